// The table of the boat's state: what is, what is ordered, and how far apart they are.
import { bearing, clock, html, one, sided, write } from "../draw.js";
import { signed } from "../charts/chart.js";
import { difference } from "../model/motion.js";
import { PLACES } from "./moment.js";
import { paced } from "./desk.js";

/**
 * @typedef {import("./desk.js").Desk} Desk
 * @typedef {object} Row
 * @property {string} name
 * @property {keyof typeof PLACES} of
 * @property {(value: number) => string} says
 * @property {(value: number) => string} [orders] how an order is written, else as it says
 * @property {number} [band] apart by more, it is marked
 * @property {[string, string]} [sides] of what is apart
 * @property {boolean} [turns]
 * @property {(moment: Desk["moment"]) => string} [also] what is told beside it, "" where it rests
 * @property {[string, string]} [gauge] its reading, and how casualties of that gauge begin
 */

const DIGITS = 500; // [ms] between changes of digits
const planes = (/** @type {number} */ value) => sided(value, "dive", "rise");
const short = (/** @type {number} */ value) => String(Number(value.toFixed(1)));
const rudder = (/** @type {number} */ value) => sided(value, "L", "R");

/** @type {Row[]} */
const ROWS = [
  {
    ...{ name: "Depth, m", of: "depth", says: (value) => value.toFixed(1), band: 5, orders: short },
    ...{ sides: ["shallow", "deep"], gauge: ["gauges.depth", "depth-gauge"] },
  },
  {
    ...{ name: "Heading", of: "heading", says: bearing, band: 5, sides: ["left", "right"] },
    ...{ turns: true, gauge: ["gauges.heading", "gyro"] },
  },
  {
    ...{ name: "Speed, kn", of: "speed", says: (value) => signed(value, 1), orders: short },
    ...{ sides: ["slow", "fast"], gauge: ["gauges.speed", "log"] },
  },
  { name: "Pitch", of: "pitch", says: (value) => sided(value, "down", "up"), sides: ["down", "up"] },
  { name: "Heel", of: "heel", says: (value) => sided(value, "port", "stbd") },
  { name: "Under the keel, m", of: "clearance", says: (value) => value.toFixed(1) },
  { name: "Sinks, m/s", of: "sinks", says: (value) => signed(value, 2) },
  { name: "Rudder", of: "rudder", says: rudder, band: 3, sides: ["L", "R"] },
  { name: "Stern planes", of: "stern", says: planes, band: 3, sides: ["dive", "rise"] },
  { name: "Bow planes", of: "bow", says: planes, band: 3, sides: ["dive", "rise"] },
  { name: "Turns, rpm", of: "turns", says: (value) => signed(value, 0) },
  { name: "Periscope, m", of: "mast", says: (value) => `${value.toFixed(1)} out`, also: shows },
];

/** Returns how high the periscope's head is, and how long it has shown. @param {Desk["moment"]} moment */
function shows(moment) {
  const [eye, mast, exposed] = ["eye", "mast", "exposed"].map((name) => moment.number(`lookout.${name}`));
  const head = mast && eye !== null ? `head ${signed(eye, 1)}, ` : "";
  return exposed || mast ? `${head}shown ${(exposed ?? 0).toFixed(0)} s` : "";
}

/** Fills the table, and keeps it filled. @param {Desk} desk */
export function showState(desk) {
  const { session, moment } = desk;
  const rows = ROWS.map((row) => {
    const cells = [html("td"), html("td", { class: "ordered" }), html("td")];
    cells[1].hidden = Boolean(row.also); // nothing is ordered there: the words have both columns
    if (row.also) cells[2].setAttribute("colspan", "2");
    const line = html("tr", { "data-of": row.of }, html("th", { scope: "row" }, row.name), ...cells);
    return { row, line, cells };
  });
  one("#truth tbody").append(...rows.map(({ line }) => line));
  const fill = () => {
    const { looking, unseen } = moment;
    document.body.toggleAttribute("data-back", looking !== null);
    const of = looking?.branch ? ` on branch ${looking.branch}` : "";
    const was = `as it was at ${clock(moment.seconds)}${of}`;
    write(one("#when"), unseen ? "not seen by this page" : looking ? was : "truth");
    for (const each of rows) fillRow(desk, each);
  };
  session.on("tick", paced(DIGITS, fill));
  moment.addEventListener("look", fill);
}

/** @param {Desk} desk @param {{ row: Row, line: HTMLElement, cells: HTMLElement[] }} filled */
function fillRow({ moment, session }, { row, line, cells }) {
  const [place, ...orders] = PLACES[row.of];
  const [is, told] = [moment.number(place), moment.first(...orders)];
  const also = row.also?.(moment) ?? "";
  const rests = Boolean(row.also) && !also;
  line.hidden = (is === null || rests) && !moment.looking && session.tickAt > 0;
  const apart = is === null || told === null ? null : difference(is, told, row.turns);
  write(cells[0], is === null ? "" : row.says(is));
  write(cells[1], told === null ? "" : (row.orders ?? row.says)(told));
  const off = apart !== null && Math.abs(apart) > (row.band ?? Infinity);
  const lies = gaugeLies(session, row) && !moment.looking;
  line.toggleAttribute("data-off", off);
  line.toggleAttribute("data-lies", lies);
  const says = apart === null || !row.sides ? "" : sided(apart, ...row.sides);
  const shown = row.gauge ? session.number(row.gauge[0]) : null;
  write(cells[2], lies && shown !== null ? `GAUGE \u25cb ${row.says(shown)}` : says === "0.0" ? "" : says || also);
}

/** Whether the crew's gauge of this is broken. @param {Desk["session"]} session @param {Row} row */
function gaugeLies(session, { gauge }) {
  const broken = session.readings.latest.get("casualties")?.values ?? {};
  return Boolean(gauge) && Object.values(broken).some((kind) => kind.startsWith(`${gauge?.[1]}-`));
}

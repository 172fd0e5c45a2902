// The table of the boat's state: what is, what is ordered, and how far apart they are.
import { bellOf } from "../controls/bells.js";
import { bearing, clock, html, one, sided, tenths, write } from "../draw.js";
import { signed } from "../charts/chart.js";
import { difference } from "../model/motion.js";
import { PLACES } from "./moment.js";
import { paced } from "./desk.js";
import { feet, inUnit, lengthDigits, unit } from "../units.js";
import { say } from "../words.js";

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
 * @property {string} [axis] by which the crew is ordered this
 * @property {(moment: Desk["moment"]) => string} [beside] what stands beside the order
 * @property {(moment: Desk["moment"]) => string} [also] what is told beside it, "" where it rests
 * @property {[string, string]} [gauge] its reading, and how casualties of that gauge begin
 */

const DIGITS = 500; // [ms] between changes of digits
const planes = (/** @type {number} */ value) => sided(value, say("dive"), say("rise"));
const shortDepth = (/** @type {number} */ value) => (feet ? lengthDigits(value) : tenths(value));
const rudder = (/** @type {number} */ value) => sided(value, say("L"), say("R"));

/** @type {Row[]} */
const ROWS = [
  {
    ...{ name: say("Depth, {0}", unit), of: "depth", says: (value) => lengthDigits(value), band: 5, orders: shortDepth },
    ...{ sides: [say("shallow"), say("deep")], gauge: ["gauges.depth", "depth-gauge"], axis: "depth" },
  },
  {
    ...{ name: say("Heading"), of: "heading", says: bearing, band: 5, sides: [say("left"), say("right")] },
    ...{ turns: true, gauge: ["gauges.heading", "gyro"], axis: "course" },
  },
  {
    ...{ name: say("Speed, kn"), of: "speed", says: (value) => signed(value, 1), orders: tenths },
    ...{ sides: [say("slow"), say("fast")], gauge: ["gauges.speed", "log"], axis: "speed" },
  },
  {
    ...{ name: say("Pitch"), of: "pitch", says: (value) => sided(value, say("down"), say("up")), axis: "pitch" },
    ...{ sides: [say("down"), say("up")] },
  },
  { name: say("Heel"), of: "heel", says: (value) => sided(value, say("port"), say("stbd")) },
  { name: say("Under the keel, {0}", unit), of: "clearance", says: (value) => lengthDigits(value) },
  { name: say("Sinks, m/s"), of: "sinks", says: (value) => signed(value, 2) },
  { name: say("Rudder"), of: "rudder", says: rudder, band: 3, sides: [say("L"), say("R")] },
  { name: say("Stern planes"), of: "stern", says: planes, band: 3, sides: [say("dive"), say("rise")] },
  { name: say("Bow planes"), of: "bow", says: planes, band: 3, sides: [say("dive"), say("rise")] },
  { name: say("Turns, rpm"), of: "turns", says: (value) => signed(value, 0), beside: bell },
  { name: say("Periscope, {0}", unit), of: "mast", says: (value) => say("{0} out", lengthDigits(value)), also: shows },
];

/** Returns the bell that the engine is ordered. @param {Desk["moment"]} moment */
function bell(moment) {
  return bellOf(moment.word("engine.bell").replace("-", " "));
}

/** Returns how high the periscope's head is, and how long it has shown. @param {Desk["moment"]} moment */
function shows(moment) {
  const [eye, mast, exposed] = ["eye", "mast", "exposed"].map((name) => moment.number(`lookout.${name}`));
  const head = mast && eye !== null ? say("head {0}, ", signed(inUnit(eye), 1)) : "";
  return exposed || mast ? say("{0}shown {1} s", head, (exposed ?? 0).toFixed(0)) : "";
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
    const at = clock(moment.seconds);
    const was = looking?.branch ? say("as it was at {0} on branch {1}", at, looking.branch) : say("as it was at {0}", at);
    write(one("#when"), unseen ? say("not seen by this page") : looking ? was : say("truth"));
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
  const waits = !moment.looking && session.crew.waiting.has(row.axis ?? "");
  cells[1].toggleAttribute("data-waits", waits);
  cells[1].title = waits ? say("not repeated yet") : "";
  const off = apart !== null && Math.abs(apart) > (row.band ?? Infinity);
  const lies = gaugeLies(moment, row);
  line.toggleAttribute("data-off", off);
  line.toggleAttribute("data-lies", lies);
  const far = apart === null || row.of !== "depth" ? apart : inUnit(apart);
  const says = far === null || !row.sides ? "" : sided(far, ...row.sides);
  const shown = row.gauge ? moment.number(row.gauge[0]) : null;
  write(cells[2], lies && shown !== null ? say("GAUGE {0}", `\u25cb ${row.says(shown)}`) : says === "0.0" ? "" : says || also || (row.beside?.(moment) ?? ""));
}

/** Whether the crew's gauge of this is broken. @param {Desk["moment"]} moment @param {Row} row */
function gaugeLies(moment, { gauge }) {
  const broken = moment.row("casualties") ?? {};
  return Boolean(gauge) && Object.values(broken).some((kind) => String(kind).startsWith(`${gauge?.[1]}-`));
}

// Charts, track, attitude and tanks, fed from the readings: of now, or of the moment looked at.
import { aidsOf, measured, points, scaleOf } from "../charts/plots.js";
import { before, rowAt } from "../model/history.js";
import { limitsOf } from "../model/limits.js";
import { html, one } from "../draw.js";
import { PLACES } from "./moment.js";
import { paced } from "./desk.js";
import { TITLES } from "../tanks/places.js";
import { shipsOf } from "./ships.js";
import { inUnit, lengthDigits, unit } from "../units.js";
import { decimals, say } from "../words.js";

/**
 * @typedef {import("./desk.js").Desk} Desk
 * @typedef {import("../charts/strip-chart.js").StripChart} StripChart
 * @typedef {import("../charts/track-chart.js").TrackChart} TrackChart
 * @typedef {import("../model/motion.js").Motion} Motion
 * Elements of other parts, which show what they are given.
 * @typedef {HTMLElement & { show?: (...what: any[]) => void }} Picture
 */

const DRAWN = 250; // [ms] between drawings of the charts
const PLACES_MOST = 1200; // of the track
/** @type {ReturnType<typeof aidsOf>} */
const NO_AIDS = { ghost: [], ahead: [] }; // of a moment that is looked at
const RECENT = 600; // [s] of the track that are drawn full
export const SPANS = [1, 3, 10, 60]; // [min]

/** Shows the charts; returns what sets their span. @param {Desk} desk */
export function showCharts(desk) {
  const { session, moment } = desk;
  const charts = /** @type {StripChart[]} */ ([...document.querySelectorAll("strip-chart")]);
  let span = 3;
  const draw = paced(DRAWN, () => {
    const shaded = broken(desk, span * 60);
    for (const chart of charts) drawChart(desk, chart, span * 60, shaded);
    drawTrack(desk);
  });
  for (const what of ["tick", "line", "exercise"]) session.on(what, draw);
  moment.addEventListener("look", draw);
  const keys = SPANS.map((minutes) => {
    const attributes = { type: "button", "aria-pressed": String(minutes === span) };
    return html("button", { ...attributes, click: () => choose(minutes) }, say("{0} min", minutes));
  });
  one("#spans").append(...keys);
  const choose = (/** @type {number} */ minutes) => {
    span = minutes;
    keys.forEach((key, at) => key.setAttribute("aria-pressed", String(SPANS[at] === minutes)));
    draw();
  };
  return (/** @type {number} */ by) => {
    const at = Math.min(Math.max(SPANS.indexOf(span) + by, 0), SPANS.length - 1);
    choose(SPANS[at]);
  };
}

/** @param {Desk} desk @param {StripChart} chart @param {number} span @param {[number, number][]} shaded */
function drawChart(desk, chart, span, shaded) {
  const of = /** @type {keyof typeof PLACES} */ (chart.dataset.of);
  const [place, ...orders] = PLACES[of];
  const { session, moment } = desk;
  const past = session.history.of(place.split(".")[0]);
  const known = session.number(place) !== null || past.times.length === 0;
  chart.hidden = !known;
  if (!known) return;
  const now = Math.max(moment.seconds, 0);
  const pastOf = (/** @type {string} */ channel) => moment.past(channel);
  const [actual, ordered] = [[place], orders].map((places) => measured(of, points(pastOf, places, now - span)));
  const deepest = of === "depth" ? limitsOf(session).depth : null;
  const limit = deepest === null ? null : inUnit(deepest);
  const { ghost, ahead } = moment.looking ? NO_AIDS : aidsOf(session, pastOf, of, now, span);
  const scale = scaleOf(of, session.ranges, [...actual, ...ordered, ...ghost, ...ahead], limit);
  chart.show({ actual, ordered, ghost, ahead, now, span, ...scale, shaded, limit });
}

/** Returns when anything was broken [s], within a span before the moment. @param {Desk} desk @param {number} span */
function broken({ moment }, span) {
  const { times, rows } = moment.past("casualties");
  /** @type {[number, number][]} */
  const found = [];
  for (let at = before(times, moment.seconds - span); at < times.length; at += 1) {
    if (Object.keys(rows[at]).length === 0) continue;
    const last = found.at(-1);
    const follows = last && at > 0 && last[1] >= times[at - 1];
    if (follows) last[1] = times[at];
    else found.push([times[at], times[at]]);
  }
  return found;
}

/** @param {Desk} desk */
function drawTrack({ moment }) {
  const chart = /** @type {TrackChart} */ (one("track-chart"));
  const { times, rows } = moment.past("motion");
  const until = times.length;
  const every = Math.max(Math.ceil(until / PLACES_MOST), 1);
  /** @type {import("../charts/track-chart.js").Place[]} */
  const places = [];
  let recent = 0;
  for (let at = 0; at < until; at += 1) {
    if (at % every && at !== until - 1) continue;
    places.push([rows[at].north, rows[at].east]);
    if (times[at] >= moment.seconds - RECENT) recent += 1;
  }
  const ordered = moment.first(...PLACES.heading.slice(1));
  chart.show(places, moment.number("motion.heading"), { ordered, recent, ships: shipsOf(moment) });
}

/** The pointers of the attitude, which move between ticks. */
export const POINTERS = {
  depth: { place: "motion.depth", rate: "motion.depth_rate" },
  pitch: { place: "motion.pitch", rate: "motion.pitch_rate" },
  heel: { place: "motion.heel", rate: "motion.heel_rate" },
  stern: { place: "diving.stern" },
  bow: { place: "diving.bow" },
  rudder: { place: "steering.rudder" },
};

/** Shows the boat from the side and from astern. @param {Desk} desk @param {Motion} motion */
export function showAttitude({ session, moment }, motion) {
  const side = /** @type {Picture & { still?: boolean }} */ (one("boat-side"));
  const stern = /** @type {Picture} */ (one("boat-stern"));
  const value = (/** @type {keyof typeof POINTERS} */ name) =>
    moment.looking ? moment.number(POINTERS[name].place) : (motion.shown[name] ?? null);
  const draw = () => {
    const [depth, pitch, bow] = [value("depth"), value("pitch"), value("bow")];
    const ordered = moment.first(...PLACES.depth.slice(1));
    const limit = limitsOf(session).depth;
    const speed = moment.number("motion.speed");
    const surface = moment.number("sea.elevation");
    const clearance = moment.number("motion.clearance");
    side.still = session.state === "frozen";
    side.show?.({ depth, pitch, speed, stern: value("stern"), bow, ordered, limit, surface, clearance });
    stern.show?.({ heel: value("heel"), rudder: value("rudder") });
  };
  motion.addEventListener("frame", draw);
  moment.addEventListener("look", draw);
}

const MAIN = ["forward", "mid", "aft"];

/** Shows tanks and air, and the orders for the tank that is chosen. @param {Desk} desk */
export function showTanks(desk) {
  const { session, moment } = desk;
  const mimic = /** @type {Picture} */ (one("tank-mimic"));
  const of = (/** @type {string} */ channel) => moment.row(channel) ?? {};
  const draw = paced(DRAWN * 2, () =>
    mimic.show?.({ tanks: of("tanks"), air: of("air"), valves: of("valves"), still: moment.looking !== null }),
  );
  session.on("tick", draw);
  moment.addEventListener("look", draw);
  mimic.addEventListener("choose", (event) => {
    const tank = String(/** @type {CustomEvent} */ (event).detail);
    const orders = tankOrders(tank);
    const keys = orders.map(([words, order]) =>
      html("button", { type: "button", click: () => void desk.give(order) }, words),
    );
    one("#tank-orders").replaceChildren(...keys);
    one("#tank-orders").hidden = orders.length === 0;
    one("#tank-chosen").textContent = TITLES[tank]?.[0] ?? tank;
  });
}

/** Returns what may be ordered of a tank: words of a key, and its order. @param {string} tank @returns {[string, string][]} */
function tankOrders(tank) {
  const name = tank.replaceAll("_", "-");
  if (MAIN.includes(name)) {
    return [
      [say("blow"), `blow ${name}`],
      [say("blow stop"), "blow stop"],
      [say("vent open"), `vent ${name} open`],
      [say("vent shut"), `vent ${name} shut`],
    ];
  }
  if (name === "negative") return [[say("flood"), "negative flood"], [say("blow"), "negative blow"]];
  if (name.startsWith("trim")) {
    return [[say("2 t forward"), "pump trim forward 2"], [say("2 t aft"), "pump trim aft 2"]];
  }
  if (name === "auxiliary" || name === "depth-control") {
    return [[say("flood 2 t"), `flood ${name} 2`], [say("pump 2 t"), `pump ${name} 2`]];
  }
  return [];
}

/** @type {Record<string, string>} */
const NAMES = {
  depth: say("Depth, {0}", unit),
  pitch: say("Pitch"),
  speed: say("Speed, kn"),
  stern: say("Stern planes"),
  bow: say("Bow planes"),
  rudder: say("Rudder"),
};
const ROWS = 12; // of the table of values
const EVERY = 10; // [s]

/** Returns what the charts show, as a table. @param {Desk} desk */
export function valuesTable({ moment }) {
  const names = /** @type {(keyof typeof PLACES)[]} */ (["depth", "pitch", "speed", "stern", "bow", "rudder"]);
  const head = html("tr", {}, ...[say("time, s"), ...names.map((name) => NAMES[name])].map((name) => html("th", { scope: "col" }, name)));
  const now = Math.floor(moment.seconds / EVERY) * EVERY;
  const rows = [];
  for (let at = now; at >= 0 && rows.length < ROWS; at -= EVERY) {
    const cells = names.map((name) => {
      const [channel, field] = PLACES[name][0].split(".");
      const value = rowAt(moment.past(channel), at)?.[field];
      return html("td", {}, value === undefined ? "" : name === "depth" ? lengthDigits(value) : decimals(value, 1));
    });
    rows.push(html("tr", {}, html("th", { scope: "row" }, String(at)), ...cells));
  }
  return html("table", {}, html("thead", {}, head), html("tbody", {}, ...rows));
}

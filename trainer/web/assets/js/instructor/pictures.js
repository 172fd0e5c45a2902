// Charts, track, attitude and tanks, fed from the readings: of now, or of the moment looked at.
import { before } from "../model/history.js";
import { html, one } from "../draw.js";
import { PLACES } from "./moment.js";
import { paced } from "./desk.js";
import { shipsOf, shipsThen } from "./ships.js";

/**
 * @typedef {import("./desk.js").Desk} Desk
 * @typedef {import("../charts/strip-chart.js").StripChart} StripChart
 * @typedef {import("../charts/strip-chart.js").Points} Points
 * @typedef {import("../charts/track-chart.js").TrackChart} TrackChart
 * @typedef {import("../model/motion.js").Motion} Motion
 * @typedef {{ low: number, high: number, step: number }} Scale
 * Elements of other parts, which show what they are given.
 * @typedef {HTMLElement & { show?: (...what: any[]) => void }} Picture
 */

const DRAWN = 250; // [ms] between drawings of the charts
const MOST = 500; // points of a line, more than a chart has pixels for
const PLACES_MOST = 1200; // of the track
const RECENT = 600; // [s] of the track that are drawn full
export const SPANS = [1, 3, 10, 60]; // [min]
const STEPS = [1, 2, 5, 10, 20, 50, 100, 200]; // of a chart's grid
const LINES = 4; // of the grid at least

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
    return html("button", { ...attributes, click: () => choose(minutes) }, `${minutes} min`);
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
  const now = Math.max(session.seconds, 0);
  const actual = points(session, [place], now - span);
  const ordered = points(session, orders, now - span);
  const limit = of === "depth" ? limitOf(session, "depth_m_max") : null;
  const cursor = moment.looking && moment.looking.branch === null ? moment.looking.seconds : null;
  const scale = scaleOf(of, session.ranges, [...actual, ...ordered], limit);
  chart.show({ actual, ordered, now, span, ...scale, shaded, limit, cursor });
}

/**
 * Returns what the first of some places has told since a time, at most MOST points.
 * @param {Desk["session"]} session
 * @param {string[]} places
 * @param {number} since [s]
 * @returns {Points}
 */
function points(session, places, since) {
  const fields = places.map((place) => place.split("."));
  const times = fields.length ? session.history.of(fields[0][0]).times : [];
  const first = Math.max(before(times, since) - 1, 0);
  const every = Math.max(Math.ceil((times.length - first) / MOST), 1);
  /** @type {Points} */
  const found = [];
  for (let at = first; at < times.length; at += 1) {
    if (at % every && at !== times.length - 1) continue;
    found.push([times[at], valueAt(session, fields, times[at], at)]);
  }
  return found;
}

/** @param {Desk["session"]} session @param {string[][]} fields @param {number} seconds @param {number} index */
function valueAt(session, fields, seconds, index) {
  for (const [channel, field] of fields) {
    const { times, rows } = session.history.of(channel);
    const same = Math.abs((times[index] ?? NaN) - seconds) < 1e-6;
    const row = same ? rows[index] : rows[before(times, seconds + 1e-6) - 1];
    const value = row?.[field];
    if (value !== undefined) return value;
  }
  return null;
}

/** Returns a limit of the exercise, null where there is none. @param {Desk["session"]} session @param {string} name */
export function limitOf(session, name) {
  const found = (session.exercise.limits ?? "").split(",").find((each) => each.startsWith(`${name}:`));
  return found ? Number(found.split(":")[1]) : null;
}

/**
 * Returns the scale of a chart: of the vessel's ranges, or wide enough for what is on it.
 * @param {string} of
 * @param {Record<string, number>} ranges
 * @param {Points} drawn
 * @param {number | null} limit
 * @returns {Scale}
 */
function scaleOf(of, ranges, drawn, limit) {
  const reach = ranges[of];
  if (reach && of !== "depth" && of !== "speed") return round(-reach, reach);
  if (of === "speed" && ranges.speed) return round(-(ranges.astern ?? 0), ranges.speed);
  const values = drawn.flatMap(([, value]) => (value === null ? [] : [value]));
  if (of === "pitch") return round(Math.min(-10, ...values), Math.max(10, ...values));
  const [least, most] = [Math.min(...values), Math.max(...values)];
  if (!Number.isFinite(least)) return round(0, 100);
  const shown = limit !== null && limit < most + 40 ? limit : most;
  const [low, high] = [Math.max(least - 10, 0), Math.max(most, shown) + 10];
  return round(low, Math.max(high, low + 40));
}

/** Returns a scale with a whole number of steps. @param {number} low @param {number} high @returns {Scale} */
function round(low, high) {
  const step = STEPS.find((each) => (high - low) / each <= 2 * LINES - 1) ?? STEPS[STEPS.length - 1];
  return { step, low: Math.floor(low / step) * step, high: Math.ceil(high / step) * step };
}

/** Returns when anything was broken [s], within a span before now. @param {Desk} desk @param {number} span */
function broken({ session }, span) {
  const { times, rows } = session.history.of("casualties");
  /** @type {[number, number][]} */
  const found = [];
  for (let at = before(times, session.seconds - span); at < times.length; at += 1) {
    if (Object.keys(rows[at]).length === 0) continue;
    const last = found.at(-1);
    const follows = last && at > 0 && last[1] >= times[at - 1];
    if (follows) last[1] = times[at];
    else found.push([times[at], times[at]]);
  }
  return found;
}

/** @param {Desk} desk */
function drawTrack({ session, moment }) {
  const chart = /** @type {TrackChart} */ (one("track-chart"));
  const { times, rows } = session.history.of("motion");
  const until = moment.looking?.branch === null ? before(times, moment.seconds + 1e-6) : times.length;
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
  const ships = moment.looking ? shipsThen(moment.row("contacts")) : shipsOf(session);
  chart.show(places, moment.number("motion.heading"), { ordered, recent, ships });
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
  const side = /** @type {Picture} */ (one("boat-side"));
  const stern = /** @type {Picture} */ (one("boat-stern"));
  const value = (/** @type {keyof typeof POINTERS} */ name) =>
    moment.looking ? moment.number(POINTERS[name].place) : (motion.shown[name] ?? null);
  const draw = () => {
    const [depth, pitch, bow] = [value("depth"), value("pitch"), value("bow")];
    const ordered = moment.first(...PLACES.depth.slice(1));
    const limit = limitOf(session, "depth_m_max");
    const speed = moment.number("motion.speed");
    const surface = moment.number("sea.elevation");
    const clearance = moment.number("motion.clearance");
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
  const of = (/** @type {string} */ channel) =>
    moment.row(channel) ?? session.readings.latest.get(channel)?.values ?? {};
  const draw = paced(DRAWN * 2, () =>
    mimic.show?.({ tanks: of("tanks"), air: of("air"), valves: of("valves") }),
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
    one("#tank-chosen").textContent = tank.replaceAll("_", " ");
  });
}

/** Returns what may be ordered of a tank: words of a key, and its order. @param {string} tank @returns {[string, string][]} */
function tankOrders(tank) {
  const name = tank.replaceAll("_", "-");
  if (MAIN.includes(name)) {
    return [
      ["blow", `blow ${name}`],
      ["blow stop", "blow stop"],
      ["vent open", `vent ${name} open`],
      ["vent shut", `vent ${name} shut`],
    ];
  }
  if (name === "negative") return [["flood", "negative flood"], ["blow", "negative blow"]];
  if (name.startsWith("trim")) {
    return [["2 t forward", "pump trim forward 2"], ["2 t aft", "pump trim aft 2"]];
  }
  if (name === "auxiliary" || name === "depth-control") {
    return [["flood 2 t", `flood ${name} 2`], ["pump 2 t", `pump ${name} 2`]];
  }
  return [];
}

const ROWS = 12; // of the table of values
const EVERY = 10; // [s]

/** Returns what the charts show, as a table. @param {Desk} desk */
export function valuesTable({ session }) {
  const names = /** @type {(keyof typeof PLACES)[]} */ (["depth", "pitch", "speed", "stern", "bow", "rudder"]);
  const head = html("tr", {}, ...["time, s", ...names].map((name) => html("th", { scope: "col" }, name)));
  const now = Math.floor(session.seconds / EVERY) * EVERY;
  const rows = [];
  for (let at = now; at >= 0 && rows.length < ROWS; at -= EVERY) {
    const cells = names.map((name) => {
      const [channel, field] = PLACES[name][0].split(".");
      const value = session.history.at(channel, at)?.[field];
      return html("td", {}, value === undefined ? "" : value.toFixed(1));
    });
    rows.push(html("tr", {}, html("th", { scope: "row" }, String(at)), ...cells));
  }
  return html("table", {}, html("thead", {}, head), html("tbody", {}, ...rows));
}

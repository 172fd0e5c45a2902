// What strip charts draw of a session: lines of what was and what was ordered, and their scales.
import { before } from "../model/history.js";
import { inUnit } from "../units.js";

/**
 * @typedef {import("../model/session.js").Session} Session
 * @typedef {import("../model/history.js").Past} Past
 * @typedef {import("./strip-chart.js").Points} Points
 * @typedef {{ low: number, high: number, step: number }} Scale
 */

const MOST = 500; // points of a line, more than a chart has pixels for
const STEPS = [1, 2, 5, 10, 20, 50, 100, 200]; // of a chart's grid
const WAY = ["depth", "heading", "pitch"]; // of a point ahead, after its seconds
const LINES = 4; // of the grid at least

/**
 * Draws the strip charts of a page from what the crew's gauges show, up to the present.
 * @param {Session} session
 * @param {Record<string, string[]>} places of what is and what is ordered, by the charts' `data-of`
 * @param {number} span [s]
 * @param {number | null} deepest [m] that the exercise allows
 */
export function drawPlots(session, places, span, deepest) {
  const now = Math.max(session.seconds, 0);
  const past = (/** @type {string} */ channel) => session.history.of(channel);
  for (const chart of document.querySelectorAll("strip-chart")) {
    const { of = "" } = /** @type {HTMLElement} */ (chart).dataset;
    const [place, ...orders] = places[of];
    const [actual, ordered] = [[place], orders].map((each) => measured(of, points(past, each, now - span)));
    const there = session.number(place) !== null;
    chart.toggleAttribute("hidden", !there);
    const limit = of === "depth" && deepest !== null ? inUnit(deepest) : null;
    const aids = aidsOf(session, past, of, now, span);
    const scale = scaleOf(of, session.ranges, [...actual, ...ordered, ...aids.ghost, ...aids.ahead], limit);
    const strip = /** @type {import("./strip-chart.js").StripChart} */ (chart);
    if (there) strip.show({ actual, ordered, ...aids, now, span, ...scale, shaded: [], limit });
  }
}

/**
 * Returns the reference crew's run, and where the boat goes with the controls as they stand.
 * @param {Session} session
 * @param {(channel: string) => Past} pastOf
 * @param {string} of
 * @param {number} now [s]
 * @param {number} span [s]
 * @returns {{ ghost: Points, ahead: Points }}
 */
export function aidsOf(session, pastOf, of, now, span) {
  const ghost = session.number(`ghost.${of}`) === null ? [] : points(pastOf, [`ghost.${of}`], now - span);
  const place = WAY.indexOf(of);
  const way = place < 0 ? "" : session.word("predictor.way");
  const told = way.split(";").filter(Boolean).map((point) => point.split(":").map(Number));
  const ahead = /** @type {Points} */ (told.map((point) => [now + point[0], point[place + 1]]));
  return { ghost: measured(of, ghost), ahead: measured(of, ahead) };
}

/** Returns points in the unit that is shown: depths may be in feet. @param {string} of @param {Points} told @returns {Points} */
export function measured(of, told) {
  if (of !== "depth") return told;
  return told.map(([at, value]) => [at, value === null ? null : inUnit(value)]);
}

/**
 * Returns what the first of some places has told since a time, at most MOST points.
 * @param {(channel: string) => Past} pastOf what a channel has shown
 * @param {string[]} places
 * @param {number} since [s]
 * @returns {Points}
 */
export function points(pastOf, places, since) {
  const fields = places
    .map((place) => place.split("."))
    .map(([channel, field]) => ({ past: pastOf(channel), field }));
  const times = fields[0]?.past.times ?? [];
  const first = Math.max(before(times, since) - 1, 0);
  const every = Math.max(Math.ceil((times.length - first) / MOST), 1);
  /** @type {Points} */
  const found = [];
  for (let at = first; at < times.length; at += 1) {
    if (at % every && at !== times.length - 1) continue;
    found.push([times[at], valueAt(fields, times[at], at)]);
  }
  return found;
}

/** @param {{ past: Past, field: string }[]} fields @param {number} seconds @param {number} index */
function valueAt(fields, seconds, index) {
  for (const { past, field } of fields) {
    const { times, rows } = past;
    const same = Math.abs((times[index] ?? NaN) - seconds) < 1e-6;
    const row = same ? rows[index] : rows[before(times, seconds + 1e-6) - 1];
    const value = row?.[field];
    if (typeof value === "number") return value;
  }
  return null;
}

/**
 * Returns the scale of a chart: of the vessel's ranges, or wide enough for what is on it.
 * @param {string} of
 * @param {Record<string, number>} ranges
 * @param {Points} drawn
 * @param {number | null} limit
 * @returns {Scale}
 */
export function scaleOf(of, ranges, drawn, limit) {
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

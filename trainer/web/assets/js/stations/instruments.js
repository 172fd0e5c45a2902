// The instruments of the stations that steer, order and watch.
import "../gauges/angle-dial.js";
import "../gauges/course-ring.js";
import "../gauges/depth-gauge.js";
import "../gauges/pitch-gauge.js";
import { limitsOf } from "../model/limits.js";
import { Motion } from "../model/motion.js";

const TURNS = 7.1; // [deg/s] the fastest that surfaces and the boat itself turn

/**
 * @typedef {import("../model/session.js").Session} Session
 * @typedef {HTMLElement & { show(...values: (number | null)[]): void,
 *   ghost?: (value: number | null) => void }} Gauge
 * @typedef {HTMLElement & {
 *   limit(greatest: number | null, periscope: number | null): void }} DepthGauge
 * @typedef {HTMLElement & { limit: number }} AngleDial
 */

/**
 * What each instrument shows: its place, where its order stands (the crew's before the
 * autopilot's), and the fastest that it moves in a second. The ghost's has the last name of its place.
 * @type {Record<string, [string, string[], number]>}
 */
const GAUGES = {
  "depth-gauge": ["gauges.depth", ["orders.depth", "diving.ordered_depth"], 6],
  "pitch-gauge": ["gauges.pitch", ["orders.pitch"], TURNS],
  "course-ring": ["gauges.heading", ["orders.course", "steering.ordered_course"], TURNS],
  "#heel": ["gauges.heel", [], TURNS],
  "#stern": ["diving.stern", ["diving.ordered_stern"], TURNS],
  "#bow": ["diving.bow", ["diving.ordered_bow"], TURNS],
  "#rudder": ["steering.rudder", ["steering.ordered_rudder"], TURNS],
  "#speed": ["gauges.speed", ["orders.speed", "engine.ordered_speed"], 1],
  "#rpm": ["engine.rpm", ["engine.ordered_rpm"], 20],
};

/**
 * Moves the instruments that this page has; returns what moves them, by their selectors.
 * @param {Session} session
 * @param {(place: string, stands: number | null) => number | null} [wanted] what an order is to
 *   be, where the page knows more than the readings
 */
export function showInstruments(session, wanted = (_, stands) => stands) {
  const gauges = Object.entries(GAUGES).flatMap(([selector, [place, orders, most]]) => {
    const gauge = /** @type {Gauge | null} */ (document.querySelector(selector));
    return gauge ? [{ gauge, selector, place, orders, most }] : [];
  });
  const pointers = Object.fromEntries(
    gauges.map(({ selector, place, most }) => [
      selector,
      { place, turns: place === "gauges.heading", most },
    ]),
  );
  const motion = new Motion(session, pointers);
  const ordered = (/** @type {string[]} */ orders) =>
    orders.map((place) => wanted(place, session.number(place))).find((to) => to !== null) ?? null;
  motion.addEventListener("frame", () => {
    for (const { gauge, selector, place, orders } of gauges) {
      const rate = selector === "course-ring" ? [session.number("steering.turn_rate")] : [];
      gauge.show(motion.shown[selector] ?? null, ordered(orders), ...rate);
      gauge.ghost?.(session.number(`ghost.${place.split(".")[1]}`));
    }
  });
  session.on("ranges", () => fit(session));
  for (const what of ["exercise", "ranges"]) session.on(what, () => showLimits(session));
  motion.start();
  return motion;
}

/** Draws the limits of the exercise on the instruments. @param {Session} session */
function showLimits(session) {
  const limits = limitsOf(session);
  /** @type {[string, number | null][]} */
  const drawn = [["depth-gauge", limits.depth], ["pitch-gauge", limits.pitch]];
  for (const [selector, limit] of drawn) {
    const gauge = /** @type {any} */ (document.querySelector(selector));
    gauge?.allow(limit);
  }
}

/** Gives dials and gauges the ranges of the vessel. @param {Session} session */
function fit({ ranges }) {
  for (const name of ["rudder", "stern", "bow"]) {
    const dial = /** @type {AngleDial | null} */ (document.querySelector(`#${name}`));
    if (dial && ranges[name]) dial.limit = ranges[name];
  }
  const depth = /** @type {DepthGauge} */ (document.querySelector("depth-gauge"));
  depth.limit(ranges.depth ?? null, ranges.periscope ?? null);
  document.querySelector("[data-legend=periscope]")?.toggleAttribute("hidden", !ranges.periscope);
}

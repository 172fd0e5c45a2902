// The instruments that diving officer and observer look at.
import "../gauges/angle-dial.js";
import "../gauges/course-ring.js";
import "../gauges/depth-gauge.js";
import "../gauges/pitch-gauge.js";
import { Motion } from "../model/motion.js";

const STEEPENS = 7.1; // [deg/s] the fastest that pitch changes

/**
 * @typedef {import("../model/session.js").Session} Session
 * @typedef {HTMLElement & { show(...values: (number | null)[]): void }} Gauge
 * @typedef {HTMLElement & {
 *   limit(greatest: number | null, periscope: number | null): void }} DepthGauge
 * @typedef {HTMLElement & { limit: number }} AngleDial
 */

/** What each instrument shows: its place, and that of what is ordered. */
const GAUGES = /** @type {Record<string, [string, string]>} */ ({
  "depth-gauge": ["gauges.depth", "orders.depth"],
  "pitch-gauge": ["gauges.pitch", "orders.pitch"],
  "course-ring": ["gauges.heading", "orders.course"],
  "#stern": ["diving.stern", "diving.ordered_stern"],
  "#bow": ["diving.bow", "diving.ordered_bow"],
  "#rudder": ["steering.rudder", "steering.ordered_rudder"],
  "#speed": ["engine.speed", "orders.speed"],
  "#rpm": ["engine.rpm", "engine.ordered_rpm"],
});

/** Moves the instruments that this page has. @param {Session} session */
export function showInstruments(session) {
  const gauges = Object.entries(GAUGES).flatMap(([selector, places]) => {
    const gauge = /** @type {Gauge | null} */ (document.querySelector(selector));
    return gauge ? [{ gauge, selector, place: places[0], ordered: places[1] }] : [];
  });
  const pointers = Object.fromEntries(
    gauges.map(({ selector, place }) => [
      selector,
      {
        place,
        turns: place === "gauges.heading",
        most: place === "gauges.pitch" ? STEEPENS : Infinity,
      },
    ]),
  );
  const motion = new Motion(session, pointers);
  motion.addEventListener("frame", () => {
    for (const { gauge, selector, ordered } of gauges) {
      const rate = selector === "course-ring" ? [session.number("steering.turn_rate")] : [];
      gauge.show(motion.shown[selector] ?? null, session.number(ordered), ...rate);
    }
  });
  session.on("ranges", () => fit(session));
  motion.start();
}

/** Gives dials and gauges the ranges of the vessel. @param {Session} session */
function fit({ ranges }) {
  for (const name of ["rudder", "stern", "bow"]) {
    const dial = /** @type {AngleDial | null} */ (document.querySelector(`#${name}`));
    if (dial && ranges[name]) dial.limit = ranges[name];
  }
  const depth = /** @type {DepthGauge} */ (document.querySelector("depth-gauge"));
  depth.limit(ranges.depth ?? null, ranges.periscope ?? null);
}

// What calls for the instructor's eyes beside what the session itself tells.
import { EMPTY, surfaceWatch } from "../model/alerts.js";
import { limitsOf } from "../model/limits.js";
import { shortLength } from "../units.js";
import { say } from "../words.js";

/**
 * @typedef {import("../model/session.js").Session} Session
 * @typedef {import("../model/alerts.js").Found} Found
 */

const NEAR = 15; // [m] to a limit
const USED = 92; // [%] of the air bank

/** @param {Session} session @returns {Found[]} */
function depth(session) {
  const is = session.number("motion.depth");
  const greatest = session.ranges["test-depth"] ?? Infinity;
  const limit = Math.min(limitsOf(session).depth ?? Infinity, greatest);
  if (is === null || is > limit || limit - is > NEAR) return [];
  return [{ key: "near", rank: "warning", words: say("Depth within {0} of {1}", shortLength(NEAR), shortLength(limit)) }];
}

/** @param {Session} session @returns {Found[]} */
function air(session) {
  const full = session.number("air.main_full");
  const blows = ["forward", "mid", "aft"].some((tank) => session.word(`valves.blow_${tank}`) === "open");
  if (full === null) return [];
  if (full < EMPTY) return [{ key: "empty", rank: "alarm", words: say("{0} empty", say("Main air bank")) }];
  if (full >= USED || !blows) return [];
  return [{ key: "air", rank: "caution", words: say("{0} below {1} %", say("Main air bank"), USED) }];
}

export const WATCHES = [
  depth,
  air,
  surfaceWatch(say("Stern planes off their order"), "diving.stern", "diving.ordered_stern"),
  surfaceWatch(say("Bow planes off their order"), "diving.bow", "diving.ordered_bow"),
  surfaceWatch(say("Rudder off its order"), "steering.rudder", "steering.ordered_rudder"),
];

// The levers of tanks that air empties: how they stand, and the orders that move them.

import { BLOWN } from "./places.js";

/** @typedef {Record<string, string>} Positions of the groups, such as `{ aft: "vent" }` */

/**
 * Returns how the lever of a group stands, by the words of the channel `valves`.
 * @param {Record<string, string>} valves
 * @param {string} group
 */
export function position(valves, group) {
  const [vent, blow] = [valves[`vent_${group}`], valves[`blow_${group}`]];
  if (group === "negative" && valves.negative_flood !== "open") return "shut";
  if (blow && blow !== "shut") return "blow";
  if (vent === "open") return group === "negative" ? "flood" : "vent";
  return "shut";
}

/**
 * Returns the orders that bring a lever to a position.
 *
 * `blow stop` shuts all blow valves and the negative tank: the others are opened again at once.
 * @param {string} group
 * @param {string} wanted
 * @param {Positions} stand how all levers stand
 * @returns {string[]}
 */
export function ordersTo(group, wanted, stand) {
  const negative = group === "negative";
  if (wanted === "blow") return [negative ? "negative blow" : `blow ${group}`];
  if (wanted === "flood") return ["negative flood"];
  const stops = stand[group] === "blow" || negative ? ["blow stop", ...others(group, stand)] : [];
  if (negative) return stops;
  return [...stops, `vent ${group} ${wanted === "vent" ? "open" : "shut"}`];
}

/** Returns the orders that shut all main ballast. @param {Positions} stand @returns {string[]} */
export function ordersToShut(stand) {
  const blown = BLOWN.some((group) => group !== "negative" && stand[group] === "blow");
  const negative = { flood: "negative flood", blow: "negative blow" }[stand.negative];
  return [...(blown ? ["blow stop", ...(negative ? [negative] : [])] : []), "vent all shut"];
}

/** @param {string} group @param {Positions} stand */
function others(group, stand) {
  return BLOWN.filter((each) => each !== group).flatMap((each) => {
    if (each === "negative" && stand[each] !== "shut") return [`negative ${stand[each]}`];
    return stand[each] === "blow" ? [`blow ${each}`] : [];
  });
}

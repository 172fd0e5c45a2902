// What a run turned on: what broke, the first order after it, each limit that was passed.
import { isOnWay, shared, way } from "./branches.js";
import { objectOf } from "./orders.js";

/**
 * @typedef {"casualty" | "first order" | "limit"} Kind
 * @typedef {{ seconds: number, kind: Kind, words: string }} Cause
 */

/**
 * Returns the causes on the way to the end of a branch, the earliest first.
 * @param {import("./session.js").Session} session
 * @param {number | null} [branch] null for the present one
 * @returns {Cause[]}
 */
export function causesOf({ signs, log, branches, present }, branch = null) {
  const same = branch === null ? Infinity : shared(branches, branch, present);
  const own = branch === null ? [] : signs.leftOn(way(branches, branch), same);
  const kept = [...signs.kept.filter(({ seconds }) => seconds <= same), ...own];
  /** @type {Cause[]} */
  const causes = [];
  let unanswered = false;
  for (const { seconds, sign, text } of kept.sort(bySeconds)) {
    if (sign === "C") causes.push({ seconds, kind: "casualty", words: objectOf(text) });
    if (sign === "o" && unanswered) causes.push({ seconds, kind: "first order", words: text });
    if (sign === "C" || sign === "o") unanswered = sign === "C";
  }
  for (const entry of log) {
    const { seconds, kind, text } = entry;
    if (kind !== "watch" || !isOnWay(branches, branch ?? present, entry)) continue;
    causes.push({ seconds, kind: "limit", words: text.replace(/^.*?: | \[\d+\]$/g, "") });
  }
  return causes.sort(bySeconds);
}

/** @param {{ seconds: number }} one @param {{ seconds: number }} other */
function bySeconds(one, other) {
  return one.seconds - other.seconds;
}

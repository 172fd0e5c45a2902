// What the session tells, taken apart: what happened, an order that is ahead.
import { movesBoat, wordOf } from "./orders.js";

const NEAR = 1; // [s] between a page's clock and the session's, when the page notes what it has done

/**
 * @typedef {{ number: string, seconds: number, when: string, text: string }} Plan an order that is ahead:
 *   its time [s], NaN where it waits for a condition; the number is "" where it is the exercise's own
 */

/** @param {string} subject number, when, order @returns {Plan} */
export function planOf(subject) {
  const [number, when, ...text] = subject.split(",");
  return { number, seconds: Number(when), when, text: text.join(",") };
}

/** Returns the letter of an order on the time line, "" for none. @param {string} order */
export function signOf(order) {
  if (!movesBoat(order)) return "";
  const word = wordOf(order);
  if (word === "casualty") return "C";
  return word === "clear" ? "c" : "o";
}

/**
 * Returns something that happened, as a log has it.
 * @param {string[]} fields
 * @param {string} saying who has said it, and after a comma the words, "" where nobody has
 * @returns {import("./session.js").Told}
 */
export function entryOf([, seconds, kind, text], saying) {
  const [speaker, ...words] = saying.split(",");
  return { seconds: Number(seconds), kind, text: plainly(text), speaker, words: words.join(",") };
}

/** Returns what is told as people say it: its time stands beside it. @param {string} text */
export function plainly(text) {
  return text.replace(/^tick \d+ \([\d.]+ s\): /, "").replace(/^LIMIT: /, "Limit passed: ");
}

/**
 * Returns a log with what was told before this page came. Some of it is there: what came while it
 * was asked for, and what this page has done itself, by its own clock.
 * @param {import("./session.js").Entry[]} log
 * @param {import("./session.js").Entry[]} earlier
 */
export function laidIn(log, earlier) {
  const whole = [...log];
  let place = whole.length;
  for (const entry of earlier.toReversed()) {
    const before = whole.slice(0, place);
    const there = before.findLastIndex((each) => same(each, entry));
    place = there >= 0 ? there : before.findLastIndex((each) => each.seconds <= entry.seconds) + 1;
    if (there < 0) whole.splice(place, 0, entry);
  }
  return whole;
}

/** @param {import("./session.js").Entry} one @param {import("./session.js").Entry} other */
function same(one, other) {
  return Math.abs(one.seconds - other.seconds) <= NEAR && said(one) === said(other);
}

/** Returns an entry without the line of who has said it. @param {import("./session.js").Entry} entry */
function said({ speaker, words, text }) {
  return speaker ? `${speaker}: ${words}` : text;
}

// What the session tells, taken apart: what happened, an order that is ahead, the marks.

/**
 * @typedef {{ number: string, seconds: number, when: string, text: string }} Plan an order that is ahead:
 *   its time [s], NaN where it waits for a condition; the number is "" where it is the exercise's own
 */

/** @param {string} subject number, when, order @returns {Plan} */
export function planOf(subject) {
  const [number, when, ...text] = subject.split(",");
  return { number, seconds: Number(when), when, text: text.join(",") };
}

/** Returns marks as they are told in words. @param {string} subject outcome and total */
export function marksOf(subject) {
  const [outcome, total] = subject.split(",");
  const marks = total ? `${Math.round(Number(total))} marks of 100` : "no marks";
  return outcome ? `${outcome}, ${marks}` : marks;
}

/** Returns something that happened, as a log has it. @param {string[]} fields @returns {import("./session.js").Entry} */
export function entryOf([, seconds, kind, text]) {
  return { seconds: Number(seconds), kind, text: plainly(text) };
}

/** Returns what is told as people say it: its time stands beside it. @param {string} text */
export function plainly(text) {
  return text.replace(/^tick \d+ \([\d.]+ s\): /, "").replace(/^LIMIT: /, "Limit passed: ");
}

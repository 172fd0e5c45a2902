// Orders to the crew that stand, and those that nobody has repeated yet.
import { ADDRESSED, CREW } from "./order-table.js";
import { objectOf, wordOf } from "./orders.js";

/** @typedef {{ seconds: number, axis: string, says: string }} CrewOrder */

export class CrewOrders {
  constructor() {
    /** @type {Map<string, CrewOrder>} orders that wait to be repeated, oldest first */
    this.waiting = new Map();
    this.wrong = "";
    this.told = ""; // the last order in words
    /** @type {Set<string>} orders that this station gave itself, and does not repeat */
    this.own = new Set();
  }

  /** @param {number} seconds @param {string} subject */
  give(seconds, subject) {
    const axis = subject.split(" ")[0];
    const says = saysOf(subject);
    const before = this.waiting.get(axis);
    // one that is sent again keeps its place: `aye` repeats the newest, and that is none
    if (before?.says !== says) this.waiting.delete(axis);
    this.waiting.set(axis, { seconds: before?.says === says ? before.seconds : seconds, axis, says });
    if (axis === "tell") this.told = says;
    this.wrong = "";
  }

  /** @param {string} order that this station gave itself */
  claim(order) {
    this.own.add(saysOf(order));
  }

  /** @param {string} subject what was repeated, and the order as it was told */
  mishear(subject) {
    const [said, order] = subject.split("; ");
    this.wrong = `${said}; ordered ${order}`;
  }

  /** @param {string} order that has been repeated, or stands no longer */
  settle(order) {
    this.waiting.delete(order.split(" ")[0]);
    this.wrong = "";
  }

  /** Forgets what waits, because nobody can repeat it any more. */
  end() {
    this.waiting.clear();
    this.wrong = "";
  }

  /** Forgets what was ordered after a moment gone back to. @param {number} seconds */
  goBack(seconds) {
    for (const [axis, order] of this.waiting) if (order.seconds > seconds) this.waiting.delete(axis);
    this.wrong = "";
  }

  /** Returns the newest order that a role is to repeat. @param {string} role */
  toRepeat(role) {
    const mine = [...this.waiting.values()].filter(
      ({ axis, says }) =>
        !this.own.has(says) &&
        (ADDRESSED[axis] ?? CREW).includes(role),
    );
    return mine.at(-1);
  }
}

/** Returns an order to the crew as people say it. @param {string} subject as a fact has it */
function saysOf(subject) {
  return wordOf(subject) === "tell" ? objectOf(subject) : subject;
}

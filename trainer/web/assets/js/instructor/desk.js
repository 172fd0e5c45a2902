// The instructor's desk: the session, the moment that is looked at, and orders with their answers.
import { Moment } from "./moment.js";

/**
 * @typedef {import("../model/session.js").Session} Session
 * @typedef {import("../protocol/link.js").Answer} Answer
 */

const LONG = 2; // lines of an answer from which on it is a text to read

/** Events: `answer` (detail: words and lines), when an order is answered by a text. */
export class Desk extends EventTarget {
  /** @param {Session} session */
  constructor(session) {
    super();
    this.session = session;
    this.moment = new Moment(session);
  }

  /**
   * Gives an order, and logs it with its answer as the other instructors see it.
   * @param {string} words
   * @returns {Promise<Answer>}
   */
  async give(words) {
    const answer = await this.session.order(words);
    if (answer.ok && answer.text) this.session.note("own", `${words}: ${answer.text}`, "instructor");
    if (answer.lines.length >= LONG) {
      this.dispatchEvent(new CustomEvent("answer", { detail: { words, lines: answer.lines } }));
    }
    return answer;
  }

  /** Gives orders one after the other, as long as they are obeyed. @param {string[]} orders */
  async giveAll(...orders) {
    for (const words of orders) {
      const answer = await this.give(words);
      if (!answer.ok) return answer;
    }
    return null;
  }
}

/**
 * Returns a function that calls another at once, and then at most every so many milliseconds.
 * @param {number} wait [ms]
 * @param {() => void} call
 */
export function paced(wait, call) {
  let due = false;
  let last = -Infinity;
  const run = () => {
    due = false;
    last = performance.now();
    call();
  };
  return () => {
    if (due) return;
    due = true;
    const left = last + wait - performance.now();
    if (left <= 0) run();
    else setTimeout(run, left);
  };
}

/** Shows a window beside what is being done: the focus stays where it is. @param {HTMLDialogElement} dialog */
export function showBeside(dialog) {
  const before = /** @type {HTMLElement} */ (document.activeElement ?? document.body);
  dialog.show();
  if (before === document.body) /** @type {HTMLElement} */ (document.activeElement)?.blur();
  else before.focus();
}

// The alerts of a session, as it tells them in facts.
import { plainly } from "./told.js";

/**
 * @typedef {import("./alerts.js").Rank} Rank
 * @typedef {import("./alerts.js").State} State
 * @typedef {{ number: string, words: string, seconds: number, rank: Rank, state: State, silent: number }} Alert
 *   `silent`: until when [ms]
 */

export class OpenAlerts {
  constructor() {
    /** @type {Map<string, Alert>} by their numbers */
    this.all = new Map();
    /** @type {Map<string, Rank>} told before the alert */
    this.ranks = new Map();
  }

  /** @param {string} subject number and rank of the next alert */
  rank(subject) {
    const [number, rank] = subject.split(",");
    this.ranks.set(number, /** @type {Rank} */ (rank));
  }

  /** @param {number} seconds @param {string} subject number, kind and words */
  raise(seconds, subject) {
    const [number, , ...words] = subject.split(",");
    const rank = this.ranks.get(number) ?? "warning";
    this.all.set(number, { number, words: plainly(words.join(",")), seconds, rank, state: "active", silent: 0 });
  }

  /** @param {string} subject number, state, how long it is silent [s] */
  become(subject) {
    const [number, state, left] = subject.split(",");
    const alert = this.all.get(number);
    if (state === "normal") this.all.delete(number);
    else if (alert) Object.assign(alert, { state, silent: performance.now() + 1000 * Number(left) });
  }

  /** Forgets all, because the session tells what is open. */
  forget() {
    this.all.clear();
  }
}

// The alerts of a session, as it tells them in facts.
import { plainly } from "./told.js";

/**
 * @typedef {import("./alerts.js").Rank} Rank
 * @typedef {import("./alerts.js").State} State
 * @typedef {{ number: string, words: string, seconds: number, rank: Rank, state: State, silent: number, by: string,
 *   name: string }} Alert `silent`: until when [ms]; `by` whom it is acknowledged, "" at this page; its `name` in the table
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
    this.all.set(number, { number, words: plainly(words.join(",")), seconds, rank, state: "active", silent: 0, by: "", name: "" });
  }

  /** @param {string} subject number, state, how long it is silent [s], who acknowledges it, its name */
  become(subject) {
    const [number, state, left, answerer = "you", name = ""] = subject.split(",");
    const by = answerer === "you" ? "" : answerer;
    const alert = this.all.get(number);
    if (state === "normal") this.all.delete(number);
    else if (alert) Object.assign(alert, { state, by, name, silent: performance.now() + 1000 * Number(left) });
  }

  /** Forgets all, because the session tells what is open. */
  forget() {
    this.all.clear();
  }
}

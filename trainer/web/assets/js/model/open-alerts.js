// The alerts of a session, as it tells them in facts.
import { plainly } from "./told.js";

/**
 * @typedef {import("./alerts.js").Rank} Rank
 * @typedef {{ number: string, kind: string, words: string, seconds: number, seen: boolean,
 *   rank: Rank }} Alert
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
    const [number, kind, ...words] = subject.split(",");
    const rank = this.ranks.get(number) ?? "warning";
    this.all.set(number, { number, kind, words: plainly(words.join(",")), seconds, seen: false, rank });
  }

  /** @param {string} number of an alert that somebody has seen */
  see(number) {
    const alert = this.all.get(number);
    if (alert) alert.seen = true;
  }

  /** Forgets what came after a moment gone back to. @param {number} seconds */
  goBack(seconds) {
    for (const [number, alert] of this.all) if (alert.seconds > seconds) this.all.delete(number);
  }
}

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

  /** Whether a fact is one of these. @param {string} what */
  static takes(what) {
    return ["alert-rank", "alert", "ack"].includes(what);
  }

  /** @param {number} seconds @param {string} what @param {string} subject */
  take(seconds, what, subject) {
    const [number, kind, ...words] = subject.split(",");
    if (what === "alert-rank") this.ranks.set(number, /** @type {Rank} */ (kind));
    else if (what === "alert") {
      const rank = this.ranks.get(number) ?? "warning";
      this.all.set(number, { number, kind, words: plainly(words.join(",")), seconds, seen: false, rank });
    } else {
      const alert = this.all.get(number);
      if (alert) alert.seen = true;
    }
  }

  /** Forgets what came after a moment gone back to. @param {number} seconds */
  goBack(seconds) {
    for (const [number, alert] of this.all) if (alert.seconds > seconds) this.all.delete(number);
  }
}

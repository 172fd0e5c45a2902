// When an alert sounds: at once, then again at the pace of its rank, until somebody has seen it.
import { PACES } from "./model/alert-table.js";

/**
 * @typedef {import("./model/alerts.js").Alerts} Alerts
 * @typedef {import("./model/alerts.js").Rank} Rank
 */

const LOOK = 250; // [ms] between looks

/** Sounds the alerts of a page, the worst of those that are due. */
export class AlertSounder {
  /**
   * @param {Alerts} alerts
   * @param {{ alert(rank: Rank): void }} sound
   * @param {() => number} [now] [ms]
   */
  constructor(alerts, sound, now = () => performance.now()) {
    this.alerts = alerts;
    this.sound = sound;
    this.now = now;
    /** @type {Map<string, number>} when each alert that nobody has seen sounds next [ms] */
    this.due = new Map();
    alerts.addEventListener("change", () => this.look());
    setInterval(() => this.look(), LOOK);
  }

  /** Sounds what is due, and forgets what was seen or has ended: it sounds anew when it comes again. */
  look() {
    const now = this.now();
    const calling = this.alerts.shown.filter(({ state }) => state === "active" || state === "silenced");
    const keys = new Set(calling.map((each) => each.key));
    for (const key of this.due.keys()) if (!keys.has(key)) this.due.delete(key);
    const due = calling.filter(({ key, state }) => state === "active" && now >= (this.due.get(key) ?? 0));
    if (due.length) this.sound.alert(due[0].rank);
    for (const each of due) this.due.set(each.key, now + 1000 * (PACES[each.rank] ?? Infinity));
  }

  /** Makes the alerts of now silent for half a minute; a new one sounds all the same. */
  silence() {
    for (const alert of this.alerts.shown) if (alert.owed && alert.state === "active") this.alerts.silence(alert);
  }
}

// When an alert sounds: at once, then again at the pace of its rank, until somebody has seen it.

/**
 * @typedef {import("./model/alerts.js").Alerts} Alerts
 * @typedef {import("./model/alerts.js").Rank} Rank
 */

/** How long until an alert of that rank sounds again [ms]. @type {Record<Rank, number>} */
const AGAIN = { emergency: 2_000, alarm: 10_000, warning: 60_000, caution: Infinity };
const SILENCE = 30_000; // [ms] that Silence lasts (MSC.302(87), 7.3)
const LOOK = 250; // [ms] between looks

/** Sounds the alerts of a page, the worst of those that are due. */
export class AlertSounder {
  /**
   * @param {Alerts} alerts of which another page of the station may have silenced some
   * @param {{ alert(rank: Rank): void }} sound
   * @param {() => number} [now] [ms]
   */
  constructor(alerts, sound, now = () => performance.now()) {
    this.alerts = alerts;
    this.sound = sound;
    this.now = now;
    /** @type {Map<string, number>} when each alert that nobody has seen sounds next [ms] */
    this.due = new Map();
    /** @type {Map<string, number>} until when an alert is silent, perhaps before this page has found it [ms] */
    this.silent = new Map();
    alerts.addEventListener("change", () => this.look());
    alerts.addEventListener("silent", (event) => {
      const { key, seconds } = /** @type {CustomEvent} */ (event).detail;
      this.silent.set(key, this.now() + 1000 * seconds);
    });
    setInterval(() => this.look(), LOOK);
  }

  /** Sounds what is due, and forgets what was seen or has ended: it sounds anew when it comes again. */
  look() {
    const now = this.now();
    const fresh = this.alerts.shown.filter((each) => each.fresh);
    const keys = new Set(fresh.map((each) => each.key));
    for (const key of this.due.keys()) {
      if (!keys.has(key)) for (const times of [this.due, this.silent]) times.delete(key);
    }
    const due = fresh.filter(({ key }) => now >= Math.max(this.due.get(key) ?? 0, this.silent.get(key) ?? 0));
    if (due.length) this.sound.alert(due[0].rank);
    for (const each of due) this.due.set(each.key, now + AGAIN[each.rank]);
  }

  /** Makes the alerts of now silent for half a minute; a new one sounds all the same. */
  silence() {
    for (const key of this.due.keys()) {
      this.silent.set(key, this.now() + SILENCE);
      this.alerts.tellSilent(key);
    }
  }
}

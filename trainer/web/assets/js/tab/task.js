// What a recording is sent for: what broke first, what is to be kept from there, and how a try went.

/**
 * @typedef {[name: string, column: number, sign: number, limit: number]} Kept a limit: its column of
 *   the channel motion, the sign by which the worst is the greatest, 0 for both sides
 * @typedef {{ causes: [branch: number, tick: number, says: string][], scheduled: [branch: number, tick: number, words: string][],
 *   kept: Kept[] }} Asked `scheduled` is what the exercise itself breaks and clears
 */

const LASTS = 120; // [s] from what broke to the result
export const MOMENT = "what-broke"; // the snapshot from which it is flown

export class Task {
  /** @param {import("./desk.js").Desk} desk whose recording has been flown @param {Asked} asked */
  constructor(desk, { causes, scheduled, kept }) {
    const { core, flight } = desk;
    const begun = flight.branches.get(1)?.begun ?? 0;
    const cause = causes.find(([branch, tick]) => desk.isPast(branch, tick));
    this.desk = desk;
    this.kept = kept;
    this.scheduled = scheduled.filter(([branch, tick]) => desk.isPast(branch, tick));
    this.recorded = flight.branches.size; // branches: what comes later is a try
    this.from = cause ? Math.min(cause[1] + 1, core.ticks) : begun; // an order acts in the tick after it
    this.until = this.from + Math.round(LASTS / core.step);
    this.cause = cause?.[2] ?? "";
    this.before = this.worst(Math.min(this.until, core.ticks));
    flight.snapshots.set(MOMENT, { branch: flight.present, tick: this.from });
  }

  /** The time from which it is flown, that of its result [s], the limits, and after them what broke. */
  get told() {
    const { step } = this.desk.core;
    const limits = this.kept.map(([name, , , limit]) => `${name}:${limit}`);
    return [this.from * step, this.until * step, limits.join(" "), this.cause].join(",");
  }

  /** Whether somebody flies it: neither as it was recorded, nor again. */
  get isTry() {
    const { flight } = this.desk;
    return flight.present > this.recorded && !flight.replayed;
  }

  /** Whether a try has just come to its result. */
  get isOver() {
    return this.desk.core.ticks === this.until && this.isTry;
  }

  /** Breaks and clears in a try what the exercise does at this tick. */
  play() {
    const { core, grammar } = this.desk;
    for (const [, tick, words] of this.isTry ? this.scheduled : []) {
      if (tick === core.ticks) this.desk.attempt(grammar.parse(words));
    }
  }

  /** How it went: of each limit its name, itself, the worst, the worst that was recorded, whether it was kept. */
  get result() {
    const worst = this.worst(this.until);
    return this.kept
      .map(([name, , sign, limit], at) => {
        const broken = (sign || 1) * (worst[at] - limit) > 0;
        return [name, limit, worst[at], this.before[at], broken ? "passed" : "kept"].join(",");
      })
      .join(" ");
  }

  /** Returns the worst of each limit's quantity on the way to the present, up to a tick. @param {number} until */
  worst(until) {
    const found = this.kept.map(([, , sign]) => (sign < 0 ? Infinity : -Infinity));
    const ticks = Array.from({ length: until - this.from + 1 }, (_, at) => this.from + at);
    this.desk.flight.recall(ticks, () => {
      const row = this.desk.readings.values("motion").map(Number);
      this.kept.forEach(([, column, sign], at) => {
        const value = sign ? row[column] : Math.abs(row[column]);
        found[at] = sign < 0 ? Math.min(found[at], value) : Math.max(found[at], value);
      });
    });
    return found;
  }
}

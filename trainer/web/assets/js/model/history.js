// What channels have shown so far: numbers and words by channel and field, at times.

import { partAt } from "./branches.js";

const SEAM = 1; // [s] between two parts of a past
const MOST = 7200; // rows of a channel: an hour of ticks of half a second

/**
 * @typedef {Record<string, any>} Row numbers, and words where a channel has them
 * @typedef {{ times: number[], rows: Row[] }} Past
 * @typedef {import("./branches.js").Part} Part
 */

export class History {
  constructor() {
    /** @type {Map<string, Past>} */
    this.channels = new Map();
    /** @type {Map<number, Map<string, Past>>} what time has gone back over, by branch */
    this.left = new Map();
    /** @type {Map<string, Past>} what was cut off last, of each channel */
    this.cutOff = new Map();
  }

  /** Returns what a channel has shown. @param {string} channel @returns {Past} */
  of(channel) {
    const found = this.channels.get(channel);
    if (found) return found;
    const begun = { times: [], rows: [] };
    this.channels.set(channel, begun);
    return begun;
  }

  /**
   * Adds a reading; time that has gone back forgets what was later.
   * @param {string} channel
   * @param {number} seconds
   * @param {Row} row
   */
  add(channel, seconds, row) {
    const past = this.of(channel);
    this.cut(channel, seconds);
    past.times.push(seconds);
    past.rows.push(row);
    if (past.times.length > MOST) {
      past.times.shift();
      past.rows.shift();
    }
  }

  /**
   * Lays an earlier past before what has been seen.
   * @param {string} channel
   * @param {[number, Row][]} earlier
   */
  recall(channel, earlier) {
    const past = this.of(channel);
    const first = past.times[0] ?? Infinity;
    const kept = earlier.filter(([seconds]) => seconds < first).sort((a, b) => a[0] - b[0]);
    past.times.unshift(...kept.map(([seconds]) => seconds));
    past.rows.unshift(...kept.map(([, row]) => row));
  }

  /**
   * Lays what is after a moment aside, each row with the branch on which it was flown.
   * @param {number} seconds
   * @param {Part[]} parts of the way to the present
   */
  goBack(seconds, parts) {
    for (const channel of this.channels.keys()) this.cut(channel, seconds + 1e-6);
    for (const [channel, { times, rows }] of this.cutOff) {
      times.forEach((at, index) => this.keep(partAt(parts, at), channel, at, rows[index]));
    }
    this.cutOff = new Map();
  }

  /** @param {number} branch @param {string} channel @param {number} seconds @param {Row} row */
  keep(branch, channel, seconds, row) {
    const channels = this.left.get(branch) ?? new Map();
    this.left.set(branch, channels);
    const past = channels.get(channel) ?? { times: [], rows: [] };
    channels.set(channel, past);
    const at = before(past.times, seconds);
    const there = past.times[at] === seconds ? 1 : 0;
    past.times.splice(at, there, seconds);
    past.rows.splice(at, there, row);
  }

  /**
   * Lays the past of a branch that was left after the present; tells whether all of it was seen.
   * @param {Part[]} parts of the way to its end
   * @param {number} from [s] where it differs
   */
  takeUp(parts, from) {
    const first = this.left.get(partAt(parts, from + SEAM))?.get("motion")?.times ?? [];
    const seen = first.some((at) => at > from && at <= from + SEAM);
    const channels = parts.flatMap(({ number }) => [...(this.left.get(number)?.keys() ?? [])]);
    for (const channel of new Set(channels)) joined(this.of(channel), this.leftOn(parts, channel, from, Infinity));
    return seen;
  }

  /**
   * Returns what a channel has shown between two times on branches that were left.
   * @param {Part[]} parts of the way to the end of one
   * @param {string} channel
   * @param {number} from [s]
   * @param {number} to [s]
   * @returns {Past}
   */
  leftOn(parts, channel, from, to) {
    /** @type {Past} */
    const found = { times: [], rows: [] };
    let begun = from;
    for (const { number, until } of parts) {
      const past = this.left.get(number)?.get(channel);
      if (past) joined(found, within(past, begun, Math.min(until, to)));
      begun = Math.max(begun, until);
    }
    return found;
  }

  /** @param {string} channel @param {number} seconds */
  cut(channel, seconds) {
    const { times, rows } = this.of(channel);
    const kept = before(times, seconds);
    if (kept === times.length) return;
    this.cutOff.set(channel, { times: times.splice(kept), rows: rows.splice(kept) });
  }

  /**
   * Returns the mean of a field over the last seconds, and over how many; null where there is none.
   *
   * A value counts as long as it stood: rows of a past that was asked for lie further apart.
   * @param {string} channel
   * @param {string} field
   * @param {number} span [s]
   * @returns {{ mean: number, span: number } | null}
   */
  mean(channel, field, span) {
    const { times, rows } = this.of(channel);
    const last = times.length - 1;
    const begin = Math.max(times[last] - span, times[0]);
    let [sum, whole] = [0, 0];
    for (let at = last; at > 0 && times[at] > begin; at -= 1) {
      const stood = times[at] - Math.max(times[at - 1], begin);
      sum += (rows[at][field] ?? 0) * stood;
      whole += stood;
    }
    const now = rows[last]?.[field];
    return now === undefined ? null : { mean: whole ? sum / whole : now, span: whole };
  }

  /**
   * Returns the row of a channel at a time, the last before it; undefined where it is not known.
   * @param {string} channel
   * @param {number} seconds
   */
  at(channel, seconds) {
    return rowAt(this.of(channel), seconds);
  }

  /**
   * Returns the row of a channel on a branch that was left, where this page has seen it.
   * @param {number} branch on which it was flown
   * @param {string} channel
   * @param {number} seconds
   */
  leftAt(branch, channel, seconds) {
    const past = this.left.get(branch)?.get(channel);
    return past && rowAt(past, seconds);
  }
}

/** Returns what a past has after one time and up to another. @param {Past} past @param {number} from [s] @param {number} to [s] @returns {Past} */
export function within({ times, rows }, from, to) {
  const [low, high] = [before(times, from + 1e-6), before(times, to + 1e-6)];
  return { times: times.slice(low, high), rows: rows.slice(low, high) };
}

/** Lays one past after another, and returns it. @param {Past} first @param {Past} next */
export function joined(first, next) {
  first.times.push(...next.times);
  first.rows.push(...next.rows);
  return first;
}

/** Returns the row of a past at a time, the last before it. @param {Past} past @param {number} seconds @returns {Row | undefined} */
export function rowAt({ times, rows }, seconds) {
  if (times[0] > seconds + SEAM) return undefined;
  return rows[Math.max(before(times, seconds + 1e-6) - 1, 0)];
}

/** Returns how many of some rising times lie before one. @param {number[]} times @param {number} seconds */
export function before(times, seconds) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < seconds) low = middle + 1;
    else high = middle;
  }
  return low;
}

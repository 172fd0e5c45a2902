// The past that a page has asked for, as it comes. Time may go back meanwhile: what is later then
// is of a branch that was left, and is not laid in.

/** @typedef {import("./history.js").Row} Row */

export class Recall {
  constructor() {
    /** @type {Map<string, { rows: [number, Row][], until: number }>} by channel; what stands, until [s] */
    this.coming = new Map();
  }

  /** Whether the past of a channel is coming. @param {string} channel */
  has(channel) {
    return this.coming.has(channel);
  }

  /** @param {string} channel */
  begin(channel) {
    this.coming.set(channel, { rows: [], until: Infinity });
  }

  /** @param {string} channel @param {number} seconds @param {Row} row */
  take(channel, seconds, row) {
    this.coming.get(channel)?.rows.push([seconds, row]);
  }

  /** @param {number} seconds after which nothing stands of what is coming */
  goBack(seconds) {
    for (const each of this.coming.values()) each.until = Math.min(each.until, seconds);
  }

  /** Returns what has come of a channel and stands. @param {string} channel @returns {[number, Row][]} */
  end(channel) {
    const { rows, until } = this.coming.get(channel) ?? { rows: [], until: 0 };
    this.coming.delete(channel);
    return rows.filter(([seconds]) => seconds <= until);
  }
}

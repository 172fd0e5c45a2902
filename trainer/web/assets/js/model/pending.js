// What has been ordered and does not stand yet, until readings show it.

const LAST = 3; // readings after an answer, of which the first may still be older than the order

/**
 * @typedef {string | number} Value
 * @typedef {{ value: Value, unanswered: number, tick: number, seen: number,
 *   reading: import("./readings.js").Reading | undefined }} Wanted
 */

/** The orders of one page that one channel will show. */
export class Pending {
  /**
   * @param {import("./session.js").Session} session
   * @param {string} channel
   */
  constructor(session, channel) {
    this.session = session;
    this.channel = channel;
    /** @type {Map<string, Wanted>} */
    this.wanted = new Map();
    session.on("fact", (event) => {
      if (/** @type {CustomEvent} */ (event).detail.what === "back") this.wanted.clear();
    });
  }

  /** The latest reading of the channel. */
  get reading() {
    return this.session.readings.latest.get(this.channel);
  }

  /** Notes what is ordered, before its answer. @param {string} name @param {Value} value */
  give(name, value) {
    const unanswered = (this.wanted.get(name)?.unanswered ?? 0) + 1;
    const tick = this.reading?.tick ?? 0;
    this.wanted.set(name, { value, unanswered, tick, seen: 0, reading: undefined });
  }

  /** Takes the answer to an order: what is refused is forgotten. @param {string} name @param {boolean} obeyed */
  answered(name, obeyed) {
    const wanted = this.wanted.get(name);
    if (!wanted) return;
    wanted.unanswered -= 1;
    wanted.reading = this.reading;
    wanted.seen = 0;
    if (!obeyed) this.wanted.delete(name);
  }

  /** Whether an order still waits for its answer. @param {string} name */
  waits(name) {
    return (this.wanted.get(name)?.unanswered ?? 0) > 0;
  }

  /**
   * Returns what is wanted: the order while readings may be older than it, then what stands.
   * @template {Value | null} T
   * @param {string} name
   * @param {T} stands by the latest reading
   * @returns {T}
   */
  resolve(name, stands) {
    const [wanted, { reading }] = [this.wanted.get(name), this];
    if (!wanted) return stands;
    if (wanted.unanswered) return /** @type {T} */ (wanted.value);
    if (reading !== wanted.reading) wanted.seen += 1;
    wanted.reading = reading;
    const told = wanted.seen > 0 && wanted.value === stands;
    if (!told && wanted.seen < LAST && (reading?.tick ?? 0) >= wanted.tick) {
      return /** @type {T} */ (wanted.value);
    }
    this.wanted.delete(name);
    return stands;
  }
}

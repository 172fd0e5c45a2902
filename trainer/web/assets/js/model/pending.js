// What has been ordered and does not stand yet, until readings show it.

const LAST = 3; // readings, or ticks, after an answer: the first may still be older than the order

/**
 * @typedef {string | number} Value
 * @typedef {import("./readings.js").Reading | undefined} Shown
 * @typedef {{ value: Value, unanswered: number, given: number, answered: number, seen: number,
 *   before: Shown, reading: Shown }} Wanted
 * `given` and `answered` are the ticks that were shown then, `seen` the readings since the answer.
 * `before` is what was shown when it was given, undefined behind another order without answer.
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
    session.onFacts({ back: () => this.wanted.clear() });
  }

  /** The latest reading of the channel. */
  get reading() {
    return this.session.readings.latest.get(this.channel);
  }

  /** Notes what is ordered, before its answer. @param {string} name @param {Value} value */
  give(name, value) {
    const unanswered = (this.wanted.get(name)?.unanswered ?? 0) + 1;
    const given = this.reading?.tick ?? 0;
    const before = unanswered > 1 ? undefined : this.reading;
    const none = { answered: given, seen: 0, reading: undefined };
    this.wanted.set(name, { value, unanswered, given, before, ...none });
  }

  /** Takes the answer to an order: what is refused is forgotten. @param {string} name @param {boolean} obeyed */
  answered(name, obeyed) {
    const wanted = this.wanted.get(name);
    if (!wanted) return;
    wanted.unanswered -= 1;
    wanted.reading = this.reading;
    wanted.answered = this.reading?.tick ?? 0;
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
    const tick = reading?.tick ?? 0;
    const early = wanted.before !== undefined && reading !== wanted.before; // before its answer
    const told = (wanted.seen > 0 || early) && wanted.value === stands;
    const late = wanted.seen >= LAST || tick > wanted.answered + LAST || tick < wanted.given;
    if (!told && !late) return /** @type {T} */ (wanted.value);
    this.wanted.delete(name);
    return stands;
  }
}

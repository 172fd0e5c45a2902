// What has been ordered and does not stand yet, until readings show it.

const TICKS = 1; // after an order the next reading may be older than the order

export class Pending {
  constructor() {
    /** @type {Map<string, { value: string | number, tick: number }>} */
    this.wanted = new Map();
  }

  /**
   * Notes an order.
   * @param {string} name
   * @param {string | number} value
   * @param {number} tick of the latest reading
   */
  give(name, value, tick) {
    this.wanted.set(name, { value, tick });
  }

  /** Forgets an order that was refused. @param {string} name */
  drop(name) {
    this.wanted.delete(name);
  }

  /**
   * Returns what is wanted: the order while readings may be older than it, then what stands.
   * @template {string | number} T
   * @param {string} name
   * @param {T} stands
   * @param {number} tick of the reading
   * @returns {T}
   */
  resolve(name, stands, tick) {
    const wanted = this.wanted.get(name);
    if (!wanted) return stands;
    const over = tick > wanted.tick + TICKS || tick < wanted.tick;
    if (over || wanted.value === stands) {
      this.wanted.delete(name);
      return stands;
    }
    return /** @type {T} */ (wanted.value);
  }
}

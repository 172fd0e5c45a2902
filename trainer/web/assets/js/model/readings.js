// The latest reading of each channel, as the session has sent it.

/**
 * @typedef {{ channel: string, tick: number, seconds: number, at: number,
 *   values: Record<string, string> }} Reading
 */

export class Readings {
  constructor() {
    /** @type {Map<string, string[]>} */
    this.names = new Map();
    /** @type {Map<string, Reading>} */
    this.latest = new Map();
  }

  /**
   * Takes names or a state; returns the reading if it is one.
   * @param {import("../protocol/line.js").Sentence} sentence
   * @returns {Reading | null}
   */
  take({ kind, fields }) {
    if (kind === "TRN") {
      const [channel, ...names] = fields;
      this.names.set(channel, names.map((name) => name.split(":")[0]));
      return null;
    }
    const reading = this.reading(fields);
    this.latest.set(reading.channel, reading);
    return reading;
  }

  /** Returns the reading in the fields of a state. @param {string[]} fields @returns {Reading} */
  reading(fields) {
    const [channel, tick, seconds, ...values] = fields;
    const names = this.names.get(channel) ?? [];
    return {
      channel,
      tick: Number(tick),
      seconds: Number(seconds),
      at: performance.now(),
      values: Object.fromEntries(names.map((name, index) => [name, values[index] ?? ""])),
    };
  }

  /** Returns a value as it was sent, "" where there is none. @param {string} place */
  word(place) {
    const [channel, field] = place.split(".");
    return this.latest.get(channel)?.values[field] ?? "";
  }

  /** Returns a value as a number, null where there is none. @param {string} place */
  number(place) {
    const word = this.word(place);
    const value = Number(word);
    return word === "" || Number.isNaN(value) ? null : value;
  }

  /** Forgets all: the line is lost, or another session is there. */
  forget() {
    this.latest.clear();
  }
}

/** Returns what a reading holds, by name: numbers, and words where there are no numbers. @param {Reading} reading */
export function rowOf(reading) {
  /** @type {import("./history.js").Row} */
  const found = {};
  for (const [name, word] of Object.entries(reading.values)) {
    const value = Number(word);
    if (word !== "") found[name] = Number.isNaN(value) ? word : value;
  }
  return found;
}

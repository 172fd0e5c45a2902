// The core in WebAssembly: one boat, whose state is a block of numbers.

/**
 * @typedef {{ memory: WebAssembly.Memory, trainer_tick: (...places: number[]) => number,
 *   trainer_show: (vessel: number, state: number, scratch: number, readings: number) => number,
 *   trainer_begin: (kind: number, amount: number, ticks: number, state: number) => number,
 *   trainer_end: (kind: number, ticks: number, state: number) => number,
 *   trainer_sea: (vessel: number, step: number, ramp: number, wanted: number, scratch: number,
 *     state: number) => number } & Record<string, any>} Exports
 * @typedef {{ records: Record<string, string>, places: Record<string, number>, step_s: number,
 *   readings: Record<string, number>, state_doubles: number }} Numbers
 */

const ROOMS = ["vessel", "compact", "scheme", "state", "scratch"];

/** Returns the bytes that a text in base64 stands for. @param {string} text */
export function unpack(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

export class Core {
  /** Returns the core for a boat. @param {BufferSource} module @param {Numbers} boat */
  static async of(module, boat) {
    const { instance } = await WebAssembly.instantiate(module, {});
    return new Core(/** @type {any} */ (instance.exports), boat);
  }

  /** @param {Exports} exports @param {Numbers} boat */
  constructor(exports, boat) {
    this.exports = exports;
    this.boat = boat;
    this.step = boat.step_s;
    this.at = Object.fromEntries([...ROOMS, "wanted", "readings"].map((room) => [room, exports[`trainer_${room}`].value]));
    this.rooms = ROOMS.map((room) => this.at[room]);
    const { buffer } = exports.memory;
    const bytes = new Uint8Array(buffer);
    for (const [room, text] of Object.entries(boat.records)) bytes.set(unpack(text), this.at[room]);
    this.state = new Float64Array(buffer, this.at.state, boat.state_doubles);
    this.wanted = new Float64Array(buffer, this.at.wanted, 9);
    this.shown = new Float64Array(buffer, this.at.readings, Object.keys(boat.readings).length);
  }

  /** Returns a number of the state by its name. @param {string} name */
  get(name) {
    return this.state[this.boat.places[name]];
  }

  /** Ticks done. */
  get ticks() {
    return this.state[this.boat.places.tick];
  }

  /** Advances the boat by a tick; returns 0, or a status with the state as it was. */
  tick() {
    return this.exports.trainer_tick(...this.rooms);
  }

  /** Returns all that is read off the boat [SI], as the core's table of readings has it. */
  show() {
    const { vessel, state, scratch, readings } = this.at;
    this.exports.trainer_show(vessel, state, scratch, readings);
    return this.shown;
  }

  /** @param {number} kind @param {number} amount [SI] @param {number} ticks */
  begin(kind, amount, ticks) {
    return this.exports.trainer_begin(kind, amount, ticks, this.at.state);
  }

  /** @param {number} kind @param {number} ticks */
  end(kind, ticks) {
    return this.exports.trainer_end(kind, ticks, this.at.state);
  }

  /** Orders a sea, by its quantities and the taper. @param {number[]} wanted @param {number} ramp [s] */
  sea(wanted, ramp) {
    this.wanted.set(wanted);
    const { vessel, scratch, state } = this.at;
    this.exports.trainer_sea(vessel, this.step, ramp, this.at.wanted, scratch, state);
  }
}

// Orders that a boat in a page takes: numbers written into the state, the sea, the shipped casualties.
import { carryOut, rowsOf } from "./rows.js";
import { describe } from "./readings.js";

/**
 * @typedef {import("./core.js").Core} Core
 * @typedef {import("./grammar.js").Order} Order
 * @typedef {{ name: string, kind: string, code: number, severity: number, ramp: number, clear: number,
 *   says: string, full: number, limit: number, low: number, high: number, sudden: boolean,
 *   degree: string, told: string, usual: string }} Casualty
 * @typedef {{ orders: string[], casualties: Casualty[], calms: Record<string, [number, number]>,
 *   ramp_s: number }} Table
 */

const LONGEST = 3600; // [s] of a ramp
const [HEIGHT, OMEGA, GAMMA, DIRECTION] = [0, 1, 2, 3];
const [PEAKED, TAPER] = [7, 8];

/** Why an order changes nothing. */
export class Refusal extends Error {}

export class BoatOrders {
  /** @param {Core} core @param {Table} table @param {import("./readings.js").Fittings} fittings */
  constructor(core, table, fittings) {
    this.core = core;
    this.table = table;
    this.fittings = fittings;
    this.rows = rowsOf(table.orders);
    this.duties = { sea: this.sea, casualty: this.begin, clear: this.clear };
  }

  /** Whether an order is about the boat, and this page takes it. @param {Order} order */
  takes(order) {
    return order.name in this.duties || this.rows.has(order.words);
  }

  /** Carries an order out; returns what now holds. Throws Refusal. @param {Order} order @returns {string} */
  obey(order) {
    if (order.name in this.duties) {
      return this.duties[/** @type {keyof typeof this.duties} */ (order.name)].call(this, order);
    }
    const row = /** @type {import("./rows.js").Row} */ (this.rows.get(order.words));
    const depth = order.name === "depth" || order.name === "periscope";
    if (depth && this.core.get("hover")) throw new Refusal("the boat hovers, which this page cannot order");
    const why = carryOut(row, order.value, this.core.state);
    if (why) throw new Refusal(why);
    return order.text;
  }

  /** @param {Order} order */
  sea(order) {
    const { core, table } = this;
    const { places } = core.boat;
    const wanted = [...core.state.slice(places.sea_target, places.sea_target + TAPER), core.get("sea_taper")];
    if (order.words === "sea from") wanted[DIRECTION] = order.value + Math.PI;
    else if (order.words === "sea calm") wanted[HEIGHT] = 0;
    else {
      const found = order.words === "sea state" ? table.calms[String(order.value)] : undefined;
      if (!found) throw new Refusal(`this page raises sea state ${Object.keys(table.calms).join(", ")}`);
      [wanted[HEIGHT], wanted[OMEGA], wanted[GAMMA], wanted[PEAKED]] = [...found, 1, 0];
    }
    if (core.get("sea_height") === 0) core.state.set(wanted.slice(1, TAPER), places.sea + 1);
    core.sea(wanted, table.ramp_s);
    return `${order.text}, within ${table.ramp_s} s`;
  }

  /** @param {string} name @returns {Casualty} */
  find(name) {
    const found = this.table.casualties.find((each) => each.name === name);
    if (!found) throw new Refusal(`no casualty ${name}`);
    return found;
  }

  /** @param {number} seconds */
  ticks(seconds) {
    return Math.ceil(seconds / this.core.step - 1e-9) + 0; // no -0
  }

  /** @param {Order} order */
  begin(order) {
    const found = this.find(order.subject);
    const given = [...order.numbers];
    const ramp = order.word === "ramp" ? Number(given.pop()) : found.ramp;
    const severity = given[0] ?? found.severity;
    if (!(found.low <= severity && severity <= found.high)) {
      throw new Refusal(`severity ${severity}: it is ${found.low} to ${found.high}`);
    }
    if (ramp > LONGEST || (found.sudden && ramp)) throw new Refusal(`${found.kind} has no such ramp`);
    const amount = severity * found.full * found.limit;
    if (!this.core.begin(found.code, amount, this.ticks(ramp))) throw new Refusal("too many casualties: clear one");
    const degree = found.sudden ? "" : `, ${describe(this.fittings, found.kind, amount)}`;
    return `casualty ${found.name}${degree}${ramp ? ` within ${ramp} s` : ""}`;
  }

  /** @param {Order} order */
  clear(order) {
    const all = ["all", "casualties"].includes(order.subject);
    const named = all ? this.table.casualties : [this.find(order.subject)];
    const once = named.filter((each, at) => named.findIndex(({ code }) => code === each.code) === at);
    const ended = once.filter((each) => this.core.end(each.code, this.ticks(this.clearing(each, all))));
    if (!ended.length) throw new Refusal("there is nothing to clear");
    return `clearing ${ended.map(({ name }) => name).join(", ")}`;
  }

  /** @param {Casualty} casualty @param {boolean} all by its kind @returns {number} [s] */
  clearing(casualty, all) {
    const own = this.table.casualties.find(({ name }) => name === casualty.kind);
    return (all && own ? own : casualty).clear;
  }
}

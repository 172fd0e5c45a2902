// A kiosk in a file: one lever for all planes, a guard of the depth, a dive from the start for the next.
import { Refusal } from "./orders.js";

/**
 * @typedef {{ shares: [string, number, number][], guarded: number, ahead: number, keeps: number,
 *   given: number, level: number, lasts: number, exercise: [string, string][] }} Dive names of the
 *   planes with the lever's share and their limit [rad]; depths and margins [m], times [s], pitch [rad]
 */

const LETTERS = { stern: "s", bow: "b" };
const ORDERS = ["lever", "restart"];

export class Visitors {
  /** @param {import("./desk.js").Desk} desk @param {Dive} dive */
  constructor(desk, dive) {
    this.desk = desk;
    this.dive = dive;
    this.begun = desk.core.ticks;
    this.exercise = dive.exercise;
  }

  /** Whether the dive has come to its end. */
  get isOver() {
    const { core } = this.desk;
    return core.ticks - this.begun === Math.round(this.dive.lasts / core.step);
  }

  /** @param {import("./grammar.js").Order} order */
  takes(order) {
    return ORDERS.includes(order.name);
  }

  /** @param {import("./grammar.js").Order} order */
  obey(order) {
    if (order.name === "restart") return this.restart();
    if (this.holds) throw new Refusal(`the boat levels by itself before ${this.dive.guarded} m: try again soon`);
    return this.desk.flight.write(() => {
      this.lever(order.value);
      return `${order.text}, by hand`;
    });
  }

  /** Puts both pairs of planes in hand at their shares of an angle; each stops at its own limit. @param {number} angle [rad] */
  lever(angle) {
    for (const [name, share, limit] of this.dive.shares) {
      const letter = LETTERS[/** @type {keyof typeof LETTERS} */ (name)];
      const toward = this.desk.boat.toward[name];
      this.set(`ordered_${letter}`, toward * Math.min(Math.max(share * angle, -limit), limit));
      this.set(`${name}_by_hand`, 1);
    }
  }

  /** Begins the dive again: what was flown before is forgotten, because a kiosk runs for days. */
  restart() {
    const { desk } = this;
    desk.pacer.freeze();
    desk.failure = "";
    desk.flight.beginAgain();
    desk.tellFact("back", "restart");
    desk.tellBranches();
    desk.pacer.run();
    return "from the start";
  }

  get byHand() {
    return this.dive.shares.some(([name]) => this.desk.core.get(`${name}_by_hand`));
  }

  /** Whether the planes are the guard's, or are to be. */
  get holds() {
    const { core } = this.desk;
    const { guarded, ahead, given, level } = this.dive;
    const coming = core.get("z") + ahead * Math.max(core.get("zdot"), 0);
    if (this.byHand) return coming > guarded;
    return coming > guarded - given || Math.abs(core.get("theta")) > level;
  }

  /** Takes the planes before the boat is too deep, and gives them back when it is level. */
  guard() {
    if (this.byHand !== this.holds) return;
    const { desk, dive } = this;
    if (this.byHand) desk.steer(desk.grammar.parse(`depth ${dive.guarded - dive.keeps}`));
    else desk.flight.write(() => (this.lever(0), "lever zero"));
  }

  /** @param {string} name @param {number} value */
  set(name, value) {
    const { core } = this.desk;
    core.state[core.boat.places[name]] = value;
  }
}

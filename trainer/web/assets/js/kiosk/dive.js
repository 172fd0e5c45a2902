// One dive of a visitor: what is said to it, and how it went.
import { say } from "../words.js";

const NEAR = 18; // [m] from where the angle is to come off
const HELD = 4; // [m] that count as there
const GOOD = 2; // [m] that a visitor is praised for
const WON = 5; // [s] within them
const FRESH = 20; // [s] of a dive in which an older reading may still be on its way
const STEEP = 12; // [deg] that need not be more
const TILTED = 3; // [deg] that a visitor sees
const RISING = 4; // [deg] of bow up that will bring the boat back by itself

/** @typedef {{ seconds: number, depth: number }} Place */

export class Dive {
  /** @param {number} target [m] */
  constructor(target) {
    this.target = target;
    /** @type {Place[]} */
    this.track = [];
    this.held = 0; // [s]
    this.nearest = target; // [m]
  }

  /**
   * Takes a reading; returns false where time has gone back.
   * @param {number} seconds of the boat's time
   * @param {number} depth [m]
   */
  take(seconds, depth) {
    const last = this.track.at(-1)?.seconds ?? 0;
    if (seconds < last && last > FRESH) return false;
    if (seconds < last) this.track = [];
    const passed = this.track.length ? seconds - last : 0;
    if (passed === 0 && this.track.length) return true;
    this.track.push({ seconds, depth });
    const off = Math.abs(depth - this.target);
    this.nearest = Math.min(this.nearest, off);
    if (off <= GOOD) this.held += passed;
    return true;
  }

  /** What came of it, in one line. */
  get verdict() {
    if (this.held >= WON) return say("You held {0} metres", this.target);
    if (this.nearest <= GOOD) return say("You went past {0} metres", this.target);
    return say("You came within {0} metres", Math.round(this.nearest));
  }

  /** And how it compares. */
  get comparison() {
    const held = say("Within 2 metres for {0} seconds.", Math.round(this.held));
    return `${held} ${say("A trained planesman holds half a metre.")}`;
  }
}

/**
 * Returns the one sentence that helps now.
 * @param {number} target [m]
 * @param {number} depth [m]
 * @param {number} pitch [deg] bow up positive
 */
export function advise(target, depth, pitch) {
  const left = target - depth;
  if (left < -HELD && pitch > RISING) return say("It comes up. Lever to the middle.");
  if (left < -HELD) return say("Too deep. Lift the lever.");
  if (left <= HELD) return say("Hold {0} metres. Small movements.", target);
  if (left <= NEAR) {
    if (pitch < -RISING) return say("Now lift early. It carries on by itself.");
    return say("Almost there. Push the lever down a little.");
  }
  if (pitch < -STEEP) return say("Steep enough. Lift the lever a little.");
  if (pitch < -TILTED) {
    return say("Good. The boat is going down. Do not steepen: 10 degrees are enough.");
  }
  return say("Push the lever down. The planes turn, then the bow goes down.");
}

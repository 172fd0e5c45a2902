// The marks of an exercise, as the session tells them in facts.
import { say } from "../words.js";

/** @typedef {{ seconds: number | null, text: string }} Reason of marks, and the moment it is about */

/** @type {Record<string, string>} */
const OUTCOMES = {
  won: say("won"),
  lost: say("lost"),
  "not reached": say("not reached"),
  "not won": say("not won"),
  ended: say("ended"),
  done: say("done"),
  "not done": say("not done"),
};

/** @type {Record<string, string>} */
const AIDS = { ghost: say("with ghost"), predictor: say("with predictor") };

/** Returns how an exercise has ended, in words. @param {string} outcome as the session tells it */
export function outcomeOf(outcome) {
  return OUTCOMES[outcome] ?? outcome;
}

export class Judgement {
  constructor() {
    this.outcome = ""; // won, lost, not reached; "" until that is told
    this.marks = ""; // in words, "" until they are told
    /** @type {Reason[]} */
    this.reasons = [];
  }

  /** The marks and their reasons, a line each. */
  get lines() {
    return this.marks ? [this.marks, ...this.reasons.map(({ text }) => text)] : [];
  }

  /** Whether a fact is one of these. @param {string} what */
  static takes(what) {
    return what === "marks" || what === "reason";
  }

  /** Takes the marks, or a reason of those told last. @param {string} what @param {string} subject */
  take(what, subject) {
    const [first, ...rest] = subject.split(",");
    const text = rest.join(",");
    if (what === "reason") {
      const known = this.reasons.some((reason) => reason.text === text); // a debrief tells its own each time
      if (!known) this.reasons.push({ seconds: first ? Number(first) : null, text });
      return;
    }
    const [total, ...aids] = rest;
    const marks = total ? say("{0} marks of 100", Math.round(Number(total))) : say("no marks");
    this.outcome = first;
    const told = first ? [outcomeOf(first), marks] : [marks];
    this.marks = [...told, ...aids.map((aid) => AIDS[aid] ?? aid)].join(", ");
    this.reasons = [];
  }
}

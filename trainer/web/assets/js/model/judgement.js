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
    this.total = ""; // the marks as a number, "" for none
    this.marks = ""; // in words, "" until they are told
    /** @type {Reason[]} */
    this.reasons = [];
  }

  /** The marks and their reasons, a line each. */
  get lines() {
    return this.marks ? [this.marks, ...this.reasons.map(({ text }) => text)] : [];
  }

  /** @param {string} subject outcome, total, aids that were used */
  mark(subject) {
    const [outcome, total, ...aids] = subject.split(",");
    const marks = total ? say("{0} marks of 100", Math.round(Number(total))) : say("no marks");
    this.outcome = outcome;
    this.total = total;
    const told = outcome ? [outcomeOf(outcome), marks] : [marks];
    this.marks = [...told, ...aids.map((aid) => AIDS[aid] ?? aid)].join(", ");
    this.reasons = [];
  }

  /** @param {string} subject moment and text of a reason of the marks that were told last */
  explain(subject) {
    const [moment, ...rest] = subject.split(",");
    const text = rest.join(",");
    const known = this.reasons.some((reason) => reason.text === text); // a debrief tells its own each time
    if (!known) this.reasons.push({ seconds: moment ? Number(moment) : null, text });
  }
}

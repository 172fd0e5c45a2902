// The marks of an exercise, as the session tells them in facts.

/** @typedef {{ seconds: number | null, text: string }} Reason of marks, and the moment it is about */

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
      this.reasons.push({ seconds: first ? Number(first) : null, text });
      return;
    }
    const marks = text ? `${Math.round(Number(text))} marks of 100` : "no marks";
    this.outcome = first;
    this.marks = first ? `${first}, ${marks}` : marks;
    this.reasons = [];
  }
}

// The step of a lesson that who trains has before him, as the session tells it in facts.

/**
 * @typedef {{ number: number, count: number, light: string, text: string }} Step
 * @typedef {{ number: number, again: boolean }} Missed a step that was not done, and whether it comes again
 */

export class Lesson {
  /** @type {Step | null} */
  step = null;
  hint = "";
  /** @type {Missed | null} */
  missed = null;
  justMissed = false; // its step is still the one that is shown
  done = false; // the last step is over
  /** @type {string[]} */
  undone = []; // numbers of the steps that were not done, at the end

  /**
   * @param {import("./session.js").Session} session
   * @param {(begun: boolean) => void} show is called after a change; whether a step has begun
   */
  constructor(session, show) {
    session.on("fact", (event) => {
      const { what, subject } = /** @type {CustomEvent} */ (event).detail;
      if (this.take(what, subject)) show(what === "step" && this.step !== null);
    });
  }

  /** Forgets the lesson before this one. */
  forget() {
    this.step = this.missed = null;
    this.hint = "";
    this.justMissed = this.done = false;
    this.undone = [];
  }

  /** Takes a fact; returns whether something has changed. @param {string} what @param {string} subject */
  take(what, subject) {
    if (what === "step") this.begin(subject);
    else if (what === "step-hint") this.hint = subject;
    else if (what === "steps-undone") this.undone = subject.split(",").slice(1);
    else if (what === "step-missed") {
      const [number, next] = subject.split(",");
      this.missed = { number: Number(number), again: next === "again" };
      this.justMissed = true;
    } else if (what === "exercise" && subject.startsWith("title=")) this.forget();
    else return false;
    return true;
  }

  /** @param {string} subject number, count, what to look at, text; 0 after the last */
  begin(subject) {
    const [number, count, light = "", ...text] = subject.split(",");
    this.hint = "";
    this.undone = [];
    if (!this.justMissed) this.missed = null;
    this.justMissed = false;
    this.done = number === "0";
    this.step = this.done ? null : { number: Number(number), count: Number(count), light, text: text.join(",") };
  }
}

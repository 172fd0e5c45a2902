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
    this.show = show;
    session.onFacts({
      step: (subject) => this.begin(subject),
      "step-hint": (hint) => this.change({ hint }),
      "step-missed": (subject) => this.miss(subject),
      "steps-undone": (subject) => this.change({ undone: subject.split(",").slice(1) }),
      exercise: (subject) => subject.startsWith("title=") && this.forget(),
    });
  }

  /** Takes what has changed, and has it shown. @param {Partial<Lesson>} change */
  change(change) {
    Object.assign(this, change);
    this.show(false);
  }

  /** Forgets the lesson before this one. */
  forget() {
    this.change({ step: null, missed: null, hint: "", justMissed: false, done: false, undone: [] });
  }

  /** @param {string} subject number of a step that was not done, and whether it comes again */
  miss(subject) {
    const [number, next] = subject.split(",");
    this.change({ missed: { number: Number(number), again: next === "again" }, justMissed: true });
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
    this.show(!this.done);
  }
}

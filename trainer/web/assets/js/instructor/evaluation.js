// What a careful crew could still earn from here: a bar that nobody but the instructor is sent.
import { clock, one, write } from "../draw.js";
import { say } from "../words.js";

/** @typedef {import("./desk.js").Desk} Desk */
/** @typedef {{ seconds: number, marks: number, soFar: number, outcome: string, branch: string, leftOut: number, beyond: string }} Point */

const OLD = 15; // [s] of exercise time from which the age is told

/** Furnishes the bar. @param {Desk} desk */
export function showEvaluation({ session }) {
  const bar = new EvaluationBar(session);
  session.onFacts({
    attainable: (subject) => bar.take(subject),
    "no-attainable": (why) => bar.refuse(why),
    back: (_order, seconds) => bar.goBack(seconds),
  });
  session.on("exercise", () => bar.begin());
  session.on("tick", () => bar.age());
}

class EvaluationBar {
  /** @param {import("../model/session.js").Session} session */
  constructor(session) {
    this.session = session;
    /** @type {Point[]} on the way that is flown, oldest first */
    this.points = [];
    this.why = ""; // there is no evaluation
    this.title = "";
  }

  /** @param {string} subject */
  take(subject) {
    const [seconds, marks, soFar, outcome, branch, leftOut, beyond = ""] = subject.split(",");
    const point = { seconds: Number(seconds), marks: Number(marks), soFar: Number(soFar), outcome, branch, leftOut: Number(leftOut), beyond };
    this.points = [...this.points.filter((each) => each.seconds < point.seconds), point];
    this.why = "";
    this.draw();
  }

  /** @param {string} why */
  refuse(why) {
    this.why = why;
    this.draw();
  }

  /** @param {number} seconds */
  goBack(seconds) {
    this.points = this.points.filter((each) => each.seconds <= seconds);
    this.draw();
  }

  /** Forgets the exercise before this one; the end of one has marks in the bar's place. */
  begin() {
    const { title = "" } = this.session.exercise;
    if (title !== this.title) {
      this.points = [];
      this.why = "";
    }
    this.title = title;
    this.draw();
  }

  draw() {
    const last = this.points.at(-1);
    one("#evaluation").hidden = !(last || this.why) || this.session.outcome !== "";
    one("#evaluation-bar").hidden = one("#evaluation-name").hidden = Boolean(this.why);
    write(one("#evaluation-marks"), this.why || !last ? "" : String(Math.round(last.marks)));
    if (this.why) write(one("#evaluation-says"), say("No evaluation: {0}", this.why));
    else if (last) this.drawBar(last);
  }

  /** @param {Point} last */
  drawBar(last) {
    const bar = one("#evaluation-bar");
    bar.dataset.outcome = last.outcome;
    bar.setAttribute("aria-valuenow", last.marks.toFixed(0));
    one(".open", bar).style.inlineSize = `${last.marks}%`;
    one(".so-far", bar).style.inlineSize = `${Math.min(last.soFar, last.marks)}%`;
    const end = Math.max(last.seconds, 1);
    const corners = this.points.map(({ seconds, marks }) => `${(100 * seconds) / end},${100 - marks}`);
    one("#evaluation-way polygon").setAttribute("points", `0,100 ${corners.join(" ")} 100,100`);
    this.age();
  }

  /** Says the marks so far, and how old all this is where it is old. */
  age() {
    const last = this.points.at(-1);
    if (!last || this.why) return;
    const { seconds, soFar, branch, leftOut, beyond } = last;
    const age = Math.round(this.session.seconds - seconds);
    const parts = [
      say("so far {0}", Math.round(soFar)),
      say("at {0}", clock(seconds)),
      branch === "1" ? "" : say("branch {0}", branch),
      age > OLD ? say("{0} s ago", age) : "",
      leftOut ? say("left out: {0}", leftOut) : "",
      beyond ? say("not for {0}", beyond) : "",
    ];
    write(one("#evaluation-says"), parts.filter(Boolean).join(" \u00b7 "));
  }
}

// The exercise from its choice to its debrief: cards, briefing, who is ready, outcome and marks.
import { clock, html, one, write } from "../draw.js";
import { limitsInWords, lossInWords } from "../briefing.js";
import { showBeside } from "./desk.js";
import { causesOf } from "../model/causes.js";
import { askAboard } from "./log.js";
import { lapseTo } from "./time.js";
import { say } from "../words.js";

/**
 * @typedef {import("./desk.js").Desk} Desk
 * @typedef {{ title: string, briefing: string, seconds: number | null, hand: string[],
 *   vessel: string }} Lesson
 * @typedef {"briefing" | "choice" | "end"} View
 */

const LOOKED = 2000; // [ms] between looks at who is aboard, before the start
const WIDE = 1000; // [px] from which on the window leaves room beside it
const BACK = "2 min"; // how far `again from` goes where no moment is looked at
const CLOSE = 1; // [s] to the end of its time, from which on that is up

/** Furnishes the window of the exercise. @param {Desk} desk @param {(seconds: number) => void} see */
export function furnishExercise(desk, see) {
  const { session } = desk;
  const pane = new ExerciseWindow(desk, see);
  one("#open-exercise").onclick = () => pane.toggle();
  const title = () => write(one("#title"), session.exercise.title ?? say("Instructor"));
  session.on("exercise", () => {
    title();
    showMission(desk);
    pane.notice();
  });
  for (const what of ["state", "marks"]) session.on(what, () => pane.notice());
  for (const what of ["line", "log"]) session.on(what, () => pane.draw());
  session.onFacts({
    debriefing: (share) => pane.debriefing(share),
    debrief: (file) => pane.debriefed(file, ""),
    "debrief-page": (address) => pane.debriefed(pane.debrief, address),
    ready: () => void pane.lookRound(),
    back: () => pane.goBack(),
  });
  setInterval(() => pane.tend(), LOOKED);
  return pane;
}

/** Shows in one line what wins and what the crew knows. @param {Desk} desk */
function showMission({ session }) {
  const { told } = session;
  const mission = one("#mission");
  const parts = [
    [say("Win"), told.wins?.join(", ")],
    [say("Lose"), told.lost?.map(lossInWords).join(", ")],
    [say("Crew knows"), lessonOf(session.exercise.title)?.briefing],
  ].filter(([, says]) => says);
  mission.hidden = parts.length === 0;
  const words = parts.flatMap(([name, says]) => [html("b", {}, `${name}: `), `${says} `]);
  mission.replaceChildren(...words);
}

/** @type {Lesson[] | null} */
let course = null;

/** Returns the shipped exercises, in the course's order. */
function lessons() {
  course ??= /** @type {Lesson[]} */ (JSON.parse(one("#lessons").textContent ?? "[]"));
  return course;
}

/** @param {string | undefined} title */
function lessonOf(title) {
  return lessons().find((each) => each.title === title);
}

class ExerciseWindow {
  /** @param {Desk} desk @param {(seconds: number) => void} see looks at a moment */
  constructor(desk, see) {
    this.desk = desk;
    this.see = see;
    this.dialog = /** @type {HTMLDialogElement} */ (one("#exercise"));
    /** @type {View} */
    this.view = "briefing";
    this.offered = ""; // for which start or end it has opened by itself
    this.begins = false; // the exercise, as soon as time runs
    this.debrief = "";
    /** @type {number | null} */
    this.written = null; // the share of a debrief that is being written
    this.address = ""; // of the debrief, where this server has it
    this.refusal = ""; // of the last order given at the end
    /** @type {string[]} */
    this.names = []; // of the exercises' files, as `next` tells them
    /** @type {import("../model/stations.js").Aboard[]} */
    this.stations = [];
    this.dialog.onclose = () => one("#open-exercise").setAttribute("aria-expanded", "false");
  }

  /** Opens by itself at the start, and at the end. */
  notice() {
    const { session } = this.desk;
    const { state, outcome, seconds, exercise } = session;
    if (state === "connecting" || state === "lost" || state === "role") {
      this.offered = "";
      return;
    }
    const starts = state === "frozen" && seconds === 0;
    const now = outcome ? `end ${outcome}` : starts ? `start ${exercise.title ?? ""}` : this.offered;
    if (now !== this.offered) {
      this.offered = now;
      this.open(outcome ? "end" : "briefing");
    } else if (this.dialog.open) this.draw();
    const begun = this.begins && state === "running";
    this.begins = starts;
    if (begun) this.dialog.close(); // whoever has let time run
  }

  /** Time has gone back: there is no end any more. */
  goBack() {
    this.debrief = this.address = this.refusal = "";
    if (this.view !== "briefing") { // what has ended goes on, perhaps by another hand
      this.offered = "";
      this.dialog.close();
    }
  }

  /** @param {string} share of a debrief that is written, "" when that has ended */
  debriefing(share) {
    this.written = share ? Number(share) : null;
    this.draw();
  }

  /** @param {string} path of the page that was written @param {string} address at this server, "" for none */
  debriefed(path, address) {
    this.debrief = path;
    this.address = address;
    this.draw();
  }

  toggle() {
    if (this.dialog.open) this.dialog.close();
    else this.open(this.desk.session.outcome ? "end" : "briefing");
  }

  /** @param {View} view */
  open(view) {
    this.view = this.dialog.dataset.view = view;
    if (!this.dialog.open) showBeside(this.dialog);
    one("#open-exercise").setAttribute("aria-expanded", "true");
    this.draw();
    void this.lookRound();
  }

  /** Looks at who is aboard while the briefing is open. */
  tend() {
    if (this.dialog.open && this.view === "briefing" && this.desk.session.joined) void this.lookRound();
  }

  async lookRound() {
    this.stations = await askAboard(this.desk);
    if (this.view === "briefing") this.draw();
  }

  /** Draws the view where it is another than the one that is there. */
  draw() {
    if (!this.dialog.open) return;
    const { body, keys, title } = this[this.view]();
    write(one("#exercise-title"), title);
    replace(one("#exercise-body"), body);
    replace(one("#exercise-keys"), [...keys, this.key(say("Close"), () => this.dialog.close())]);
  }

  /** @param {string} words @param {() => void} click @param {boolean} [main] */
  key(words, click, main = false) {
    return html("button", { type: "button", class: main ? "main" : "", click }, words);
  }

  briefing() {
    const { session } = this.desk;
    const { exercise, told } = session;
    const stands = session.word("time.time") === "frozen" && !session.outcome;
    const choose = this.key(say("Choose another"), () => void this.choose());
    const run = this.key(say("Run"), () => void this.run(), true);
    const end = this.key(say("End exercise"), () => void this.desk.give("end exercise"));
    const others = session.alone ? [] : [choose, ...(session.outcome ? [] : [end])];
    const keys = [...(stands ? [run] : []), ...others];
    if (!exercise.title) {
      const says = say("The boat sails freely: there is no exercise.");
      return { title: say("No exercise"), body: [html("p", {}, says), ...this.aboard()], keys };
    }
    const crew = lessonOf(exercise.title)?.briefing ?? "";
    const lines = (told.line ?? []).filter((line) => !crew.includes(line.trim()));
    const sides = html(
      "div",
      { class: "sides" },
      column(say("The crew is told"), [crew || say("what its stations show")]),
      column(say("You alone are told"), lines.length ? [lines.join(" ")] : [say("nothing more")]),
    );
    const rules = [
      [say("Wins"), told.wins?.join(", ")],
      [say("Loses"), told.lost?.map(lossInWords).join(", ")],
      [say("By hand"), exercise.hand?.replaceAll(",", ", ")],
      [say("Limits"), limitsInWords(exercise.limits)],
    ];
    return { title: exercise.title, body: [sides, table(rules), ...this.aboard()], keys };
  }

  /** Returns who is aboard, and who is ready, where anybody can be. */
  aboard() {
    if (this.desk.session.alone) return [];
    const crew = this.stations.filter(({ role }) => role !== "instructor");
    const rows = crew.map(({ role, line, ready }) => {
      return html("li", {}, html("b", {}, role), ready ? say(" at {0}: ready", line) : say(" at {0}: not ready yet", line));
    });
    const none = html("li", {}, say("No station. The exercise can be flown from here."));
    const list = html("ul", {}, ...(rows.length ? rows : [none]));
    return [html("section", {}, html("h3", {}, say("Aboard")), list)];
  }

  async run() {
    await this.desk.give("run"); // it closes when time runs
  }

  /** Asks for the names of the exercises, and shows the cards. */
  async choose() {
    this.names = (await this.desk.session.ask("next")).lines;
    this.open("choice");
  }

  choice() {
    const cards = lessons().map((lesson, at) => this.card(lesson, this.names[at]));
    const back = this.key(say("Back"), () => this.open(this.desk.session.outcome ? "end" : "briefing"));
    return { title: say("Choose an exercise"), body: [html("div", { class: "cards" }, ...cards)], keys: [back] };
  }

  /** @param {Lesson} lesson @param {string | undefined} name */
  card({ title, briefing, seconds, hand, vessel }, name) {
    const facts = [
      seconds === null ? say("no end") : say("{0} min", Math.round(seconds / 60)),
      vessel.toUpperCase(),
      hand.length ? say("by hand: {0}", hand.join(", ")) : say("automatic"),
    ];
    const click = () => void this.begin(name ?? "");
    const parts = [html("b", {}, title), html("small", {}, facts.join(" \u00b7 ")), html("span", {}, briefing)];
    return html("button", { type: "button", class: "card", disabled: !name, click }, ...parts);
  }

  /** Ends this exercise where it is not over, and begins another. @param {string} name */
  async begin(name) {
    const { session } = this.desk;
    if (!session.outcome && !(await this.desk.give("end exercise")).ok) return;
    this.view = "briefing";
    await this.desk.give(`next ${name}`);
  }

  end() {
    const { session } = this.desk;
    const { judgement } = session;
    const reasons = judgement.reasons.map((reason) => html("li", { class: "row" }, html("span", { class: "grow" }, reason.text), this.seeKey(reason)));
    const body = [
      html("p", { class: "big" }, judgement.marks || say("No marks yet.")),
      html("ul", { class: "marks" }, ...reasons),
      html("h3", {}, say("See")),
      html("div", { class: "row" }, ...this.moments()),
      this.debrief && this.debriefLine(),
      this.written !== null && html("p", { class: "path" }, say("The debrief is being written: {0} %", Math.round(100 * this.written))),
    ].filter((part) => part instanceof Node);
    const back = this.desk.moment.looking;
    const keys = [
      ...(judgement.reasons.length ? [this.key(say("Release marks"), () => void this.order("release marks"))] : []),
      this.key(say("Debrief"), () => void this.order("debrief")),
      ...(this.refusal ? [html("span", { class: "refusal", role: "alert" }, this.refusal)] : []),
      this.key(say("Again"), () => void this.desk.give("again"), true),
      this.key(back ? say("Again from {0}", clock(back.seconds)) : say("Again from {0} ago", BACK), () => void this.again()),
      this.key(say("Next"), () => void this.choose()),
    ];
    return { title: `${session.exercise.title ?? say("Exercise")}: ${endInWords(session)}`, body, keys };
  }

  /** Gives an order; a refusal is shown beside the keys. @param {string} words */
  async order(words) {
    const answer = await this.desk.give(words);
    this.refusal = answer.ok ? "" : answer.text;
    this.draw();
  }

  /** Returns where the debrief is: a key that opens it, or on which machine it lies. */
  debriefLine() {
    const { debrief, address } = this;
    if (!address) return html("p", { class: "path" }, say("The debrief lies on the session's machine: {0}", debrief));
    const key = html("a", { class: "key", href: address, target: "_blank", rel: "noopener" }, say("Open the debrief"));
    return html("p", { class: "path row" }, key, html("span", { class: "grow" }, debrief));
  }

  /** Returns a key that looks at the moment of a reason. @param {import("../model/judgement.js").Reason} reason */
  seeKey({ seconds }) {
    return seconds === null ? null : this.moment(seconds, say("See"));
  }

  /** @param {number} seconds @param {string} words */
  moment(seconds, words) {
    return this.key(`${words} ${clock(seconds)}`, () => {
      this.see(seconds);
      if (innerWidth < WIDE) this.dialog.close(); // it covers what is to be seen
    });
  }

  /** Returns keys for what broke and its first answer, the limits passed, and what was marked. */
  moments() {
    const { session } = this.desk;
    const marks = session.signs.kept.filter(({ sign }) => sign === "M");
    const found = [...causesOf(session), ...marks.map(({ seconds, text }) => ({ seconds, words: text }))];
    found.sort((a, b) => a.seconds - b.seconds);
    return found.slice(0, 12).map(({ seconds, words }) => this.moment(seconds, words));
  }

  /** Begins again from the moment that is looked at, or from a while ago. */
  async again() {
    const { looking } = this.desk.moment;
    const lapse = looking ? await lapseTo(this.desk, looking) : null;
    if (looking && lapse === null) return;
    await this.desk.give(lapse === null ? `again from ${BACK}` : `again from ${Math.max(lapse, 0.1)}`);
  }
}

/** Returns how an exercise has ended: its time is up only where it has come to it. @param {import("../model/session.js").Session} session */
function endInWords({ exercise, judgement, outcome, seconds }) {
  if (judgement.outcome === "won") return say("WON");
  if (outcome === "lost") return say("LOST");
  return seconds > Number(exercise.duration ?? Infinity) - CLOSE ? say("TIME IS UP") : say("OVER");
}

/** @param {string} title @param {string[]} lines */
function column(title, lines) {
  return html("section", {}, html("h3", {}, title), ...lines.map((line) => html("p", {}, line)));
}

/** @param {(string | undefined)[][]} rows */
function table(rows) {
  const there = rows.filter(([, says]) => says);
  const cells = there.map(([name, says]) => html("tr", {}, html("th", { scope: "row" }, name ?? ""), html("td", {}, says ?? "")));
  return html("table", { class: "rules" }, html("tbody", {}, ...cells));
}

/** Replaces children where they would look otherwise, so that a key keeps the focus. @param {Element} parent @param {Node[]} children */
function replace(parent, children) {
  const before = parent.children;
  const same =
    before.length === children.length &&
    children.every((child, at) => /** @type {Element} */ (child).outerHTML === before[at].outerHTML);
  if (!same) parent.replaceChildren(...children);
}

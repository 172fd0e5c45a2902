// What who trains alone may do before an exercise and after it.
import { clock, html, one, write } from "../draw.js";
import { say } from "../words.js";

const LEAD = 15; // [s] before what went wrong, from where it is flown again
/** @type {any} */
const DONE = { done: say("done"), begun: say("begun") }; // a lesson has no marks
const DEAF = 1000; // [ms] after the end in which keys are the boat's

/** Furnishes the keys in the window of the briefing. @param {import("../model/session.js").Session} session */
export function furnishCourse(session) {
  const dialog = /** @type {HTMLDialogElement} */ (one("#briefing"));
  const [begin, next, again, wrong] = ["#begin", "#next", "#again", "#from-wrong"].map((id) => one(id));
  const lessons = /** @type {HTMLDetailsElement} */ (one("#lessons"));
  let ended = -DEAF; // [ms] when the end was told
  const order = async (/** @type {string[]} */ ...orders) => {
    if (performance.now() - ended < DEAF) return;
    for (const words of orders) {
      const answer = await session.order(words);
      one("#course-refusal").hidden = answer.ok;
      write(one("#course-refusal"), answer.ok ? "" : answer.text);
      if (!answer.ok) return;
    }
    dialog.close();
    /** @type {HTMLElement} */ (document.activeElement)?.blur(); // Enter is for the boat again
  };
  const begun = () => session.exercise.title || session.seconds > 0;
  const lead = (/** @type {string} */ word) =>
    void order(...(begun() && !session.outcome ? ["end exercise"] : []), `next ${word}`);
  const [led, marked] = lessons.querySelectorAll(".keys");
  for (const each of JSON.parse(one("#offered").textContent ?? "[]")) {
    (each.steps ? led : marked).append(keyOf(each, () => lead(each.word)));
  }
  let picked = new URLSearchParams(location.search).get("begin"); // on the first page
  const show = () => {
    const { outcome, exercise, judgement } = session;
    const undone = Boolean(exercise.steps) && outcome !== "done"; // of a lesson that is over
    const there = [begin, next, again].map((key) => key.hidden);
    if (outcome && again.hidden) ended = performance.now();
    begin.hidden = session.state !== "frozen" || session.seconds > 0;
    write(begin, exercise.title ? say("Begin") : say("Sail freely"));
    if (picked && session.state) {
      if (!begun()) lead(picked);
      picked = null;
    }
    again.hidden = !outcome;
    next.hidden = again.hidden || (undone && !exercise.course); // the list below leads on all the same
    if (outcome && undone) lessons.open = true;
    const moment = judgement.reasons.find(({ seconds }) => seconds !== null)?.seconds ?? null;
    const from = Math.max((moment ?? 0) - LEAD, 0);
    wrong.hidden = !outcome || moment === null;
    write(wrong, say("Again from {0}, where it went wrong", clock(from)));
    wrong.onclick = () => void order(`again from ${Math.max(session.seconds - from, 1).toFixed(0)} s`);
    showDone(session, lessons);
    if (!exercise.title) lessons.open = true;
    const shown = [begin, next, again].find((key, at) => there[at] && !key.hidden);
    const key = exercise.title ? shown : shown && one("[aria-current=step]", lessons);
    if (dialog.open) key?.focus(); // Enter goes on
  };
  begin.onclick = () => void order("run");
  next.onclick = () => void order("next");
  again.onclick = () => void order("again");
  for (const what of ["exercise", "marks", "state"]) session.on(what, show);
}

/** Returns the key of a lesson or an exercise. @param {any} of @param {() => void} click */
function keyOf({ word, title, steps, seconds, hand }, click) {
  const length = steps ? say("{0} steps", steps) : [say("{0} min", Math.round(seconds / 60)), ...hand].join(", ");
  const small = html("small", {}, length, html("span", { "data-done": "" }));
  return html("button", { type: "button", "data-name": word, click }, html("b", {}, title), " ", small);
}

/** Shows what is passed, and chooses the next. @param {any} session @param {HTMLElement} lessons */
function showDone({ exercise }, lessons) {
  const keys = lessons.querySelectorAll("[data-name]");
  /** @type {string[][]} */
  const told = (exercise.done?.split(",") ?? []).map((/** @type {any} */ each) => each.split(":"));
  for (const [word, how, passed] of told) {
    const marks = passed ? say("passed, {0} marks of 100", how) : say("{0} marks of 100", how);
    write(one(`[data-name="${word}"] [data-done]`, lessons), `, ${DONE[how] ?? marks}`);
  }
  for (const key of keys) {
    const next = /** @type {HTMLElement} */ (key).dataset.name === exercise.suggested;
    key.setAttribute("aria-current", next ? "step" : "false");
  }
  const done = told.filter((each) => each[2]).length;
  if (done) write(one("summary", lessons), say("{0} of {1} passed; the next is chosen", done, keys.length));
}

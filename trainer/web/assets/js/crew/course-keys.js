// What who trains alone may do before an exercise and after it: begin, the next, again, from where it went wrong.
import { clock, html, one, write } from "../draw.js";
import { say } from "../words.js";

const LEAD = 15; // [s] before a moment that went wrong, from where it is flown again
const DONE = { done: say("done"), begun: say("begun") }; // a lesson has no marks
const DEAF = 1000; // [ms] after the end in which a key that was meant for the boat does nothing

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
  const lead = (/** @type {string} */ name) => void order(...(session.outcome ? [] : ["end exercise"]), `next ${name}`);
  const offered = /** @type {{ name: string, title: string, steps: number }[]} */ (JSON.parse(one("#led-lessons").textContent ?? "[]"));
  one(".keys", lessons).append(
    ...offered.map(({ name, title, steps }) =>
      html(
        "button",
        { type: "button", "data-name": name, click: () => lead(name) },
        html("b", {}, title),
        " ",
        html("small", {}, say("{0} steps", steps), html("span", { "data-done": "" })),
      ),
    ),
  );
  const showDone = () => {
    for (const each of (session.exercise.done ?? "").split(",").filter(Boolean)) {
      const [name, how] = /** @type {[string, keyof typeof DONE]} */ (each.split(":"));
      write(one(`[data-name="${name}"] [data-done]`, lessons), `, ${DONE[how]}`);
    }
    chooseNext(session, lessons, offered.map(({ name }) => name));
  };
  const show = () => {
    const { outcome, exercise, judgement } = session;
    const undone = Boolean(exercise.steps) && outcome !== "done"; // of a lesson that is over
    const there = [begin, next, again].map((key) => key.hidden);
    if (outcome && again.hidden) ended = performance.now();
    begin.hidden = session.state !== "frozen" || session.seconds > 0;
    again.hidden = !outcome;
    next.hidden = again.hidden || (undone && !exercise.course); // the list below leads on all the same
    if (outcome && undone) lessons.open = true;
    const moment = judgement.reasons.find(({ seconds }) => seconds !== null)?.seconds ?? null;
    const from = Math.max((moment ?? 0) - LEAD, 0);
    wrong.hidden = !outcome || moment === null;
    write(wrong, say("Again from {0}, where it went wrong", clock(from)));
    wrong.onclick = () => void order(`again from ${Math.max(session.seconds - from, 1).toFixed(0)} s`);
    showDone();
    if (!exercise.title) lessons.open = true;
    const shown = [begin, next, again].find((key, at) => there[at] && !key.hidden);
    if (dialog.open) shown?.focus(); // Enter goes on
  };
  begin.onclick = () => void order("run");
  next.onclick = () => void order("next");
  again.onclick = () => void order("again");
  for (const what of ["exercise", "marks", "state"]) session.on(what, show);
}

/**
 * Chooses the first lesson that is not done, as the terminal's list does.
 * @param {import("../model/session.js").Session} session
 * @param {HTMLElement} lessons
 * @param {string[]} offered names
 */
function chooseNext({ exercise }, lessons, offered) {
  const told = (exercise.done ?? "").split(",").map((each) => each.split(":"));
  const done = told.filter(([, how]) => how === "done").map(([name]) => name);
  const first = offered.find((name) => !done.includes(name));
  for (const key of lessons.querySelectorAll("[data-name]")) {
    const chosen = /** @type {HTMLElement} */ (key).dataset.name === first;
    key.classList.toggle("main", chosen);
    if (chosen) key.setAttribute("aria-current", "step");
    else key.removeAttribute("aria-current");
  }
  if (done.length) write(one("summary", lessons), say("Lessons: {0} of {1} done; the next is chosen", done.length, offered.length));
}

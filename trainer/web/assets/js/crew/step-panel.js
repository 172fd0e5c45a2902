// A lesson's step on a page: its words, hint and progress, and a ring about the instrument to look at.
import { html, one, write } from "../draw.js";
import { Lesson } from "../model/lesson.js";
import { say } from "../words.js";

/**
 * The instruments that a step may light up: where each is, on which part of the page, its name.
 * @type {Record<string, { place: string, part: string, name: string }>}
 */
const LIGHTS = {
  depth: { place: ".panel.depth:not(.group)", part: "dive", name: say("depth") },
  heading: { place: ".panel.course", part: "steer", name: say("heading") },
  speed: { place: ".panel.telegraph", part: "steer", name: say("speed") },
  pitch: { place: ".panel.pitch", part: "dive", name: say("pitch") },
  rudder: { place: ".panel.rudder", part: "steer", name: say("rudder") },
  stern: { place: ".panel.stern", part: "dive", name: say("stern planes") },
  bow: { place: ".panel.bow", part: "dive", name: say("bow planes") },
  bell: { place: ".panel.telegraph", part: "steer", name: say("engine") },
  tanks: { place: ".panel.picture", part: "tanks", name: say("tanks") },
};

/** What works each axis, which is dimmed in a lesson that leaves it to others. @type {Record<string, string>} */
const WORKED = {
  rudder: ".panel.rudder",
  planes: ".panel.planes",
  ballast: ".panel.group",
};

/**
 * Shows the steps. Orders in backquotes of a text are keys that give them.
 * @param {import("../model/session.js").Session} session
 * @param {(words: string) => void} give
 * @param {(part: string) => void} choose shows a part of the page, where there is no room for all
 */
export function furnishSteps(session, give, choose) {
  const lesson = new Lesson(session, (begun) => {
    const { step, hint, missed, done, undone } = lesson;
    const end = undone.length ? say("Steps not done: {0}.", undone.join(", ")) : say("The last step is done.");
    const { place, part, name } = LIGHTS[step?.light ?? ""] ?? { place: "", part: "", name: "" };
    one("#lesson").hidden = !step && !done;
    write(one("#lesson-head"), step ? say("Step {0} of {1}", step.number, step.count) : end);
    write(one("#lesson-light"), name && say("look at: {0}", name));
    const progress = /** @type {HTMLProgressElement} */ (one("#lesson-progress"));
    if (step) progress.max = step.count;
    progress.value = step ? step.number - 1 : progress.max - undone.length;
    one("#lesson-text").replaceChildren(...parts(step?.text ?? "", give));
    fill("#lesson-hint", hint && say("Hint: {0}", hint));
    fill("#lesson-missed", missed ? missedInWords(missed) : "");
    for (const each of document.querySelectorAll("[data-lit]")) each.removeAttribute("data-lit");
    if (place) for (const each of document.querySelectorAll(`${place}, part-keys [data-name=${part}]`)) each.setAttribute("data-lit", "");
    const hand = (session.exercise.hand ?? "").split(",");
    for (const [axis, panels] of Object.entries(WORKED)) {
      for (const each of document.querySelectorAll(panels)) {
        each.toggleAttribute("data-dim", Boolean(step) && !hand.includes(axis) && !each.hasAttribute("data-lit"));
      }
    }
    if (begun && part) choose(part);
  });
}

/** Returns a text in which what is to be typed is a key. @param {string} text @param {(words: string) => void} give */
function parts(text, give) {
  const order = (/** @type {string} */ words) => html("button", { type: "button", "data-control": true, click: () => give(words) }, words);
  return text.split("`").map((part, at) => (at % 2 ? order(part) : part));
}

/** @param {string} selector @param {string} text */
function fill(selector, text) {
  one(selector).hidden = !text;
  write(one(selector), text);
}

/** @param {import("../model/lesson.js").Missed} missed */
function missedInWords({ number, again }) {
  return again
    ? say("Step {0} was not done in its time: once more, from its beginning.", number)
    : say("Step {0} was not done in its time: on to the next.", number);
}

// The keys of the page. None acts while a field, or a control that has its own keys, has the focus.
import { isTyping } from "../frame.js";
import { one } from "../draw.js";

/**
 * @typedef {{ toggleTime: () => void, step: () => void, mark: () => void, span: (by: number) => void,
 *   drawer: () => void, move: (by: number) => void, cause: (later: boolean) => void,
 *   now: () => void }} Deeds
 */

const OWN = "button, a, [role='slider'], [role='tab'], summary";
const MOVES = { ArrowLeft: -1, ArrowRight: 1, PageUp: -30, PageDown: 30 }; // [s]

/** Listens to the keys. @param {Deeds} deeds */
export function listenToKeys(deeds) {
  /** @type {Record<string, () => void>} */
  const acts = {
    ".": deeds.step,
    b: () => one("#find").focus(),
    m: deeds.mark,
    "/": () => one("#order").focus(),
    "[": () => deeds.span(-1),
    "]": () => deeds.span(1),
    l: deeds.drawer,
    c: () => deeds.cause(true),
    C: () => deeds.cause(false),
    Escape: () => (closeWindow() ? undefined : deeds.now()),
  };
  addEventListener("keydown", (event) => {
    if (isTyping(event) || document.querySelector("dialog:modal")) return;
    const own = /** @type {Element} */ (event.target).closest(OWN);
    const by = MOVES[/** @type {keyof typeof MOVES} */ (event.key)];
    const act = event.key === " " && !own ? deeds.toggleTime : acts[event.key] ?? acts[event.key.toLowerCase()];
    if (by && !scrolls(event)) deeds.move(by);
    else if (act && event.key.length === 1) act();
    else if (event.key === "Escape") acts.Escape();
    else return;
    event.preventDefault();
  });
}

/** Whether a key belongs to a list that it scrolls, or to tabs. @param {KeyboardEvent} event */
function scrolls(event) {
  return Boolean(/** @type {Element} */ (event.target).closest(".scroll, [role='tab']"));
}

/** Closes the window that is open; tells whether there was one. */
function closeWindow() {
  const open = /** @type {HTMLDialogElement | null} */ (document.querySelector("dialog[open]"));
  open?.close();
  return Boolean(open);
}

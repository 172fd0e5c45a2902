// The telegraph: ahead is up; the chosen stop in a frame, the engine room's answer beside it.
import { html } from "../draw.js";
import { bellOf } from "./bells.js";
import { say } from "../words.js";

/** @type {Record<string, string>} */
const SHORT = {
  flank: say("Flank"),
  full: say("Full"),
  standard: say("Std"),
  "two-thirds": "2/3",
  "one-third": "1/3",
  stop: say("STOP"),
};

/** Dispatches `order` (detail: the bell as it is ordered, such as `ahead full`). */
class OrderTelegraph extends HTMLElement {
  /** @type {[string, number][]} */
  bells = [];
  /** @type {HTMLElement[]} */
  keys = [];
  chosen = "";
  answered = "";
  /** @type {HTMLElement | null} where a hand that slides is now */
  under = null;

  connectedCallback() {
    this.setAttribute("role", "radiogroup");
    this.addEventListener("pointerdown", (event) => this.slide(event));
  }

  /** The bells of the boat and their turns [kn]; the fastest ahead stands at the top. */
  get stops() {
    return this.bells;
  }

  set stops(bells) {
    if (JSON.stringify(bells) === JSON.stringify(this.bells)) return;
    this.bells = [...bells];
    const sorted = [...bells].sort((a, b) => b[1] - a[1]);
    this.keys = sorted.map(([bell]) => this.key(bell));
    const [ahead, astern] = [say("AHEAD"), say("ASTERN")].map((way) => html("span", { class: "end" }, way));
    this.replaceChildren(ahead, ...this.keys, astern);
    this.mark();
  }

  /** @param {string} bell */
  key(bell) {
    const short = SHORT[bell.split(" ").at(-1) ?? ""] ?? bellOf(bell);
    return html(
      "button",
      {
        type: "button",
        role: "radio",
        "aria-label": bellOf(bell),
        "data-bell": bell,
        class: bell.split(" ")[0],
        keydown: (event) => this.press(/** @type {KeyboardEvent} */ (event)),
        click: (event) => {
          if (/** @type {MouseEvent} */ (event).detail === 0) this.ring(bell); // by the keyboard
        },
      },
      html("span", { class: "answer" }),
      short,
    );
  }

  /** Follows a hand across the stops; only where it ends is ordered. @param {PointerEvent} event */
  slide(event) {
    if (event.button > 0) return;
    const find = (/** @type {PointerEvent} */ at) => {
      const found = document.elementFromPoint(at.clientX, at.clientY)?.closest("[data-bell]");
      return found && this.contains(found) ? /** @type {HTMLElement} */ (found) : null;
    };
    const move = (/** @type {PointerEvent} */ at) => {
      this.under?.classList.remove("under");
      this.under = find(at);
      this.under?.classList.add("under");
    };
    const end = (/** @type {PointerEvent} */ at) => {
      move(at);
      removeEventListener("pointermove", move);
      removeEventListener("pointerup", end);
      removeEventListener("pointercancel", end);
      const bell = at.type === "pointerup" ? this.under?.dataset.bell : "";
      this.under?.classList.remove("under");
      if (bell) this.ring(bell);
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", end);
    addEventListener("pointercancel", end);
    move(event);
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    const by = { ArrowUp: -1, ArrowLeft: -1, ArrowDown: 1, ArrowRight: 1 }[event.key];
    const at = this.keys.indexOf(/** @type {HTMLElement} */ (event.currentTarget));
    const next = by && this.keys[at + by];
    if (!next) return;
    event.preventDefault();
    event.stopPropagation();
    next.focus();
    this.ring(next.dataset.bell ?? "");
  }

  /** @param {string} bell */
  ring(bell) {
    this.chosen = bell;
    this.mark();
    this.dispatchEvent(new CustomEvent("order", { detail: bell, bubbles: true }));
  }

  /** @param {string} bell as it is ordered @param {boolean} answered whether the engine does it */
  show(bell, answered) {
    this.chosen = bell;
    if (answered || !bell) this.answered = bell;
    this.mark();
  }

  mark() {
    const { keys } = this;
    const first = keys.find((key) => key.dataset.bell === this.chosen) ?? keys[0];
    for (const key of keys) {
      const chosen = key.dataset.bell === this.chosen;
      key.setAttribute("aria-checked", String(chosen));
      key.tabIndex = key === first ? 0 : -1;
      key.classList.toggle("answered", key.dataset.bell === this.answered);
    }
  }
}

customElements.define("order-telegraph", OrderTelegraph);

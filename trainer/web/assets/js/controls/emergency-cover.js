// A push under a cover, for what must not be done by mistake: lift the cover, then push.
import { html, write } from "../draw.js";
import { say } from "../words.js";

const OPEN = 5; // [s] until the cover falls shut again
const GUARD = 0.4; // [s] in which the second tap of two is not a push yet

/** `<emergency-cover label="Emergency blow">`: event `order` when it is pushed. */
class EmergencyCover extends HTMLElement {
  #cover = html("button", { type: "button", class: "cover", click: () => this.#lift() });
  #push = html("button", { type: "button", class: "push", click: () => this.#fire() });
  #left = html("span", { class: "left" });
  #until = 0; // [ms]
  #timer = 0;

  connectedCallback() {
    if (this.firstChild) return;
    const label = this.getAttribute("label") ?? say("Emergency");
    this.#cover.append(html("b", {}, label), html("span", {}, say("lift the cover")));
    this.#push.append(html("b", {}, label), this.#left);
    this.#cover.onpointerdown = (event) => this.#slide(event);
    this.append(this.#push, this.#cover);
    this.#close();
  }

  disconnectedCallback() {
    clearInterval(this.#timer);
  }

  /** A slide upwards lifts the cover, as a tap does. @param {PointerEvent} event */
  #slide(event) {
    const least = this.clientHeight / 3;
    const move = (/** @type {PointerEvent} */ next) => {
      if (Math.abs(next.clientY - event.clientY) > least) this.#lift();
    };
    this.#cover.setPointerCapture(event.pointerId);
    this.#cover.addEventListener("pointermove", move);
    this.#cover.onlostpointercapture = () => this.#cover.removeEventListener("pointermove", move);
  }

  #lift() {
    if (this.hasAttribute("open")) return;
    this.setAttribute("open", "");
    this.#cover.setAttribute("disabled", "");
    this.#until = performance.now() + OPEN * 1000;
    this.#timer = setInterval(() => this.#count(), 100);
    this.#count();
  }

  #count() {
    const left = (this.#until - performance.now()) / 1000;
    write(this.#left, say("push: shuts in {0} s", Math.ceil(left)));
    if (left <= OPEN - GUARD && this.#push.hasAttribute("disabled")) {
      this.#push.removeAttribute("disabled");
      this.#push.focus();
    }
    if (left <= 0) this.#close();
  }

  #close() {
    clearInterval(this.#timer);
    const focused = document.activeElement === this.#push;
    this.removeAttribute("open");
    this.#push.setAttribute("disabled", "");
    this.#cover.removeAttribute("disabled");
    if (focused) this.#cover.focus();
  }

  #fire() {
    this.#close();
    this.dispatchEvent(new CustomEvent("order", { bubbles: true }));
  }
}

customElements.define("emergency-cover", EmergencyCover);

// A lever for rudder or planes: drag it, tap its groove, or use the arrow keys.
import { html, write } from "../draw.js";
import { clamp } from "../gauges/gauge.js";

const USUAL = 30; // [deg]
const DETENT = 1.5; // [deg] about zero
const OFTEN = 100; // [ms] between two orders at least
const MARGIN = 7; // [%] of the slot at either end
/** @type {Record<string, number>} degrees of each key; with Shift five times */
const KEYS = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 5, PageDown: -5 };

/**
 * Dispatches `order` (detail: degrees): at most ten a second, the last one always.
 * Attributes: `name`, `label`, `low`, `high`, `upright`.
 */
class OrderLever extends HTMLElement {
  most = USUAL; // [deg] the largest angle either way

  connectedCallback() {
    if (this.firstChild) return;
    this.value = 0;
    this.held = false;
    this.sent = -Infinity;
    this.due = 0;
    /** @type {number | null} what a hand has chosen since the order was last shown */
    this.chosen = null;
    this.mark = html("div", { class: "mark" });
    this.knob = html("div", {
      class: "knob",
      role: "slider",
      tabindex: 0,
      "aria-label": this.getAttribute("label") ?? "",
      "aria-orientation": this.upright ? "vertical" : "horizontal",
      keydown: (event) => this.press(/** @type {KeyboardEvent} */ (event)),
    });
    this.steps = html("div", { class: "steps", "aria-hidden": "true" });
    this.groove = html(
      "div",
      { class: "slot", pointerdown: (event) => this.grab(/** @type {PointerEvent} */ (event)) },
      html("div", { class: "groove" }),
      this.steps,
      this.mark,
      this.knob,
    );
    const [low, high] = this.ends;
    this.append(
      html("span", { class: "end" }, low),
      this.groove,
      html("span", { class: "end" }, high),
    );
    this.limit = Number(this.getAttribute("limit") ?? USUAL);
    this.set(0);
  }

  get upright() {
    return this.hasAttribute("upright");
  }

  get ends() {
    return [this.getAttribute("low") ?? "left", this.getAttribute("high") ?? "right"];
  }

  /** The largest angle either way [deg]. */
  get limit() {
    return this.most;
  }

  set limit(most) {
    this.most = most;
    this.knob?.setAttribute("aria-valuemin", String(-most));
    this.knob?.setAttribute("aria-valuemax", String(most));
    const values = [];
    for (let value = 0; value <= most; value += 10) values.push(value, -value);
    const steps = [...new Set(values)].map((value) => {
      const step = html("span", { class: "step" }, String(Math.abs(value)));
      this.place(step, value);
      return step;
    });
    this.steps?.replaceChildren(...steps);
  }

  /** Returns a value in words. @param {number} value */
  words(value) {
    const [low, high] = this.ends;
    return value === 0 ? "zero" : `${Math.abs(value)} ${value < 0 ? low : high}`;
  }

  /** @param {HTMLElement} part @param {number} value */
  place(part, value) {
    const share = (50 + (50 * value) / this.limit) * (1 - (2 * MARGIN) / 100) + MARGIN;
    if (this.upright) part.style.top = `${100 - share}%`;
    else part.style.left = `${share}%`;
  }

  /** Puts the knob to a value. @param {number} value */
  set(value) {
    if (!this.knob) return;
    this.value = clamp(Math.round(value), -this.limit, this.limit) || 0;
    this.place(this.knob, this.value);
    write(this.knob, String(Math.abs(this.value)));
    this.knob.setAttribute("aria-valuenow", String(this.value));
    this.knob.setAttribute("aria-valuetext", this.words(this.value));
  }

  /** Puts the knob to a value that a hand has chosen, and orders it. @param {number} value */
  choose(value) {
    this.set(value);
    if (this.value === this.chosen) return;
    this.chosen = this.value ?? 0;
    this.send();
  }

  /** Orders the value, now or as soon as it may. */
  send() {
    if (this.due) return;
    const wait = Math.max(0, (this.sent ?? 0) + OFTEN - performance.now());
    const order = () => {
      this.due = 0;
      this.sent = performance.now();
      this.dispatchEvent(new CustomEvent("order", { detail: this.value, bubbles: true }));
    };
    if (wait) this.due = window.setTimeout(order, wait);
    else order();
  }

  /**
   * @param {number | null} actual [deg]
   * @param {number | null} ordered [deg]
   * @param {string} [mode] `hand`, or what steers the surface
   * @param {boolean} [waits] whether the order still waits for its answer
   */
  show(actual, ordered, mode = "hand", waits = false) {
    if (!this.mark) return;
    this.mark.hidden = actual === null;
    if (actual !== null) this.place(this.mark, clamp(actual, -this.limit, this.limit));
    this.classList.toggle("automatic", mode !== "hand");
    this.classList.toggle("asking", waits || this.due !== 0);
    if (this.held || this.due || waits) return;
    this.chosen = null;
    if (ordered !== null && Math.round(ordered) !== this.value) this.set(ordered);
  }

  /** Returns the value at a place of the slot. @param {PointerEvent} event */
  read(event) {
    const box = /** @type {HTMLElement} */ (this.groove).getBoundingClientRect();
    const along = this.upright
      ? 1 - (event.clientY - box.top) / box.height
      : (event.clientX - box.left) / box.width;
    const value = (((along * 100 - MARGIN) / (1 - (2 * MARGIN) / 100) - 50) / 50) * this.limit;
    return Math.abs(value) < DETENT ? 0 : value;
  }

  /** @param {PointerEvent} event */
  grab(event) {
    const { groove } = this;
    if (!groove || event.button > 0) return;
    event.preventDefault();
    this.held = true;
    groove.setPointerCapture(event.pointerId);
    this.knob?.focus();
    const move = (/** @type {Event} */ moved) =>
      this.choose(this.read(/** @type {PointerEvent} */ (moved)));
    const leave = () => {
      this.held = false;
      groove.removeEventListener("pointermove", move);
    };
    groove.addEventListener("pointermove", move);
    for (const end of ["pointerup", "pointercancel"]) {
      groove.addEventListener(end, leave, { once: true });
    }
    move(event);
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    const by = KEYS[event.key] * (event.shiftKey ? 5 : 1);
    if (event.key === "Home") this.choose(0);
    else if (by) this.choose((this.value ?? 0) + by);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
}

customElements.define("order-lever", OrderLever);

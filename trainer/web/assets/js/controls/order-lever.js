// A lever for rudder or planes, on one scale with the dial inside it: it is held, not hit.
import "../gauges/angle-dial.js";
import { html, sidedOrder, svg, tenths, write } from "../draw.js";
import { Fan } from "../gauges/fan.js";
import { clamp, readable } from "../gauges/gauge.js";
import { OFF } from "../model/alerts.js";
import { say } from "../words.js";

const USUAL = 30; // [deg]
const DETENT = 1.5; // [deg] about zero
const OFTEN = 100; // [ms] between two orders at least
const STEP = 5; // [deg] that a tap on the groove moves the knob towards it
const HELD = 400; // [ms] after which what is held goes on
const GOES = 50; // [ms] for each degree that the groove's hold moves on
const CREEPS = 160; // [ms] the same for a fine key
/** @type {Record<string, number>} degrees of each key; with Shift five times */
const KEYS = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1, PageUp: 5, PageDown: -5 };

/**
 * Dispatches `order` (detail: degrees): at most ten a second, the last one always.
 *
 * `<order-lever name label low high limit face>` holds an `<angle-dial>`, to whose arc it is the
 * lower rim (face `down`) or the chord (`left`, `right`). A style's `--lever-face: down` lays it across
 * where a screen is too low for it.
 */
class OrderLever extends HTMLElement {
  most = USUAL; // [deg] the largest angle either way
  /** @type {Fan | null} */
  fan = null;
  /** @type {number | null} where the surface is [deg] */
  actual = null;
  /** @type {number | null} what was ordered last [deg] */
  ordered = null;

  connectedCallback() {
    if (this.groove) return;
    this.own = this.getAttribute("face") ?? "right"; // which the page's style may lay across
    this.value = 0;
    this.held = false;
    this.sent = -Infinity;
    this.due = 0;
    /** @type {number | null} what a hand has chosen since the order was last shown */
    this.chosen = null;
    this.figure = html("div", { class: "figure", "aria-hidden": "true", hidden: true });
    this.knob = html("div", {
      class: "knob",
      role: "slider",
      tabindex: 0,
      "aria-label": this.getAttribute("label") ?? "",
      keydown: (event) => this.press(/** @type {KeyboardEvent} */ (event)),
      pointerdown: (event) => this.drag(/** @type {PointerEvent} */ (event)),
    });
    this.groove = svg("path", { class: "groove" });
    this.reach = svg("path", {
      class: "reach",
      pointerdown: (event) => this.follow(/** @type {PointerEvent} */ (event)),
    });
    this.gap = svg("path", { class: "gap" });
    const rail = svg("svg", { "aria-hidden": "true" }, this.groove, this.gap, this.reach);
    this.bed = html("div", { class: "slot" }, rail, this.knob, this.figure);
    const keys = this.ends.map((word, high) => this.fineKey(word, high ? 1 : -1));
    this.hand = html("div", { class: "hand", "data-control": true }, keys[1], this.bed, keys[0]);
    this.append(this.hand);
    this.limit = Number(this.getAttribute("limit") ?? USUAL);
    this.set(0);
    new ResizeObserver(() => this.lay()).observe(this.bed);
  }

  /** Returns the key at an end, which moves the lever by a degree. @param {string} word @param {1 | -1} way */
  fineKey(word, way) {
    const by = () => this.choose((this.value ?? 0) + way);
    return html(
      "button",
      {
        type: "button",
        class: `fine ${way > 0 ? "high" : "low"}`,
        "aria-label": `${this.getAttribute("label")}: 1 ${word}`,
        pointerdown: (event) =>
          this.hold(/** @type {PointerEvent} */ (event), () => way * this.limit, 1, CREEPS),
        click: (event) => {
          if (/** @type {MouseEvent} */ (event).detail === 0) by(); // by the keyboard
        },
      },
      html("span", { class: "arrow" }),
      word,
    );
  }

  get ends() {
    return [this.getAttribute("low") ?? say("left"), this.getAttribute("high") ?? say("right")];
  }

  /** Whether it takes no orders now. */
  get idle() {
    return this.hand?.inert ?? true;
  }

  /** The largest angle either way [deg]. */
  get limit() {
    return this.most;
  }

  set limit(most) {
    this.most = most;
    this.knob?.setAttribute("aria-valuemin", String(-most));
    this.knob?.setAttribute("aria-valuemax", String(most));
    if (this.fan) this.set(this.value ?? 0);
  }

  /** Lays the scale out in the room there is, for the lever and its dial. */
  lay() {
    const { bed, groove, knob, reach } = this;
    if (!groove || !knob || !reach || !bed?.clientWidth || !bed.clientHeight) return;
    const face = getComputedStyle(this).getPropertyValue("--lever-face").trim() || this.own || "right";
    this.setAttribute("face", face);
    knob.setAttribute("aria-orientation", face === "down" ? "horizontal" : "vertical");
    const size = /** @type {[number, number]} */ ([knob.offsetWidth, knob.offsetHeight]);
    this.fan = new Fan(face, [bed.clientWidth, bed.clientHeight], readable(this), size);
    const { fan } = this;
    const over = 1 + ((face === "down" ? size[0] : size[1]) / 2 - 2) / fan.half; // under the whole knob
    const path = fan.path(-over, over, (share) => fan.knob(share));
    for (const part of [groove, reach]) part.setAttribute("d", path);
    const dial = /** @type {any} */ (this.querySelector("angle-dial"));
    if (dial) dial.fan = fan;
    this.set(this.value ?? 0);
  }

  /** Returns a value in words. @param {number} value */
  words(value) {
    const [low, high] = this.ends;
    return value === 0 ? say("zero") : sidedOrder(value, low, high);
  }

  /** Puts the knob to a value, and writes it as it was ordered. @param {number} value @param {number} [ordered] */
  set(value, ordered = value) {
    const { fan, figure, knob } = this;
    if (!knob || !figure) return;
    this.value = clamp(Math.round(value), -this.limit, this.limit) || 0;
    const shown = Math.round(ordered) === this.value ? ordered : this.value;
    const [x, y] = fan?.knob(this.value / this.limit) ?? [0, 0];
    for (const part of [knob, figure]) Object.assign(part.style, { left: `${x}px`, top: `${y}px` });
    write(knob, tenths(Math.abs(shown)));
    write(figure, this.value === 0 ? "0" : this.words(this.value));
    knob.setAttribute("aria-valuenow", String(this.value));
    knob.setAttribute("aria-valuetext", this.words(Number(shown.toFixed(1))));
    this.mark();
  }

  /** Marks on the groove what lies between the order and the surface. */
  mark() {
    const { actual, fan, gap, limit, value = 0 } = this;
    const [from, to] = [value, clamp(actual ?? value, -limit, limit)].map((angle) => angle / limit);
    gap?.setAttribute("d", fan && from !== to ? fan.path(from, to, (share) => fan.knob(share)) : "");
    gap?.classList.toggle("off", Math.abs((actual ?? value) - value) > OFF);
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

  /** Leaves out the order that is still to come, because the lever is given away. */
  leave() {
    clearTimeout(this.due);
    this.due = 0;
  }

  /**
   * @param {number | null} ordered [deg]
   * @param {string} [mode] `hand`, or what steers the surface
   * @param {boolean} [waits] whether the order still waits for its answer
   * @param {number | null} [actual] where the surface is [deg]
   */
  show(ordered, mode = "hand", waits = false, actual = null) {
    if (!this.knob) return;
    this.actual = actual;
    this.mark();
    this.classList.toggle("automatic", mode !== "hand");
    this.classList.toggle("asking", waits || this.due !== 0);
    if (this.held || this.due || waits) return;
    this.chosen = null;
    if (ordered !== null && (Math.round(ordered) !== this.value || ordered !== this.ordered)) this.set(ordered, ordered);
    this.ordered = ordered;
  }

  /** Returns the value at a place of the page. @param {PointerEvent} event */
  read(event) {
    const box = /** @type {HTMLElement} */ (this.bed).getBoundingClientRect();
    return (this.fan?.share(event, box) ?? 0) * this.limit;
  }

  /**
   * Takes something into a hand until the finger leaves; what it only touches orders nothing.
   * @param {PointerEvent} event
   * @param {(moved: PointerEvent) => void} move
   * @returns {AbortSignal | null} aborted when it leaves, null where no hand may take it
   */
  take(event, move) {
    const part = /** @type {HTMLElement} */ (event.currentTarget);
    if (event.button > 0 || this.held) return null;
    event.preventDefault();
    const left = new AbortController();
    const { signal } = left;
    this.held = true;
    this.chosen = this.value ?? 0;
    if (this.figure) this.figure.hidden = false;
    part.setPointerCapture(event.pointerId);
    const own = (/** @type {(moved: PointerEvent) => void} */ then) => (/** @type {Event} */ moved) => {
      if (/** @type {PointerEvent} */ (moved).pointerId === event.pointerId) {
        then(/** @type {PointerEvent} */ (moved));
      }
    };
    part.addEventListener("pointermove", own(move), { signal });
    part.addEventListener(
      "lostpointercapture",
      own(() => {
        this.held = false;
        if (this.figure) this.figure.hidden = true;
        left.abort();
      }),
      { signal },
    );
    return signal;
  }

  /** Moves the knob with the finger, which keeps its place on it. @param {PointerEvent} event */
  drag(event) {
    const offset = this.read(event) - (this.value ?? 0);
    const begun = this.value ?? 0;
    let moved = false;
    const move = (/** @type {PointerEvent} */ at) => {
      const value = this.read(at) - offset;
      moved ||= Math.round(value) !== begun;
      if (moved) this.choose(Math.abs(value) < DETENT ? 0 : value);
    };
    if (this.take(event, move)) this.knob?.focus();
  }

  /** Steps towards a finger on the groove, and goes to it while it is held. @param {PointerEvent} event */
  follow(event) {
    let wanted = this.read(event);
    const move = (/** @type {PointerEvent} */ at) => (wanted = this.read(at));
    if (this.hold(event, () => wanted, STEP, GOES, move)) this.knob?.focus();
  }

  /**
   * Steps towards a value, and after a while goes on to it degree by degree.
   * @param {PointerEvent} event
   * @param {() => number} wanted [deg]
   * @param {number} step [deg]
   * @param {number} every [ms]
   * @param {(moved: PointerEvent) => void} [move]
   */
  hold(event, wanted, step, every, move = () => undefined) {
    const signal = this.take(event, move);
    if (!signal) return false;
    const go = (/** @type {number} */ by) => {
      const at = this.value ?? 0;
      this.choose(at + clamp(Math.round(wanted()) - at, -by, by));
    };
    go(step);
    let going = 0;
    const waits = setTimeout(() => (going = window.setInterval(() => go(1), every)), HELD);
    signal.addEventListener("abort", () => {
      clearTimeout(waits);
      clearInterval(going);
    });
    return true;
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

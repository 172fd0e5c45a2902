// Forward against aft on one bar: the moment of the trim water.
import { svg, write } from "../draw.js";
import { tellScale } from "../gauges/gauge.js";

const SPOKEN = 2000; // [ms] between changes of what the bar says
const WRITTEN = 480; // [ms] between changes of its digits

/** `<balance-bar low="aft" high="forward" unit="t m">` */
class BalanceBar extends HTMLElement {
  #pointer = svg("path", { class: "pointer", d: "M0 0l-9 -16h18Z" });
  #bug = svg("path", { class: "bug", d: "M0 2l-8 14h16Z" });
  #digits = svg("text", { x: 160, y: 22, class: "worth" });
  #spoken = -SPOKEN;
  #wrote = -WRITTEN;

  connectedCallback() {
    if (this.firstChild) return;
    this.classList.add("gauge");
    this.setAttribute("role", "meter");
    for (const name of ["now", "min", "max"]) this.setAttribute(`aria-value${name}`, "0");
    const low = svg("text", { x: 8, y: 22 });
    const high = svg("text", { x: 312, y: 22, class: "end" });
    low.textContent = this.getAttribute("low") ?? "";
    high.textContent = this.getAttribute("high") ?? "";
    const steps = [-1, -0.5, 0, 0.5, 1].map((share) => `M${160 + share * 144} 46v12`);
    const picture = svg(
      "svg",
      { viewBox: "0 0 320 76", "aria-hidden": "true" },
      svg("path", { d: `M16 52H304${steps.join("")}M160 42v20`, class: "scale" }),
      this.#pointer,
      this.#bug,
      this.#digits,
      low,
      high,
      svg("path", { d: "M90 12L230 68M230 12L90 68", class: "cross" }),
    );
    this.append(picture);
    tellScale(this, picture, [320, 76]);
  }

  /**
   * @param {number | null} value
   * @param {number} limit at either end
   * @param {number | null} [ordered] where it will be
   */
  show(value, limit, ordered = null) {
    this.toggleAttribute("hidden", value === null);
    if (value === null) return;
    this.#place(this.#pointer, value, limit, 50);
    this.#bug.toggleAttribute("hidden", ordered === null || ordered === value);
    if (ordered !== null) this.#place(this.#bug, ordered, limit, 54);
    const now = performance.now();
    const side = this.getAttribute(value < 0 ? "low" : "high") ?? "";
    const unit = this.getAttribute("unit") ?? "";
    const words = `${Math.abs(value).toFixed(0)} ${unit}`;
    if (now - this.#wrote > WRITTEN) {
      this.#wrote = now;
      write(this.#digits, words);
    }
    if (now - this.#spoken < SPOKEN) return;
    this.#spoken = now;
    this.setAttribute("aria-valuemin", String(-limit));
    this.setAttribute("aria-valuemax", String(limit));
    this.setAttribute("aria-valuenow", value.toFixed(0));
    this.setAttribute("aria-valuetext", `${words} ${Math.abs(value) < 0.5 ? "" : side}`.trim());
  }

  /** @param {Element} node @param {number} value @param {number} limit @param {number} y */
  #place(node, value, limit, y) {
    const share = limit ? Math.min(Math.max(value / limit, -1), 1) : 0;
    node.setAttribute("transform", `translate(${(160 + share * 144).toFixed(1)} ${y})`);
  }
}

customElements.define("balance-bar", BalanceBar);

// A bar for speed, turns, air: what is, filled from zero; what is ordered, a hollow bug above.
import { html } from "../draw.js";
import { Gauge, clamp } from "./gauge.js";
import { decimals, say } from "../words.js";

class LevelBar extends Gauge {
  draw() {
    const unit = this.getAttribute("unit") ?? "";
    this.unit = unit === "rpm" ? say("rpm") : unit;
    this.bar = html("div", { class: "bar" });
    this.mark = html("div", { class: "hollow" });
    this.figure = html("b");
    this.numerals = html("div", { class: "numerals", "aria-hidden": "true" });
    this.append(
      html("div", { class: "head", "aria-hidden": "true" }, this.getAttribute("aria-label"), this.figure),
      html("div", { class: "trough" }, this.bar, this.mark),
      this.numerals,
    );
    this.range(this.size("low", 0), this.size("high", 100));
  }

  /**
   * Sets the ends of the scale, and how far apart its numerals are.
   * @param {number} low
   * @param {number} high
   * @param {number} [step]
   */
  range(low, high, step = this.size("step", (high - low) / 4)) {
    this.low = low;
    this.high = high;
    const values = [];
    for (let value = low; value <= high; value += step) values.push(value);
    const numerals = values.map((value) => {
      const between = Math.round(value / step) % 2 !== 0; // left out where there is no room
      const numeral = html("span", { "data-between": between }, String(Math.round(value)));
      numeral.style.left = `${this.at(value)}%`;
      return numeral;
    });
    this.numerals?.replaceChildren(...numerals);
  }

  /** Returns where a value stands [%]. @param {number} value */
  at(value) {
    const [low, high] = [this.low ?? 0, this.high ?? 100];
    return (100 * (clamp(value, low, high) - low)) / (high - low);
  }

  /** @param {number | null} value @param {number | null} [ordered] */
  show(value, ordered = null) {
    if (!this.bar || !this.mark || !this.figure) return;
    const [zero, at] = [this.at(Math.max(0, this.low ?? 0)), this.at(value ?? 0)];
    this.bar.style.left = `${Math.min(zero, at)}%`;
    this.bar.style.width = `${value === null ? 0 : Math.abs(at - zero)}%`;
    this.mark.hidden = ordered === null;
    if (ordered !== null) this.mark.style.left = `${this.at(ordered)}%`;
    const digits = (this.high ?? 100) < 50 ? 1 : 0;
    this.digits(this.figure, value === null ? "" : `${decimals(value, digits)} ${this.unit}`);
    if (value !== null) this.tell(value, [this.low ?? 0, this.high ?? 100], `${decimals(value, digits)} ${this.unit}`);
  }
}

customElements.define("level-bar", LevelBar);

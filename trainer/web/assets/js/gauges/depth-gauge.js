// Depth: digits in the middle, one fine needle round once in 100 m, a column over the whole range.
import { svg } from "../draw.js";
import { Gauge, around, bug, clamp, pointer, text, tick, turn } from "./gauge.js";

/** @type {import("./gauge.js").Point} */
const CENTRE = [160, 160];
const RADIUS = 142;
const [LEFT, TOP, FOOT, WIDE] = [372, 24, 296, 14]; // the column
const UNKNOWN = 300; // [m] the column's range where the boat's is not known
const BEYOND = 1.2; // of the greatest depth
const NEAR = 50; // [m] within which the order has its bug on the dial

class DepthGauge extends Gauge {
  draw() {
    this.range = UNKNOWN;
    this.needle = pointer(CENTRE, 70, RADIUS - 2, 9);
    this.bug = bug(CENTRE, RADIUS + 2);
    this.scale = svg("g");
    this.mark = svg("path", { class: "pointer", d: "M0 0l16 -9v18Z" });
    this.ordered = svg("path", { class: "bug", d: "M0 0l14 -8v16Z" });
    this.figure = text([160, 172], "digits");
    this.order = text([160, 196], "order");
    const label = text([160, 126], "label", "metres");
    const moving = [this.needle, this.bug, this.ordered, this.mark];
    this.picture(412, 320, ...dial(), this.scale, ...moving, this.figure, this.order, label);
    this.limit(null);
  }

  /**
   * Sets the column's range by the greatest depth, and marks periscope depth.
   * @param {number | null} greatest [m]
   * @param {number | null} [periscope] [m]
   */
  limit(greatest, periscope = null) {
    this.range = greatest ? BEYOND * greatest : UNKNOWN;
    this.scale?.replaceChildren(...this.column(greatest, periscope));
  }

  /** @param {number | null} greatest @param {number | null} periscope */
  column(greatest, periscope) {
    const step = this.range && this.range > 100 ? 10 : 2;
    const parts = [svg("rect", { x: LEFT, y: TOP, width: WIDE, height: FOOT - TOP, class: "face" })];
    if (greatest) {
      const y = this.height(greatest);
      parts.push(svg("rect", { x: LEFT, y, width: WIDE, height: FOOT - y, class: "beyond" }));
    }
    for (let metres = 0; metres <= (this.range ?? UNKNOWN); metres += step) {
      const [y, major] = [this.height(metres), metres % (5 * step) === 0];
      const style = major ? "tick" : "tick minor";
      parts.push(svg("line", { x1: LEFT - (major ? 9 : 5), x2: LEFT, y1: y, y2: y, class: style }));
      if (major) parts.push(text([LEFT - 13, y], "numeral end", String(metres)));
    }
    if (periscope) parts.push(text([LEFT + 24, this.height(periscope)], "numeral begin", "P"));
    return parts;
  }

  /** Returns how high a depth stands on the column. @param {number} depth */
  height(depth) {
    const range = this.range ?? UNKNOWN;
    return TOP + (clamp(depth, 0, range) / range) * (FOOT - TOP);
  }

  /** @param {number | null} depth [m] @param {number | null} [ordered] [m] */
  show(depth, ordered = null) {
    if (!this.needle || !this.bug || !this.mark || !this.ordered || !this.figure) return;
    const near = depth !== null && ordered !== null && Math.abs(ordered - depth) < NEAR;
    turn(this.needle, depth === null ? null : depth * 3.6, CENTRE);
    turn(this.bug, near ? ordered * 3.6 : null, CENTRE);
    place(this.mark, depth === null ? null : this.height(depth), LEFT + 8);
    place(this.ordered, ordered === null ? null : this.height(ordered), LEFT + WIDE + 2);
    this.digits(this.figure, depth === null ? "" : depth.toFixed(1));
    const order = ordered === null ? "" : `ordered ${round(ordered)}`;
    if (this.order && this.order.textContent !== order) this.order.textContent = order;
    if (depth === null) return;
    const words = `${depth.toFixed(0)} metres${order && `, ${order}`}`;
    this.tell(depth, [0, this.range ?? UNKNOWN], words);
  }
}

/** Returns the dial, which stays as it is. */
function dial() {
  /** @type {Element[]} */
  const parts = [svg("circle", { cx: CENTRE[0], cy: CENTRE[1], r: RADIUS, class: "face" })];
  for (let metres = 0; metres < 100; metres += 1) {
    const rank = metres % 10 === 0 ? 0 : metres % 5 === 0 ? 1 : 2;
    parts.push(tick(CENTRE, RADIUS, metres * 3.6, rank));
    const numeral = around(CENTRE, RADIUS - 33, metres * 3.6);
    if (rank === 0) parts.push(text(numeral, "numeral", String(metres)));
  }
  return parts;
}

/** @param {Element} part @param {number | null} y @param {number} x */
function place(part, y, x) {
  part.toggleAttribute("hidden", y === null);
  if (y !== null) part.setAttribute("transform", `translate(${x} ${y.toFixed(1)})`);
}

/** @param {number} value */
function round(value) {
  return Number.isInteger(value) ? String(value) : value.toFixed(1);
}

customElements.define("depth-gauge", DepthGauge);

// Depth: digits in the middle, one fine needle round once in 100 m or 300 ft, a column over the whole range.
import { svg, write } from "../draw.js";
import { Gauge, around, bug, clamp, text, tick, turn } from "./gauge.js";
import { feet, inUnit, lengthDigits } from "../units.js";
import { decimals, say } from "../words.js";

/** @type {import("./gauge.js").Point} */
const CENTRE = [160, 160];
const RADIUS = 142;
const [LEFT, TOP, FOOT, WIDE] = [372, 24, 296, 14]; // the column
const UNKNOWN = 300; // [m] the column's range where the boat's is not known
const BEYOND = 1.2; // of the greatest depth
const TURN = feet ? 300 : 100; // in the unit chosen, of the needle once round; the order has its bug within half
const STEPS = [2, 10, 20, 50]; // of the column
const MARKS = 50; // of the column at most

class DepthGauge extends Gauge {
  draw() {
    this.range = UNKNOWN;
    this.needle = svg("path", { class: "pointer", d: `M160 ${162 - RADIUS}l11 24h-22Z` }); // outside the numerals
    this.bug = bug(CENTRE, RADIUS + 2);
    this.faint = svg("path", { class: "ghost", d: `M160 ${160 - RADIUS}V90`, hidden: true });
    this.level = svg("path", { class: "ghost", d: "M-14 0h22", hidden: true });
    this.scale = svg("g");
    this.allowed = svg("path", { class: "bracket", hidden: true });
    this.dangers = ["jam", "flooding"].map((name) => svg("rect", { width: 5, class: `danger ${name}`, hidden: true }));
    this.mark = svg("path", { class: "pointer", d: "M0 0l16 -9v18Z" });
    this.ordered = svg("path", { class: "bug", d: "M0 0l14 -8v16Z" });
    this.figure = text([160, 172], "digits");
    this.order = text([160, 182], "order");
    const label = text([160, 126], "label spare", feet ? say("feet") : say("metres"));
    const moving = [this.faint, this.level, this.needle, this.bug, this.ordered, this.mark];
    this.picture([418, 320], ...dial(), this.scale, this.allowed, ...this.dangers, ...moving, this.figure, this.order, label);
    this.limit(null);
  }

  /**
   * Sets the column's range by the greatest depth, and marks periscope depth.
   * @param {number | null} greatest [m]
   * @param {number | null} [periscope] [m]
   */
  limit(greatest, periscope = null) {
    this.range = inUnit(greatest ? BEYOND * greatest : UNKNOWN);
    this.scale?.replaceChildren(...this.column(greatest && inUnit(greatest), periscope && inUnit(periscope)));
  }

  /** Draws a bracket about the depths that the exercise allows. @param {number | null} deepest [m] */
  allow(deepest) {
    const foot = this.height(inUnit(deepest ?? 0));
    const [inner, outer] = [LEFT - 2, LEFT + WIDE + 2];
    this.allowed?.toggleAttribute("hidden", deepest === null);
    this.allowed?.setAttribute("d", `M${inner} ${foot - 12}V${foot}H${outer}V${foot - 12}`);
  }

  /** Draws the column, by lengths in the unit chosen. @param {number | null} greatest @param {number | null} periscope */
  column(greatest, periscope) {
    const step = STEPS.find((each) => (this.range ?? UNKNOWN) / each <= MARKS) ?? 50;
    const parts = [svg("rect", { x: LEFT, y: TOP, width: WIDE, height: FOOT - TOP, class: "face" })];
    if (greatest) {
      const y = this.height(greatest);
      parts.push(svg("rect", { x: LEFT, y, width: WIDE, height: FOOT - y, class: "beyond" }));
    }
    for (let depth = 0; depth <= (this.range ?? UNKNOWN); depth += step) {
      const [y, major] = [this.height(depth), depth % (5 * step) === 0];
      const style = major ? "tick" : "tick minor";
      parts.push(svg("line", { x1: LEFT - (major ? 9 : 5), x2: LEFT, y1: y, y2: y, class: style }));
      if (major) parts.push(text([LEFT - 13, y], "numeral end", String(depth)));
    }
    if (periscope) parts.push(text([LEFT + 27, this.height(periscope)], "numeral begin", say("P")));
    return parts;
  }

  /** Returns how high a depth in the unit chosen stands on the column. @param {number} depth */
  height(depth) {
    const range = this.range ?? UNKNOWN;
    return TOP + (clamp(depth, 0, range) / range) * (FOOT - TOP);
  }

  /** Shows the depth of the reference crew's run. @param {number | null} metres */
  ghost(metres) {
    const depth = metres === null ? null : inUnit(metres);
    if (this.faint) turn(this.faint, depth === null ? null : (depth * 360) / TURN, CENTRE);
    if (this.level) place(this.level, depth === null ? null : this.height(depth), LEFT + 8);
  }

  /** Draws how far down dangers would take the boat from here, beside one another. @param {...(number | null)} depths [m] */
  reach(...depths) {
    const from = this.height(this.depth ?? 0);
    depths.forEach((depth, at) => {
      const bar = this.dangers?.[at];
      const high = depth === null ? 0 : this.height(inUnit(depth)) - from;
      bar?.toggleAttribute("hidden", !(high > 0));
      for (const [name, value] of [["x", LEFT + 1 + 7 * at], ["y", from], ["height", Math.max(high, 0)]]) bar?.setAttribute(String(name), String(value));
    });
  }

  /** @param {number | null} metres @param {number | null} [orderedMetres] */
  show(metres, orderedMetres = null) {
    const [depth, ordered] = [metres, orderedMetres].map((each) => (each === null ? null : inUnit(each)));
    this.depth = depth;
    if (!this.needle || !this.bug || !this.mark || !this.ordered || !this.figure) return;
    const near = depth !== null && ordered !== null && Math.abs(ordered - depth) < TURN / 2;
    turn(this.needle, depth === null ? null : (depth * 360) / TURN, CENTRE);
    turn(this.bug, near ? (ordered * 360) / TURN : null, CENTRE);
    place(this.mark, depth === null ? null : this.height(depth), LEFT + 8);
    place(this.ordered, ordered === null ? null : this.height(ordered), LEFT + WIDE + 2);
    const few = this.dataset.room === "few"; // where the needle leaves less room
    const digits = metres === null || depth === null ? "" : few && depth >= 100 ? depth.toFixed(0) : lengthDigits(metres);
    this.digits(this.figure, digits);
    const order = ordered === null ? "" : say("ordered {0}", round(ordered));
    if (this.order) write(this.order, ordered !== null && few ? round(ordered) : order);
    if (depth === null) return;
    const said = feet ? say("{0} feet", depth.toFixed(0)) : say("{0} metres", depth.toFixed(0));
    const words = `${said}${order && `, ${order}`}`;
    this.tell(depth, [0, this.range ?? UNKNOWN], words);
  }
}

/** Returns the dial, which stays as it is. */
function dial() {
  /** @type {Element[]} */
  const parts = [svg("circle", { cx: CENTRE[0], cy: CENTRE[1], r: RADIUS, class: "face" })];
  for (let depth = 0; depth < TURN; depth += TURN / 100) {
    const rank = depth % (TURN / 10) === 0 ? 0 : depth % (TURN / 20) === 0 ? 1 : 2;
    const angle = (depth * 360) / TURN;
    parts.push(tick(CENTRE, RADIUS, angle, rank));
    const numeral = around(CENTRE, RADIUS - 48, angle);
    const spare = depth % (TURN / 5) === 0 ? "" : " spare";
    if (rank === 0) parts.push(text(numeral, `numeral${spare}`, String(depth)));
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
  return Number.isInteger(value) || feet ? value.toFixed(0) : decimals(value, 1);
}

customElements.define("depth-gauge", DepthGauge);

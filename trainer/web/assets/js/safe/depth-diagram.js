// The safe depth by speed: down to where a jam or a flooding ends above test depth, and where the boat is.
import { svg } from "../draw.js";
import { Gauge, clamp, text } from "../gauges/gauge.js";
import { inUnit, lengthOf } from "../units.js";
import { say } from "../words.js";

/**
 * @typedef {{ speed: number, jam: number | null, flooding: number | null }} Limit at a speed [kn], depths [m]
 * @typedef {{ speed: number, depth: number }} Place [kn] and [m]
 * @typedef {{ limits: Limit[], test: number, now: Place, ordered: Place, jam: number | null, flooding: number | null }} Shown
 */

const [LEFT, TOP, WIDE, HIGH] = [64, 34, 400, 250]; // of the diagram within its picture
const DEEPEST = 1.15; // of test depth
const SPEEDS = [1, 2, 5, 10]; // [kn] of the grid
const DEPTHS = [2, 5, 10, 20, 50, 100, 200]; // likewise, in the unit chosen
const LINES = 7; // of the grid at most

class DepthDiagram extends Gauge {
  draw() {
    this.setAttribute("role", "img");
    /** @type {Limit[] | null} drawn, which are the boat's and no moment's */
    this.of = null;
    this.grid = svg("g");
    this.safe = svg("path", { class: "safe" });
    this.lines = svg("g");
    this.reach = svg("path", { class: "reach" });
    this.ordered = svg("path", { class: "bug", d: "M0 -9L9 0L0 9L-9 0Z" });
    this.now = svg("circle", { r: 6, class: "now" });
    this.picture([490, 342], this.grid, this.safe, this.lines, this.reach, this.ordered, this.now);
  }

  /** @param {Shown} shown */
  show({ limits, test, now, ordered, jam, flooding }) {
    if (!limits.length) return;
    const fastest = limits[limits.length - 1].speed;
    const foot = DEEPEST * test;
    const x = (/** @type {number} */ speed) => LEFT + (clamp(speed, 0, fastest) / fastest) * WIDE;
    const y = (/** @type {number} */ depth) => TOP + (clamp(depth, 0, foot) / foot) * HIGH;
    if (this.of !== limits) {
      this.of = limits;
      this.grid?.replaceChildren(...grid(x, y, fastest, foot, test));
      const least = limits.map((each) => Math.min(each.jam ?? test, each.flooding ?? test));
      const along = limits.map(({ speed }, at) => `L${x(speed)} ${y(least[at])}`).join("");
      this.safe?.setAttribute("d", `M${x(limits[0].speed)} ${y(0)}${along}L${x(fastest)} ${y(0)}Z`);
      this.lines?.replaceChildren(...["jam", "flooding"].map((name) => edge(limits, name, x, y)));
    }
    const [at, top] = [x(now.speed), y(now.depth)];
    this.now?.setAttribute("transform", `translate(${at.toFixed(1)} ${top.toFixed(1)})`);
    this.ordered?.setAttribute("transform", `translate(${x(ordered.speed).toFixed(1)} ${y(ordered.depth).toFixed(1)})`);
    const deepest = Math.max(jam ?? 0, flooding ?? 0, now.depth);
    this.reach?.setAttribute("d", `M${at.toFixed(1)} ${top.toFixed(1)}V${y(deepest).toFixed(1)}`);
    this.setAttribute("aria-label", say("Safe depth by speed, and the boat at {0} knots, {1}", now.speed.toFixed(0), lengthOf(now.depth, 0)));
  }
}
customElements.define("depth-diagram", DepthDiagram);

/**
 * @param {(speed: number) => number} x
 * @param {(depth: number) => number} y
 * @param {number} fastest [kn]
 * @param {number} foot [m]
 * @param {number} test [m]
 */
function grid(x, y, fastest, foot, test) {
  const parts = [svg("rect", { x: LEFT, y: TOP, width: WIDE, height: HIGH, class: "face" })];
  const beyond = y(test);
  parts.push(svg("rect", { x: LEFT, y: beyond, width: WIDE, height: TOP + HIGH - beyond, class: "beyond" }));
  for (const speed of steps(fastest, SPEEDS)) {
    parts.push(svg("line", { x1: x(speed), x2: x(speed), y1: TOP, y2: TOP + HIGH, class: "tick minor" }));
    parts.push(text([x(speed), TOP + HIGH + 20], "numeral", String(speed)));
  }
  const metre = inUnit(1);
  for (const depth of steps(foot * metre, DEPTHS)) {
    const level = y(depth / metre);
    parts.push(svg("line", { x1: LEFT, x2: LEFT + WIDE, y1: level, y2: level, class: "tick minor" }));
    parts.push(text([LEFT - 8, level], "numeral end", String(depth)));
  }
  parts.push(text([LEFT + WIDE / 2, TOP + HIGH + 48], "label", say("speed [kn]")));
  parts.push(text([LEFT, TOP - 16], "label begin", say("depth, test depth {0}", lengthOf(test, 0))));
  return parts;
}

/** @param {number} most @param {number[]} sizes */
function steps(most, sizes) {
  const step = sizes.find((size) => most / size <= LINES) ?? sizes[sizes.length - 1];
  return Array.from({ length: Math.floor(most / step) + 1 }, (_, at) => at * step);
}

/**
 * Returns the line of a danger's limit, where the boat can have it.
 * @param {Limit[]} limits
 * @param {string} name
 * @param {(speed: number) => number} x
 * @param {(depth: number) => number} y
 */
function edge(limits, name, x, y) {
  const points = limits.flatMap((limit) => {
    const depth = name === "jam" ? limit.jam : limit.flooding;
    return depth === null ? [] : [`${x(limit.speed).toFixed(1)} ${y(depth).toFixed(1)}`];
  });
  return svg("path", { class: `edge ${name}`, d: points.length ? `M${points.join("L")}` : "" });
}

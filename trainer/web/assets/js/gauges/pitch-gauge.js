// Pitch: the boat to its true angle between two arcs, and below it the bubble, ten times finer.
import { svg, write } from "../draw.js";
import { Gauge, arc, around, clamp, line, text, turn } from "./gauge.js";
import { decimals, say } from "../words.js";

/** @type {import("./gauge.js").Point} */
const CENTRE = [190, 108];
const RADIUS = 150;
const SCALE = 30; // [deg] of the arcs
const DRAWN = 45; // [deg] that the boat is drawn at, at most
const BUBBLE = 10; // [deg] of the tube
const FINE = 12; // of the tube for a degree
const TUBE = 232; // its height
const PARTS = {
  sail: "M6 -13L11 -33H42L49 -13Z",
  tail: "M-97 -2L-88 -19L-77 -17L-79 -6ZM-97 2L-88 19L-77 17L-79 6ZM-108 -9L-104 -9L-104 9L-108 9Z",
  hull: "M-104 0C-84 -7 -58 -14 -26 -14H58C84 -14 102 -8 102 0C102 8 84 14 58 14H-26C-58 14 -84 7 -104 0Z",
};
const ENDS = "M128 0l-16 -6v12ZM-128 0l16 -6v12Z"; // which end at the arcs

class PitchGauge extends Gauge {
  draw() {
    const hull = Object.values(PARTS).map((d) => svg("path", { d, class: "hull" }));
    this.boat = svg("g", {}, ...hull, svg("path", { d: ENDS, class: "pointer" }));
    this.bug = svg("path", { class: "bug", d: "M0 0l14 -9v18Z" });
    const [x, y] = CENTRE;
    this.faint = svg("path", { class: "ghost", d: `M${x - RADIUS} ${y}h40M${x + RADIUS} ${y}h-40`, hidden: true });
    this.bubble = svg("ellipse", { cx: 190, cy: TUBE, rx: 15, ry: 8, class: "bubble" });
    this.figure = svg("tspan");
    this.way = svg("tspan", { class: "side", dx: 8 });
    this.allowed = svg("path", { class: "bracket", hidden: true });
    const middle = svg("g", { transform: `translate(${CENTRE})` }, this.boat);
    const words = [svg("text", { x: CENTRE[0], y: 192, class: "digits" }, this.figure, this.way)];
    this.picture([380, 276], ...arcs(), ...tube(), this.allowed, this.faint, middle, this.bug, this.bubble, ...words);
  }

  /** Draws brackets at the ends of what the exercise allows. @param {number | null} steepest [deg] */
  allow(steepest) {
    this.allowed?.toggleAttribute("hidden", steepest === null);
    const ends = [90, 270].flatMap((middle) => [-1, 1].map((way) => bracket(middle, way, steepest ?? 0)));
    this.allowed?.setAttribute("d", ends.join(""));
  }

  /** Shows the pitch of the reference crew's run. @param {number | null} pitch [deg] */
  ghost(pitch) {
    if (this.faint) turn(this.faint, pitch === null ? null : -clamp(pitch, -SCALE, SCALE), CENTRE);
  }

  /** @param {number | null} pitch [deg] bow up @param {number | null} [ordered] [deg] */
  show(pitch, ordered = null) {
    if (!this.boat || !this.bug || !this.bubble || !this.figure || !this.way) return;
    const held = clamp(pitch ?? 0, -DRAWN, DRAWN);
    this.boat.setAttribute("transform", `rotate(${(-held).toFixed(2)}) scale(1.16)`);
    const off = clamp(pitch ?? 0, -BUBBLE - 0.3, BUBBLE + 0.3) * FINE;
    this.bubble.setAttribute("transform", `translate(${off.toFixed(1)} 0)`);
    this.bug.toggleAttribute("hidden", ordered === null);
    if (ordered !== null) {
      const [x, y] = around(CENTRE, RADIUS - 14, 90 - clamp(ordered, -SCALE, SCALE));
      this.bug.setAttribute("transform", `translate(${x} ${y}) rotate(${-ordered})`);
    }
    const fine = this.dataset.room === "few" ? 0 : 1; // digits after the point
    const shown = this.digits(this.figure, pitch === null ? "" : decimals(Math.abs(pitch), fine));
    const way = pitch === null ? "" : Math.abs(pitch) < 0.05 ? say("level") : pitch < 0 ? say("down") : say("up");
    if (shown) write(this.way, way);
    if (pitch === null) return;
    const size = Math.abs(pitch).toFixed(0);
    const words = pitch < 0 ? say("{0} degrees down by the bow", size) : say("{0} degrees up by the bow", size);
    this.tell(pitch, [-DRAWN, DRAWN], words);
  }
}

/** Returns the arcs at both ends, and the level line. */
function arcs() {
  /** @type {Element[]} */
  const parts = [svg("line", { x1: 46, x2: 334, y1: 108, y2: 108, class: "tick minor level" })];
  for (const [middle, sense] of [
    [90, -1],
    [270, 1],
  ]) {
    parts.push(svg("path", { d: arc(CENTRE, RADIUS, middle - 32, middle + 32), class: "arc" }));
    for (let value = -SCALE; value <= SCALE; value += 5) {
      const [angle, major] = [middle + sense * value, value % 10 === 0];
      const style = major ? "tick" : "tick minor";
      parts.push(line(CENTRE, RADIUS, RADIUS + (major ? 12 : 7), angle, style));
      const numeral = around(CENTRE, RADIUS + 24, angle);
      const rank = Math.abs(value) === SCALE || value === 0 ? "numeral" : "numeral spare";
      if (major) parts.push(text(numeral, rank, String(Math.abs(value))));
    }
  }
  return parts;
}

/**
 * Returns one end of the bracket on an arc: across the arc, and back along it.
 * @param {number} middle where the arc is level [deg]
 * @param {number} way -1 or 1
 * @param {number} steepest [deg]
 */
function bracket(middle, way, steepest) {
  const end = middle + way * clamp(steepest, 0, SCALE);
  const [hook, outer, inner] = [around(CENTRE, RADIUS + 12, end - way * 3), around(CENTRE, RADIUS + 12, end), around(CENTRE, RADIUS - 8, end)];
  const back = around(CENTRE, RADIUS - 8, end - way * 3);
  return `M${[hook, outer, inner, back].map((point) => point.map((each) => each.toFixed(1)).join(" ")).join("L")}`;
}

/** Returns the tube with its scale. */
function tube() {
  const parts = [svg("rect", { x: 60, y: TUBE - 12, width: 260, height: 24, rx: 12, class: "tube" })];
  for (let value = -BUBBLE; value <= BUBBLE; value += 1) {
    const [x, major] = [190 + value * FINE, value % 5 === 0];
    const [y1, style] = [TUBE + (major ? 8 : 13), major ? "tick" : "tick minor"];
    parts.push(svg("line", { x1: x, x2: x, y1, y2: TUBE + 18, class: style }));
    if (major) parts.push(text([x, TUBE + 32], "numeral spare", String(Math.abs(value))));
  }
  parts.push(text([36, TUBE + 1], "numeral spare", say("aft")), text([346, TUBE + 1], "numeral spare", say("fwd")));
  return parts;
}

customElements.define("pitch-gauge", PitchGauge);

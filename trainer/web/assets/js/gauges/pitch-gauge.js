// Pitch: the boat to its true angle between two arcs, and below it the bubble, ten times finer.
import { svg, write } from "../draw.js";
import { Gauge, arc, around, clamp, line, text } from "./gauge.js";

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
const ENDS = "M148 0l-18 -6v12ZM-148 0l18 -6v12Z";

class PitchGauge extends Gauge {
  draw() {
    const hull = Object.values(PARTS).map((d) => svg("path", { d, class: "hull" }));
    this.boat = svg("g", {}, ...hull, svg("path", { d: ENDS, class: "pointer" }));
    this.bug = svg("path", { class: "bug", d: "M0 0l14 -9v18Z" });
    this.bubble = svg("ellipse", { cx: 190, cy: TUBE, rx: 15, ry: 8, class: "bubble" });
    this.figure = text([190, 192], "digits");
    this.way = text([244, 192], "side begin");
    const middle = svg("g", { transform: `translate(${CENTRE})` }, this.boat);
    const words = [this.figure, this.way];
    this.picture(380, 272, ...arcs(), ...tube(), middle, this.bug, this.bubble, ...words);
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
    this.digits(this.figure, pitch === null ? "" : Math.abs(pitch).toFixed(1));
    const way = pitch === null ? "" : Math.abs(pitch) < 0.05 ? "level" : pitch < 0 ? "down" : "up";
    write(this.way, way);
    if (pitch === null) return;
    const words = `${Math.abs(pitch).toFixed(0)} degrees ${pitch < 0 ? "down" : "up"} by the bow`;
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
      if (major) parts.push(text(numeral, "numeral", String(Math.abs(value))));
    }
  }
  return parts;
}

/** Returns the tube with its scale. */
function tube() {
  const parts = [svg("rect", { x: 60, y: TUBE - 12, width: 260, height: 24, rx: 12, class: "tube" })];
  for (let value = -BUBBLE; value <= BUBBLE; value += 1) {
    const [x, major] = [190 + value * FINE, value % 5 === 0];
    const [y1, style] = [TUBE + (major ? 8 : 13), major ? "tick" : "tick minor"];
    parts.push(svg("line", { x1: x, x2: x, y1, y2: TUBE + 18, class: style }));
    if (major) parts.push(text([x, TUBE + 30], "numeral", String(Math.abs(value))));
  }
  parts.push(text([36, TUBE + 1], "numeral", "aft"), text([346, TUBE + 1], "numeral", "fwd"));
  return parts;
}

customElements.define("pitch-gauge", PitchGauge);

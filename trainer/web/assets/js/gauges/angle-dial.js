// Rudder, planes, heel: an arc about zero, twice enlarged; `face` is where its middle looks.
import { svg, write } from "../draw.js";
import { Gauge, arc, around, bug, clamp, line, pointer, side, text, turn } from "./gauge.js";

/**
 * @typedef {import("./gauge.js").Point} Point
 * @typedef {{ size: Point, centre: Point, at: number, sense: 1 | -1, radius: number, gain: number,
 *   digits: Point, order: Point, low: Point, high: Point }} Face
 */

/** @type {Record<string, Face>} */
const FACES = {
  down: {
    size: [320, 196],
    centre: [160, 22],
    at: 180,
    sense: -1,
    radius: 126,
    gain: 2,
    digits: [160, 62],
    order: [160, 86],
    low: [30, 40],
    high: [290, 40],
  },
  flat: {
    size: [320, 128],
    centre: [160, -86],
    at: 180,
    sense: -1,
    radius: 190,
    gain: 1.4,
    digits: [160, 36],
    order: [160, 55],
    low: [30, 18],
    high: [290, 18],
  },
  right: {
    size: [210, 300],
    centre: [38, 150],
    at: 90,
    sense: -1,
    radius: 126,
    gain: 2,
    digits: [60, 160],
    order: [60, 184],
    low: [60, 276],
    high: [60, 34],
  },
};
FACES.left = mirrored(FACES.right);
const USUAL = 30; // [deg]

/** Returns a face as a mirror at its side shows it. @param {Face} face @returns {Face} */
function mirrored({ size, centre, at, sense, digits, order, low, high, ...same }) {
  const turned = (/** @type {Point} */ [x, y]) => /** @type {Point} */ ([size[0] - x, y]);
  const [middle, figure, below] = [centre, digits, order].map(turned);
  const places = { centre: middle, digits: figure, order: below, low: turned(low), high: turned(high) };
  return { size, at: 360 - at, sense: sense === 1 ? -1 : 1, ...places, ...same };
}

class AngleDial extends Gauge {
  most = USUAL; // [deg] the largest angle either way

  draw() {
    this.face = FACES[this.getAttribute("face") ?? "down"];
    this.words = [this.getAttribute("low") ?? "left", this.getAttribute("high") ?? "right"];
    const { centre, radius, size, digits, order, low, high } = this.face;
    this.scale = svg("g");
    this.pointer = pointer(centre, size[0] > size[1] ? radius - 40 : 84, radius - 1);
    this.bug = bug(centre, radius + 3);
    this.figure = text(digits, "digits");
    this.order = text(order, "order");
    const ends = [text(low, "label", this.words[0]), text(high, "label", this.words[1])];
    this.picture(...size, this.scale, ...ends, this.pointer, this.bug, this.figure, this.order);
    this.limit = this.size("limit", USUAL);
  }

  /** The largest angle either way [deg], where the stops stand. */
  get limit() {
    return this.most;
  }

  set limit(most) {
    this.most = most;
    this.scale?.replaceChildren(...this.ticks(most));
  }

  /** Returns where a value stands on the arc [deg]. @param {number} value */
  angle(value) {
    const { at, sense, gain } = this.face ?? FACES.down;
    return at + sense * gain * value * Math.min(1, USUAL / this.limit);
  }

  /** @param {number} most */
  ticks(most) {
    const { centre, radius } = this.face ?? FACES.down;
    const whole = arc(centre, radius, this.angle(-most - 3), this.angle(most + 3));
    /** @type {Element[]} */
    const parts = [svg("path", { d: whole, class: "arc" })];
    if (this.hasAttribute("sides")) {
      const [port, starboard] = [-1, 1].map((way) =>
        arc(centre, radius + 6, this.angle(way), this.angle(way * most)),
      );
      parts.push(svg("path", { d: port, class: "port" }));
      parts.push(svg("path", { d: starboard, class: "starboard" }));
    }
    for (let value = -Math.floor(most); value <= most; value += 1) {
      const [major, middle] = [value % 10 === 0, value % 5 === 0];
      const length = major ? 17 : middle ? 12 : 7;
      const style = major ? "tick" : "tick minor";
      parts.push(line(centre, radius - length, radius, this.angle(value), style));
      const numeral = around(centre, radius - 30, this.angle(value));
      if (major) parts.push(text(numeral, "numeral", String(Math.abs(value))));
    }
    for (const end of [-most, most]) {
      parts.push(line(centre, radius - 18, radius + 9, this.angle(end), "stop"));
    }
    return parts;
  }

  /** @param {number | null} value [deg] @param {number | null} [ordered] [deg] */
  show(value, ordered = null) {
    if (!this.face || !this.words || !this.pointer || !this.bug || !this.figure || !this.order) return;
    const [low, high] = this.words;
    const held = value === null ? null : clamp(value, -this.limit - 3, this.limit + 3);
    turn(this.pointer, held === null ? null : this.angle(held), this.face.centre);
    const order = ordered === null ? null : clamp(ordered, -this.limit, this.limit);
    turn(this.bug, order === null ? null : this.angle(order), this.face.centre);
    this.digits(this.figure, value === null ? "" : Math.abs(value).toFixed(1));
    this.order.classList.toggle("plain", ordered === null);
    if (ordered === null) write(this.order, side(value ?? 0, low, high));
    else write(this.order, `${Math.abs(ordered).toFixed(0)} ${side(ordered, low, high)}`.trim());
    if (value === null) return;
    const words = `${Math.abs(value).toFixed(0)} degrees ${side(value, low, high)}`;
    this.tell(value, [-this.limit, this.limit], words);
  }
}

customElements.define("angle-dial", AngleDial);

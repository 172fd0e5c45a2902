// The boat from astern: heel over a fixed horizon, and how the tail's surfaces are turned.
import { sided, svg, write } from "../draw.js";
import { tellScale } from "../gauges/gauge.js";
import { say } from "../words.js";

const HULL = 38; // radius in the units of the view
const CHORD = 22; // of rudder and planes; what is seen of it goes with the sine of their angle
const THICK = 1.4; // half of a surface that is not turned
const SCALE = [-30, -20, -10, 10, 20, 30]; // [deg]
const MOST = 30; // [deg] where the pointer is parked
const WORDS = 2000; // [ms] between descriptions

/**
 * Heel, starboard down positive; rudder, right positive; stern planes, rise positive [deg].
 * @typedef {{ heel: number | null, rudder?: number | null, stern?: number | null }} Seen
 */

/** `<boat-stern>`: a boat with a tail like a cross, as a ship behind it would see it. */
export class BoatStern extends HTMLElement {
  constructor() {
    super();
    this.rudders = [-1, 1].map(() => svg("path", { class: "plane" }));
    this.planes = [-1, 1].map(() => svg("path", { class: "plane" }));
    this.boat = svg(
      "g",
      { class: "hull" },
      svg("path", { d: "M-34 -60H34L30 -56H-30Z", class: "dark" }),
      svg("path", { d: "M-9 -34L-6.5 -76Q0 -80 6.5 -76L9 -34Z", class: "dark" }),
      svg("circle", { r: HULL, class: "body" }),
      svg("circle", { r: HULL * 0.62, class: "ring" }),
      ...this.planes,
      ...this.rudders,
      svg("circle", { r: 6, class: "dark" }),
    );
    this.pointer = svg("path", { d: "M0 78L6.5 65H-6.5Z", class: "pendulum" });
    this.digits = svg("text", { x: 0, y: -86, class: "heel" });
    this.described = -WORDS;
  }

  connectedCallback() {
    this.setAttribute("role", "img");
    const ticks = SCALE.map((angle) => tick(angle, 92));
    const horizon = svg("path", { d: "M-106 0H-46M46 0H106", class: "level" });
    const view = { viewBox: "-110 -102 220 204", "aria-hidden": "true" };
    const parts = [horizon, ...ticks, tick(0, 98), this.boat, this.pointer, this.digits];
    const picture = svg("svg", view, ...parts);
    this.replaceChildren(picture);
    tellScale(this, picture, [220, 204]);
  }

  /** @param {Seen} seen */
  show({ heel, rudder = 0, stern = 0 }) {
    this.toggleAttribute("data-empty", heel === null);
    if (heel === null) return;
    const parked = Math.min(Math.max(heel, -MOST), MOST);
    this.boat.setAttribute("transform", `rotate(${heel.toFixed(2)})`);
    this.pointer.setAttribute("transform", `rotate(${(-parked).toFixed(2)})`);
    this.rudders.forEach((each, side) => each.setAttribute("d", upright(side, rudder ?? 0)));
    this.planes.forEach((each, side) => each.setAttribute("d", across(side, stern ?? 0)));
    const now = performance.now();
    if (now - this.described < WORDS) return;
    this.described = now;
    const words = sided(heel, say("to port"), say("to starboard"), 0);
    this.setAttribute("aria-label", say("Boat from astern: heel {0}", words));
    write(this.digits, say("heel {0}", sided(heel, say("port"), say("stbd"))));
  }
}
customElements.define("boat-stern", BoatStern);

/** Returns what is seen of a turned surface, from the least to the most. @param {number} angle */
function breadth(angle) {
  const edge = CHORD * Math.sin((angle * Math.PI) / 180);
  return [Math.min(edge, 0) - THICK, Math.max(edge, 0) + THICK].map((each) => each.toFixed(1));
}

/** Returns the outline of the upper (0) or lower (1) rudder. @param {number} side @param {number} angle */
function upright(side, angle) {
  const [low, high] = breadth(angle);
  const [root, tip] = side ? [8, 60] : [-8, -60];
  return `M${low} ${root}V${tip}H${high}V${root}Z`;
}

/** Returns the outline of the port (0) or starboard (1) plane. @param {number} side @param {number} angle */
function across(side, angle) {
  const [low, high] = breadth(-angle);
  const [root, tip] = side ? [8, 64] : [-8, -64];
  return `M${root} ${low}H${tip}V${high}H${root}Z`;
}

/** @param {number} angle @param {number} end */
function tick(angle, end) {
  return svg("line", { x1: 0, x2: 0, y1: 84, y2: end, class: "tick", transform: `rotate(${-angle})` });
}

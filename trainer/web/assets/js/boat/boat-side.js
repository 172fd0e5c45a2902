// The boat in the water from the side: true angles and one scale, before a ladder of depth.
import { sided, svg } from "../draw.js";
import { Hull, KEEL, LENGTH } from "./hull.js";
import { Water } from "./water.js";
import { inUnit, unit } from "../units.js";
import { say } from "../words.js";

const KNOT = 0.514444; // [m/s]
const SPAN = 90; // [m] of water that are shown for a boat of LENGTH
const ROOM = 1.25; // lengths of the boat that are shown across at least
const SKY = 0.17; // share of the height that is sky where the surface is seen
const FIXED_SKY = 0.1; // and where the view stands still
const WORDS = 2000; // [ms] between descriptions

/**
 * What is known of the boat; null is not known, and is not drawn.
 * @typedef {{ depth: number | null, pitch: number | null, speed?: number | null,
 *   stern?: number | null, bow?: number | null, ordered?: number | null, limit?: number | null,
 *   surface?: number | null, clearance?: number | null }} Seen
 * Depth, ordered depth, limit, and clearance of the keel over the ground [m]; pitch, bow up positive, and planes, rise positive [deg];
 * speed [kn]; surface: the elevation of the sea over the boat [m].
 */

/**
 * `<boat-side>`; `at="0.5"` is the boat's place across, and `fixed` holds the view still from the
 * surface down. `span` is the water shown [m]. Properties: `length` of the boat [m], `words`, and
 * `still`, where time stands still.
 */
export class BoatSide extends HTMLElement {
  constructor() {
    super();
    this.length = LENGTH;
    this.still = false;
    this.words = { surface: say("surface"), ordered: say("ordered"), limit: say("limit"), metres: unit, ground: say("ground") };
    this.water = new Water();
    this.hull = new Hull(this.water.shade);
    this.level = svg("line", { class: "level" });
    this.boat = svg("g", {}, this.hull.element);
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
    this.shownAt = performance.now();
    this.described = -WORDS;
    this.size = { width: 0, height: 0, text: 16 };
    /** @type {Seen} */
    this.seen = { depth: null, pitch: null };
  }

  connectedCallback() {
    this.setAttribute("role", "img");
    const { defs, behind, before } = this.water;
    this.picture = svg("svg", { "aria-hidden": "true" }, defs, behind, this.level, this.boat, before);
    this.replaceChildren(this.picture);
    new ResizeObserver(() => this.measure()).observe(this);
    this.measure();
  }

  measure() {
    const { width, height } = this.getBoundingClientRect();
    this.size = { width, height, text: parseFloat(getComputedStyle(this).fontSize) };
    this.picture?.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.show(this.seen);
  }

  /** @param {Seen} seen */
  show(seen) {
    this.seen = seen;
    if (this.size.width < 2 || this.size.height < 2) return;
    const now = performance.now();
    const passed = Math.min((now - this.shownAt) / 1000, 0.5);
    this.shownAt = now;
    const view = this.view(seen.depth ?? 0);
    const still = this.calm.matches || this.still;
    const speed = still ? 0 : (seen.speed ?? 0);
    this.water.place(view, seen.ordered ?? null, seen.limit ?? null, this.words, this.ground);
    this.water.flow(view, still ? 0 : passed, speed * KNOT, seen.surface ?? 0);
    this.place(seen, view);
    this.hull.turnPlanes(seen.stern ?? null, seen.bow ?? null);
    this.hull.turnPropeller(speed, passed);
    if (now - this.described >= WORDS) this.describe(now);
  }

  /** The depth of the ground under the keel as it is drawn [m], null where none is known. */
  get ground() {
    const { depth, clearance = null } = this.seen;
    return depth === null || clearance === null ? null : depth + (KEEL * this.length) / LENGTH + clearance;
  }

  /**
   * Returns what of the water is shown: it goes with the boat, but for the sky.
   * @param {number} depth
   * @returns {import("./water.js").View}
   */
  view(depth) {
    const { width, height, text } = this.size;
    const span = Number(this.getAttribute("span") ?? (SPAN * this.length) / LENGTH);
    const scale = Math.min(height / span, width / (ROOM * this.length));
    const tall = height / scale;
    const fixed = this.hasAttribute("fixed");
    const highest = -(fixed ? FIXED_SKY : SKY) * tall;
    const top = fixed ? highest : Math.max(depth - tall / 2, highest);
    return { width, height, scale, top, text };
  }

  /** @param {Seen} seen @param {import("./water.js").View} view */
  place({ depth, pitch }, { width, scale, top }) {
    const shown = depth !== null && pitch !== null;
    this.boat.toggleAttribute("hidden", !shown);
    this.level.toggleAttribute("hidden", !shown);
    if (!shown) return;
    const wanted = Number(this.getAttribute("at") ?? 0.5) * width;
    const room = 0.54 * this.length * scale; // to either side, so that nothing of it is cut off
    const [x, y] = [Math.max(Math.min(wanted, width - room), room), (depth - top) * scale];
    const size = (this.length / LENGTH) * scale;
    const turn = `rotate(${(-pitch).toFixed(2)}) scale(${size.toFixed(4)})`;
    this.boat.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)}) ${turn}`);
    const reach = 0.62 * this.length * scale;
    for (const [name, value] of Object.entries({ x1: x - reach, x2: x + reach, y1: y, y2: y })) {
      this.level.setAttribute(name, value.toFixed(1));
    }
  }

  /** Says in words what is drawn. @param {number} now [ms] */
  describe(now) {
    this.described = now;
    const { depth, pitch } = this.seen;
    const where = depth === null ? say("not known") : `${inUnit(depth).toFixed(0)} ${this.words.metres}`;
    const angle = pitch === null ? "" : `, ${sided(pitch, say("down"), say("up"), 0)}°`;
    this.setAttribute("aria-label", say("Boat from the side: {0}", `${where}${angle}`));
  }
}
customElements.define("boat-side", BoatSide);

// The water that the boat is in: surface, light, what drifts past, and a ladder of depth.
import { svg } from "../draw.js";
import { feet, inUnit } from "../units.js";

const LIT = 90; // [m] that light reaches
const STEPS = [1, 2, 5, 10, 20, 50, 100, 200].map((each) => each / inUnit(1)); // [m] of the ladder
const APART = 2.8; // lines of text between two steps at least
const RIPPLE = 0.22; // [m] of a calm surface
const SWELL = 0.65; // [rad/s] of a wave of about ten seconds
const GRAVITY = 9.81; // [m/s2]
const DRIFT = 240; // [px] the tile that drifting matter repeats in
const RAYS = ["M-30 0L-62 60H-40L-22 0Z", "M-4 0L-18 74H4L6 0Z", "M22 0L30 52H44L32 0Z", "M50 0L72 66H92L62 0Z"];

let made = 0;

/**
 * @typedef {{ surface: string, ordered: string, limit: string, metres: string, ground: string }} Words
 * @typedef {{ width: number, height: number, scale: number, top: number, text: number }} View
 * Width and height [px], scale [px/m], the depth at the upper edge [m], the size of text [px].
 */

/** Everything but the boat, in pixels; depths below move with the view. */
export class Water {
  constructor() {
    made += 1;
    const ids = ["light", "near", "band", "ray", "veil"].map((id) => `${id}-${made}`);
    const [light, near, band, ray, veil] = ids;
    this.shade = `shade-${made}`;
    this.drift = svg(
      "pattern",
      { id: near, width: DRIFT, height: DRIFT, patternUnits: "userSpaceOnUse" },
      svg("path", { d: specks(), class: "specks" }),
    );
    this.light = gradient(light, ["shallow", "deep"], "userSpaceOnUse");
    this.banding = svg(
      "pattern",
      { id: band, width: 14, height: 14, patternUnits: "userSpaceOnUse" },
      svg("path", { d: "M-2 16L16 -2M-2 2L2 -2M12 16L16 12", class: "hatch" }),
    );
    const defs = svg("defs", {}, this.light, this.drift, this.banding);
    defs.append(
      gradient(this.shade, ["hull-top", "hull-middle", "hull-foot"]),
      gradient(ray, ["ray-bright", "ray-gone"]),
      gradient(veil, ["veil-near", "veil-gone"]),
    );
    this.column = svg("path", { fill: `url(#${light})` });
    this.rays = svg("g", { fill: `url(#${ray})` }, ...RAYS.map((d) => svg("path", { d })));
    this.matter = svg("path", { fill: `url(#${near})` });
    this.ladder = svg("g");
    this.crest = svg("path", { class: "crest" });
    this.limit = svg("g", { class: "limit" }, svg("rect", { fill: `url(#${band})` }), svg("line"));
    this.behind = svg("g", {}, this.column, this.rays, this.matter, this.ladder, this.limit);
    this.veil = svg("path", { fill: `url(#${veil})` }); // water between us and the boat, near the surface
    this.ordered = svg("line", { class: "ordered-depth" });
    this.labels = svg("g", { class: "labels" });
    this.ground = svg("g", { class: "ground", hidden: true }, svg("rect"), svg("text"));
    this.before = svg("g", {}, this.veil, this.crest, this.ordered, this.labels, this.ground);
    this.defs = defs;
    this.drawn = "";
    this.moved = 0; // [m] past the boat
    this.second = 0;
    this.elevation = 0; // [m] of the surface over the boat
    this.rise = 0; // [m/s] of it
  }

  /**
   * Draws what stands in the water, where that has changed.
   * @param {View} view
   * @param {number | null} ordered [m]
   * @param {number | null} limit [m]
   * @param {Words} words
   * @param {number | null} [ground] [m] depth of it under the boat
   */
  place(view, ordered, limit, words, ground = null) {
    const { width, height, scale, top } = view;
    const step = stepOf(view);
    const first = Math.floor(top / step);
    const drawn = [width, height, scale, first, ordered, limit, ...Object.values(words)].join();
    const lift = `translate(0 ${(-top * scale).toFixed(1)})`;
    this.drawGround(view, ground, words);
    for (const each of [this.ladder, this.limit, this.ordered, this.labels]) {
      each.setAttribute("transform", lift);
    }
    this.light.setAttribute("gradientTransform", lift);
    this.rays.setAttribute("transform", `${lift} translate(${width / 2}) scale(${scale})`);
    if (drawn !== this.drawn) this.draw(view, step, first, { ordered, limit, words });
    this.drawn = drawn;
    this.tidy(view);
  }

  /**
   * @param {View} view
   * @param {number} step
   * @param {number} first
   * @param {{ ordered: number | null, limit: number | null, words: Words }} seen
   */
  draw(view, step, first, { ordered, limit, words }) {
    const { scale } = view;
    set(this.light, { x1: 0, x2: 0, y1: 0, y2: LIT * scale });
    this.drawLadder(view, step, first, words);
    this.drawLine(this.ordered, view, ordered);
    this.drawLimit(view, limit);
    if (ordered !== null) this.drawLabel(view, ordered, "ordered", words);
    if (limit !== null) this.drawLabel(view, limit, "limit", words);
  }

  /** Shows the labels that are whole in the view; that of the limit goes above its line for it. @param {View} view */
  tidy({ height, scale, top, text }) {
    const fits = (/** @type {number} */ y) => y - top * scale > 0.9 * text && y - top * scale < height - 0.3 * text;
    for (const label of this.labels.children) {
      const { below, above } = /** @type {SVGElement} */ (label).dataset;
      if (below && above) label.setAttribute("y", fits(Number(below)) ? below : above);
      label.toggleAttribute("hidden", !fits(Number(label.getAttribute("y"))));
    }
  }

  /** @param {View} view @param {number} step @param {number} first @param {Words} words */
  drawLadder(view, step, first, words) {
    const { width, height, scale } = view;
    const rungs = Math.ceil(height / scale / step) + 2;
    const depths = Array.from({ length: rungs }, (_, rung) => (first + rung) * step);
    const below = depths.filter((depth) => depth >= 0);
    this.ladder.replaceChildren(
      ...below.filter(Boolean).map((depth) => {
        const y = depth * scale;
        return svg("line", { x1: 0, x2: width, y1: y, y2: y, class: "rung" });
      }),
    );
    this.labels.replaceChildren(
      ...below.map((depth) => {
        const y = depth ? depth * scale - 0.4 * view.text : 1.3 * view.text; // below the waves
        const label = svg("text", { x: 0.7 * view.text, y });
        label.textContent = depth ? metres(depth, words) : words.surface;
        return label;
      }),
    );
  }

  /** @param {SVGElement} line @param {View} view @param {number | null} depth */
  drawLine(line, { width, scale }, depth) {
    line.toggleAttribute("hidden", depth === null);
    const y = (depth ?? 0) * scale;
    set(line, { x1: 0, x2: width, y1: y, y2: y });
  }

  /** @param {View} view @param {number | null} limit */
  drawLimit(view, limit) {
    const [shade, line] = /** @type {SVGElement[]} */ ([...this.limit.children]);
    this.limit.toggleAttribute("hidden", limit === null);
    const y = (limit ?? 0) * view.scale;
    const most = view.top * view.scale + 2 * view.height;
    set(shade, { x: 0, y, width: view.width, height: Math.max(most - y, 0) });
    this.drawLine(line, view, limit);
  }

  /** Draws the ground under the boat, where it is in the view. @param {View} view @param {number | null} depth @param {Words} words */
  drawGround({ width, height, scale, top, text }, depth, words) {
    const y = ((depth ?? 0) - top) * scale;
    this.ground.toggleAttribute("hidden", depth === null || y > height);
    if (depth === null) return;
    const [earth, says] = /** @type {SVGElement[]} */ ([...this.ground.children]);
    set(earth, { x: 0, y, width, height: Math.max(height - y, 0) });
    set(says, { x: 0.7 * text, y: Math.min(y + 1.2 * text, height - 0.3 * text) });
    says.textContent = words.ground;
  }

  /** @param {View} view @param {number} depth @param {"ordered" | "limit"} kind @param {Words} words */
  drawLabel(view, depth, kind, words) {
    const [above, below] = [-0.5, 1.3].map((lines) => depth * view.scale + lines * view.text);
    const label = svg("text", { x: view.width - 0.7 * view.text, y: above, class: `of-${kind}` });
    if (kind === "limit") Object.assign(label.dataset, { below, above });
    label.textContent = `${words[kind]} ${metres(depth, words)}`;
    this.labels.append(label);
  }

  /**
   * Moves what moves: the surface, and what drifts past.
   * @param {View} view
   * @param {number} passed [s]
   * @param {number} speed [m/s] past the boat, 0 where nothing is to move
   * @param {number} elevation [m] of the surface over the boat
   */
  flow(view, passed, speed, elevation) {
    this.second += passed;
    this.moved += speed * passed;
    const rise = passed > 0 ? (elevation - this.elevation) / passed : 0;
    this.rise += (rise - this.rise) * Math.min(passed / 0.5, 1);
    this.elevation = elevation;
    const [x, y] = [-this.moved * view.scale, -view.top * view.scale].map((each) => each % DRIFT);
    this.drift.setAttribute("patternTransform", `translate(${x.toFixed(1)} ${y.toFixed(1)})`);
    this.drawSurface(view);
  }

  /** @param {View} view */
  drawSurface(view) {
    const { width, height, scale, top } = view;
    const surface = -top * scale;
    const seen = surface > -6 * scale;
    this.crest.toggleAttribute("hidden", !seen);
    this.veil.toggleAttribute("hidden", !seen);
    if (!seen) {
      this.fill(`M0 0H${width}`, height);
      return;
    }
    const step = Math.max(width / 90, 6);
    let line = "";
    for (let x = 0; x <= width + step; x += step) {
      const y = surface - this.heightAt((x - width / 2) / scale) * scale;
      line += `${x ? "L" : "M"}${x.toFixed(0)} ${y.toFixed(1)}`;
    }
    this.crest.setAttribute("d", line);
    this.fill(line, height);
    this.veil.setAttribute("d", `${line}V${(surface + 14 * scale).toFixed(1)}H0Z`);
  }

  /** Fills all below a line with water. @param {string} line @param {number} height */
  fill(line, height) {
    for (const each of [this.column, this.matter]) each.setAttribute("d", `${line}V${height}H0Z`);
  }

  /**
   * Returns the height of the surface [m], so far ahead of the boat [m]. Over the boat it is what
   * the sea says; elsewhere a wave of ten seconds goes on from there.
   * @param {number} ahead
   */
  heightAt(ahead) {
    const number = (SWELL * SWELL) / GRAVITY;
    const [cosine, sine] = [Math.cos(number * ahead), Math.sin(number * ahead)];
    const wave = this.elevation * cosine + (this.rise / SWELL) * sine;
    const along = ahead + this.moved;
    const short = 0.5 * Math.sin(along / 1.1 - 1.4 * this.second);
    return wave + RIPPLE * (Math.sin(along / 2.9 + this.second) + short);
  }
}

/** Returns the step of the ladder [m] that leaves room for text. @param {View} view */
function stepOf({ scale, text }) {
  return STEPS.find((step) => step * scale > APART * text) ?? STEPS[STEPS.length - 1];
}

/** @param {number} depth @param {Words} words */
function metres(depth, words) {
  return `${Number(inUnit(depth).toFixed(feet ? 0 : 1))} ${words.metres}`;
}

/** @param {Element} element @param {Record<string, number>} values */
function set(element, values) {
  for (const [name, value] of Object.entries(values)) element.setAttribute(name, value.toFixed(1));
}

/** @param {string} id @param {string[]} stops classes of colours @param {string} [units] */
function gradient(id, stops, units = "objectBoundingBox") {
  const last = stops.length - 1;
  return svg(
    "linearGradient",
    { id, x1: 0, x2: 0, y1: 0, y2: 1, gradientUnits: units },
    ...stops.map((name, place) => svg("stop", { offset: place / last, class: name })),
  );
}

/** Returns dots strewn over a tile, always the same. */
function specks() {
  let [path, seed] = ["", 7];
  const next = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
  for (let speck = 0; speck < 26; speck += 1) {
    path += `M${(next() * DRIFT).toFixed(0)} ${(next() * DRIFT).toFixed(0)}h0`;
  }
  return path;
}

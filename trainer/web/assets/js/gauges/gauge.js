// What all instruments have: a picture of fixed size, digits that stay readable, words for the ear.
import { svg, write } from "../draw.js";

const DIGITS = 480; // [ms] between two changes of digits: what flickers cannot be read
const WORDS = 2000; // [ms] between two changes of what a screen reader is told

const LEAST_TEXT = 11.5; // [px]
const SOME = 0.66; // [px] for a unit, below which words that may be spared are left out
const FEW = 0.45; // below which numerals are, too

/** @typedef {[number, number]} Point */

export class Gauge extends HTMLElement {
  connectedCallback() {
    if (this.firstChild) return;
    this.classList.add("gauge");
    this.setAttribute("role", "meter");
    this.wrote = -Infinity;
    this.told = -Infinity;
    this.draw();
  }

  /** Draws what stays as it is. */
  draw() {}

  /** @param {string} name @param {number} otherwise */
  size(name, otherwise) {
    return Number(this.getAttribute(name) ?? otherwise);
  }

  /**
   * Draws a picture, with the cross of old readings over it.
   * @param {Point | null} size its units, null for those of the page
   * @param {...Element} parts
   */
  picture(size, ...parts) {
    const [x1, y1, x2, y2] = ["20%", "20%", "80%", "80%"];
    const picture = svg(
      "svg",
      { viewBox: size ? `0 0 ${size[0]} ${size[1]}` : false, "aria-hidden": "true" },
      ...parts,
      svg("line", { x1, y1, x2, y2, class: "cross" }),
      svg("line", { x1, y1: y2, x2, y2: y1, class: "cross" }),
    );
    this.append(picture);
    if (size) tellScale(this, picture, size);
  }

  /** Changes digits, at most twice a second; returns whether they are shown. @param {Node} node @param {string} text */
  digits(node, text) {
    if (node.textContent === text) return true;
    const now = performance.now();
    if (node.textContent && now - (this.wrote ?? 0) < DIGITS) return false;
    this.wrote = now;
    write(node, text);
    return true;
  }

  /**
   * Tells the value in words, at most once in two seconds.
   * @param {number} value
   * @param {[number, number]} range
   * @param {string} words
   */
  tell(value, [low, high], words) {
    const now = performance.now();
    if (now - (this.told ?? 0) < WORDS) return;
    this.told = now;
    this.setAttribute("aria-valuemin", String(low));
    this.setAttribute("aria-valuemax", String(high));
    this.setAttribute("aria-valuenow", clamp(value, low, high).toFixed(1));
    this.setAttribute("aria-valuetext", words);
  }
}

/**
 * Tells a picture's scale [px for a unit] to its style, so that its words keep a size that is read,
 * and which of them there is room for: `all`, `some` or `few`.
 * @param {HTMLElement} host
 * @param {Element} picture
 * @param {Point} size in its units
 * @param {() => void} [changed] called when there is other room
 */
export function tellScale(host, picture, [wide, high], changed) {
  new ResizeObserver(([{ contentRect: { width, height } }]) => {
    const scale = Math.min(width / wide, height / high);
    if (scale <= 0) return;
    host.style.setProperty("--scale", scale.toFixed(3));
    const room = scale < FEW ? "few" : scale < SOME ? "some" : "all";
    const other = host.dataset.room !== room;
    host.dataset.room = room;
    if (other) changed?.();
  }).observe(picture);
}

/** Returns the size of an instrument's numerals where it is drawn in pixels. @param {Element} element */
export function readable(element) {
  return Math.max(LEAST_TEXT, 0.8 * parseFloat(getComputedStyle(element).fontSize));
}

/** @param {number} value @param {number} low @param {number} high */
export function clamp(value, low, high) {
  return Math.min(Math.max(value, low), high);
}

/**
 * Returns a place on a circle; angles [deg] go clockwise from the top.
 * @param {Point} centre
 * @param {number} radius
 * @param {number} angle
 * @returns {Point}
 */
export function around([x, y], radius, angle) {
  const turned = (angle * Math.PI) / 180;
  return [x + radius * Math.sin(turned), y - radius * Math.cos(turned)];
}

/**
 * Returns the path of an arc between two angles [deg].
 * @param {Point} centre
 * @param {number} radius
 * @param {number} from
 * @param {number} to
 */
export function arc(centre, radius, from, to) {
  const [begin, end] = [around(centre, radius, from), around(centre, radius, to)];
  const long = Math.abs(to - from) > 180 ? 1 : 0;
  const sweep = to > from ? 1 : 0;
  return `M${begin.map(short)}A${radius} ${radius} 0 ${long} ${sweep} ${end.map(short)}`;
}

/** @param {number} value */
function short(value) {
  return value.toFixed(2);
}

/**
 * Returns a tick of a scale, by its rank: 0 is the longest.
 * @param {Point} centre
 * @param {number} radius outer end
 * @param {number} angle
 * @param {0 | 1 | 2} rank
 */
export function tick(centre, radius, angle, rank) {
  const length = [18, 13, 8][rank];
  return line(centre, radius - length, radius, angle, rank === 0 ? "tick" : "tick minor");
}

/**
 * Returns a line along a radius.
 * @param {Point} centre
 * @param {number} inner
 * @param {number} outer
 * @param {number} angle
 * @param {string} style
 */
export function line(centre, inner, outer, angle, style) {
  const [[x1, y1], [x2, y2]] = [around(centre, inner, angle), around(centre, outer, angle)];
  return svg("line", { x1, y1, x2, y2, class: style });
}

/**
 * Returns a text at a place.
 * @param {Point} place
 * @param {string} style
 * @param {string} [words]
 */
export function text([x, y], style, words = "") {
  return svg("text", { x, y, class: style }, words);
}

/**
 * Returns a hollow bug outside a rim, for what is ordered.
 * @param {Point} centre
 * @param {number} radius
 */
export function bug([x, y], radius) {
  return svg("path", { class: "bug", d: `M${x} ${y - radius}l10 -15h-20Z` });
}

/**
 * Turns a part about a centre, or hides it where there is no angle.
 * @param {Element} part
 * @param {number | null} angle
 * @param {Point} centre
 */
export function turn(part, angle, [x, y]) {
  part.toggleAttribute("hidden", angle === null);
  if (angle !== null) part.setAttribute("transform", `rotate(${angle.toFixed(2)} ${x} ${y})`);
}

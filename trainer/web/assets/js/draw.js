// Elements of HTML and SVG, and numbers in words.
// The words come first of all: they translate what the page has before its elements read it.
import { decimals } from "./words.js";

const SVG = "http://www.w3.org/2000/svg";

/**
 * @typedef {Record<string, string | number | boolean | ((event: Event) => void)>} Attributes
 * @typedef {Node | string | null | undefined | false} Child
 */

/**
 * Returns an element of HTML; functions become listeners, false leaves an attribute out.
 * @param {string} name
 * @param {Attributes} [attributes]
 * @param {...Child} children
 * @returns {HTMLElement}
 */
export function html(name, attributes = {}, ...children) {
  return furnish(document.createElement(name), attributes, children);
}

/**
 * Returns an element of SVG.
 * @param {string} name
 * @param {Attributes} [attributes]
 * @param {...Child} children
 * @returns {SVGElement}
 */
export function svg(name, attributes = {}, ...children) {
  const element = /** @type {SVGElement} */ (document.createElementNS(SVG, name));
  return furnish(element, attributes, children);
}

/**
 * @template {Element} T
 * @param {T} element
 * @param {Attributes} attributes
 * @param {Child[]} children
 */
function furnish(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(name, value);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false) element.setAttribute(name, String(value));
  }
  element.append(...children.filter((child) => child || child === "").map((child) => child || ""));
  return element;
}

/** Returns the element that a selector finds, which has to be there. @param {string} selector */
export function one(selector, within = /** @type {ParentNode} */ (document)) {
  const found = within.querySelector(selector);
  if (!found) throw new Error(`the page has no ${selector}`);
  return /** @type {HTMLElement} */ (found);
}

/** Changes a text only where it is another. @param {Node} node @param {string} text */
export function write(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** Returns a time such as 01:34, with hours from the first one on. @param {number} seconds */
export function clock(seconds) {
  const whole = Math.max(0, Math.floor(seconds));
  const parts = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60, whole % 60];
  const shown = parts[0] ? parts : parts.slice(1);
  return shown.map((part) => String(part).padStart(2, "0")).join(":");
}

/** Returns a heading in three digits. @param {number} degrees */
export function bearing(degrees) {
  return String(((Math.round(degrees) % 360) + 360) % 360).padStart(3, "0");
}

/** Returns how many digits after the mark a number needs, one at most. @param {number} value */
function tenthsOf(value) {
  return Number.isInteger(Number(value.toFixed(1))) ? 0 : 1;
}

/** Returns a number in tenths, which whole numbers leave out. @param {number} value */
export function tenths(value) {
  return decimals(value, tenthsOf(value));
}

/** Returns an ordered size and its side: `15 right`, `0.3 rise`. @param {number} value @param {string} negative @param {string} positive */
export function sidedOrder(value, negative, positive) {
  return sided(value, negative, positive, tenthsOf(value));
}

/**
 * Returns a size and a side in words, as `3.2 down`; nothing has no side.
 * @param {number} value
 * @param {string} negative
 * @param {string} positive
 * @param {number} [digits]
 */
export function sided(value, negative, positive, digits = 1) {
  const size = decimals(Math.abs(value), digits);
  return Number(Math.abs(value).toFixed(digits)) === 0 ? size : `${size} ${value < 0 ? negative : positive}`;
}

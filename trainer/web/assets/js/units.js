// Lengths in the unit that is chosen: metres or feet. Speeds are knots, as everywhere at sea.
import { decimals, short } from "./words.js";

const FOOT = 0.3048; // [m]
const KEPT = "units"; // where the browser keeps the choice
const UNITS = ["m", "ft"];

/** The unit of lengths: `m` or `ft`. */
export const unit = UNITS.find((each) => each === chosen()) ?? UNITS[0];

/** Whether lengths are in feet. */
export const feet = unit === "ft";

/** Returns a length in the unit chosen. @param {number} metres */
export function inUnit(metres) {
  return feet ? metres / FOOT : metres;
}

/** Returns the digits of a length; those of feet are one fewer. @param {number} metres */
export function lengthDigits(metres, digits = 1) {
  return decimals(inUnit(metres), feet ? Math.max(digits - 1, 0) : digits);
}

/** Returns a length with its unit. @param {number} metres */
export function lengthOf(metres, digits = 1) {
  return `${lengthDigits(metres, digits)} ${unit}`;
}

/** Returns a whole length as short as it is known, with its unit. @param {number} metres */
export function shortLength(metres) {
  return `${short(feet ? Math.round(inUnit(metres)) : metres)} ${unit}`;
}

/** Keeps a unit for this browser. @param {string} wanted */
export function keepUnit(wanted) {
  localStorage.setItem(KEPT, wanted);
}

function chosen() {
  // A worker shows nothing, and the sentences of the kiosk are in metres.
  if (globalThis.document?.body.classList.contains("kiosk") ?? true) return null;
  return new URLSearchParams(location.search).get("units") ?? localStorage.getItem(KEPT);
}

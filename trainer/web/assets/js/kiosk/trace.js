// The way of a dive, depth downwards against time.
import { svg } from "../draw.js";

const ABOVE = 8; // [m] of the picture over the shallowest depth
const BELOW = 12; // [m] under the deepest

/**
 * Draws a dive into a picture of SVG.
 * @param {Element} picture
 * @param {import("./dive.js").Dive} dive
 * @param {number} lasts [s]
 */
export function drawTrace(picture, dive, lasts) {
  const { width, height } = picture.getBoundingClientRect();
  picture.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const depths = [dive.target, ...dive.track.map(({ depth }) => depth)];
  const [top, foot] = [Math.min(...depths) - ABOVE, Math.max(...depths) + BELOW];
  const x = (/** @type {number} */ seconds) => ((seconds / lasts) * width).toFixed(1);
  const y = (/** @type {number} */ depth) => (((depth - top) / (foot - top)) * height).toFixed(1);
  const way = dive.track.map(({ seconds, depth }) => `${x(seconds)},${y(depth)}`).join(" ");
  const label = svg("text", { x: 8, y: Number(y(dive.target)) - 6 });
  label.textContent = `${dive.target} m`;
  picture.replaceChildren(
    svg("line", { x1: 0, x2: width, y1: y(dive.target), y2: y(dive.target), class: "wanted" }),
    svg("polyline", { points: way, class: "way" }),
    label,
  );
}

// What is before and behind the sea: the sky, and the water that runs over the glass.
import { parts } from "./ships.js";

/**
 * @typedef {import("./scope-view.js").Light} Light
 * @typedef {import("./scope-view.js").Scene} Scene
 */

const STARS = 220;
const CLOUDS = 26;
const BUBBLES = 46;
const DROPS = 34;

/** Returns a number from 0 to 1 that is always the same. @param {number} place @param {number} which */
function chance(place, which) {
  const mixed = Math.sin(place * 127.1 + which * 311.7) * 43758.5453;
  return mixed - Math.floor(mixed);
}

/**
 * Draws the sky down to the horizon, by true bearings: it stays where it is as the boat turns.
 * @param {CanvasRenderingContext2D} pen
 * @param {{ scene: Scene, light: Light, scale: number, reach: number, field: number }} what
 */
export function drawSky(pen, { scene, light, scale, reach, field }) {
  const sky = pen.createLinearGradient(0, -Math.min(reach, 0.35 * scale), 0, 4);
  sky.addColorStop(0, light.high);
  sky.addColorStop(1, light.low);
  pen.fillStyle = sky;
  pen.fillRect(-reach, -reach, 2 * reach, reach + 8);
  const way = (scene.bearing * Math.PI) / 180;
  const [count, draw] = light.stars ? [STARS, star] : [CLOUDS, cloud];
  for (let i = 0; i < count; i++) {
    const off = 2 * Math.PI * chance(i, 1) - way;
    const beside = off - 2 * Math.PI * Math.round(off / (2 * Math.PI));
    if (Math.abs(beside) < 0.8 * field + 0.12) draw(pen, i, beside * scale, scale, light);
  }
  pen.globalAlpha = 1;
}

/** @param {CanvasRenderingContext2D} pen @param {number} i @param {number} x @param {number} scale */
function star(pen, i, x, scale) {
  pen.fillStyle = "#dfe6f2";
  pen.globalAlpha = 0.25 + 0.6 * chance(i, 3);
  const size = 0.8 + chance(i, 4);
  pen.fillRect(x, -(0.01 + 0.4 * chance(i, 2)) * scale, size, size);
}

/** @param {CanvasRenderingContext2D} pen @param {number} i @param {number} x @param {number} scale @param {Light} light */
function cloud(pen, i, x, scale, light) {
  pen.fillStyle = light.lamps ? "#5a4a55" : "#f7fafb";
  pen.globalAlpha = 0.1 + 0.13 * chance(i, 3);
  const y = -(0.02 + 0.2 * chance(i, 2)) * scale;
  const wide = (0.03 + 0.07 * chance(i, 4)) * scale;
  for (let part = 0; part < 4; part++) {
    const off = (chance(i, 5 + part) - 0.5) * 1.4 * wide;
    pen.beginPath();
    pen.ellipse(x + off, y - 0.1 * wide * chance(i, 9 + part), 0.5 * wide, 0.07 * wide, 0, 0, 7);
    pen.fill();
  }
}

/**
 * Draws the sea over the glass, from below.
 * @param {CanvasRenderingContext2D} pen
 * @param {number[]} circle
 * @param {{ covered: number, light: Light, seconds: number, depth: number }} how
 */
export function drawBubbles(pen, [x, y, radius], { covered, light, seconds, depth }) {
  const top = y + radius - 2 * radius * covered;
  const dim = Math.exp(-0.35 * depth);
  const [red, green, blue] = parts(light.under);
  const water = pen.createLinearGradient(0, y - radius, 0, y + radius);
  const shade = (/** @type {number} */ size) => `rgb(${[red, green, blue].map((each) => Math.round(each * size)).join()})`;
  water.addColorStop(0, shade(1.7 * dim));
  water.addColorStop(1, shade(0.45 * dim));
  pen.fillStyle = water;
  pen.beginPath();
  pen.moveTo(x - radius, y + radius);
  for (let i = 0; i <= 24; i++) {
    const wave = covered < 1 ? 0.04 * radius * Math.sin(0.9 * i + 5 * seconds) : 0;
    pen.lineTo(x - radius + (i / 12) * radius, top + wave);
  }
  pen.lineTo(x + radius, y + radius);
  pen.fill();
  pen.strokeStyle = light.foam;
  pen.lineWidth = 1;
  for (let i = 0; i < BUBBLES; i++) {
    const rise = (chance(i, 1) + seconds * (0.12 + 0.3 * chance(i, 2))) % 1;
    const at = y + radius - 2 * radius * rise;
    if (at < top) continue;
    pen.globalAlpha = 0.5 * dim * (1 - rise) * covered;
    pen.beginPath();
    pen.arc(x + (2 * chance(i, 3) - 1) * radius, at, (0.004 + 0.016 * chance(i, 4)) * radius, 0, 7);
    pen.stroke();
  }
  pen.globalAlpha = 1;
}

/**
 * Draws drops that run off the glass.
 * @param {CanvasRenderingContext2D} pen
 * @param {number[]} circle
 * @param {number} left share of them
 * @param {number} since [s]
 */
export function drawDrops(pen, [x, y, radius], left, since) {
  pen.fillStyle = "#dfeaee";
  pen.globalAlpha = 0.3 * left * left;
  pen.fillRect(x - radius, y - radius, 2 * radius, 2 * radius);
  for (let i = 0; i < DROPS; i++) {
    const size = (0.012 + 0.035 * chance(i, 3)) * radius;
    const at = [
      x + (2 * chance(i, 1) - 1) * radius,
      y + (2 * chance(i, 2) - 1) * radius + 0.5 * radius * chance(i, 4) * since * since,
    ];
    pen.globalAlpha = 0.5 * left;
    pen.fillStyle = "#cfdde2";
    pen.beginPath();
    pen.ellipse(at[0], at[1], size, size * (1.2 + since * chance(i, 5)), 0, 0, 7);
    pen.fill();
    pen.globalAlpha = 0.7 * left;
    pen.fillStyle = "#ffffff";
    pen.beginPath();
    pen.arc(at[0] - 0.3 * size, at[1] - 0.4 * size, 0.22 * size, 0, 7);
    pen.fill();
  }
  pen.globalAlpha = 1;
}

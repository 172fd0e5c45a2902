// A strip chart: what was ordered (dashed) and what was (solid), over the last minutes.
import { clock } from "../draw.js";
import { Chart, signed, stepOf, stroke } from "./chart.js";
import { unit as unitOfLength } from "../units.js";
import { say } from "../words.js";

/**
 * @typedef {[number, number | null][]} Points times [s] and values; null leaves a gap
 * @typedef {object} Series
 * @property {Points} actual
 * @property {Points} ordered
 * @property {Points} ghost the reference crew's run
 * @property {Points} ahead where it goes from now on
 * @property {number} now [s] at the right end, but for what is ahead
 * @property {number} span [s] of the whole width
 * @property {number} low
 * @property {number} high
 * @property {number} step of the grid
 * @property {[number, number][]} shaded times [s] from and to, when something was broken
 * @property {number | null} limit
 *
 * @typedef {import("./chart.js").Area & { left: number, right: number, top: number, bottom: number,
 *   end: number, x: (seconds: number) => number, y: (value: number) => number }} Frame
 */

const TIMES = [10, 30, 60, 120, 300, 600, 900, 1800]; // [s] between marks of time
const GAP = 30; // [s] without a reading, over which no line is drawn

/** `<strip-chart label unit [down]>`: `down` has greater values below, as depth has. */
export class StripChart extends Chart {
  /** @param {Series} series */
  show(series) {
    this.series = series;
    this.draw();
  }

  draw() {
    const { series } = this;
    const area = series && this.begin();
    if (!series || !area) return;
    const frame = this.frame(area, series);
    shade(frame, series);
    grid(frame, series);
    if (series.limit !== null) limit(frame, series.limit);
    lines(frame, series);
    this.name(frame);
    ends(frame, series);
    this.say(series);
  }

  /** @param {import("./chart.js").Area} area @param {Series} series @returns {Frame} */
  frame(area, { ahead, low, high, now, span }) {
    const { width, height, size, pen } = area;
    const wide = [low, high].map((value) => pen.measureText(signed(value, 0)).width);
    const [left, right] = [Math.max(...wide) + 8, width - 4];
    const [top, bottom] = [size * 1.75, height - size * 1.7];
    const down = this.hasAttribute("down");
    const end = ahead.at(-1)?.[0] ?? now; // [s]
    const whole = span + end - now;
    const x = (/** @type {number} */ seconds) => right - ((end - seconds) / whole) * (right - left);
    const y = (/** @type {number} */ value) => {
      const share = (value - low) / (high - low);
      return top + (down ? share : 1 - share) * (bottom - top);
    };
    return { ...area, left, right, top, bottom, end, x, y };
  }

  /** @param {Frame} frame */
  name({ pen, size, left, right, colour, face }) {
    pen.textAlign = "left";
    pen.font = `400 ${size}px ${face}`;
    pen.fillStyle = colour("ink-2");
    const label = this.getAttribute("label") ?? "";
    const names = [`${label}, ${this.unit}`, label];
    const fits = (/** @type {string} */ name) => pen.measureText(name).width < right - left - 4 * size;
    const told = names.find(fits) ?? label.split(",")[0];
    const from = fits(told) ? left : 0; // over the numbers of the axis, where there is no other room
    pen.fillText(told, from, size * 0.8, right - from - 4 * size);
  }

  /** The unit, as people write it. */
  get unit() {
    const told = this.getAttribute("unit") ?? "";
    return { m: unitOfLength, deg: say("deg") }[told] ?? told;
  }

  /** Says in words what is seen. @param {Series} series */
  say({ actual, ordered, ghost, ahead, span }) {
    const [unit, now, told] = [this.unit, actual.at(-1)?.[1], ordered.at(-1)?.[1]];
    const value = now == null ? say("nothing yet") : say("now {0} {1}", signed(now, 1), unit);
    const order = told == null ? [] : [say("ordered {0}", signed(told, 1))];
    const [beside, there] = [ghost.at(-1)?.[1], ahead.at(-1)?.[1]];
    if (beside != null) order.push(say("ghost {0}", signed(beside, 1)));
    if (there != null) order.push(say("ahead {0}", signed(there, 1)));
    const title = this.getAttribute("label") ?? "";
    const words = [title, say("last {0} minutes", span / 60), value, ...order].join(", ");
    if (this.getAttribute("aria-label") !== words) this.setAttribute("aria-label", words);
  }
}
customElements.define("strip-chart", StripChart);

/** @param {Frame} frame @param {Series} series */
function shade({ pen, x, left, right, top, bottom, colour }, { shaded }) {
  pen.fillStyle = colour("warning");
  pen.globalAlpha = 0.14;
  for (const [from, to] of shaded) {
    const [begin, end] = [Math.max(left, x(from)), Math.min(right, x(to))];
    if (end > begin) pen.fillRect(begin, top, end - begin, bottom - top);
  }
  pen.globalAlpha = 1;
}

/** @param {Frame} frame @param {Series} series */
function grid(frame, { low, high, step, now, span }) {
  const { pen, x, y, left, right, top, bottom, size, colour, end } = frame;
  pen.lineWidth = 1;
  pen.strokeStyle = colour("line");
  pen.fillStyle = colour("ink-2");
  pen.textAlign = "right";
  const each = Math.ceil((size * 1.2) / Math.abs(y(step) - y(0)));
  for (let index = 0; low + index * step <= high + 1e-9; index += 1) {
    const value = low + index * step;
    const at = Math.round(y(value)) + 0.5;
    stroke(pen, [left, at, right, at]);
    if (index % each === 0) pen.fillText(signed(value, 0), left - 5, at);
  }
  pen.textAlign = "center";
  const between = stepOf(TIMES, (right - left) / (span + end - now), size * 4.2);
  for (let at = Math.ceil((now - span) / between) * between; at <= end; at += between) {
    if (at < 0) continue;
    const place = Math.round(x(at)) + 0.5;
    stroke(pen, [place, top, place, bottom + 3]);
    pen.fillText(clock(at), Math.min(Math.max(place, left + size), right - size * 1.3), bottom + size);
  }
}

/** @param {Frame} frame @param {number} value */
function limit({ pen, y, left, right, top, bottom, colour }, value) {
  const at = y(value);
  if (at < top || at > bottom) return;
  pen.strokeStyle = colour("warning-line");
  pen.lineWidth = 1.5;
  stroke(pen, [left, at, right, at]);
}

/** @param {Frame} frame @param {Series} series */
function lines(frame, { actual, ordered, ghost, ahead, now }) {
  const { pen, left, right, top, bottom, size, colour, end, x } = frame;
  pen.save();
  pen.beginPath();
  pen.rect(left, top - 2, right - left, bottom - top + 4);
  pen.clip();
  pen.setLineDash([size / 2, size / 3]);
  trace(frame, ordered, colour("ordered"), size / 8);
  pen.setLineDash([size / 8, size / 3]);
  trace(frame, ghost, colour("ink-2"), size / 6);
  pen.setLineDash([size / 5, size / 5]);
  trace(frame, ahead, colour("actual"), size / 8);
  pen.setLineDash([]);
  pen.strokeStyle = colour("ink-2");
  pen.lineWidth = 1;
  if (end > now) stroke(pen, [x(now), top, x(now), bottom]);
  trace(frame, actual, colour("actual"), size / 6.5);
  pen.restore();
}

/** @param {Frame} frame @param {Points} points @param {string} style @param {number} wide */
function trace({ pen, x, y }, points, style, wide) {
  pen.strokeStyle = style;
  pen.lineWidth = wide;
  pen.beginPath();
  let before = -Infinity;
  for (const [at, value] of points) {
    if (value === null) before = -Infinity;
    else {
      if (at - before > GAP) pen.moveTo(x(at), y(value));
      else pen.lineTo(x(at), y(value));
      before = at;
    }
  }
  pen.stroke();
}

/** An arrow head for the order at the right end, and the value as a number above it. @param {Frame} frame @param {Series} series */
function ends({ pen, x, y, right: edge, top, bottom, size, colour, face }, { actual, ordered, now }) {
  const right = Math.min(x(now), edge);
  const [is, told] = [actual.at(-1)?.[1], ordered.at(-1)?.[1]];
  const near = (/** @type {number} */ value) => Math.min(bottom, Math.max(top, y(value)));
  if (told != null) {
    const at = near(told);
    pen.strokeStyle = colour("ordered");
    pen.lineWidth = 2;
    pen.beginPath();
    pen.moveTo(right, at);
    pen.lineTo(right - size * 0.7, at - size * 0.4);
    pen.lineTo(right - size * 0.7, at + size * 0.4);
    pen.closePath();
    pen.stroke();
  }
  if (is == null) return;
  pen.textAlign = "right";
  pen.font = `500 ${size * 1.25}px ${face}`;
  pen.fillStyle = colour("actual");
  pen.fillText(signed(is, Math.abs(is) < 100 ? 1 : 0), edge, size * 0.8);
}

// A strip chart: what was ordered (dashed) and what was (solid), over the last minutes.
import { clock } from "../draw.js";
import { Chart, signed, stepOf, stroke } from "./chart.js";

/**
 * @typedef {[number, number | null][]} Points times [s] and values; null leaves a gap
 * @typedef {object} Series
 * @property {Points} actual
 * @property {Points} ordered
 * @property {number} now [s] at the right end
 * @property {number} span [s] of the whole width
 * @property {number} low
 * @property {number} high
 * @property {number} step of the grid
 * @property {[number, number][]} shaded times [s] from and to, when something was broken
 * @property {number | null} limit
 * @property {number | null} cursor [s] the moment that is looked at
 *
 * @typedef {import("./chart.js").Area & { left: number, right: number, top: number, bottom: number,
 *   x: (seconds: number) => number, y: (value: number) => number }} Frame
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
  frame(area, { low, high, now, span }) {
    const { width, height, size } = area;
    const [left, right] = [size * 2.7, width - size * 4.5];
    const [top, bottom] = [size * 1.75, height - size * 1.7];
    const down = this.hasAttribute("down");
    const x = (/** @type {number} */ seconds) => right - ((now - seconds) / span) * (right - left);
    const y = (/** @type {number} */ value) => {
      const share = (value - low) / (high - low);
      return top + (down ? share : 1 - share) * (bottom - top);
    };
    return { ...area, left, right, top, bottom, x, y };
  }

  /** @param {Frame} frame */
  name({ pen, size, left, colour, face }) {
    pen.textAlign = "left";
    pen.font = `400 ${size}px ${face}`;
    pen.fillStyle = colour("ink-2");
    pen.fillText(`${this.getAttribute("label")}, ${this.getAttribute("unit")}`, left, size * 0.8);
  }

  /** Says in words what is seen. @param {Series} series */
  say({ actual, ordered, span }) {
    const [unit, now, told] = [this.getAttribute("unit"), actual.at(-1)?.[1], ordered.at(-1)?.[1]];
    const value = now == null ? "nothing yet" : `now ${signed(now, 1)} ${unit}`;
    const order = told == null ? "" : `, ordered ${signed(told, 1)}`;
    const words = `${this.getAttribute("label")}, last ${span / 60} minutes, ${value}${order}`;
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
  const { pen, x, y, left, right, top, bottom, size, colour } = frame;
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
  const between = stepOf(TIMES, (right - left) / span, size * 4.2);
  for (let at = Math.ceil((now - span) / between) * between; at <= now; at += between) {
    if (at < 0) continue;
    const place = Math.round(x(at)) + 0.5;
    stroke(pen, [place, top, place, bottom + 3]);
    pen.fillText(clock(at), Math.min(Math.max(place, left + size), right), bottom + size);
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
function lines(frame, { actual, ordered, cursor }) {
  const { pen, x, left, right, top, bottom, size, colour } = frame;
  pen.save();
  pen.beginPath();
  pen.rect(left, top - 2, right - left, bottom - top + 4);
  pen.clip();
  pen.setLineDash([size / 2, size / 3]);
  trace(frame, ordered, colour("ordered"), size / 8);
  pen.setLineDash([]);
  trace(frame, actual, colour("actual"), size / 6.5);
  if (cursor !== null) {
    pen.strokeStyle = colour("ordered");
    pen.lineWidth = 2;
    stroke(pen, [x(cursor), top, x(cursor), bottom]);
  }
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

/** The values at the right end: a number, and an arrow head for the order. @param {Frame} frame @param {Series} series */
function ends({ pen, y, right, top, bottom, size, colour, face }, { actual, ordered }) {
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
  pen.textAlign = "left";
  pen.font = `500 ${size * 1.25}px ${face}`;
  pen.fillStyle = colour("actual");
  pen.fillText(signed(is, Math.abs(is) < 100 ? 1 : 0), right + 5, near(is));
}

// The sea as it is seen from a little above it: ranges from far to near, each over the one before.
import { parts } from "./ships.js";

const COLUMNS = 97;
const RANGES = 32;
const NEAREST = 5; // [m]
const FURTHEST = 1000; // [m] beyond it waves are a line
const TONES = 33; // of one range
const STEEP = 0.2; // slope that has the darkest tone
const STOPS = 4; // columns from one stop of a range's colours to the next
const CLOSE = 60; // [m] nearer than which waves are wide on the screen, and need few corners
const CORNERS = [4, 2]; // columns from corner to corner, close and further away
const RIPPLES = 160; // [m] to which the wind's own ripples are seen
const EARTH = 6371e3 / 0.8279; // [m] by which light is bent, as the session has it
const OVERLAP = 3; // [px] of ranges under nearer ones, whose corners are others

/**
 * @typedef {{ dark: string, mean: string, light: string, far: string, foam: string }} Colours
 * @typedef {object} Outlook where it is drawn, and from where
 * @property {CanvasRenderingContext2D} pen
 * @property {number} eye [m] over the waves at the boat
 * @property {number} level [m] of them there
 * @property {number} train [rad]
 * @property {number} field [rad]
 * @property {number} centre [px]
 * @property {number} horizontal [px] of elevation 0
 * @property {number} scale [px] of a radian
 * @property {number} foot [px] of the lowest that is seen
 * @property {Colours} colours
 * @property {number} seconds
 *
 * @typedef {{ distance: number, draw: () => void }} Among what is drawn between the ranges
 */

export class Water {
  constructor() {
    this.levels = new Float64Array(COLUMNS * RANGES);
    this.heights = new Float64Array(COLUMNS * RANGES); // [px] on the screen
    this.ahead = new Float64Array(COLUMNS * RANGES); // [m] off the boat
    this.right = new Float64Array(COLUMNS * RANGES);
    this.ranges = new Float64Array(RANGES);
    this.ripple = 0; // share of a tone
    this.way = 0; // [m] that the boat has gone
    /** @type {string[][]} */
    this.paints = [];
    this.painted = "";
  }

  /**
   * Draws the sea and what is on it, the furthest first.
   * @param {import("./sea.js").Sea} sea
   * @param {Outlook} outlook
   * @param {Among[]} among from near to far
   */
  draw(sea, outlook, among) {
    this.ripple = 0.12 + Math.min(0.2 * sea.height, 0.2);
    this.way = sea.ahead * outlook.seconds;
    this.spread(outlook);
    this.measure(sea, outlook);
    this.mix(outlook.colours);
    this.drawDistance(outlook);
    const waiting = [...among];
    for (let range = RANGES - 1; range > 0; range--) {
      while (waiting.length && waiting[waiting.length - 1].distance > this.ranges[range]) waiting.pop()?.draw();
      this.drawRange(range, outlook);
      this.drawFoam(range, outlook, sea.height);
    }
    for (const each of waiting.reverse()) each.draw();
    this.drawFoot(outlook);
  }

  /** Fills what is between the horizon and the furthest range, and no more. @param {Outlook} outlook */
  drawDistance({ pen, eye, scale, centre, horizontal, field, colours }) {
    const top = horizontal + Math.sqrt((2 * eye) / EARTH) * scale;
    const lowest = Math.max(...this.heights.subarray((RANGES - 1) * COLUMNS));
    pen.fillStyle = colours.far;
    pen.fillRect(centre - 0.5 * field * scale, top, field * scale, Math.max(lowest - top, 0) + OVERLAP);
  }

  /** Sets the ranges, from the nearest that is seen. @param {Outlook} outlook */
  spread({ eye, scale, horizontal, foot }) {
    const lowest = Math.max((foot - horizontal) / scale, 0.02);
    const nearest = Math.max(NEAREST, (0.7 * Math.max(eye, 0.3)) / Math.tan(lowest));
    const first = Math.min(nearest, 0.2 * FURTHEST);
    for (let i = 0; i < RANGES; i++) this.ranges[i] = first * (FURTHEST / first) ** (i / (RANGES - 1));
  }

  /** Finds the level of each point, and where it is seen. @param {import("./sea.js").Sea} sea @param {Outlook} outlook */
  measure(sea, { eye, level, train, field, horizontal, scale }) {
    const base = eye + level;
    for (let column = 0; column < COLUMNS; column++) {
      const angle = train + (column / (COLUMNS - 1) - 0.5) * field;
      const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
      for (let range = 0; range < RANGES; range++) {
        const away = this.ranges[range];
        const water = sea.level(away * cos, away * sin);
        const at = range * COLUMNS + column;
        this.levels[at] = water;
        this.ahead[at] = away * cos;
        this.right[at] = away * sin;
        this.heights[at] = horizontal - ((water - base) / away - away / (2 * EARTH)) * scale;
      }
    }
  }

  /** Mixes the tones of each range. @param {Colours} colours */
  mix({ dark, mean, light, far }) {
    const name = [dark, mean, light, far].join();
    if (this.painted === name) return;
    this.painted = name;
    const [low, middle, high, haze] = [dark, mean, light, far].map(parts);
    this.paints = Array.from({ length: RANGES }, (_, range) => {
      const away = range / (RANGES - 1);
      return Array.from({ length: TONES }, (_each, tone) => {
        const share = tone / (TONES - 1);
        const [from, to, part] = share < 0.5 ? [low, middle, 2 * share] : [middle, high, 2 * share - 1];
        return `rgb(${from.map((own, i) => Math.round(blend(blend(own, to[i], part), haze[i], away ** 2.2))).join()})`;
      });
    });
  }

  /** Returns the tone of a piece of the sea: what faces the eye is dark. @param {number} range @param {number} column @param {number} seconds */
  toneOf(range, column, seconds) {
    const at = range * COLUMNS + column;
    const away = this.ranges[range];
    const slope = (this.levels[at] - this.levels[at - COLUMNS]) / (away - this.ranges[range - 1]);
    let tone = 0.5 - (0.5 * slope) / STEEP;
    if (away < RIPPLES && this.ripple) {
      const [x, y] = [this.ahead[at] + this.way, this.right[at]];
      const fine = Math.sin(0.9 * x + 2.1 * seconds + Math.sin(0.7 * y)) * Math.sin(1.3 * y - 0.4 * x + 1.7 * seconds);
      tone += this.ripple * fine * (1 - away / RIPPLES);
    }
    return Math.min(Math.max(Math.round(tone * (TONES - 1)), 0), TONES - 1);
  }

  /** Fills a range down to the next one, its tones running into each other. @param {number} range @param {Outlook} outlook */
  drawRange(range, outlook) {
    const { pen, seconds } = outlook;
    const [far, near] = [range * COLUMNS, (range - 1) * COLUMNS];
    const [first, last] = this.seen(far, outlook);
    const [left, right] = [this.across(first, outlook), this.across(last, outlook)];
    const paint = pen.createLinearGradient(left, 0, right, 0);
    for (let column = first; column <= last; column += STOPS) {
      paint.addColorStop((column - first) / (last - first), this.paints[range][this.toneOf(range, column, seconds)]);
    }
    const step = CORNERS[this.ranges[range] < CLOSE ? 0 : 1];
    pen.fillStyle = paint;
    pen.beginPath();
    for (let column = first; column <= last; column += step) {
      pen.lineTo(this.across(column, outlook), this.heights[far + column]);
    }
    for (let column = last; column >= first; column -= step) {
      const below = Math.max(this.heights[near + column], this.heights[far + column]);
      pen.lineTo(this.across(column, outlook), below + OVERLAP);
    }
    pen.fill();
  }

  /** Returns the first and the last column of a range that are within the round view. @param {number} far where the range begins @param {Outlook} outlook */
  seen(far, { foot, field, scale }) {
    const top = Math.max(Math.min(...this.heights.subarray(far, far + COLUMNS)), 0);
    const half = Math.sqrt(Math.max(foot * foot - top * top, 0)) / (field * scale);
    const beyond = Math.max(Math.floor(((0.5 - half) * (COLUMNS - 1)) / STOPS), 0) * STOPS;
    return beyond < (COLUMNS - 1) / 2 ? [beyond, COLUMNS - 1 - beyond] : [0, COLUMNS - 1];
  }

  /** Draws white water along the crests that are highest. @param {number} range @param {Outlook} outlook @param {number} height [m] significant */
  drawFoam(range, outlook, height) {
    const { pen, scale } = outlook;
    const away = this.ranges[range];
    if (height < 0.6 || away > 500) return;
    const least = Math.min(Math.max(0.64 - 0.05 * height, 0.38), 0.6) * height;
    pen.strokeStyle = outlook.colours.foam;
    pen.lineWidth = Math.min(Math.max((0.1 * height * scale) / away / 6, 0.7), 9);
    pen.globalAlpha = 0.55;
    pen.beginPath();
    for (let column = 1; column < COLUMNS; column++) {
      const at = range * COLUMNS + column;
      const crest = this.levels[at] > least && this.levels[at] > this.levels[at - COLUMNS];
      if (!crest || Math.sin(7.3 * this.right[at] + 3.1 * (this.ahead[at] + this.way)) < 0.1) continue;
      pen.moveTo(this.across(column - 1, outlook), this.heights[at - 1]);
      pen.lineTo(this.across(column, outlook), this.heights[at]);
    }
    pen.stroke();
    pen.globalAlpha = 1;
  }

  /** Fills what is nearer than the nearest range. @param {Outlook} outlook */
  drawFoot(outlook) {
    const { pen, foot } = outlook;
    pen.fillStyle = this.paints[0][Math.floor(0.4 * TONES)];
    pen.beginPath();
    pen.moveTo(this.across(0, outlook), foot);
    for (let column = 0; column < COLUMNS; column++) pen.lineTo(this.across(column, outlook), this.heights[column]);
    pen.lineTo(this.across(COLUMNS - 1, outlook), foot);
    pen.fill();
  }

  /** Returns where a column is seen [px]. @param {number} column @param {Outlook} outlook */
  across(column, { centre, field, scale }) {
    return centre + (column / (COLUMNS - 1) - 0.5) * field * scale;
  }
}

/** @param {number} one @param {number} other @param {number} share */
function blend(one, other, share) {
  return one + (other - one) * share;
}

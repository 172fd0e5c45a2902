// The track from above: north up, both ways to one scale, with a bar that tells the scale.
import { Chart, stepOf, stroke } from "./chart.js";
import { lengthOf } from "../units.js";
import { say } from "../words.js";

/**
 * @typedef {[north: number, east: number]} Place [m]
 * @typedef {{ name: string, bearing: number, range: number, course: number }} Ship from the boat
 * @typedef {{ ordered?: number | null, recent?: number, ships?: Ship[] }} More the ordered course [deg],
 *   how many of the last places are drawn full, and ships near
 * @typedef {import("./chart.js").Area & { x: (east: number) => number,
 *   y: (north: number) => number, scale: number }} Map
 */

const GRID = [50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000]; // [m]
const LEAST = [200, 300]; // [m] to north and to east that are always shown
const EDGE = 40; // [px] beside the track, both sides together
const BOAT = 26; // [px] of the boat's length
const SHIP = 11; // [px] from the middle of a ship to its bow
const FAR = 10_000; // [m] up to which ships widen the map
const SMALLEST = 1e-3; // [px] of a metre, where there is next to no room
const RIGHT = Math.PI / 180;

/** `<track-chart>`: where the boat has been. */
export class TrackChart extends Chart {
  /** @param {Place[]} places oldest first @param {number | null} heading [deg] @param {More} [more] */
  show(places, heading, more = {}) {
    this.shown = { places, heading, more };
    this.draw();
  }

  draw() {
    const area = this.shown && this.begin();
    if (!this.shown || !area) return;
    const { places, heading, more } = this.shown;
    const last = places.at(-1);
    /** @type {(Ship & { place: Place })[]} */
    const ships = (more.ships ?? []).map((ship) => ({ ...ship, place: placeOf(last ?? [0, 0], ship) }));
    const near = ships.filter(({ range }) => range < FAR).map(({ place }) => place);
    /** @type {Place[]} */
    const flown = places.length ? places : [[0, 0]];
    const map = mapOf(area, [...flown, ...near]);
    grid(map);
    for (const ship of ships) mark(map, ship);
    if (last) {
      tail(map, places, more.recent ?? places.length);
      if (more.ordered != null) course(map, last, more.ordered);
      if (heading !== null) boat(map, last, heading);
    }
    north(map);
    this.say(last);
  }

  /** @param {Place | undefined} last */
  say(last) {
    const [north, east] = last ?? [0, 0];
    const [up, across] = [side(north, say("south"), say("north")), side(east, say("west"), say("east"))];
    this.setAttribute("aria-label", say("Track, north up: the boat is {0} and {1} of the start", up, across));
  }
}
customElements.define("track-chart", TrackChart);

/** @param {number} metres @param {string} negative @param {string} positive */
function side(metres, negative, positive) {
  return `${lengthOf(Math.abs(metres), 0)} ${metres < 0 ? negative : positive}`;
}

/** @param {import("./chart.js").Area} area @param {Place[]} places @returns {Map} */
function mapOf(area, places) {
  const ends = [0, 1].map((axis) => {
    const values = places.map((place) => place[axis]);
    return [Math.min(...values), Math.max(...values)];
  });
  const [[south, top], [west, east]] = ends;
  const { width, height } = area;
  const up = (height - EDGE) / Math.max(top - south, LEAST[0]);
  const across = (width - EDGE) / Math.max(east - west, LEAST[1]);
  const scale = Math.max(Math.min(up, across), SMALLEST);
  const [middleN, middleE] = [(south + top) / 2, (west + east) / 2];
  return {
    ...area,
    scale,
    x: (metres) => width / 2 + (metres - middleE) * scale,
    y: (metres) => height / 2 - (metres - middleN) * scale,
  };
}

/** @param {Map} map */
function grid({ pen, width, height, size, colour, x, y, scale }) {
  const step = stepOf(GRID, scale, size * 5);
  pen.strokeStyle = colour("line");
  pen.lineWidth = 1;
  const [left, bottom] = [-x(0) / scale, (y(0) - height) / scale];
  for (let at = Math.ceil(left / step) * step; x(at) < width; at += step) {
    stroke(pen, [x(at), 0, x(at), height]);
  }
  for (let at = Math.ceil(bottom / step) * step; y(at) > 0; at += step) {
    stroke(pen, [0, y(at), width, y(at)]);
  }
  pen.fillStyle = pen.strokeStyle = colour("ink-2");
  const [bar, foot] = [step * scale, height - 10];
  stroke(pen, [10, foot, 10 + bar, foot]);
  for (const end of [10, 10 + bar]) stroke(pen, [end, foot - 4, end, foot + 4]);
  pen.textAlign = "left";
  pen.fillText(step < 1000 ? `${step} m` : `${step / 1000} km`, 16 + bar, foot);
}

/** @param {Place} from @param {Ship} ship @returns {Place} */
function placeOf([north, east], { bearing, range }) {
  return [north + range * Math.cos(bearing * RIGHT), east + range * Math.sin(bearing * RIGHT)];
}

/** A ship is a triangle towards its course, with its name. @param {Map} map @param {Ship & { place: Place }} ship */
function mark({ pen, size, colour, x, y }, { name, course: towards, place: [northward, eastward] }) {
  pen.save();
  pen.translate(x(eastward), y(northward));
  pen.fillStyle = pen.strokeStyle = colour("ink");
  pen.textAlign = "left";
  pen.fillText(name, size * 0.7, 0);
  pen.rotate(towards * RIGHT);
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(0, -SHIP);
  pen.lineTo(SHIP / 2, SHIP / 2);
  pen.lineTo(-SHIP / 2, SHIP / 2);
  pen.closePath();
  pen.stroke();
  pen.restore();
}

/** @param {Map} map @param {Place[]} places @param {number} recent */
function tail({ pen, size, colour, x, y }, places, recent) {
  const divide = Math.max(places.length - recent, 0);
  const draw = (/** @type {Place[]} */ part, /** @type {number} */ wide, /** @type {string} */ style) => {
    pen.lineWidth = wide;
    pen.strokeStyle = style;
    pen.beginPath();
    for (const [northward, eastward] of part) pen.lineTo(x(eastward), y(northward));
    pen.stroke();
  };
  draw(places.slice(0, divide + 1), 1, colour("ink-3"));
  draw(places.slice(divide), size / 6.5, colour("actual"));
}

/** @param {Map} map @param {Place} last @param {number} ordered [deg] */
function course({ pen, size, colour, x, y }, [northward, eastward], ordered) {
  const [angle, long] = [ordered * RIGHT, size * 7];
  const [from, up] = [x(eastward), y(northward)];
  pen.strokeStyle = colour("ordered");
  pen.lineWidth = 1.5;
  pen.setLineDash([6, 5]);
  stroke(pen, [from, up, from + long * Math.sin(angle), up - long * Math.cos(angle)]);
  pen.setLineDash([]);
}

/** @param {Map} map @param {Place} last @param {number} heading [deg] */
function boat({ pen, colour, x, y }, [northward, eastward], heading) {
  pen.save();
  pen.translate(x(eastward), y(northward));
  pen.rotate(heading * RIGHT);
  pen.beginPath();
  pen.moveTo(0, -BOAT / 2);
  pen.bezierCurveTo(BOAT / 6, -BOAT / 3, BOAT / 6, BOAT / 4, 0, BOAT / 2);
  pen.bezierCurveTo(-BOAT / 6, BOAT / 4, -BOAT / 6, -BOAT / 3, 0, -BOAT / 2);
  pen.fillStyle = colour("hull");
  pen.fill();
  pen.strokeStyle = colour("actual");
  pen.lineWidth = 1.6;
  pen.stroke();
  pen.restore();
}

/** @param {Map} map */
function north({ pen, width, size, colour }) {
  const at = width - size * 1.4;
  pen.fillStyle = colour("ink-2");
  pen.textAlign = "center";
  pen.fillText(say("N"), at, size);
  pen.beginPath();
  pen.moveTo(at, size * 1.8);
  pen.lineTo(at - size * 0.45, size * 3);
  pen.lineTo(at + size * 0.45, size * 3);
  pen.closePath();
  pen.fill();
}

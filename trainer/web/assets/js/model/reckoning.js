// Where a boat has sailed by dead reckoning: what its compass and its log have shown.

const KNOT = 0.514444; // [m/s]
const RIGHT = Math.PI / 180;

/** @typedef {[north: number, east: number]} Place [m] */

/**
 * Returns places from the first reading on, at most so many.
 *
 * They are those of a plotting table: speed is through the water, along the heading, and a gauge
 * that lies leads it astray. Between two readings the boat made the mean of both: at a hurried
 * time they are far apart.
 * @param {import("./history.js").Past} past with heading [deg] and speed [kn]
 * @param {number} most
 * @returns {Place[]}
 */
export function reckon({ times, rows }, most) {
  const every = Math.max(Math.ceil(times.length / most), 1);
  const ways = rows.map(velocityOf);
  /** @type {Place[]} */
  const places = [];
  let [north, east] = [0, 0];
  ways.forEach(([northward, eastward], at) => {
    if (at) {
      const half = (times[at] - times[at - 1]) / 2;
      north += half * (northward + ways[at - 1][0]);
      east += half * (eastward + ways[at - 1][1]);
    }
    if (at % every === 0 || at === rows.length - 1) places.push([north, east]);
  });
  return places;
}

/**
 * Returns the velocity through the water that gauges show.
 * @param {Record<string, number>} gauges with heading [deg] and speed [kn]
 * @returns {[north: number, east: number]} [m/s]
 */
function velocityOf({ heading, speed }) {
  const [along, course] = [(speed || 0) * KNOT, (heading || 0) * RIGHT];
  return [along * Math.cos(course), along * Math.sin(course)];
}

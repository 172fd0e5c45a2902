// Where a boat has sailed by dead reckoning: what its compass and its log have shown.

const KNOT = 0.514444; // [m/s]
const RIGHT = Math.PI / 180;

/** @typedef {[north: number, east: number]} Place [m] */

/**
 * Returns places from the first reading on, at most so many.
 *
 * They are those of a plotting table: speed is through the water, along the heading, and a gauge
 * that lies leads it astray.
 * @param {import("./history.js").Past} past with heading [deg] and speed [kn]
 * @param {number} most
 * @returns {Place[]}
 */
export function reckon({ times, rows }, most) {
  const every = Math.max(Math.ceil(times.length / most), 1);
  /** @type {Place[]} */
  const places = [];
  let [north, east] = [0, 0];
  rows.forEach(({ heading, speed }, at) => {
    const way = at ? (times[at] - times[at - 1]) * (speed || 0) * KNOT : 0;
    north += way * Math.cos((heading || 0) * RIGHT);
    east += way * Math.sin((heading || 0) * RIGHT);
    if (at % every === 0 || at === rows.length - 1) places.push([north, east]);
  });
  return places;
}

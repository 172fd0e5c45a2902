// The boat that sails by itself while nobody is there: a picture, of no session's boat.

const ROUND = 84; // [s] from the top of its way to the next
const TOP = 20; // [m]
const FOOT = 50; // [m]
const STEEPEST = 11; // [deg]
const PLANES = { bow: 9, stern: 6 }; // [deg]
const SPEED = 10; // [kn]

/** Returns what is seen of it. @param {number} second */
export function sailing(second) {
  const turn = (2 * Math.PI * second) / ROUND;
  return {
    depth: (TOP + FOOT) / 2 - ((FOOT - TOP) / 2) * Math.cos(turn),
    pitch: -STEEPEST * Math.sin(turn),
    bow: -PLANES.bow * Math.cos(turn),
    stern: -PLANES.stern * Math.cos(turn),
    speed: SPEED,
    ordered: null,
    limit: null,
  };
}

// A gamepad or joystick as a yoke: sideways is the rudder, back is rise.

const OFTEN = 100; // [ms]
const REST = 0.12; // of an axis, about its middle
/** @type {[number, string, number][]} axis, surface, sign */
const AXES = [
  [0, "rudder", 1],
  [1, "stern", 1],
  [3, "bow", 1],
];

/**
 * Calls back when a surface is moved: its name, and a share of its largest angle.
 * @param {(name: string, share: number) => void} moved
 */
export function gamepad(moved) {
  /** @type {Record<string, number>} */
  const last = {};
  setInterval(() => {
    const pad = navigator.getGamepads?.().find((each) => each?.connected);
    if (!pad) return;
    for (const [axis, name, sign] of AXES) {
      const value = pad.axes[axis] ?? 0;
      const share = Math.abs(value) < REST ? 0 : Math.round(sign * value * 50) / 50;
      if (share !== (last[name] ?? 0)) moved(name, share);
      last[name] = share;
    }
  }, OFTEN);
}

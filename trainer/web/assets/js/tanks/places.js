// Where tanks, pipes and banks stand in the picture of the boat, bow to the right.
import { say } from "../words.js";

/**
 * @typedef {[number, number, number, number]} Box left, top, width, height
 * @typedef {{ size: [number, number], tanks: Record<string, Box>, dry: Record<string, Box>,
 *   hull: string, inner: Box, banks: Record<string, Box>, header: number, valves: number,
 *   foot: number, keel: number, trim: number, names: number, short: boolean }} Form
 * `header` is the height of the air pipe, `valves` of the valves on the main tanks, `foot` of
 * their flood ports, `keel` of the sea below the pumps, `trim` of the pipe between the trim tanks,
 * `names` how far those stand below the inner tanks; a `short` form has no words at its valves.
 */

/** What each tank is called, in full and short. @type {Record<string, [string, string]>} */
export const TITLES = {
  aft: [say("Aft main"), say("Aft")],
  mid: [say("Mid main"), say("Mid")],
  forward: [say("Forward main"), say("Fwd")],
  trim_aft: [say("Trim aft"), say("Trim aft")],
  auxiliary: [say("Auxiliary"), say("Aux.")],
  depth_control: [say("Depth control"), say("Depth c.")],
  negative: [say("Negative"), say("Neg.")],
  trim_forward: [say("Trim forward"), say("Trim fwd")],
};
/** Tanks that air empties; the last of them lies inside. */
export const MAIN = ["aft", "mid", "forward"];
export const BLOWN = [...MAIN, "negative"];
/** Of tanks with pumps: what tells the amount still to move into them, and its sign. */
export const MOVED = /** @type {Record<string, [string, number]>} */ ({
  trim_forward: ["moving_trim", 1],
  trim_aft: ["moving_trim", -1],
  auxiliary: ["moving_auxiliary", 1],
  depth_control: ["moving_depth_control", 1],
});
/** @type {Record<string, [string, string]>} */
export const BANKS = { main: [say("Main air"), say("Main")], emergency: [say("Emergency air"), say("Emerg.")] };

/** @type {Form} for the width of a page */
export const WIDE = {
  size: [1240, 338],
  tanks: {
    aft: [205, 96, 240, 54],
    mid: [488, 96, 240, 54],
    forward: [838, 96, 256, 54],
    trim_aft: [225, 188, 130, 46],
    auxiliary: [430, 188, 130, 46],
    depth_control: [590, 188, 130, 46],
    negative: [744, 188, 110, 46],
    trim_forward: [938, 188, 130, 46],
  },
  dry: {
    flood_aft: [180, 170, 210, 98],
    flood_centre: [390, 170, 506, 98],
    flood_forward: [896, 170, 200, 98],
  },
  hull: "M70 186C110 120 180 88 260 88H750L760 58H832L840 88H1080C1160 88 1200 140 1200 186S1160 284 1080 284H260C180 284 110 252 70 186ZM70 150V222M104 148L70 100H94L142 128M104 224L70 272H94L142 244",
  inner: [180, 170, 916, 98],
  banks: { main: [330, 8, 200, 18], emergency: [850, 8, 200, 18] },
  header: 42,
  valves: 68,
  foot: 150,
  keel: 332,
  trim: 306,
  names: 16,
  short: false,
};

/** @type {Form} for a panel of a page, and for phones */
export const NARROW = {
  size: [440, 256],
  tanks: {
    aft: [46, 64, 102, 36],
    mid: [154, 64, 102, 36],
    forward: [298, 64, 104, 36],
    trim_aft: [52, 122, 66, 40],
    auxiliary: [134, 122, 62, 40],
    depth_control: [204, 122, 54, 40],
    negative: [266, 122, 52, 40],
    trim_forward: [338, 122, 64, 40],
  },
  dry: {
    flood_aft: [44, 112, 82, 74],
    flood_centre: [126, 112, 204, 74],
    flood_forward: [330, 112, 80, 74],
  },
  hull: "M12 124C24 82 40 58 74 58H386C420 58 432 92 432 124S420 194 386 194H74C40 194 24 166 12 124ZM12 106V142M26 98L12 78H24L40 88M26 150L12 170H24L40 160",
  inner: [44, 112, 366, 74],
  banks: { main: [46, 6, 70, 12], emergency: [266, 6, 74, 12] },
  header: 30,
  valves: 46,
  foot: 100,
  keel: 236,
  trim: 213,
  names: 14,
  short: true,
};

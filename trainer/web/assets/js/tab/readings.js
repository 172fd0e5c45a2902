// What the channels show, read off the state as the session's stations read it.
import { remainder } from "./rows.js";

/**
 * @typedef {import("./core.js").Core} Core
 * @typedef {string | number | null} Value
 * @typedef {{ frozen: boolean, speed: number, branch: number, replaying: boolean, shown: boolean }} Pace
 * @typedef {{ channels: Record<string, [string, string, number][]>, toward: Record<string, number>,
 *   rps: number, bells: [string, number][], tanks: string[], compartments: string[], banks: string[],
 *   valves: string[], capacity: number[], bank_volume: number[], bank_full: number[], gas: number,
 *   buoyancy: number, g: number, sail: [number, number], intake: number | null, kinds: string[],
 *   slots: number, axes: string[], sides: Record<string, [string, string]>,
 *   gauge_units: Record<string, [string, number]>, shares: Record<string, string>, knot: number }} Fittings
 */

const DEGREE = Math.PI / 180;
const TURN = 2 * Math.PI;
const TONNE = 1000;
const POSITIONS = ["shut", "open", "emergency"];
const PARTS = ["depth", "position", "tanks"];
const LETTERS = { rudder: "r", stern: "s", bow: "b" };
const ROUND = 350 * DEGREE;
const SLOWEST = 0.005; // [kn] that is not written as zero
const STEEPEST = 0.02; // of |cos pitch|: the equations are singular at 90 degrees

/** Returns an angle [rad] as a course below 360 when written. @param {number} angle */
function compass(angle, decimals = 1) {
  const size = 10 ** decimals;
  return ((Math.round((angle / DEGREE) * size) / size) % 360 + 360) % 360;
}

/** Returns a value with its decimals, "" for none. @param {Value} value @param {number} decimals */
export function written(value, decimals) {
  if (value === null) return "";
  if (typeof value === "string") return value;
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? (0).toFixed(decimals) : text;
}

export class Readings {
  /** @param {Core} core @param {Fittings} fittings */
  constructor(core, fittings) {
    this.core = core;
    this.fittings = fittings;
    /** @type {Pace} */
    this.pace = { frozen: true, speed: 1, branch: 1, replaying: false, shown: false };
    const made = [stations(this), orders(this), ballast(this), truth(this), casualties(this)];
    /** @type {Record<string, () => Value>} */
    this.fields = Object.assign({}, ...made);
  }

  /** Returns the fields of a channel as they are written. @param {string} channel */
  values(channel) {
    this.gauges = this.core.read();
    return this.fittings.channels[channel].map(([name, , decimals]) =>
      written((this.fields[`${channel}.${name}`] ?? this.fields[name] ?? nothing)(), decimals),
    );
  }

  /** @param {string} name */
  get(name) {
    return this.core.get(name);
  }

  /** @param {string} block @param {number} place */
  at(block, place) {
    return this.core.state[this.core.boat.places[block] + place];
  }

  get depth() {
    return this.gauges?.[0] ?? 0;
  }
  get heading() {
    return this.gauges?.[1] ?? 0;
  }
  get speed() {
    return (this.gauges?.[2] ?? 0) / this.fittings.knot;
  }
}

/** @returns {Value} */
function nothing() {
  return null;
}

/** What helm, planes and engine show. @param {Readings} r @returns {Record<string, () => Value>} */
function stations(r) {
  const { fittings } = r;
  const rpm = (/** @type {number} */ u) => u * fittings.rps * 60;
  const turns = () => r.get(r.get("speed_by_hand") ? "ordered_u_c" : "command_u_c");
  const kept = () => !(r.get("stern_by_hand") && r.get("bow_by_hand")) || r.get("hover");
  return {
    depth: () => r.depth,
    heading: () => compass(r.heading),
    speed: () => r.speed,
    pitch: () => r.get("theta") / DEGREE,
    heel: () => r.get("phi") / DEGREE,
    ordered_course: () => (r.get("rudder_by_hand") ? null : compass(r.get("ordered_psi"))),
    turn_rate: () => r.get("r") / DEGREE,
    ordered_speed: () => (r.get("speed_by_hand") ? null : r.get("ordered_speed") / fittings.knot),
    rpm: () => rpm(r.get("u_c")),
    ordered_rpm: () => rpm(turns()),
    bell: () => bell(r),
    speed_mode: () => (r.get("speed_by_hand") ? "hand" : "auto"),
    ordered_depth: () => (kept() ? r.get("ordered_depth") : null),
    "time.time": () => (r.pace.frozen ? "frozen" : "running"),
    "time.speed": () => r.pace.speed,
    held: () => PARTS.filter((part) => r.get(`held_${part}`)).join("+") || null,
    branch: () => r.pace.branch,
    replay: () => (r.pace.replaying ? "yes" : "no"),
    shown: () => (r.pace.shown ? "yes" : "no"),
    ...Object.assign({}, ...Object.entries(LETTERS).map(([name, letter]) => surface(r, name, letter))),
  };
}

/** @param {Readings} r @returns {Value} */
function bell(r) {
  if (!r.get("speed_by_hand")) return null;
  const ordered = r.get("ordered_u_c");
  const rung = r.fittings.bells.find(([, speed]) => Math.abs(speed - ordered) < 1e-9);
  return rung ? rung[0].replaceAll("_", "-") : null;
}

/** @param {Readings} r @param {string} name @param {string} letter @returns {Record<string, () => Value>} */
function surface(r, name, letter) {
  const toward = r.fittings.toward[name];
  const angle = (/** @type {string} */ place) => (toward ? (r.get(place) / DEGREE) * toward : null);
  const byHand = () => r.get(`${name}_by_hand`);
  return {
    [name]: () => angle(`delta_${letter}`),
    [`ordered_${name}`]: () => angle(`${byHand() ? "ordered" : "command"}_${letter}`),
    [`${name}_mode`]: () => (byHand() ? "hand" : "auto"),
  };
}

/** What the crew is ordered. @param {Readings} r @returns {Record<string, () => Value>} */
function orders(r) {
  const { axes, knot } = r.fittings;
  const stands = (/** @type {string} */ axis) => r.at("crew_order_tick", axes.indexOf(axis));
  const when = (/** @type {string} */ axis, /** @type {() => Value} */ read) => () => (stands(axis) ? read() : null);
  const size = { depth: 1, speed: knot, pitch: DEGREE };
  const shown = { depth: () => r.depth, speed: () => r.speed, pitch: () => r.get("theta") / DEGREE };
  /** @type {Record<string, () => Value>} */
  const made = {
    "orders.course": when("course", () => compass(r.get("crew_course"))),
    course_side: when("course", () => ({ "-1": "left", 1: "right" })[String(r.get("crew_course_side"))] ?? null),
    course_error: when("course", () => courseToGo(r)),
    depth_unit: when("depth", () => (r.get("crew_depth_unit") === 1 ? "m" : "ft")),
    told: nothing,
  };
  for (const axis of axes) {
    made[`${axis}_since`] = when(axis, () => (r.core.ticks - stands(axis) + 1) * r.core.step);
  }
  for (const axis of /** @type {("depth" | "speed" | "pitch")[]} */ (Object.keys(size))) {
    const wanted = () => r.get(`crew_${axis}`) / size[axis];
    made[`orders.${axis}`] = when(axis, wanted);
    made[`${axis}_error`] = when(axis, () => wanted() - shown[axis]());
  }
  return made;
}

/** @param {Readings} r */
function courseToGo(r) {
  const left = r.at("crew_order", 0) - r.heading;
  const nearest = !r.get("crew_course_side") || Math.abs(left) > ROUND;
  return (nearest ? remainder(left, TURN) : left) / DEGREE;
}

/** What the ballast panel shows. @param {Readings} r @returns {Record<string, () => Value>} */
function ballast(r) {
  const { fittings } = r;
  /** @type {Record<string, () => Value>} */
  const made = {};
  fittings.tanks.forEach((tank, place) => {
    const name = tank.replace("compartment_", "flood_");
    const whole = fittings.capacity[place];
    made[name] = () => (whole ? r.at("water", place) / TONNE : null);
    made[`${name}_full`] = () => (whole ? (100 * r.at("water", place)) / whole : null);
  });
  fittings.banks.forEach((bank, place) => {
    const [volume, full] = [fittings.bank_volume[place], fittings.bank_full[place]];
    made[`air.${bank}`] = () => (volume ? (r.get(`bank_${bank}`) * (fittings.gas / 1e6)) / volume : null);
    made[`air.${bank}_full`] = () => (full ? (r.get(`bank_${bank}`) * 100) / full : null);
  });
  for (const valve of fittings.valves) {
    for (const kind of ["vent", "blow"]) made[`${kind}_${valve}`] = () => POSITIONS[r.get(`${kind}_${valve}`)];
  }
  for (const pump of ["trim", "auxiliary", "depth_control"]) {
    made[`moving_${pump}`] = () => r.get(`move_${pump}`) / TONNE;
  }
  const trims = fittings.capacity[fittings.tanks.indexOf("trim_forward")];
  const drained = () => fittings.compartments[r.get("drained") - 1]?.replace("compartment_", "") ?? null;
  return {
    ...made,
    draining: drained,
    hover: () => (r.get("hover") ? "on" : "off"),
    trim_mode: () => (trims ? (r.get("trim_by_hand") ? "hand" : "auto") : null),
    compressor: () => {
      if (fittings.intake === null) return null;
      const running = r.get("z") <= fittings.intake ? "on" : "no air";
      return r.get("compressor") ? running : "off";
    },
    negative_flood: () => (r.get("negative_flood") ? "open" : "shut"),
  };
}

/** The truth, and the sea. @param {Readings} r @returns {Record<string, () => Value>} */
function truth(r) {
  const { fittings } = r;
  const overSail = () => {
    const [x, z] = fittings.sail;
    const [pitch, heel] = [r.get("theta"), r.get("phi")];
    return r.get("z") + r.get("eta_wave") - (x * Math.sin(pitch) - z * Math.cos(pitch) * Math.cos(heel));
  };
  return {
    "swell.height": () => null, // there is no periscope in a tab
    "swell.drift": () => null,
    "motion.depth": () => r.get("z"),
    "motion.heading": () => compass(r.get("psi"), 2),
    "motion.speed": () => r.get("u") / fittings.knot,
    north: () => r.get("x"),
    east: () => r.get("y"),
    depth_rate: () => rates(r).down,
    "motion.turn_rate": () => rates(r).heading / DEGREE,
    speed_rate: () => r.get("udot") / fittings.knot,
    pitch_rate: () => rates(r).pitch / DEGREE,
    heel_rate: () => rates(r).heel / DEGREE,
    north_rate: () => rates(r).way[0],
    east_rate: () => rates(r).way[1],
    heavy: () => (r.get("weight") - fittings.buoyancy) / fittings.g / TONNE,
    ...sea(r, "sea", ""),
    ...sea(r, "sea_target", "ordered_"),
    ramp: () => r.get("sea_ramp"),
    elevation: () => r.get("eta_wave"),
    over_sail: overSail,
    ...ground(r),
    ticks: () => r.core.ticks,
  };
}

/** @param {Readings} r @param {string} block @param {string} before @returns {Record<string, () => Value>} */
function sea(r, block, before) {
  const [height, omega, , direction] = [0, 1, 2, 3].map((place) => () => r.at(block, place));
  return {
    [`${before}height`]: height,
    [`${before}period`]: () => (height() ? TURN / omega() : null),
    [`${before}from`]: () => (height() ? compass(direction() + Math.PI, 0) : null),
  };
}

/** The current at the boat [m/s], north and east. @param {Readings} r @returns {[number, number]} */
function water(r) {
  const depth = r.get("z");
  return [r.get("water_north") + r.get("shear_north") * depth, r.get("water_east") + r.get("shear_east") * depth];
}

/** The rates of this tick [rad/s, m/s], as motion_rates.py has them: those of the state are of the tick before. @param {Readings} r */
function rates(r) {
  const [u, v, w, p, q, turning] = ["u", "v", "w", "p", "q", "r"].map((name) => r.get(name));
  const [phi, theta, psi] = ["phi", "theta", "psi"].map((name) => r.get(name));
  const [sinHeel, cosHeel, sinPitch, cosPitch] = [Math.sin(phi), Math.cos(phi), Math.sin(theta), Math.cos(theta)];
  const level = Math.max(Math.abs(cosPitch), STEEPEST) * (cosPitch < 0 ? -1 : 1);
  const heading = (q * sinHeel + turning * cosHeel) / level;
  const [across, down] = [v * cosHeel - w * sinHeel, v * sinHeel + w * cosHeel];
  const along = u * cosPitch + down * sinPitch;
  const [north, east] = water(r);
  /** @type {[number, number]} */
  const way = [
    along * Math.cos(psi) - across * Math.sin(psi) + north,
    along * Math.sin(psi) + across * Math.cos(psi) + east,
  ];
  return {
    heel: p + heading * sinPitch,
    pitch: q * cosHeel - turning * sinHeel,
    heading,
    way: /** @type {[number, number]} */ (r.get("held_position") ? [0, 0] : way),
    down: r.get("held_depth") ? 0 : down * cosPitch - u * sinPitch,
  };
}

/** The water at the boat, and her way over the ground. @param {Readings} r @returns {Record<string, () => Value>} */
function ground(r) {
  const knots = (/** @type {[number, number]} */ [north, east]) => Math.hypot(north, east) / r.fittings.knot;
  const current = () => water(r);
  const way = () => rates(r).way;
  const goes = (/** @type {[number, number]} */ [north, east]) => Math.atan2(east, north);
  return {
    set: () => (knots(current()) >= SLOWEST ? compass(goes(current()), 1) : null),
    drift: () => knots(current()),
    course_over_ground: () => compass(knots(way()) >= SLOWEST ? goes(way()) : r.get("psi"), 1),
    speed_over_ground: () => knots(way()),
  };
}

/** What is broken. @param {Readings} r @returns {Record<string, () => Value>} */
function casualties(r) {
  const made = Array.from({ length: r.fittings.slots }, (_, slot) => {
    const name = `casualty_${slot + 1}`;
    const held = (/** @type {string} */ block) => (r.at("casualty", slot) ? r.at(block, slot) : null);
    const kind = () => r.fittings.kinds[r.at("casualty", slot) - 1] ?? null;
    const left = () => held("casualty_ticks");
    return {
      [name]: kind,
      [`${name}_amount`]: () => held("casualty_amount"),
      [`${name}_target`]: () => ((left() ?? 0) < 0 ? 0 : held("casualty_target")),
      [`${name}_left`]: () => (left() === null ? null : Math.abs(Number(left())) * r.core.step),
      [`${name}_says`]: () => {
        const what = kind();
        return what && describe(r.fittings, what, held("casualty_amount") ?? 0);
      },
    };
  });
  return Object.assign({}, ...made);
}

/** Returns an amount of a casualty with its unit and side. @param {Fittings} fittings @param {string} kind @param {number} amount [SI] */
export function describe(fittings, kind, amount) {
  const { sides, gauge_units: units, shares, toward } = fittings;
  const short = (/** @type {number} */ value) => String(Number(value.toPrecision(3)));
  const [what, how] = [kind.slice(0, kind.lastIndexOf("-")), kind.slice(kind.lastIndexOf("-") + 1)];
  const [part] = kind.split("-");
  if (part in sides && /-(hard-over|stuck)$/.test(kind)) {
    const size = Math.round(((amount * toward[part]) / DEGREE) * 10) / 10;
    return `${Math.abs(size)} deg${size ? ` ${sides[part][size < 0 ? 1 : 0]}` : ""}`;
  }
  if (what in units) {
    const [unit, size] = units[what];
    const shown = amount / size;
    if (how === "noisy") return `${short(shown)} ${unit} of noise`;
    if (how === "stuck") return `at ${(unit === "deg" ? ((shown % 360) + 360) % 360 : shown).toFixed(1)} ${unit}`;
    return `reads ${short(Math.abs(shown))} ${unit} too ${shown < 0 ? "little" : "much"}`;
  }
  if (/^(leak|flooding)-/.test(kind)) return `hole ${short(1e4 * amount)} cm2`;
  const share = Object.entries(shares).find(([end]) => kind.startsWith(end) || kind.endsWith(end));
  return share ? `${short(100 * amount)} % ${share[1]}` : "";
}

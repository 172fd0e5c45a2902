// What the channels show, read off the state as the session's stations read it.

/**
 * @typedef {import("./core.js").Core} Core
 * @typedef {string | number | null} Value
 * @typedef {{ frozen: boolean, speed: number, branch: number, replaying: boolean, shown: boolean }} Pace
 * @typedef {[place: number, size: number, ofState: boolean, isCourse: boolean, words: string[]]} Source
 * @typedef {{ channels: Record<string, [string, string, number, Source | null][]>, rps: number,
 *   bells: [string, number][], compartments: string[], valves: string[], trims: boolean,
 *   toward: Record<string, number>,
 *   intake: number | null, kinds: string[], slots: number, axes: string[],
 *   modes: string[], consumers: string[],
 *   counts: Record<string, Count> }} Fittings
 * @typedef {{ how: string, before: string, unit: string, size: number, sides: [string, string] }} Count how an amount is counted
 */

const DEGREE = Math.PI / 180;
const POSITIONS = ["shut", "open", "emergency"];
const PARTS = ["depth", "position", "tanks"];
const SURFACES = ["rudder", "stern", "bow"];

/** Returns an angle [rad] as a course below 360 when written. @param {number} angle @param {number} decimals */
function compass(angle, decimals) {
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
    const made = [stations(this), orders(this), ballast(this), plant(this), casualties(this)];
    /** @type {Record<string, () => Value>} */
    this.fields = Object.assign({}, ...made);
  }

  /** Returns the fields of a channel as they are written. @param {string} channel */
  values(channel) {
    const shown = this.core.show();
    return this.fittings.channels[channel].map(([name, , decimals, source]) => {
      if (!source) return written((this.fields[name] ?? nothing)(), decimals);
      const [place, size, ofState, isCourse, words] = source;
      const value = (ofState ? this.core.state : shown)[place];
      if (Number.isNaN(value)) return "";
      if (words.length) return words[value];
      return written(isCourse ? compass(value, decimals) : value / size, decimals);
    });
  }

  /** @param {string} name */
  get(name) {
    return this.core.get(name);
  }

  /** @param {string} block @param {number} place */
  at(block, place) {
    return this.core.state[this.core.boat.places[block] + place];
  }
}

/** @returns {Value} */
function nothing() {
  return null;
}

/** What helm and engine show in words or turns, and how time runs. @param {Readings} r @returns {Record<string, () => Value>} */
function stations(r) {
  const { fittings } = r;
  const rpm = (/** @type {number} */ u) => u * fittings.rps * 60;
  const mode = (/** @type {string} */ name) => () => (r.get(`${name}_by_hand`) ? "hand" : "auto");
  return {
    rpm: () => rpm(r.get("u_c")),
    ordered_rpm: () => rpm(r.get(r.get("speed_by_hand") ? "ordered_u_c" : "command_u_c")),
    bell: () => bell(r),
    ...Object.fromEntries([...SURFACES, "speed"].map((name) => [`${name}_mode`, mode(name)])),
    time: () => (r.pace.frozen ? "frozen" : "running"),
    speed: () => r.pace.speed,
    held: () => PARTS.filter((part) => r.get(`held_${part}`)).join("+") || null,
    branch: () => r.pace.branch,
    replay: () => (r.pace.replaying ? "yes" : "no"),
    shown: () => (r.pace.shown ? "yes" : "no"),
    ticks: () => r.core.ticks,
  };
}

/** @param {Readings} r @returns {Value} */
function bell(r) {
  if (!r.get("speed_by_hand")) return null;
  const ordered = r.get("ordered_u_c");
  const rung = r.fittings.bells.find(([, speed]) => Math.abs(speed - ordered) < 1e-9);
  return rung ? rung[0].replaceAll("_", "-") : null;
}

/** What the crew is ordered. @param {Readings} r @returns {Record<string, () => Value>} */
function orders(r) {
  const { axes } = r.fittings;
  const stands = (/** @type {string} */ axis) => r.at("crew_order_tick", axes.indexOf(axis));
  const when = (/** @type {string} */ axis, /** @type {() => Value} */ read) => () => (stands(axis) ? read() : null);
  /** @type {Record<string, () => Value>} */
  const made = {
    course_side: when("course", () => ({ "-1": "left", 1: "right" })[String(r.get("crew_course_side"))] ?? null),
    depth_unit: when("depth", () => (r.get("crew_depth_unit") === 1 ? "m" : "ft")),
  };
  for (const axis of axes) {
    made[`${axis}_since`] = when(axis, () => (r.core.ticks - stands(axis) + 1) * r.core.step);
  }
  return made;
}

/** How levers and switches of the ballast panel stand. @param {Readings} r @returns {Record<string, () => Value>} */
function ballast(r) {
  const { fittings } = r;
  /** @type {Record<string, () => Value>} */
  const made = {};
  for (const valve of fittings.valves) {
    for (const kind of ["vent", "blow"]) made[`${kind}_${valve}`] = () => POSITIONS[r.get(`${kind}_${valve}`)];
  }
  const drained = () => fittings.compartments[r.get("drained") - 1]?.replace("compartment_", "") ?? null;
  return {
    ...made,
    draining: drained,
    hover: () => (r.get("hover") ? "on" : "off"),
    trim_mode: () => (fittings.trims ? (r.get("trim_by_hand") ? "hand" : "auto") : null),
    compressor: () => {
      if (fittings.intake === null) return null;
      const running = r.get("z") <= fittings.intake ? "on" : "no air";
      return r.get("compressor") ? running : "off";
    },
    negative_flood: () => (r.get("negative_flood") ? "open" : "shut"),
  };
}

/** What is being shifted, who is under way, and what is dead. @param {Readings} r @returns {Record<string, () => Value>} */
function plant(r) {
  const { fittings } = r;
  const left = (/** @type {string} */ ticks) => () => (r.get(ticks) ? Math.abs(r.get(ticks)) * r.core.step : null);
  const made = SURFACES.map((name) => {
    const mode = (/** @type {string} */ field) => (fittings.toward[name] ? fittings.modes[r.get(field)] : null);
    return {
      [`${name}_supply`]: () => mode(`${name}_mode`),
      [`${name}_shifted_to`]: () => (r.get(`${name}_mode_ticks`) ? mode(`${name}_mode_ordered`) : null),
      [`${name}_shift`]: left(`${name}_mode_ticks`),
    };
  });
  const isDead = (/** @type {string} */ _, /** @type {number} */ bit) => (r.get("unpowered") >> bit) & 1;
  return Object.assign({}, ...made, {
    party_due: left("fight_ticks"),
    dead: () => fittings.consumers.filter(isDead).join("+") || null,
  });
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
  const { how, before, unit, size, sides } = fittings.counts[kind];
  const short = (/** @type {number} */ value) => String(Number(value.toPrecision(3)));
  if (how === "angle") {
    const angle = Math.round(((amount * size) / DEGREE) * 10) / 10;
    return `${Math.abs(angle)} deg${angle ? ` ${sides[angle < 0 ? 1 : 0]}` : ""}`;
  }
  if (how === "plain") return `${before}${short(amount / size)} ${unit}`;
  if (how === "share") return `${short(100 * amount)} % ${unit}`;
  const shown = amount / size;
  if (how === "noise") return `${short(shown)} ${unit} of noise`;
  if (how === "value") return `at ${(unit === "deg" ? ((shown % 360) + 360) % 360 : shown).toFixed(1)} ${unit}`;
  return how && `reads ${short(Math.abs(shown))} ${unit} too ${shown < 0 ? "little" : "much"}`;
}

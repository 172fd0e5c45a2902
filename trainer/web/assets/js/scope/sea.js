// The waves round the boat, as the session has packed them, run on between two ticks.

const DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
const LARGEST = 6; // of a filter's output
const FASTEST = 8; // of a wave's frequency over the peak's
const STEP = 0.25; // [rad] of the peak wave in a step of the groups
const SEAM = 24; // steps over which the ends of the groups become one
const BANDS = 10; // waves of one direction
const ACROSS = [-0.8660254037844386, -0.5, 0, 0.5, 0.8660254037844386];
const ALONG = [0.5, 0.8660254037844386, 1, 0.8660254037844386, 0.5];
const DEGREE = Math.PI / 180;
const ENTRIES = 4096; // of the table of cosines; a power of two
const PER_RADIAN = ENTRIES / (2 * Math.PI);
const TABLE = Float64Array.from({ length: ENTRIES }, (_, i) => Math.cos((i + 0.5) / PER_RADIAN));

/** Returns numbers from -1 to 1 of so many digits each. @param {string} text @param {number} count */
export function unpacked(text, count) {
  const most = DIGITS.length ** count;
  return Float64Array.from({ length: Math.floor(text.length / count) }, (_, at) => {
    let whole = 0;
    for (let i = 0; i < count; i++) whole = whole * DIGITS.length + DIGITS.indexOf(text[at * count + i]);
    return ((whole + 0.5) / most) * 2 - 1;
  });
}

export class Sea {
  constructor() {
    this.height = 0; // [m] significant
    this.number = 0; // [1/m] of the peak wave
    this.rate = 0; // [rad/s]
    this.towards = 0; // [rad] off the bow, where the waves go
    this.along = 0; // [m/s] of the boat, along and across the waves
    this.across = 0;
    this.ahead = 0; // [m/s] of the boat along its bow
    this.clock = 0;
    this.drift = 0;
    this.later = 0; // [s] after the reading
    /** @type {Float64Array} outputs of the filters, two numbers a step, without an end */
    this.groups = new Float64Array(0);
    this.reach = 0;
    /** @type {Float64Array} phase above the boat, frequency and amplitude of the cosines */
    this.waves = new Float64Array(0);
    this.phases = new Float64Array(0);
    this.bends = new Float64Array(0); // [1/m] their numbers
    this.sizes = new Float64Array(0);
  }

  /** Takes a reading of the channel. @param {import("../model/session.js").Session} session */
  take(session) {
    const number = (/** @type {string} */ name) => session.number(`swell.${name}`) ?? 0;
    this.height = number("height");
    this.number = number("number");
    this.rate = number("rate");
    this.towards = number("towards") * DEGREE;
    const [cos, sin] = [Math.cos(this.towards), Math.sin(this.towards)];
    this.along = number("ahead") * cos + number("right") * sin;
    this.ahead = number("ahead");
    this.across = number("right") * cos - number("ahead") * sin;
    this.clock = number("clock");
    this.drift = number("drift");
    this.closeGroups(unpacked(session.word("swell.groups"), 2));
    this.waves = unpacked(session.word("swell.waves"), 3);
    const count = this.waves.length / 3;
    this.phases = new Float64Array(count);
    this.sizes = Float64Array.from({ length: count }, (_, i) => this.waves[3 * i + 2]);
    this.bends = Float64Array.from({ length: count }, (_, i) => {
      const relative = this.waves[3 * i + 1] * FASTEST;
      return relative * relative * this.number;
    });
    this.run(0);
  }

  /** Makes the groups a ring: beyond them they come again. @param {Float64Array} parts */
  closeGroups(parts) {
    const steps = parts.length / 2;
    this.reach = steps / 2;
    const ring = Math.max(steps - SEAM, 0);
    this.groups = parts.slice(0, 2 * ring);
    for (let i = 0; i < Math.min(SEAM, ring); i++) {
      const share = i / SEAM;
      for (let j = 0; j < 2; j++) {
        this.groups[2 * i + j] = share * parts[2 * i + j] + (1 - share) * parts[2 * (ring + i) + j];
      }
    }
    for (let i = 0; i < this.groups.length; i++) this.groups[i] *= LARGEST;
  }

  /** Lets the waves run on. @param {number} later [s] after the reading */
  run(later) {
    this.later = later;
    for (let i = 0; i < this.phases.length; i++) {
      const relative = this.waves[3 * i + 1] * FASTEST;
      const group = Math.floor(i / BANDS);
      const way = (this.along * ALONG[group] + this.across * ACROSS[group]) * later;
      this.phases[i] = this.waves[3 * i] * 2 * Math.PI + relative * this.rate * later - this.bends[i] * way;
    }
  }

  /** Returns the level [m] at a place so far ahead and to the right [m]. @param {number} ahead @param {number} right */
  level(ahead, right) {
    if (!this.height) return 0;
    const [cos, sin] = [Math.cos(this.towards), Math.sin(this.towards)];
    const along = ahead * cos + right * sin;
    const across = right * cos - ahead * sin;
    return 0.25 * this.height * (this.ofGroups(along) + this.ofCosines(along, across));
  }

  /** @param {number} along [m] */
  ofGroups(along) {
    const { groups, later } = this;
    if (!groups.length) return 0;
    const way = this.number * (along + this.along * later);
    const place = this.clock + this.reach + (this.rate * later - 2 * way) / STEP;
    const first = Math.floor(place);
    const f = place - first;
    const weights = [
      (-f * (f - 1) * (f - 2)) / 6,
      ((f + 1) * (f - 1) * (f - 2)) / 2,
      (-(f + 1) * f * (f - 2)) / 2,
      ((f + 1) * f * (f - 1)) / 6,
    ];
    const ring = groups.length / 2;
    let [even, odd] = [0, 0];
    for (let i = 0; i < 4; i++) {
      const at = 2 * ((((first - 1 + i) % ring) + ring) % ring);
      even += weights[i] * groups[at];
      odd += weights[i] * groups[at + 1];
    }
    const turn = this.drift + way;
    return even * Math.cos(turn) - odd * Math.sin(turn);
  }

  /** Adds them up by a table of cosines: there are fifty, at three thousand places. @param {number} along [m] @param {number} across [m] */
  ofCosines(along, across) {
    const { phases, bends, sizes } = this;
    let sum = 0;
    for (let i = 0, group = 0; i < phases.length; group++) {
      const met = along * ALONG[group] + across * ACROSS[group];
      for (const end = i + BANDS; i < end; i++) {
        sum += sizes[i] * TABLE[((phases[i] - bends[i] * met) * PER_RADIAN) & (ENTRIES - 1)];
      }
    }
    return sum;
  }
}

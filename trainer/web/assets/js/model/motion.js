// What pointers show between two ticks. Digits show the readings themselves.

const FOLLOW = 0.12; // [s] time constant of a pointer, so that a tick makes no jump
const FRAME = 50; // [ms] between pictures: twenty a second
const REST = 10; // pictures of which one is drawn while nothing moves
const AWAKE = 1000; // [ms] that all are drawn after something has changed, or somebody has done something
const STILL = 4; // from this pace of time on ticks are shown as they come

/**
 * @typedef {{ place: string, rate?: string, most?: number, turns?: boolean }} Pointer
 * A place (`gauges.depth`), where its rate is told if anywhere, the greatest rate that the boat can
 * have [1/s], and whether it turns round at 360.
 */

/**
 * Moves pointers; dispatches `frame` for each picture. Few are drawn in a freeze, and for who wants
 * no motion one for each reading, because a page at rest must not cost a station its battery.
 */
export class Motion extends EventTarget {
  /**
   * @param {import("./session.js").Session} session
   * @param {Record<string, Pointer>} pointers by the name that a page gives them
   */
  constructor(session, pointers) {
    super();
    this.session = session;
    this.pointers = pointers;
    /** @type {Record<string, number | null>} */
    this.shown = Object.fromEntries(Object.keys(pointers).map((name) => [name, null]));
    /** @type {Record<string, { value: number, tick: number, rate: number }>} */
    this.last = {};
    this.before = performance.now();
    /** @type {number[]} [ms] of script in the last pictures */
    this.cost = [];
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
    this.awake = 0; // [ms] until when all pictures are drawn, though time stands still
    this.left = 0; // pictures left out since the last
    this.asked = 0; // the picture that is asked for
    /** @type {Map<string, string>} the last reading of each channel, as it was */
    this.heard = new Map();
    session.on("tick", () => this.take());
    session.addEventListener("reading", (event) => this.hear(/** @type {CustomEvent} */ (event).detail));
    for (const what of ["pointerdown", "pointermove", "pointerup", "wheel", "keydown", "resize"])
      addEventListener(what, () => this.wake(), { capture: true, passive: true });
  }

  /** Begins to draw, never while the page is hidden. @param {number} [every] [ms] */
  start(every = FRAME) {
    Object.assign(document, { motion: this }); // where it is found by who measures its cost
    setInterval(() => {
      this.left = this.rests() ? (this.left + 1) % REST : 0;
      if (this.left === 0) this.draw();
    }, every);
  }

  /** Asks for a picture, unless one is asked for or nobody would see it. */
  draw() {
    if (document.hidden || this.asked) return;
    this.asked = requestAnimationFrame((now) => {
      this.asked = 0;
      this.frame(now);
    });
  }

  /** Draws all pictures for a while. */
  wake() {
    this.awake = performance.now() + AWAKE;
  }

  /** Returns whether nothing moves by itself, and nothing has happened of late. */
  rests() {
    const still = this.calm.matches || this.session.state === "frozen";
    return still && performance.now() > this.awake;
  }

  /** Shows a reading that is another than the last. @param {{ channel: string, values: object }} reading */
  hear({ channel, values }) {
    const now = JSON.stringify(values);
    if (this.heard.get(channel) === now) return;
    this.heard.set(channel, now);
    if (this.calm.matches) this.draw();
    else this.wake();
  }

  /** Takes a reading: where the told rate is secret, the last two readings give one. */
  take() {
    for (const [name, { place, rate, most = Infinity, turns }] of Object.entries(this.pointers)) {
      const reading = this.session.readings.latest.get(place.split(".")[0]);
      const value = this.session.number(place);
      if (!reading || value === null) {
        delete this.last[name];
        this.shown[name] = null;
        continue;
      }
      const before = this.last[name];
      if (before?.tick === reading.tick) continue;
      const passed = before ? reading.seconds - before.tick : 0;
      const moved = before ? difference(value, before.value, turns) : 0;
      const guess = passed > 0 && passed < 2 ? moved / passed : 0;
      const told = rate ? (this.session.number(rate) ?? 0) : guess;
      this.last[name] = {
        value,
        tick: reading.seconds,
        rate: Math.min(Math.max(told, -most), most),
      };
      this.shown[name] ??= value;
    }
  }

  /** @param {number} now [ms] */
  frame(now) {
    const began = performance.now();
    const passed = Math.min((now - this.before) / 1000, 0.2);
    this.before = now;
    const share = this.calm.matches ? 1 : 1 - Math.exp(-passed / FOLLOW);
    for (const [name, last] of Object.entries(this.last)) {
      const target = last.value + last.rate * this.ahead(began);
      const old = this.shown[name] ?? target;
      const { turns } = this.pointers[name];
      const next = old + difference(target, old, turns) * share;
      this.shown[name] = turns ? (next + 360) % 360 : next;
    }
    this.dispatchEvent(new Event("frame"));
    this.cost.push(performance.now() - began);
    if (this.cost.length > 200) this.cost.shift();
  }

  /** Returns how far [s] of the boat's time the picture is ahead of the tick. @param {number} now */
  ahead(now) {
    const { session } = this;
    if (session.state !== "running" || this.calm.matches || session.pace >= STILL) return 0;
    return Math.min(((now - session.tickAt) / 1000) * session.pace, 0.5);
  }
}

/**
 * Returns how far one value is from another, the short way round where they turn.
 * @param {number} value
 * @param {number} other
 * @param {boolean} [turns]
 */
export function difference(value, other, turns) {
  const apart = value - other;
  return turns ? ((((apart + 180) % 360) + 360) % 360) - 180 : apart;
}

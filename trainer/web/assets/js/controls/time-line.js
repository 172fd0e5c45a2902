// The time line: what has been flown, and a handle that looks back at any moment of it.
import { clock, html, write } from "../draw.js";
import { say } from "../words.js";

/**
 * @typedef {{ seconds: number, sign: string, text: string }} Sign
 * @typedef {{ number: number, from: number, to: number, why: string }} Lane a branch that was left
 * @typedef {{ branch: number | null, seconds: number }} Look a moment; branch null is the present one
 * @typedef {{ seconds: number, kind: string, words: string }} Cause
 * @typedef {{ now: number, end: number, signs: Sign[], causes: Cause[], lanes: Lane[],
 *   replaying: boolean }} Flown
 */

const TICKS = [30, 60, 120, 300, 600, 900, 1800, 3600, 7200]; // [s]
const LABELS = 11; // on the whole line at most
const SPOKEN = 2000; // [ms] between changes of what is spoken
const CLOSE = 0.26; // [s]
const HINT = say("Drag the line to look back. Nothing is overwritten: what was flown stays as a branch.");
const REPLAY = say("A replay runs. Take over, and it goes on from there by your orders.");
const SIGNS = { C: "casualty", c: "cleared", M: "mark", S: "snapshot", o: "order", P: "planned", p: "planned" };
/** @type {Record<string, string>} what a sign is called */
const KINDS = {
  casualty: say("casualty"),
  cleared: say("cleared"),
  mark: say("mark"),
  snapshot: say("snapshot"),
  order: say("order"),
  planned: say("planned"),
};
const LETTERS = { P: "C" }; // that a sign shows, where it is not its own
const BARE = "op"; // signs without a letter
const KEYS = { ArrowLeft: -1, ArrowRight: 1, PageUp: -30, PageDown: 30 }; // [s]
/** @type {Record<string, string>} */
const CAUSES = { casualty: say("casualty"), "first order": say("first order"), limit: say("limit") };
/** What the keys under the line do, in the order in which they stand. */
const DEEDS = [
  ["before", say("Cause before")],
  ["next", say("Next cause")],
  ["watch", say("Watch again from here")],
  ["take", say("Take over here")],
  ["now", say("Return to now")],
];

/**
 * `<time-line>`: events `look` (detail: a Look, or null for the present) and `deed` (detail: `watch`
 * or `take`, which somebody else carries out at the moment that is looked at).
 */
export class TimeLine extends HTMLElement {
  constructor() {
    super();
    /** @type {Look | null} */
    this.looking = null;
    /** @type {Flown} */
    this.flown = { now: 0, end: 600, signs: [], causes: [], lanes: [], replaying: false };
    this.spokenAt = 0;
    this.told = ""; // of the signs that are drawn
    this.left = ""; // of the lanes
    this.held = false; // by a finger or the mouse
  }

  connectedCallback() {
    if (this.track) return;
    this.done = html("div", { class: "done" });
    this.head = html("div", { class: "head" });
    this.ticks = html("div", { class: "ticks", "aria-hidden": "true" });
    this.signs = html("div", { class: "signs", "aria-hidden": "true" });
    this.lanes = html("div", { class: "lanes" });
    this.handle = html("div", {
      class: "handle",
      role: "slider",
      tabindex: 0,
      "aria-label": say("Moment that is looked at"),
      "aria-valuemin": 0,
      "aria-valuemax": 0,
      "aria-valuenow": 0,
      keydown: (event) => this.press(/** @type {KeyboardEvent} */ (event)),
    });
    const grab = (/** @type {Event} */ event) =>
      this.grab(/** @type {PointerEvent} */ (event), this.track, null);
    const parts = [this.ticks, this.done, this.signs, this.head, this.handle];
    this.track = html("div", { class: "track", pointerdown: grab }, ...parts);
    this.says = html("span", { class: "grow says", role: "status" }, HINT);
    this.keys = DEEDS.map(([deed, words]) =>
      html("button", { type: "button", "data-deed": deed, click: () => this.act(deed) }, words),
    );
    this.append(this.lanes, this.track, html("div", { class: "row" }, this.says, ...this.keys));
    this.look(null);
  }

  /** Draws what has been flown. @param {Flown} flown */
  show(flown) {
    const { end } = this.flown;
    const drawn = !this.ticks?.firstChild;
    this.flown = flown;
    if (drawn || end !== flown.end) this.drawTicks();
    const told = JSON.stringify([flown.end, flown.signs]);
    if (this.told !== told) this.drawSigns();
    this.told = told;
    const left = JSON.stringify([flown.end, flown.lanes]);
    if (this.left !== left && !this.held) {
      this.left = left;
      this.drawLanes();
    }
    this.done?.style.setProperty("width", this.share(flown.now));
    this.head?.style.setProperty("left", this.share(flown.now));
    this.point();
  }

  /** Looks at a moment, null for the present; tells it. @param {Look | null} look */
  look(look) {
    const last = this.last(look?.branch ?? null);
    if (look) look.seconds = Math.max(0, Math.min(last, Math.round(look.seconds * 2) / 2));
    this.looking = look;
    this.point();
    this.dispatchEvent(new CustomEvent("look", { detail: look && { ...look } }));
  }

  /** Looks at the moment so much earlier or later, on the branch that is looked at. @param {number} by [s] */
  move(by) {
    const { branch, seconds } = this.looking ?? { branch: null, seconds: this.flown.now };
    this.look({ branch, seconds: seconds + by });
  }

  /** @param {number | null} branch */
  last(branch) {
    return this.flown.lanes.find((lane) => lane.number === branch)?.to ?? this.flown.now;
  }

  /** @param {string} deed */
  act(deed) {
    if (deed === "now") this.look(null);
    else if (deed === "next" || deed === "before") this.stepCause(deed === "next");
    else this.dispatchEvent(new CustomEvent("deed", { detail: deed }));
  }

  /** Puts the handle where it belongs, and says so. */
  point() {
    const { looking, handle, flown } = this;
    const at = looking?.seconds ?? flown.now;
    this.toggleAttribute("data-looking", looking !== null);
    for (const key of this.keys ?? []) {
      const { deed = "" } = key.dataset;
      const steps = flown.causes.length > 0 && (deed === "next" || deed === "before");
      const takes = flown.replaying && deed === "take";
      key.toggleAttribute("disabled", looking === null && !takes && !steps);
    }
    handle?.style.setProperty("left", this.share(at));
    this.toggleAttribute("data-lane", Boolean(looking?.branch));
    const now = performance.now();
    if (handle && (looking || now - this.spokenAt > SPOKEN)) {
      this.spokenAt = now;
      handle.setAttribute("aria-valuemax", String(Math.round(this.last(looking?.branch ?? null))));
      handle.setAttribute("aria-valuenow", String(Math.round(at)));
      handle.setAttribute("aria-valuetext", clock(at));
    }
    if (this.says) write(this.says, this.words());
    this.mark();
  }

  /** Shows on which lane the moment is. */
  mark() {
    for (const lane of this.lanes?.querySelectorAll("[data-branch]") ?? []) {
      const { branch = "" } = /** @type {HTMLElement} */ (lane).dataset;
      const here = Number(branch) === this.looking?.branch;
      lane.toggleAttribute("data-here", here);
      const needle = /** @type {HTMLElement} */ (lane.querySelector(".needle"));
      needle.hidden = !here;
      if (here) needle.style.left = this.share(this.looking?.seconds ?? 0);
    }
  }

  /** Returns what is looked at, in words. */
  words() {
    const { looking, flown } = this;
    if (!looking) return flown.replaying ? REPLAY : HINT;
    const at = clock(looking.seconds);
    const cause = flown.causes.find(({ seconds }) => Math.abs(seconds - looking.seconds) < CLOSE);
    if (cause) return say("Looking at {0}, {1}: {2}. Nothing is sent.", at, CAUSES[cause.kind], cause.words);
    if (looking.branch) return say("Looking at {0} of branch {1}. Nothing is sent.", at, looking.branch);
    const ago = clock(flown.now - looking.seconds);
    return say("Looking at {0}, {1} ago. Nothing is sent; the session goes its way.", at, ago);
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    const by = KEYS[/** @type {keyof typeof KEYS} */ (event.key)];
    if (by) this.move(by);
    else if (event.key === "Home") this.move(-Infinity);
    else if (event.key === "End" || event.key === "Escape") this.look(null);
    else if (event.key === "ArrowUp" || event.key === "ArrowDown") this.jump(event.key === "ArrowUp");
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  /** Goes to the sign before this moment, or to the one after it. @param {boolean} earlier */
  jump(earlier) {
    const at = this.looking?.seconds ?? this.flown.now;
    const times = this.flown.signs
      .filter(({ sign, seconds }) => !"opP".includes(sign) && Math.abs(seconds - at) > CLOSE)
      .map(({ seconds }) => seconds);
    const side = times.filter((seconds) => seconds < at === earlier);
    if (side.length) {
      const seconds = earlier ? Math.max(...side) : Math.min(...side);
      this.look({ branch: null, seconds });
    }
  }

  /** Goes to the next cause, from the present to the first one; or to the one before. @param {boolean} later */
  stepCause(later) {
    const { causes } = this.flown;
    const at = this.looking?.seconds ?? (later ? -Infinity : Infinity);
    const next = later
      ? causes.find(({ seconds }) => seconds > at + CLOSE)
      : causes.findLast(({ seconds }) => seconds < at - CLOSE);
    if (next) this.look({ branch: this.looking?.branch ?? null, seconds: next.seconds });
    else if (later && this.looking) this.look(null);
  }

  /** Follows a finger or the mouse. @param {PointerEvent} event @param {HTMLElement | undefined} on @param {number | null} branch */
  grab(event, on, branch) {
    if (!on || event.button) return;
    const box = on.getBoundingClientRect();
    const read = (/** @type {PointerEvent} */ next) =>
      this.look({ branch, seconds: ((next.clientX - box.left) / box.width) * this.flown.end });
    on.setPointerCapture(event.pointerId);
    this.held = true;
    on.onpointermove = read;
    on.onpointerup = on.onpointercancel = () => {
      this.held = false;
      on.onpointermove = null;
    };
    read(event);
  }

  /** @param {number} seconds */
  share(seconds) {
    return `${((100 * Math.min(seconds, this.flown.end)) / this.flown.end).toFixed(3)}%`;
  }

  drawTicks() {
    const { end } = this.flown;
    const step = TICKS.find((each) => end / each <= LABELS) ?? TICKS[TICKS.length - 1];
    const ticks = [];
    for (let at = 0; at <= end; at += step) {
      const tick = html("span", { class: "minute" }, at < end ? clock(at) : "");
      tick.style.left = this.share(at);
      ticks.push(tick);
    }
    this.ticks?.replaceChildren(...ticks);
  }

  drawSigns() {
    const drawn = this.flown.signs.map(({ seconds, sign, text }) => {
      const kind = SIGNS[/** @type {keyof typeof SIGNS} */ (sign)] ?? "order";
      const title = `${clock(seconds)} ${KINDS[kind]}: ${text}`;
      const letter = LETTERS[/** @type {keyof typeof LETTERS} */ (sign)] ?? sign;
      const node = html("span", { class: `sign ${kind}`, title }, BARE.includes(sign) ? "" : letter);
      node.style.left = this.share(seconds);
      return node;
    });
    this.signs?.replaceChildren(...drawn);
  }

  drawLanes() {
    this.lanes?.replaceChildren(...this.flown.lanes.map((lane) => this.lane(lane)));
    this.mark();
  }

  /** Returns the lane of a branch that was left: it can be dragged into. @param {Lane} lane */
  lane({ number, from, to, why }) {
    const says = say("Branch {0}, {1} to {2}; it began by {3}", number, clock(from), clock(to), why);
    const bar = html(
      "button",
      { type: "button", class: "bar", "aria-label": say("Look at the end of branch {0}", number), title: says },
      `${number}`,
    );
    bar.style.left = this.share(from);
    bar.style.width = `${(100 * (to - from)) / this.flown.end}%`;
    const needle = html("div", { class: "needle", hidden: true });
    const lane = html("div", { class: "lane", "data-branch": number }, bar, needle);
    lane.onpointerdown = (event) => this.grab(event, lane, number);
    bar.onclick = (event) => {
      if (event.detail === 0) this.look({ branch: number, seconds: to }); // by the keyboard
    };
    return lane;
  }
}
customElements.define("time-line", TimeLine);

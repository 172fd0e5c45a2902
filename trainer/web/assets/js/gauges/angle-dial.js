// Rudder, planes, heel: an arc whose angles lie evenly along its chord, alone or over a lever.
import { sided, sidedOrder, svg, write } from "../draw.js";
import { Fan } from "./fan.js";
import { Gauge, clamp, readable, text } from "./gauge.js";
import { say } from "../words.js";

const USUAL = 30; // [deg]
const BEYOND = 3; // [deg] past the stops that a pointer shows
const LEAST = 24; // [px] of a side that is worth drawing on
const FINE = 4; // [px] between ticks at least
const POINTER = 1.15; // of the text's size: its length, which ends before the numerals
const NUMERAL = 2.3; // of the text's size: how far inside the arc a numeral stands
const SPREAD = 7; // of the text's size: half the width of the digits and what is ordered below them
const WIDE = 2.1; // of the text's size: room for a numeral
const ORDERED = 8.5; // of its size: the width of what is ordered
const LARGE = 3.6; // of the text's size: the digits, where there is room
const WORD = 3.7; // of the text's size: room for the word of a side
const SIDES = 8; // of the text's size: half a scale that has such words
const BESIDE = 5; // of the digits' size: their width with the side beside them
const SMALL = 1.7; // of the text's size: digits are left out rather than smaller

/** `<angle-dial face="down|left|right" low high limit sides>` */
class AngleDial extends Gauge {
  most = USUAL; // [deg] the largest angle either way
  /** @type {Fan | null} */
  laid = null;
  /** @type {[number | null, number | null]} what is shown, and what is ordered */
  shown = [null, null];

  draw() {
    this.words = [this.getAttribute("low") ?? say("left"), this.getAttribute("high") ?? say("right")];
    this.scale = svg("g");
    this.pointer = svg("path", { class: "pointer", hidden: true });
    this.bug = svg("path", { class: "bug", hidden: true });
    this.faint = svg("path", { class: "ghost", hidden: true });
    this.amount = svg("tspan");
    this.way = svg("tspan", { class: "toward" });
    this.figure = svg("text", { class: "digits" }, this.amount, this.way);
    this.order = text([0, 0], "order");
    this.picture(null, this.scale, this.faint, this.pointer, this.bug, this.figure, this.order);
    this.limit = this.size("limit", USUAL);
    if (this.closest("order-lever")) return; // which gives its own scale
    new ResizeObserver(() => {
      const box = /** @type {[number, number]} */ ([this.clientWidth, this.clientHeight]);
      this.fan = new Fan(this.getAttribute("face") ?? "down", box, readable(this));
    }).observe(this);
  }

  /** The largest angle either way [deg], where the stops stand. */
  get limit() {
    return this.most;
  }

  set limit(most) {
    this.most = most;
    if (this.laid) this.fan = this.laid;
  }

  /** Where values stand. @param {Fan} fan */
  set fan(fan) {
    const room = Math.min(...fan.box) >= LEAST;
    this.laid = room ? fan : null;
    this.scale?.replaceChildren(...(room ? this.ticks(fan) : []));
    const { text: size } = fan;
    this.pointer?.setAttribute("d", `M0 1l${0.5 * size} ${POINTER * size}h${-size}Z`);
    this.faint?.setAttribute("d", `M0 1v${2 * size}`);
    this.bug?.setAttribute("d", `M0 -2l${0.6 * size} ${-0.9 * size}h${-1.2 * size}Z`);
    this.digitsAt(fan);
    this.show(...this.shown);
  }

  /** Puts the digits where the arc leaves room, or leaves them out. @param {Fan} fan */
  digitsAt(fan) {
    const { box, face, half, inner, text: size } = fan;
    const [down, begin] = [face === "down", inner[0]];
    const end = Math.min(inner[1], fan.chord ? Infinity : fan.within(SPREAD * size));
    const room = Math.max(end - begin, 0);
    const lines = down ? Math.min(room / 1.4, room - size, box[0] / BESIDE) : Math.min(room / 2.6, half / 2);
    const large = Math.min(lines, LARGE * size);
    const small = Math.min(Math.max(0.42 * large, size), down ? Infinity : room / ORDERED);
    const below = (small + 0.14 * large) / 2; // what is ordered stands there, at the side what is, too
    const [x, y] = fan.place(0, (begin + end) / 2 - below);
    put(this.figure, x, y, large);
    put(this.order, x, y + 0.5 * large + (down ? 0.6 : 1.8) * small, small);
    const under = { dx: null, x, y: y + 0.5 * large + 0.6 * small };
    const way = { "font-size": small, ...(down ? { dx: "0.25em", x: null, y: null } : under) };
    for (const [name, at] of Object.entries(way)) {
      if (at === null) this.way?.removeAttribute(name);
      else this.way?.setAttribute(name, String(at));
    }
    for (const part of [this.figure, this.order]) part?.toggleAttribute("hidden", large < SMALL * size);
  }

  /** @param {Fan} fan */
  ticks(fan) {
    const { most } = this;
    const { text: size, half } = fan;
    const at = (/** @type {number} */ value) => value / most;
    const along = (/** @type {number} */ from, /** @type {number} */ to, /** @type {number} */ inside) =>
      fan.path(at(from), at(to), (share) => fan.point(share, inside));
    /** @type {Element[]} */
    const parts = [svg("path", { d: along(-most, most, 0), class: "arc" })];
    if (this.hasAttribute("sides")) {
      parts.push(svg("path", { d: along(-most, -1, -4), class: "port" }));
      parts.push(svg("path", { d: along(1, most, -4), class: "starboard" }));
    }
    const line = (/** @type {number} */ value, /** @type {number} */ long, /** @type {string} */ style) => {
      const [[x1, y1], [x2, y2]] = [fan.point(at(value)), fan.point(at(value), long)];
      parts.push(svg("line", { x1, y1, x2, y2, class: style }));
    };
    const step = [1, 5, 10].find((each) => (each * half) / most >= FINE) ?? 10;
    const room = (/** @type {number} */ from, /** @type {number} */ to) => {
      const [[x1, y1], [x2, y2]] = [from, to].map((share) => fan.point(share, NUMERAL * size));
      return Math.hypot(x2 - x1, y2 - y1) >= WIDE * size;
    };
    const numbered = [10, 20, 30].find((each) => each <= most && room(0, each / most) && room(1, 1 - each / most));
    for (let value = -Math.floor(most / step) * step; value <= most; value += step) {
      const [major, middle] = [value % 10 === 0, value % 5 === 0];
      line(value, size * (major ? 1.2 : middle ? 0.85 : 0.5), major ? "tick" : "tick minor");
      const [x, y] = fan.point(at(value), NUMERAL * size);
      if (numbered ? value % numbered === 0 : Math.abs(value) === most && room(1, -1)) parts.push(text([x, y], "numeral", String(Math.abs(value))));
    }
    for (const end of [-most, most]) line(end, size * 1.3, "stop");
    if (this.closest("order-lever")) return parts; // whose keys bear the words
    return [...parts, ...this.sides(fan)];
  }

  /** Returns the words of both sides, where there is room for them. @param {Fan} fan */
  sides(fan) {
    const { face, half, inner, text: size } = fan;
    const end = face === "down" ? inner[1] : fan.within(0.6 * half);
    if (half < SIDES * size || end - inner[0] < WORD * size) return [];
    return (this.words ?? []).map((word, high) => {
      const way = high ? 1 : -1;
      const at = face === "down" ? fan.point(way, WORD * size) : fan.place(0.6 * way * half, (inner[0] + end) / 2);
      return text(at, "label", word);
    });
  }

  /** Shows the angle of the reference crew's run. @param {number | null} value [deg] */
  ghost(value) {
    const { faint, laid, limit } = this;
    faint?.toggleAttribute("hidden", value === null || !laid);
    if (value !== null && laid) faint?.setAttribute("transform", laid.stand(clamp(value, -limit, limit) / limit));
  }

  /** @param {number | null} value [deg] @param {number | null} [ordered] [deg] */
  show(value, ordered = null) {
    this.shown = [value, ordered];
    const { amount, bug, laid, limit, order, pointer, way, words } = this;
    if (!words || !pointer || !bug || !amount || !way || !order) return;
    const [low, high] = words;
    const stand = (/** @type {SVGElement} */ part, /** @type {number | null} */ to, /** @type {number} */ most) => {
      part.toggleAttribute("hidden", to === null || !laid);
      if (to !== null && laid) part.setAttribute("transform", laid.stand(clamp(to, -most, most) / limit));
    };
    stand(pointer, value, limit + BEYOND);
    stand(bug, this.closest("order-lever") ? null : ordered, limit);
    const [size, side = ""] = value === null ? [""] : sided(value, low, high).split(" ");
    if (this.digits(amount, size)) write(way, side); // never the one's digits with the other's side
    write(order, ordered === null ? "" : say("ordered {0}", sidedOrder(ordered, low, high)));
    if (value !== null) this.tell(value, [-limit, limit], `${say("{0} degrees", size)} ${side}`.trim());
  }
}

/** Puts a text to a place, in a size. @param {SVGElement | undefined} part @param {number} x @param {number} y @param {number} tall [px] */
function put(part, x, y, tall) {
  if (!part) return;
  part.style.fontSize = `${tall}px`;
  part.setAttribute("x", String(x));
  part.setAttribute("y", String(y));
}

customElements.define("angle-dial", AngleDial);

// Course: a card that turns under a fixed mark, as a gyro repeater; rate of turn as an arc.
import { bearing, svg, write } from "../draw.js";
import { difference } from "../model/motion.js";
import { Gauge, arc, around, bug, clamp, line, text, tick, turn } from "./gauge.js";
import { say } from "../words.js";

/** @type {import("./gauge.js").Point} */
const CENTRE = [160, 166];
const RADIUS = 142;
const RATE = 84; // radius of the arc
const WIDE = 30; // [deg] of arc for 1 deg/s
const MOST = 3; // [deg/s]
/** @type {Record<number, string>} */
const NAMES = { 0: say("N"), 90: say("E"), 180: say("S"), 270: say("W") };

class CourseRing extends Gauge {
  draw() {
    this.bug = bug(CENTRE, RADIUS + 1);
    this.faint = svg("path", { class: "ghost", d: `M160 ${CENTRE[1] - RADIUS}v34`, hidden: true });
    this.card = svg("g", {}, ...card(), this.faint, this.bug);
    this.rate = svg("path", { class: "rate" });
    this.figure = text([160, 178], "digits");
    this.order = text([160, 188], "order");
    this.error = text([160, 224], "label spare");
    const lubber = svg("path", { class: "pointer", d: "M160 48l9 -30h-18Z" });
    const rates = [-3, -2, -1, 1, 2, 3].map((rate) =>
      line(CENTRE, RATE - 4, RATE + 4, rate * WIDE, "tick minor"),
    );
    const words = [text([160, 132], "label spare", say("heading")), this.figure, this.order, this.error];
    this.picture([320, 320], this.card, lubber, ...rates, this.rate, ...words);
  }

  /** Shows the heading of the reference crew's run. @param {number | null} heading [deg] */
  ghost(heading) {
    if (this.faint) turn(this.faint, heading, CENTRE);
  }

  /**
   * @param {number | null} heading [deg]
   * @param {number | null} [ordered] [deg]
   * @param {number | null} [rate] [deg/s]
   */
  show(heading, ordered = null, rate = null) {
    if (!this.card || !this.bug || !this.rate || !this.figure || !this.order || !this.error) return;
    turn(this.card, heading === null ? 0 : -heading, CENTRE);
    turn(this.bug, ordered, CENTRE);
    const held = clamp(rate ?? 0, -MOST, MOST);
    this.rate.setAttribute("d", Math.abs(held) < 0.02 ? "" : arc(CENTRE, RATE, 0, held * WIDE));
    this.digits(this.figure, heading === null ? "" : bearing(heading));
    const told = ordered === null ? "" : say("ordered {0}", bearing(ordered));
    write(this.order, ordered !== null && this.dataset.room === "few" ? bearing(ordered) : told);
    write(this.error, heading === null || ordered === null ? "" : toGo(ordered, heading));
    if (heading === null) return;
    const order = ordered === null ? [] : [say("ordered {0}", bearing(ordered))];
    this.tell(heading, [0, 360], [say("{0} degrees", bearing(heading)), ...order].join(", "));
  }
}

/** Returns how far it is to an order, in words. @param {number} ordered @param {number} heading */
function toGo(ordered, heading) {
  const error = Math.round(difference(ordered, heading, true));
  if (error === 0) return say("on course");
  return error < 0 ? say("{0} to the left", -error) : say("{0} to the right", error);
}

/** Returns the card. */
function card() {
  /** @type {Element[]} */
  const parts = [svg("circle", { cx: CENTRE[0], cy: CENTRE[1], r: RADIUS, class: "face" })];
  for (let degrees = 0; degrees < 360; degrees += 5) {
    const rank = degrees % 30 === 0 ? 0 : degrees % 10 === 0 ? 1 : 2;
    parts.push(tick(CENTRE, RADIUS, degrees, rank));
    if (rank !== 0) continue;
    const [x, y] = around(CENTRE, RADIUS - 34, degrees);
    const name = NAMES[degrees] ?? bearing(degrees);
    const style = degrees % 90 === 0 ? "numeral quarter" : "numeral";
    parts.push(svg("text", { x, y, class: style, transform: `rotate(${degrees} ${x} ${y})` }, name));
  }
  return parts;
}

customElements.define("course-ring", CourseRing);

// A tile: one boat at a glance, with the way to its own page.
import { points } from "../charts/plots.js";
import { bearing, clock, html, one, svg, write } from "../draw.js";
import { STATES } from "../frame.js";
import { PLACES } from "../instructor/moment.js";
import { lengthDigits, unit } from "../units.js";
import { decimals, say } from "../words.js";

/** The curves: ordered and actual. @type {("depth" | "heading" | "speed")[]} */
const CURVES = ["depth", "heading", "speed"];
const SPAN = 300; // [s] of a curve
const [WIDE, HIGH] = [100, 30]; // of its picture
/** The least height of each curve, so that a steady boat shows a line. @type {Record<string, number>} */
const LEAST = { depth: 10, heading: 10, speed: 2 };
/** @type {Record<string, { title: () => string, unit: string, write: (value: number) => string }>} */
const FIGURES = {
  depth: { title: () => say("Depth"), unit: ` ${unit}`, write: lengthDigits },
  heading: { title: () => say("Course"), unit: "°", write: bearing },
  speed: { title: () => say("Speed"), unit: " kn", write: (value) => decimals(value, 1) },
};

/** @typedef {import("./class-boat.js").ClassBoat} ClassBoat */

export class Tile {
  /** @param {ClassBoat} boat @param {() => void} chosen is called when the choice changes */
  constructor(boat, chosen) {
    this.boat = boat;
    const { number } = boat.row;
    const name = say("Boat {0}", boat.title);
    this.box = /** @type {HTMLInputElement} */ (
      html("input", { type: "checkbox", id: `choose-${number}`, "aria-label": say("Choose boat {0}", boat.title), change: chosen })
    );
    this.way = html("a", { href: `./boat/${number}/instructor` }, name);
    this.curves = CURVES.map((of) => ({ of, node: curveNode(of) }));
    this.node = html(
      "article",
      { class: "panel tile", "data-boat": number, "aria-label": name },
      html("header", {}, this.box, html("h2", {}, this.way), html("span", { class: "state" }), html("span", { class: "time" })),
      html("div", { class: "aboard" }, html("p", { class: "crew quiet" }), html("span", { class: "shown", hidden: true }, say("shown to all"))),
      html("p", { class: "place quiet" }),
      ...this.curves.map(({ node }) => node),
      html("p", { class: "marks" }, html("meter", { min: 0, max: 100, "aria-label": say("Could still earn") }), html("span")),
      html("p", { class: "need", role: "status" }),
      html("p", { class: "said quiet", role: "status" }),
    );
  }

  get chosen() {
    return this.box.checked;
  }

  draw() {
    const { boat, node } = this;
    const { session } = boat;
    const [need] = boat.needs;
    const pill = one(".state", node);
    pill.dataset.state = session.state;
    write(pill, STATES[session.state]);
    const whole = session.exercise.duration ? ` / ${clock(Number(session.exercise.duration))}` : "";
    write(one(".time", node), `${clock(session.seconds)}${whole}`);
    write(one(".crew", node), boat.crew.join(", ") || say("nobody aboard"));
    for (const { of, node: curve } of this.curves) drawCurve(boat, of, curve);
    this.drawMarks();
    if (session.exercise.course) this.drawPlace();
    node.dataset.need = String(need?.rank ?? 0);
    write(one(".need", node), boat.needs.map(({ text }) => text).join(" \u00b7 "));
  }

  drawMarks() {
    const { attainable, session } = this.boat;
    const told = session.judgement.marks;
    const meter = /** @type {HTMLMeterElement} */ (one(".marks meter", this.node));
    meter.hidden = attainable === null || Boolean(told);
    meter.value = attainable ?? 0;
    const open = attainable === null ? "" : say("could still earn {0}", Math.round(attainable));
    write(one(".marks span", this.node), told || open);
  }

  /** Shows where it is in the course of its class. */
  drawPlace() {
    const { exercise, judgement } = this.boat.session;
    const [place, of, reach] = exercise.course.split(",");
    const told = [say("{0} of {1}: {2}", place, of, exercise.name)];
    if (judgement.total && reach) told.push(say("{0} of {1}", Math.floor(Number(judgement.total)), reach));
    else if (reach) told.push(say("{0} marks to go on", reach));
    write(one(".place", this.node), told.join(", "));
    one("#next").hidden = false;
  }

  /** Shows what the boat has answered. @param {import("../protocol/link.js").Answer} answer */
  say({ ok, text }) {
    const place = one(".said", this.node);
    place.toggleAttribute("data-refused", !ok);
    write(place, ok ? text || say("done") : say("no: {0}", text));
  }
}

/** @param {string} of */
function curveNode(of) {
  const lines = ["ordered", "actual"].map((kind) => svg("polyline", { class: kind }));
  const picture = svg("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, preserveAspectRatio: "none", "aria-hidden": "true" }, ...lines);
  return html("div", { class: "curve" }, html("span", { class: "quiet" }, FIGURES[of].title()), picture, html("b"), html("i"));
}

/** Draws one quantity over the last minutes, ordered and actual. @param {ClassBoat} boat @param {keyof typeof PLACES} of @param {HTMLElement} node */
function drawCurve({ session }, of, node) {
  const [place, ...orders] = PLACES[of];
  const shown = { actual: pointsOf(session, [place]), ordered: pointsOf(session, orders) };
  if (of === "heading") for (const line of Object.values(shown)) unwind(line, session.number(place) ?? 0);
  const values = Object.values(shown).flat().map(([, value]) => value);
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const spread = Math.max(high - low, LEAST[of]);
  const middle = (high + low) / 2;
  for (const [kind, line] of Object.entries(shown)) {
    const at = (/** @type {[number, number]} */ [seconds, value]) => {
      const up = (value - middle) / spread + 0.5;
      return `${(WIDE * (1 - (session.seconds - seconds) / SPAN)).toFixed(1)},${((of === "depth" ? up : 1 - up) * (HIGH - 4) + 2).toFixed(1)}`;
    };
    one(`.${kind}`, node).setAttribute("points", line.map(at).join(" "));
  }
  const now = session.number(place);
  const wanted = orders.map((order) => session.number(order)).find((value) => value !== null);
  const figure = FIGURES[of];
  write(one("b", node), now === null ? "-" : figure.write(now) + figure.unit);
  write(one("i", node), wanted == null ? "" : `\u2192 ${figure.write(wanted)}`);
}

/** Returns what some places have shown in the last minutes. @param {import("../model/session.js").Session} session @param {string[]} places @returns {[number, number][]} */
function pointsOf(session, places) {
  const past = (/** @type {string} */ channel) => session.history.of(channel);
  const found = points(past, places, session.seconds - SPAN);
  return /** @type {[number, number][]} */ (found.filter(([, value]) => value !== null));
}

/** Turns headings into angles without a step at north, near another one. @param {[number, number][]} line @param {number} near */
function unwind(line, near) {
  for (const point of line) point[1] = near + ((((point[1] - near + 180) % 360) + 360) % 360) - 180;
}

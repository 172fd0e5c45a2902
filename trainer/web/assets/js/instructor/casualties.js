// Casualties: what is broken, and what can be: found, preset by a click, given by a second one.
import { lossInWords } from "../briefing.js";
import { clock, html, one, write } from "../draw.js";
import { objectOf, wordOf } from "../model/orders.js";
import { Timing } from "./timing.js";
import { say } from "../words.js";

/**
 * @typedef {import("./desk.js").Desk} Desk
 * @typedef {import("../model/session.js").Casualty} Casualty
 * @typedef {object} Degree what severity 1 is, in the unit that people use
 * @property {number} severity usual
 * @property {number} ramp [s] usual
 * @property {number} factor the unit's number at severity 1
 * @property {string} unit
 * @property {string[]} sides the negative one first; none where there is only more or less
 * @property {string} side the usual one
 */

const SLOTS = 8;

/** Fills the panel. @param {Desk} desk */
export function showCasualties(desk) {
  const { session } = desk;
  const chooser = new Chooser(desk);
  session.on("tick", () => showBroken(desk));
  desk.moment.addEventListener("look", () => showBroken(desk));
  session.on("line", () => {
    chooser.list();
    showAhead(desk);
  });
  one("#find").oninput = () => chooser.list();
  one("#break").onsubmit = (event) => {
    event.preventDefault();
    void chooser.give();
  };
}

/** Lists what is broken, or was at the moment that is looked at. @param {Desk} desk */
function showBroken(desk) {
  const { moment } = desk;
  const word = (/** @type {number} */ slot, field = "") => moment.word(`casualties.casualty_${slot}${field}`);
  const slots = Array.from({ length: SLOTS }, (_, at) => at + 1).filter((slot) => word(slot));
  write(one("#broken-count"), slots.length ? say("{0} of {1}", slots.length, SLOTS) : say("none"));
  const told = slots.map((slot) => {
    const [name, says, left] = [word(slot), word(slot, "_says"), Number(word(slot, "_left"))];
    const clearing = Number(word(slot, "_target")) === 0;
    const lasts = Math.ceil(left);
    const does = clearing ? say("clears for {0} s", lasts) : say("grows for {0} s", lasts);
    return { name, says, when: left > 0 ? does : "" };
  });
  const list = one("#broken");
  const now = JSON.stringify([told, moment.looking !== null]);
  if (list.dataset.shown === now) return;
  list.dataset.shown = now;
  list.replaceChildren(...told.map((each) => brokenRow(desk, each)));
}

/** @param {Desk} desk @param {{ name: string, says: string, when: string }} told */
function brokenRow(desk, { name, says, when }) {
  const clear = () => void desk.give(`clear ${name}`);
  const key = html("button", { type: "button", "aria-label": say("Clear {0}", name), click: clear }, say("Clear"));
  const past = desk.moment.looking !== null; // then nothing is sent
  return html(
    "li",
    { class: "broken" },
    html("b", { class: "grow" }, says ? `${name}, ${says}` : name),
    html("span", {}, when),
    ...(past ? [] : [key]),
  );
}

/** Lists what is to come, the exercise's own too. @param {Desk} desk */
function showAhead(desk) {
  const list = one("#ahead");
  const { plans } = desk.session;
  const now = JSON.stringify(plans);
  if (list.dataset.shown === now) return;
  list.dataset.shown = now;
  list.hidden = plans.length === 0;
  list.replaceChildren(...plans.map((each) => aheadRow(desk, each)));
}

/** @param {Desk} desk @param {import("../model/told.js").Plan} plan */
function aheadRow(desk, { number, seconds, when, text }) {
  const moment = Number.isNaN(seconds) ? say("when {0}", lossInWords(when)) : say("at {0}", clock(seconds));
  const words = wordOf(text) === "casualty" ? objectOf(text) : text;
  const click = () => void desk.give(`cancel ${number}`);
  const own = html("small", {}, say("exercise"));
  const key = html("button", { type: "button", "aria-label": say("Take away {0} {1}", words, moment), click }, say("Take away"));
  return html("li", { class: "ahead" }, html("b", { class: "grow" }, words), html("span", {}, moment), number ? key : own);
}

class Chooser {
  /** @param {Desk} desk */
  constructor(desk) {
    this.desk = desk;
    /** @type {Casualty | null} */
    this.chosen = null;
    /** @type {Degree | null} */
    this.degree = null;
    this.drawn = "";
    this.timing = new Timing();
  }

  /** Lists what has the letters that were typed. */
  list() {
    const field = /** @type {HTMLInputElement} */ (one("#find"));
    const wanted = field.value.toLowerCase().split(/[\s-]+/);
    const found = this.desk.session.casualties.filter(({ name, says }) =>
      wanted.every((part) => `${name} ${says}`.toLowerCase().includes(part)),
    );
    const drawn = JSON.stringify([found, this.chosen?.name]);
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    one("#offers").replaceChildren(...found.map((each) => this.offer(each)));
  }

  /** @param {Casualty} casualty */
  offer(casualty) {
    const here = casualty.name === this.chosen?.name;
    const click = () => (casualty.name === this.chosen?.name ? void this.give() : this.choose(casualty));
    const parts = [html("b", {}, casualty.name), html("span", {}, casualty.says)];
    return html("li", {}, html("button", { type: "button", "aria-pressed": String(here), click }, ...parts));
  }

  /** Presets a casualty as its table has it. @param {Casualty} casualty */
  choose(casualty) {
    this.chosen = casualty;
    this.degree = degreeOf(this.desk.session.degrees.get(casualty.name));
    const { degree } = this;
    write(one("#chosen-name"), casualty.name);
    one("#chosen").hidden = false;
    this.timing.open();
    one("#degree").hidden = one("#ramp-field").hidden = degree === null;
    const side = /** @type {HTMLSelectElement} */ (one("#side"));
    side.hidden = !degree?.sides.length;
    side.replaceChildren(...(degree?.sides ?? []).map((word) => html("option", {}, word)));
    if (degree) {
      side.value = degree.side;
      field("#severity").value = String(Number(Math.abs(degree.severity * degree.factor).toPrecision(3)));
      field("#ramp").value = String(degree.ramp);
      write(one("#unit"), degree.unit);
    }
    const focused = document.activeElement?.closest("#offers");
    this.list();
    if (focused) /** @type {HTMLElement | null} */ (document.querySelector("#offers [aria-pressed='true']"))?.focus();
  }

  /** Gives what is chosen, or plans it. */
  async give() {
    if (!this.chosen) return;
    const answer = await this.desk.give(`${this.timing.words()}${this.words()}`);
    if (!answer.ok) return;
    this.chosen = null;
    one("#chosen").hidden = true;
    this.timing.close();
    this.list();
  }

  /** Returns the order for what is chosen. */
  words() {
    const { degree } = this;
    const name = this.chosen?.name ?? "";
    if (!degree) return `casualty ${name}`;
    const side = /** @type {HTMLSelectElement} */ (one("#side")).value;
    const amount = Number(field("#severity").value.replace(",", "."));
    const sign = degree.sides.length ? (side === degree.sides[0] ? -1 : 1) : 1;
    const severity = Number(((sign * amount) / degree.factor).toFixed(4));
    return `casualty ${name} ${severity} ramp ${Number(field("#ramp").value) || 0}`;
  }
}

/** @param {string} selector */
function field(selector) {
  return /** @type {HTMLInputElement} */ (one(selector));
}

/**
 * Returns the usual degree of a casualty, null where it has no other.
 * @param {string[] | undefined} fields name, severity, ramp, amount, unit, side, and the sides there are
 * @returns {Degree | null}
 */
export function degreeOf(fields) {
  if (!fields) return null;
  const [severity, ramp, amount] = fields.slice(1, 4).map(Number);
  const [unit, side, ...sides] = fields.slice(4);
  return { severity, ramp, factor: amount / Math.abs(severity), unit, sides, side };
}

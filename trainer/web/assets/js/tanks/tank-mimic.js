// The boat's tanks, air banks, valves and pumps, from the side. Each tank is a key: event `choose`.
import { tellScale } from "../gauges/gauge.js";
import { write } from "../draw.js";
import { chevron, drawTanks, sideways } from "./drawing.js";
import { BANKS, BLOWN, MAIN, MOVED, NARROW, TITLES, WIDE } from "./places.js";
import { decimals, say } from "../words.js";

const ROOM = 900; // [px] from which on the wide form is drawn
const FLAT = 2.6; // [-] width by height, above which it is the larger one
const FLOWS = 4000; // [ms] after which a level that stands still flows no more
const SPOKEN = 2000; // [ms] between changes of what a tank's label says
const LOW = [5, 20]; // [%] of a bank: warning, caution
/** @type {Record<string, string>} how a valve stands */
const VALVES = { open: say("open"), shut: say("shut"), emergency: say("emerg.") };
const LEAST = 0.05; // [t] of water where none belongs, or still to move, that is worth a mark

/**
 * @typedef {import("./places.js").Form} Form
 * @typedef {Record<string, string | number | null | undefined>} Values a reading, as it was sent
 * @typedef {{ tanks?: Values, air?: Values, valves?: Values,
 *   capacities?: Record<string, number>, still?: boolean }} Shown
 * `capacities` [t] are those that the session tells of its boat; `still`: at a moment that is looked
 * at, where an amount that is another than the last drawn one is no flow.
 * @typedef {{ amount: number, at: number, flow: number }} Flow
 */

/** @param {string | number | null | undefined} word @returns {number | null} */
function number(word) {
  return word === "" || word === null || word === undefined ? null : Number(word);
}

class TankMimic extends HTMLElement {
  /** @type {Map<string, SVGElement>} */
  #parts = new Map();
  /** @type {Map<string, Flow>} */
  #flows = new Map();
  /** @type {Map<string, number>} [ms] when a label last changed */
  #spoken = new Map();
  /** @type {Shown} */
  #shown = {};
  #chosen = "";
  /** @type {Form | null} */
  #form = null;
  #sizes = new ResizeObserver(() => this.#fit());

  connectedCallback() {
    this.classList.add("gauge");
    this.#sizes.observe(this);
    this.#fit();
  }

  disconnectedCallback() {
    this.#sizes.disconnect();
  }

  /** The tank whose orders are shown, "" for none. */
  get chosen() {
    return this.#chosen;
  }

  set chosen(name) {
    this.#chosen = name;
    for (const tank of Object.keys(TITLES)) {
      this.#parts.get(tank)?.setAttribute("aria-pressed", String(tank === name));
    }
  }

  /** Shows readings of the channels tanks, air and valves. @param {Shown} shown */
  show(shown) {
    this.#shown = shown;
    const { tanks, air, valves } = shown;
    if (!tanks) return;
    for (const name of Object.keys(TITLES)) this.#showTank(name, tanks);
    for (const name of Object.keys(BANKS)) this.#showBank(name, air ?? {});
    for (const name of BLOWN) this.#showValves(name, valves ?? {});
    for (const name of ["flood_aft", "flood_centre", "flood_forward"]) this.#showDry(name, tanks);
    this.#toggle("none", Object.keys(TITLES).every((name) => number(tanks[name]) === null));
    this.#toggle("trim", number(tanks.trim_aft) !== null);
  }

  // drawing

  #fit() {
    const [width, height] = [this.clientWidth, this.clientHeight];
    const form = width >= ROOM && width >= FLAT * height ? WIDE : NARROW;
    if (form === this.#form) return;
    this.#form = form;
    this.#spoken.clear();
    this.classList.toggle("short", form.short);
    const picture = drawTanks(form, (name) => this.#keys(name));
    this.replaceChildren(picture);
    tellScale(this, picture, form.size, () => this.show(this.#shown));
    this.#parts.clear();
    for (const part of this.querySelectorAll("[data-part]")) {
      this.#parts.set(part.getAttribute("data-part") ?? "", /** @type {SVGElement} */ (part));
    }
    this.chosen = this.#chosen;
    this.show(this.#shown);
  }

  /** @param {string} name */
  #keys(name) {
    const choose = () => {
      this.chosen = name;
      this.dispatchEvent(new CustomEvent("choose", { detail: name, bubbles: true }));
    };
    const keydown = (/** @type {Event} */ event) => {
      if (!["Enter", " "].includes(/** @type {KeyboardEvent} */ (event).key)) return;
      event.preventDefault();
      choose();
    };
    return { "aria-pressed": "false", click: choose, keydown };
  }

  // showing

  /** @param {string} name @param {boolean} yes */
  #toggle(name, yes) {
    this.#parts.get(name)?.toggleAttribute("hidden", !yes);
  }

  /** @param {string} name @param {string} text */
  #write(name, text) {
    const node = this.#parts.get(name);
    if (node) write(node, text);
  }

  /** @param {string} name @param {Values} tanks */
  #showTank(name, tanks) {
    const form = this.#form ?? NARROW;
    const amount = number(tanks[name]);
    this.#toggle(name, amount !== null);
    this.#toggle(`${name} words`, amount !== null);
    if (amount === null) return;
    const full = number(tanks[`${name}_full`]) ?? 0;
    const capacity = this.#shown.capacities?.[name] ?? 0;
    const [field, sign] = MOVED[name] ?? ["", 0];
    const moving = (number(tanks[field]) ?? 0) * sign;
    const [x, y, w, h] = form.tanks[name];
    const high = h * Math.min(Math.max(full / 100, 0), 1);
    const level = this.#parts.get(`${name} level`);
    level?.setAttribute("y", (y + h - high).toFixed(1));
    level?.setAttribute("height", high.toFixed(1));
    const share = capacity ? Math.min(Math.max((amount + moving) / capacity, 0), 1) : 0;
    const target = Math.abs(moving) < LEAST ? "" : `M${x} ${(y + h * (1 - share)).toFixed(1)}h${w}`;
    this.#parts.get(`${name} target`)?.setAttribute("d", target);
    const bare = this.dataset.room !== "all" && !MAIN.includes(name); // where a sign has no room
    const percent = `${full.toFixed(0)}${bare ? "" : " %"}`;
    this.#write(`${name} value`, form.short ? percent : `${decimals(amount, 1)} t  ${percent}`);
    this.#showFlow(name, amount, moving);
    this.#say(name, amount, full, moving);
  }

  /** @param {string} name @param {number} amount @param {number} moving */
  #showFlow(name, amount, moving) {
    const form = this.#form ?? NARROW;
    const [x, , w] = form.tanks[name];
    const [middle, size] = [x + w / 2, form.short ? 6 : 9];
    const flow = Math.abs(moving) >= LEAST ? Math.sign(moving) : this.#flowing(name, amount);
    if (name === "trim_aft") return;
    if (name === "trim_forward") {
      const [fore, , wide] = form.tanks.negative;
      const along = sideways((fore + wide + x) / 2, form.trim, size, flow);
      this.#parts.get("trim flow")?.setAttribute("d", flow ? along : "");
      return;
    }
    const height = MAIN.includes(name) ? form.foot + size : form.keel - size;
    const part = this.#parts.get(`${name} flow`);
    part?.setAttribute("d", flow ? chevron(middle, height, size, flow) : "");
    this.#parts.get(name)?.setAttribute("data-flow", ["out", "none", "in"][flow + 1]);
  }

  /** Returns which way water flows, 1 in, -1 out, by how the amount changes. */
  #flowing(/** @type {string} */ name, /** @type {number} */ amount) {
    if (this.#shown.still) this.#flows.delete(name);
    if (this.#shown.still) return 0;
    const now = performance.now();
    const before = this.#flows.get(name);
    if (before?.amount === amount) return now - before.at < FLOWS ? before.flow : 0;
    const flow = before ? Math.sign(amount - before.amount) : 0;
    this.#flows.set(name, { amount, at: now, flow });
    return flow;
  }

  /** @param {string} name @param {number} amount @param {number} full @param {number} moving */
  #say(name, amount, full, moving) {
    const now = performance.now();
    if (now - (this.#spoken.get(name) ?? -SPOKEN) < SPOKEN) return;
    this.#spoken.set(name, now);
    const more = Math.abs(moving) < LEAST ? [] : [say("{0} still to move", decimals(Math.abs(moving), 1))];
    const holds = [say("{0} tonnes, {1} percent", decimals(amount, 1), full.toFixed(0)), ...more].join(", ");
    this.#parts.get(name)?.setAttribute("aria-label", `${TITLES[name][0]}: ${holds}`);
  }

  /** @param {string} name @param {Values} air */
  #showBank(name, air) {
    const [pressure, full] = [number(air[name]), number(air[`${name}_full`]) ?? 0];
    this.#toggle(`bank ${name}`, pressure !== null);
    if (pressure === null) return;
    const [, , width] = (this.#form ?? NARROW).banks[name];
    const share = Math.min(Math.max(full / 100, 0), 1);
    this.#parts.get(`bank ${name} level`)?.setAttribute("width", (width * share).toFixed(1));
    this.#write(`bank ${name} value`, `${decimals(pressure, 1)} MPa`);
    const rank = full < LOW[0] ? "warning" : full < LOW[1] ? "caution" : "none";
    this.#parts.get(`bank ${name}`)?.setAttribute("data-rank", rank);
  }

  /** @param {string} name @param {Values} valves */
  #showValves(name, valves) {
    const own = name === "negative" ? ["negative_flood"] : [];
    for (const valve of [`vent_${name}`, `blow_${name}`, ...own]) {
      const stands = String(valves[valve] ?? "");
      const open = stands !== "" && stands !== "shut";
      this.#parts.get(valve)?.setAttribute("data-open", String(open));
      this.#write(`${valve} word`, VALVES[stands] ?? stands);
    }
    const blown = String(valves[`blow_${name}`] ?? "shut") !== "shut";
    this.#parts.get(`${name} air`)?.setAttribute("data-open", String(blown));
  }

  /** @param {string} name @param {Values} tanks */
  #showDry(name, tanks) {
    const amount = number(tanks[name]) ?? 0;
    this.#toggle(name, amount >= LEAST);
    const small = this.#form?.short && this.dataset.room !== "all";
    const told = !small ? decimals(amount, 1) : amount < 1 ? "< 1" : amount.toFixed(0);
    this.#write(`${name} word`, this.#form?.short ? `${told} t` : say("FLOODED {0} t", told)); // a hatch says it, too
  }
}

customElements.define("tank-mimic", TankMimic);

// The controls of tanks and air on a page: switches, pumps, the cover; they show what stands.
import { one, write } from "../draw.js";
import { Pending } from "../model/pending.js";
import { BLOWN, MAIN, TITLES } from "./places.js";
import { ordersTo, ordersToShut, position } from "./levers.js";
import { decimals, say } from "../words.js";

/**
 * @typedef {import("../model/session.js").Session} Session
 * @typedef {(words: string) => Promise<boolean>} Give gives an order; whether it was obeyed
 * @typedef {HTMLElement & { show(stands: string, wanted?: string): void }} PositionSwitch
 * @typedef {HTMLElement & { show(moving: number): void }} PumpKeys
 */

/** Which group of controls a tank has. @type {Record<string, string>} */
const GROUP = {
  aft: "main",
  mid: "main",
  forward: "main",
  negative: "main",
  trim_aft: "trim",
  trim_forward: "trim",
  auxiliary: "auxiliary",
  depth_control: "depth",
};
/** Switches: what tells how each stands, and how its positions are ordered. */
const SWITCHES = /** @type {Record<string, [string, string, Record<string, string>?]>} */ ({
  hover: ["tanks.hover", "hover"],
  compressor: ["air.compressor", "compressor"],
  trim: ["tanks.trim_mode", "trim", { hand: "manual" }],
  drain: ["tanks.draining", "drain"],
});

export class TankPanel {
  /** @param {Session} session @param {Give} give */
  constructor(session, give) {
    this.session = session;
    this.give = give;
    this.pending = new Pending(session, "valves"); // a page asks for it behind tanks and air
    this.mimic = /** @type {any} */ (one("tank-mimic"));
    this.listen();
  }

  /** How the levers stand, or are ordered to stand. */
  get positions() {
    const valves = this.session.readings.latest.get("valves")?.values ?? {};
    return Object.fromEntries(
      BLOWN.map((group) => [
        group,
        this.pending.resolve(`lever ${group}`, position(valves, group)),
      ]),
    );
  }

  listen() {
    this.mimic.addEventListener("choose", (/** @type {CustomEvent} */ event) => {
      /** @type {any} */ (document.querySelector("part-keys[part=group]"))?.choose(
        GROUP[event.detail],
      );
      showTanks(this.session);
    });
    this.each("[data-lever]", (node, name) =>
      this.heard(node, (detail) => this.move(name, String(detail))),
    );
    this.each("[data-switch]", (node, name) =>
      this.heard(node, (detail) => this.turn(name, String(detail))),
    );
    this.each("[data-pump]", (node, name) =>
      this.heard(node, (detail) => this.pump(node, name, Number(detail))),
    );
    this.each("[data-order]", (node, words) => {
      const { levers } = node.dataset;
      const wanted = levers ? allLevers(levers) : {};
      node.addEventListener("click", () => this.send(wanted, [words]));
    });
    this.each("[data-shut]", (node) => node.addEventListener("click", () => this.shut()));
    this.each("emergency-cover", (node) => 
      this.heard(node, () => this.send(allLevers("blow"), ["emergency blow"])),
    );
  }

  /**
   * @param {string} selector
   * @param {(node: HTMLElement, name: string) => void} does
   */
  each(selector, does) {
    for (const each of document.querySelectorAll(selector)) {
      const node = /** @type {HTMLElement} */ (each);
      const { lever, switch: turned, pump, order } = node.dataset;
      does(node, lever ?? turned ?? pump ?? order ?? "");
    }
  }

  /** @param {HTMLElement} node @param {(detail: unknown) => void} listener */
  heard(node, listener) {
    node.addEventListener("order", (event) => listener(/** @type {CustomEvent} */ (event).detail));
  }

  // orders

  /** Brings a lever to a position. @param {string} group @param {string} wanted */
  move(group, wanted) {
    const orders = ordersTo(group, wanted, this.positions);
    return this.send({ [`lever ${group}`]: wanted }, orders);
  }

  /** Shuts main ballast, vents and blows. */
  shut() {
    return this.send(allLevers("shut"), ordersToShut(this.positions));
  }

  /** @param {string} name @param {string} wanted */
  turn(name, wanted) {
    const [, order, words = {}] = SWITCHES[name];
    return this.send({ [`switch ${name}`]: wanted }, [`${order} ${words[wanted] ?? wanted}`]);
  }

  /** @param {HTMLElement} node @param {string} name @param {number} amount [t] */
  pump(node, name, amount) {
    const words = amount < 0 ? node.dataset.low : node.dataset.high;
    return this.send({ [`pump ${name}`]: amount }, [`${words} ${Math.abs(amount)}`]);
  }

  /**
   * Sends orders one behind the other; what is wanted shows until readings tell.
   * @param {Record<string, string | number>} wanted by the name of each control
   * @param {string[]} orders
   */
  async send(wanted, orders) {
    for (const [name, value] of Object.entries(wanted)) this.pending.give(name, value);
    const obeyed = await Promise.all(orders.map((words) => this.give(words)));
    for (const name of Object.keys(wanted)) this.pending.answered(name, obeyed.every(Boolean));
    this.show();
  }

  // showing

  show() {
    const { session } = this;
    const values = (/** @type {string} */ channel) => session.readings.latest.get(channel)?.values;
    const valves = values("valves");
    if (!values("tanks")) return;
    showTanks(session);
    this.fit();
    const wanted = this.positions;
    this.each("[data-lever]", (node, group) =>
      /** @type {PositionSwitch} */ (node).show(position(valves ?? {}, group), wanted[group]),
    );
    this.each("[data-switch]", (node, name) => {
      const reading = session.word(SWITCHES[name][0]) || "stop";
      const stands = reading === "no air" ? "on" : reading;
      const ordered = this.pending.resolve(`switch ${name}`, stands);
      /** @type {PositionSwitch} */ (node).show(stands, ordered);
    });
    this.each("[data-pump]", (node, name) => {
      const moving = session.number(`tanks.moving_${name}`) ?? 0;
      /** @type {PumpKeys} */ (node).show(this.pending.resolve(`pump ${name}`, moving));
    });
    this.balance();
  }

  /** Leaves out what this boat lacks: its field is empty. */
  fit() {
    for (const each of document.querySelectorAll("[data-needs]")) {
      const place = /** @type {HTMLElement} */ (each).dataset.needs ?? "";
      each.toggleAttribute("hidden", this.session.word(place) === "");
    }
    const keys = /** @type {any} */ (document.querySelector("part-keys[part=group]"));
    const sections = document.querySelectorAll("section[data-group]:not([hidden])");
    const groups = [...sections].map((each) => {
      const { group = "", short = "" } = /** @type {HTMLElement} */ (each).dataset;
      return [group, short];
    });
    const now = JSON.stringify(groups);
    if (!keys || keys.dataset.groups === now) return;
    keys.dataset.groups = now;
    keys.parts = groups;
  }

  /** Shows the moment of the trim water, and what it will be. */
  balance() {
    const bar = /** @type {any} */ (document.querySelector("balance-bar"));
    const { session } = this;
    const [fore, aft] = [session.number("tanks.trim_forward"), session.number("tanks.trim_aft")];
    const arm = (session.ranges["trim-arm"] ?? 0) / 2;
    if (!bar || !arm || fore === null || aft === null) return bar?.show?.(null, 0);
    const moving = session.number("tanks.moving_trim") ?? 0;
    const most = Math.max(session.tanks.trim_forward ?? 0, session.tanks.trim_aft ?? 0) * arm;
    bar.show((fore - aft) * arm, most, moving ? (fore - aft + 2 * moving) * arm : null);
  }
}

/** Returns a position of all levers of main ballast. @param {string} wanted */
function allLevers(wanted) {
  return Object.fromEntries(MAIN.map((group) => [`lever ${group}`, wanted]));
}

/** Shows the picture of the tanks, and what the chosen one holds. @param {Session} session */
export function showTanks(session) {
  const mimic = /** @type {any} */ (one("tank-mimic"));
  const values = (/** @type {string} */ channel) => session.readings.latest.get(channel)?.values;
  const [tanks, air, valves] = [values("tanks"), values("air"), values("valves")];
  mimic.show({ tanks, air, valves, capacities: session.tanks });
  const name = mimic.chosen;
  const amount = session.number(`tanks.${name}`);
  if (!name || amount === null) return;
  const whole = session.tanks[name];
  const [title, holds] = [TITLES[name][0], decimals(amount, 1)];
  write(one("#tank"), whole ? say("{0}: {1} of {2} t", title, holds, decimals(whole, 1)) : `${title}: ${holds} t`);
}

// What moves a surface: normal, emergency or hand, the pressure of its oil, and keys that shift it.
import { html, write } from "../draw.js";
import { decimals, say } from "../words.js";

const LOW_OIL = 16; // [MPa] below which the session warns of it
/** Which system of oil moves a surface in each mode; hands need none. @type {Record<string, string>} */
const SYSTEMS = { normal: "main", emergency: "vital" };
const MODES = { normal: say("Normal"), emergency: say("Emerg."), hand: say("Hand") };
/** What a key says aloud. @type {Record<string, string>} */
const WHOLE = { normal: say("Normal: main oil"), emergency: say("Emerg.: vital oil"), hand: say("Hand: no oil") };
/** @type {Record<string, (seconds: string) => string>} */
const COMING = {
  normal: (seconds) => say("to normal in {0} s", seconds),
  emergency: (seconds) => say("to emergency in {0} s", seconds),
  hand: (seconds) => say("to hand in {0} s", seconds),
};

/**
 * @typedef {import("../model/session.js").Session} Session
 * @typedef {(words: string) => Promise<unknown>} Give gives an order
 */

/**
 * `<supply-keys name="stern" label="Stern planes" channel="supply">`: hidden where the boat has no
 * plant. A key is pressed as the surface is moved, and framed while it is being shifted to it. Keys
 * of a role that may not shift it are left out.
 */
class SupplyKeys extends HTMLElement {
  #title = html("b", {});
  #told = html("span", { class: "told" });
  /** @type {[string, HTMLElement][]} */
  #keys = [];
  #row = html("div", { class: "keys", role: "group", "data-control": true });

  /** @param {Session} session @param {Give} give */
  bind(session, give) {
    const name = this.getAttribute("name") ?? "";
    const label = this.getAttribute("label") ?? "";
    write(this.#title, label);
    this.#row.setAttribute("aria-label", say("{0}: moved by", label));
    const may = session.may(name === "rudder" ? "rudder normal" : "planes normal");
    this.#keys = Object.entries(MODES).map(([mode, word]) => {
      const click = () => void give(`${name} ${mode}`);
      return [mode, html("button", { type: "button", "aria-label": WHOLE[mode], click }, word)];
    });
    this.#row.append(...this.#keys.map(([, key]) => key));
    this.append(this.#title, this.#told, ...(may ? [this.#row] : []));
    this.hidden = true;
    session.on("tick", () => this.show(session));
    session.on("ranges", () => {
      for (const [mode, key] of this.#keys) key.toggleAttribute("hidden", !(`shift-${mode}` in session.ranges));
    });
  }

  /** @param {Session} session */
  show(session) {
    const [channel, name] = [this.getAttribute("channel") ?? "supply", this.getAttribute("name") ?? ""];
    const mode = session.word(`${channel}.${name}_supply`);
    const coming = session.word(`${channel}.${name}_shifted_to`);
    this.toggleAttribute("hidden", mode === "");
    for (const [each, key] of this.#keys) {
      key.setAttribute("aria-pressed", String(each === mode));
      key.toggleAttribute("data-coming", each === coming);
    }
    const pressure = session.number(`${channel}.${SYSTEMS[mode]}_pressure`);
    const [told, isUnusual] = coming ? [shifting(session, channel, name, coming), true] : moved(mode, pressure);
    write(this.#told, told);
    this.#told.toggleAttribute("data-unusual", isUnusual);
  }
}

/** @param {Session} session @param {string} channel @param {string} name @param {string} coming */
function shifting(session, channel, name, coming) {
  return COMING[coming](decimals(session.number(`${channel}.${name}_shift`) ?? 0, 0));
}

/** Returns what moves a surface, and whether that is unusual. @param {string} mode @param {number | null} pressure @returns {[string, boolean]} */
function moved(mode, pressure) {
  if (pressure === null) return [say("by hand, no oil"), true];
  const isLow = pressure < LOW_OIL;
  const oil = decimals(pressure, 1);
  if (mode === "emergency") return [isLow ? say("vital oil LOW {0} MPa", oil) : say("vital oil {0} MPa", oil), true];
  return isLow ? [say("main oil LOW {0} MPa", oil), true] : [say("main oil {0} MPa", oil), false];
}

customElements.define("supply-keys", SupplyKeys);

/** Binds all that a page has. @param {Session} session @param {Give} give */
export function bindSupplies(session, give) {
  for (const each of document.querySelectorAll("supply-keys")) /** @type {SupplyKeys} */ (each).bind(session, give);
}

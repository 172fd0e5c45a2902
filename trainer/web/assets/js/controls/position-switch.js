// A switch of a few positions, such as vent, shut, blow. It gives an order and shows what stands.
import { html, one, write } from "../draw.js";
import { say } from "../words.js";

/** @type {Record<string, string>} */
const WORDS = {
  vent: say("vent"),
  flood: say("flood"),
  shut: say("shut"),
  blow: say("blow"),
  off: say("off"),
  on: say("on"),
  hand: say("hand"),
  auto: say("auto"),
  stop: say("stop"),
  aft: say("aft"),
  centre: say("centre"),
  forward: say("forward"),
};
/** What stands in a position: its glyph turns with it, so that a shape says it too. */
const SHAPES = ["vent", "flood", "shut", "blow", "off", "on", "hand", "auto"];

/**
 * `<position-switch label="Forward" positions="vent shut blow">`: event `order`, detail the
 * position. Blue frame: ordered. Solid mark: as it stands.
 */
class PositionSwitch extends HTMLElement {
  /** @type {string[]} */
  #positions = [];
  /** @type {Map<string, HTMLElement>} */
  #keys = new Map();
  #wanted = "";
  #stands = "";

  connectedCallback() {
    if (this.firstChild) return;
    this.#positions = (this.getAttribute("positions") ?? "off on").split(" ");
    const label = this.getAttribute("label") ?? "";
    for (const position of this.#positions) this.#keys.set(position, this.#key(position));
    const keys = html("div", { class: "positions", role: "radiogroup", "aria-label": label });
    keys.append(...this.#keys.values());
    this.append(html("span", { class: "title", "aria-hidden": "true" }, label), keys);
    this.#mark();
  }

  /**
   * Shows the position that stands, and the one that was ordered if it is another.
   * @param {string} stands
   * @param {string} [wanted]
   */
  show(stands, wanted = stands) {
    if (this.#stands === stands && this.#wanted === wanted) return;
    [this.#stands, this.#wanted] = [stands, wanted];
    this.#mark();
  }

  /** @param {string} position */
  #key(position) {
    const word = (this.getAttribute(`word-${position}`) ?? WORDS[position] ?? position).toUpperCase();
    const shape = SHAPES.includes(position) ? position : "shut";
    return html(
      "button",
      {
        type: "button",
        role: "radio",
        "aria-checked": "false",
        "data-position": position,
        click: () => this.#order(position),
        keydown: (event) => this.#move(/** @type {KeyboardEvent} */ (event), position),
      },
      html("span", { class: "mark", "aria-hidden": "true" }),
      html("span", { class: `shape ${shape}`, "aria-hidden": "true" }),
      html("span", { class: "word" }, word),
      html("span", { class: "unseen" }),
    );
  }

  /** @param {string} position */
  #order(position) {
    this.#wanted = position;
    this.#mark();
    this.dispatchEvent(new CustomEvent("order", { detail: position, bubbles: true }));
  }

  /** @param {KeyboardEvent} event @param {string} position */
  #move(event, position) {
    const by = { ArrowUp: -1, ArrowLeft: -1, ArrowDown: 1, ArrowRight: 1 }[event.key];
    const next = by && this.#positions[this.#positions.indexOf(position) + by];
    if (!next) return;
    event.preventDefault();
    this.#order(next);
    this.#keys.get(next)?.focus();
  }

  #mark() {
    const focus = this.#keys.has(this.#wanted) ? this.#wanted : this.#positions[0];
    for (const [position, key] of this.#keys) {
      key.setAttribute("aria-checked", String(position === this.#wanted));
      key.toggleAttribute("data-stands", position === this.#stands);
      key.tabIndex = position === focus ? 0 : -1;
      write(one(".unseen", key), position === this.#stands ? ` ${say("(stands)")}` : "");
    }
  }
}

customElements.define("position-switch", PositionSwitch);

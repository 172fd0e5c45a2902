// Keys of a pump: amounts to choose from, two directions, what is still to move, and Stop.
import { html, write } from "../draw.js";
import { decimals, say } from "../words.js";

const AMOUNTS = [1, 2, 5, 10]; // [t]
const LEAST = 0.05; // [t] below which nothing is left to move

/**
 * `<pump-keys label="Auxiliary" high="Flood" low="Pump" arrows="↓ ↑">`: event `order`, detail the
 * amount [t] still to move from now on, positive for `high`, 0 to stop. The same direction again adds.
 */
class PumpKeys extends HTMLElement {
  #amount = 2;
  #moving = 0;
  #left = html("p", { class: "left", "aria-live": "off" });
  /** @type {HTMLElement[]} */
  #amounts = [];
  /** @type {[number, HTMLElement][]} */
  #directions = [];
  #stop = html("button", { type: "button", class: "stop", click: () => this.#order(0) }, say("Stop"));

  connectedCallback() {
    if (this.firstChild) return;
    const label = this.getAttribute("label") ?? "";
    this.setAttribute("role", "group");
    this.setAttribute("aria-label", label);
    this.#amounts = AMOUNTS.map((amount) => this.#choice(amount));
    const choose = { class: "amounts", role: "radiogroup", "aria-label": say("{0}: tonnes", label) };
    this.#directions = [-1, 1].map((sign) => [sign, this.#direction(sign)]);
    this.append(
      this.#left,
      html("div", choose, ...this.#amounts),
      html("div", { class: "directions" }, ...this.#directions.map(([, key]) => key), this.#stop),
    );
    this.#choose(this.#amount);
    this.show(0);
  }

  /** Shows the amount [t] still to move, positive for `high`. @param {number} moving */
  show(moving) {
    this.#moving = Math.abs(moving) < LEAST ? 0 : moving;
    const way = this.#moving > 0 ? "high" : "low";
    this.toggleAttribute("data-moving", this.#moving !== 0);
    const words = say("{0}: {1} t to go", this.#name(way), decimals(Math.abs(this.#moving), 1));
    write(this.#left, this.#moving ? words : say("nothing to move"));
    this.#stop.toggleAttribute("disabled", this.#moving === 0);
  }

  /** @param {string} way */
  #name(way) {
    return this.getAttribute(way) ?? way;
  }

  /** @param {number} amount */
  #choice(amount) {
    const keydown = (/** @type {Event} */ event) => {
      const by = { ArrowLeft: -1, ArrowRight: 1 }[/** @type {KeyboardEvent} */ (event).key];
      const next = by && AMOUNTS[AMOUNTS.indexOf(amount) + by];
      if (!next) return;
      event.preventDefault();
      this.#choose(next);
      this.#amounts[AMOUNTS.indexOf(next)].focus();
    };
    const click = () => this.#choose(amount);
    return html("button", { type: "button", role: "radio", click, keydown }, String(amount));
  }

  /** @param {number} amount */
  #choose(amount) {
    this.#amount = amount;
    AMOUNTS.forEach((each, index) => {
      this.#amounts[index].setAttribute("aria-checked", String(each === amount));
      this.#amounts[index].tabIndex = each === amount ? 0 : -1;
    });
    for (const [sign, key] of this.#directions) {
      const [low, high] = (this.getAttribute("arrows") ?? "↓ ↑").split(" ");
      const arrow = html("span", { "aria-hidden": "true" }, sign > 0 ? ` ${high}` : `${low} `);
      const tonnes = html("span", {}, `${amount} t`);
      const below = html("span", {}, ...(sign > 0 ? [tonnes, arrow] : [arrow, tonnes]));
      key.replaceChildren(html("span", {}, `${this.#name(sign > 0 ? "high" : "low")} `), below);
    }
  }

  /** @param {number} sign */
  #direction(sign) {
    const side = sign > 0 ? "high" : "low";
    const click = () => {
      const before = Math.sign(this.#moving) === sign ? this.#moving : 0;
      this.#order(before + sign * this.#amount);
    };
    return html("button", { type: "button", class: `direction ${side}`, click });
  }

  /** @param {number} amount */
  #order(amount) {
    const detail = Math.round(amount * 10) / 10;
    this.show(detail);
    this.dispatchEvent(new CustomEvent("order", { detail, bubbles: true }));
  }
}

customElements.define("pump-keys", PumpKeys);

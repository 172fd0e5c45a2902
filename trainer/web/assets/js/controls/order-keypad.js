// A keypad that makes a number into an order: the number first, then what it is.
import { html, write } from "../draw.js";
import { say } from "../words.js";

const DIGITS = ["1", "2", "3", "4", "5", "6", "7", "8", "9", "clear", "0", "back"];
const LONGEST = 4;

/**
 * `<order-keypad label="...">` with `.keys = [[key, words, least, most]...]`: event `order`, detail
 * `{ key, number }`. A key works while the number lies in its range.
 */
class OrderKeypad extends HTMLElement {
  #typed = "";
  #shown = html("output", { class: "typed" });
  /** @type {[HTMLElement, number, number][]} */
  #keys = [];
  #ends = html("div", { class: "ends" });

  connectedCallback() {
    if (this.firstChild) return;
    this.setAttribute("role", "group");
    this.setAttribute("aria-label", this.getAttribute("label") ?? say("Keypad"));
    const digits = DIGITS.map((digit) => {
      const words = { clear: "C", back: "⌫" }[digit] ?? digit;
      const label = { clear: say("Clear"), back: say("Last digit back") }[digit] ?? digit;
      return html(
        "button",
        { type: "button", "aria-label": label, click: () => this.#press(digit) },
        words,
      );
    });
    this.append(this.#shown, html("div", { class: "digits" }, ...digits), this.#ends);
    this.addEventListener("keydown", (event) => this.#type(event));
    this.#write();
  }

  /** @param {[string, string, number, number][]} keys what is ordered, its words, least and greatest number */
  set keys(keys) {
    const now = JSON.stringify(keys);
    if (this.dataset.keys === now) return;
    this.dataset.keys = now;
    this.#keys = keys.map(([key, words, least, most]) => {
      const click = () => this.#order(key);
      return [html("button", { type: "button", click }, words), least, most];
    });
    this.#ends.replaceChildren(...this.#keys.map(([key]) => key));
    this.#write();
  }

  /** @param {KeyboardEvent} event */
  #type(event) {
    const pressed = { Backspace: "back", Delete: "clear" }[event.key] ?? event.key;
    if (!DIGITS.includes(pressed)) return;
    event.preventDefault();
    this.#press(pressed);
  }

  /** @param {string} digit */
  #press(digit) {
    if (digit === "clear") this.#typed = "";
    else if (digit === "back") this.#typed = this.#typed.slice(0, -1);
    else this.#typed = `${this.#typed}${digit}`.slice(-LONGEST).replace(/^0+(?=\d)/, "");
    this.#write();
  }

  #write() {
    write(this.#shown, this.#typed || say("none"));
    this.#shown.toggleAttribute("data-typed", this.#typed !== "");
    const number = Number(this.#typed);
    for (const [key, least, most] of this.#keys) {
      key.toggleAttribute("disabled", !this.#typed || number < least || number > most);
    }
  }

  /** @param {string} key */
  #order(key) {
    const detail = { key, number: Number(this.#typed) };
    this.#typed = "";
    this.#write();
    this.querySelector("button")?.focus();
    this.dispatchEvent(new CustomEvent("order", { detail, bubbles: true }));
  }
}

customElements.define("order-keypad", OrderKeypad);

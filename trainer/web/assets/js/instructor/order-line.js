// The line where orders are typed: completed by Tab or a click, brought back by Up and Down.
import { html, one } from "../draw.js";
import { next } from "./completion.js";
import { mayGive } from "../model/orders.js";
import { say } from "../words.js";

/**
 * @typedef {{ session: import("../model/session.js").Session,
 *   give(words: string): Promise<{ ok: boolean }> }} Desk who gives what is typed
 */

const SHOWN = 8; // words that may come next
const KEPT = 50; // orders that can be brought back

/** Furnishes the line. @param {Desk} desk */
export function furnishOrderLine(desk) {
  const line = new OrderLine(desk);
  one("#mark").onclick = () => void desk.give("mark");
  return line;
}

class OrderLine {
  /** @param {Desk} desk */
  constructor(desk) {
    this.desk = desk;
    this.field = /** @type {HTMLInputElement} */ (one("#order"));
    /** @type {import("./completion.js").OrderWords} */
    this.table = JSON.parse(one("#order-words").textContent ?? "{}");
    const { role } = desk.session;
    const may = (/** @type {string} */ form) => mayGive(form.replace(/[[\]]/g, ""), role, "running");
    if (role !== "instructor") this.table.forms = this.table.forms.filter(([form]) => may(form));
    /** @type {string[]} */
    this.given = [];
    this.place = 0;
    this.field.oninput = () => this.suggest();
    this.field.onfocus = () => this.suggest();
    this.field.onblur = () => setTimeout(() => this.clear(), 200);
    this.field.onkeydown = (event) => this.press(event);
    one("#type").onsubmit = (event) => {
      event.preventDefault();
      void this.give();
    };
  }

  /** What names an order may hold, as they are known now. */
  get names() {
    const { session } = this.desk;
    const kept = () => session.signs.kept.filter(({ sign }) => sign === "S").map(({ text }) => text);
    return {
      NAME: () => [...session.casualties.map(({ name }) => name), "all"],
      LABEL: () => [...kept(), "here"],
      CHANNEL: () => [...session.readings.names.keys(), "events"],
      EXERCISE: () => [],
      ORDER: () => [...new Set(this.table.forms.map(([form]) => form.split(" ")[0].replace(/[[\]]/g, "")))],
    };
  }

  /** What may come next after what is typed. */
  get next() {
    return next(this.table, this.names, this.field.value);
  }

  suggest() {
    const { words, hints } = this.next;
    const keys = words.slice(0, SHOWN).map((word) =>
      html("button", { type: "button", tabindex: -1, class: "small", click: () => this.take(word) }, word),
    );
    const more = words.length > SHOWN ? [html("span", {}, say("and {0} more", words.length - SHOWN))] : [];
    const told = hints.slice(0, 2).map((hint) => html("span", {}, hint));
    one("#completions").replaceChildren(...(this.field.value ? [...keys, ...more, ...told] : []));
  }

  clear() {
    if (document.activeElement !== this.field) one("#completions").replaceChildren();
  }

  /** Takes a word in place of the one that is begun. @param {string} word */
  take(word) {
    this.field.value = `${this.field.value.replace(/\S*$/, "")}${word} `;
    this.field.focus();
    this.suggest();
  }

  /** @param {KeyboardEvent} event */
  press(event) {
    const { key } = event;
    const begun = this.field.value.trim() !== "";
    if (key === "Tab" && !event.shiftKey && begun && this.next.words.length) {
      event.preventDefault();
      this.take(this.next.words[0]);
    } else if (key === "ArrowUp" || key === "ArrowDown") {
      event.preventDefault();
      this.place += key === "ArrowUp" ? -1 : 1;
      this.place = Math.min(Math.max(this.place, 0), this.given.length);
      this.field.value = this.given[this.place] ?? "";
      this.suggest();
    } else if (key === "Escape") this.field.blur();
  }

  async give() {
    const words = this.field.value.trim();
    if (!words) return;
    this.given.push(words);
    if (this.given.length > KEPT) this.given.shift();
    this.place = this.given.length;
    this.field.value = "";
    this.suggest();
    const answer = await this.desk.give(words);
    if (answer.ok || this.field.value) return; // what is typed meanwhile stays
    this.field.value = words;
    if (document.activeElement === this.field) this.field.select();
  }
}

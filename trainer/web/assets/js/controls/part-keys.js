// Keys that choose which part of a page is shown where there is no room for all.
import { html } from "../draw.js";
import { say } from "../words.js";

/** `<part-keys part="group">` with `.parts = [[name, words]...]`: sets `data-group` of the body. Sections of another group are `data-away`. */
class PartKeys extends HTMLElement {
  /** @param {[string, string][]} parts */
  set parts(parts) {
    this.setAttribute("role", "group");
    this.setAttribute("aria-label", this.getAttribute("label") ?? say("Shown"));
    const key = ([name, words] = ["", ""]) =>
      html("button", { type: "button", "data-name": name, click: () => this.choose(name) }, words);
    this.replaceChildren(...parts.map(key));
    const { [this.#part]: chosen = "" } = document.body.dataset;
    const there = [...this.querySelectorAll("button")].find((each) => each.checkVisibility());
    const first = there?.dataset.name ?? parts[0]?.[0] ?? "";
    this.choose(parts.some(([name]) => name === chosen) ? chosen : first);
  }

  get #part() {
    return this.getAttribute("part") ?? "part";
  }

  /** Shows a part. @param {string} name */
  choose(name) {
    const part = this.#part;
    document.body.dataset[part] = name;
    for (const each of /** @type {NodeListOf<HTMLElement>} */ (document.querySelectorAll(`section[data-${part}]`))) {
      each.toggleAttribute("data-away", each.dataset[part] !== name);
    }
    for (const key of this.querySelectorAll("button")) {
      key.setAttribute("aria-pressed", String(key.dataset.name === name));
    }
  }
}

customElements.define("part-keys", PartKeys);

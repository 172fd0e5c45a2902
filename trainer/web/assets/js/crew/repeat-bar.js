// The order to the crew that this station is to repeat, with the key that repeats it.
import { html, write } from "../draw.js";
import { say } from "../words.js";

/** @typedef {import("../model/session.js").Session} Session */

/**
 * `<repeat-bar data-control>` with `bind(session)`: hidden while nothing is to be repeated. What a
 * screen reader says stands before it, where it is never hidden.
 */
class RepeatBar extends HTMLElement {
  #says = html("b", { class: "ordered" });
  #wrong = html("span", { class: "wrong" });
  #key = html("button", { type: "button" });
  #aloud = html("span", { class: "unseen", role: "status" });

  connectedCallback() {
    if (this.firstChild) return;
    this.hidden = true;
    this.append(html("span", { title: say("An order to the crew that nobody has repeated yet") }, say("NEW ORDER")), this.#says, this.#wrong, this.#key);
    this.before(this.#aloud);
  }

  /** @param {Session} session */
  bind(session) {
    this.#key.onclick = () => {
      const order = session.crew.toRepeat(session.role);
      if (order) void session.order(order.axis === "tell" ? "aye" : `${order.says} aye`);
    };
    session.on("crew", () => this.#show(session));
    session.on("state", () => this.#show(session));
    this.#show(session);
  }

  /** @param {Session} session */
  #show(session) {
    const order = session.crew.toRepeat(session.role);
    this.hidden = !order;
    write(this.#says, order?.says ?? "");
    const wrong = session.crew.wrong ? say("WRONG REPEAT: {0}", session.crew.wrong) : "";
    write(this.#wrong, wrong);
    write(this.#aloud, order ? say("New order: {0}. {1}", order.says, wrong) : "");
    write(this.#key, order ? say("Repeat: {0} aye", order.says) : say("Repeat"));
  }
}

customElements.define("repeat-bar", RepeatBar);

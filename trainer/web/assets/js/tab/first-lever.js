// A boat in a file begins with one lever, and one key leads to all instruments.
import "../controls/order-lever.js";
import { html, one, sidedOrder, tenths, write } from "../draw.js";
import { Readings } from "../model/readings.js";
import { lengthOf } from "../units.js";
import { say } from "../words.js";

/**
 * @typedef {import("../protocol/line.js").Sentence} Sentence
 * @typedef {{ limit: number, before: string }} First the lever's limit [deg], and an order before its first
 */

const ROUND = 10; // [m] to which a depth is rounded that the autopilot is to keep

export class FirstLever {
  /** @param {import("./link.js").Link} link @param {First} first */
  constructor(link, { limit, before }) {
    this.link = link;
    this.readings = new Readings();
    this.before = before;
    this.inHand = false; // the planes are the hand's, not the autopilot's
    const words = { low: say("dive"), high: say("rise"), limit, face: "right" };
    const name = say("Stern planes");
    this.lever = /** @type {any} */ (
      html(
        "order-lever",
        { ...words, name: "stern", label: name, order: (event) => void this.steer(event) },
        html("angle-dial", { ...words, "aria-label": name }),
      )
    );
    this.depth = html("b");
    this.pitch = html("b");
    this.said = html("p", { class: "quiet", role: "status" });
    this.section = html(
      "section",
      { id: "first-lever", class: "panel", "aria-labelledby": "first-title" },
      html("h2", { id: "first-title", class: "big" }, say("The boat is yours")),
      html("p", {}, say("Push the lever down: the stern planes turn, the bow goes down, the boat dives.")),
      html("p", { class: "readouts" }, html("span", {}, say("Depth"), " ", this.depth), html("span", {}, say("Pitch"), " ", this.pitch)),
      this.lever,
      this.said,
      html(
        "p",
        { class: "row keys" },
        html("button", { type: "button", click: () => void this.level() }, say("Level off")),
        html("button", { type: "button", class: "main", click: () => this.close() }, say("All instruments")),
      ),
    );
    document.body.dataset.begins = "";
    one("#columns").append(this.section);
    this.listening = new AbortController();
    const { signal } = this.listening;
    link.addEventListener("sentence", (event) => this.hear(/** @type {CustomEvent<Sentence>} */ (event).detail), { signal });
  }

  /** Shows what the instruments say. @param {Sentence} sentence */
  hear(sentence) {
    const { readings } = this;
    if (sentence.kind !== "TRN" && sentence.kind !== "TRS") return;
    const channel = readings.take(sentence)?.channel;
    if (channel === "gauges") {
      write(this.depth, lengthOf(readings.number("gauges.depth") ?? 0));
      const pitch = readings.number("gauges.pitch") ?? 0;
      write(this.pitch, sidedOrder(pitch, say("down"), say("up")));
    }
    if (channel !== "diving") return;
    const at = readings.number("diving.stern");
    this.lever.show(readings.number("diving.ordered_stern"), readings.word("diving.stern_mode"), false, at);
    this.lever.querySelector("angle-dial").show(at);
  }

  /** Orders what the lever says, in the words that a crew would use. @param {Event} event */
  async steer(event) {
    const angle = /** @type {CustomEvent<number>} */ (event).detail;
    if (this.before && !this.inHand) await this.give(this.before);
    this.inHand = true;
    await this.give(angle ? `stern ${angle < 0 ? "dive" : "rise"} ${tenths(Math.abs(angle))}` : "stern zero");
  }

  /** Has the autopilot keep the depth, to the nearest ten metres. */
  async level() {
    this.lever.leave();
    this.inHand = false;
    const depth = this.readings.number("gauges.depth") ?? 0;
    await this.give(`depth ${Math.max(ROUND, Math.round(depth / ROUND) * ROUND)} m`);
  }

  /** Gives an order, and says it with its answer. @param {string} words */
  async give(words) {
    const { ok, text } = await this.link.order(words);
    write(this.said, ok ? say("The order: {0}", words) : text);
  }

  /** Leaves the lever for the whole desk; what was ordered stands. */
  close() {
    this.listening.abort();
    delete document.body.dataset.begins;
    this.section.remove();
    one("#freeze").focus();
  }
}

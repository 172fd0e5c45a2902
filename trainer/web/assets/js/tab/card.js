// The card with which a mailed run begins: what breaks, what is to be kept, one key; and its result.
import { clock, html, tenths, write } from "../draw.js";
import { lengthOf, shortLength } from "../units.js";
import { say } from "../words.js";
import { MOMENT } from "./task.js";

const degrees = (/** @type {number} */ value) => say("{0} degrees", tenths(value));
const knots = (/** @type {number} */ value) => `${tenths(value)} kn`;
/**
 * What is to be kept by each limit, what its worst value is called, and how a value is written.
 * @type {Record<string, { keep: (limit: number) => string, worst: string, says: (value: number) => string }>}
 */
const LIMITS = {
  depth_m_max: { keep: (limit) => say("the boat above {0}", shortLength(limit)), worst: say("Deepest"), says: lengthOf },
  depth_m_min: { keep: (limit) => say("the boat below {0}", shortLength(limit)), worst: say("Shallowest"), says: lengthOf },
  pitch_deg_max: { keep: (limit) => say("its pitch within {0}", degrees(limit)), worst: say("Steepest"), says: degrees },
  heel_deg_max: { keep: (limit) => say("its heel within {0}", degrees(limit)), worst: say("Most heel"), says: degrees },
  speed_kn_max: { keep: (limit) => say("its speed below {0}", knots(limit)), worst: say("Fastest"), says: knots },
  speed_kn_min: { keep: (limit) => say("its speed above {0}", knots(limit)), worst: say("Slowest"), says: knots },
};

/** Sides of an amount, as it is told. @type {Record<string, string>} */
const SIDES = { dive: say("dive"), rise: say("rise"), left: say("left"), right: say("right"), deg: say("deg") };

/** Returns what breaks in words. @param {string} cause its clause, and after a bar how much: `6 deg dive` */
function clauseOf(cause) {
  const [words, amount = ""] = cause.split("|");
  return say(words, amount.split(" ").map((part) => SIDES[part] ?? part).join(" "));
}

export class Card {
  /** @param {import("./link.js").Link} link */
  constructor(link) {
    this.link = link;
    this.title = html("h2", { id: "task-title", class: "big" });
    this.body = html("div", { class: "says" });
    this.keys = html("p", { class: "row keys" });
    this.dialog = /** @type {HTMLDialogElement} */ (
      html("dialog", { id: "task", "aria-labelledby": "task-title" }, this.title, this.body, this.keys)
    );
    document.body.append(this.dialog);
  }

  /** Begins with what the run is sent for. @param {string} told its times [s], limits, and what broke */
  offer(told) {
    const [from, until, limits, ...rest] = told.split(",");
    const cause = rest.join(",");
    const keep = limits.split(" ").filter(Boolean).map((limit) => {
      const [name, value] = limit.split(":");
      return LIMITS[name].keep(Number(value));
    });
    const [at, end] = [from, until].map((seconds) => clock(Number(seconds)));
    this.at = at;
    this.task = keep.length ? say("Keep {0}.", keep.join(say(" and "))) : say("See whether you do better.");
    this.note = `${this.task} ${say("The result comes at {0}.", end)}`;
    write(this.title, cause ? say("At {0} {1}.", at, clauseOf(cause)) : say("At {0} the boat is yours.", at));
    this.show(
      [html("p", { class: "big" }, this.task), html("p", {}, say("It has been flown once. Fly it yourself: the result comes at {0}, two minutes on.", end))],
      [this.key(say("Take over at {0}", at), () => void this.fly(), true), ...this.shows(), this.key(say("Look round first"), () => this.dialog.close())],
    );
  }

  /** Goes where it broke, and lets time run. */
  async fly() {
    this.dialog.close();
    const there = await this.link.order(`restore ${MOMENT}`);
    if (there.ok) await this.link.order("run");
    const note = document.getElementById("tab-note");
    if (note) write(note, this.note ?? "");
  }

  /** Shows how a try went. @param {string} told rows of a limit's name, itself, the worst, the recorded one, whether it was kept */
  tell(told) {
    const rows = told.split(" ").filter(Boolean).map((row) => row.split(","));
    const broken = rows.some((row) => row[4] === "passed");
    write(this.title, rows.length ? (broken ? say("A limit was passed") : say("Within the limits")) : say("Two minutes are over"));
    const heads = ["", say("limit"), say("you"), say("as recorded")].map((head) => html("th", { scope: "col" }, head));
    const lines = rows.map(([name, limit, worst, recorded, kept]) => {
      const { worst: words, says } = LIMITS[name];
      const [bound, yours, before] = [limit, worst, recorded].map((value) => says(Number(value)));
      const cells = [bound, html("b", {}, yours), before].map((cell) => html("td", {}, cell));
      return html("tr", { "data-kept": kept }, html("th", { scope: "row" }, words), ...cells);
    });
    const table = html("table", {}, html("thead", {}, html("tr", {}, ...heads)), html("tbody", {}, ...lines));
    this.show(
      [html("p", {}, this.task ?? ""), ...(rows.length ? [table] : [])],
      [this.key(say("Again from {0}", this.at ?? ""), () => void this.fly(), true), ...this.shows(), this.key(say("Go on from here"), () => void this.goOn())],
    );
  }

  /** Returns the key that has the reference crew show the way, where one came with the page. */
  shows() {
    return this.link.hasWay ? [this.key(say("Show the way"), () => void this.demonstrate())] : [];
  }

  /** Has the way shown from where it broke; the try comes afterwards. */
  async demonstrate() {
    this.dialog.close();
    await this.link.order(`restore ${MOMENT}`);
    await this.link.order("demonstrate");
  }

  async goOn() {
    this.dialog.close();
    await this.link.order("run");
  }

  /** @param {Node[]} body @param {HTMLElement[]} keys */
  show(body, keys) {
    this.body.replaceChildren(...body);
    this.keys.replaceChildren(...keys);
    if (!this.dialog.open) this.dialog.showModal();
    keys[0].focus();
  }

  /** @param {string} words @param {() => void} click @param {boolean} [main] */
  key(words, click, main = false) {
    return html("button", { type: "button", class: main ? "main" : "", click }, words);
  }
}

// Orders to the crew: given by keypad, key and word; what stands, and what the crew has said.
import { ask } from "../controls/question.js";
import { bearing, html, one, write } from "../draw.js";
import { depthOrder, pitchOrder } from "../frame.js";
import { entryLine } from "./log-lines.js";
import { say } from "../words.js";

/**
 * @typedef {import("../model/session.js").Session} Session
 * @typedef {(words: string) => Promise<boolean>} Give
 */

const FOOT = 0.3048; // [m]
const STEEPEST = 30; // [deg] of bubble
const SAID = 20; // entries of the log: as many as have room
/** How a key of the keypad is ordered. @type {Record<string, (number: number) => string>} */
const KEYS = {
  "depth, m": (number) => `order depth ${number} m`,
  "depth, ft": (number) => `order depth ${number} ft`,
  "bubble down": (number) => `order pitch ${number} down`,
  "bubble up": (number) => `order pitch ${number} up`,
  "course left": (number) => `order course left ${bearing(number)}`,
  "course right": (number) => `order course right ${bearing(number)}`,
  course: (number) => `order course ${bearing(number)}`,
  "speed, kn": (number) => `order speed ${number}`,
};

/** Furnishes what gives orders to the crew. @param {Session} session @param {Give} give */
export function furnishOrders(session, give) {
  const pad = /** @type {any} */ (one("order-keypad"));
  const fit = () => {
    const { depth = 2000, speed = 60, periscope } = session.ranges;
    const keys = [
      ["depth, m", say("depth, m"), 1, depth],
      ["bubble down", say("pitch down"), 1, STEEPEST],
      ["depth, ft", say("depth, ft"), 1, Math.floor(depth / FOOT)],
      ["bubble up", say("pitch up"), 1, STEEPEST],
      ["course left", say("course left"), 0, 360],
      ["course right", say("course right"), 0, 360],
      ["course", say("course"), 0, 360],
      ["speed, kn", say("speed, kn"), 0, Math.floor(speed)],
    ];
    // the officer of the deck orders no bubble
    pad.keys = keys.filter(([key]) => session.role !== "deck" || !String(key).startsWith("bubble"));
    one("[data-range=periscope]").toggleAttribute("hidden", periscope === undefined);
  };
  session.on("ranges", fit);
  fit();
  pad.addEventListener("order", (/** @type {CustomEvent} */ event) =>
    give(KEYS[event.detail.key](event.detail.number)),
  );
  furnishWords(give);
  for (const key of document.querySelectorAll("[data-ask]")) {
    key.addEventListener("click", () => void askFirst(/** @type {HTMLElement} */ (key), give));
  }
}

/** Takes orders as they are typed. @param {Give} give */
function furnishWords(give) {
  const form = /** @type {HTMLFormElement} */ (one("#typed-order"));
  form.onsubmit = async (event) => {
    event.preventDefault();
    const field = /** @type {HTMLInputElement} */ (one("input", form));
    if (await give(field.value.trim())) field.value = "";
  };
}

/** Asks before an order that acts at once. @param {HTMLElement} key @param {Give} give */
async function askFirst(key, give) {
  const { ask: words = "", says = "" } = key.dataset;
  const title = key.textContent ?? "";
  if (await ask(`${title}?`, says, title)) await give(words);
}

/** Shows what stands, and what the crew says. @param {Session} session @param {Give} give */
export function showStanding(session, give) {
  const orders = standing(session);
  const said = session.log.filter(({ kind }) => kind === "crew").slice(-SAID);
  const depth = session.number("orders.depth");
  write(one("#ordered-depth"), depth === null ? "" : say("ordered {0}", depthOrder(session, depth)));
  const now = JSON.stringify([orders, said]);
  const list = one("#standing");
  if (list.dataset.shown === now) return;
  list.dataset.shown = now;
  list.replaceChildren(...orders.map((order) => line(order, give)));
  if (!orders.length) list.append(html("li", { class: "quiet" }, say("none stands")));
  one("#said").replaceChildren(...said.map(entryLine));
}

/**
 * Returns the orders that stand: axis, words, and whether they are repeated.
 * @param {Session} session
 * @returns {[string, string, string][]}
 */
function standing(session) {
  const shown = /** @type {[string, (value: number) => string][]} */ ([
    ["course", (value) => say("course {0}", bearing(value))],
    ["depth", (value) => say("depth {0}", depthOrder(session, value))],
    ["speed", (value) => say("speed {0} kn", value)],
    ["pitch", (value) => pitchOrder(value)],
  ]);
  /** @type {[string, string, string][]} */
  const found = shown.flatMap(([axis, words]) => {
    const value = session.number(`orders.${axis}`);
    return value === null ? [] : [[axis, words(value), state(session, axis)]];
  });
  const told = session.word("orders.told");
  if (told) found.push(["words", told, state(session, "tell")]);
  const right = (/** @type {[string, string, string]} */ [, , how]) => Number(how !== say("WRONG REPEAT"));
  return found.sort((a, b) => right(a) - right(b)); // of a long list the end is not seen
}

/** @param {Session} session @param {string} axis */
function state(session, axis) {
  const waiting = session.crew.waiting.get(axis);
  if (!waiting) return say("repeated");
  return session.crew.wrong.endsWith(waiting.says) ? say("WRONG REPEAT") : say("not repeated yet");
}

/** @param {[string, string, string]} order @param {Give} give */
function line([axis, words, how], give) {
  const belay = () => void give(`belay ${axis}`);
  const attributes = { type: "button", "aria-label": say("Belay: {0}", words), click: belay };
  return html(
    "li",
    { class: "row" },
    html("b", { class: "ordered grow" }, words),
    html("span", { "data-wrong": how === say("WRONG REPEAT"), class: "quiet" }, how),
    html("button", attributes, say("Belay")),
  );
}

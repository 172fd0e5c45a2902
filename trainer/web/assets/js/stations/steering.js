// Helm, planes and pilot: one page, of which a role has its part.
import "../controls/order-lever.js";
import "../controls/order-telegraph.js";
import "../controls/part-keys.js";
import "../crew/repeat-bar.js";
import "../crew/report-bar.js";
import "../gauges/level-bar.js";
import { Alerts, surfaceWatch } from "../model/alerts.js";
import { Link } from "../protocol/link.js";
import { Pending } from "../model/pending.js";
import { Session } from "../model/session.js";
import { bearing, html, one, write } from "../draw.js";
import { furnish, isTyping, orderedLine } from "../frame.js";
import { furnishPlant } from "../plant/window.js";
import { furnishSafeDepth } from "../safe/safe-depth.js";
import { gamepad } from "../controls/gamepad.js";
import { giver, seldom, showReadouts } from "./readouts.js";
import { showInstruments } from "./instruments.js";
import { decimals, say } from "../words.js";

/** @type {Record<string, string[]>} */
const CHANNELS = {
  helm: ["gauges", "orders", "steering", "engine", "supply", "time"],
  planes: ["gauges", "orders", "diving", "supply", "safe", "time"],
  pilot: ["gauges", "orders", "steering", "engine", "diving", "supply", "safe", "time"],
  trainee: [
    ...["gauges", "orders", "steering", "engine", "diving", "tanks", "air", "valves"],
    ...["supply", "plant", "safe", "time"],
  ],
};
/** @type {Record<string, string>} the channel of each surface */
const SURFACES = { rudder: "steering", stern: "diving", bow: "diving" };
const OFF_ORDER = {
  rudder: say("Rudder off its order"),
  stern: say("Stern planes off their order"),
  bow: say("Bow planes off their order"),
};
/** @type {Record<string, [string, string]>} in the words of an order */
const SIDES = { rudder: ["left", "right"], stern: ["dive", "rise"], bow: ["dive", "rise"] };
const ANSWERED = 0.05; // of the bell's turns

const { role = "helm" } = document.body.dataset;
export const session = new Session(new Link(document.documentElement.dataset.version ?? ""), role, CHANNELS[role]);
const watches = Object.entries(OFF_ORDER).map(([name, title]) =>
  surfaceWatch(title, `${SURFACES[name]}.${name}`, `${SURFACES[name]}.ordered_${name}`),
);
const sound = furnish(session, new Alerts(session, watches));

/** @type {any[]} */
const levers = [...document.querySelectorAll("order-lever")];
/** @type {any} */
const telegraph = document.querySelector("order-telegraph");
/** @type {any[]} */
const bars = [...document.querySelectorAll("repeat-bar, report-bar")];
for (const bar of bars) bar.bind(session);

export const give = giver(session);
if (role !== "trainee") furnishPlant(session, give);
if (CHANNELS[role].includes("safe")) furnishSafeDepth(session);
/** What is ordered here, by the channel that will show it. @type {Record<string, Pending>} */
const pending = Object.fromEntries(
  ["steering", "diving", "engine"].map((channel) => [channel, new Pending(session, channel)]),
);

for (const lever of levers) {
  const name = lever.getAttribute("name");
  const given = pending[SURFACES[name]];
  lever.addEventListener("order", async (/** @type {CustomEvent<number>} */ { detail }) => {
    const [low, high] = SIDES[name];
    const zero = name === "rudder" ? "rudder amidships" : `${name} zero`;
    const words = detail === 0 ? zero : `${name} ${detail < 0 ? low : high} ${Math.abs(detail)}`;
    given.give(name, detail);
    given.answered(name, await give(words));
  });
}
telegraph?.addEventListener("order", async (/** @type {CustomEvent<string>} */ { detail }) => {
  sound.bell();
  pending.engine.give("bell", detail);
  pending.engine.answered("bell", await give(`bell ${detail}`));
  telegraph.show(...bell());
});
/** Gives levers away by an order, which none of them may follow with its own. @param {string[]} names @param {string} words */
function giveAway(names, words) {
  for (const lever of levers) if (names.includes(lever.getAttribute("name"))) lever.leave();
  void give(words);
}
for (const key of document.querySelectorAll("[data-auto]")) {
  const name = /** @type {HTMLElement} */ (key).dataset.auto ?? "";
  key.addEventListener("click", () => giveAway([name], `${name} auto`));
}

/**
 * What the autopilot can be given of what the crew is ordered: the role that may, the axis by hand,
 * what is ordered, what is kept, and the order.
 * @type {[string, string, string, string, (value: number) => string][]}
 */
const KEPT = [
  ["steering", "rudder", "orders.course", "steering.ordered_course", (to) => `course ${bearing(to)}`],
  ["diving", "planes", "orders.depth", "diving.ordered_depth", (to) => `depth ${to} m`],
  ["engine", "speed", "orders.speed", "engine.ordered_speed", (to) => `speed ${to} kn`],
];

/** Shows a key for each order to the crew that the autopilot may keep, and does not. */
function showAutopilot() {
  const hand = (session.exercise.hand ?? "").split(",");
  const wanted = KEPT.filter(([channel, axis]) => CHANNELS[role].includes(channel) && !hand.includes(axis))
    .map(([channel, , ordered, kept, wording]) => ({
      names: Object.keys(SURFACES).filter((name) => SURFACES[name] === channel),
      to: session.number(ordered),
      stands: session.number(kept),
      wording,
    }))
    .filter(({ to, stands }) => to !== null && to !== stands)
    .map(({ names, to, wording }) => ({ names, words: wording(Number(to)) }));
  const bar = one("#autopilot");
  const shown = wanted.map(({ words }) => words).join();
  if (bar.dataset.shown === shown) return;
  bar.dataset.shown = shown;
  const keys = wanted.map(({ names, words }) =>
    html("button", { type: "button", click: () => giveAway(names, words) }, say("Autopilot: {0}", words)),
  );
  bar.replaceChildren(...keys);
}

/** @type {any} the halves of a pilot's page, where there is no room for both */
const halves = document.querySelector("part-keys");
if (halves) {
  halves.parts = [
    ["steer", say("Steer")],
    ["dive", say("Dive")],
  ];
}

/** @type {Record<string, [string, number]>} arrow keys steer from anywhere on the page */
const ARROWS = {
  ArrowLeft: ["rudder", -1],
  ArrowRight: ["rudder", 1],
  ArrowUp: ["stern", 1],
  ArrowDown: ["stern", -1],
};
/** Moves a lever by a key. Who trains works the whole boat, whichever part is shown. @param {string} name @param {number} by */
export function nudge(name, by) {
  const lever = levers.find((each) => each.getAttribute("name") === name);
  if (!lever || (role !== "trainee" && !lever.checkVisibility())) return false;
  if (!lever.idle) lever.choose(lever.value + by);
  return true;
}
addEventListener("keydown", (event) => {
  if (isTyping(event) || !(event.key in ARROWS)) return;
  const [name, by] = ARROWS[event.key];
  if (nudge(name, by * (event.shiftKey ? 5 : 1))) event.preventDefault();
});
gamepad((name, value) => {
  const lever = levers.find((each) => each.getAttribute("name") === name);
  if (lever && !lever.idle) lever.choose(value * lever.limit);
});

session.on("ranges", () => {
  const { speed, astern } = session.ranges;
  for (const name of Object.keys(SURFACES)) {
    const lever = document.querySelector(`order-lever[name="${name}"]`);
    const panel = lever?.closest("section");
    if (panel instanceof HTMLElement) panel.hidden = !(name in session.ranges);
    if (lever && name in session.ranges) Object.assign(lever, { limit: session.ranges[name] });
  }
  if (telegraph) telegraph.stops = session.bells;
  const step = (speed ?? 20) > 10 ? 10 : 2;
  const [low, high] = [-(astern ?? 5), speed ?? 20].map((end) => step * grown(end / step));
  /** @type {any} */ (document.querySelector("#speed"))?.range(low, high, step);
});

/** Returns the next whole number away from zero. @param {number} value */
function grown(value) {
  return Math.sign(value) * Math.ceil(Math.abs(value));
}

/** Shows what is in hand and what is automatic, and what may be. */
function showModes() {
  const hand = (session.exercise.hand ?? "").split(",");
  for (const [name, channel] of Object.entries(SURFACES)) {
    const mode = session.word(`${channel}.${name}_mode`);
    const words = document.querySelector(`[data-mode="${name}"]`);
    if (words) write(words, mode === "hand" ? say("by hand") : mode ? say("automatic: move it to take") : "");
    const key = document.querySelector(`[data-auto="${name}"]`);
    const axis = name === "rudder" ? "rudder" : "planes";
    const fixed = hand.includes(axis) || hand.includes(name);
    if (key instanceof HTMLElement) key.hidden = mode !== "hand" || fixed;
  }
}

/** Returns which bell stands, and whether the engine does it. @returns {[string, boolean]} */
function bell() {
  const told = session.word("engine.bell").replace("-", " "); // as it is ordered
  const [rpm, ordered] = [session.number("engine.rpm"), session.number("engine.ordered_rpm")];
  const off = rpm === null || ordered === null ? Infinity : Math.abs(rpm - ordered);
  const wanted = pending.engine.resolve("bell", told);
  return [wanted, wanted === told && off <= Math.max(ANSWERED * Math.abs(ordered ?? 0), 1)];
}

/** Returns a rate of turn in words. @param {number} rate [deg/s] */
function swings(rate) {
  const size = decimals(Math.abs(rate), 1);
  return rate < 0 ? say("swing {0} deg/s left", size) : say("swing {0} deg/s right", size);
}

const showWords = seldom(() => showReadouts(session));
session.on("tick", () => {
  write(one("#ordered"), orderedLine(session) && say("Ordered: {0}", orderedLine(session)));
  showModes();
  showAutopilot();
  showWords();
  telegraph?.show(...bell());
  const rate = session.number("steering.turn_rate");
  const swing = document.querySelector("#swing");
  if (swing) write(swing, rate ? swings(rate) : "");
});

const motion = showInstruments(session, (place, stands) => {
  const [channel, field] = place.split(".");
  return pending[channel]?.resolve(field.replace("ordered_", ""), stands) ?? stands;
});
motion.addEventListener("frame", () => {
  for (const lever of levers) {
    const name = lever.getAttribute("name");
    const channel = SURFACES[name];
    const ordered = pending[channel].resolve(name, session.number(`${channel}.ordered_${name}`));
    const mode = session.word(`${channel}.${name}_mode`);
    lever.show(ordered, mode, pending[channel].waits(name), motion.shown[`#${name}`] ?? null);
  }
});
session.start();

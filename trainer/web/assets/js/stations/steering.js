// Helm, planes and pilot: one page, of which a role has its part.
import "../controls/order-lever.js";
import "../controls/order-telegraph.js";
import "../crew/repeat-bar.js";
import "../crew/report-bar.js";
import "../gauges/angle-dial.js";
import "../gauges/course-ring.js";
import "../gauges/depth-gauge.js";
import "../gauges/level-bar.js";
import "../gauges/pitch-gauge.js";
import { Alerts, surfaceWatch } from "../model/alerts.js";
import { Link } from "../protocol/link.js";
import { Motion } from "../model/motion.js";
import { Pending } from "../model/pending.js";
import { Session } from "../model/session.js";
import { bearing, html, one, write } from "../draw.js";
import { furnish, isTyping, orderedLine } from "../frame.js";
import { gamepad } from "../controls/gamepad.js";
import { giver } from "./readouts.js";

/** @type {Record<string, string[]>} */
const CHANNELS = {
  helm: ["gauges", "orders", "steering", "engine", "time"],
  planes: ["gauges", "orders", "diving", "time"],
  pilot: ["gauges", "orders", "steering", "engine", "diving", "time"],
};
/** @type {Record<string, string>} the channel of each surface */
const SURFACES = { rudder: "steering", stern: "diving", bow: "diving" };
const OFF_ORDER = {
  rudder: "Rudder off its order",
  stern: "Stern planes off their order",
  bow: "Bow planes off their order",
};
const POINTERS = {
  depth: { place: "gauges.depth", most: 6 },
  heading: { place: "gauges.heading", most: 7.1, turns: true },
  pitch: { place: "gauges.pitch", most: 7.1 },
  heel: { place: "gauges.heel", most: 7.1 },
  speed: { place: "gauges.speed", most: 1 },
  rpm: { place: "engine.rpm", most: 20 },
  rudder: { place: "steering.rudder", most: 7.1 },
  stern: { place: "diving.stern", most: 7.1 },
  bow: { place: "diving.bow", most: 7.1 },
};
const ANSWERED = 0.05; // of the bell's turns

const { role = "helm" } = document.body.dataset;
const session = new Session(new Link(document.documentElement.dataset.version ?? ""), role, CHANNELS[role]);
const watches = Object.entries(OFF_ORDER).map(([name, title]) =>
  surfaceWatch(title, `${SURFACES[name]}.${name}`, `${SURFACES[name]}.ordered_${name}`),
);
const sound = furnish(session, new Alerts(session, watches));
const motion = new Motion(session, POINTERS);

/** @type {any[]} */
const levers = [...document.querySelectorAll("order-lever")];
/** @type {any} */
const telegraph = document.querySelector("order-telegraph");
/** @type {any[]} */
const bars = [...document.querySelectorAll("repeat-bar, report-bar")];
for (const bar of bars) bar.bind(session);

const give = giver(session);
/** What is ordered here, by the channel that will show it. @type {Record<string, Pending>} */
const pending = Object.fromEntries(
  ["steering", "diving", "engine"].map((channel) => [channel, new Pending(session, channel)]),
);

for (const lever of levers) {
  const name = lever.getAttribute("name");
  const given = pending[SURFACES[name]];
  lever.addEventListener("order", async (/** @type {CustomEvent<number>} */ { detail }) => {
    const [low, high] = lever.ends;
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
for (const key of document.querySelectorAll("[data-auto]")) {
  const name = /** @type {HTMLElement} */ (key).dataset.auto ?? "";
  key.addEventListener("click", () => void give(`${name} auto`));
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
    .map(([, , ordered, kept, say]) => [session.number(ordered), session.number(kept), say])
    .filter(([to, at]) => to !== null && to !== at)
    .map(([to, , say]) => /** @type {(to: number) => string} */ (say)(Number(to)));
  const bar = one("#autopilot");
  if (bar.dataset.shown === wanted.join()) return;
  bar.dataset.shown = wanted.join();
  const keys = wanted.map((words) =>
    html("button", { type: "button", click: () => void give(words) }, `Autopilot: ${words}`),
  );
  bar.replaceChildren(...keys);
}

/** @param {string} half */
function choose(half) {
  document.body.dataset.half = half;
  for (const key of document.querySelectorAll("[data-half]:not(body)")) {
    key.setAttribute("aria-pressed", String(/** @type {HTMLElement} */ (key).dataset.half === half));
  }
}
for (const key of document.querySelectorAll(".halves button")) {
  key.addEventListener("click", () => choose(/** @type {HTMLElement} */ (key).dataset.half ?? ""));
}
choose("steer");

/** @type {Record<string, [string, number]>} arrow keys steer from anywhere on the page */
const ARROWS = {
  ArrowLeft: ["rudder", -1],
  ArrowRight: ["rudder", 1],
  ArrowUp: ["stern", 1],
  ArrowDown: ["stern", -1],
};
/** @param {string} name @param {number} by */
function nudge(name, by) {
  const lever = levers.find((each) => each.getAttribute("name") === name);
  if (!lever?.checkVisibility()) return false;
  if (!lever.inert) lever.choose(lever.value + by);
  return true;
}
addEventListener("keydown", (event) => {
  if (isTyping(event) || !(event.key in ARROWS)) return;
  const [name, by] = ARROWS[event.key];
  if (nudge(name, by * (event.shiftKey ? 5 : 1))) event.preventDefault();
});
gamepad((name, value) => {
  const lever = levers.find((each) => each.getAttribute("name") === name);
  if (lever && !lever.inert) lever.choose(value * lever.limit);
});

session.on("ranges", () => {
  const { depth, periscope, speed, astern } = session.ranges;
  /** @type {any} */ (one("depth-gauge")).limit(depth ?? null, periscope ?? null);
  for (const name of Object.keys(SURFACES)) {
    const [dial, lever] = [`#${name}`, `order-lever[name="${name}"]`].map((each) =>
      document.querySelector(each),
    );
    const panel = dial?.closest("section");
    if (panel instanceof HTMLElement) panel.hidden = !(name in session.ranges);
    if (name in session.ranges) Object.assign(dial ?? {}, { limit: session.ranges[name] });
    if (name in session.ranges) Object.assign(lever ?? {}, { limit: session.ranges[name] });
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
    if (words) write(words, mode === "hand" ? "by hand" : mode ? "automatic: touch to take" : "");
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

session.on("tick", () => {
  write(one("#ordered"), orderedLine(session) && `Ordered: ${orderedLine(session)}`);
  showModes();
  showAutopilot();
  telegraph?.show(...bell());
  const rate = session.number("steering.turn_rate");
  const swing = document.querySelector("#swing");
  if (swing) write(swing, rate ? `swing ${Math.abs(rate).toFixed(1)} deg/s ${rate < 0 ? "left" : "right"}` : "");
  const speed = document.querySelector("#speed-digits");
  if (speed) write(speed, (session.number("gauges.speed") ?? 0).toFixed(1));
  const heading = document.querySelector("#heading-digits");
  if (heading) write(heading, bearing(session.number("gauges.heading") ?? 0));
});

/** Shows values on an instrument, where the page has it. @param {string} where @param {unknown[]} values */
function show(where, ...values) {
  /** @type {any} */ (document.querySelector(where))?.show(...values);
}
motion.addEventListener("frame", () => {
  const { shown } = motion;
  const at = (/** @type {string} */ place) => session.number(place);
  show("course-ring", shown.heading, at("orders.course") ?? at("steering.ordered_course"), at("steering.turn_rate"));
  show("depth-gauge", shown.depth, at("orders.depth") ?? at("diving.ordered_depth"));
  show("pitch-gauge", shown.pitch, at("orders.pitch"));
  show("#heel", shown.heel, null);
  show("#speed", shown.speed, at("orders.speed") ?? at("engine.ordered_speed"));
  show("#rpm", shown.rpm, at("engine.ordered_rpm"));
  for (const [name, channel] of Object.entries(SURFACES)) {
    const ordered = pending[channel].resolve(name, at(`${channel}.ordered_${name}`));
    const mode = session.word(`${channel}.${name}_mode`);
    show(`#${name}`, shown[name], ordered);
    show(`order-lever[name="${name}"]`, shown[name], ordered, mode, pending[channel].waits(name));
  }
});
motion.start();
session.start();

// Who trains alone: helm and planes as the pilot has them, tanks, charts, log, an order line; steps lead.
import "../charts/strip-chart.js";
import "../controls/emergency-cover.js";
import "../controls/position-switch.js";
import "../controls/pump-keys.js";
import "../tanks/balance-bar.js";
import "../tanks/tank-mimic.js";
import { drawPlots } from "../charts/plots.js";
import { furnishCourse } from "../crew/course-keys.js";
import { furnishSteps } from "../crew/step-panel.js";
import { isTyping } from "../frame.js";
import { furnishOrderLine } from "../instructor/order-line.js";
import { limitsOf } from "../model/limits.js";
import { plantRows } from "../plant/panel.js";
import { furnishPlant } from "../plant/window.js";
import { TankPanel } from "../tanks/panel.js";
import { one, write } from "../draw.js";
import { keepLog } from "../crew/log-lines.js";
import { give, nudge, session } from "./steering.js";
import { seldom } from "./readouts.js";
import { say } from "../words.js";

const SPAN = 300; // [s] of the charts
/** Where each chart's quantity is shown, and where its order stands. */
const PLOTTED = {
  depth: ["gauges.depth", "orders.depth", "diving.ordered_depth"],
  pitch: ["gauges.pitch", "orders.pitch"],
  speed: ["gauges.speed", "orders.speed", "engine.ordered_speed"],
  rudder: ["steering.rudder", "steering.ordered_rudder"],
};
/** Keys that give orders: those of the terminal's panel, because the lessons name them. @type {Record<string, string>} */
const KEYS = {
  m: "rudder amidships",
  z: "stern planes zero",
  x: "bow planes zero",
  0: "bell stop",
  1: "bell ahead one-third",
  2: "bell ahead two-thirds",
  3: "bell ahead standard",
  4: "bell ahead full",
  5: "bell ahead flank",
  6: "bell astern one-third",
  7: "bell astern two-thirds",
  8: "bell astern full",
};
/** Keys of the bow planes [deg]. @type {Record<string, number>} */
const BOW = { ",": -1, ".": 1, "<": -5, ">": 5 };
/** Which part an exercise begins with, by what is in hand. @type {[string, string][]} */
const HAND = [["rudder", "steer"], ["planes", "dive"], ["ballast", "tanks"]];
const OWN = "button, a, summary, textarea"; // what has keys of its own

/** @type {any[]} */
const [halves, sides] = [one("part-keys[part=half]"), one("part-keys[part=side]")];
/** @type {[string, string][]} */
const SIDES = [
  ["tanks", say("Tanks")],
  ["charts", say("Charts")],
  ["log", say("Log")],
];
halves.parts = [["steer", say("Steer")], ["dive", say("Dive")], ...SIDES];
sides.parts = SIDES;

halves.addEventListener("click", () => choose(document.body.dataset.half ?? ""));

/** Shows a part of the page, where there is room for one and where there is room for two. @param {string} part */
function choose(part) {
  halves.choose(part);
  if (SIDES.some(([name]) => name === part)) sides.choose(part);
}

let opened = ""; // the exercise for which a part is shown
const field = /** @type {HTMLInputElement} */ (one("#order"));
const tanks = new TankPanel(session, give);
furnishPlant(session, give, plantRows(session, give));
furnishSteps(session, (words) => void give(words), choose);
furnishCourse(session);
furnishOrderLine({
  session,
  give: async (words) => {
    const ok = await give(words);
    if (ok && !field.value) field.blur(); // keys work the boat again, unless the next order is begun
    return { ok };
  },
});

function stands() {
  return session.word("time.time") === "frozen";
}

function toggleTime() {
  void give(stands() ? "run" : "freeze");
}

/** Repeats the order to the crew that is new, or begins to type one. */
function repeat() {
  const key = /** @type {HTMLElement} */ (one("repeat-bar button"));
  if (session.crew.toRepeat(session.role)) key.click();
  else if (document.activeElement !== field) field.focus();
}

addEventListener("keydown", (event) => {
  const { key, target } = event;
  const [own, empty] = [/** @type {Element} */ (target).closest(OWN), target === field && !field.value];
  const letter = key.length === 1 && !event.ctrlKey && !event.altKey && !event.metaKey;
  if (key === "F2") toggleTime();
  else if (key === "Enter" && !own && (empty || !isTyping(event))) repeat();
  else if (isTyping(event) || document.querySelector("dialog:modal")) return;
  else if (letter && KEYS[key.toLowerCase()]) void give(KEYS[key.toLowerCase()]);
  else if (BOW[key]) nudge("bow", BOW[key]);
  else {
    if (letter && /^[a-z:]$/i.test(key)) field.focus(); // an order is begun
    if (key !== ":") return;
  }
  event.preventDefault();
});

one("#freeze").onclick = toggleTime;
write(one("#plots-span"), say("last {0} minutes", SPAN / 60));
const show = seldom(() => {
  const freeze = one("#freeze");
  write(freeze, stands() ? say("Run") : say("Freeze"));
  freeze.toggleAttribute("disabled", !session.may(stands() ? "run" : "freeze"));
  tanks.show();
  drawPlots(session, PLOTTED, SPAN, limitsOf(session).depth);
});
for (const what of ["tick", "state", "ranges"]) session.on(what, show);
session.on("exercise", () => {
  const { hand = "", title = "" } = session.exercise;
  if (title === opened) return;
  opened = title;
  choose(HAND.find(([axis]) => hand.split(",").includes(axis))?.[1] ?? "steer");
});
keepLog(session);

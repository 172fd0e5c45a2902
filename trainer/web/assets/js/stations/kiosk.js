// A visitor's dive: the boat sails by itself, one key begins, one lever, one sentence, a result.
import "../boat/boat-side.js";
import "../controls/order-lever.js";
import { Lesson } from "../model/lesson.js";
import { Link } from "../protocol/link.js";
import { Motion } from "../model/motion.js";
import { Pending } from "../model/pending.js";
import { Session } from "../model/session.js";
import { askWord, showPalette } from "../frame.js";
import { Dive, advise } from "../kiosk/dive.js";
import { sailing } from "../kiosk/poster.js";
import { drawTrace } from "../kiosk/trace.js";
import { keepAwake, refuseGestures } from "../screen.js";
import { changes, figure, following, say, speak } from "../words.js";
import { html, one, write } from "../draw.js";

/**
 * @typedef {"attract" | "dive" | "result"} Scene
 * @typedef {import("../boat/boat-side.js").BoatSide} BoatSide
 */

const TARGET = 60; // [m] where nobody orders a depth
const LASTS = 180; // [s] where the exercise has no end
const LEVER = 20; // [deg] of the bow planes
const IDLE = 45; // [s] of a dive in which nobody touches anything
const SHOWN = 20; // [s] of a result
const LOOK = 250; // [ms]
const PATIENCE = 10_000; // [ms] for a lost line, after which the dive is over
const PLACES = { attract: 0.66, dive: 0.5, result: 0.72 }; // of the boat, across the picture

const first = new URLSearchParams(location.search).get("lang"); // of those who do not choose
const link = new Link(document.documentElement.dataset.version ?? "");
const session = new Session(link, "visitor", ["gauges", "orders", "diving", "time"]);
const motion = new Motion(session, {
  depth: { place: "gauges.depth", most: 5 },
  pitch: { place: "gauges.pitch", most: 7.1 },
  speed: { place: "gauges.speed" },
  stern: { place: "diving.stern" },
  bow: { place: "diving.bow" },
});
const side = /** @type {BoatSide} */ (one("boat-side"));
const pending = new Pending(session, "diving");
const lesson = new Lesson(session, () => follow());

/** @type {Scene} */
let scene = "attract";
let dive = new Dive(TARGET);
let restarted = false; // time has gone back to the start of this dive
/** @type {import("../model/readings.js").Reading | undefined} */
let before; // the last reading before that
let touched = performance.now(); // [ms] when somebody did something, or a scene began
let seen = performance.now(); // [ms] when the boat was there

/** @param {Scene} next */
function enter(next) {
  scene = next;
  document.body.dataset.scene = next;
  touched = performance.now();
  side.setAttribute("at", String(PLACES[next]));
  if (next === "attract") speak(first);
  if (next === "result") showResult();
  const key = { attract: "#start", dive: "order-lever [role=slider]", result: "#again" }[next];
  const chosen = document.activeElement !== document.body; // a visitor works it, no ring before
  if (chosen) /** @type {HTMLElement | null} */ (document.querySelector(key))?.focus();
}

/** Begins a dive from the start; the session answers when it has. */
async function begin() {
  restarted = false;
  const answer = await session.order("restart");
  if (!answer.ok) return;
  dive = new Dive(session.number("orders.depth") ?? TARGET);
  enter("dive");
}

/** The whole length of a dive [s]; a lesson has none. */
function length() {
  return Number(session.exercise.duration) || (led() ? Infinity : LASTS);
}

/** Whether the exercise is a lesson, whose steps say what to do. */
function led() {
  return Boolean(session.exercise.steps);
}

/** Orders what the lever says. @param {Event} event */
async function work(event) {
  const angle = /** @type {CustomEvent<number>} */ (event).detail;
  const words = angle === 0 ? "zero" : `${angle < 0 ? "dive" : "rise"} ${Math.abs(angle)}`;
  touched = performance.now();
  pending.give("lever", angle);
  const { ok } = await session.order(`lever ${words}`);
  pending.answered("lever", ok);
}

/** @returns {any} */
function lever() {
  return one("order-lever");
}

/** Hears that time has gone back. @param {Event} event */
function hear(event) {
  const { kind, fields } = /** @type {CustomEvent} */ (event).detail;
  if (kind !== "TRF" || fields[2] !== "back") return;
  restarted = true;
  before = session.readings.latest.get("gauges");
}

/** Shows a reading while a visitor dives. */
function follow() {
  const gauges = session.readings.latest.get("gauges");
  const [depth, pitch] = [session.number("gauges.depth"), session.number("gauges.pitch")];
  if (scene !== "dive" || !gauges || depth === null || pitch === null) return;
  if (!restarted || gauges === before) return; // this was on its way
  if (!dive.take(gauges.seconds, depth)) {
    enter("attract"); // somebody else has gone back in time
    return;
  }
  dive.target = session.number("orders.depth") ?? dive.target;
  const left = Math.max(length() - gauges.seconds, 0);
  write(one("#depth"), depth.toFixed(0));
  write(one("#angle"), Math.abs(pitch).toFixed(0));
  write(one("#left"), `${Math.floor(left / 60)}:${String(Math.floor(left % 60)).padStart(2, "0")}`);
  write(one("#task"), sentence(depth, pitch));
  showStep();
  if (session.state === "ended" || left === 0) enter("result");
}

/** Returns what is said now. @param {number} depth @param {number} pitch */
function sentence(depth, pitch) {
  if (session.state === "frozen") return say("Time stands still for a moment.");
  if (session.word("diving.bow_mode") === "auto") {
    return say("Too fast. The boat levels by itself, then the lever is yours again.");
  }
  if (!led()) return advise(dive.target, depth, pitch);
  return [lesson.step?.text.replaceAll("`", "") ?? "", lesson.hint].join(" ");
}

/** Shows how far a lesson is, and lights up what to look at. */
function showStep() {
  const { number = 0, count = 0, light = "" } = lesson.step ?? {};
  write(one("#step"), `${number} / ${count}`);
  for (const each of document.querySelectorAll("[data-shows], order-lever")) {
    each.toggleAttribute("data-lit", (/** @type {HTMLElement} */ (each).dataset.shows ?? "bow") === light);
  }
}

function showResult() {
  if (led()) write(one("#verdict"), session.outcome === "done" ? say("Well done: each step, to the last.") : say("That was it, for this time."));
  one("#how").hidden = led();
  one("#trace").toggleAttribute("hidden", led());
  if (led()) return;
  write(one("#verdict"), dive.verdict);
  write(one("#how"), dive.comparison);
  one("#trace").setAttribute("aria-label", dive.verdict);
  drawTrace(one("#trace"), dive, length());
}

/** Looks at the clock: who is not there any more is not waited for. */
function look() {
  const now = performance.now();
  if (session.live) seen = now;
  const idle = (now - touched) / 1000;
  if (scene === "dive" && (idle > IDLE || now - seen > PATIENCE)) enter("attract");
  if (scene !== "result") return;
  if (idle > SHOWN) enter("attract");
  else write(one("#nobody"), say("Nobody there? Back to the start in {0}", Math.ceil(SHOWN - idle)));
}

/** Says so while there is no boat. */
function attend() {
  const there = session.live;
  one(".waiting").toggleAttribute("hidden", there || session.state === "role");
  side.toggleAttribute("data-stale", !there && scene === "dive");
  offerDive();
  for (const control of document.querySelectorAll("[data-control], .go")) {
    control.toggleAttribute("inert", !there);
  }
}

/** Offers a dive where a visitor may begin the exercise again; else tells whom to ask. */
function offerDive() {
  const offered = session.exercise.visitors === "yes";
  const crewed = !offered && session.live && session.readings.latest.has("gauges");
  one("#start").hidden = !offered;
  one("#challenge").hidden = crewed;
  one("#crewed").hidden = !crewed;
  one(".timed").hidden = length() === Infinity;
  one(".led").hidden = !led();
  if (!led()) return;
  write(one("#invitation"), session.exercise.title ?? "");
  write(one("#challenge"), (session.told.line ?? []).join(" "));
  write(one("#start"), say("Begin"));
}

/** Puts everything into the language that is spoken. */
function translate() {
  const { code, name } = following();
  const key = one("#language");
  write(key, name);
  key.setAttribute("lang", code);
  side.words = { surface: say("surface"), ordered: say("ordered"), limit: "", metres: "m", ground: "" };
  const { length: metres = 70, mass = 4400 } = session.ranges;
  const size = [figure(metres), figure(Math.round(mass / 100) * 100)];
  write(
    one("#challenge"),
    say(
      "{0} metres long, {1} tonnes. It answers after twenty seconds. Can you bring it to {2} metres in three minutes?",
      ...size,
      session.number("orders.depth") ?? TARGET,
    ),
  );
  furnishLever();
  follow();
  if (scene === "result") showResult();
}

/** Puts a lever with words of the language in the place of the one before. */
function furnishLever() {
  const words = { low: say("down"), high: say("up"), limit: LEVER, face: "right" };
  const order = (/** @type {Event} */ event) => void work(event);
  const dial = html("angle-dial", { ...words, "aria-label": say("Planes") });
  lever().replaceWith(html("order-lever", { ...words, name: "planes", label: say("Planes"), order }, dial));
}

function picture() {
  if (scene === "attract") motion.wake(); // its boat sails, though no session does
  const { depth, pitch, speed, stern, bow } = motion.shown;
  const ordered = led() ? session.number("orders.depth") : dive.target;
  side.show(
    scene === "attract"
      ? sailing(performance.now() / 1000)
      : { depth, pitch, speed, stern, bow, ordered, limit: null },
  );
  const given = pending.resolve("lever", session.number("diving.ordered_bow"));
  lever().show?.(given, session.word("diving.bow_mode"), pending.waits("lever"), bow ?? null);
  /** @type {any} */ (one("angle-dial")).show?.(bow ?? null);
}

showPalette();
keepAwake();
refuseGestures();
askWord(session);
changes.addEventListener("change", translate);
session.on("ranges", translate);
session.on("tick", () => {
  follow();
  attend();
});
for (const what of ["state", "exercise"]) session.on(what, attend);
session.on("older", () => location.reload());
link.addEventListener("sentence", hear);
motion.addEventListener("frame", picture);
for (const key of ["#start", "#again"]) one(key).onclick = () => void begin();
one("#stop").onclick = () => enter("attract");
one("#language").onclick = () => speak(following().code);
for (const what of ["pointerdown", "keydown"]) addEventListener(what, () => (touched = performance.now()));
setInterval(look, LOOK);
enter("attract");
attend();
session.start();
motion.start();

// What every station's page has: state and time, alerts, palette, sound, and who it is.
import { AlertSounder } from "./alert-sounder.js";
import "./alert-bar.js";
import { muteWatch } from "./model/alerts.js";
import { Sound } from "./sound.js";
import { furnishChoices } from "./choices.js";
import { furnishBriefing } from "./briefing.js";
import { furnishAids } from "./aids.js";
import { followShown } from "./class/shown.js";
import { bearing, clock, one, write } from "./draw.js";
import { say, short } from "./words.js";

/**
 * @typedef {import("./model/session.js").Session} Session
 * @typedef {import("./model/alerts.js").Alerts} Alerts
 */

export const STATES = {
  connecting: say("CONNECTING"),
  role: say("ROLE?"),
  running: say("RUNNING"),
  frozen: say("FROZEN"),
  replay: say("REPLAY"),
  lost: say("NO LINK"),
  ended: say("ENDED"),
};
const PALETTES = ["dusk", "day", "bright", "night"];
const FOOT = 0.3048; // [m]
const BLOWN = ["forward", "mid", "aft", "negative"]; // tanks
const BANKS = ["main", "emergency"];
const LEAST_AIR = 1; // [%] of a bank, with which it still gives some
/** An order by hand of each axis: who may give it works there. @type {Record<string, string>} */
const BY_HAND = { rudder: "rudder", planes: "stern", speed: "bell", ballast: "pump" };
const KEPT = "palette"; // where the browser keeps the choice
/** What is told to the crew about the light aboard. @type {Record<string, string>} */
const RIGGED = { "rig for red": "night", "rig for white": "" };

/**
 * Furnishes a station's page; returns its sound.
 * @param {Session} session
 * @param {Alerts} alerts
 */
export function furnish(session, alerts) {
  const sound = new Sound();
  const palette = furnishPalette();
  switchSound(sound);
  alerts.watches.push(muteWatch(sound, () => alerts.shown));
  showAlerts(alerts, sound);
  ringOrders(session, sound);
  soundBoat(session, sound);
  rigLight(session, palette);
  for (const what of ["state", "tick", "exercise"]) session.on(what, () => showState(session));
  session.on("older", () => one("#older", document).removeAttribute("hidden"));
  askWord(session);
  furnishBriefing(session);
  furnishAids(session);
  followShown();
  addEventListener("keydown", (event) => {
    if (event.key.toLowerCase() !== "a" || isTyping(event)) return;
    const first = alerts.shown.find((each) => each.owed && !each.by && each.rank !== "emergency");
    if (first) alerts.acknowledge(first);
  });
  showState(session);
  return sound;
}

/** Shows the palette, and lets it be chosen; returns the chooser. */
export function furnishPalette() {
  const palette = /** @type {HTMLSelectElement} */ (one("#palette"));
  palette.value = showPalette();
  palette.onchange = () => keepPalette(palette.value);
  furnishChoices();
  return palette;
}

/** Shows alerts, and sounds new ones until somebody has seen them. @param {Alerts} alerts @param {Sound} [sound] */
export function showAlerts(alerts, sound) {
  alerts.answers = Boolean(sound);
  const bar = /** @type {import("./alert-bar.js").AlertBar} */ (one("alert-bar"));
  bar.follow(alerts, sound && new AlertSounder(alerts, sound));
}

/** Strikes the bell for each new order that this station is to repeat. @param {Session} session @param {Sound} sound */
function ringOrders(session, sound) {
  /** @type {import("./model/crew.js").CrewOrder | undefined} */
  let last;
  session.on("crew", () => {
    const order = session.crew.toRepeat(session.role);
    if (order && order !== last) sound.bell();
    last = order;
  });
}

/** Lets what this station's instruments show be heard: the telegraph when it is rung, air that flows. @param {Session} session @param {Sound} sound */
function soundBoat(session, sound) {
  /** @type {string | null} */
  let rung = null; // null until the page has heard of the engine
  session.on("tick", () => {
    sound.blow(session.state === "running" && airFlows(session));
    if (!session.readings.latest.has("engine")) return;
    const bell = session.word("engine.bell");
    if (bell && rung !== null && bell !== rung) sound.telegraph();
    rung = bell;
  });
}

/** @param {Session} session */
function airFlows(session) {
  const blows = BLOWN.some((tank) => ["open", "emergency"].includes(session.word(`valves.blow_${tank}`)));
  return blows && BANKS.some((bank) => (session.number(`air.${bank}_full`) ?? 0) > LEAST_AIR);
}

/**
 * Follows what is told about the light; the choice of this browser stays kept.
 * @param {Session} session
 * @param {HTMLSelectElement} [palette]
 */
export function rigLight(session, palette) {
  let rigged = "";
  session.on("tick", () => {
    const told = session.word("orders.told");
    if (told === rigged || !(told in RIGGED)) return;
    rigged = told;
    const name = RIGGED[told] || keptPalette();
    if (palette) palette.value = name;
    setPalette(name);
  });
}

/** Whether a key belongs to a field or a control. @param {KeyboardEvent} event */
export function isTyping(event) {
  const target = /** @type {Element} */ (event.target);
  return event.ctrlKey || event.altKey || event.metaKey || Boolean(target.closest("input, select"));
}

/** Shows state and time, and what they mean for controls and instruments. @param {Session} session */
export function showState(session) {
  const { state } = session;
  const pill = one("#state");
  for (const part of [document.body, pill]) {
    if (part.dataset.state !== state) part.dataset.state = state; // told aloud whenever it is set
  }
  write(pill, STATES[state]);
  const left = session.exercise.duration ? ` / ${clock(Number(session.exercise.duration))}` : "";
  write(one("#time"), `${clock(session.seconds)}${left}`);
  write(one("#link"), describeLink(session) || describeHands(session));
  for (const control of document.querySelectorAll("[data-control]")) {
    control.toggleAttribute("inert", !session.live);
  }
  for (const gauge of document.querySelectorAll(".gauge")) {
    gauge.toggleAttribute("data-stale", state === "lost" || state === "connecting");
  }
}

/** Returns what the page is doing about its line, "" where all is well. @param {Session} session */
function describeLink(session) {
  const { why, tries } = session.source;
  if (session.state === "connecting") return session.alone ? "" : say("Dialling {0}", location.host);
  if (session.state === "lost") return say("{0}; try {1}", why || say("no readings"), tries);
  return "";
}

/** Returns what this station could work, and who of the others has worked it last. @param {Session} session */
function describeHands(session) {
  const elsewhere = session
    .word("orders.hands")
    .split("; ")
    .filter((each) => {
      const [axis, role] = each.split(" ");
      return axis in BY_HAND && role !== session.role && session.may(BY_HAND[axis]);
    });
  return elsewhere.length ? say("others have: {0}", elsewhere.join("; ")) : "";
}

/** Returns what the crew is ordered, in one line. @param {Session} session */
export function orderedLine(session) {
  const parts = [];
  const [course, depth] = [session.number("orders.course"), session.number("orders.depth")];
  const side = session.word("orders.course_side");
  if (course !== null) parts.push(courseOrder(bearing(course), side));
  if (depth !== null) parts.push(say("depth {0}", depthOrder(session, depth)));
  const pitch = session.number("orders.pitch");
  if (pitch !== null) parts.push(pitchOrder(pitch));
  const speed = session.number("orders.speed");
  if (speed !== null) parts.push(say("speed {0} kn", speed));
  const led = session.role === "trainee" && session.exercise.steps; // the step stands elsewhere
  const told = led ? "" : session.word("orders.told");
  return [parts.join(", "), told].filter(Boolean).join("; ");
}

/** Returns an ordered course in words. @param {string} to @param {string} side to which it is turned, "" for the nearer */
function courseOrder(to, side) {
  if (!side) return say("course {0}", to);
  return side === "left" ? say("course left to {0}", to) : say("course right to {0}", to);
}

/** Returns a depth in the unit of its order. @param {Session} session @param {number} metres */
export function depthOrder(session, metres) {
  const feet = session.word("orders.depth_unit") === "ft";
  return feet ? `${Math.round(metres / FOOT)} ft` : `${short(metres)} m`;
}

/** Returns an ordered pitch in words. @param {number} pitch */
export function pitchOrder(pitch) {
  if (pitch === 0) return say("level");
  return pitch < 0 ? say("pitch {0} down", -pitch) : say("pitch {0} up", pitch);
}

/** Returns the palette that is asked for or was kept, else that of the browser. */
function keptPalette() {
  const asked = new URLSearchParams(location.search).get("palette");
  const kept = asked ?? localStorage.getItem(KEPT);
  const light = matchMedia("(prefers-color-scheme: light)").matches;
  return PALETTES.find((each) => each === kept) ?? (light ? "day" : "dusk");
}

/** Shows that palette; returns its name. */
export function showPalette() {
  const name = keptPalette();
  setPalette(name);
  return name;
}

/** Shows a palette from now on, and at the next start. @param {string} name */
function keepPalette(name) {
  localStorage.setItem(KEPT, name);
  setPalette(name);
}

/** @param {string} name */
function setPalette(name) {
  document.documentElement.dataset.palette = name;
  dispatchEvent(new Event("palette"));
}

/** @param {Sound} sound */
function switchSound(sound) {
  const key = one("#sound");
  key.onclick = () => {
    const on = sound.toggle();
    key.setAttribute("aria-pressed", String(on));
    write(key, on ? say("Sound on") : say("Sound off"));
  };
}

/** Asks for the role's token, where the session wants one. @param {Session} session */
export function askWord(session) {
  const dialog = /** @type {HTMLDialogElement} */ (one("#word"));
  const form = /** @type {HTMLFormElement} */ (one("form", dialog));
  const field = /** @type {HTMLInputElement} */ (one("input", dialog));
  form.onsubmit = (event) => {
    event.preventDefault();
    void session.give(field.value.trim());
    field.value = "";
  };
  session.on("state", () => {
    // Behind its colon a refusal says what a terminal types; here the word goes into the field.
    write(one("#refusal"), session.refusal.replace(/: (--token|type role) .*$/, ""));
    if (session.state === "role" && !dialog.open) dialog.showModal();
    if (session.state !== "role" && dialog.open) dialog.close();
  });
}

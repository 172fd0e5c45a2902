// What every station's page has: state and time, alerts, palette, sound, and who it is.
import { RANKS } from "./model/alerts.js";
import { Sound } from "./sound.js";
import { furnishBriefing } from "./briefing.js";
import { bearing, clock, html, one, svg, write } from "./draw.js";

/**
 * @typedef {import("./model/session.js").Session} Session
 * @typedef {import("./model/alerts.js").Alerts} Alerts
 * @typedef {import("./model/alerts.js").Shown} Shown
 */

const SHAPES = {
  emergency: "M12 1L23.5 22.5H.5Z",
  alarm: "M12 1L23.5 22.5H.5Z",
  warning: "M12 1a11 11 0 1 0 .01 0Z",
  caution: "M2 2H22V22H2Z",
};
const STATES = {
  connecting: "CONNECTING",
  role: "ROLE?",
  running: "RUNNING",
  frozen: "FROZEN",
  replay: "REPLAY",
  lost: "NO LINK",
  ended: "ENDED",
};
const AT_ONCE = 3; // alerts that are shown
const PALETTES = ["dusk", "day", "night"];
const FOOT = 0.3048; // [m]
const KEPT = "palette"; // where the browser keeps the choice
/** What is told to the crew about the light aboard. @type {Record<string, string>} */
const RIGGED = { "rig for red": "night", "rig for white": "" };

class AlertBar extends HTMLElement {
  connectedCallback() {
    this.setAttribute("role", "log");
    this.setAttribute("aria-label", "Alerts");
    this.setAttribute("aria-live", "polite");
  }

  /** @param {Alerts} alerts */
  show(alerts) {
    const shown = alerts.shown;
    const now = JSON.stringify(shown.map((each) => [each.key, each.words, each.fresh]));
    if (this.dataset.shown === now) return;
    this.dataset.shown = now;
    const urgent = shown.some((each) => each.fresh && RANKS.indexOf(each.rank) < 2);
    this.setAttribute("aria-live", urgent ? "assertive" : "polite");
    const more = shown.length - AT_ONCE;
    this.replaceChildren(
      ...shown.slice(0, AT_ONCE).map((each) => this.entry(each, alerts)),
      ...(more > 0 ? [html("span", { class: "alert" }, `+${more}`)] : []),
    );
  }

  /** @param {Shown} alert @param {Alerts} alerts */
  entry(alert, alerts) {
    const icon = svg(
      "svg",
      { viewBox: "0 0 24 24", class: "icon", "aria-hidden": "true" },
      svg("path", { d: SHAPES[alert.rank] }),
      svg("path", { d: "M12 8v7M12 18.5v.1", class: "cut" }),
    );
    const seen = () => alerts.acknowledge(alert);
    return html(
      "span",
      { class: "alert", "data-rank": alert.rank, "data-new": alert.fresh },
      icon,
      html("b", {}, alert.words),
      html("time", {}, clock(alert.seconds)),
      alert.fresh && html("button", { type: "button", click: seen }, "Acknowledge"),
      !alert.fresh && alert.rank !== "caution" && html("span", {}, "seen"),
    );
  }
}
customElements.define("alert-bar", AlertBar);

/**
 * Furnishes a station's page; returns its sound.
 * @param {Session} session
 * @param {Alerts} alerts
 */
export function furnish(session, alerts) {
  const sound = new Sound();
  const palette = furnishPalette();
  switchSound(sound);
  showAlerts(alerts, sound);
  ringOrders(session, sound);
  rigLight(session, palette);
  for (const what of ["state", "tick", "exercise"]) session.on(what, () => showState(session));
  session.on("older", () => one("#older", document).removeAttribute("hidden"));
  askWord(session);
  furnishBriefing(session);
  addEventListener("keydown", (event) => {
    if (event.key.toLowerCase() !== "a" || isTyping(event)) return;
    const first = alerts.shown.find((each) => each.fresh);
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
  return palette;
}

/** Shows alerts, and tells new ones. @param {Alerts} alerts @param {Sound} [sound] */
export function showAlerts(alerts, sound) {
  const bar = /** @type {AlertBar} */ (one("alert-bar"));
  /** @type {Set<string>} */
  const sounded = new Set();
  alerts.addEventListener("change", () => {
    bar.show(alerts);
    for (const each of alerts.shown) {
      if (each.fresh && !sounded.has(each.key)) sound?.alert(each.rank);
      sounded.add(each.key);
    }
  });
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
  document.body.dataset.state = state;
  pill.dataset.state = state;
  write(pill, STATES[state]);
  const left = session.exercise.duration ? ` / ${clock(Number(session.exercise.duration))}` : "";
  write(one("#time"), `${clock(session.seconds)}${left}`);
  write(one("#link"), describeLink(session));
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
  if (session.state === "connecting") return session.alone ? "" : `Dialling ${location.host}`;
  if (session.state === "lost") return `${why || "no readings"}; try ${tries}`;
  return "";
}

/** Returns what the crew is ordered, in one line. @param {Session} session */
export function orderedLine(session) {
  const parts = [];
  const [course, depth] = [session.number("orders.course"), session.number("orders.depth")];
  const side = session.word("orders.course_side");
  if (course !== null) parts.push(`course ${side ? `${side} to ` : ""}${bearing(course)}`);
  if (depth !== null) parts.push(`depth ${depthOrder(session, depth)}`);
  const pitch = session.number("orders.pitch");
  if (pitch !== null) parts.push(pitchOrder(pitch));
  const speed = session.number("orders.speed");
  if (speed !== null) parts.push(`speed ${speed} kn`);
  const told = session.word("orders.told");
  return [parts.join(", "), told].filter(Boolean).join("; ");
}

/** Returns a depth in the unit of its order. @param {Session} session @param {number} metres */
export function depthOrder(session, metres) {
  const feet = session.word("orders.depth_unit") === "ft";
  return feet ? `${Math.round(metres / FOOT)} ft` : `${metres} m`;
}

/** Returns an ordered pitch in words. @param {number} pitch */
export function pitchOrder(pitch) {
  return pitch === 0 ? "level" : `bubble ${Math.abs(pitch)} ${pitch < 0 ? "down" : "up"}`;
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
    write(key, on ? "Sound on" : "Sound off");
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
    write(one("#refusal"), session.refusal);
    if (session.state === "role" && !dialog.open) dialog.showModal();
    if (session.state !== "role" && dialog.open) dialog.close();
  });
}

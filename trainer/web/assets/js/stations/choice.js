// The first page: what is sailed here, who is aboard, and which station this browser is to be.
import { clock, one, write } from "../draw.js";
import { furnishPalette } from "../frame.js";
import { paced } from "../instructor/desk.js";
import { Readings } from "../model/readings.js";
import { Link } from "../protocol/link.js";

/** @typedef {import("../protocol/line.js").Sentence} Sentence */

const OWN = "chooser"; // what this page is called in the list
const PACE = 500; // [ms] between looks at who is aboard

const link = new Link(document.documentElement.dataset.version ?? "");
const readings = new Readings();
/** @type {Record<string, string>} */
const exercise = {};
/** @type {string[]} who is here: names, else roles */
let aboard = [];
let over = "";

furnishPalette();
link.addEventListener("open", () => void begin());
link.addEventListener("lost", () => {
  readings.forget();
  tell("lost", `NO LINK: ${link.why}; try ${link.tries}`);
  for (const key of keys()) write(one("small", key), "");
});
link.addEventListener("older", () => {
  one("#older").hidden = false;
  tell("lost", "OLDER PAGE");
});
link.addEventListener("sentence", (event) => hear(/** @type {CustomEvent<Sentence>} */ (event).detail));
link.open();

/** Asks what is sailed here, and who is aboard, where the session tells it without a token. */
async function begin() {
  link.settle();
  for (const key of Object.keys(exercise)) delete exercise[key];
  over = "";
  offerKiosk();
  tell("running", "CONNECTED");
  const called = await link.order(`name ${OWN}`);
  if (!called.ok) {
    write(one("#title"), "A session that asks for a word");
    write(one("#says"), "Choose a station: it asks for your word once, and keeps it in this browser.");
    return;
  }
  await Promise.all([link.order("briefing"), link.order("subscribe time at 2 hz")]);
  showExercise();
  await lookRound();
}

/** @param {Sentence} sentence */
function hear(sentence) {
  const { kind, fields } = sentence;
  if (kind === "TRN" || kind === "TRS") readings.take(sentence);
  else if (kind === "TRF" && fields[2] === "exercise") learn(fields[3] ?? "");
  else if (kind === "TRF" && fields[2] === "exercise-over") over = fields[3] || "ended";
  else if (kind === "TRF" && fields[2] === "back") over = "";
  else if (kind === "TRF" && fields[2] === "stations") aboard = [];
  else if (kind === "TRF" && fields[2] === "aboard") aboard.push(known(fields[3]));
  else if (kind === "TRE" && fields[2] === "station") look();
  showExercise();
}

/** Returns what a station is called here. @param {string} told role, name and more */
function known(told) {
  const [role, name] = told.split(",");
  return name || role;
}

/** @param {string} told a key of the exercise and its value */
function learn(told) {
  const equals = told.indexOf("=");
  exercise[told.slice(0, equals)] = told.slice(equals + 1);
  offerKiosk();
}

/** Offers the kiosk where a visitor may begin the exercise again, and nowhere else. */
function offerKiosk() {
  const kiosk = /** @type {HTMLElement} */ (one("[data-name=kiosk]").closest("li"));
  kiosk.hidden = exercise.visitors !== "yes";
}

/** Shows what is sailed here, and how far it is. */
function showExercise() {
  const time = readings.word("time.time");
  if (!time) return;
  const seconds = readings.latest.get("time")?.seconds ?? 0;
  const end = exercise.duration ? ` / ${clock(Number(exercise.duration))}` : "";
  write(one("#title"), exercise.title ?? "The boat sails freely");
  write(one("#time"), `${clock(seconds)}${end}`);
  write(one("#says"), saysOf(time, seconds));
}

/** @param {string} time as the session tells it @param {number} seconds */
function saysOf(time, seconds) {
  if (over) return "The exercise is over.";
  if (readings.word("time.replay") === "yes") return "A replay runs.";
  if (time === "running") return "Time runs.";
  return seconds > 0 ? "Time stands still." : "It has not begun yet.";
}

/** @returns {NodeListOf<HTMLElement>} */
function keys() {
  return document.querySelectorAll("[data-role]");
}

const look = paced(PACE, () => void lookRound());

/** Shows how many are aboard at each station. */
async function lookRound() {
  const { ok } = await link.order("who");
  if (!ok) return;
  for (const key of keys()) {
    const { name = "", role = "" } = key.dataset;
    const wanted = document.querySelectorAll(`[data-role="${role}"]`).length > 1 ? name : role;
    const count = aboard.filter((each) => each === wanted).length;
    key.toggleAttribute("data-taken", count > 0);
    write(one("small", key), count ? `${count} aboard` : "free");
  }
}

/** @param {string} state @param {string} words */
function tell(state, words) {
  const pill = one("#state");
  pill.dataset.state = state;
  write(pill, words);
}

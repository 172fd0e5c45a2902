// The first page: what is sailed here, who is aboard, and which station this browser is to be.
import { limitsInWords } from "../briefing.js";
import { clock, one, write } from "../draw.js";
import { furnishPalette } from "../frame.js";
import { paced } from "../instructor/desk.js";
import { Readings } from "../model/readings.js";
import { Stations } from "../model/stations.js";
import { Link } from "../protocol/link.js";
import { say } from "../words.js";

/** @typedef {import("../protocol/line.js").Sentence} Sentence */

const OWN = "chooser"; // what this page is called in the list
const PACE = 500; // [ms] between looks at who is aboard

const link = new Link(document.documentElement.dataset.version ?? "");
const readings = new Readings();
/** @type {Record<string, string>} */
const exercise = {};
/** @type {string[]} what the crew is told of it */
let lines = [];
const stations = new Stations();
const homes = new Map([...keys()].map((key) => [key, /** @type {Element} */ (key.closest("ul"))]));
let arranged = ""; // for which exercise the stations stand as they do
let over = "";
/** What the session tells this page. @type {Record<string, (subject: string) => void>} */
const FACTS = {
  exercise: learn,
  "exercise-over": (how) => (over = how || "ended"),
  back: () => (over = ""),
  stations: (count) => stations.expect(Number(count)),
  aboard: (subject) => stations.add(subject),
};

furnishPalette();
link.addEventListener("open", () => void begin());
link.addEventListener("lost", () => {
  readings.forget();
  tell("lost", say("NO LINK: {0}; try {1}", link.why, link.tries));
  for (const key of keys()) write(one("small", key), "");
});
link.addEventListener("older", () => {
  one("#older").hidden = false;
  tell("lost", say("OLDER PAGE"));
});
link.addEventListener("sentence", (event) => hear(/** @type {CustomEvent<Sentence>} */ (event).detail));
link.open();

/** Asks what is sailed here, and who is aboard, where the session tells it without a token. */
async function begin() {
  link.settle();
  forget();
  over = "";
  arrange();
  tell("running", say("CONNECTED"));
  const called = await link.order(`name ${OWN}`);
  if (!called.ok) {
    write(one("#title"), say("A session that asks for a word"));
    write(one("#says"), say("Choose a station: it asks for your word once, and keeps it in this browser."));
    return;
  }
  forget(); // a line without a token was told it once already
  await Promise.all([link.order("briefing"), link.order("subscribe time at 2 hz")]);
  showExercise();
  await lookRound();
}

/** @param {Sentence} sentence */
function hear(sentence) {
  const { kind, fields } = sentence;
  if (kind === "TRN" || kind === "TRS") readings.take(sentence);
  else if (kind === "TRF") FACTS[fields[2]]?.(fields[3] ?? "");
  else if (kind === "TRE" && fields[2] === "station") look();
  showExercise();
}

/** Forgets the exercise: another one is told. */
function forget() {
  for (const key of Object.keys(exercise)) delete exercise[key];
  lines = [];
}

/** @param {string} told a key of the exercise and its value */
function learn(told) {
  const equals = told.indexOf("=");
  const [key, value] = [told.slice(0, equals), told.slice(equals + 1)];
  if (key === "title") forget();
  if (key === "line") lines.push(value);
  else exercise[key] = value;
  arrangeSoon();
}

/** Puts the stations that the exercise wants first; the others are folded. */
function arrange() {
  const stands = JSON.stringify([exercise.title, exercise.hand, exercise.visitors]);
  if (stands === arranged) return;
  arranged = stands;
  const kiosk = /** @type {HTMLElement} */ (one("[data-name=kiosk]").closest("li"));
  kiosk.hidden = exercise.visitors !== "yes"; // only where a visitor may begin the exercise again
  const chosen = wantedStations().map((name) => one(`[data-name=${name}]`));
  const focused = /** @type {HTMLElement | null} */ (document.activeElement);
  for (const [key, home] of homes) home.append(/** @type {Element} */ (key.closest("li")));
  one("#wanted ul").append(...chosen.map((key) => /** @type {Element} */ (key.closest("li"))));
  one("#wanted").hidden = one("#others summary").hidden = chosen.length === 0;
  one("#others").toggleAttribute("open", chosen.length === 0);
  for (const group of document.querySelectorAll("#others section")) {
    group.toggleAttribute("hidden", !group.querySelector("li"));
  }
  focused?.focus(); // what is moved loses it
}

/** Returns the names of the stations that the exercise wants: those that work what is in hand. */
function wantedStations() {
  if (exercise.visitors === "yes") return ["kiosk"];
  const hand = (exercise.hand ?? "").split(",");
  const parts = [...keys()].map(({ dataset }) => {
    const works = (dataset.works ?? "").split(" ");
    return { name: dataset.name ?? "", works: works.length, of: hand.filter((axis) => axis && works.includes(axis)) };
  });
  const needed = parts.filter(({ of, works }) => {
    const less = parts.some((other) => other.works < works && of.every((axis) => other.of.includes(axis)));
    return of.length > 0 && !less; // one that has more to work than it takes is not needed
  });
  return needed.map(({ name }) => name);
}

const arrangeSoon = paced(PACE / 10, () => {
  arrange();
  showExercise();
});

/** Shows what is sailed here, and how far it is. */
function showExercise() {
  const time = readings.word("time.time");
  if (!time) return;
  const seconds = readings.latest.get("time")?.seconds ?? 0;
  const end = exercise.duration ? ` / ${clock(Number(exercise.duration))}` : "";
  const sails = seconds || time === "running";
  one("#scenarios").hidden = Boolean(exercise.title || sails);
  write(one("#title"), exercise.title ?? (sails ? say("The boat sails freely") : say("It stands until somebody chooses")));
  write(one("#time"), `${clock(seconds)}${end}`);
  write(one("#says"), saysOf(time, seconds));
  const facts = [
    [say("By hand"), exercise.hand?.replaceAll(",", ", ")],
    [say("Limits"), limitsInWords(exercise.limits)],
    [say("Lesson"), exercise.steps ? say("{0} steps that lead who trains", exercise.steps) : ""],
  ].filter(([, what]) => what);
  fill(one("#about"), lines.join(" ").trim());
  fill(one("#facts"), facts.map(([name, what]) => `${name}: ${what}`).join(". "));
}

/** Shows a text, and nothing where there is none. @param {HTMLElement} place @param {string} text */
function fill(place, text) {
  place.hidden = !text;
  write(place, text);
}

/** @param {string} time as the session tells it @param {number} seconds */
function saysOf(time, seconds) {
  if (over) return say("The exercise is over.");
  if (readings.word("time.replay") === "yes") return say("A replay runs.");
  if (time === "running") return say("Time runs.");
  return seconds > 0 ? say("Time stands still.") : say("It has not begun yet.");
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
    const shared = document.querySelectorAll(`[data-role="${role}"]`).length > 1;
    const there = stations.all.filter((each) => (shared && each.called ? each.called : each.role) === (shared ? name : role));
    const names = there.map(({ called, line }) => (called && called !== name ? called : line));
    key.toggleAttribute("data-taken", there.length > 0);
    write(one("small", key), there.length ? say("{0} aboard: {1}", there.length, names.join(", ")) : say("free"));
  }
}

/** @param {string} state @param {string} words */
function tell(state, words) {
  const pill = one("#state");
  pill.dataset.state = state;
  write(pill, words);
}

// The wall: what ten people see from four metres away. It orders nothing.
import "../boat/boat-side.js";
import "../charts/track-chart.js";
import { Alerts } from "../model/alerts.js";
import { Link } from "../protocol/link.js";
import { limitsOf } from "../model/limits.js";
import { paced } from "../instructor/desk.js";
import { Motion } from "../model/motion.js";
import { reckon } from "../model/reckoning.js";
import { Session } from "../model/session.js";
import { bellOf } from "../controls/bells.js";
import { askWord, depthOrder, rigLight, showAlerts, showPalette, showState } from "../frame.js";
import { hideStillPointer, keepAwake, moveEachMinute } from "../screen.js";
import { bearing, html, one, write } from "../draw.js";
import { lengthDigits, unit } from "../units.js";
import { decimals, say } from "../words.js";

const CREW = ["gauges", "orders", "diving", "engine", "time"];
/** What is read, as the crew's gauges show it, and as it is. */
const READ = {
  gauges: { from: "gauges", channels: CREW, words: "" },
  motion: { from: "motion", channels: [...CREW, "motion", "sea"], words: say("the truth") },
};
const DIGITS = 500; // [ms] between digits that change
const TRACK = 2000; // [ms] between tracks
const PLACES = 1200; // of the track

/** The boat's number, where it is one of a class. */
const [, boat = ""] = /\/(?:boat|shown)\/(\d+)\/wall$/.exec(location.pathname) ?? [];
const truth = new URLSearchParams(location.search).has("truth");
const { from, channels, words } = READ[truth ? "motion" : "gauges"];
const link = new Link(document.documentElement.dataset.version ?? "");
const session = new Session(link, truth ? "instructor" : "observer", channels);
session.called = "wall";
const alerts = new Alerts(session);
const motion = new Motion(session, {
  depth: { place: `${from}.depth`, rate: truth ? "motion.depth_rate" : undefined, most: 5 },
  pitch: { place: `${from}.pitch`, rate: truth ? "motion.pitch_rate" : undefined, most: 7.1 },
  speed: { place: `${from}.speed` },
  stern: { place: "diving.stern" },
  bow: { place: "diving.bow" },
  surface: { place: "sea.elevation" },
});
const side = /** @type {import("../boat/boat-side.js").BoatSide} */ (one("boat-side"));

/** Returns a number as it is written on the wall, a dash where it is not known. @param {string} place */
function figure(place, digits = 1) {
  const value = session.number(place);
  return value === null ? "-" : decimals(value, digits);
}

function showFigures() {
  const heading = session.number(`${from}.heading`);
  const pitch = session.number(`${from}.pitch`);
  const depth = session.number(`${from}.depth`);
  write(one("#depth"), depth === null ? "-" : lengthDigits(depth));
  write(one("#heading"), heading === null ? "-" : bearing(heading));
  write(one("#speed"), figure(`${from}.speed`));
  write(one("#pitch"), pitch === null ? "-" : decimals(Math.abs(pitch), 1));
  write(one("#way"), !pitch || Math.abs(pitch) < 0.05 ? "" : pitch < 0 ? say("down") : say("up"));
  showOrders();
}

/** Shows what the crew is ordered, beside what it concerns. */
function showOrders() {
  const [course, bell] = [session.number("orders.course"), session.word("engine.bell")];
  const [depth, speed] = [session.number("orders.depth"), session.number("orders.speed")];
  write(one("#ordered-depth"), depth === null ? "" : say("ordered {0}", depthOrder(session, depth)));
  write(one("#ordered-course"), course === null ? "" : say("ordered {0}", bearing(course)));
  write(one("#ordered-speed"), speed === null ? "" : say("ordered {0} kn", speed));
  write(one("#bell"), bellOf(bell.replaceAll("-", " ")) || "-");
}

/** Shows the track: as it was, or as it is reckoned from what the crew's gauges show. */
function showTrack() {
  const past = session.history.of(from);
  const every = Math.max(Math.ceil(past.rows.length / PLACES), 1);
  const flown = past.rows.filter((_, at) => at % every === 0 || at === past.rows.length - 1);
  const places = truth
    ? flown.map(({ north, east }) => /** @type {[number, number]} */ ([north, east]))
    : reckon(past, PLACES);
  const track = /** @type {import("../charts/track-chart.js").TrackChart} */ (one("track-chart"));
  track.show(places, session.number(`${from}.heading`), { ordered: session.number("orders.course") });
}

/** Shows the title that the crew knows, and the marks once they are released. */
function showExercise() {
  const title = session.exercise.title || say("Free sailing");
  write(one("#exercise"), boat ? `${say("Boat {0}", boat)}: ${title}` : title);
  const { judgement, outcome } = session;
  const panel = one("#marks");
  panel.toggleAttribute("hidden", !outcome || !judgement.marks);
  const [total = "", ...reasons] = judgement.lines;
  panel.replaceChildren(
    html("h2", {}, total),
    html("ul", {}, ...reasons.map((each) => html("li", {}, each))),
  );
}

/** Gives command to the instructor who asks: a wall that took it first orders nothing. @param {Event} event */
function giveCommand(event) {
  const { kind, fields } = /** @type {CustomEvent} */ (event).detail;
  if (kind === "TRF" && fields[2] === "asked") void session.ask("give command");
}

/** The greatest depth that the crew may have, if any. */
function limit() {
  return limitsOf(session).depth ?? session.ranges["test-depth"] ?? null;
}

function picture() {
  const { depth, pitch, speed, stern, bow, surface } = motion.shown;
  const ordered = session.number("orders.depth");
  side.still = session.state === "frozen";
  side.show({ depth, pitch, speed, stern, bow, surface, limit: limit(), ordered });
}

showPalette();
rigLight(session);
showAlerts(alerts);
askWord(session);
keepAwake();
hideStillPointer();
moveEachMinute(one("main"));
write(one("#source"), words);
write(one("#depth-unit"), unit);
for (const what of ["state", "tick", "exercise"]) session.on(what, () => showState(session));
for (const what of ["exercise", "marks", "state"]) session.on(what, showExercise);
session.on("tick", paced(TRACK, showTrack));
session.on("ranges", () => (side.length = session.ranges.length ?? side.length));
session.on("older", () => location.reload());
link.addEventListener("sentence", giveCommand);
motion.addEventListener("frame", picture);
setInterval(showFigures, DIGITS);
session.start();
motion.start();

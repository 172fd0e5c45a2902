// The wall: what ten people see from four metres away. It orders nothing.
import "../boat/boat-side.js";
import { Alerts } from "../model/alerts.js";
import { Link } from "../protocol/link.js";
import { Motion } from "../model/motion.js";
import { Session } from "../model/session.js";
import { askWord, rigLight, showAlerts, showPalette, showState } from "../frame.js";
import { hideStillPointer, keepAwake, moveEachMinute } from "../screen.js";
import { bearing, html, one, write } from "../draw.js";

const CREW = ["gauges", "orders", "diving", "engine", "time"];
/** What is read, as the crew's gauges show it, and as it is. */
const READ = {
  gauges: { from: "gauges", channels: CREW, words: "" },
  motion: { from: "motion", channels: [...CREW, "motion", "sea"], words: "the truth" },
};
const DIGITS = 500; // [ms] between digits that change

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
  return session.number(place)?.toFixed(digits) ?? "-";
}

function showFigures() {
  const heading = session.number(`${from}.heading`);
  const pitch = session.number(`${from}.pitch`);
  const depth = session.number(`${from}.depth`);
  write(one("#depth"), depth === null ? "-" : depth.toFixed(1));
  write(one("#heading"), heading === null ? "-" : bearing(heading));
  write(one("#speed"), figure(`${from}.speed`));
  write(one("#pitch"), pitch === null ? "-" : Math.abs(pitch).toFixed(1));
  write(one("#way"), !pitch || Math.abs(pitch) < 0.05 ? "" : pitch < 0 ? "down" : "up");
  showOrders();
}

/** Shows what the crew is ordered, beside what it concerns. */
function showOrders() {
  const [course, bell] = [session.number("orders.course"), session.word("engine.bell")];
  const [depth, speed] = [session.number("orders.depth"), session.number("orders.speed")];
  const unit = session.word("orders.depth_unit");
  write(one("#ordered-depth"), depth === null ? "" : `ordered ${Number(depth)} ${unit}`);
  write(one("#ordered-course"), course === null ? "" : `ordered ${bearing(course)}`);
  write(one("#ordered-speed"), speed === null ? bell.replaceAll("-", " ") : `ordered ${speed} kn`);
}

/** Shows the title that the crew knows, and the marks once they are released. */
function showExercise() {
  write(one("#exercise"), session.exercise.title || "Free sailing");
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
  const found = /(?:^|,)depth_m_max:([\d.]+)/.exec(session.exercise.limits ?? "");
  return found ? Number(found[1]) : (session.ranges["test-depth"] ?? null);
}

function picture() {
  const { depth, pitch, speed, stern, bow, surface } = motion.shown;
  const ordered = session.number("orders.depth");
  const metres = session.word("orders.depth_unit") === "ft" ? 0.3048 : 1;
  side.show({
    ...{ depth, pitch, speed, stern, bow, surface, limit: limit() },
    ordered: ordered === null ? null : ordered * metres,
  });
}

showPalette();
rigLight(session);
showAlerts(alerts);
askWord(session);
keepAwake();
hideStillPointer();
moveEachMinute(one("main"));
write(one("#source"), words);
for (const what of ["state", "tick", "exercise"]) session.on(what, () => showState(session));
for (const what of ["exercise", "marks", "state"]) session.on(what, showExercise);
session.on("ranges", () => (side.length = session.ranges.length ?? side.length));
session.on("older", () => location.reload());
link.addEventListener("sentence", giveCommand);
motion.addEventListener("frame", picture);
setInterval(showFigures, DIGITS);
session.start();
motion.start();

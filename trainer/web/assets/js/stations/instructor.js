// The instructor: the truth, what is broken, what was flown, and all orders.
import "../boat/boat-side.js";
import "../boat/boat-stern.js";
import "../charts/strip-chart.js";
import "../charts/track-chart.js";
import "../controls/time-line.js";
import "../tanks/tank-mimic.js";
import { html, one } from "../draw.js";
import { furnish } from "../frame.js";
import { showCasualties } from "../instructor/casualties.js";
import { furnishCommand } from "../instructor/command.js";
import { Desk } from "../instructor/desk.js";
import { furnishDrawer, furnishReading } from "../instructor/drawer.js";
import { showEvaluation } from "../instructor/evaluation.js";
import { furnishExercise } from "../instructor/exercise.js";
import { listenToKeys } from "../instructor/keys.js";
import { showAboard, showLog } from "../instructor/log.js";
import { furnishOrderLine } from "../instructor/order-line.js";
import { POINTERS, showAttitude, showCharts, showTanks } from "../instructor/pictures.js";
import { showSea } from "../instructor/sea.js";
import { showShips } from "../instructor/ships.js";
import { showState } from "../instructor/state-table.js";
import { furnishTime, furnishTimeLine, toggleTime } from "../instructor/time.js";
import { WATCHES } from "../instructor/watches.js";
import { Alerts } from "../model/alerts.js";
import { Motion } from "../model/motion.js";
import { Session } from "../model/session.js";
import { plantRows } from "../plant/panel.js";
import { furnishPlant } from "../plant/window.js";
import { Link } from "../protocol/link.js";
import { say } from "../words.js";

const CHANNELS = [
  ...["motion", "gauges", "orders", "steering", "engine", "diving", "tanks", "air", "valves", "plant"],
  ...["time", "sea", "current", "casualties", "contacts", "lookout", "ledger"],
];
const AWAY = ["connecting", "lost", "role"]; // states in which nothing can be ordered

const link = new Link(document.documentElement.dataset.version ?? "");
const session = new Session(link, "instructor", CHANNELS);
const desk = new Desk(session);
const givePlant = (/** @type {string} */ words) => desk.give(words);
const motion = new Motion(session, POINTERS);

furnish(session, new Alerts(session, WATCHES));
showState(desk);
showEvaluation(desk);
showCasualties(desk);
showLog(desk);
showAboard(desk);
showSea(desk);
showShips(desk);
showTanks(desk);
showAttitude(desk, motion);
furnishPlant(session, givePlant, plantRows(session, givePlant));
furnishTime(desk);
furnishOrderLine(desk);
furnishReading(desk);
furnishCommand(desk);
const line = furnishTimeLine(desk);
furnishExercise(desk, (seconds) => line.look({ branch: null, seconds }));
listenToKeys({
  toggleTime: () => toggleTime(desk),
  step: () => void desk.give("step"),
  mark: () => void desk.give("mark"),
  span: showCharts(desk),
  drawer: furnishDrawer(desk),
  move: (by) => line.move(by),
  cause: (later) => line.stepCause(later),
  now: () => line.look(null),
});
furnishTabs();
one("#class").hidden = !/\/boat\/\d+\/instructor$/.test(location.pathname); // of a class
session.on("state", () => {
  for (const each of document.querySelectorAll("[data-link]")) {
    each.toggleAttribute("inert", AWAY.includes(session.state));
  }
});
session.start();
motion.start();

/** On a telephone one of four views is seen. */
function furnishTabs() {
  /** @type {Record<string, string>} */
  const words = { Boat: say("Boat"), Charts: say("Charts"), Track: say("Track"), Log: say("Log") };
  const names = new Set([...document.querySelectorAll("[data-tab]")].map(tabOf));
  const choose = (/** @type {string} */ name) => {
    document.body.dataset.view = name;
    for (const [at, key] of [...one("#tabs").children].entries()) {
      key.setAttribute("aria-pressed", String([...names][at] === name));
    }
    for (const panel of document.querySelectorAll("[data-tab]")) {
      panel.toggleAttribute("data-away", tabOf(panel) !== name);
    }
  };
  one("#tabs").append(
    ...[...names].map((name) => html("button", { type: "button", click: () => choose(name) }, words[name])),
  );
  choose("Boat");
}

/** @param {Element} panel */
function tabOf(panel) {
  return /** @type {HTMLElement} */ (panel).dataset.tab ?? "";
}

// Observer: all instruments and no controls; one key marks a moment.
import "../charts/strip-chart.js";
import "../controls/part-keys.js";
import "../tanks/tank-mimic.js";
import { Alerts } from "../model/alerts.js";
import { Link } from "../protocol/link.js";
import { Session } from "../model/session.js";
import { drawPlots } from "../charts/plots.js";
import { plantRows } from "../plant/panel.js";
import { furnishPlant } from "../plant/window.js";
import { limitsOf } from "../model/limits.js";
import { furnish, orderedLine } from "../frame.js";
import { giver, seldom, showReadouts } from "./readouts.js";
import { showInstruments } from "./instruments.js";
import { showTanks } from "../tanks/panel.js";
import { one, write } from "../draw.js";
import { keepLog } from "../crew/log-lines.js";
import { say } from "../words.js";

const SPAN = 300; // [s] of the charts
/** Where each chart's quantity is shown, and where its order stands. */
const PLOTTED = {
  depth: ["gauges.depth", "orders.depth", "diving.ordered_depth"],
  pitch: ["gauges.pitch", "orders.pitch"],
  speed: ["gauges.speed", "orders.speed", "engine.ordered_speed"],
  stern: ["diving.stern", "diving.ordered_stern"],
  bow: ["diving.bow", "diving.ordered_bow"],
  rudder: ["steering.rudder", "steering.ordered_rudder"],
};
const PANELS = ["steering", "engine", "diving", "tanks", "air", "valves", "plant"];
const CHANNELS = ["gauges", "orders", ...PANELS, "time"];

const link = new Link(document.documentElement.dataset.version ?? "");
const session = new Session(link, "observer", CHANNELS);
furnish(session, new Alerts(session));
/** @type {any} */ (one("part-keys")).parts = [
  ["boat", say("Boat")],
  ["surfaces", say("Planes")],
  ["charts", say("Charts")],
  ["tanks", say("Tanks")],
  ["log", say("Log")],
];
write(one("#plots-span"), say("last {0} minutes", SPAN / 60));
const give = giver(session);
furnishPlant(session, give, plantRows(session, give));
const form = /** @type {HTMLFormElement} */ (one("#mark"));
form.onsubmit = async (/** @type {SubmitEvent} */ event) => {
  event.preventDefault();
  const field = /** @type {HTMLInputElement} */ (one("input", form));
  const remark = field.value.trim();
  if (!(await give(`mark ${remark}`.trim()))) return;
  session.note("mark", say("mark by observer: {0}", remark)); // the session tells it to all but this line
  field.value = "";
};

const show = seldom(() => {
  write(one("#ordered"), orderedLine(session));
  showReadouts(session);
  showTanks(session);
  drawPlots(session, PLOTTED, SPAN, limitsOf(session).depth);
});
for (const what of ["tick", "ranges", "crew"]) session.on(what, show);
one("tank-mimic").addEventListener("choose", show);
keepLog(session);
showInstruments(session);
session.start();

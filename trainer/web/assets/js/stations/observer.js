// Observer: all instruments and no controls; one key marks a moment.
import "../controls/part-keys.js";
import "../tanks/tank-mimic.js";
import { Alerts } from "../model/alerts.js";
import { Link } from "../protocol/link.js";
import { Session } from "../model/session.js";
import { furnish, orderedLine } from "../frame.js";
import { giver, seldom, showReadouts } from "./readouts.js";
import { plain } from "../protocol/line.js";
import { showInstruments } from "./instruments.js";
import { showTanks } from "../tanks/panel.js";
import { clock, html, one, write } from "../draw.js";

const SHOWN = 60; // entries of the log
const PANELS = ["steering", "engine", "diving", "tanks", "air", "valves"];
const CHANNELS = ["gauges", "orders", ...PANELS, "time"];

const link = new Link(document.documentElement.dataset.version ?? "");
const session = new Session(link, "observer", CHANNELS);
furnish(session, new Alerts(session));
/** @type {any} */ (one("part-keys")).parts = [
  ["boat", "Boat"],
  ["surfaces", "Planes"],
  ["tanks", "Tanks"],
  ["log", "Log"],
];
const give = giver(session);
const form = /** @type {HTMLFormElement} */ (one("#mark"));
form.onsubmit = async (/** @type {SubmitEvent} */ event) => {
  event.preventDefault();
  const field = /** @type {HTMLInputElement} */ (one("input", form));
  const remark = plain(field.value);
  if (!(await give(`mark ${remark}`.trim()))) return;
  session.note("mark", `mark by observer: ${remark}`); // the session tells it to all but this line
  field.value = "";
};

const show = seldom(() => {
  write(one("#ordered"), orderedLine(session));
  showReadouts(session);
  showTanks(session);
});
for (const what of ["tick", "ranges", "crew"]) session.on(what, show);
one("tank-mimic").addEventListener("choose", show);
session.on("log", () => {
  const list = one("#log");
  const entries = session.log.slice(-SHOWN);
  list.replaceChildren(
    ...entries.map(({ seconds, text }) =>
      html("li", {}, html("time", {}, clock(seconds)), html("span", {}, text)),
    ),
  );
  list.scrollTop = list.scrollHeight;
});
showInstruments(session);
session.start();

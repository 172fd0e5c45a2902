// Ballast: the tanks, their valves and pumps, and the air that empties them.
import "../controls/emergency-cover.js";
import "../controls/part-keys.js";
import "../controls/position-switch.js";
import "../controls/pump-keys.js";
import "../crew/repeat-bar.js";
import "../crew/report-bar.js";
import "../tanks/balance-bar.js";
import "../tanks/tank-mimic.js";
import { Alerts, bankWatch } from "../model/alerts.js";
import { Link } from "../protocol/link.js";
import { Session } from "../model/session.js";
import { plantRows } from "../plant/panel.js";
import { furnishPlant } from "../plant/window.js";
import { TankPanel } from "../tanks/panel.js";
import { furnish, orderedLine } from "../frame.js";
import { giver, seldom, showReadouts } from "./readouts.js";
import { one, write } from "../draw.js";
import { say } from "../words.js";

const CHANNELS = ["gauges", "orders", "tanks", "air", "valves", "plant", "time"];

const link = new Link(document.documentElement.dataset.version ?? "");
const session = new Session(link, "ballast", CHANNELS);
const watches = [
  bankWatch(say("Main air bank"), "air.main_full"),
  bankWatch(say("Emergency air bank"), "air.emergency_full"),
];
furnish(session, new Alerts(session, watches));
for (const bar of ["repeat-bar", "report-bar"]) /** @type {any} */ (one(bar)).bind(session);
const give = giver(session);
const panel = new TankPanel(session, give);
furnishPlant(session, give, plantRows(session, give));

const show = seldom(() => {
  write(one("#ordered"), orderedLine(session));
  showReadouts(session);
  panel.show();
});
for (const what of ["tick", "ranges", "crew"]) session.on(what, show);
session.start();

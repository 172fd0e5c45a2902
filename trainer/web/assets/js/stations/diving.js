// Diving officer: depth and bubble, what the planes hold, tanks, and orders to the crew. The officer
// of the deck has course, depth and orders alone.
import "../controls/emergency-cover.js";
import "../controls/order-keypad.js";
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
import { furnishSafeDepth } from "../safe/safe-depth.js";
import { TankPanel } from "../tanks/panel.js";
import { furnish, orderedLine } from "../frame.js";
import { furnishOrders, showStanding } from "../crew/orders.js";
import { giver, seldom, showReadouts } from "./readouts.js";
import { showInstruments } from "./instruments.js";
import { showHeld } from "../crew/held.js";
import { one, write } from "../draw.js";
import { say } from "../words.js";

const DIVES = document.body.dataset.role === "diving";
const CHANNELS = ["gauges", "orders", ...(DIVES ? ["diving", "tanks", "air", "valves", "plant", "safe"] : []), "time"];

const link = new Link(document.documentElement.dataset.version ?? "");
const session = new Session(link, DIVES ? "diving" : "deck", CHANNELS);
const watches = [
  bankWatch(say("Main air bank"), "air.main_full"),
  bankWatch(say("Emergency air bank"), "air.emergency_full"),
];
furnish(session, new Alerts(session, DIVES ? watches : []));
for (const bar of ["repeat-bar", "report-bar"]) /** @type {any} */ (one(bar)).bind(session);
/** @type {any} */ (one("part-keys[part=part]")).parts = [
  ["boat", say("Boat")],
  ["crew", say("Orders")],
  ["tanks", DIVES ? say("Tanks") : say("Course")],
];
const give = giver(session);
const panel = DIVES ? new TankPanel(session, give) : null;
furnishOrders(session, give);
if (DIVES) furnishPlant(session, give, plantRows(session, give));
if (DIVES) furnishSafeDepth(session);

const show = seldom(() => {
  write(one("#ordered"), orderedLine(session));
  showReadouts(session);
  if (DIVES) showHeld(session);
  showStanding(session, give);
  panel?.show();
});
for (const what of ["tick", "ranges", "crew", "log"]) session.on(what, show);
showInstruments(session);
session.start();

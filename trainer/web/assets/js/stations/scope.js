// Periscope: the mast, the view, bearings, ranges and marks of what is seen.
import "../crew/repeat-bar.js";
import "../crew/report-bar.js";
import "../scope/scope-view.js";
import { Alerts } from "../model/alerts.js";
import { Link } from "../protocol/link.js";
import { Motion } from "../model/motion.js";
import { Pending } from "../model/pending.js";
import { Session } from "../model/session.js";
import { bearing, one, write } from "../draw.js";
import { furnish, isTyping, orderedLine } from "../frame.js";
import { giver, seldom } from "./readouts.js";
import { paced } from "../instructor/desk.js";
import { lengthOf } from "../units.js";
import { decimals, say } from "../words.js";

/** @typedef {import("../scope/ships.js").Sight} Sight */

const CHANNELS = ["scope", "swell", "gauges", "orders", "time"];
const DEGREE = Math.PI / 180;
const MINUTE = DEGREE / 60;
const SHIPS = 10; // that the session tells
const PICTURE = 66; // [ms] between pictures: fifteen a second
const ORDERS = 330; // [ms] between orders to train
/** @type {Record<string, number>} [deg] that one key of the arrows trains, by power */
const STEPS = { 1.5: 1, 6: 0.2 };
/** @type {Record<string, string>} what the mast does */
const GOING = { raising: say("raising"), lowering: say("lowering"), stopped: say("stopped"), up: say("up"), down: say("down") };
const FASTEST = { head: 6, turn: 7.1 }; // [m/s] [deg/s] of the boat

const session = new Session(new Link(document.documentElement.dataset.version ?? ""), "scope", CHANNELS);
furnish(session, new Alerts(session));
for (const bar of ["repeat-bar", "report-bar"]) /** @type {any} */ (one(bar)).bind(session);
const give = giver(session);
const pending = new Pending(session, "scope");
/** @type {any} */
const view = one("scope-view");
/** @type {Sight[]} */
let ships = [];

const motion = new Motion(session, {
  head: { place: "swell.head", most: FASTEST.head },
  pitch: { place: "swell.pitch", most: FASTEST.turn },
  heel: { place: "swell.heel", most: FASTEST.turn },
  heading: { place: "gauges.heading", most: FASTEST.turn, turns: true },
});

/** @type {number | null} where it is to be trained [deg], until that is ordered */
let aim = null;

/** Where the scope points off the bow [deg], as ordered here or as it stands. */
function trained() {
  const stands = session.number("scope.train") ?? 0;
  return aim ?? Number(pending.resolve("train", round(stands)));
}

/** Returns an angle from 0 to 360 in tenths. @param {number} degrees */
function round(degrees) {
  return (Math.round(10 * ((degrees % 360) + 360)) / 10) % 360;
}

const sendTrain = paced(ORDERS, async () => {
  const wanted = trained();
  pending.give("train", wanted);
  aim = null;
  pending.answered("train", await give(`scope train ${wanted}`));
});

/** Trains the scope to an angle off the bow. @param {number} degrees */
function train(degrees) {
  if (!session.live || !fitted()) return;
  aim = round(degrees);
  sendTrain();
  draw();
}

/** Whether the boat has a periscope. */
function fitted() {
  return session.word("scope.going") !== "";
}

for (const key of document.querySelectorAll("[data-scope]")) {
  const { scope = "" } = /** @type {HTMLElement} */ (key).dataset;
  key.addEventListener("click", () => void give(`scope ${scope}`));
}
for (const key of document.querySelectorAll("[data-power]")) {
  const { power = "" } = /** @type {HTMLElement} */ (key).dataset;
  key.addEventListener("click", () => void give(`scope power ${power}`));
}
for (const key of document.querySelectorAll("[data-train]")) {
  const { train: by = "" } = /** @type {HTMLElement} */ (key).dataset;
  key.addEventListener("click", () => train(by === "ahead" ? 0 : trained() + Number(by)));
}
const form = /** @type {HTMLFormElement} */ (one("#range"));
/** @type {HTMLSelectElement} */ (one("select", form)).onchange = ({ target }) => {
  const { value } = /** @type {HTMLSelectElement} */ (target);
  const height = /** @type {HTMLInputElement} */ (one("input", form));
  if (value) height.value = value;
};
form.onsubmit = async (/** @type {SubmitEvent} */ event) => {
  event.preventDefault();
  const height = /** @type {HTMLInputElement} */ (one("input", form)).valueAsNumber;
  const answer = await session.order(`scope range ${height}`);
  write(one("#ranged"), answer.ok ? answer.text : say("No range: {0}", answer.text));
};
one("#mark").onclick = () => void give(`mark contact ${bearing(bearingNow())}`);

/** The bearing under the wire by the gyro [deg]. */
function bearingNow() {
  const stands = session.number("scope.bearing") ?? 0;
  return round(stands + trained() - (session.number("scope.train") ?? 0));
}

/** @type {Record<string, () => void>} */
const KEYS = {
  ArrowLeft: () => train(trained() - step()),
  ArrowRight: () => train(trained() + step()),
  Home: () => train(0),
};
const step = () => STEPS[session.word("scope.power") === "6.0" ? 6 : 1.5];
addEventListener("keydown", (event) => {
  if (isTyping(event) || !(event.key in KEYS)) return;
  event.preventDefault();
  const far = event.shiftKey && event.key !== "Home";
  if (far) train(trained() + (event.key === "ArrowLeft" ? -10 : 10) * step());
  else KEYS[event.key]();
});

/** @type {{ x: number, train: number } | null} where a hand has taken the view */
let held = null;
view.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => {
  held = { x: event.clientX, train: trained() };
  view.setPointerCapture(event.pointerId);
});
view.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
  if (!held) return;
  const { width, height } = view.getBoundingClientRect();
  const field = session.word("scope.power") === "6.0" ? 8 : 32;
  train(held.train - ((event.clientX - held.x) / Math.min(width, height)) * field);
});
for (const over of ["pointerup", "pointercancel"]) view.addEventListener(over, () => (held = null));

/** Reads the ships in sight. @returns {Sight[]} */
function read() {
  const found = [];
  for (let place = 1; place <= SHIPS; place++) {
    const name = `scope.ship_${place}`;
    const type = session.word(name);
    if (!type) break;
    const angle = (/** @type {string} */ part, /** @type {number} */ unit) =>
      (session.number(`${name}_${part}`) ?? 0) * unit;
    found.push({
      ...{ type, train: angle("train", DEGREE), aspect: angle("aspect", DEGREE) },
      ...{ bottom: angle("bottom", MINUTE), top: angle("top", MINUTE), span: angle("span", MINUTE) },
      lights: session.word(`${name}_lights`).split(" ").filter(Boolean).map(lightOf),
    });
  }
  return found;
}

/** @param {string} text colour, beside and elevation @returns {[string, number, number]} */
function lightOf(text) {
  const [colour, beside, elevation] = text.split(":");
  return [colour, Number(beside) * MINUTE, Number(elevation) * MINUTE];
}

/** Returns what is said where nothing is seen. */
function dark() {
  if (!session.tickAt) return "";
  if (!fitted()) return say("This boat has no periscope");
  const going = session.word("scope.going");
  return going === "raising" ? say("Raising") : going === "lowering" ? say("Lowering") : say("Scope down");
}

/** Draws the view as it is now. */
function draw() {
  const later = motion.ahead(performance.now());
  const { head, pitch, heel, heading } = motion.shown;
  view.sea.run(later);
  const swung = (heading ?? 0) - (session.number("gauges.heading") ?? 0);
  const at = trained() * DEGREE;
  const tilt = (heel ?? 0) * Math.cos(at) - (pitch ?? 0) * Math.sin(at);
  view.show({
    ...{ view: session.word("scope.view"), words: dark(), power: session.number("scope.power") ?? 1.5 },
    ...{ train: at + swung * DEGREE, bearing: bearingNow() + swung, head: head ?? 0 },
    light: session.exercise.light ?? "day",
    ...{ roll: motion.calm.matches ? 0 : -tilt * DEGREE, ships, still: motion.calm.matches },
    seconds: (session.readings.latest.get("swell")?.seconds ?? 0) + later,
  });
}

const show = seldom(() => {
  const mast = session.number("scope.mast");
  write(one("#ordered"), orderedLine(session) && say("Ordered: {0}", orderedLine(session)));
  write(one("#mast"), mast === null ? "" : say("{0}, {1} out", GOING[session.word("scope.going")] ?? session.word("scope.going"), lengthOf(mast)));
  write(one("#bearing"), fitted() ? bearing(bearingNow()) : "");
  write(one("#train"), fitted() ? sideOf(trained()) : "");
  for (const key of document.querySelectorAll("[data-power]")) {
    const { power = "" } = /** @type {HTMLElement} */ (key).dataset;
    key.setAttribute("aria-pressed", String(Number(power) === session.number("scope.power")));
  }
  view.setAttribute("aria-label", spoken());
});

/** Returns an angle off the bow in words. @param {number} degrees */
function sideOf(degrees) {
  const side = degrees > 180 ? say("{0} left", decimals(360 - degrees, 1)) : say("{0} right", decimals(degrees, 1));
  return degrees === 0 ? say("ahead") : side;
}

/** Returns what is seen, in words. */
function spoken() {
  if (["", "down"].includes(session.word("scope.view"))) return dark() || say("View through the periscope");
  const under = session.word("scope.view") === "washed" ? say("washed over, ") : "";
  const seen = session.word("scope.sighted").replaceAll(";", ",") || say("no ship in sight");
  return say("View through the periscope on {0}: {1}", bearing(bearingNow()), `${under}${seen}`);
}

session.on("reading", (event) => {
  const { channel } = /** @type {CustomEvent} */ (event).detail;
  if (channel === "swell") view.sea.take(session);
  if (channel === "scope") ships = read();
});
session.on("tick", () => {
  show();
  if (motion.calm.matches) draw();
});
motion.addEventListener("frame", () => {
  if (!motion.calm.matches) draw();
});
motion.start(PICTURE);
session.start();

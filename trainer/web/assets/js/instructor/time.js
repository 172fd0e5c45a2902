// Time: its keys, and the time line, which looks back, watches again and takes over.
import { html, one, write } from "../draw.js";
import { lanes } from "../model/branches.js";
import { causesOf } from "../model/causes.js";
import { wordOf } from "../model/orders.js";
import { paced } from "./desk.js";
import { say } from "../words.js";

/**
 * @typedef {import("./desk.js").Desk} Desk
 * @typedef {import("../controls/time-line.js").TimeLine} TimeLine
 * @typedef {import("../controls/time-line.js").Look} Look
 */

const PACES = [1, 2, 4, 10];
const SHORTEST = 600; // [s] of the line, where an exercise has no end
const ROOM = 1.15; // beyond what was flown
const WHOLE = 300; // [s]
const TICK = 0.1; // [s] the shortest way back that an order knows
const DRAWN = 200; // [ms]

/** Furnishes the keys of time. @param {Desk} desk */
export function furnishTime(desk) {
  const { session } = desk;
  const keys = PACES.map((pace) =>
    html("button", { type: "button", "data-pace": pace, click: () => void desk.give(`time ${pace}`) }, `x${pace}`),
  );
  one("#pace").append(...keys);
  one("#freeze").onclick = () => toggleTime(desk);
  one("#step").onclick = () => void desk.give("step");
  const show = () => {
    const stands = session.word("time.time") === "frozen";
    write(one("#freeze"), stands ? say("Run") : say("Freeze"));
    one("#freeze").toggleAttribute("disabled", !session.may(stands ? "run" : "freeze"));
    one("#step").toggleAttribute("disabled", !session.may("step"));
    for (const key of keys) {
      key.setAttribute("aria-pressed", String(Number(key.dataset.pace) === session.pace));
    }
  };
  for (const what of ["tick", "state"]) session.on(what, show);
}

/** Stops time, or lets it go on. @param {Desk} desk */
export function toggleTime(desk) {
  void desk.give(desk.session.word("time.time") === "frozen" ? "run" : "freeze");
}

/** Furnishes the time line. @param {Desk} desk */
export function furnishTimeLine(desk) {
  const { session, moment } = desk;
  const line = /** @type {TimeLine} */ (one("time-line"));
  const draw = paced(DRAWN, () => {
    const now = session.seconds;
    const left = lanes(session.branches, session.present);
    const replaying = session.state === "replay";
    const signs = [...session.signs.kept, ...planned(session)];
    line.show({ now, end: endOf(desk, left), signs, causes: causesOf(session, moment.looking?.branch), lanes: left, replaying });
  });
  for (const what of ["tick", "line", "log", "state", "exercise"]) session.on(what, draw);
  moment.addEventListener("look", draw);
  session.on("tick", () => learnBranch(desk));
  session.onFacts({ back: () => line.look(null), next: () => line.look(null) });
  line.addEventListener("look", (event) => moment.look(/** @type {CustomEvent} */ (event).detail));
  line.addEventListener("deed", (event) => {
    const watch = /** @type {CustomEvent} */ (event).detail === "watch";
    void (watch ? watchAgain(desk) : takeOver(desk)).then((done) => done && line.look(null));
  });
  return line;
}

/** Asks for the branches when one has begun that nobody told: by a replay taken over. @param {Desk} desk */
function learnBranch({ session }) {
  const number = session.number("time.branch");
  if (number === null || session.branches.has(number) || asked.has(number)) return;
  asked.add(number);
  void session.ask("branches").then(() => asked.delete(number));
}
/** @type {Set<number>} branches that have been asked for */
const asked = new Set();

/** Returns the signs of what is to come at a time. @param {import("../model/session.js").Session} session */
function planned({ plans }) {
  return plans
    .filter(({ seconds }) => !Number.isNaN(seconds))
    .map(({ seconds, text }) => ({ seconds, sign: wordOf(text) === "casualty" ? "P" : "p", text }));
}

/** Returns how long the line is [s]. @param {Desk} desk @param {{ to: number }[]} left */
function endOf({ session }, left) {
  const ahead = planned(session).map(({ seconds }) => seconds);
  const flown = Math.max(session.furthest, session.seconds, ...left.map(({ to }) => to), ...ahead);
  const length = Number(session.exercise.duration ?? 0);
  if (length >= flown && length > 0) return length;
  return Math.max(SHORTEST, Math.ceil((flown * ROOM) / WHOLE) * WHOLE);
}

/** Goes to the moment that is looked at; time stands still there. @param {Desk} desk */
export async function takeOver(desk) {
  const { session, moment } = desk;
  const { looking } = moment;
  if (session.state === "replay") {
    const answer = await desk.give("take over");
    if (!answer.ok || !looking) return answer.ok;
  }
  if (!looking) return false;
  const lapse = await lapseTo(desk, looking);
  if (lapse === null) return false;
  if (looking.branch === null && looking.seconds <= 0) return (await desk.give("reset")).ok;
  return lapse < TICK || (await desk.give(`backtrack ${lapse}`)).ok;
}

/** Watches again from the moment that is looked at. @param {Desk} desk */
export async function watchAgain(desk) {
  const { looking } = desk.moment;
  if (!looking) return false;
  if (desk.session.state === "replay" && !(await desk.give("take over")).ok) return false;
  const lapse = await lapseTo(desk, looking);
  return lapse !== null && (await desk.give(`replay ${Math.max(lapse, TICK)}`)).ok;
}

/**
 * Has time stand still where that moment can be reached from; returns how far back it is [s].
 * @param {Desk} desk
 * @param {Look} look
 */
export async function lapseTo(desk, { branch, seconds }) {
  const still = await desk.give(branch === null ? "freeze" : `branch ${branch}`);
  if (!still.ok) return null;
  await desk.session.ask("branches");
  const { branches, present } = desk.session;
  const now = branches.get(present)?.last ?? desk.session.seconds;
  return Number(Math.max(now - seconds, 0).toFixed(3));
}

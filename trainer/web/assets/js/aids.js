// The way shown, the ghost and the predictor on a page: their keys, and in words how far off and where to.
import { bearing, html, write } from "./draw.js";
import { lengthOf } from "./units.js";
import { decimals, say } from "./words.js";

/** @typedef {import("./model/session.js").Session} Session */

const CHANNELS = ["ghost", "predictor"];
const AHEAD = 60; // [s] that the key asks for

/** Furnishes the line of the aids. @param {Session} session */
export function furnishAids(session) {
  const bar = document.querySelector("#aids");
  if (!(bar instanceof HTMLElement)) return;
  let joined = false;
  session.on("state", () => {
    const asks = session.joined && !joined && !session.alone; // a page by mail has no aids
    for (const channel of asks ? CHANNELS : []) void session.ask(`subscribe ${channel}`);
    joined = session.joined;
  });
  const answer = html("span", { role: "status" });
  const off = html("span", { class: "quiet", id: "off-ghost" });
  const ahead = html("span", { class: "quiet", id: "way-ahead" });
  const give = async (/** @type {string} */ words) => {
    const { ok, text } = await session.order(words);
    write(answer, ok ? "" : text);
  };
  const hear = async (/** @type {string} */ words) => write(answer, (await session.order(words)).text);
  const isShown = () => session.word("time.shown") === "yes";
  const has = (/** @type {string} */ aid) => session.number(`${aid}.depth`) !== null;
  const type = "button";
  const way = html("button", { type, id: "show-way", click: () => void give(isShown() ? "demonstrate off" : "demonstrate") });
  const ghost = html("button", { type, id: "ghost", click: () => void give(`ghost ${has("ghost") ? "off" : "on"}`) });
  const ask = () => void give(has("predictor") ? "predictor off" : `predictor ${AHEAD} s`);
  const predictor = html("button", { type, id: "predictor", click: ask });
  const hint = html("button", { type, id: "hint", click: () => void hear("hint") });
  bar.append(way, ghost, predictor, hint, off, ahead, answer);
  let seen = false; // the ghost, whose past is asked for when it comes
  const show = () => {
    if (has("ghost") && !seen && !session.alone) recallGhost(session);
    seen = has("ghost");
    const allowed = (session.exercise.aids ?? "").split(",");
    const stands = session.word("time.time") === "frozen";
    write(way, isShown() ? say("Back from the way shown") : say("Show the way"));
    way.hidden = !session.exercise.way || !session.may("demonstrate") || !(stands || isShown());
    for (const [aid, each, name] of /** @type {[string, HTMLElement, string][]} */ ([
      ["ghost", ghost, say("Ghost")],
      ["predictor", predictor, say("Predictor")],
    ])) {
      write(each, name);
      each.hidden = !allowed.includes(aid) || !session.may(aid);
      each.setAttribute("aria-pressed", String(has(aid)));
    }
    const price = session.exercise.hint;
    write(hint, price ? say("Hint: {0} marks", price) : "");
    hint.hidden = !price || !session.may("hint");
    write(off, has("ghost") ? offGhost(session) : "");
    write(ahead, has("predictor") ? wayAhead(session) : "");
    bar.hidden = [way, ghost, predictor, hint].every(({ hidden }) => hidden) && !off.textContent && !ahead.textContent;
  };
  for (const what of ["tick", "state", "exercise"]) session.on(what, show);
  show();
}

/** Asks for the ghost's past, which was not shown while it was off. @param {Session} session */
function recallGhost(session) {
  session.history.channels.delete("ghost");
  void session.ask("history ghost 60 min");
}

/** Returns how far the boat is from the ghost. @param {Session} session */
function offGhost(session) {
  const [depth, heading, pitch] = ["depth", "heading", "pitch"].map((name) => session.number(`ghost.${name}_off`) ?? 0);
  const size = lengthOf(Math.abs(depth), 1);
  const turned = decimals(Math.abs(heading), 1);
  return [
    depth > 0 ? say("{0} deeper than the ghost", size) : say("{0} higher than the ghost", size),
    heading > 0 ? say("{0} degrees right of it", turned) : say("{0} degrees left of it", turned),
    inclined(pitch),
  ].join(", ");
}

/** Returns where the boat goes. @param {Session} session */
function wayAhead(session) {
  const number = (/** @type {string} */ name) => session.number(`predictor.${name}`) ?? 0;
  const there = [lengthOf(number("depth"), 1), bearing(number("heading")), inclined(number("pitch"))];
  return say("in {0} s: {1}", number("seconds"), there.join(", "));
}

/** @param {number} pitch [deg] */
function inclined(pitch) {
  const size = decimals(Math.abs(pitch), 1);
  return pitch < 0 ? say("{0} degrees down", size) : say("{0} degrees up", size);
}

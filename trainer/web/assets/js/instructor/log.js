// The log: what has happened, who has ordered it, and what the page was refused; and who is aboard.
import { clock, html, one, write } from "../draw.js";
import { paced } from "./desk.js";
import { say } from "../words.js";

/**
 * @typedef {import("./desk.js").Desk} Desk
 * @typedef {import("../model/session.js").Entry} Entry
 * @typedef {import("../model/stations.js").Aboard} Aboard
 */

const SHOWN = 150; // entries
const PACE = 250; // [ms]
const CHOOSER = "chooser"; // what the first page is called: nobody is aboard by it

/** Fills the log up to the moment, newest first; who comes and goes by a key. @param {Desk} desk */
export function showLog({ session, moment }) {
  const [list, comings] = [one("#log"), one("#log-stations")];
  const draw = paced(PACE, () => {
    const at = list.scrollTop;
    const all = comings.getAttribute("aria-pressed") === "true";
    const told = all ? moment.log : moment.log.filter(({ kind }) => kind !== "station");
    list.replaceChildren(...told.slice(-SHOWN).reverse().map(entryRow));
    list.scrollTop = at;
  });
  comings.onclick = () => {
    comings.setAttribute("aria-pressed", String(comings.getAttribute("aria-pressed") !== "true"));
    draw();
  };
  session.on("log", draw);
  moment.addEventListener("look", draw);
}

/** @param {Entry} entry */
function entryRow(entry) {
  const { who, words } = tellOf(entry);
  const parts = [html("time", {}, clock(entry.seconds)), html("span", { class: "who" }, who)];
  return html("li", { "data-kind": entry.kind }, ...parts, html("span", { class: "grow" }, words));
}

/** Returns who has said or done something, and what. @param {Entry} entry */
export function tellOf({ kind, text, speaker, words }) {
  return speaker ? { who: speaker, words } : { who: kind, words: text };
}

/** Tells who is aboard whenever somebody comes or goes. @param {Desk} desk */
export function showAboard(desk) {
  const { session } = desk;
  const ask = paced(1000, () => {
    void askAboard(desk).then((stations) => {
      const crew = stations.map(({ role }) => role).filter((role) => role !== "instructor");
      const others = stations.length - crew.length - 1;
      const more = others > 1 ? say("{0} more instructors", others) : say("{0} more instructor", others);
      const there = [...new Set(crew), ...(others > 0 ? [more] : [])].join(", ");
      write(one("#aboard"), there ? say("{0} aboard", there) : say("no station aboard"));
    });
  });
  onArrival(desk, ask);
  session.on("state", () => {
    if (session.joined) ask();
  });
}

/** Calls whenever somebody has come or gone. @param {{ session: import("../model/session.js").Session }} desk @param {() => void} call */
export function onArrival({ session }, call) {
  /** @type {Entry | undefined} */
  let known;
  session.on("log", () => {
    const last = session.log.findLast(({ kind }) => kind === "station");
    if (last !== known) call();
    known = last;
  });
}

/** Asks who is aboard. @param {Desk} desk @returns {Promise<Aboard[]>} */
export async function askAboard({ session }) {
  await session.ask("who");
  const stations = session.stations.all.filter(({ called }) => called !== CHOOSER);
  return stations.map((each) => ({ ...each, role: each.called || each.role }));
}

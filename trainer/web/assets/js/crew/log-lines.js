// What has happened, line by line, for who has no key to who comes and goes.
import { clock, html, one } from "../draw.js";

const SHOWN = 60; // entries

/** Keeps the log filled with what was last done and said, its end in sight. @param {import("../model/session.js").Session} session */
export function keepLog(session) {
  session.on("log", () => {
    const list = one("#log");
    const told = session.log.filter(({ kind }) => kind !== "station");
    list.replaceChildren(...told.slice(-SHOWN).map(entryLine));
    list.scrollTop = list.scrollHeight;
  });
}

/** Returns one entry with its time. @param {{ seconds: number, text: string }} entry */
export function entryLine({ seconds, text }) {
  return html("li", {}, html("time", {}, clock(seconds)), html("span", {}, text));
}

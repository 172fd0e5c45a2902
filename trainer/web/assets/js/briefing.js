// The briefing: what the exercise is about before it begins, how it stands, and its marks at the end.
import { CREW } from "./model/order-table.js";
import { clock, html, one, write } from "./draw.js";

/** @type {Record<string, string>} quantities of limits that have another name among people */
const NAMES = {
  cpa: "range to a ship",
  clearance: "water under the keel",
  speed_over_ground: "speed over the ground",
};

/** @typedef {import("./model/session.js").Session} Session */

/**
 * Furnishes the briefing of a station. It opens by itself before time runs, and at the end.
 * @param {Session} session
 */
export function furnishBriefing(session) {
  const dialog = /** @type {HTMLDialogElement} */ (one("#briefing"));
  const key = one("#show-briefing");
  if (!CREW.includes(session.role) && session.role !== "observer") return;
  const [close, ready] = [one("#close-briefing"), one("#ready")];
  let shown = ""; // what it has opened for by itself
  const show = () => {
    key.hidden = !session.exercise.title && !session.outcome;
    write(one("#briefing-title"), session.exercise.title ?? "Free sailing");
    one("#briefing-text").replaceChildren(...text(session));
    const begins = session.state === "frozen" && session.seconds === 0;
    ready.hidden = !begins || !session.may("ready");
    const why = session.outcome ? "end" : begins && session.exercise.title ? "begin" : "";
    if (why && shown !== `${why} ${session.exercise.title}` && !dialog.open) {
      shown = `${why} ${session.exercise.title}`;
      dialog.show();
    }
    if (!why && session.state === "running" && shown.startsWith("begin") && dialog.open) {
      dialog.close();
      shown = "running";
    }
  };
  key.onclick = () => (dialog.open ? dialog.close() : dialog.show());
  close.onclick = () => dialog.close();
  ready.onclick = async () => {
    const { ok } = await session.order("ready");
    if (ok) dialog.close();
  };
  addEventListener("keydown", (event) => {
    if (event.key === "Escape" && dialog.open) dialog.close();
    if (event.key !== "F1") return;
    event.preventDefault();
    key.click();
  });
  for (const what of ["exercise", "marks", "state"]) session.on(what, show);
}

/** Returns the briefing, or how it ended. @param {Session} session */
function text(session) {
  const { exercise, told, outcome, judgement } = session;
  const parts = [];
  if (outcome) parts.push(html("p", { class: "outcome" }, `The exercise is over: ${outcome}.`));
  if (outcome && !judgement.marks) parts.push(html("p", {}, "The instructor has the marks first."));
  parts.push(...judgement.lines.map((line) => html("p", {}, line)));
  parts.push(...(told.line ?? []).map((line) => html("p", {}, line)));
  const facts = [
    ["By hand", (exercise.hand ?? "").replaceAll(",", ", ")],
    ["Won by", (told.wins ?? []).join("; ")],
    ["Lost by", (told.lost ?? []).join("; ")],
    ["Limits", limitsInWords(exercise.limits)],
    ["Length", exercise.duration ? clock(Number(exercise.duration)) : ""],
  ];
  const rows = facts
    .filter(([, what]) => what)
    .flatMap(([name, what]) => [html("dt", {}, name), html("dd", {}, what)]);
  if (rows.length) parts.push(html("dl", {}, ...rows));
  return parts;
}

/** Returns limits such as `depth_m_max:130,pitch_deg_max:15` in words. @param {string} [told] */
export function limitsInWords(told = "") {
  return told.split(",").map(limit).filter(Boolean).join(", ");
}

/** Returns a limit such as `depth_m_max:130` in words. @param {string} told */
function limit(told) {
  const [name, value] = told.split(":");
  const parts = name.split("_");
  const [unit, end] = parts.splice(-2);
  if (!value) return "";
  const what = NAMES[parts.join("_")] ?? parts.join(" ");
  return `${what} at ${end === "min" ? "least" : "most"} ${value}${unit === "level" ? "" : ` ${unit}`}`;
}

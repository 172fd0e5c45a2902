// The briefing: what the exercise is about before it begins, how it stands, and its marks at the end.
import { CREW } from "./model/order-table.js";
import { clock, html, one, write } from "./draw.js";
import { outcomeOf } from "./model/judgement.js";
import { shortLength } from "./units.js";
import { say } from "./words.js";

/** @type {Record<string, string>} quantities of limits, as people say them */
const NAMES = {
  depth: say("depth"),
  pitch: say("pitch"),
  heel: say("heel"),
  speed: say("speed"),
  cpa: say("range to a ship"),
  clearance: say("water under the keel"),
  speed_over_ground: say("speed over the ground"),
};
const LONG_LINE = 60; // [letters] from which a line of a text ended because its page was full
/** @type {Record<string, string>} */
const UNITS = { deg: say("deg") };

/** @type {Record<string, (bound: string) => string>} by quantity and side */
const LOSSES = {
  "depth>": (bound) => say("deeper than {0}", bound),
  "depth<": (bound) => say("shallower than {0}", bound),
  "speed>": (bound) => say("faster than {0}", bound),
  "speed<": (bound) => say("slower than {0}", bound),
  "time>": (bound) => say("after {0}", bound),
  "time<": (bound) => say("before {0}", bound),
  "clearance<": (bound) => say("less than {0} of water under the keel", bound),
};
/** @type {Record<string, string>} of a condition that names no unit */
const FIRST_UNITS = { speed: "kn", speed_over_ground: "kn", pitch: "deg", heel: "deg", time: "s" };
const LOSS = /^([a-z][a-z_]*?)(?:_(kn|m_s|m|ft|deg|s|min))?\s*([<>])=?\s*([-+.\de]+)\s*(\S*)$/i;

/** @typedef {import("./model/session.js").Session} Session */

/**
 * Furnishes the briefing of a station. It opens by itself before time runs, at the end, and when the
 * marks come. It goes as soon as time runs or the end is undone: nothing lies over a running boat.
 * @param {Session} session
 */
export function furnishBriefing(session) {
  const dialog = /** @type {HTMLDialogElement} */ (one("#briefing"));
  const key = one("#show-briefing");
  if (!CREW.includes(session.role) && session.role !== "observer") return;
  const trains = session.role === "trainee"; // alone: nobody else begins or goes on
  const [close, ready] = [one("#close-briefing"), one("#ready")];
  let [shown, of] = ["", ""]; // for what it has opened by itself, and of which exercise
  const show = () => {
    key.hidden = !session.exercise.title && !session.outcome && !trains;
    const { title = "" } = session.exercise;
    write(one("#briefing-title"), title || (trains ? say("What do you want to train?") : say("Free sailing")));
    one("#briefing-text").replaceChildren(...text(session));
    const begins = session.state === "frozen" && session.seconds === 0;
    ready.hidden = !begins || trains || !session.may("ready");
    const end = session.judgement.marks ? "marks" : "end";
    const why = session.outcome ? end : begins && (title || trains) ? "begin" : "";
    if (why && (shown !== why || of !== title)) {
      [shown, of] = [why, title];
      dialog.show();
    }
    if (!why && shown && (shown !== "begin" || session.state === "running")) {
      shown = "";
      dialog.close();
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
  if (outcome) parts.push(html("p", { class: "outcome" }, say("The exercise is over: {0}.", outcomeOf(outcome))));
  if (outcome && exercise.steps) parts.push(html("p", {}, say("Lessons have no marks.")));
  else if (outcome && !judgement.marks) parts.push(html("p", {}, marksToCome(session)));
  if (!exercise.steps) parts.push(...judgement.lines.map((line) => html("p", {}, line)));
  parts.push(...paragraphs(told.line ?? []).map((line) => html("p", {}, line)));
  const facts = [
    [say("By hand"), (exercise.hand ?? "").replaceAll(",", ", ")],
    [say("Won by"), (told.wins ?? []).join("; ")],
    [say("Lost by"), (told.lost ?? []).map(lossInWords).join("; ")],
    [say("Limits"), limitsInWords(exercise.limits)],
    [say("Steps"), exercise.steps ?? ""],
    [say("Length"), exercise.duration ? clock(Number(exercise.duration)) : ""],
  ];
  const rows = facts
    .filter(([, what]) => what)
    .flatMap(([name, what]) => [html("dt", {}, name), html("dd", {}, what)]);
  if (rows.length) parts.push(html("dl", {}, ...rows));
  return parts;
}

/** Returns the lines of a text as paragraphs: a long one goes on in the next. @param {string[]} lines */
function paragraphs(lines) {
  /** @type {string[]} */
  const joined = [];
  for (const [i, line] of lines.entries()) {
    if (i && lines[i - 1].length >= LONG_LINE) joined.push(`${joined.pop()} ${line}`);
    else joined.push(line);
  }
  return joined;
}

/** @param {Session} session */
function marksToCome({ role }) {
  if (role !== "trainee") return say("The instructor has the marks first.");
  return say("The marks are being calculated; an instructor who is here has them first.");
}

/** Returns what loses an exercise, such as `speed_kn < 10 and time < 60`, in words. @param {string} loss */
export function lossInWords(loss) {
  const [, held, seconds] = /^(.*\S)\s+for\s+([\d.]+)\s*s$/.exec(loss) ?? [];
  const words = (held ?? loss).split(/\s+and\s+/).map(comparison).join(say(" and "));
  return seconds ? say("{0} for {1} s", words, seconds) : words;
}

/** Returns a condition such as `depth > 160` in words. @param {string} condition */
function comparison(condition) {
  const [, quantity = "", suffix, side, number, after] = LOSS.exec(condition) ?? [];
  if (!quantity) return condition;
  if (quantity === "showing" && side === ">" && !Number(number)) return say("sail or deck out of the water");
  const unit = suffix || after || FIRST_UNITS[quantity] || "m";
  const bound = unit === "m" ? shortLength(Number(number)) : `${number} ${UNITS[unit] ?? unit.replace("_", "/")}`;
  const [known, name] = [LOSSES[`${quantity}${side}`], NAMES[quantity] ?? quantity];
  if (known) return known(bound);
  return side === ">" ? say("{0} more than {1}", name, bound) : say("{0} less than {1}", name, bound);
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
  const far = unit === "m" ? shortLength(Number(value)) : `${value} ${UNITS[unit] ?? unit}`;
  const bound = unit === "level" ? value : far;
  return end === "min" ? say("{0} at least {1}", what, bound) : say("{0} at most {1}", what, bound);
}

// What is needed now and then: the ledger, the stations with what they lost, marks, moments kept.
import { clock, html, one } from "../draw.js";
import { showBeside } from "./desk.js";
import { valuesTable } from "./pictures.js";
import { say } from "../words.js";

/** @typedef {import("./desk.js").Desk} Desk */

const ASKED = 2000; // [ms] between looks at the stations, while the drawer is open
const LEDGER = {
  ticks: say("Ticks"),
  duty_cycle: say("Duty cycle, %"),
  overruns: say("Overruns"),
  caught_up: say("Caught up"),
  slipped: say("Slipped"),
  gaps: say("Gaps"),
  late_p50: say("Late, half of them, us"),
  late_p99: say("Late, 99 of 100, us"),
  late_most: say("Late, most, us"),
  work_p99: say("Work, 99 of 100, us"),
};

/** Furnishes the drawer; returns what opens and closes it. @param {Desk} desk */
export function furnishDrawer(desk) {
  const drawer = /** @type {HTMLDialogElement} */ (one("#drawer"));
  const toggle = () => {
    if (drawer.open) drawer.close();
    else {
      showBeside(drawer);
      void fill(desk);
    }
    one("#open-drawer").setAttribute("aria-expanded", String(drawer.open));
  };
  one("#open-drawer").onclick = toggle;
  one("#close-drawer").onclick = toggle;
  drawer.onclose = () => one("#open-drawer").setAttribute("aria-expanded", "false");
  setInterval(() => {
    if (drawer.open && !drawer.contains(document.activeElement)) void fill(desk);
  }, ASKED);
  desk.session.on("line", () => {
    if (drawer.open) void fill(desk);
  });
  return toggle;
}

/** @param {Desk} desk */
async function fill(desk) {
  const others = desk.session.alone ? [] : await sessionsOwn(desk);
  one("#drawer-body").replaceChildren(section(say("Moments kept"), ...moments(desk)), ...others);
}

/** Returns what a session with other stations has. @param {Desk} desk */
async function sessionsOwn(desk) {
  const { lines } = await desk.session.ask("who");
  return [
    section(say("Stations"), list(lines, say("Nobody"))),
    section(say("Marks"), list(desk.session.judgement.lines, say("They come at the end."))),
    section(say("Ledger"), ledger(desk)),
  ];
}

/** @param {string} title @param {...Node} parts */
function section(title, ...parts) {
  return html("section", {}, html("h3", {}, title), ...parts);
}

/** @param {string[]} lines @param {string} none */
function list(lines, none) {
  return html("ul", {}, ...(lines.length ? lines : [none]).map((each) => html("li", {}, each)));
}

/** @param {Desk} desk */
function moments(desk) {
  const kept = desk.session.signs.kept.filter(({ sign }) => sign === "S");
  const rows = kept.map(({ seconds, text }) => {
    const restore = () => void desk.give(`restore ${text}`);
    const key = html("button", { type: "button", click: restore }, say("Restore {0}", text));
    return html("li", { class: "row" }, html("time", {}, clock(seconds)), key);
  });
  const name = /** @type {HTMLInputElement} */ (html("input", {
    ...{ "aria-label": say("Name of the moment"), placeholder: say("name: before-jam"), maxlength: 40 },
    ...{ autocomplete: "off", class: "grow" },
  }));
  const keep = (/** @type {Event} */ event) => {
    event.preventDefault();
    const word = name.value.trim().replace(/\s+/g, "-");
    if (word) void desk.give(`snapshot ${word}`);
  };
  const form = html("form", { class: "row", submit: keep }, name, html("button", {}, say("Keep this moment")));
  return [html("ul", {}, ...rows), form];
}

/** @param {Desk} desk */
function ledger({ session }) {
  const rows = Object.entries(LEDGER).map(([field, name]) => {
    const value = html("td", {}, session.word(`ledger.${field}`));
    return html("tr", {}, html("th", { scope: "row" }, name), value);
  });
  return html("table", {}, html("tbody", {}, ...rows));
}

/** Shows long answers, and the charts as a table, in a window to read. @param {Desk} desk */
export function furnishReading(desk) {
  const dialog = /** @type {HTMLDialogElement} */ (one("#reading"));
  const show = (/** @type {string} */ title, /** @type {Node} */ body) => {
    one("#reading-title").textContent = title;
    one("#reading-body").replaceChildren(body);
    if (!dialog.open) dialog.showModal();
  };
  one("#close-reading").onclick = () => dialog.close();
  one("#open-values").onclick = () => show(say("What the charts show"), valuesTable(desk));
  desk.addEventListener("answer", (event) => {
    const { words, lines } = /** @type {CustomEvent} */ (event).detail;
    show(words, html("pre", {}, lines.join("\n")));
  });
}

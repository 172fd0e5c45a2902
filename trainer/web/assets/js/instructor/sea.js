// The sea: what it is and what it is becoming, and the orders that change it; and its tab.
import { bearing, html, one, write } from "../draw.js";
import { paced } from "./desk.js";
import { lengthDigits, unit } from "../units.js";
import { decimals, say } from "../words.js";

/** @typedef {import("./desk.js").Desk} Desk */

const STATES = 9;
const ROWS = [
  [say("Height, {0}", unit), "height"],
  [say("Period, s"), "period"],
  [say("From"), "from"],
];
const WATER = [
  [say("Current towards"), "set"],
  [say("Drift, kn"), "drift"],
  [say("Course over ground"), "course_over_ground"],
  [say("Speed over ground, kn"), "speed_over_ground"],
];

/** Fills the tab of the sea. @param {Desk} desk */
export function showSea(desk) {
  const { session, moment } = desk;
  const rows = ROWS.map(([name, field]) => {
    const cells = [html("td"), html("td", { class: "ordered" })];
    return { field, cells, line: html("tr", {}, html("th", { scope: "row" }, name), ...cells) };
  });
  const over = html("td");
  const sail = html("tr", {}, html("th", { scope: "row" }, say("Water over the sail, {0}", unit)), over, html("td"));
  const water = WATER.map(([name, field]) => {
    const cell = html("td");
    return { field, cell, line: html("tr", {}, html("th", { scope: "row" }, name), cell, html("td")) };
  });
  one("#sea tbody").append(...rows.map(({ line }) => line), sail, ...water.map(({ line }) => line));
  const fill = paced(500, () => {
    for (const { field, cells } of rows) {
      ["", "ordered_"].forEach((which, at) => {
        const value = moment.number(`sea.${which}${field}`);
        const says = value === null ? "" : field === "from" ? bearing(value) : field === "height" ? lengthDigits(value) : decimals(value, 1);
        write(cells[at], value !== null && Number(value.toFixed(1)) === 0 && field !== "from" ? say("calm") : says);
      });
    }
    const deep = moment.number("sea.over_sail");
    write(over, deep === null ? "" : lengthDigits(deep));
    for (const { field, cell } of water) {
      const value = moment.number(`current.${field}`);
      const course = field === "set" || field === "course_over_ground";
      write(cell, value === null ? say("none") : course ? bearing(value) : decimals(value, 1));
    }
  });
  session.on("tick", fill);
  moment.addEventListener("look", fill);
  furnishOrders(desk);
  furnishTabs();
}

/** @param {Desk} desk */
function furnishOrders(desk) {
  const state = /** @type {HTMLSelectElement} */ (one("#sea-state"));
  const from = /** @type {HTMLInputElement} */ (one("#sea-from"));
  state.append(...Array.from({ length: STATES }, (_, at) => html("option", {}, String(at))));
  one("#raise").onclick = () => void desk.give(`sea state ${state.value}`);
  one("#calm").onclick = () => void desk.give("sea calm");
  const turn = () => void desk.give(`sea from ${from.value.trim() || "000"}`);
  one("#turn").onclick = turn;
  one("#sea-orders").onsubmit = (event) => {
    event.preventDefault();
    turn();
  };
  const towards = /** @type {HTMLInputElement} */ (one("#current-set"));
  const drift = /** @type {HTMLInputElement} */ (one("#current-drift"));
  one("#current-orders").onsubmit = (event) => {
    event.preventDefault();
    void desk.give(`current set ${towards.value.trim() || "000"} drift ${drift.value.trim() || "0"}`);
  };
  one("#no-current").onclick = () => void desk.give("current off");
}

/** Track, sea and ships share a place: one of them is seen. */
function furnishTabs() {
  const tabs = [one("#track-tab"), one("#sea-tab"), one("#ships-tab")];
  const choose = (/** @type {HTMLElement} */ wanted) => {
    for (const tab of tabs) {
      const here = tab === wanted;
      tab.setAttribute("aria-selected", String(here));
      tab.tabIndex = here ? 0 : -1;
      one(`#${tab.getAttribute("aria-controls")}`).hidden = !here;
    }
  };
  for (const tab of tabs) {
    tab.onclick = () => choose(tab);
    tab.onkeydown = ({ key }) => {
      if (key !== "ArrowLeft" && key !== "ArrowRight") return;
      const by = key === "ArrowRight" ? 1 : tabs.length - 1;
      const other = tabs[(tabs.indexOf(tab) + by) % tabs.length];
      choose(other);
      other.focus();
    };
  }
}

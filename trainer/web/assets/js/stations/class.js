// The class: a tile for each boat, and words to all of them or to those that are chosen.
import { BOATS_PERIOD, askBoats } from "../class/boats.js";
import { ClassBoat } from "../class/class-boat.js";
import { Tile } from "../class/tile.js";
import { html, one, write } from "../draw.js";
import { furnishPalette, isTyping } from "../frame.js";
import { say } from "../words.js";

const DRAWN = 1000; // [ms] between drawings
const SORTED = 5000; // [ms] between changes of the order, so that a tile can be hit

/** @type {Tile[]} by number */
const tiles = [];
let byNeed = true;
let shown = 0; // the boat that is shown to all
let sorted = -Infinity; // [ms]

furnishPalette();
furnishWord();
furnishOrder();
furnishWords();
one("#show").onclick = () => void show();
addEventListener("keydown", (event) => {
  if (isTyping(event) || !/^[1-9]$/.test(event.key)) return;
  one(`[data-boat="${event.key}"] a`).focus();
});
void look();
setInterval(() => void look(), BOATS_PERIOD);
setInterval(draw, DRAWN);

/** Asks how the boats are, and for the word where this browser has no instructor's seat. */
async function look() {
  const told = await askBoats();
  if (!told) return;
  const dialog = /** @type {HTMLDialogElement} */ (one("#word"));
  if (told.seat !== 0) {
    if (!dialog.open) dialog.showModal();
    return;
  }
  if (dialog.open) dialog.close();
  if (!tiles.length) begin(told.boats);
  markShown(told.shown);
  for (const row of told.boats) Object.assign(tiles[row.number - 1].boat.row, row);
}

/** @param {import("../class/boats.js").BoatRow[]} rows */
function begin(rows) {
  for (const row of rows) {
    const boat = new ClassBoat({ ...row }, document.documentElement.dataset.version ?? "");
    boat.session.on("older", () => (one("#older").hidden = false));
    tiles.push(new Tile(boat, countChosen));
    boat.session.start();
  }
  one("#tiles").append(...tiles.map(({ node }) => node));
  countChosen();
  setTimeout(draw, 0);
}

function draw() {
  for (const tile of tiles) tile.draw();
  const now = performance.now();
  if (now - sorted < SORTED || !tiles.length) return;
  sorted = now;
  sort();
}

/** Lays the tiles in their order, without moving the focus. */
function sort() {
  const order = byNeed ? tiles.toSorted((a, b) => b.boat.urgency - a.boat.urgency) : tiles;
  const main = one("#tiles");
  if (order.every(({ node }, at) => main.children[at] === node)) return;
  const focused = /** @type {HTMLElement | null} */ (document.activeElement);
  main.append(...order.map(({ node }) => node));
  if (focused && main.contains(focused)) focused.focus();
}

function furnishOrder() {
  const keys = [one("#by-need"), one("#by-number")];
  keys.forEach((key, at) => {
    key.onclick = () => {
      byNeed = at === 0;
      keys.forEach((each) => each.setAttribute("aria-pressed", String(each === key)));
      sort();
    };
  });
}

/** The boats that words go to: those that are chosen. */
function chosen() {
  return tiles.filter((tile) => tile.chosen);
}

function countChosen() {
  const count = chosen().length;
  write(one("#count"), say("{0} boats, {1} chosen", tiles.length, count));
  one("#all").setAttribute("aria-pressed", String(count === tiles.length));
}

function furnishWords() {
  const field = /** @type {HTMLInputElement} */ (one("#order"));
  /** @type {{ forms: [string, string][] }} */
  const { forms } = JSON.parse(one("#order-words").textContent ?? "{}");
  one("#begun").append(...forms.map(([form]) => html("option", { value: form.toLowerCase() })));
  one("#all").onclick = () => {
    const all = chosen().length < tiles.length;
    for (const { box } of tiles) box.checked = all;
    countChosen();
  };
  for (const key of document.querySelectorAll("#keys button")) {
    key.addEventListener("click", () => void give(/** @type {HTMLElement} */ (key).dataset.words ?? ""));
  }
  one("#say").onsubmit = (event) => {
    event.preventDefault();
    const words = field.value.trim();
    if (words) void give(words).then((all) => all && (field.value = ""));
  };
}

/** Gives an order to the chosen boats; each answers for itself. @param {string} words @returns {Promise<boolean>} whether all obey */
async function give(words) {
  const to = chosen();
  const place = one("#answer");
  place.toggleAttribute("data-refused", !to.length);
  write(place, to.length ? say("{0}: to {1} boats", words, to.length) : say("choose boats first"));
  const answers = await Promise.all(
    to.map(async (tile) => {
      const answer = await tile.boat.session.order(words);
      tile.say(answer);
      return { number: tile.boat.row.number, ...answer };
    }),
  );
  if (!to.length) return false;
  const refused = answers.filter(({ ok }) => !ok);
  place.toggleAttribute("data-refused", refused.length > 0);
  const done = say("{0}: obeyed by {1} of {2}", words, answers.length - refused.length, answers.length);
  write(place, [done, ...refused.map(({ number, text }) => say("boat {0}: {1}", number, text))].join(" \u00b7 "));
  return !refused.length;
}

/** Shows the chosen boat to all, or takes back the one that is shown. */
async function show() {
  const to = chosen();
  const place = one("#answer");
  place.toggleAttribute("data-refused", !shown && to.length !== 1);
  if (!shown && to.length !== 1) {
    write(place, say("choose the one boat that all are to see"));
    return;
  }
  const body = String(shown ? 0 : to[0].boat.row.number);
  const done = await fetch("./shown", { method: "POST", body }).catch(() => null);
  place.toggleAttribute("data-refused", !done?.ok);
  if (!done?.ok) {
    write(place, (await done?.text())?.trim() ?? say("the server does not answer"));
    return;
  }
  markShown(Number(body));
  write(place, shown ? say("boat {0} is shown to all: {1}", shown, new URL("./wall", location.href).href) : say("no boat is shown any more"));
}

/** Marks the boat that is shown to all. @param {number} number */
function markShown(number) {
  shown = number;
  one("#show").setAttribute("aria-pressed", String(Boolean(shown)));
  for (const { node, boat } of tiles) one(".shown", node).hidden = boat.row.number !== shown;
}

/** Asks for the instructor's word. */
function furnishWord() {
  const form = /** @type {HTMLFormElement} */ (one("#word form"));
  const field = /** @type {HTMLInputElement} */ (one("#word input"));
  form.onsubmit = async (event) => {
    event.preventDefault();
    const body = `instructor ${field.value.trim()}`;
    field.value = "";
    const kept = await fetch("./word", { method: "POST", body }).catch(() => null);
    const text = (await kept?.text())?.trim() ?? say("the server does not answer");
    write(one("#refusal"), kept?.ok ? "" : text.replace(/: (--token|type role) .*$/, ""));
    if (kept?.ok) await look();
  };
}

// The first page of a class: who comes says his name, his boat and his station.
import { html, one, write } from "../draw.js";
import { furnishPalette } from "../frame.js";
import { BOATS_PERIOD, askBoats } from "../class/boats.js";
import { say } from "../words.js";

const NEXT_FREE = 0;

furnishPalette();
one("#come").onsubmit = (event) => {
  event.preventDefault();
  void comeAboard();
};
void look();
setInterval(() => void look(), BOATS_PERIOD);

/** Shows which boats there are, and how many are aboard each. */
async function look() {
  const told = await askBoats();
  if (!told) {
    write(one("#answer"), say("the server does not answer"));
    return;
  }
  one("#word-field").hidden = !told.guarded;
  const list = one("#boats");
  if (!list.childElementCount) list.append(...keysOf(told.boats));
  for (const { number, crew } of told.boats) {
    write(one(`#boat-${number} + span small`), crew ? say("{0} aboard", crew) : say("free"));
  }
}

/** Returns the keys that choose a boat. @param {import("../class/boats.js").BoatRow[]} boats */
function keysOf(boats) {
  const asked = Number(new URLSearchParams(location.search).get("boat") ?? NEXT_FREE);
  const rows = [{ number: NEXT_FREE, name: say("the next free boat") }, ...boats];
  return rows.map(({ number, name }) => {
    const attributes = { type: "radio", name: "boat", id: `boat-${number}`, value: number, checked: number === asked };
    const title = [number || "", name].filter(Boolean).join(" ");
    return html("label", { class: "key" }, html("input", attributes), html("span", {}, `${title} `, html("small")));
  });
}

/** Takes a seat, and goes to the boat's page. */
async function comeAboard() {
  const station = /** @type {HTMLSelectElement} */ (one("#station"));
  const boat = /** @type {HTMLInputElement} */ (one("[name=boat]:checked")).value;
  const [called, token] = ["#called", "#token"].map((field) => /** @type {HTMLInputElement} */ (one(field)).value.trim());
  const body = [boat, station.selectedOptions[0].dataset.role, token, called].join("\n");
  const taken = await fetch("./seat", { method: "POST", body }).catch(() => null);
  const text = (await taken?.text())?.trim() ?? say("the server does not answer");
  if (taken?.ok) location.assign(`./boat/${text}/${station.value}`);
  else write(one("#answer"), text.replace(/: (--token|type role) .*$/, ""));
}

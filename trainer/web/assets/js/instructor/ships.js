// The ships near: where each bears, how near it will come; orders to them.
import { bearing, clock, html, one, write } from "../draw.js";
import { paced } from "./desk.js";
import { shortLength } from "../units.js";
import { decimals, say } from "../words.js";

/**
 * @typedef {import("./desk.js").Desk} Desk
 * @typedef {{ name: string, type: string, bearing: number, range: number, course: number,
 *   speed: number, cpa: number, tcpa: number | null }} Ship [deg], [m], [kn], [s]
 */

const MOST = 8; // ships of the channel
const DIGITS = 500; // [ms] between changes of digits
const MILE = 1852; // [m]
/** @type {Record<string, string>} types of ships in words */
const TYPES = {
  tanker: say("tanker"),
  cargo: say("cargo"),
  ferry: say("ferry"),
  fishing: say("fishing"),
  yacht: say("yacht"),
  tug: say("tug"),
  submarine: say("submarine"),
};
const NEW = "new "; // before a type, in the choice of ships

/** Returns a type of ship in words. @param {string} type */
function typeOf(type) {
  return TYPES[type] ?? type;
}

/**
 * Returns the ships near, the nearest first.
 * @param {{ word(place: string): string, number(place: string): number | null }} seen the session, or a moment of it
 * @returns {Ship[]}
 */
export function shipsOf(seen) {
  return Array.from({ length: MOST }, (_, at) => `contacts.contact_${at + 1}`)
    .filter((name) => seen.word(name))
    .map((name) => {
      const number = (/** @type {string} */ field) => seen.number(`${name}_${field}`);
      return {
        ...{ name: seen.word(name), type: seen.word(`${name}_type`) },
        ...{ bearing: number("bearing") ?? 0, range: number("range") ?? 0 },
        ...{ course: number("course") ?? 0, speed: number("speed") ?? 0 },
        ...{ cpa: number("cpa") ?? 0, tcpa: number("tcpa") },
      };
    });
}

/** Fills the tab of the ships. @param {Desk} desk */
export function showShips(desk) {
  const { session, moment } = desk;
  const choice = furnishOrders(desk);
  const body = one("#ships tbody");
  const lines = Array.from({ length: MOST }, () => {
    const cells = Array.from({ length: 6 }, () => html("td"));
    const head = html("th", { scope: "row" });
    return { head, cells, line: html("tr", { hidden: true }, head, ...cells) };
  });
  body.append(...lines.map(({ line }) => line));
  const fill = paced(DIGITS, () => {
    const ships = shipsOf(moment);
    one("#no-ships").hidden = ships.length > 0;
    one("#ships").hidden = ships.length === 0;
    choice.offer(shipsOf(session)); // orders are to those of now
    lines.forEach(({ head, cells, line }, at) => {
      const ship = ships[at];
      line.hidden = !ship;
      if (!ship) return;
      write(head, ship.name);
      head.title = typeOf(ship.type);
      line.onclick = () => choice.choose(ship);
      says(ship).forEach((text, column) => write(cells[column], text));
    });
  });
  session.on("tick", fill);
  moment.addEventListener("look", fill);
}

/** Furnishes the orders to ships: a new one, or one of those near. @param {Desk} desk */
function furnishOrders(desk) {
  const chosen = /** @type {HTMLSelectElement} */ (one("#ship"));
  /** @type {[string, string][]} */
  const types = JSON.parse(one("#ship-types").textContent ?? "[]");
  const kinds = types.map(([type]) => html("option", { value: NEW + type }, say("a new {0}", typeOf(type))));
  /** @type {Ship[]} */
  let near = [];
  const field = (/** @type {string} */ of) => /** @type {HTMLInputElement} */ (one(`#ship-${of}`));
  const said = (/** @type {string} */ of) => field(of).value.trim() || "0";
  const isNew = () => chosen.value.startsWith(NEW);
  const furnish = () => {
    one("#ship-add").hidden = !isNew();
    for (const each of ["move", "turn", "go", "remove"]) one(`#ship-${each}`).hidden = isNew();
  };
  const give = (/** @type {string} */ words) => void desk.give(`contact ${words}`);
  const place = () => placeAt(desk, Number(said("bearing")), Number(said("range")));
  const add = () => {
    const type = chosen.value.slice(NEW.length);
    const name = newName(type, near);
    give(`add ${name} ${type} at ${place()} course ${said("course")} speed ${said("speed")}`);
  };
  one("#ship-orders").onsubmit = (event) => {
    event.preventDefault();
    if (isNew()) add();
  };
  one("#ship-move").onclick = () => give(`${chosen.value} move ${place()}`);
  one("#ship-turn").onclick = () => give(`${chosen.value} course ${said("course")}`);
  one("#ship-go").onclick = () => give(`${chosen.value} speed ${said("speed")}`);
  one("#ship-remove").onclick = () => give(`${chosen.value} remove`);
  chosen.onchange = furnish;
  chosen.append(...kinds);
  furnish();
  return {
    /** Offers the ships near beside new ones. @param {Ship[]} ships */
    offer(ships) {
      const names = ships.map(({ name }) => name).toSorted();
      const same = names.join() === near.map(({ name }) => name).toSorted().join();
      near = ships;
      if (same) return;
      const before = chosen.value;
      chosen.replaceChildren(...names.map((name) => html("option", {}, name)), ...kinds);
      chosen.value = before;
      if (chosen.selectedIndex < 0) chosen.selectedIndex = 0;
      furnish();
    },
    /** Fills the fields by a ship of the list. @param {Ship} ship */
    choose(ship) {
      if (!near.some(({ name }) => name === ship.name)) return; // it was near at a moment looked at
      chosen.value = ship.name;
      const fields = { bearing: bearing(ship.bearing), range: String(ship.range), course: bearing(ship.course) };
      for (const [of, value] of Object.entries({ ...fields, speed: ship.speed.toFixed(1) })) {
        field(of).value = value;
      }
      furnish();
    },
  };
}

/** Returns a place as orders have it, metres from the origin. @param {Desk} desk @param {number} from [deg] @param {number} range [m] */
function placeAt({ session }, from, range) {
  const angle = (from * Math.PI) / 180;
  const [north, east] = ["north", "east"].map((axis) => session.number(`motion.${axis}`) ?? 0);
  return `${Math.round(north + range * Math.cos(angle))} ${Math.round(east + range * Math.sin(angle))}`;
}

/** Returns a name that no ship near has. @param {string} type @param {Ship[]} ships */
function newName(type, ships) {
  const taken = new Set(ships.map(({ name }) => name));
  let number = 1;
  while (taken.has(`${type}${number}`)) number += 1;
  return `${type}${number}`;
}

/** Returns the cells of a ship. @param {Ship} ship */
function says({ bearing: from, range, course, speed, cpa, tcpa }) {
  const far = (/** @type {number} */ metres) => (metres < MILE ? shortLength(metres) : `${decimals(metres / MILE, 1)} nm`);
  const until = tcpa === null ? "" : tcpa < 0 ? say("past") : clock(tcpa);
  return [bearing(from), far(range), bearing(course), decimals(speed, 1), far(cpa), until];
}

// The ships near: where each bears, how near it will come and when.
import { bearing, clock, html, one, write } from "../draw.js";
import { paced } from "./desk.js";

/**
 * @typedef {import("./desk.js").Desk} Desk
 * @typedef {{ name: string, type: string, bearing: number, range: number, course: number,
 *   speed: number, cpa: number, tcpa: number | null }} Ship [deg], [m], [kn], [s]
 */

const MOST = 8; // ships of the channel
const DIGITS = 500; // [ms] between changes of digits
const MILE = 1852; // [m]

/** Returns the ships near, the nearest first. @param {Desk["session"]} session @returns {Ship[]} */
export function shipsOf(session) {
  return Array.from({ length: MOST }, (_, at) => `contacts.contact_${at + 1}`)
    .filter((name) => session.word(name))
    .map((name) => {
      const number = (/** @type {string} */ field) => session.number(`${name}_${field}`);
      return {
        ...{ name: session.word(name), type: session.word(`${name}_type`) },
        ...{ bearing: number("bearing") ?? 0, range: number("range") ?? 0 },
        ...{ course: number("course") ?? 0, speed: number("speed") ?? 0 },
        ...{ cpa: number("cpa") ?? 0, tcpa: number("tcpa") },
      };
    });
}

/** Fills the tab of the ships, and keeps it filled. @param {Desk} desk */
export function showShips({ session }) {
  const body = one("#ships tbody");
  const lines = Array.from({ length: MOST }, () => {
    const cells = Array.from({ length: 6 }, () => html("td"));
    const head = html("th", { scope: "row" });
    return { head, cells, line: html("tr", { hidden: true }, head, ...cells) };
  });
  body.append(...lines.map(({ line }) => line));
  const fill = paced(DIGITS, () => {
    const ships = shipsOf(session);
    one("#no-ships").hidden = ships.length > 0;
    one("#ships").hidden = ships.length === 0;
    lines.forEach(({ head, cells, line }, at) => {
      const ship = ships[at];
      line.hidden = !ship;
      if (!ship) return;
      write(head, ship.name);
      head.title = ship.type;
      says(ship).forEach((text, column) => write(cells[column], text));
    });
  });
  session.on("tick", fill);
}

/** Returns the cells of a ship. @param {Ship} ship */
function says({ bearing: from, range, course, speed, cpa, tcpa }) {
  const far = (/** @type {number} */ metres) => (metres < MILE ? `${metres} m` : `${(metres / MILE).toFixed(1)} nm`);
  const until = tcpa === null ? "" : tcpa < 0 ? "past" : clock(tcpa);
  return [bearing(from), far(range), bearing(course), speed.toFixed(1), far(cpa), until];
}

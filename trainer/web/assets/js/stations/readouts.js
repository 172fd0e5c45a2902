// Readings as digits, and what was answered to the last order.
import { bearing, one, sided, write } from "../draw.js";
import { movesBoat } from "../model/orders.js";
import { lengthOf } from "../units.js";
import { decimals, say } from "../words.js";

const BETWEEN = 480; // [ms] between changes of digits, so that they can be read

/** @typedef {import("../model/session.js").Session} Session */

/**
 * Returns a function that shows at most twice a second, the last time included.
 * @param {() => void} show
 */
export function seldom(show) {
  let last = -BETWEEN;
  let due = false;
  return () => {
    if (due) return;
    due = true;
    setTimeout(
      () => {
        due = false;
        last = performance.now();
        show();
      },
      Math.max(last + BETWEEN - performance.now(), 0),
    );
  };
}

/** Writes the readings that elements with `data-place` name. @param {Session} session */
export function showReadouts(session) {
  for (const each of document.querySelectorAll("[data-place]")) {
    const node = /** @type {HTMLElement} */ (each);
    const { place = "", lower: low, higher: high, unit = "", digits = "1" } = node.dataset;
    const value = session.number(place);
    const words = (/** @type {number} */ shown) => {
      if ("bearing" in node.dataset) return bearing(shown);
      return low && high ? sided(shown, low, high, Number(digits)) : decimals(shown, Number(digits));
    };
    if (session.readings.latest.has(place.split(".")[0])) {
      node.closest("[data-readout]")?.toggleAttribute("hidden", value === null);
    }
    const measured = () => (unit === "m" ? lengthOf(value ?? 0, Number(digits)) : `${words(value ?? 0)}${unit && ` ${unit}`}`);
    if (value !== null) write(node, measured());
  }
}

/**
 * Returns a function that gives an order and shows its answer in the page's line of answers.
 * @param {Session} session
 */
export function giver(session) {
  const line = one("#answer");
  return async (/** @type {string} */ words) => {
    const answer = await session.order(words);
    session.tell("crew");
    const later = session.state === "frozen" && movesBoat(words);
    const told = [`${words}: ${answer.text}`, ...(answer.lines.length === 1 ? answer.lines : [])].join("; ");
    line.toggleAttribute("data-refused", !answer.ok);
    if (!answer.ok) write(line, say("Refused: {0}", told));
    else write(line, later ? say("{0}: acts when time runs", told) : told);
    return answer.ok;
  };
}

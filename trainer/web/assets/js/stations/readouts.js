// Readings as digits, and what was answered to the last order.
import { bearing, one, sided, write } from "../draw.js";
import { movesBoat } from "../model/orders.js";

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
    const { place = "", low, high, unit = "", digits = "1" } = node.dataset;
    const value = session.number(place);
    const words = (/** @type {number} */ shown) => {
      if ("bearing" in node.dataset) return bearing(shown);
      return low && high ? sided(shown, low, high, Number(digits)) : shown.toFixed(Number(digits));
    };
    if (session.readings.latest.has(place.split(".")[0])) {
      node.closest("[data-readout]")?.toggleAttribute("hidden", value === null);
    }
    if (value !== null) write(node, `${words(value)}${unit && ` ${unit}`}`);
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
    const later = session.state === "frozen" && movesBoat(words) ? ": acts when time runs" : "";
    const told = [`${words}: ${answer.text}`, ...(answer.lines.length === 1 ? answer.lines : [])].join("; ");
    line.toggleAttribute("data-refused", !answer.ok);
    write(line, answer.ok ? `${told}${later}` : `Refused: ${told}`);
    return answer.ok;
  };
}

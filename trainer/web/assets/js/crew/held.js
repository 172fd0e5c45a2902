// What the planes hold in the mean: by that an officer sees that the boat is out of trim.
import { clock, one, sided, write } from "../draw.js";

const SPAN = 180; // [s]

/** @param {import("../model/session.js").Session} session */
export function showHeld(session) {
  let span = 0;
  for (const surface of ["stern", "bow"]) {
    const held = session.history.mean("diving", surface, SPAN);
    const shown = one(`#${surface}-held`);
    const sides = /** @type {const} */ (["dive", "rise"]);
    write(shown, held ? `hold ${sided(held.mean, ...sides)}` : "");
    span = Math.max(span, held?.span ?? 0);
  }
  write(one("#span"), span > 0 ? `mean of ${clock(span)}` : "");
}

// What the planes hold in the mean: by that an officer sees that the boat is out of trim.
import { clock, one, sided, write } from "../draw.js";
import { say } from "../words.js";

const SPAN = 180; // [s]

/** @param {import("../model/session.js").Session} session */
export function showHeld(session) {
  let span = 0;
  for (const surface of ["stern", "bow"]) {
    const held = session.history.mean("diving", surface, SPAN);
    const shown = one(`#${surface}-held`);
    const sides = /** @type {const} */ ([say("dive"), say("rise")]);
    write(shown, held ? say("hold {0}", sided(held.mean, ...sides)) : "");
    span = Math.max(span, held?.span ?? 0);
  }
  write(one("#span"), span > 0 ? say("mean of {0}", clock(span)) : "");
}

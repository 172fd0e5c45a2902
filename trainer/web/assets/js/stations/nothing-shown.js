// The wall of a class while no boat is shown: it waits for the next one.
import { BOATS_PERIOD, askBoats } from "../class/boats.js";
import { showPalette } from "../frame.js";
import { hideStillPointer, keepAwake, moveEachMinute } from "../screen.js";
import { one } from "../draw.js";

showPalette();
keepAwake();
hideStillPointer();
moveEachMinute(one("main"));
setInterval(() => void look(), BOATS_PERIOD);

/** Loads the page again once a boat is shown: the server leads to its wall. */
async function look() {
  if ((await askBoats())?.shown) location.reload();
}

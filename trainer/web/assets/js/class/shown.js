// The boat that the instructor shows to all, as a station's page of a class tells of it.
import { BOATS_PERIOD, askBoats } from "./boats.js";
import { one, write } from "../draw.js";
import { say } from "../words.js";

const OF_A_CLASS = /\/boat\/\d+\/[a-z]+$/; // the address of such a page

/** Shows the way to the boat that is shown, where this is a page of a class. */
export function followShown() {
  if (!OF_A_CLASS.test(location.pathname)) return;
  const way = one("#shown");
  const look = async () => {
    const shown = (await askBoats("../../"))?.shown;
    if (shown === undefined) return;
    write(way, shown ? say("Boat {0} is shown to all", shown) : "");
    one("#shown-way").hidden = !shown;
  };
  void look();
  setInterval(() => void look(), 2 * BOATS_PERIOD);
}

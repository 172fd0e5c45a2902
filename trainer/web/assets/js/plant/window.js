// The window of the plant over a page, which a key of the page opens.
import { bindSupplies } from "./supply-keys.js";
import { one, write } from "../draw.js";
import { say } from "../words.js";

/**
 * Follows the plant of a session; the key is hidden where the boat has none.
 * @param {import("./supply-keys.js").Session} session
 * @param {import("./supply-keys.js").Give} give
 * @param {() => void} [showRows]
 */
export function furnishPlant(session, give, showRows = () => undefined) {
  const [panel, opener] = [one("#plant"), one("#open-plant")];
  const { channel = "plant" } = panel.dataset;
  bindSupplies(session, give);
  panel.addEventListener("keydown", ({ key }) => {
    if (key === "Escape") panel.hidePopover();
  });
  /** @type {unknown} */
  let last = null; // a reading may come again with the tick of one before
  const show = () => {
    const reading = session.readings.latest.get(channel);
    const has = (reading?.values.main_pressure ?? "") !== "";
    opener.toggleAttribute("hidden", !has);
    if (!has || reading === last) return;
    last = reading;
    showRows();
    const isUnusual = panel.querySelector(".told[data-unusual]") !== null;
    opener.toggleAttribute("data-unusual", isUnusual);
    write(opener, isUnusual ? say("Plant !") : say("Plant"));
  };
  session.on("tick", show);
}

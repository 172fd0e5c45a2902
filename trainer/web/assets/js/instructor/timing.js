// When a casualty comes: now, so long from now, at a time, or when the boat does something.
import { clock, html, one, write } from "../draw.js";
import { say } from "../words.js";

const QUANTITIES = [
  ["depth", say("depth"), "m", "80"],
  ["speed", say("speed"), "kn", "8"],
  ["pitch", say("pitch, up +"), "deg", "5"],
  ["heel", say("heel, stbd +"), "deg", "5"],
  ["depth_rate", say("sinking"), "m_s", "0.5"],
  ["turn_rate", say("turning, right +"), "deg_s", "0.5"],
];
const SHOWN = { m_s: "m/s", deg: say("deg"), deg_s: say("deg/s") }; // units as people write them
const FIRST = { in: 30, at: 120 }; // [s] preset
const TIMED = /^(?:(\d+):)?(\d+(?:[.,]\d+)?)$/; // minutes and seconds, or seconds

/** The fields that say when a casualty comes. */
export class Timing {
  constructor() {
    field("#quantity").append(...QUANTITIES.map(([name, says]) => html("option", { value: name }, says)));
    field("#how").onchange = () => this.show();
    field("#quantity").onchange = () => this.preset();
    this.preset();
  }

  open() {
    one("#timing").hidden = false;
    this.show();
  }

  close() {
    one("#timing").hidden = true;
    field("#how").value = "now";
  }

  /** Shows the fields of the way that is chosen. */
  show() {
    const how = field("#how").value;
    const moment = field("#moment");
    moment.hidden = how !== "in" && how !== "at";
    for (const name of ["#quantity", "#sense", "#threshold-field"]) one(name).hidden = how !== "when";
    if (!moment.hidden) {
      moment.setAttribute("aria-label", how === "in" ? say("Time from now") : say("Time since the start"));
      moment.value = clock(FIRST[/** @type {keyof typeof FIRST} */ (how)]);
    }
    write(one("#give"), how === "now" ? say("Give now") : say("Plan"));
  }

  /** Presets the threshold of the quantity that is chosen. */
  preset() {
    const [, , unit, usual] = this.chosen();
    write(one("#threshold-unit"), SHOWN[/** @type {keyof typeof SHOWN} */ (unit)] ?? unit);
    field("#threshold").value = usual;
  }

  chosen() {
    return QUANTITIES.find(([name]) => name === field("#quantity").value) ?? QUANTITIES[0];
  }

  /** Returns the words before the order, "" for now. */
  words() {
    const how = field("#how").value;
    if (how === "now") return "";
    if (how !== "when") return `${how} ${secondsOf(field("#moment").value)} `;
    const [name, , unit] = this.chosen();
    const threshold = field("#threshold").value.trim().replace(",", ".");
    return `when ${name} ${field("#sense").value} ${threshold} ${unit} then `;
  }
}

/** Returns a time in seconds; what is none as it was typed, since the session says why. @param {string} typed */
export function secondsOf(typed) {
  const found = TIMED.exec(typed.trim());
  if (!found) return typed.trim();
  return `${Number(found[1] ?? 0) * 60 + Number(found[2].replace(",", "."))} s`;
}

/** @param {string} selector */
function field(selector) {
  return /** @type {HTMLInputElement & HTMLSelectElement} */ (one(selector));
}

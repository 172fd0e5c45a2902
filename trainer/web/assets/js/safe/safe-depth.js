// How deep a jam or a flooding would take the boat now: a key that says it, and the diagram that it opens.
import "./depth-diagram.js";
import { one, write } from "../draw.js";
import { lengthOf } from "../units.js";
import { say } from "../words.js";

/**
 * @typedef {import("../model/session.js").Session} Session
 * @typedef {import("./depth-diagram.js").Limit} Limit
 */

/** Follows the safe depth of a session; nothing is shown where the boat has none. @param {Session} session */
export function furnishSafeDepth(session) {
  const [opener, panel] = [one("#open-safe"), one("#safe")];
  /** @type {any} */
  const diagram = one("depth-diagram", panel);
  /** @type {any} */
  const gauge = document.querySelector("depth-gauge");
  for (const part of [opener, panel]) {
    part.addEventListener("keydown", ({ key }) => {
      if (key === "Escape") panel.hidePopover();
    });
  }
  const number = (/** @type {string} */ place) => session.number(place);
  let packed = "";
  /** @type {Limit[]} */
  let limits = [];
  const show = () => {
    const [jam, flooding, test, depth] = ["safe.jam", "safe.flooding", "safe.test", "gauges.depth"].map(number);
    opener.toggleAttribute("hidden", test === null);
    gauge?.reach(jam, flooding);
    if (test === null || depth === null) return;
    const isUnsafe = Math.max(jam ?? 0, flooding ?? 0) > test;
    opener.toggleAttribute("data-unsafe", isUnsafe);
    const told = [
      jam === null ? "" : say("jam to {0}", lengthOf(jam, 0)),
      flooding === null ? "" : say("flooding to {0}", lengthOf(flooding, 0)),
    ];
    const words = told.filter(Boolean).join(" · ");
    const shown = isUnsafe ? `! ${words}` : words;
    if (opener.textContent !== shown) opener.setAttribute("aria-label", say("Safe depth: {0}", shown));
    write(opener, shown);
    if (!panel.matches(":popover-open")) return;
    if (packed !== session.word("safe.limits")) limits = unpack((packed = session.word("safe.limits")));
    const now = { speed: number("gauges.speed") ?? 0, depth };
    const ordered = {
      speed: number("orders.speed") ?? number("engine.ordered_speed") ?? now.speed,
      depth: number("orders.depth") ?? number("diving.ordered_depth") ?? depth,
    };
    diagram.show({ limits, test, now, ordered, jam, flooding });
  };
  session.on("tick", show);
  panel.addEventListener("toggle", show);
}

/** @param {string} packed @returns {Limit[]} */
function unpack(packed) {
  const value = (/** @type {string} */ text) => (text ? Number(text) : null);
  return packed.split(";").filter(Boolean).map((row) => {
    const [speed, jam, flooding] = row.split(":");
    return { speed: Number(speed), jam: value(jam), flooding: value(flooding) };
  });
}

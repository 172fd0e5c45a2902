// The bells of the engine telegraph, as people read them.
import { say } from "../words.js";

/** @type {Record<string, string>} parts of a bell's name */
const WORDS = {
  ahead: say("ahead"),
  astern: say("astern"),
  back: say("back"),
  flank: say("flank"),
  full: say("full"),
  standard: say("standard"),
  "two-thirds": say("two-thirds"),
  "one-third": say("one-third"),
  emergency: say("emergency"),
  stop: say("stop"),
};

/** Returns a bell in words. @param {string} bell as it is ordered, such as `ahead full` */
export function bellOf(bell) {
  return bell.split(" ").map((part) => WORDS[part] ?? part).join(" ");
}

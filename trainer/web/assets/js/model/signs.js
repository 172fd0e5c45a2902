// What the time line has a sign for: what broke, what was ordered, marks and moments kept.
import { partAt } from "./branches.js";

/**
 * @typedef {{ seconds: number, sign: string, text: string }} Kept a sign on the time line
 * @typedef {import("./branches.js").Part} Part
 */

export class Signs {
  constructor() {
    /** @type {Kept[]} of the way to the present */
    this.kept = [];
    /** @type {Map<number, Map<string, Kept>>} of branches that were left */
    this.left = new Map();
  }

  /** @param {number} seconds @param {string} sign @param {string} text */
  keep(seconds, sign, text) {
    const there = this.kept.some((each) => each.seconds === seconds && each.text === text);
    if (!there) this.kept.push({ seconds, sign, text });
  }

  /** Lays aside what is after a moment, each with the branch on which it was. @param {number} seconds @param {Part[]} parts of the way to the present */
  setAside(seconds, parts) {
    for (const each of this.kept) {
      if (each.seconds <= seconds) continue;
      const signs = this.left.get(partAt(parts, each.seconds)) ?? new Map();
      this.left.set(partAt(parts, each.seconds), signs.set(`${each.seconds} ${each.text}`, each));
    }
  }

  /** Forgets what is after a moment. @param {number} seconds */
  cut(seconds) {
    this.kept = this.kept.filter((each) => each.seconds <= seconds);
  }

  /** Returns what was laid aside on the way to the end of a branch, after a moment. @param {Part[]} parts @param {number} from [s] @returns {Kept[]} */
  leftOn(parts, from) {
    return parts
      .flatMap(({ number }) => [...(this.left.get(number)?.values() ?? [])].filter((each) => partAt(parts, each.seconds) === number))
      .filter(({ seconds }) => seconds > from);
  }
}

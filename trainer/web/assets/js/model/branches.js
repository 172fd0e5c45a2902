// What was flown and left: which part of a branch is its own, beside the present one.

/** @typedef {import("./session.js").Branch} Branch @typedef {{ number: number, until: number }} Part */

const LEAST = 0.6; // [s] of its own, below which a branch is not worth showing

/**
 * Returns the branches that the end of one lies on, from the first, and until when each [s].
 * @param {Map<number, Branch>} branches
 * @param {number} number
 * @returns {Part[]}
 */
export function way(branches, number) {
  /** @type {Part[]} */
  const parts = [];
  let until = Infinity;
  for (let at = branches.get(number); at; at = branches.get(at.parent)) {
    parts.unshift({ number: at.number, until });
    until = at.begun;
  }
  return parts;
}

/** Returns the branch that was flown at a moment on the way of another. @param {Part[]} parts @param {number} seconds */
export function partAt(parts, seconds) {
  return parts.find(({ until }) => seconds <= until)?.number ?? 0;
}

/**
 * Returns until when [s] two branches are the same.
 * @param {Map<number, Branch>} branches
 * @param {number} one
 * @param {number} other
 */
export function shared(branches, one, other) {
  const [first, second] = [way(branches, one), way(branches, other)];
  let same = 0;
  for (let at = 0; at < Math.min(first.length, second.length); at += 1) {
    if (first[at].number !== second[at].number) break;
    same = Math.min(first[at].until, second[at].until);
    if (first[at].until !== second[at].until) break;
  }
  return same;
}

/**
 * Whether what happened lies on the way to the end of a branch.
 * @param {Map<number, Branch>} branches
 * @param {number} branch
 * @param {{ seconds: number, branch: number }} entry with the branch that was flown when it was told
 */
export function isOnWay(branches, branch, entry) {
  const { seconds } = entry;
  return partAt(way(branches, entry.branch || branch), seconds) === partAt(way(branches, branch), seconds);
}

/**
 * Returns the branches that were left, newest first, each from where it differs from the present.
 * @param {Map<number, Branch>} branches
 * @param {number} present
 * @returns {{ number: number, from: number, to: number, why: string }[]}
 */
export function lanes(branches, present) {
  return [...branches.values()]
    .filter((each) => each.number !== present)
    .map((each) => {
      const from = Math.max(shared(branches, each.number, present), each.begun);
      return { number: each.number, from, to: each.last, why: each.why };
    })
    .filter((lane) => lane.to - lane.from >= LEAST)
    .sort((a, b) => b.number - a.number);
}

// What has been flown: branches of copies of the state, and of what orders wrote between them.

/**
 * @typedef {import("./core.js").Core} Core
 * @typedef {[number, number][]} Writes places of the state and what is written there
 * @typedef {{ number: number, parent: number, begun: number, last: number, why: string,
 *   copies: Map<number, Float64Array>, before: Map<number, Writes>, after: Map<number, Writes> }} Branch
 * @typedef {{ number: number, parent: number, begun: number, last: number, why: string,
 *   state: string, before: [number, Writes][], after: [number, Writes][] }} Recorded
 */

const EVERY = 50; // ticks between copies: what is between them is flown again in a moment

export class Flight {
  /** @param {Core} core */
  constructor(core) {
    this.core = core;
    /** @type {Map<number, Branch>} */
    this.branches = new Map();
    this.present = 0;
    this.replayed = 0; // the branch that is flown again, 0 for none
    /** @type {Map<string, { branch: number, tick: number }>} */
    this.snapshots = new Map();
  }

  /** The branch that is being flown. */
  get branch() {
    return /** @type {Branch} */ (this.branches.get(this.present));
  }

  /** Begins a branch with the state as it stands. @param {string} why */
  begin(why) {
    const [number, tick] = [this.branches.size + 1, this.core.ticks];
    const copies = new Map([[tick, this.core.state.slice()]]);
    const parts = { copies, before: new Map(), after: new Map() };
    const parent = this.present;
    this.branches.set(number, { number, parent, begun: tick, last: tick, why, ...parts });
    this.present = number;
    this.replayed = 0;
  }

  /** Takes a branch that was recorded, and flies it again. @param {Recorded} recorded @param {Float64Array} state */
  take(recorded, state) {
    const { number, parent, begun, last, why } = recorded;
    const copies = new Map([[begun, state]]);
    const parts = { copies, before: new Map(recorded.before), after: new Map(recorded.after) };
    this.branches.set(number, { number, parent, begun, last, why, ...parts });
    this.present = number;
    this.core.state.set(state);
    while (this.core.ticks < last) this.advance();
  }

  /** Does something to the state, and keeps what that wrote. @param {() => string} deed */
  write(deed) {
    const { state } = this.core;
    const was = state.slice();
    const why = deed();
    /** @type {Writes} */
    const writes = [];
    state.forEach((value, place) => {
      if (!Object.is(value, was[place])) writes.push([place, value]);
    });
    const { before } = this.branch;
    const tick = this.core.ticks;
    if (writes.length) before.set(tick, [...(before.get(tick) ?? []), ...writes]);
    return why;
  }

  /** Flies a tick of the present branch; returns its status. */
  tick() {
    if (this.replayed) {
      this.advance();
      if (this.core.ticks >= this.branch.last) this.replayed = 0;
      return 0;
    }
    const status = this.core.tick();
    if (!status) this.keep();
    return status;
  }

  /** Flies a tick again, with what was ordered there. */
  advance() {
    this.follow(this.owner(this.present, this.core.ticks));
    this.keep();
  }

  /** @param {Branch} branch */
  follow(branch) {
    const { core } = this;
    if (core.ticks === branch.begun) core.state.set(/** @type {Float64Array} */ (branch.copies.get(branch.begun)));
    const next = core.ticks + 1;
    put(branch.before.get(core.ticks), core.state);
    core.tick();
    put(branch.after.get(next), core.state);
    if (core.ticks !== next) throw new Error(`tick ${next} of branch ${branch.number} cannot be flown`);
  }

  keep() {
    const { core, branch } = this;
    branch.last = Math.max(branch.last, core.ticks);
    if (core.ticks % EVERY === 0 && !branch.copies.has(core.ticks)) branch.copies.set(core.ticks, core.state.slice());
  }

  /** Returns the branch on whose way a tick of another was flown. @param {number} number @param {number} tick */
  owner(number, tick) {
    let here = /** @type {Branch} */ (this.branches.get(number));
    while (here.parent && tick < here.begun) here = /** @type {Branch} */ (this.branches.get(here.parent));
    return here;
  }

  /** Goes to the end of a tick of a branch, before its orders. @param {number} number @param {number} tick */
  visit(number, tick) {
    const here = this.owner(number, tick);
    const from = Math.max(...[...here.copies.keys()].filter((at) => at <= tick));
    const { core } = this;
    core.state.set(/** @type {Float64Array} */ (here.copies.get(from)));
    while (core.ticks < tick) this.follow(here);
    return here;
  }

  /** Calls something with the state at ticks of the present's past, and comes back. @param {number[]} ticks @param {(tick: number) => void} call */
  recall(ticks, call) {
    const now = this.core.state.slice();
    for (const tick of ticks) {
      this.visit(this.present, tick);
      call(tick);
    }
    this.core.state.set(now);
  }

  /** Goes back to a tick of a branch: a new branch begins there. @param {number} number @param {number} tick @param {string} why */
  goBack(number, tick, why) {
    const { number: parent } = this.visit(number, tick);
    this.present = parent;
    this.begin(why);
  }

  /** Forgets all that was flown, and begins again where the first branch began. */
  beginAgain() {
    const { begun, copies, why } = /** @type {Branch} */ (this.branches.get(1));
    this.core.state.set(/** @type {Float64Array} */ (copies.get(begun)));
    this.branches.clear();
    this.present = 0;
    this.begin(why);
  }

  /** Flies the way of the present branch again from a tick on. @param {number} tick */
  replay(tick) {
    this.visit(this.present, tick);
    this.replayed = this.present;
  }

  /** Ends a replay where it is: a new branch begins there. @param {string} why */
  takeOver(why) {
    this.goBack(this.replayed, this.core.ticks, why);
  }
}

/** @param {Writes | undefined} writes @param {Float64Array} state */
function put(writes, state) {
  for (const [place, value] of writes ?? []) state[place] = value;
}

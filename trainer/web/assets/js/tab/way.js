// The way shown in a page: the reference crew's run from where it broke, which came with the recording.
import { unpack } from "./core.js";
import { Refusal } from "./orders.js";

/** @typedef {{ branch: import("./flight.js").Recorded, orders: [number, string][] }} Stored */

const FREE = ["freeze", "run", "step", "time", "demonstrate"]; // order words, while it is shown

export class Way {
  /** @param {import("./desk.js").Desk} desk whose recording has been flown @param {Stored} stored */
  constructor(desk, { branch, orders }) {
    const { core, flight } = desk;
    const [present, state] = [flight.present, core.state.slice()];
    flight.take(branch, new Float64Array(unpack(branch.state).buffer));
    flight.present = present;
    core.state.set(state);
    this.desk = desk;
    this.branch = branch;
    this.orders = orders;
    /** @type {{ branch: number, state: Float64Array } | null} where whoever sails goes on afterwards */
    this.left = null;
  }

  /** Refuses what would move the boat while the way is shown. @param {string} name of an order */
  guard(name) {
    if (this.left && !FREE.includes(name)) throw new Refusal("the reference crew shows the way: demonstrate off ends it");
  }

  begin() {
    const { core, flight, pacer } = this.desk;
    if (this.left) throw new Refusal("the way is being shown already");
    if (flight.replayed) throw new Refusal("a replay is running: take over first");
    if (!pacer.frozen) throw new Refusal("time runs: freeze first");
    this.left = { branch: flight.present, state: core.state.slice() };
    flight.present = this.branch.number;
    flight.replay(this.branch.begun);
    this.desk.tellFact("back", "demonstrate");
    const [from, until] = [this.branch.begun, this.branch.last].map((tick) => tick * core.step);
    pacer.run();
    return `the reference crew shows the way from ${from} s to ${until} s; demonstrate off ends it`;
  }

  /** Tells what the crew orders at this tick. */
  speak() {
    for (const [tick, words] of this.left ? this.orders : []) {
      if (tick === this.desk.core.ticks) this.desk.event("shown", `shown: ${words}`);
    }
  }

  /** Goes back to the moment of whoever sails; time stands still there. */
  end() {
    const { left } = this;
    if (!left) throw new Refusal("the way is not being shown");
    const { core, flight, pacer } = this.desk;
    this.left = null;
    pacer.freeze();
    flight.present = left.branch;
    flight.replayed = 0;
    core.state.set(left.state);
    this.desk.tellFact("back", "demonstrate off");
    return `the way has been shown: back at ${core.ticks * core.step} s, frozen`;
  }
}

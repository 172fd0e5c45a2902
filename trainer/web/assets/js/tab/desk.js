// A session in a page: orders in, sentences out, as a session at the other end of a line.
import { BoatOrders, Refusal } from "./orders.js";
import { Core, unpack } from "./core.js";
import { Flight } from "./flight.js";
import { Grammar, NoOrder } from "./grammar.js";
import { Pacer } from "./pace.js";
import { Readings } from "./readings.js";
import { MOMENT, Task } from "./task.js";
import { Visitors } from "./visitors.js";
import { Way } from "./way.js";

/**
 * @typedef {import("./grammar.js").Order} Order
 * @typedef {{ kind: string, tag: string, fields: string[] }} Sentence
 * @typedef {{ ok: boolean, text: string, lines: string[] }} Answer
 * @typedef {{ branches: import("./flight.js").Recorded[], orders: [number, number, string][],
 *   events: [number, number, string, string][], from: string,
 *   exercise: [string, string][], way?: import("./way.js").Stored } & import("./task.js").Asked} Recording
 * @typedef {import("./core.js").Numbers & import("./readings.js").Fittings &
 *   import("./orders.js").Table & { grammar: import("./grammar.js").Table, ranges: [string, string][],
 *   title: string, recording: Recording | null, visitors?: import("./visitors.js").Dive }} Boat
 * @typedef {{ now: () => number, later: (call: () => void, wait: number) => void }} Clock
 */

const SHOWN = 50; // [ms] between readings at most
const ROWS = 360; // of a past
const [SLOWEST, FASTEST] = [0.5, 50];
const PRESENT = ["time", "ledger"]; // channels that have no past
const OFFERED =
  "not in this page: it takes rudder, planes, engine, autopilot, valves, pumps, sea, casualties and time";
const PANELS = ["gauges", "steering", "engine", "diving", "tanks", "air"];
const TALK = ["role", "subscribe", "unsubscribe", "briefing", "history", "casualties", "snapshots", "branches", "who", "log", "status"];

export class Desk {
  /**
   * @param {Core} core
   * @param {Boat} boat
   * @param {(sentences: Sentence[]) => void} send
   * @param {Clock} clock
   */
  constructor(core, boat, send, clock) {
    this.core = core;
    this.boat = boat;
    this.send = send;
    this.clock = clock;
    this.flight = new Flight(core);
    this.readings = new Readings(core, boat);
    this.orders = new BoatOrders(core, boat, boat);
    this.grammar = new Grammar(boat.grammar);
    const gap = (/** @type {number} */ seconds) => this.gap(seconds);
    this.pacer = new Pacer(core.step, clock, { tick: () => this.tick(), gap });
    /** @type {Set<string>} */
    this.channels = new Set();
    /** @type {Sentence[]} */
    this.out = [];
    /** @type {[number, number, string, string][]} branch, tick, kind and text of what has happened */
    this.log = [];
    /** @type {[number, number, string, string][]} branch, tick, what and subject */
    this.facts = [];
    this.shownAt = -Infinity;
    this.failure = "";
    /** @type {Task | null} what a recording is sent for */
    this.task = null;
    /** @type {Way | null} as the reference crew shows it */
    this.way = null;
    /** @type {Visitors | null} whoever dives at a kiosk */
    this.visitors = boat.visitors ? new Visitors(this, boat.visitors) : null;
    this.begin();
  }

  /** @param {Uint8Array<ArrayBuffer>} module @param {Boat} boat @param {(sentences: Sentence[]) => void} send @param {Clock} clock */
  static async open(module, boat, send, clock) {
    return new Desk(await Core.of(module, boat), boat, send, clock);
  }

  /** Begins, or takes up what was recorded. */
  begin() {
    const { recording } = this.boat;
    if (!recording) {
      this.flight.begin("start");
      return;
    }
    for (const branch of recording.branches) {
      this.flight.take(branch, new Float64Array(unpack(branch.state).buffer));
    }
    for (const [branch, tick, text] of recording.orders) this.facts.push([branch, tick, "order", text]);
    this.log.push(...recording.events);
    if (recording.way) this.way = new Way(this, recording.way);
    this.task = new Task(this, recording);
  }

  /** Answers an order. @param {string} words @returns {Answer} */
  answer(words) {
    /** @type {string[]} */
    const lines = [];
    try {
      const text = this.obey(this.grammar.parse(words), lines);
      this.show(true);
      return { ok: true, text, lines };
    } catch (error) {
      if (!(error instanceof NoOrder || error instanceof Refusal)) throw error;
      return { ok: false, text: error.message, lines };
    } finally {
      this.flush();
    }
  }

  /** @param {Order} order @param {string[]} lines of a long answer @returns {string} */
  obey(order, lines) {
    if (TALK.includes(order.name)) return this.talk(order, lines);
    this.way?.guard(order.name);
    if (this.visitors?.takes(order)) return this.visitors.obey(order);
    if (this.orders.takes(order)) return this.steer(order);
    const duty = TIME[/** @type {keyof typeof TIME} */ (order.name)];
    if (!duty) throw new Refusal(`${order.text}: ${OFFERED}`);
    return duty(this, order);
  }

  /** Gives the boat an order. @param {Order} order */
  steer(order) {
    if (this.flight.replayed) throw new Refusal("a replay is running: take over first");
    const told = this.flight.write(() => this.orders.obey(order));
    this.fact("order", order.text);
    return told;
  }

  /** Gives an order of the exercise itself: where it has nothing to do, nothing is done. @param {Order} order */
  attempt(order) {
    try {
      this.steer(order);
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
    }
  }

  // time

  /** Takes a tick; returns whether time goes on. */
  tick() {
    const was = this.flight.replayed;
    this.way?.speak();
    const status = this.flight.tick();
    if (status) this.failure = `a number is out of all bounds after tick ${this.core.ticks}`;
    if (status) this.event("trouble", `FROZEN: ${this.failure}; backtrack or reset`);
    const arrived = was && !this.flight.replayed;
    if (!was) this.task?.play();
    if (arrived) this.event("moment", this.way?.left ? this.way.end() : "the replay is at its end");
    const over = this.task?.isOver || this.visitors?.isOver;
    this.visitors?.guard();
    const goes = !status && !arrived && !over;
    if (!goes) this.pacer.freeze();
    this.show(!goes);
    if (this.task?.isOver) this.tellFact("result", this.task.result);
    this.flush();
    return goes;
  }

  /** Tells that the page was not running. @param {number} seconds */
  gap(seconds) {
    this.event("time", `this page was asleep for ${seconds.toFixed(0)} s: time goes on from where it stood`);
  }

  /** @param {number} branch @param {number} tick @param {Order} order */
  goBack(branch, tick, order) {
    const left = this.core.ticks;
    const abandoned = this.flight.present;
    this.pacer.freeze();
    this.failure = "";
    this.tellBranches();
    this.flight.goBack(branch, tick, order.text);
    this.task?.play();
    this.tellFact("back", order.text);
    this.tellBranches();
    const [from, to] = [left, this.core.ticks].map((at) => (at * this.core.step).toFixed(1));
    return `back from ${from} s to ${to} s, frozen; branch ${this.flight.present} begins, branch ${abandoned} returns to where you were`;
  }

  /** Returns the tick so many seconds ago. @param {number} seconds */
  before(seconds) {
    const tick = this.core.ticks - Math.round(seconds / this.core.step);
    const first = /** @type {import("./flight.js").Branch} */ (this.flight.branches.get(1)).begun;
    if (tick < first) throw new Refusal(`that is before the start, ${(this.core.ticks - first) * this.core.step} s ago`);
    return tick;
  }

  // what is told

  /** @param {Order} order @param {string[]} lines */
  talk(order, lines) {
    const { subject } = order;
    if (order.name === "role") this.join();
    if (order.name === "briefing") this.brief();
    if (order.name === "subscribe") this.subscribe(subject);
    if (order.name === "unsubscribe") this.channels.delete(subject);
    if (order.name === "history") return this.recall(subject, order.value);
    if (order.name === "branches") this.tellBranches();
    if (order.name === "snapshots") this.tellSnapshots();
    if (order.name === "casualties") lines.push(...this.listing());
    if (order.name === "who") lines.push("instructor in this page");
    if (order.name === "log") lines.push(...this.log.slice(-order.value || -10).map(([, , , text]) => text));
    if (order.name === "status") lines.push(...this.status(subject ? [subject] : PANELS));
    return order.name === "role" ? "this page is the whole session" : "";
  }

  join() {
    this.brief();
    this.tellBranches();
    for (const [branch, tick, what, subject] of this.facts) {
      if (this.isPast(branch, tick)) this.put("TRF", tick, what, subject);
    }
    const { recording } = this.boat;
    const hint = `${recording?.from}: drag the time line, take over anywhere`;
    if (recording) this.put("TRE", this.core.ticks, "moment", hint);
    if (this.task) this.tellFact("task", this.task.told);
  }

  /** Returns whether a tick of a branch lies in the present's past. @param {number} branch @param {number} tick */
  isPast(branch, tick) {
    return tick <= this.core.ticks && this.flight.owner(this.flight.present, tick).number === branch;
  }

  brief() {
    const exercise = this.boat.recording?.exercise ?? this.visitors?.exercise ?? [["title", this.boat.title]];
    for (const [key, value] of exercise) this.tellFact("exercise", `${key}=${value}`);
    for (const [key, value] of this.boat.ranges) this.tellFact("range", `${key}=${value}`);
  }

  /** @param {string} channel */
  subscribe(channel) {
    if (channel === "events") return;
    const fields = this.boat.channels[channel];
    if (!fields) throw new Refusal(`no channel ${channel}`);
    this.channels.add(channel);
    this.put("TRN", channel, ...fields.map(([name, unit]) => `${name}:${unit}`));
    this.shownAt = -Infinity;
  }

  listing() {
    return this.boat.casualties.flatMap(({ name, degree, says, told, usual }) => {
      this.tellFact("casualty", `${name},${degree},${says}`);
      if (usual) this.tellFact("degree", usual);
      return [`${name} ${degree}`.trim() + (told ? `    (${told})` : ""), `    ${says}`];
    });
  }

  /** @param {string[]} channels */
  status(channels) {
    return channels.flatMap((channel) => {
      if (!this.boat.channels[channel]) throw new Refusal(`no channel ${channel}`);
      const values = this.readings.values(channel);
      return this.boat.channels[channel].map(([name, unit], at) => `${name} ${values[at]} ${unit}`.trim());
    });
  }

  tellBranches() {
    for (const { number, parent, begun, last, why } of this.flight.branches.values()) {
      const seconds = [begun, last].map((tick) => String(tick * this.core.step));
      this.tellFact("branch", [number, parent, ...seconds, why].join(","));
    }
  }

  tellSnapshots() {
    for (const [name, { tick }] of this.flight.snapshots) if (name !== MOMENT) this.put("TRF", tick, "snapshot", name);
  }

  /** Sends what a channel has shown. @param {string} channel @param {number} lapse [s] */
  recall(channel, lapse) {
    if (PRESENT.includes(channel)) throw new Refusal(`${channel} has no past`);
    const { core, flight } = this;
    const first = Math.max(core.ticks - Math.ceil(lapse / core.step), flight.branches.get(1)?.begun ?? 0);
    this.tellFact("past", `begin,${channel}`);
    if (channel === "events") {
      for (const [branch, tick, kind, text] of this.log) {
        if (tick >= first && this.isPast(branch, tick)) this.put("TRE", tick, kind, text);
      }
    } else if (channel in this.boat.channels) {
      const every = Math.max(Math.ceil((core.ticks - first) / ROWS), 1);
      const ticks = Array.from({ length: Math.floor((core.ticks - first) / every) + 1 }, (_, at) => first + at * every);
      flight.recall(ticks, (tick) => this.put("TRS", channel, tick, ...this.row(channel)));
    }
    this.tellFact("past", `end,${channel}`);
    return `${channel}: what it has shown since ${first * core.step} s`;
  }

  /** @param {string} channel */
  row(channel) {
    return [this.core.ticks * this.core.step, ...this.readings.values(channel)];
  }

  /** Shows the present, at most so often unless it must be seen. @param {boolean} must */
  show(must) {
    const now = this.clock.now();
    if (!must && now - this.shownAt < SHOWN) return;
    this.shownAt = now;
    const { frozen, speed } = this.pacer;
    const { present: branch, replayed } = this.flight;
    const shown = Boolean(this.way?.left);
    this.readings.pace = { frozen, speed, branch, replaying: replayed > 0 && !shown, shown };
    for (const channel of this.channels) this.put("TRS", channel, this.core.ticks, ...this.row(channel));
  }

  /** @param {string} kind @param {string} text */
  event(kind, text) {
    this.log.push([this.flight.present, this.core.ticks, kind, text]);
    this.put("TRE", this.core.ticks, kind, text);
  }

  /** Tells a fact that the time line keeps. @param {string} what @param {string} subject */
  fact(what, subject) {
    this.facts.push([this.flight.present, this.core.ticks, what, subject]);
    this.tellFact(what, subject);
  }

  /** @param {string} what @param {string} subject */
  tellFact(what, subject) {
    this.put("TRF", this.core.ticks, what, subject);
  }

  /** Lets a sentence wait: facts and events begin with their tick. @param {string} kind @param {(string | number)[]} parts */
  put(kind, ...parts) {
    const [tick, ...rest] = parts;
    const timed = kind === "TRF" || kind === "TRE";
    const fields = timed ? [tick, Number(tick) * this.core.step, ...rest] : parts;
    this.out.push({ kind, tag: "", fields: fields.map(String) });
  }

  flush() {
    const { out } = this;
    this.out = [];
    if (out.length) this.send(out);
  }
}

/** Orders about time and moments. @type {Record<string, (desk: Desk, order: Order) => string>} */
const TIME = {
  freeze: (desk) => {
    desk.pacer.freeze();
    return "frozen";
  },
  run: (desk) => {
    if (desk.failure) throw new Refusal(`this boat cannot go on: ${desk.failure}`);
    desk.pacer.run();
    return "running";
  },
  step: (desk, order) => {
    desk.pacer.freeze();
    for (let left = order.value; left > 0 && desk.tick(); left -= 1);
    return `${order.value} tick${order.value > 1 ? "s" : ""}, then frozen`;
  },
  time: (desk, order) => {
    if (!(order.value >= SLOWEST && order.value <= FASTEST)) {
      throw new Refusal(`this page's time goes x${SLOWEST} to x${FASTEST}`);
    }
    desk.pacer.change(order.value);
    return order.text;
  },
  mark: (desk, order) => {
    desk.fact("mark", order.subject);
    return `marked at ${desk.core.ticks * desk.core.step} s`;
  },
  snapshot: (desk, order) => {
    desk.flight.snapshots.set(order.subject, { branch: desk.flight.present, tick: desk.core.ticks });
    desk.fact("snapshot", order.subject);
    return `snapshot ${order.subject}`;
  },
  restore: (desk, order) => {
    const kept = desk.flight.snapshots.get(order.subject);
    if (!kept) throw new Refusal(`no snapshot ${order.subject}`);
    return desk.goBack(kept.branch, kept.tick, order);
  },
  reset: (desk, order) => desk.goBack(1, desk.flight.branches.get(1)?.begun ?? 0, order),
  backtrack: (desk, order) => desk.goBack(desk.flight.present, desk.before(order.value), order),
  branch: (desk, order) => {
    const found = desk.flight.branches.get(order.value);
    if (!found) throw new Refusal(`no branch ${order.value}; the latest is ${desk.flight.branches.size}`);
    return desk.goBack(order.value, found.last, order);
  },
  replay: (desk, order) => {
    const tick = desk.before(order.value);
    desk.flight.replay(tick);
    desk.tellFact("order", order.text);
    desk.pacer.run();
    return `replay from ${tick * desk.core.step} s; take over ends it at any moment`;
  },
  demonstrate: (desk, { word }) => {
    if (!desk.way) throw new Refusal("this page has no reference crew: it comes with the recording of an exercise");
    return word === "off" ? desk.way.end() : desk.way.begin();
  },
  take: (desk, order) => {
    if (order.words !== "take over") throw new Refusal(`${order.text}: ${OFFERED}`);
    if (!desk.flight.replayed) throw new Refusal("no replay is running");
    desk.flight.takeOver("take over");
    desk.task?.play();
    desk.tellFact("back", "take over"); // what was ordered later is not of this branch
    desk.tellBranches();
    return `taken over at ${desk.core.ticks * desk.core.step} s; branch ${desk.flight.present} begins`;
  },
};

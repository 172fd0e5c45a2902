// The session as one page sees it: values, news, orders, alerts. It knows nothing of elements.
import { shared, way } from "./branches.js";
import { CrewOrders } from "./crew.js";
import { FACTS, PAST_FACTS } from "./facts.js";
import { History } from "./history.js";
import { Judgement } from "./judgement.js";
import { OpenAlerts } from "./open-alerts.js";
import { ANEW } from "./order-table.js";
import { mayGive, wordOf } from "./orders.js";
import { Readings, rowOf } from "./readings.js";
import { Recall } from "./recall.js";
import { Signs } from "./signs.js";
import { Stations } from "./stations.js";
import { entryOf, laidIn } from "./told.js";
import { Vessel } from "./vessel.js";
import { say } from "../words.js";

const LATE = 15; // [s] of what instruments showed that a page may have missed and need not ask for
const STALE = 2000; // [ms] without a tick, while time runs, after which readings are old
const LINES = ["line", "wins", "lost"]; // keys of an exercise that come again and again
const MOST = 500; // entries of the log
const WATCH = 250; // [ms] between looks at whether readings have become old

/**
 * @typedef {import("../protocol/line.js").Sentence} Sentence
 * @typedef {import("../protocol/link.js").Answer} Answer
 * @typedef {import("./readings.js").Reading} Reading
 * @typedef {{ seconds: number, kind: string, text: string, speaker: string, words: string }} Told
 *   something that happened; where somebody has said it, who (a role, `schedule`) and in which words
 * @typedef {Told & { branch: number }} Entry with the branch that was flown then, 0 where none is known
 * @typedef {{ number: number, parent: number, begun: number, last: number, why: string }} Branch
 * @typedef {{ name: string, degree: string, says: string }} Casualty
 * @typedef {"connecting" | "role" | "running" | "frozen" | "replay" | "lost" | "ended"} State
 *
 * Who brings the session: a web socket, or a worker with a boat of its own.
 * @typedef {EventTarget & { open(): void, order(words: string): Promise<Answer>, there: boolean,
 *   alone: boolean, why: string, tries: number, settle(): void, redial(): void }} Source
 */

/**
 * Events: `state`, `tick`, `reading` (detail: a reading), `log`, `alerts`, `crew`, `exercise`,
 * `ranges`, `marks`, `line` (time line, branches), `older`, `fact` (see `onFacts`).
 */
export class Session extends EventTarget {
  /**
   * @param {Source} source
   * @param {string} role
   * @param {string[]} channels that the page wants
   * @param {string} [pace] of each, such as `1 hz`; without it they come whenever they change
   */
  constructor(source, role, channels, pace = "") {
    super();
    this.source = source;
    this.alone = source.alone; // nobody else can be aboard, and nobody judges
    this.role = role;
    this.called = ""; // what the page is called in the list of stations, where its role is not enough
    this.channels = channels;
    this.rate = pace ? ` at ${pace}` : "";
    this.readings = new Readings();
    this.history = new History();
    this.crew = new CrewOrders();
    /** @type {State} */
    this.state = "connecting";
    this.refusal = ""; // why the role is not given
    /** @type {Entry[]} */
    this.log = [];
    this.alerts = new OpenAlerts();
    /** @type {Record<string, string>} */
    this.exercise = {};
    /** @type {Record<string, string[]>} */
    this.told = {};
    this.vessel = new Vessel();
    this.ranges = this.vessel.ranges;
    this.bells = this.vessel.bells;
    this.tanks = this.vessel.tanks;
    this.signs = new Signs();
    /** @type {Map<number, Branch>} */
    this.branches = new Map();
    /** @type {Casualty[]} */
    this.casualties = [];
    /** @type {import("./told.js").Plan[]} */
    this.plans = [];
    /** @type {Map<string, string[]>} their usual degrees, by their names */
    this.degrees = new Map();
    this.outcome = "";
    this.judgement = new Judgement();
    this.stations = new Stations();
    this.saying = ""; // who says what comes next, and its words
    this.furthest = 0;
    this.over = false;
    this.tickAt = 0; // [ms] when the last reading came
    this.caughtUp = false;
    this.past = new Recall();
    /** @type {Entry[]} */
    this.earlier = [];
    /** @type {Set<string>} */
    this.due = new Set();
    this.joined = false;

    source.addEventListener("open", () => void this.join());
    source.addEventListener("lost", () => this.lose());
    source.addEventListener("older", () => this.tell("older"));
    source.addEventListener("sentence", (event) =>
      this.hear(/** @type {CustomEvent<Sentence>} */ (event).detail),
    );
  }

  /** Dials the session, and keeps an eye on the age of what it sends. */
  start() {
    this.source.open();
    setInterval(() => this.update(), WATCH);
  }

  /** The boat's time [s]. */
  get seconds() {
    return this.readings.latest.get("time")?.seconds ?? this.furthest;
  }

  /** Whether controls work: there is a line, the role is ours, and nobody replays. */
  get live() {
    if (this.word("time.shown") === "yes") return false; // the reference crew moves them
    return this.state === "running" || this.state === "frozen" || this.state === "ended";
  }

  /** Whether an order is obeyed of this role, as the session stands. @param {string} order */
  may(order) {
    return mayGive(order, this.role, this.state);
  }

  /** What is left of the exercise [s], null where it has no end. */
  get left() {
    const duration = Number(this.exercise.duration);
    return this.exercise.duration ? Math.max(duration - this.seconds, 0) : null;
  }

  /** How fast time goes, 1 where nothing is told. */
  get pace() {
    return this.readings.number("time.speed") ?? 1;
  }

  /** @param {string} place such as `gauges.depth` @returns {number | null} */
  number(place) {
    return this.readings.number(place);
  }

  /** @param {string} place @returns {string} */
  word(place) {
    return this.readings.word(place);
  }

  /**
   * Gives an order, and logs what is refused.
   * @param {string} words
   * @returns {Promise<Answer>}
   */
  async order(words) {
    const answer = await this.source.order(words);
    if (!answer.ok) this.note("refused", `${words}: ${answer.text}`);
    return answer;
  }

  /** Asks something of the page's own, which nobody sees. @param {string} words */
  ask(words) {
    return this.source.order(words);
  }

  /** Takes a token for the role, and dials anew with it. @param {string} word */
  async give(word) {
    const body = `${this.role} ${word}`;
    const kept = await fetch("./word", { method: "POST", body }).catch(() => null);
    this.refusal = kept ? say("that can be no word") : say("the server does not answer");
    if (kept?.ok) this.source.redial();
    else this.tell("state");
  }

  // the line

  async join() {
    const answer = await this.ask(`role ${this.role}`);
    if (!answer.ok) {
      if (!this.source.there) return;
      this.refusal = answer.text;
      this.update();
      return;
    }
    this.source.settle();
    this.refusal = "";
    this.over = false;
    this.caughtUp = false;
    this.joined = true;
    if (this.called) void this.ask(`name ${this.called}`);
    for (const channel of this.channels) void this.ask(`subscribe ${channel}${this.rate}`);
    if (this.role === "instructor") {
      for (const words of ["snapshots", "branches"]) void this.ask(words);
      void this.askCasualties();
    }
    this.update();
  }

  async askCasualties() {
    await this.ask("casualties");
    this.tell("line");
  }

  lose() {
    this.joined = false;
    this.readings.forget();
    this.crew = new CrewOrders();
    this.told = {};
    this.vessel.forget();
    this.past = new Recall();
    this.update();
    for (const what of ["crew", "exercise"]) this.tell(what);
  }

  /** Settles which state the page is in; tells a change. */
  update() {
    const before = this.state;
    this.state = this.found();
    const told = before !== this.state || ["connecting", "lost", "role"].includes(this.state);
    if (told) this.tell("state");
  }

  /** @returns {State} */
  found() {
    if (!this.joined) {
      if (this.refusal) return "role";
      return this.tickAt || this.source.tries > 1 ? "lost" : "connecting";
    }
    const time = this.word("time.time");
    if (this.outcome || this.over) return "ended";
    if (this.word("time.replay") === "yes") return "replay";
    if (time && time !== "running") return "frozen";
    if (this.tickAt && performance.now() - this.tickAt > STALE + 1000) return "lost";
    return time ? "running" : "connecting";
  }

  // what the session says

  /** @param {Sentence} sentence */
  hear(sentence) {
    const { kind, fields } = sentence;
    if (kind === "TRF") this.fact(Number(fields[1]), fields[2], fields[3] ?? "");
    else if (kind === "TRE") this.hearEntry(entryOf(fields, this.saying));
    else if (kind === "TRS" && this.past.has(fields[0])) this.keepPast(this.readings.reading(fields));
    else this.show(this.readings.take(sentence));
  }

  /** @param {Reading | null} reading */
  show(reading) {
    if (!reading) return;
    this.tickAt = reading.at;
    const { channel, seconds } = reading;
    if (channel !== "time" || seconds > this.furthest) this.furthest = Math.max(this.furthest, seconds);
    this.history.add(channel, seconds, rowOf(reading));
    this.dispatchEvent(new CustomEvent("reading", { detail: reading }));
    this.catchUp(seconds);
    this.tell("tick");
    if (channel === "time") this.update();
  }

  /** Asks once for what a page that comes late has not seen. @param {number} seconds */
  catchUp(seconds) {
    if (this.caughtUp) return;
    this.caughtUp = true;
    void this.ask("history events 60 min");
    const seen = this.history.of(this.channels[0]).times.at(-2) ?? 0;
    if (seconds - seen < LATE) return;
    for (const channel of this.channels) {
      if (channel !== "time") void this.ask(`history ${channel} 60 min`);
    }
  }

  /** Takes where the past of a channel begins and ends. @param {string} subject */
  recall(subject) {
    const [which, channel] = subject.split(",");
    if (which === "begin") {
      this.past.begin(channel);
      return;
    }
    const rows = this.past.end(channel);
    if (channel === "events") {
      this.log = laidIn(this.log, this.earlier);
      this.earlier = [];
      this.tell("log");
    } else {
      this.history.recall(channel, rows);
      this.tell("tick");
    }
  }

  /** @param {Reading} reading */
  keepPast(reading) {
    this.past.take(reading.channel, reading.seconds, rowOf(reading));
  }

  /** @param {Told} told */
  hearEntry(told) {
    const entry = { ...told, branch: Math.max(this.present, this.number("time.branch") ?? 0) };
    this.saying = "";
    if (this.past.has("events")) this.earlier.push(entry);
    else this.happened(entry);
  }

  /** @param {Entry} entry */
  happened(entry) {
    this.log.push(entry);
    if (this.log.length > MOST) this.log.shift();
    this.tell("log");
  }

  /** Adds an entry of the page's own. @param {string} kind @param {string} words @param {string} [speaker] */
  note(kind, words, speaker = "") {
    this.happened({ seconds: this.seconds, kind, text: words, speaker, words, branch: this.present });
  }

  /** Takes a fact by its row. @param {number} seconds @param {string} what @param {string} subject */
  fact(seconds, what, subject) {
    const again = this.past.has("events"); // most of it was told when this page came
    if (!again) this.dispatchEvent(new CustomEvent("fact", { detail: { seconds, what, subject } }));
    const [take, ...events] = (again ? PAST_FACTS : FACTS)[what] ?? [];
    take?.(this, subject, seconds);
    for (const event of events) this.tell(event);
  }

  /** Keeps a sign on the time line. @param {number} seconds @param {string} sign its letter, "" for none @param {string} text */
  keep(seconds, sign, text) {
    if (!sign) return;
    this.signs.keep(seconds, sign, text);
    this.tell("line");
  }

  /** @param {string} subject number, parent, begun, last, why */
  branch(subject) {
    const [number, parent, begun, last, ...why] = subject.split(",");
    const [id, from, since, until] = [number, parent, begun, last].map(Number);
    const before = this.present;
    this.branches.set(id, { number: id, parent: from, begun: since, last: until, why: why.join(",") });
    if (before && id > before) this.turn(before, id);
  }

  /** @param {string} subject name, degree and meaning of a casualty on offer */
  offer(subject) {
    const [name, degree = "", ...says] = subject.split(",");
    if (!this.casualties.some((each) => each.name === name)) {
      this.casualties.push({ name, degree, says: says.join(",") });
    }
  }

  /** @param {string} subject a key of the exercise and its value */
  brief(subject) {
    const equals = subject.indexOf("=");
    const [key, value] = [subject.slice(0, equals), subject.slice(equals + 1)];
    if (key === "title" && value !== this.exercise.title) this.begin();
    if (LINES.includes(key)) (this.told[key] ??= []).push(value);
    else this.exercise[key] = value;
  }

  /** @param {string} how the exercise has ended */
  end(how) {
    if (!this.outcome) this.judgement = new Judgement(); // else it is told once more
    this.outcome = how || "ended";
    this.crew.end();
  }

  /** Forgets the exercise before this one. */
  begin() {
    const name = this.exercise.name;
    this.exercise = name ? { name } : {};
    this.told = {};
    this.signs = new Signs();
    this.judgement = new Judgement();
    this.outcome = "";
    this.furthest = 0;
    this.branches.clear();
    this.casualties = [];
    this.plans = [];
    this.alerts = new OpenAlerts();
    this.history.left.clear();
  }

  /**
   * Leaves the way of one branch for that of another, from where they part.
   * @param {number} left
   * @param {number} taken
   */
  turn(left, taken) {
    const from = shared(this.branches, taken, left);
    const parted = from < (this.branches.get(taken)?.begun ?? 0);
    if (!parted && this.number("time.branch") === taken) return; // what came since is its own
    this.setAside(from, left);
    this.signs.cut(from);
    if (parted) this.takeUp(taken, from);
  }

  /** Keeps what was flown after a moment, with the branches on which it was flown. @param {number} seconds @param {number} [branch] */
  setAside(seconds, branch = this.present) {
    const parts = way(this.branches, branch);
    this.past.goBack(seconds);
    this.history.goBack(seconds, parts);
    this.signs.setAside(seconds, parts);
  }

  /** Takes up the past of a branch that was left, from where it differs. @param {number} branch @param {number} from [s] */
  takeUp(branch, from) {
    const parts = way(this.branches, branch);
    this.signs.kept.push(...this.signs.leftOn(parts, from));
    if (!this.history.takeUp(parts, from)) this.forgetPast();
  }

  /** Forgets what channels have shown, where this page has not seen it: the session tells it. */
  forgetPast() {
    this.history.channels.clear();
    this.caughtUp = false;
  }

  /** The branch that is flown: the last one that began. */
  get present() {
    return Math.max(0, ...this.branches.keys());
  }

  /** @param {number} seconds @param {string} order that has brought time there */
  goBack(seconds, order) {
    this.setAside(seconds);
    const last = ANEW.includes(order) ? seconds - 0.001 : seconds;
    this.signs.cut(last);
    this.log = this.log.filter((each) => each.branch || each.seconds <= last);
    if (!this.present && wordOf(order) === "branch") this.forgetPast();
    this.crew.goBack(seconds);
    this.outcome = "";
    this.judgement = new Judgement();
    this.furthest = seconds;
    if (this.role === "instructor") void this.ask("snapshots");
    for (const what of ["line", "crew", "tick", "log", "alerts"]) this.tell(what);
    this.update();
  }

  /** Tells listeners once, however often it changes until they hear it. @param {string} what */
  tell(what) {
    if (this.due.has(what)) return;
    this.due.add(what);
    setTimeout(() => {
      this.due.delete(what);
      this.dispatchEvent(new Event(what));
    }, 0);
  }

  /** @param {string} what @param {(event: Event) => void} listener */
  on(what, listener) {
    this.addEventListener(what, listener);
  }

  /** Has facts heard as they come, before the session takes them. @param {Record<string, (subject: string, seconds: number) => void>} deeds by the facts' names */
  onFacts(deeds) {
    this.on("fact", (event) => {
      const { seconds, what, subject } = /** @type {CustomEvent} */ (event).detail;
      deeds[what]?.(subject, seconds);
    });
  }
}

// Alerts: what calls for eyes, how urgently, and whether it has been seen.
import { TITLES } from "./alert-table.js";
import { limitsOf } from "./limits.js";
import { shortLength } from "../units.js";
import { say, spoken } from "../words.js";

/**
 * @typedef {"emergency" | "alarm" | "warning" | "caution"} Rank
 * @typedef {"active" | "silenced" | "acknowledged" | "rectified"} State as trainer/session/stations/alerts.py has them
 * @typedef {{ key: string, rank: Rank, words: string, seconds: number, number: string, state: State,
 *   owed: boolean, by: string }} Shown one alert; `number` is the session's, "" for one of the page's own; `owed` a look
 * @typedef {{ key: string, rank: Rank, words: string, seconds: number, holds: boolean }} Own
 * @typedef {{ key: string, rank: Rank, words: string }} Found
 * @typedef {import("./session.js").Session} Session
 */

/** @type {Rank[]} the most urgent first */
export const RANKS = ["emergency", "alarm", "warning", "caution"];
export const OFF = 3; // [deg] that a surface may be off its order
const OFF_FOR = 3; // [s]
const STEEP = 30; // [deg] of pitch
const MUTE_TOLD = 2; // of the four ranks, the first ones, whose muting is told
const HELD = 10; // [s] after which an alert that was seen is over, where this page does not find it
const NEAR_LIMIT = 0.8; // of a limit of the exercise, from which the crew is cautioned
const SILENCE = 30_000; // [ms] that Silence lasts (MSC.302(87), 7.3)

/**
 * Keeps the alerts of a page: those of the session, and what its own gauges show. Which of its own
 * were seen or silenced the session keeps for all pages of the station. Event: `change`.
 */
export class Alerts extends EventTarget {
  /** @param {Session} session @param {((session: Session) => Found[])[]} [watches] of this page */
  constructor(session, watches = []) {
    super();
    this.session = session;
    const told = session.role === "instructor"; // by the session, which limits are passed
    this.watches = [link, steepness, ...(told ? [] : [nearLimits]), ...watches];
    this.answers = true; // somebody at this page can acknowledge
    /** @type {Map<string, Own>} */
    this.own = new Map();
    /** @type {Map<string, number>} until when each is silent, perhaps before this page has found it [ms] */
    this.silent = new Map();
    /** @type {Map<string, { seconds: number, held: number | null }>} when each was seen, and when it held last [s] */
    this.seen = new Map();
    session.onFacts({
      back: (_order, seconds) => this.goBack(seconds),
      next: () => this.seen.clear(),
      "own-alert": (subject, seconds) => this.hear(subject, seconds),
    });
    for (const what of ["tick", "state", "alerts"]) session.on(what, () => this.look());
  }

  /** What is shown: what is owed a look first, then by rank, then the newest. @returns {Shown[]} */
  get shown() {
    const now = performance.now();
    const told = [...this.session.alerts.all.values()].map(({ silent, ...alert }) => ({
      ...alert,
      words: titled(alert),
      key: `session-${alert.number}`,
      state: alert.state === "silenced" && now >= silent ? "active" : alert.state,
    }));
    const own = [...this.own.values()].map((alert) => ({ ...alert, number: "", by: "", state: this.stateOf(alert, now) }));
    return [...told, ...own]
      .map((alert) => ({ ...alert, owed: alert.rank !== "caution" && alert.state !== "acknowledged" }))
      .sort(
        (a, b) =>
          Number(b.owed) - Number(a.owed) ||
          RANKS.indexOf(a.rank) - RANKS.indexOf(b.rank) ||
          b.seconds - a.seconds ||
          Number(b.number) - Number(a.number),
      );
  }

  /** @param {Own} own @param {number} now [ms] @returns {State} */
  stateOf({ key, holds }, now) {
    if (this.seen.has(key)) return "acknowledged";
    if (!holds) return "rectified";
    return now < (this.silent.get(key) ?? 0) ? "silenced" : "active";
  }

  /** Looks at the gauges; tells what is new, and what holds no more. */
  look() {
    const found = this.watches.flatMap((watch) => watch(this.session));
    const keys = new Set(found.map((each) => each.key));
    for (const each of found) {
      const before = this.own.get(each.key);
      const worse = before && RANKS.indexOf(each.rank) < RANKS.indexOf(before.rank);
      if (worse) this.end(each.key);
      const again = worse || !before?.holds;
      this.own.set(each.key, { ...each, seconds: again ? this.session.seconds : before.seconds, holds: true });
    }
    for (const [key, alert] of this.own) {
      alert.holds = keys.has(key);
      const owed = alert.rank !== "caution" && !this.seen.has(key) && this.answers;
      if (!alert.holds && (!owed || alert.seconds > this.session.seconds)) this.end(key); // time may have gone back
    }
    if (this.session.tickAt) this.hold(keys);
    this.dispatchEvent(new Event("change"));
  }

  /** Takes an alert as seen, here and in the session. @param {Shown} alert */
  acknowledge(alert) {
    if (alert.number) void this.session.ask(`ack ${alert.number}`);
    else {
      this.see(alert.key, this.session.seconds);
      void this.session.ask(`ack seen ${alert.key}`);
      this.look();
    }
  }

  /** @param {string} key @param {number} seconds */
  see(key, seconds) {
    this.seen.set(key, { seconds, held: null });
  }

  /** Ends what was seen and does not hold here: it was over before this page came. @param {Set<string>} keys of what holds */
  hold(keys) {
    const now = this.session.seconds;
    for (const [key, seen] of this.seen) {
      if (keys.has(key)) seen.held = now;
      seen.held ??= now;
      if (now - seen.held > HELD) this.end(key);
    }
  }

  /** Silences an alert for a while, at all pages of the station. @param {Shown} alert */
  silence({ key, number }) {
    if (!number) this.silent.set(key, performance.now() + SILENCE);
    void this.session.ask(`ack silent ${number || key}`);
  }

  /** Forgets an alert of this page that is over: it is new when it comes again. @param {string} key */
  end(key) {
    const remark = this.own.get(key)?.rank === "caution"; // which nobody sees or silences
    for (const kept of [this.own, this.seen, this.silent]) kept.delete(key);
    if (!remark) void this.session.ask(`ack over ${key}`);
  }

  /** Forgets what was seen after a moment gone back to. @param {number} seconds */
  goBack(seconds) {
    for (const [key, seen] of this.seen) if (seen.seconds > seconds) this.seen.delete(key);
  }

  /** Hears what another page of the station has seen or silenced. @param {string} subject key, state, how long @param {number} seconds */
  hear(subject, seconds) {
    const [key, state, left] = subject.split(",");
    if (state === "seen") this.see(key, seconds);
    else if (state === "over") this.seen.delete(key);
    this.silent.set(key, performance.now() + 1000 * Number(left));
    this.look();
  }
}

/** Returns an alert's words, after its title in a language that the session does not speak. @param {{ name: string, words: string }} alert */
function titled({ name, words }) {
  const title = TITLES[name]?.();
  return title && spoken() !== "en" ? `${title}: ${words}` : words;
}

/** @param {Session} session @returns {Found[]} */
function link(session) {
  if (session.state !== "lost") return [];
  const words = say("No link: readings are old, controls do nothing. It is dialled again.");
  return [{ key: "link", rank: "warning", words }];
}

/** @param {Session} session @returns {Found[]} */
function steepness(session) {
  const pitch = session.number("gauges.pitch") ?? session.number("motion.pitch") ?? 0;
  if (Math.abs(pitch) <= STEEP) return [];
  return [{ key: "pitch", rank: "alarm", words: say("Pitch beyond {0} degrees", STEEP) }];
}

/** Warns who comes near a limit of the exercise, or passes it, by the gauges. @param {Session} session @returns {Found[]} */
function nearLimits(session) {
  const limits = limitsOf(session);
  return [
    ...nearLimit("depth", limits.depth, session.number("gauges.depth"), {
      past: say("Beyond the limit: depth at most {0}", shortLength(limits.depth ?? 0)),
      near: say("Near the limit: depth at most {0}", shortLength(limits.depth ?? 0)),
    }),
    ...nearLimit("pitch", limits.pitch, session.number("gauges.pitch"), {
      past: say("Beyond the limit: pitch at most {0} degrees", limits.pitch ?? 0),
      near: say("Near the limit: pitch at most {0} degrees", limits.pitch ?? 0),
    }),
  ];
}

/**
 * @param {string} name
 * @param {number | null} limit
 * @param {number | null} shown by the gauge
 * @param {{ past: string, near: string }} words
 * @returns {Found[]}
 */
function nearLimit(name, limit, shown, words) {
  if (limit === null || shown === null || Math.abs(shown) < NEAR_LIMIT * limit) return [];
  if (Math.abs(shown) > limit) return [{ key: `past-${name}`, rank: "alarm", words: words.past }];
  return [{ key: `near-${name}`, rank: "caution", words: words.near }];
}

/**
 * Returns a watch on the page's own sound: a caution stands while an alarm is muted.
 * @param {{ on: boolean }} sound
 * @param {() => Shown[]} shown
 */
export function muteWatch(sound, shown) {
  /** @returns {Found[]} */
  return () => {
    const alarmed = shown().some((each) => each.state === "active" && RANKS.indexOf(each.rank) < MUTE_TOLD);
    if (sound.on || !alarmed) return [];
    return [{ key: "muted", rank: "caution", words: say("Sound is off: alarms are not heard") }];
  };
}

/**
 * Returns a watch on a surface: it tells when it stays off its order without coming nearer.
 * @param {string} title with its verb's number: "Rudder off its order"
 * @param {string} actual a place
 * @param {string} ordered a place
 */
export function surfaceWatch(title, actual, ordered) {
  let [since, least] = [Infinity, Infinity];
  /** @param {Session} session @returns {Found[]} */
  return (session) => {
    const [is, wanted] = [session.number(actual), session.number(ordered)];
    const off = is === null || wanted === null ? 0 : Math.abs(is - wanted);
    if (off <= OFF) {
      [since, least] = [Infinity, Infinity];
      return [];
    }
    if (off < least - 0.1 || since > session.seconds) since = session.seconds;
    least = Math.min(least, off);
    if (session.seconds - since < OFF_FOR) return [];
    return [{ key: actual.replaceAll(/\W/g, "-"), rank: "warning", words: title }];
  };
}

export const EMPTY = 1; // [%] of a bank's air, below which it is empty
/** Of a bank's air [%]: what is told below each. @type {[number, Rank][]} */
const AIR = [
  [EMPTY, "alarm"],
  [5, "warning"],
  [20, "caution"],
];

/**
 * Returns a watch on an air bank: it tells when little is left.
 * @param {string} title
 * @param {string} place how full it is [%]
 */
export function bankWatch(title, place) {
  /** @param {Session} session @returns {Found[]} */
  return (session) => {
    const full = session.number(place);
    const [share, rank] = AIR.find(([least]) => full !== null && full < least) ?? [];
    if (!share || !rank) return [];
    const words = share === EMPTY ? say("{0} empty", title) : say("{0} below {1} %", title, share);
    return [{ key: place.replaceAll(/[\W_]/g, "-"), rank, words }];
  };
}

// The moment that the page shows: the present, or one in the past that is looked at.

import { isOnWay, partAt, shared, way } from "../model/branches.js";
import { joined, within } from "../model/history.js";

/**
 * @typedef {import("../model/session.js").Session} Session
 * @typedef {import("../controls/time-line.js").Look} Look
 * @typedef {import("../model/history.js").Past} Past
 */

/** Tells values as they are, or as they were. Event: `look`. */
export class Moment extends EventTarget {
  /** @param {Session} session */
  constructor(session) {
    super();
    this.session = session;
    /** @type {Look | null} */
    this.looking = null;
  }

  /** Looks at a moment, null for the present. @param {Look | null} looking */
  look(looking) {
    this.looking = looking;
    this.dispatchEvent(new Event("look"));
  }

  /** The time that is shown [s]. */
  get seconds() {
    return this.looking?.seconds ?? this.session.seconds;
  }

  /** Returns a value, null where there is none. @param {string} place such as `motion.depth` */
  number(place) {
    if (!this.looking) return this.session.number(place);
    const value = this.value(place);
    return typeof value === "number" ? value : null;
  }

  /** Returns a value as it was sent, "" where there is none. @param {string} place */
  word(place) {
    return this.looking ? String(this.value(place) ?? "") : this.session.word(place);
  }

  /** @param {string} place @returns {unknown} what is known of the moment that is looked at */
  value(place) {
    const [channel, field] = place.split(".");
    return this.row(channel)?.[field];
  }

  /** Returns all values of a channel. @param {string} channel @returns {import("../model/history.js").Row | undefined} */
  row(channel) {
    const { looking, session } = this;
    const { history } = session;
    if (!looking) return session.readings.latest.get(channel)?.values;
    const { branch, seconds } = looking;
    const { branches, present } = session;
    if (branch === null || seconds <= shared(branches, branch, present)) {
      return history.at(channel, seconds);
    }
    return history.leftAt(partAt(way(branches, branch), seconds), channel, seconds);
  }

  /** Returns what a channel has shown up to the moment, on the branch that is looked at. @param {string} channel @returns {Past} */
  past(channel) {
    const { looking, session } = this;
    const { branches, history, present } = session;
    const seen = history.of(channel);
    if (!looking) return seen;
    const { branch, seconds } = looking;
    if (branch === null) return within(seen, -Infinity, seconds);
    const same = Math.min(shared(branches, branch, present), seconds);
    return joined(within(seen, -Infinity, same), history.leftOn(way(branches, branch), channel, same, seconds));
  }

  /** Returns what had happened by the moment, on the branch that is looked at. */
  get log() {
    const { looking, session } = this;
    if (!looking) return session.log;
    const branch = looking.branch ?? session.present;
    return session.log.filter(
      (entry) => entry.seconds <= looking.seconds && isOnWay(session.branches, branch, entry),
    );
  }

  /** Whether a page that came late has not seen this branch. */
  get unseen() {
    return Boolean(this.looking) && !this.row("motion");
  }

  /** Returns what is ordered: by the crew's orders if any stands, else by the autopilot's. @param {...string} places */
  first(...places) {
    for (const place of places) {
      const value = this.number(place);
      if (value !== null) return value;
    }
    return null;
  }
}

/** Where each quantity is told: as it is, and as it is ordered. */
export const PLACES = {
  depth: ["motion.depth", "orders.depth", "diving.ordered_depth"],
  heading: ["motion.heading", "orders.course", "steering.ordered_course"],
  speed: ["motion.speed", "orders.speed", "engine.ordered_speed"],
  pitch: ["motion.pitch", "orders.pitch"],
  heel: ["motion.heel"],
  clearance: ["motion.clearance"],
  sinks: ["motion.depth_rate"],
  rudder: ["steering.rudder", "steering.ordered_rudder"],
  stern: ["diving.stern", "diving.ordered_stern"],
  bow: ["diving.bow", "diving.ordered_bow"],
  turns: ["engine.rpm", "engine.ordered_rpm"],
  mast: ["lookout.mast"],
};

// One boat of a class as its instructor sees it: its session, who is aboard, and what it needs.
import { onArrival } from "../instructor/log.js";
import { RANKS } from "../model/alerts.js";
import { Session } from "../model/session.js";
import { Link } from "../protocol/link.js";
import { say } from "../words.js";

const CHANNELS = ["motion", "orders", "diving", "steering", "engine", "time"];
const PACE = "1 hz"; // so that eight boats cost a page what one does elsewhere
const IDLE = 120; // [s] of the boat's time without an order of its crew
const NOT_CREW = ["instructor", "schedule", ""]; // speakers
const WATCHERS = ["chooser", "wall"]; // pages that nobody works, by what they are called
const OWN = "class"; // what this page is called in a boat's list
const NO_LINE = ["lost", "connecting", "role"];
/** @typedef {{ rank: number, text: string }} Need the greater rank, the sooner it is to be seen */

export class ClassBoat {
  /** @param {import("./boats.js").BoatRow} row @param {string} version of the page */
  constructor(row, version) {
    this.row = row;
    this.link = new Link(version, `./boat/${row.number}/`);
    this.session = new Session(this.link, "instructor", CHANNELS, PACE);
    this.session.called = OWN;
    /** @type {number | null} marks that could still be earned */
    this.attainable = null;
    this.begun = 0; // [s] when this page came: before it, nobody was idle
    this.session.onFacts({
      attainable: (subject) => (this.attainable = Number(subject.split(",")[1])),
      "no-attainable": () => (this.attainable = null),
      next: () => (this.attainable = null),
      asked: () => void this.session.ask("give command"), // of an instructor at the boat's own page
    });
    const look = () => void this.session.ask("who");
    onArrival(this, look);
    this.session.on("state", () => {
      if (this.session.joined) look();
      else this.begun = 0;
    });
  }

  /** Its number, and its name if it has one. */
  get title() {
    return [this.row.number, this.row.name].filter(Boolean).join(" ");
  }

  /** Who is aboard beside instructors: the stations, behind the names that were said. @returns {string[]} */
  get crew() {
    const there = this.session.stations.all.filter(({ role, called }) => role !== "instructor" && !WATCHERS.includes(called));
    const stations = [...new Set(there.map(({ role, called }) => called || role))];
    return stations.length ? [...(this.row.names ?? []), ...stations] : [];
  }

  /** The worst alert that nobody has seen yet, if any. */
  get alert() {
    const open = [...this.session.alerts.all.values()].filter(({ state }) => state !== "acknowledged");
    return open.sort((a, b) => RANKS.indexOf(a.rank) - RANKS.indexOf(b.rank) || b.seconds - a.seconds)[0];
  }

  /** For how long the crew has ordered nothing while time runs [s]. */
  get idle() {
    const { session } = this;
    this.begun ||= session.seconds;
    const last = session.log.findLast(({ speaker }) => !NOT_CREW.includes(speaker));
    return session.state === "running" ? session.seconds - Math.max(last?.seconds ?? 0, this.begun) : 0;
  }

  /** What calls for the instructor, the most urgent first. @returns {Need[]} */
  get needs() {
    const { session, row, alert } = this;
    const dead = row.state && row.state !== "at sea";
    /** @type {(Need | false | undefined)[]} */
    const found = [
      dead ? { rank: 7, text: STATES[row.state ?? ""]?.() ?? "" } : undefined,
      !dead && NO_LINE.includes(session.state) && { rank: 6, text: say("no line") },
      alert && { rank: 5 - Math.min(RANKS.indexOf(alert.rank), 2), text: alert.words },
      Boolean(row.resumed) && session.state === "frozen" && { rank: 4, text: say("resumed from its recording: say run") },
      session.joined && !this.crew.length && { rank: 2, text: say("nobody aboard") },
      this.idle > IDLE && { rank: 2, text: say("no order for {0} min", Math.floor(this.idle / 60)) },
    ];
    return /** @type {Need[]} */ (found.filter(Boolean)).sort((a, b) => b.rank - a.rank);
  }

  /** How soon it is to be seen: what it needs, then how much of its marks is gone. */
  get urgency() {
    return (this.needs[0]?.rank ?? 0) + (this.attainable === null ? 0 : (100 - this.attainable) / 101);
  }
}

/** @type {Record<string, () => string>} */
const STATES = {
  starting: () => say("the boat is being made ready"),
  resuming: () => say("its session has died and is resumed"),
  ended: () => say("its session has ended"),
  away: () => say("its machine does not answer"),
  lost: () => say("it cannot go to sea: see the terminal"),
};

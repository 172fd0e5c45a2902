// What each fact of the session does to what a page knows: a row a fact, by its name on the wire.
import { wordOf } from "./orders.js";
import { planOf, signOf } from "./told.js";
import { say } from "../words.js";

/**
 * @typedef {import("./session.js").Session} Session
 * @typedef {(session: Session, subject: string, seconds: number) => void} Deed
 * @typedef {[Deed, ...string[]]} Row what a fact does, and the events by which a page hears of it
 */

/** What a fact does that the session tells again, to a page that has come late. @type {Record<string, Row>} */
export const PAST_FACTS = {
  past: [(session, subject) => session.recall(subject)],
  chair: [(_session, role) => location.assign(`./${role}${location.search}`)],
  said: [(session, subject) => (session.saying = subject)],
  mark: [(session, remark, seconds) => session.keep(seconds, "M", remark || say("marked"))],
  snapshot: [(session, name, seconds) => session.keep(seconds, "S", name || say("marked"))],
  order: [(session, order, seconds) => session.keep(seconds, signOf(order), order)],
  marks: [({ judgement }, subject) => judgement.mark(subject), "marks"],
  reason: [({ judgement }, subject) => judgement.explain(subject), "marks"],
};

/** What a fact does as it comes; another one only listeners hear. @type {Record<string, Row>} */
export const FACTS = {
  ...PAST_FACTS,
  order: [obey],
  back: [(session, order, seconds) => session.goBack(seconds, order)],
  branch: [(session, subject) => session.branch(subject), "line", "log"],
  exercise: [(session, subject) => session.brief(subject), "exercise"],
  "exercise-over": [(session, how) => session.end(how), "crew", "exercise"],
  range: [({ vessel }, subject) => vessel.take(subject), "ranges"],
  "crew-order": [({ outcome, crew }, order, seconds) => outcome || crew.give(seconds, order), "crew"],
  "own-order": [({ crew }, order) => crew.claim(order), "crew"],
  repeated: [({ crew }, order) => crew.settle(order), "crew"],
  belayed: [({ crew }, order) => crew.settle(order), "crew"],
  "wrong-repeat": [({ crew }, subject) => crew.mishear(subject), "crew"],
  "alert-rank": [({ alerts }, subject) => alerts.rank(subject), "alerts"],
  alert: [({ alerts }, subject, seconds) => alerts.raise(seconds, subject), "alerts"],
  "alert-state": [({ alerts }, subject) => alerts.become(subject), "alerts"],
  alerts: [({ alerts }) => alerts.forget(), "alerts"],
  stations: [({ stations }, count) => stations.expect(Number(count))],
  aboard: [({ stations }, subject) => stations.add(subject)],
  casualty: [(session, subject) => session.offer(subject), "line"],
  degree: [({ degrees }, subject) => degrees.set(subject.split(",")[0], subject.split(","))],
  plans: [(session) => (session.plans = []), "line"],
  planned: [(session, subject) => (session.plans = [...session.plans, planOf(subject)]), "line"],
  over: [(session) => (session.over = true)],
};

/** Takes an order that was obeyed. @param {Session} session @param {string} order @param {number} seconds */
function obey(session, order, seconds) {
  const word = wordOf(order);
  if (word === "replay") session.setAside(seconds);
  if (word === "snapshot") void session.ask("snapshots");
  session.keep(seconds, signOf(order), order);
}

"""The questions to a session, such as ``who``, which change nothing of the run.

``dispatch`` calls the function that ``duties`` has for the order word. The orders ``mark`` and
``ack`` stand here too: they record an event, but move nothing.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from trainer.boat.casualties import available_casualties, casualty_listing, degrees
from trainer.io.orders.grammar import Refused, Reply
from trainer.session.crew.agenda import Agenda
from trainer.session.exercise.evaluation import Evaluation
from trainer.session.past.history import History
from trainer.session.people.shown import ScreenOutput
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.roles import INSTRUCTOR_ROLE
from trainer.session.stations.station import Duty, Fact, LongAnswer, News, Request


@dataclass
class Questions:
    """The answers to questions, and the orders that note a mark or a seen alert."""

    history: History
    log: EventLog
    agenda: Agenda
    shown: ScreenOutput
    evaluation: Evaluation

    @property
    def duties(self) -> Mapping[str, Duty]:
        """Return the functions that answer the questions, by order word."""
        return {
            "status": self._status,
            "what-if": self.evaluation.ask,
            "log": lambda asked: LongAnswer(
                self.log.lately(asked.station.role, int(asked.order.value))
            ),
            "casualties": self._casualties,
            "plans": self._plans,
            "branches": self._branches,
            "snapshots": self._snapshots,
            "mark": self._mark,
            "ack": self._acknowledge,
            "alerts": lambda asked: LongAnswer(
                self.log.account_alerts(asked.station) or ["no alerts"]
            ),
        }

    def _status(self, asked: Request) -> LongAnswer | Refused:
        if channel := asked.order.subject:
            return self.shown.status_of(channel, asked.station)
        lines = self.shown.status(asked.station)
        if asked.station.role is INSTRUCTOR_ROLE:
            lines.append(self.evaluation.status())
        return LongAnswer(lines)

    def _casualties(self, asked: Request) -> LongAnswer:
        boat = self.history.boat
        facts = [Fact("casualty", ",".join(fields)) for fields in available_casualties(boat)]
        facts += [Fact("degree", degree.fields) for degree in degrees(boat)]
        self.log.note(asked.station, facts)
        return LongAnswer(casualty_listing(boat))

    def _plans(self, asked: Request) -> LongAnswer:
        if asked.station.role is INSTRUCTOR_ROLE:
            self.log.note(asked.station, self.agenda.facts(self.history.entry))
        return LongAnswer(self.agenda.listing(self.history.entry))

    def _branches(self, asked: Request) -> LongAnswer:
        stretches = self.history.branches()
        for stretch in stretches:
            now = self.history.tick, self.history.boat.time
            asked.station.note(News(*now, "moment", "", Fact("branch", stretch.fields)))
        return LongAnswer([str(stretch) for stretch in stretches])

    def _snapshots(self, asked: Request) -> str:
        step = self.history.boat.method.step
        moments = self.history.snapshots()
        for name, moment in moments.items():
            seconds = moment.tick * step
            asked.station.note(News(moment.tick, seconds, "moment", "", Fact("snapshot", name)))
        names = [f"{name} ({moment.tick * step:g} s)" for name, moment in moments.items()]
        return f"snapshots: {', '.join(names) or 'none by name'}; backtrack reaches any tick"

    def _acknowledge(self, asked: Request) -> Reply:
        """Take that an alert is seen or silenced. It is in the file before the answer goes out."""
        order = asked.order
        if order.subject:  # named, and not numbered: a page's own
            return self.log.note_own_alert(order, asked.station)
        take = self.log.silence if order.word == "silent" else self.log.acknowledge
        reply = take(order, asked.station)
        self.history.recording.flush()
        return reply

    def _mark(self, asked: Request) -> Reply:
        """Mark this moment. The mark is in the file before the answer goes out."""
        remark = asked.order.subject
        self.log.tell("mark", remark or "marked", asked.station, Fact("mark", remark))
        self.history.recording.flush()
        answer = self.log.as_kept(f"marked at {self.history.boat.time:g} s")
        self.log.tell_trouble()
        return answer

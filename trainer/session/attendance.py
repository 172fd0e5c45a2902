"""Stations come to a session, are told what it is about, are heard, and leave.

The session calls ``listen`` in the thread that ticks, whenever a line has something to read. It
takes the waiting lines of each station, at most 32 at once, because the next tick must not be late
for one talkative station.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Final

from trainer.session.crew.agenda import Agenda
from trainer.session.crew.crew import CrewTalk
from trainer.session.doors.alarm import Alarm
from trainer.session.exercise.conduct import Conduct
from trainer.session.exercise.evaluation import Evaluation
from trainer.session.past.history import History
from trainer.session.people.briefing import Briefing, hint, in_words, ranges
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.roles import INSTRUCTOR_ROLE, STRANGER_ROLE, TRAINEE_ROLE, Role
from trainer.session.stations.station import (
    ORDER_RATE,
    Fact,
    LongAnswer,
    NoReception,
    Reception,
    Request,
    Station,
)

MAX_LINES_AT_ONCE: Final = 32  # of one station before the clock is looked at again
CLOSE_TIMEOUT_S: Final = 0.5  # for a line to get out what it was sent before it is closed


@dataclass(frozen=True)
class Introduction:
    """The first texts about a run for a newcomer: lines for people, facts for programs."""

    instructor: tuple[str, ...] = ()
    crew: tuple[str, ...] = ()  # and everybody else
    exercise: Briefing = field(default_factory=Briefing)


@dataclass
class Attendance:
    """The stations of one session."""

    log: EventLog
    history: History
    conduct: Conduct
    crew: CrewTalk
    agenda: Agenda
    introduction: Introduction
    evaluation: Evaluation
    wake: threading.Event
    hear: Callable[[Request], None]  # an order, and takes the steps that it allows
    reception: Reception = field(default_factory=NoReception)
    until_left: bool = False  # the run ends when the last of those who came by themselves has gone

    def __post_init__(self) -> None:
        self._alarm = Alarm(self.wake.set)

    def greet(self, station: Station) -> None:
        """Send a station its briefing, and some orders that it may give."""
        for line in (*self._briefed(station), hint(station.role, self.crew.work.hand)):
            station.line.send(line)

    def brief(self, asked: Request) -> LongAnswer:
        """Answer the order ``briefing``: send once more what a newcomer gets."""
        station = asked.station
        self._introduce(station)
        facts = [] if asked.heard.machine else in_words(self._exercise_facts(station))
        return LongAnswer((*self._briefed(station), *facts))

    def listen(self) -> None:
        """Admit newcomers, hear the stations, and drop those that have left."""
        self.log.strangers.settle()
        self.log.tell_trouble()
        self.conduct.work.take_results()
        self.conduct.command.tend()
        self._admit_newcomers()
        for station in list(self.log.stations):
            self.log.heard = station
            self._take(station)
            self._alarm.set(station.guesses.wait)
            if held_up := station.allowance.held_up:
                self._alarm.set(held_up)  # what was not taken waits with no word of its own
            elif station.waiting:
                self.wake.set()  # others, and the clock, have their turn before the rest
            elif station.leaving or station.line.ended:
                self._see_out(station)
        self.log.heard = None
        self._alarm.set(self.log.strangers.wait)

    @property
    def silent(self) -> bool:
        """Return whether no station is attached, and none can come."""
        ended = all(station.line.ended for station in self.log.stations)
        return ended and not self.reception.awaited

    def _take(self, station: Station) -> None:
        """Hear the next lines of a station."""
        before = station.role, station.settled
        for request in station.take(MAX_LINES_AT_ONCE):
            before = self._entered(station, before)
            self.hear(request)
        self._entered(station, before)

    def _admit_newcomers(self) -> None:
        """Make stations of the lines that have come since the last call."""
        for station in self.reception.newcomers():
            # a line that still owes a token learns nothing of the session
            if station.role is not STRANGER_ROLE:
                self.greet(station)
            self.log.stations.append(station)
            self.log.strangers.log("station", f"{station.line.name} has come")

    def _entered(self, station: Station, before: tuple[Role, bool]) -> tuple[Role, bool]:
        """Greet or introduce a newcomer; return its role, and whether the line has chosen it."""
        changed = before[1] and station.role is not before[0]  # it has taken another chair
        if changed or (before[0] is STRANGER_ROLE and station.role is not STRANGER_ROLE):
            self.greet(station)
        if station.settled and (changed or not before[1]):  # an observer's role is as before
            self._introduce(station)
        return station.role, station.settled

    def _introduce(self, station: Station) -> None:
        """Tell a program the exercise, the vessel's ranges, and what the crew is ordered."""
        facts = [("exercise", pair) for pair in self._exercise_facts(station)]
        facts += [("range", pair) for pair in ranges(self.history.boat, station.role)]
        facts += [("rate", pair) for pair in ORDER_RATE if station.visits]
        self.log.note(station, [Fact(what, f"{key}={value}") for what, (key, value) in facts])
        self.log.note(station, [each.fact for each in self.crew.standing()])
        self.log.note(station, self.conduct.guide.facts)
        self.log.note(station, self.conduct.marks.facts(station.role))
        if station.role is INSTRUCTOR_ROLE:
            self.log.note(station, self.agenda.facts(self.history.entry))
            self.log.note(station, self.evaluation.facts)
            self.evaluation.hand_over()
        self.log.note_alerts(station)
        self.log.tell_duties()

    def _exercise_facts(self, station: Station) -> list[tuple[str, str]]:
        """Return the facts of the exercise at this moment, as keys and values."""
        role, seconds = station.role, self.history.boat.time
        facts = [*self.introduction.exercise.facts(role, seconds)]
        facts += self.crew.work.conditions(role.name)
        if role is TRAINEE_ROLE:
            facts += self.conduct.training.progress_facts()
        return facts

    def _briefed(self, station: Station) -> tuple[str, ...]:
        """Return the briefing of the exercise for a station."""
        introduction = self.introduction
        return introduction.instructor if station.role is INSTRUCTOR_ROLE else introduction.crew

    def _see_out(self, station: Station) -> None:
        """Close a line in a thread of its own, because closing may wait for its far end."""
        if not station.visits:
            return  # a line that the run was begun with is there to its end
        station.leave()
        self.log.stations.remove(station)
        self.log.tell_duties()
        tell = self.log.tell if station.settled else self.log.strangers.log
        tell("station", f"{station.account()}: {station.leaving or 'gone'}")
        threading.Thread(target=station.close, args=(CLOSE_TIMEOUT_S,), daemon=True).start()
        if self.until_left and not any(each.visits for each in self.log.stations):
            seconds = self.history.boat.time
            self.log.tell("time", f"ended at {seconds:g} s: the last station has left")
            self.conduct.control.ended = True

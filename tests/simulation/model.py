"""What a session should be, told by its lines alone.

The laws ask the product's own tables: which plans are due, who has command, which moment a jump
comes to. This model has tables of its own. It is fed by each order, its answer and each tick, and
says where the session is another. What it knows stands in the documents: docs/instructor.md of
command, docs/exercise-files.md of plans, docs/stations.md of pictures.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import pytest

from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.recording.recording import Recording, RecordingError
from trainer.session.nmea.sentences import InstrumentSet
from trainer.session.past.control import Control
from trainer.session.session import Session
from trainer.session.stations.station import Station
from trainer.session.stations.subscriptions import Publisher
from trainer.session.stations.view import Frame, Pace

KEEP_COMMAND_S: Final = 10.0  # that who has command may answer one who asks for it
JUMP_WORDS: Final = ("restore", "reset", "backtrack", "branch", "again", "restart")
FROZEN_JUMPS: Final = ("restore", "reset", "backtrack", "branch", "again")
# What instructors alone are told, since it gives away what a crew will meet.
INSTRUCTORS_FACTS: Final = ("plans", "planned", "attainable", "no-attainable")
PLAN_WORDS: Final = {"in", "at", "when"}
HEADING_SENTENCE: Final = "$INHDT,"


NamedPlan = tuple[int, str, float]  # its number, its words, and when [s] it is due


class ModelPlan(NamedTuple):
    """An order that an instructor has planned."""

    number: int
    text: str
    seconds: float  # [s] when it is due, infinite for a condition


@dataclass
class Model:
    """What one process should be."""

    tell: Callable[[str], object]  # told what is another
    clock: Callable[[], float]  # [s]
    shown: Callable[[int, int], object]  # told the tick and the branch that are handed over
    plans: dict[int, ModelPlan] = field(default_factory=dict)
    made: dict[NamedPlan, int] = field(default_factory=dict)  # first tick, by every process
    # plans with each snapshot by name and tick: of two alike, that of the branch's own past wins
    kept: dict[tuple[str, int], set[frozenset[NamedPlan]]] = field(default_factory=dict)
    unread: set[tuple[str, int]] = field(default_factory=set)  # kept in a replay: plans untold
    holder: Station | None = None
    asked: dict[int, float] = field(default_factory=dict)  # [s] who asked for command, and when
    to_fly: float = math.inf  # ticks that may come until somebody orders more
    offered: tuple[int, bytes, Pace] | None = None  # the picture that was last handed over

    def begin(self, session: Session) -> None:
        """Begin with a process; what stood before it is believed."""
        self.plans.clear()
        self.asked.clear()
        self.holder = self.offered = None
        self.to_fly = math.inf
        self._believe(session)

    def watch(self, patch: pytest.MonkeyPatch) -> None:
        """Note what is shown. Nothing of it is changed."""
        offer, lines, obey = Publisher.offer, InstrumentSet.lines, Control.obey

        def obey_noted(control: Control, order: Order, who: str) -> Reply:
            reply = obey(control, order, who)
            if not isinstance(reply, Refused):
                self._time(order)
            return reply

        def offer_noted(publisher: Publisher, tick: int, state: bytes, pace: Pace) -> None:
            self.offered = tick, state, pace
            self.shown(tick, pace.branch)
            offer(publisher, tick, state, pace)

        def lines_noted(instruments: InstrumentSet, frame: Frame) -> list[str]:
            said = lines(instruments, frame)
            self._check_instruments(said, frame)
            return said

        patch.setattr(Publisher, "offer", offer_noted)
        patch.setattr(InstrumentSet, "lines", lines_noted)
        patch.setattr(Control, "obey", obey_noted)

    def hear(
        self, session: Session, order: Order, station: Station, reply: object, before: "Before"
    ) -> None:
        """Take an order and its answer, which may come later; compare the session with it."""
        accepted = not isinstance(reply, Refused)
        jumped = accepted and order.name in JUMP_WORDS
        if accepted and not before.replaying:
            self._plan(session, order, before)
        elif accepted and order.name == "snapshot":
            self.unread.add((order.subject, before.tick))
        self._command(session, order, station, before, accepted=accepted)
        if jumped:
            self._check_jump(session, order, before)
        if jumped or order.name == "take":
            self._check_automatic(session, f"after {order.text!r}")
        if session.history.flown.replaying or before.replaying or order.name == "demonstrate":
            self._believe(session)
        elif not session.history.recording.trouble:
            self._check_plans(session, f"after {order.text!r}")
        self._check_moment(session, f"after {order.text!r}")

    def tick(self, session: Session, before: "Before") -> None:
        """Take a tick."""
        flown = session.history.flown
        self._count_tick(session, before)
        if before.replaying or flown.replaying or before.shown or flown.shows_way:
            self._believe(session)
            return
        due = [p for p in self.plans.values() if self._due(session, p.seconds) <= before.tick]
        for plan in due:
            if session.agenda.planned.get(plan.number):
                self.tell(f"tick {before.tick}: plan {plan.number} is due, and still ahead")
            self.plans.pop(plan.number, None)
        self._spend_conditions(session)
        if session.history.tick > before.tick:
            late = [
                entry.order.text
                for entry in session.agenda.schedule[session.history.entry :]
                if self._due(session, entry.seconds) <= before.tick
            ]
            if late:
                self.tell(f"tick {before.tick}: {late} of the exercise are due, and not given")
        self._check_plans(session, f"after tick {before.tick}")
        self._check_moment(session, f"after tick {before.tick}")

    def _time(self, order: Order) -> None:
        """Take an order about time that was accepted: how many ticks may come by it."""
        if order.name in ("run", "replay", "restart"):
            self.to_fly = math.inf
        elif order.name in JUMP_WORDS or (order.name == "freeze" and math.isinf(self.to_fly)):
            self.to_fly = 0.0
        elif order.name == "step":
            self.to_fly = order.value + (0.0 if math.isinf(self.to_fly) else self.to_fly)

    def _count_tick(self, session: Session, before: "Before") -> None:
        """Look whether a tick has come that nobody ordered: after a jump time stands still."""
        history = session.history
        shown = before.shown or history.flown.shows_way
        if shown or history.recording.branch != before.branch:  # by what no line says
            self.to_fly = math.inf
        elif before.replaying and not history.flown.replaying:
            self.to_fly = 0.0
        elif history.tick > before.tick:
            if self.to_fly < 1.0:
                self.tell(f"tick {before.tick}: time goes on, and nobody has ordered that")
            self.to_fly -= 1.0

    def _check_automatic(self, session: Session, when: str) -> None:
        """Look whether the moments in memory are those of the present past."""
        history, recording = session.history, session.history.recording
        whole = not (recording.trouble or recording.missing or history.flown.replaying)
        if not (whole and isinstance(recording, Recording)):
            return
        kept, last = history.automatic, -1
        for index in range(len(kept)):
            moment = kept._at(index)  # noqa: SLF001
            try:
                known = recording.moment(recording.branch, moment.tick)
            except RecordingError:  # the disk is in trouble, which the session has not met yet
                return
            # a branch may begin after orders that came when this was kept
            its = known and (known.state == moment.state or known.after > moment.after)
            if not (its and last < moment.tick <= history.tick and moment.after <= history.after):
                self.tell(f"{when}: of tick {moment.tick} another moment is kept in memory")
            last = moment.tick

    def _due(self, session: Session, seconds: float) -> float:
        step = session.boat.method.step
        return math.ceil(seconds / step - 1e-9) if math.isfinite(seconds) else math.inf

    def _plan(self, session: Session, order: Order, before: "Before") -> None:
        """Take an order about plans that was accepted."""
        if order.name == "plan":
            number = before.last_plan + 1
            now = before.tick * session.boat.method.step
            seconds = math.inf if order.word == "when" else order.value
            seconds += now if order.word == "in" else 0.0
            self.plans[number] = ModelPlan(number, order.subject, seconds)
            named = named_plan(number, order.subject, seconds)
            self.made[named] = min(before.tick, self.made.get(named, before.tick))
        elif order.name == "cancel":
            for number in list(self.plans) if order.word == "all" else [int(order.value)]:
                self.plans.pop(number, None)
        elif order.name == "snapshot":
            self.kept.setdefault((order.subject, before.tick), set()).add(self._named())

    def _named(self) -> frozenset[NamedPlan]:
        return frozenset(named_plan(p.number, p.text, p.seconds) for p in self.plans.values())

    def _spend_conditions(self, session: Session) -> None:
        """Believe that a plan with a condition that is gone was due."""
        for plan in [p for p in self.plans.values() if math.isinf(p.seconds)]:
            if plan.number not in session.agenda.planned:
                del self.plans[plan.number]

    def _command(
        self, session: Session, order: Order, station: Station, before: "Before", *, accepted: bool
    ) -> None:
        """Look whether command is with whom it should be."""
        holder = session.conduct.command.holder
        was = self.holder or before.holder
        self.holder = holder
        if order.name == "command" and accepted:
            self.asked.setdefault(id(station), self.clock())
        if order.name == "keep" and accepted:
            self.asked.clear()
        passed = was is not None and holder is not was
        there = was in session.event_log.stations and not was.line.ended and not was.leaving
        if passed and there and was.role.name == "instructor" and order.name != "give":
            since = self.asked.get(id(holder), math.inf)
            if self.clock() - since < KEEP_COMMAND_S:
                self.tell(f"after {order.text!r}: command is taken from one who may keep it")
        if (
            passed
            and there
            and (taker := self._next_to_command(session, was)) not in (None, holder)
        ):
            self.tell(f"after {order.text!r}: command is not with {taker.line.name}")
        if passed:
            self.asked.clear()

    def _next_to_command(self, session: Session, was: Station) -> Station | None:
        """Return who gets command from one: who asked for it, else who came first of the others."""
        others = [
            each
            for each in session.event_log.stations
            if each.role.name == "instructor" and not (each.line.ended or each.leaving)
            if each is not was
        ]
        asking = [each for each in others if id(each) in self.asked]
        return next(iter(asking or others), None)

    def _check_jump(self, session: Session, order: Order, before: "Before") -> None:
        """Look whether a jump has come to its moment, and the plans with it."""
        tick, text = session.history.tick, repr(order.text)
        if order.name in FROZEN_JUMPS and not session.time.frozen:
            self.tell(f"after {text}: time runs")
        if session.history.recording.branch == before.branch:
            self.tell(f"after {text}: no branch begins")
        whole = not session.history.recording.trouble and not session.history.recording.missing
        if order.name == "backtrack" and whole and not before.replaying:
            wanted = max(before.tick - self._due(session, order.value), 0)
            if tick != wanted:
                self.tell(f"after {text}: tick {tick} in place of {wanted}")
        named = plans_of(session)
        for plan in named:
            if (made := self.made.get(plan, tick)) > tick:
                self.tell(f"after {text}: plan {plan[0]} of tick {made} is ahead at {tick}")
        picture = order.subject, tick
        read = order.name == "restore" and picture not in self.unread
        kept = self.kept.get(picture) if read else None
        if kept and whole and named not in kept:
            were = " or ".join(str(sorted(each)) for each in kept)
            self.tell(f"after {text}: the plans are {sorted(named)}, not {were}")
        self._believe(session)

    def _believe(self, session: Session) -> None:
        """Take over the plans of a session as they are, where lines do not tell them."""
        self.plans = {
            number: ModelPlan(number, plan.order.text, plan.seconds)
            for number, plan in session.agenda.planned.items()
        }

    def _check_plans(self, session: Session, when: str) -> None:
        """Compare the orders ahead."""
        there = plans_of(session)
        if there != self._named():
            self.tell(f"{when}: the plans are {sorted(there)}, not {sorted(self._named())}")
            self._believe(session)

    def _check_moment(self, session: Session, when: str) -> None:
        """Look whether what is shown and what is open is of the present moment."""
        tick = session.history.tick
        late = [a.text for a in session.event_log.alerts.open.values() if a.raised.tick > tick]
        if late:
            self.tell(f"{when}, tick {tick}: alerts of later ticks are open: {late}")
        if self.offered is None:
            return
        shown, _, pace = self.offered
        if shown != tick:
            self.tell(f"{when}: tick {shown} is shown, at tick {tick}")
        elif pace.branch != session.history.recording.branch:
            self.tell(f"{when}: branch {pace.branch} is shown")
        elif pace.frozen != session.time.frozen and session.time.frozen:
            self.tell(f"{when}: time is shown to run, and stands still")

    def _check_instruments(self, said: list[str], frame: Frame) -> None:
        """Look whether the compass is that of the frame."""
        heading = math.degrees(frame.readings.heading) % 360.0
        for line in said:
            if line.startswith(HEADING_SENTENCE):
                told = float(line.split(",")[1])
                apart = abs((told - heading + 180.0) % 360.0 - 180.0)
                if apart > 0.06:
                    self.tell(f"tick {frame.tick}: {line!r}, where the gyro reads {heading:.2f}")


class Before(NamedTuple):
    """What a session was before an order or a tick, for the model."""

    tick: int
    branch: int
    replaying: bool
    shown: bool  # by the reference crew, after whom the boat is back with the plans of before
    last_plan: int
    holder: Any

    @classmethod
    def of(cls, session: Session) -> "Before":
        """Return what a session is."""
        return cls(
            session.history.tick,
            session.history.recording.branch,
            session.history.flown.replaying,
            session.history.flown.shows_way,
            session.agenda.plans.last,
            session.conduct.command.holder,
        )


def plans_of(session: Session) -> frozenset[NamedPlan]:
    """Return the plans of a session."""
    planned = session.agenda.planned.items()
    return frozenset(named_plan(n, plan.order.text, plan.seconds) for n, plan in planned)


def named_plan(number: int, text: str, seconds: float) -> NamedPlan:
    """Return a plan as it is told from others."""
    return number, text, round(seconds, 6)

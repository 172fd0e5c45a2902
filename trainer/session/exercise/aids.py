"""The aids of a trainee: the ghost and the predictor.

The ghost is the reference crew's run. An exercise says which it allows. What is switched on is in
the journal, so that marks can tell of it. ``stations/aids`` has what they show.
"""

from dataclasses import dataclass, field
from functools import partial

from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.recording.facts import Giver
from trainer.io.recording.recording import Moment
from trainer.session.aside import BackgroundTask
from trainer.session.exercise.reference_flight import fly_ghost
from trainer.session.past.history import History
from trainer.session.past.plan import Plan
from trainer.session.people.shown import ScreenOutput
from trainer.session.stations.aids import GhostReading, Predictor, ShownAids
from trainer.session.stations.event_log import EventLog
from trainer.session.stations.past import PastReader

GHOST, PREDICTOR = "ghost", "predictor"
STAYS_ON = "stays on"


@dataclass
class Aids:
    """The aids of one session."""

    history: History
    log: EventLog
    shown: ScreenOutput
    work: BackgroundTask
    past: PastReader
    plan: Plan | None = None
    _on: dict[str, tuple[Order, Giver]] = field(default_factory=dict)  # by name
    _ghost: list[GhostReading] = field(default_factory=list)  # flown once
    _predictor: Predictor | None = None
    _making: set[str] = field(default_factory=set)  # in threads

    def obey(self, order: Order, giver: Giver) -> Reply:
        """Switch an aid on or off; return the answer."""
        name = order.name
        if order.word == "off":
            answer: Reply = f"{name} off" if self._on.pop(name, None) else Refused(f"{name} is off")
        elif refused := self._barred(name):
            return refused
        else:
            self._on[name] = order, giver
            answer = self._switch_on(name, order.value)
        self._show()
        return answer

    def follow(self, _moment: Moment) -> None:
        """Journal again what is on, because a new branch may begin before it was."""
        for order, giver in () if self.history.flown.barred else self._on.values():
            self.history.answered(self.history.order(giver, order), STAYS_ON)

    def _barred(self, name: str) -> Refused | None:
        """Return why an aid may not be switched on, None if it may."""
        if self.plan is None:
            return Refused(f"this session has no {name}")
        if name == GHOST and not self.plan.crew.rules:
            kind = "exercise" if self.plan.title else "free run"
            return Refused(f"this {kind} has no reference crew, whose run the ghost is")
        if name not in self.plan.aids:
            return Refused(f'this exercise does not allow it: its file has no aids = ["{name}"]')
        return None

    def _switch_on(self, name: str, seconds: float) -> Reply:
        """Have an aid made in a thread, if it is not there yet; return the answer."""
        ahead = (
            f" {seconds:g} s ahead, with the controls as they stand" if name == PREDICTOR else ""
        )
        if name == PREDICTOR and self._predictor:
            self._predictor.seconds = seconds
        elif name not in self._making and not (name == GHOST and self._ghost):
            self._making.add(name)
            self._make(name)
        return f"{name} on{ahead}"

    def _make(self, name: str) -> None:
        """Have a thread fly the ghost, or fit the predictor's boat out."""
        plan, work = self.plan, self.work
        assert plan is not None  # noqa: S101 (else it is barred)

        def fail(error: Exception) -> None:
            self._making.discard(name)  # so that it is tried again when it is asked for
            self._on.pop(name, None)
            self.log.tell("trouble", f"no {name}: {type(error).__name__}: {error}")

        if name == GHOST:
            work.begin(name, partial(fly_ghost, plan, work.closing), self._take_ghost, fail)
        else:
            work.begin(name, lambda: Predictor(plan.launch_boat()), self._take_predictor, fail)

    def _take_ghost(self, ghost: list[GhostReading]) -> None:
        self._making.discard(GHOST)
        self._ghost = ghost
        self._show()

    def _take_predictor(self, predictor: Predictor) -> None:
        """Show the predictor as it was ordered last."""
        self._making.discard(PREDICTOR)
        self._predictor = predictor
        if PREDICTOR in self._on:
            predictor.seconds = self._on[PREDICTOR][0].value
        self._show()

    def _show(self) -> None:
        """Show what is on from the next picture on."""
        ghost = self._ghost if GHOST in self._on else ()
        predictor = self._predictor if PREDICTOR in self._on else None
        self.shown.aids = self.past.aids = ShownAids(ghost, predictor)
        self.shown.show()

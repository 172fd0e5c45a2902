"""The agenda: the orders ahead, the exercise's own and those of an instructor.

``dispatch`` asks what is due, and instructors see what is ahead. The exercise's own orders come by
its schedule, and by conditions that the core watches. Instructors plan theirs in the session. The
journal has each plan and each planned order that was given, because a jump in time takes the plans
back too. The session tells the plans to instructors alone, because a plan gives away what the crew
will meet.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.casualties import casualty_refusal, scale_of
from trainer.boat.quantities import is_met
from trainer.config.exercise.derived import Condition, compile_condition
from trainer.config.exercise.exercise import ConditionalCasualty
from trainer.config.exercise.loss_words import word_loss
from trainer.config.files import ConfigError, Position
from trainer.io.orders.grammar import Order, Refused, Reply, condition_words, parse
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.recording.facts import Giver, GiverKind
from trainer.io.status_line import clock
from trainer.session.stations.station import Fact

MAX_PLANS: Final = 40  # plans that may wait at once, and entries of the list that programs get
WHEN_POSITION: Final = Position("when", "")
SPENT_TRIGGERS: Final = STATE_OFFSETS["triggers_spent"]


class ComingOrder(NamedTuple):
    """An order that will be given: its time [s] or condition, and its number."""

    when: float | str
    text: str
    number: int = 0  # for `cancel`; 0: the exercise's own

    @property
    def fact(self) -> Fact:
        """Return this order as a fact for programs."""
        when = f"{self.when:.3f}" if isinstance(self.when, float) else self.when
        return Fact("planned", f"{self.number or ''},{when},{self.text}")

    @property
    def moment(self) -> str:
        """Return its number and when it comes, in words."""
        if isinstance(self.when, str):
            return f"{self.number or 'exercise'}: when {word_loss(self.when)}"
        return f"{self.number or 'exercise'}: at {clock(self.when)}"

    def __str__(self) -> str:
        return f"{self.moment}: {self.text}"


@dataclass(frozen=True)
class PlannedOrder:
    """An order that an instructor has planned, for a time or a condition."""

    number: int
    order: Order
    seconds: float = math.inf  # [s]
    condition: Condition | None = None

    @property
    def ahead(self) -> ComingOrder:
        """Return the planned order as the list of orders ahead has it."""
        when = self.condition.text if self.condition else self.seconds
        return ComingOrder(when, self.order.text, self.number)

    def is_due(self, boat: Boat) -> bool:
        """Return whether the order acts on the next tick."""
        if self.condition:
            return is_met(self.condition, boat)
        return boat.ticks_in(self.seconds) <= boat.ticks


class Plans(NamedTuple):
    """The plans of instructors at one moment."""

    planned: tuple[PlannedOrder, ...] = ()
    last: int = 0  # the number of the newest


@dataclass
class Agenda:
    """The orders ahead of one session."""

    boat: Boat
    schedule: Sequence[ScheduledOrder] = ()
    armed: Sequence[ConditionalCasualty] = ()
    planned: dict[int, PlannedOrder] = field(default_factory=dict)
    _last: int = 0  # the number of the newest
    _told: tuple[object, ...] = ()  # the plans as they were last sent to instructors

    def obey(self, order: Order) -> Reply:
        """Plan an order, or cancel one; return the answer."""
        if order.name == "cancel":
            numbers = ", ".join(map(str, self.planned)) or "none"
            gone = self._drop(order)
            if not gone:
                return Refused(f"no such plan of an instructor's; there is {numbers}")
            return f"cancelled: {', '.join(str(each.ahead) for each in gone)}"
        made = self._made(order, self.boat.time)
        if isinstance(made, Refused):
            return made
        if refused := self._problem(made):
            return refused
        self._take(made)
        return f"planned: {made.ahead}"

    @property
    def plans(self) -> Plans:
        """Return the plans of instructors as they stand now."""
        return Plans(tuple(self.planned.values()), self._last)

    def put_back(self, plans: Plans) -> None:
        """Put back the plans that stood at the moment to which time has jumped."""
        self.planned = {each.number: each for each in plans.planned}
        self._last = plans.last

    def note(self, order: Order, giver: Giver, seconds: float) -> None:
        """Change the plans as an order of the journal did when it was given."""
        if giver.kind is GiverKind.PLAN:
            self.planned.pop(giver.plan, None)
        elif order.name == "cancel":
            self._drop(order)
        elif order.name == "plan":
            made = self._made(order, seconds)
            if isinstance(made, PlannedOrder):
                self._take(made)

    def due(self) -> list[PlannedOrder]:
        """Remove and return the plans that act on the next tick, the earliest first."""
        due_orders = [each for each in self.planned.values() if each.is_due(self.boat)]
        for each in due_orders:
            del self.planned[each.number]
        return sorted(due_orders, key=lambda each: (each.seconds, each.number))

    def ahead(self, entry: int) -> list[ComingOrder]:
        """Return the orders ahead, timed ones first; ``entry`` is the schedule's next entry."""
        scheduled = [ComingOrder(each.seconds, each.order.text) for each in self.schedule[entry:]]
        scheduled += [ahead_of(each) for each in self._waiting()]
        coming = scheduled + [each.ahead for each in self.planned.values()]
        timed = [each for each in coming if isinstance(each.when, float)]
        return [*sorted(timed, key=lambda each: each.when), *(e for e in coming if e not in timed)]

    def facts(self, entry: int) -> list[Fact]:
        """Return the facts that tell the orders ahead to programs, their number first."""
        coming = self.ahead(entry)
        return [Fact("plans", str(len(coming))), *(each.fact for each in coming[:MAX_PLANS])]

    def listing(self, entry: int) -> list[str]:
        """Return the list in words."""
        return [str(each) for each in self.ahead(entry)] or ["nothing is planned"]

    def has_changed(self, entry: int) -> bool:
        """Return whether an order was added or has gone since the last call."""
        before = self._told
        self._told = entry, self.boat.plain[SPENT_TRIGGERS], *self.planned
        return self._told != before

    def _waiting(self) -> list[ConditionalCasualty]:
        """Return the casualties that may still begin by their conditions."""
        spent = int(self.boat.plain[SPENT_TRIGGERS])
        return [
            trigger
            for bit, trigger in enumerate(self.armed)
            if trigger.rule == "again" or not spent >> bit & 1
        ]

    def _made(self, order: Order, now: float) -> PlannedOrder | Refused:
        """Return the plan that an order makes at a time [s]."""
        inner = parse(order.subject)
        if not isinstance(inner, Order):
            return Refused(f"{order.subject}: no order of this version")
        number = self._last + 1
        if order.word != "when":
            return PlannedOrder(number, inner, order.value + (now if order.word == "in" else 0.0))
        words = condition_words(order, inner)
        try:
            return PlannedOrder(number, inner, condition=compile_condition(words, WHEN_POSITION))
        except ConfigError as error:
            return Refused(str(error))

    def _problem(self, made: PlannedOrder) -> Refused | None:
        """Return why an order cannot be planned, None if it can."""
        if len(self.planned) >= MAX_PLANS:
            return Refused(f"{MAX_PLANS} orders are planned: cancel one")
        if made.condition and not scale_of(self.boat, made.condition.quantity):
            return Refused(f"{self.boat.file.path.name} has no {made.condition.quantity}")
        if not made.condition and made.seconds < self.boat.time:
            return Refused(f"{clock(made.seconds)} is past: it is {clock(self.boat.time)}")
        return casualty_refusal(self.boat, made.order) if made.order.name == "casualty" else None

    def _take(self, made: PlannedOrder) -> None:
        self.planned[made.number] = made
        self._last = made.number

    def _drop(self, order: Order) -> list[PlannedOrder]:
        wanted = list(self.planned) if order.word == "all" else [int(order.value)]
        return [self.planned.pop(number) for number in wanted if number in self.planned]


def ahead_of(armed: ConditionalCasualty) -> ComingOrder:
    """Return a casualty that waits for a condition or for a time."""
    condition, casualty = armed.condition, armed.casualty
    timed = condition.quantity == "time" and condition.sense > 0.0
    again = ", again each time" if armed.rule == "again" else ""
    degree = "" if casualty.measure.sudden else f" {casualty.severity:g} ramp {casualty.ramp_s:g}"
    text = f"casualty {casualty.name}{degree}{again}"
    return ComingOrder(condition.threshold if timed else condition.text, text)

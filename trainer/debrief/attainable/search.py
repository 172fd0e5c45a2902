"""The most marks that a few flights from a moment earn.

Each value has its witness: the orders of a flight that earns it, from its moment or a later one.
So a value is a lower bound, and what is said of it is true of a flight. The search ends at the
first continuation that keeps the marks known before, so nearly all flights are near a fall.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from trainer.boat.helm import obey_order
from trainer.boat.mute_crew import MuteCrew, StrictCrew
from trainer.boat.reference_crew import GivenOrder
from trainer.config.exercise.outcome import Outcome
from trainer.core.kernel import Numbers
from trainer.debrief.attainable.continuations import (
    ANGLE_ORDERS,
    Choices,
    Continuation,
    ContinuationKind,
)
from trainer.debrief.marks.reference import can_fly, join_runs
from trainer.debrief.marks.rehearsal import (
    ByReference,
    Departure,
    Flight,
    OrdersByTick,
    Rehearsal,
    depart,
    fly,
    last_tick,
    stretches,
    world_orders_in,
)
from trainer.debrief.marks.scoring import Scorecard
from trainer.debrief.passage.controls import HAND_CONTROLS
from trainer.debrief.passage.trajectory import Trajectory
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.words import ORDER_WORDS
from trainer.io.recording.facts import REFERENCE_GIVER, Giver, GiverKind
from trainer.io.recording.recording import RecordedOrder
from trainer.session.past.plan import Plan

WORTH_MARKS: Final = 3.0  # [%] of marks from which a change is looked into, and told
ENOUGH_MARKS: Final = 1.0  # [%] below what was known before, at which a search ends
STEP_MARKS: Final = 10.0  # [%] below it, with which the few that were best nearby will do
NEAR_S: Final = 60.0  # [s] from a moment that was searched, within which these few are tried first
MOST_NEAR: Final = 3  # of these few


AUTOMATIC_TEXTS: Final = frozenset(word.automatic_order for word in ORDER_WORDS.values())
OWN_WAY: Final = Continuation(ContinuationKind.OWN)


@dataclass(frozen=True)
class NoCurve(Exception):  # noqa: N818 (it is an answer, not a fault)
    """There is no curve, and why."""

    why: str


@dataclass(frozen=True)
class AttainablePoint:
    """The marks to be had from a moment on, and their flight."""

    tick: int
    marks: float  # [%]
    won: bool
    lost: bool
    card: Scorecard | None = None  # of that flight
    since: int = 0  # [tick] from which it is not the crew's own
    way: Continuation = OWN_WAY

    @property
    def fate(self) -> tuple[bool, bool]:
        """Return whether the exercise is won, and whether it is lost."""
        return self.won, self.lost

    def serves(self, marks: float, *, won: bool) -> bool:
        """Return whether it keeps these marks, and the exercise where it was ``won``."""
        return self.marks >= marks and (self.won or not won)


@dataclass(frozen=True)
class OpenMoment:
    """A moment of a run from which it can go on otherwise."""

    here: Departure
    past: Trajectory  # up to there
    own: tuple[RecordedOrder, ...]  # the crew's, up to there
    strict: StrictCrew | None = None  # aboard so far, where it differs


@dataclass
class HandsAtWork(ByReference):
    """The crew's orders; from a tick on the reference crew's hands at planes and rudder."""

    begin: int = 0  # [tick]

    def look(self, given: Sequence[RecordedOrder], tick: int) -> list[GivenOrder]:
        """Follow the orders of this tick; return what the hands order."""
        mute = self.mute
        assert mute is not None  # noqa: S101 (it never speaks)
        looked = {name: hand.looked for name, hand in mute.crew.hands.items()}
        mute.follow(parsed(given))
        said: list[GivenOrder] = []
        if tick >= self.begin:
            for name, hand in mute.crew.hands.items():
                hand.looked = looked.get(name, hand.looked)
                said += mute.crew.steer(hand)
        return said

    def first_sight(self, column: Callable[[str], Numbers], readings: Numbers) -> int:
        """Return after how many ticks a rule may begin, or a hand may order something."""
        assert self.mute is not None  # noqa: S101 (it never speaks)
        return self.mute.crew.first_sight(column, readings)


@dataclass
class ContinuationSearch:
    """The search over what could be done in one exercise."""

    plan: Plan
    judge: Callable[[Trajectory], Scorecard]
    choices: Choices
    later: OrdersByTick  # those that come whoever is the crew
    flown: int = 0  # [ticks]
    tried: dict[int, dict[object, float]] = field(default_factory=dict)  # marks, by tick

    def ways(self, moment: OpenMoment) -> list[Continuation]:
        """Return the continuations of a moment."""
        boat = depart(self.plan, moment.here)
        mute = crew_of(moment.here).aboard(boat)
        for order in parsed(self.later.get(moment.here.tick, ())):
            obey_order(boat, order)
        found = self.choices.of(mute, list(parsed(moment.own)))
        if moment.strict is not None:
            found.append(Continuation(ContinuationKind.STRICT, drops_late=True))
        return found

    def fly(self, moment: OpenMoment, way: Continuation) -> Rehearsal:
        """Return a continuation flown from a moment to the end of the exercise."""
        here = moment.here
        boat = depart(self.plan, here)
        strict = way.kind is ContinuationKind.STRICT and moment.strict
        mute = (strict or crew_of(here)).aboard(boat)
        flight = Flight(self.plan, boat, ByReference(mute=mute, speaks_from=here.tick))
        mute.pass_over(way.settled, drops_late=way.drops_late)
        for tick, until in stretches(here.tick, last_tick(self.plan), self.later):
            flight.give_again(self.later.get(tick, ()))
            if tick == here.tick:
                flight.give_again([order_at(tick, REFERENCE_GIVER, text) for text in way.first])
                if own := [e for e in flight.given if e.giver.kind is not GiverKind.SCHEDULE]:
                    mute.follow(parsed(own))
            if not flight.fly_to(until):
                break
        self.flown += boat.ticks - here.tick
        return flight.rehearsal()

    def point(self, moment: OpenMoment, way: Continuation) -> AttainablePoint:
        """Return what a continuation of a moment earns."""
        tick, flown = moment.here.tick, self.fly(moment, way).trajectory
        card = self.judge(join_runs(moment.past, flown))
        return replace(point_of(tick, card), since=tick, way=way)

    def steer_on(
        self, here: Departure, before: Trajectory, orders: OrdersByTick, begin: int, until: int
    ) -> tuple[Departure, Trajectory]:
        """Return a moment, and the run up to it, steered by hands.

        The other ``orders`` are given; those of surfaces that hands work only before ``begin``.
        """
        boat = depart(self.plan, here)
        mute = crew_of(here).aboard(boat)
        flight = Flight(self.plan, boat, HandsAtWork(mute=mute, speaks_from=math.inf, begin=begin))
        to_world = list(here.to_world)
        for tick, stop in stretches(here.tick, until, orders):
            worked = {name for hand in mute.crew.hands for name in HAND_CONTROLS[hand][1]}
            now = [
                each
                for each in orders.get(tick, ())
                if tick < begin
                or each.name not in worked & ANGLE_ORDERS
                or each.giver.kind is GiverKind.SCHEDULE
                or each.text in AUTOMATIC_TEXTS
            ]
            to_world += world_orders_in(now, tick)
            flight.give_again(now)
            if not flight.fly_to(stop):
                break
        self.flown += boat.ticks - here.tick
        there = Departure(boat.ticks, boat.snapshot(), tuple(to_world), mute)
        return there, join_runs(before, flight.rehearsal().trajectory)

    def fly_on(self, moment: OpenMoment, until: int) -> OpenMoment:
        """Return the moment at a tick to which nobody of the crew orders anything more."""
        run, there = fly(self.plan, moment.here, self.later, until=until)
        return replace(moment, here=there, past=join_runs(moment.past, run.trajectory))

    def best(
        self, moment: OpenMoment, marks: float = 100.0, *, won: bool = True
    ) -> AttainablePoint:
        """Return the best continuation, or the first that keeps the marks and a won exercise."""
        return _best_of(self._found(moment, self.ways(moment), marks - ENOUGH_MARKS, won=won))

    def plainest(self, moment: OpenMoment) -> AttainablePoint:
        """Return the first continuation that earns next to what the best does, with its fate.

        It is what to show: others win a mark or two by orders that look odd.
        """
        found = self._found(moment, self.ways(moment), 100.0 - WORTH_MARKS, won=True)
        best = _best_of(found)
        return next(e for e in found if e.serves(best.marks - WORTH_MARKS, won=best.won))

    def best_near(self, moment: OpenMoment, marks: float, *, won: bool) -> AttainablePoint:
        """Return the best continuation of the recorded run: first those that were best nearby.

        They alone are tried, where they leave a small step down from ``marks``.
        """
        tick, ways = moment.here.tick, self.ways(moment)
        near = sorted(self.tried, key=lambda each: abs(each - tick))[:2]

        def rank(way: Continuation) -> float:
            return max((self.tried[each].get(way.alike, -1.0) for each in near), default=-1.0)

        ways.sort(key=lambda way: -rank(way))
        few: list[Continuation] = []
        if near and abs(near[0] - tick) * self.plan.method.step <= NEAR_S:
            top = max(map(rank, ways))
            kept = [way for way in ways if rank(way) >= max(top - WORTH_MARKS, 0.0)][:MOST_NEAR]
            always = (ContinuationKind.RENEW, ContinuationKind.STRICT)
            few = [*kept, *(w for w in ways if w.kind in always and w not in kept)] if kept else []
        known = dict(self.tried[near[0]]) if few else {}
        self.tried[tick] = known
        if few:
            found = self._found(moment, few, marks - ENOUGH_MARKS, won=won)
            if _best_of(found).serves(marks - STEP_MARKS, won=won):
                return _best_of(found)
            rest = [way for way in ways if way not in few]
            return _best_of([*found, *self._found(moment, rest, marks - ENOUGH_MARKS, won=won)])
        return _best_of(self._found(moment, ways, marks - ENOUGH_MARKS, won=won))

    def _found(
        self, moment: OpenMoment, ways: Sequence[Continuation], enough: float, *, won: bool
    ) -> list[AttainablePoint]:
        """Return what ways earn, up to the first that earns enough marks and wins."""
        found: list[AttainablePoint] = []
        for way in ways:
            point = self.point(moment, way)
            found.append(point)
            if moment.here.tick in self.tried:
                self.tried[moment.here.tick][way.alike] = point.marks
            if point.serves(enough, won=won):
                break
        return found


def _best_of(points: Iterable[AttainablePoint]) -> AttainablePoint:
    return max(points, key=lambda each: (each.marks, each.won))


def crew_of(here: Departure) -> MuteCrew:
    """Return the mute crew that is aboard at a moment."""
    assert here.crew is not None  # noqa: S101 (runs that are searched are followed)
    return here.crew


def parsed(orders: Iterable[RecordedOrder]) -> Iterable[Order]:
    """Yield recorded orders as orders, remarks left out."""
    return (order for each in orders if isinstance(order := parse(each.text), Order))


def order_at(tick: int, giver: Giver, text: str, entry: int | None = None) -> RecordedOrder:
    """Return an order that is still to be given, as a recording would have it."""
    return RecordedOrder(0, 1, tick, giver, text, entry, None, "")


def point_of(tick: int, card: Scorecard) -> AttainablePoint:
    """Return the point of a run's marks."""
    outcome = card.verdict.outcome if card.verdict else Outcome.UNDECIDED
    won, lost = outcome is Outcome.WON, outcome is Outcome.LOST
    return AttainablePoint(tick, card.total or 0.0, won, lost, card, since=tick)


def refuse_plan(plan: Plan) -> None:
    """Raise NoCurve for an exercise without reference crew, end or marks."""
    if not plan.crew.rules:
        raise NoCurve("this exercise has no reference crew")
    if not can_fly(plan):
        raise NoCurve("this exercise has no end, or one that is too far away")
    if not plan.judged_by_tasks:
        raise NoCurve("this exercise has no tasks")


def orders_without(orders: OrdersByTick, left_out: frozenset[int]) -> OrdersByTick:
    """Return orders by tick without some, by their numbers."""
    return {
        tick: [each for each in given if each.id not in left_out] for tick, given in orders.items()
    }

"""The marks that a careful crew could still earn, at each moment of a run.

The recorded run is flown again with the reference crew aboard, mute. At each moment a copy of that
crew takes over and flies the exercise to its end; its marks, with those of the past, are the
moment's. Where they fall the crew has lost something for good: docs/debrief.md, "What each minute
cost".

``data`` asks for the curve for a debrief. ``evaluator`` flies moments of its own while the session
goes on; of this module it uses ``refuse_plan`` and ``point_of``.
"""

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from trainer.boat.mute_crew import WATER_ORDERS, MuteCrew, is_same_order
from trainer.boat.reference_crew import RuleProgress
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.reference_crew import MARK_ORDER, SAID_ORDERS
from trainer.debrief.attainable.changes import (
    MarkChange,
)
from trainer.debrief.attainable.stretches import (
    AttainablePoint,
    finest_period,
)
from trainer.debrief.marks.reference import best_way, can_fly, join_runs
from trainer.debrief.marks.rehearsal import (
    ByReference,
    Departure,
    Flight,
    OrdersByTick,
    Rehearsal,
    depart,
    due_tick,
    fly,
    stretches,
    world_orders_in,
)
from trainer.debrief.marks.scoring import Scorecard
from trainer.debrief.passage.controls import HAND_CONTROLS, opposite_order, share_of
from trainer.debrief.passage.episodes import crew_orders
from trainer.debrief.passage.trajectory import Trajectory, hole_words
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.facts import SCHEDULE_GIVER, Giver, GiverKind
from trainer.io.recording.recording import RecordedOrder
from trainer.session.past.plan import Plan

SUSPECT_TIME_S: Final = 10.0  # [s] before a change begins, in which an order may have caused it
BETTER_TIME_S: Final = 30.0  # [s] from a moment, for which the better orders are told
MAX_BETTER_ORDERS: Final = 2  # told of one moment
CAUSE_SHARE: Final = 0.5  # [-] of a change that a cause must account for
FILE_GIVER: Final = Giver(GiverKind.SCHEDULE, "schedule", "the file of orders")
COMPARED_COLUMNS: Final = ("x", "y", "z", "phi", "theta", "psi", "u")  # of a run flown again
OWN_KINDS: Final = (GiverKind.STATION, GiverKind.PLAN)  # who gives orders of people's own


@dataclass(frozen=True)
class NoCurve(Exception):  # noqa: N818 (it is an answer, not a fault)
    """There is no curve, and why."""

    why: str


@dataclass
class RunExplorer:
    """A recorded run, and what would have come of it from any of its moments."""

    plan: Plan
    trajectory: Trajectory
    judge: Callable[[Trajectory], Scorecard]  # by the rules that count
    progress: Callable[[float], object] = field(default=lambda _: None)  # the share that is flown
    finest: int = field(init=False)  # [ticks] between moments to depart from
    departures: dict[int, Departure] = field(init=False, default_factory=dict)  # by tick
    ways: dict[int, Departure] = field(init=False, default_factory=dict)  # the best, by tick
    points: dict[int, AttainablePoint] = field(init=False, default_factory=dict)
    better: dict[int, list[RecordedOrder]] = field(init=False, default_factory=dict)
    hands: dict[int, dict[str, list[str]]] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self.crew = orders_of_people(self.trajectory, self.plan)
        self.plan = self.plan.alone()
        self.recorded = orders_by_tick(self.trajectory)
        self.later = orders_beside_crew(self.trajectory, self.plan)
        self.step = self.plan.method.step
        self.last = int(self.trajectory.ticks[-1])
        self.finest = finest_period(self.last, self.step)

    def fly_again(self) -> None:
        """Fly the recorded run again; keep moments to depart from.

        NoCurve for a run that has no curve.
        """
        refuse_unfit(self.plan, self.trajectory)
        boat = self.plan.launch_boat()
        crew = MuteCrew(boat, self.plan.crew)
        flight = Flight(self.plan, boat, ByReference(mute=crew, speaks_from=math.inf))
        to_world: list[Any] = []
        moments = {*range(0, self.last, self.finest), *self.recorded}
        for tick, until in stretches(0, self.last, moments):
            if tick % self.finest == 0:
                state = boat.snapshot()
                self.departures[tick] = Departure(tick, state, tuple(to_world), crew.aboard(boat))
            given = self.recorded.get(tick, ())
            to_world += world_orders_in(given, tick)
            flight.give_again(given)
            if not flight.fly_to(until):
                break
        self._compare(flight.rehearsal().trajectory)

    def _compare(self, flown: Trajectory) -> None:
        """Refuse a run that is not the recorded one to the bit."""
        for name in COMPARED_COLUMNS:
            if not np.array_equal(self.trajectory.columns[name], flown.columns[name]):
                raise NoCurve(
                    "the run cannot be flown again to the bit: it is of another core or program"
                )

    def point(self, tick: int) -> AttainablePoint:
        """Return what could be earned from a tick on."""
        if tick not in self.points:
            self.points[tick] = self._point(tick)
        return self.points[tick]

    def _point(self, tick: int) -> AttainablePoint:
        if tick >= self.last:
            return point_of(self.last, self.judge(self.trajectory))
        run = self.from_moment(tick)
        return point_of(tick, self.judge(join_runs(self.trajectory, run.trajectory)))

    def from_moment(self, tick: int, until: int | None = None) -> Rehearsal:
        """Return the reference crew's run from a tick on, to its end or ``until`` another."""
        if tick not in self.ways:
            here = self.departure(tick)
            if here.tick < tick:
                _, here = fly(self.plan, here, self.recorded, until=tick)
            self.ways[tick] = best_way(self.plan, self.trajectory, here, self.later, self.judge)
        return fly(self.plan, self.ways[tick], self.later, speaks_from=tick, until=until)[0]

    def reference_orders(self, tick: int) -> list[RecordedOrder]:
        """Return what the reference crew orders in BETTER_TIME_S from a tick on."""
        if tick not in self.better:
            until = tick + BETTER_TIME_S / self.step
            given = self.from_moment(tick, math.floor(until) + 1).trajectory.orders
            own = (each for each in given if each.giver.kind is GiverKind.REFERENCE)
            self.better[tick] = [each for each in own if each.tick <= until]
        return self.better[tick]

    def with_better(self, change: MarkChange) -> MarkChange:
        """Return a fall with what the reference crew orders from its moment on."""
        if change.marks > 0.0 or not change.told_at < self.last:
            return change
        near = [(each.tick, each.text) for each in self.reference_orders(change.told_at)]
        return replace(change, better=tuple(near[:MAX_BETTER_ORDERS]))

    def soon_by_reference(self, tick: int) -> list[str]:
        """Return what the reference crew orders in SUSPECT_TIME_S from a tick on."""
        if tick >= self.last:
            return []
        until = tick + SUSPECT_TIME_S / self.step
        return [each.text for each in self.reference_orders(tick) if each.tick <= until]

    def without(self, order: RecordedOrder, end: int) -> float:
        """Return the marks attainable at ``end`` if an order before it is left out.

        Water that was moved back since is left where it was, too.
        """
        left_out = {order.id, *(each.id for each in self.taken_back(order))}
        orders = {
            tick: [each for each in given if each.id not in left_out]
            for tick, given in self.recorded.items()
        }
        prefix, there = fly(self.plan, self.departure(order.tick), orders, until=end)
        past = join_runs(self.trajectory, prefix.trajectory)
        if there.tick < end:
            return point_of(there.tick, self.judge(past)).marks
        there = best_way(self.plan, past, there, self.later, self.judge)
        run, _ = fly(self.plan, there, self.later, speaks_from=end)
        return point_of(end, self.judge(join_runs(past, run.trajectory))).marks

    def taken_back(self, order: RecordedOrder) -> list[RecordedOrder]:
        """Return the order that has moved the water of an order back, if one has."""
        text = opposite_order(order.text)
        later = [each for each in self.crew if each.tick > order.tick and each.text == text]
        return later[:1] if order.name in WATER_ORDERS else []

    def departure(self, tick: int) -> Departure:
        """Return the last departure that is not after a tick."""
        return self.departures[max(each for each in self.departures if each <= tick)]

    def pending(self, tick: int) -> list[RuleProgress]:
        """Return the rules of the reference crew that were overdue at a tick."""
        crew = self.departure(tick).crew
        return crew.pending(tick * self.step) if crew else []

    def overdue(self, begin: int, end: int) -> RuleProgress | None:
        """Return the first rule that was overdue in a stretch and still to be given."""
        known: list[str] = []  # that the reference crew would no longer give
        for tick in sorted(each for each in self.departures if begin <= each <= end):
            for late in self.pending(tick):
                text = late.rule.order.text
                if late.rule.order.name in SAID_ORDERS:  # no order of the boat's
                    return late
                if text not in known and tick < self.last:
                    if any(each.text == text for each in self.reference_orders(tick)):
                        return late
                    known.append(text)
        return None

    def due_tick(self, late: RuleProgress) -> int:
        """Return the tick at which the order of a rule was due."""
        return math.ceil((late.due or 0.0) / self.step - 1e-9)

    def wanted(self, tick: int) -> dict[str, list[str]]:
        """Return what each hand of the reference crew would order at a tick."""
        here = self.departure(tick)
        if here.tick not in self.hands:
            crew = here.crew and here.crew.aboard(depart(self.plan, here))
            self.hands[here.tick] = dict(crew.hand_orders()) if crew else {}
        return self.hands[here.tick]

    def by_hand(self, tick: int) -> frozenset[str]:
        """Return the orders that hands of the reference crew give at a tick, by name."""
        return frozenset().union(*(HAND_CONTROLS[hand][1] for hand in self.wanted(tick)))

    def hand_share(self, hand: str, given: RecordedOrder) -> float:
        """Return the share of what a hand of the reference crew wanted then [-]."""
        shares = (share_of(given.text, each) for each in self.wanted(given.tick).get(hand, ()))
        return next(filter(None, shares), 0.0)

    def answer_time(self, hand: str) -> float:
        """Return how long a hand of the reference crew takes to begin [s]."""
        crew = self.plan.crew
        return crew.planesman.answer_s if hand == "planesman" else crew.helmsman.answer_s

    def came(self, order: Order, due: int) -> int | None:
        """Return when [tick] an order that was due was given, None if never."""
        for tick in sorted(each for each in self.recorded if each >= due):
            given = (parse(each.text) for each in self.recorded[tick])
            if any(isinstance(other, Order) and is_same_order(order, other) for other in given):
                return tick
        return None


def point_of(tick: int, card: Scorecard) -> AttainablePoint:
    """Return the point of a run's marks."""
    outcome = card.verdict.outcome if card.verdict else Outcome.UNDECIDED
    won, lost = outcome is Outcome.WON, outcome is Outcome.LOST
    return AttainablePoint(tick, card.total or 0.0, won, lost, card)


def orders_by_tick(trajectory: Trajectory) -> OrdersByTick:
    """Return the accepted orders of a run by tick, marks of ships among them."""
    by_tick: dict[int, list[RecordedOrder]] = defaultdict(list)
    for mark in trajectory.marks:
        giver = Giver(GiverKind.STATION, mark.role, mark.who)
        text = f"{MARK_ORDER} {mark.text}"
        by_tick[mark.tick].append(RecordedOrder(0, 1, mark.tick, giver, text, None, None, ""))
    for entry in trajectory.orders:
        if entry.accepted is not False:
            by_tick[entry.tick].append(entry)
    return by_tick


def orders_of_people(trajectory: Trajectory, plan: Plan) -> tuple[RecordedOrder, ...]:
    """Return the orders that somebody chose: the crew's, and those of ``--orders``."""
    added = {i for i, each in enumerate(plan.schedule) if each not in plan.own_schedule}
    by_file = [
        replace(each, giver=FILE_GIVER)
        for each in trajectory.orders
        if each.entry in added and each.accepted is not False
    ]
    return tuple(sorted((*crew_orders(trajectory), *by_file), key=lambda each: each.tick))


def orders_beside_crew(trajectory: Trajectory, plan: Plan) -> OrdersByTick:
    """Return the orders that come whoever is the crew: of the schedule, and the instructor's."""
    by_tick: dict[int, list[RecordedOrder]] = defaultdict(list)
    for index, entry in enumerate(plan.schedule):
        tick = due_tick(plan, index)
        by_tick[tick].append(
            RecordedOrder(0, 1, tick, SCHEDULE_GIVER, entry.order.text, index, None, "")
        )
    crew = {each.id for each in crew_orders(trajectory)}
    for given in trajectory.orders:
        own = given.giver.kind in OWN_KINDS and given.entry is None
        if own and given.accepted is not False and given.id not in crew:
            by_tick[given.tick].append(given)
    return by_tick


def refuse_plan(plan: Plan) -> None:
    """Raise NoCurve for an exercise without reference crew, end or marks."""
    if not plan.crew.rules:
        raise NoCurve("this exercise has no reference crew")
    if not can_fly(plan):
        raise NoCurve("this exercise has no end, or one that is too far away")
    if not plan.judged_by_tasks:
        raise NoCurve("this exercise has no tasks")


def refuse_unfit(plan: Plan, trajectory: Trajectory) -> None:
    """Raise NoCurve for a run that has no curve."""
    refuse_plan(plan)
    ticks = trajectory.ticks
    if ticks[0] != 0:
        raise NoCurve("the record does not begin at the start")
    if len(ticks) == 1:
        raise NoCurve("nothing was flown")
    if trajectory.holes:
        raise NoCurve(hole_words(trajectory.holes))

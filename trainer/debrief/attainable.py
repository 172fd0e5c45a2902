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
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import pairwise
from typing import Any, Final

import numpy as np

from trainer.boat.mute_crew import MuteCrew, is_same_order
from trainer.boat.reference_crew import RuleProgress
from trainer.config.outcome import Outcome
from trainer.config.reference_crew import MARK_ORDER
from trainer.debrief.attainable_falls import SteepFall, join_falls, parted_falls, steep_falls
from trainer.debrief.attainable_stretches import (
    IDLE_POINTS,
    POINT_PERIODS,
    WORTH_MARKS,
    AttainablePoint,
    MarkStretch,
    changed_stretches,
    finest_period,
    most_tried,
    without_luck,
)
from trainer.debrief.episodes import crew_orders
from trainer.debrief.reference import can_fly, join_runs
from trainer.debrief.rehearsal import (
    ByReference,
    Departure,
    Flight,
    OrdersByTick,
    Rehearsal,
    due_tick,
    fly,
    last_tick,
    stretches,
    world_orders_in,
)
from trainer.debrief.scoring import Scorecard
from trainer.debrief.trajectory import Trajectory
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.words import ORDER_WORDS
from trainer.io.recording.facts import SCHEDULE_GIVER, Giver, GiverKind
from trainer.io.recording.recording import RecordedOrder
from trainer.session.plan import Plan

SUSPECT_TIME_S: Final = 10.0  # [s] before a change begins, in which an order may have caused it
BETTER_TIME_S: Final = 30.0  # [s] from a moment, for which the better orders are told
MAX_BETTER_ORDERS: Final = 2  # told of one moment
CAUSE_SHARE: Final = 0.5  # [-] of a change that a cause must account for
HAND_CONTROLS: Final = {  # what the reference crew's hands work, and the orders that do
    hand: (axis, frozenset(w.name for w in ORDER_WORDS.values() if w.works == axis))
    for hand, axis in (("planesman", "planes"), ("helmsman", "rudder"))
}
FILE_GIVER: Final = Giver(GiverKind.SCHEDULE, "schedule", "the file of orders")
COMPARED_COLUMNS: Final = ("x", "y", "z", "phi", "theta", "psi", "u")  # of a run flown again
OWN_KINDS: Final = (GiverKind.STATION, GiverKind.PLAN)  # who gives orders of people's own


@dataclass(frozen=True)
class NoCurve(Exception):  # noqa: N818 (it is an answer, not a fault)
    """There is no curve, and why."""

    why: str


class ChangeCause(Enum):
    """The causes of a change. The values stand in the figures of a debrief."""

    ORDER = "order"  # one of the crew's
    MISSING = "missing"  # one that did not come
    STEERING = "steering"  # planes or rudder, worked otherwise than by the reference crew
    BETTER = "better"  # than the reference crew did
    RECORD_ENDS = "record-ends"  # before the exercise does


@dataclass(frozen=True)
class MarkChange:
    """A stretch over which the attainable marks fell or rose, and why."""

    begin: int  # [tick]
    end: int
    marks: float  # [%] more at its end than at its begin
    cause: ChangeCause
    order: str = ""  # that was given, or did not come
    tick: int | None = None  # when it was given, or due
    came: int | None = None  # [tick] when one that was missing was given after all
    untouched: tuple[str, ...] = ()  # controls that nobody had worked
    who: str = ""  # gave it
    falls: tuple[SteepFall, ...] = ()  # the steep ones within it
    better: tuple[tuple[int, str], ...] | None = None  # the reference crew's, each with its tick

    @property
    def told_at(self) -> int:
        """Return the tick at which charts have it: of its order, else of its begin."""
        return self.begin if self.tick is None else self.tick


@dataclass(frozen=True)
class AttainableCurve:
    """What could still be earned, over a run."""

    points: tuple[AttainablePoint, ...]
    changes: tuple[MarkChange, ...]
    finest: int = 1  # [ticks] down to which a change is followed

    @property
    def until_won(self) -> int | None:
        """Return the last tick from which the exercise could be won. None: never."""
        return max((each.tick for each in self.points if each.won), default=None)

    @property
    def until_saved(self) -> int | None:
        """Return the last tick from which it need not be lost. None: never."""
        return max((each.tick for each in self.points if not each.lost), default=None)


@dataclass
class RunExplorer:
    """A recorded run, and what would have come of it from any of its moments."""

    plan: Plan
    trajectory: Trajectory
    judge: Callable[[Trajectory], Scorecard]  # by the rules that count
    progress: Callable[[float], object] = field(default=lambda _: None)  # the share that is flown
    finest: int = field(init=False)  # [ticks] between moments to depart from
    departures: dict[int, Departure] = field(init=False, default_factory=dict)  # by tick
    points: dict[int, AttainablePoint] = field(init=False, default_factory=dict)

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
        before = max(each for each in self.departures if each <= tick)
        here = self.departures[before]
        if before < tick:
            _, here = fly(self.plan, here, self.recorded, until=tick)
        run, _ = fly(self.plan, here, self.later, speaks_from=tick, until=until)
        return run

    def with_better(self, change: MarkChange) -> MarkChange:
        """Return a fall with what the reference crew orders from its moment on."""
        if change.marks > 0.0 or not change.told_at < self.last:
            return change
        until = change.told_at + BETTER_TIME_S / self.step
        given = self.from_moment(change.told_at, math.floor(until) + 1).trajectory.orders
        own = [each for each in given if each.giver.kind is GiverKind.REFERENCE]
        near = [(each.tick, each.text) for each in own if each.tick <= until]
        return replace(change, better=tuple(near[:MAX_BETTER_ORDERS]))

    def without(self, order: RecordedOrder, end: int) -> float:
        """Return the marks attainable at ``end`` if an order before it is left out."""
        orders = {
            tick: [each for each in given if each.id != order.id]
            for tick, given in self.recorded.items()
        }
        begin = max(tick for tick in self.departures if tick <= order.tick)
        prefix, there = fly(self.plan, self.departures[begin], orders, until=end)
        past = join_runs(self.trajectory, prefix.trajectory)
        if there.tick < end:
            return point_of(there.tick, self.judge(past)).marks
        run, _ = fly(self.plan, there, self.later, speaks_from=end)
        return point_of(end, self.judge(join_runs(past, run.trajectory))).marks

    def pending(self, tick: int) -> list[RuleProgress]:
        """Return the rules of the reference crew that were overdue at a tick."""
        departure = self.departures.get(tick) or self.departures[max(self.departures)]
        return departure.crew.pending(tick * self.step) if departure.crew else []

    def overdue(self, begin: int, end: int) -> RuleProgress | None:
        """Return the first rule that was overdue in a stretch."""
        ticks = (tick for tick in sorted(self.departures) if begin <= tick <= end)
        return next((late[0] for tick in ticks if (late := self.pending(tick))), None)

    def untouched(self, end: int) -> tuple[str, ...]:
        """Return the controls that the reference crew works, and nobody had by a tick."""
        departure = self.departures.get(end) or self.departures[max(self.departures)]
        hands = departure.crew.crew.hands if departure.crew else {}
        given = {each.name for each in self.crew if each.tick < end}
        return tuple(
            name
            for hand, (name, orders) in HAND_CONTROLS.items()
            if hand in hands and not given & orders
        )

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


# The curve


def attainable_curve(run: RunExplorer) -> AttainableCurve:
    """Return what could be earned at each moment of a run.

    The run has been flown again by ``RunExplorer.fly_again``.
    """
    stride = IDLE_POINTS * POINT_PERIODS * run.finest
    ticks = sorted({*range(0, run.last, stride), run.last} & {*run.departures, run.last})
    for before, after in pairwise(ticks):
        halve(run, before, after)
        run.progress(1.0 - (1.0 - after / run.last) ** 2)  # from later moments less is flown
    points = tuple(run.points[tick] for tick in sorted(run.points))
    cut_short = run.last < last_tick(run.plan) and not points[-1].lost
    flown = points[:-1] if cut_short else points
    level = without_luck(flown, [each.tick for each in run.crew])
    stretches = changed_stretches(level, run.step)
    changes = join_changes(
        change
        for stretch in stretches
        for change in sorted(explain(run, stretch), key=lambda each: each.tick or each.begin)
    )
    rest = points[-1].marks - flown[-1].marks
    if abs(rest) > WORTH_MARKS:
        cause = ChangeCause.RECORD_ENDS
        changes.append(MarkChange(flown[-1].tick, points[-1].tick, rest, cause))
    return AttainableCurve(points, tuple(map(run.with_better, changes)), run.finest)


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
    if int(trajectory.ticks[-1]) < 1 or trajectory.ticks[0] != 0:
        raise NoCurve("the record does not begin at the start")


def halve(run: RunExplorer, before: int, after: int) -> None:
    """Find the points of a stretch, halved where its ends differ or orders lie."""
    first, last, stride = run.point(before), run.point(after), run.finest
    near = after - before <= POINT_PERIODS * stride
    idle = near or not any(before <= each.tick < after for each in run.crew)
    if abs(first.marks - last.marks) <= WORTH_MARKS and first.fate == last.fate and idle:
        return
    middle = before + stride * ((after - before) // stride // 2)
    if middle > before and middle in run.departures:
        halve(run, before, middle)
        halve(run, middle, after)


def join_changes(changes: Iterable[MarkChange]) -> list[MarkChange]:
    """Return the changes, those of one cause that follow each other as one."""
    joined: list[MarkChange] = []
    for change in changes:
        last = joined[-1] if joined else None
        alike = (change.cause, change.order, change.tick, change.untouched)
        if last and alike == (last.cause, last.order, last.tick, last.untouched):
            marks, falls = last.marks + change.marks, join_falls((*last.falls, *change.falls))
            joined[-1] = replace(last, end=change.end, marks=marks, falls=falls)
        else:
            joined.append(change)
    return joined


def suspects(run: RunExplorer, stretch: MarkStretch) -> list[RecordedOrder]:
    """Return the crew's orders that may have caused a fall: those nearest to its begin.

    They came before half of it had. A wrong order costs nothing as long as a careful crew could
    still put it right, so that orders of some seconds before are among them; without any, the last.
    """
    before = stretch.begin.tick - round(SUSPECT_TIME_S / run.step)
    given = [each for each in run.crew if each.tick < stretch.half.tick]
    near = [each for each in given if before <= each.tick] or given[-1:]
    near.sort(key=lambda each: abs(each.tick - stretch.begin.tick))
    return near[: most_tried(run.last)]


def worst_order(run: RunExplorer, stretch: MarkStretch) -> tuple[RecordedOrder, float] | None:
    """Return the order that caused a fall, and its share of it.

    It is left out up to the end of the fall, then up to its half: where nobody does anything else,
    a fatal order saves nothing in the end. There it is named for less, if nothing was overdue.
    """
    given = suspects(run, stretch)
    for point in (stretch.end, stretch.half):
        lost = stretch.begin.marks - point.marks
        if not given or lost <= 0.0 or not (point.tick in run.departures or point.tick >= run.last):
            continue
        saved = {each.id: run.without(each, point.tick) - point.marks for each in given}
        worst = max(given, key=lambda each: saved[each.id])
        alone = point is stretch.half and not run.pending(point.tick)
        if saved[worst.id] >= (WORTH_MARKS if alone else CAUSE_SHARE * lost):
            return worst, min(saved[worst.id] / lost, 1.0)
    return None


def explain(run: RunExplorer, stretch: MarkStretch) -> Iterator[MarkChange]:
    """Yield a change with its cause: the order without which it would not have been.

    What is lost beside that, or without any such order, is that of the order that was overdue, or
    of the way in which planes and rudder were worked.
    """
    begin, end = stretch.begin.tick, stretch.end.tick
    change = MarkChange(begin, end, stretch.marks, ChangeCause.BETTER)
    if change.marks > 0.0:
        yield change
        return
    change = replace(change, falls=steep_falls(stretch, run.finest))
    if worst := worst_order(run, stretch):
        order, share = worst
        rest = (1.0 - share) * change.marks
        share = 1.0 if abs(rest) <= WORTH_MARKS else share
        by_order = replace(change, cause=ChangeCause.ORDER, order=order.text, tick=order.tick)
        by_order = replace(by_order, who=order.who, marks=share * change.marks)
        if share == 1.0:
            yield by_order
            return
        own, others = parted_falls(change.falls, order.tick, share * change.marks, rest)
        yield replace(by_order, falls=own)
        change = replace(change, marks=rest, falls=others)
    if late := run.overdue(begin, end):
        order_due, due = late.rule.order, math.ceil((late.due or 0.0) / run.step - 1e-9)
        missing = replace(change, cause=ChangeCause.MISSING, order=order_due.text, tick=due)
        yield replace(missing, came=run.came(order_due, due))
    else:
        yield replace(change, cause=ChangeCause.STEERING, untouched=run.untouched(end))

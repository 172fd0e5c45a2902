"""A recorded run, and what could still be earned at its moments.

The run is flown again to the bit with the reference crew aboard, mute. From any of its moments it
can then go on otherwise (``search``), or with other orders up to there (``causes``). Marks that
could still be earned never rise: the crew's own orders lead to whatever a later moment has.
"""

import math
from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, Final

import numpy as np

from trainer.boat.mute_crew import MuteCrew, StrictCrew
from trainer.config.exercise.reference_crew import MARK_ORDER
from trainer.config.exercise.score_rules import ANSWER_ORDERS
from trainer.debrief.attainable.continuations import Choices
from trainer.debrief.attainable.search import (
    AttainablePoint,
    ContinuationSearch,
    NoCurve,
    OpenMoment,
    point_of,
    refuse_plan,
)
from trainer.debrief.marks.reference import join_runs
from trainer.debrief.marks.rehearsal import (
    ByReference,
    Departure,
    Flight,
    OrdersByTick,
    due_tick,
    fly,
    last_tick,
    stretches,
    world_orders_in,
)
from trainer.debrief.marks.scoring import Scorecard
from trainer.debrief.passage.episodes import crew_orders
from trainer.debrief.passage.trajectory import Trajectory, hole_words
from trainer.io.recording.facts import SCHEDULE_GIVER, Giver, GiverKind
from trainer.io.recording.recording import RecordedOrder
from trainer.session.past.plan import Plan

FINEST_PERIOD_S: Final = 1.0  # [s] down to which a fall is halved, in a run that is not too long
MAX_TICKS: Final = 350_000  # flown for one debrief: then the curve and its causes are as they are
MAX_FINEST: Final = 4_000  # moments of a run from which to depart
FILE_GIVER: Final = Giver(GiverKind.SCHEDULE, "schedule", "the file of orders")
COMPARED_COLUMNS: Final = ("x", "y", "z", "phi", "theta", "psi", "u")  # of a run flown again
OWN_KINDS: Final = (GiverKind.STATION, GiverKind.PLAN)  # who gives orders of people's own


@dataclass
class RunExplorer:
    """A recorded run, and what would have come of it from any of its moments."""

    plan: Plan
    trajectory: Trajectory
    judge: Callable[[Trajectory], Scorecard]  # by the rules that count
    progress: Callable[[float], object] = field(default=lambda _: None)  # the share that is flown
    departures: dict[int, Departure] = field(init=False, default_factory=dict)  # by tick
    strict: dict[int, StrictCrew] = field(init=False, default_factory=dict)  # by tick
    points: dict[int, AttainablePoint] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self.crew = orders_of_people(self.trajectory, self.plan)
        self.plan = self.plan.alone()
        self.recorded = orders_by_tick(self.trajectory)
        self.step = self.plan.method.step
        self.last = int(self.trajectory.ticks[-1])
        self.finest = finest_period(self.last, self.step)
        later = orders_beside_crew(self.trajectory, self.plan)
        self.search = ContinuationSearch(self.plan, self.judge, Choices(self.plan), later)

    def fly_again(self) -> None:
        """Fly the recorded run again; keep moments to depart from.

        NoCurve for a run that has no curve.
        """
        refuse_plan(self.plan)
        refuse_unfit(self.trajectory)
        self.departures = self._fly_again(MuteCrew)
        crew = max(self.departures.items())[1].crew
        if crew is not None and crew.answered:
            strict = self._fly_again(StrictCrew)
            self.strict = {t: e.crew for t, e in strict.items() if isinstance(e.crew, StrictCrew)}

    def _fly_again(self, kind: type[MuteCrew]) -> dict[int, Departure]:
        boat = self.plan.launch_boat()
        crew = kind(boat, self.plan.crew)
        flight = Flight(self.plan, boat, ByReference(mute=crew, speaks_from=math.inf))
        to_world: list[Any] = []
        found = {}
        moments = {*range(0, self.last, self.finest), *self.recorded}
        for tick, until in stretches(0, self.last, moments):
            if tick % self.finest == 0:
                state = boat.snapshot()
                found[tick] = Departure(tick, state, tuple(to_world), crew.aboard(boat))
            given = self.recorded.get(tick, ())
            to_world += world_orders_in(given, tick)
            flight.give_again(given)
            if not flight.fly_to(until):
                break
        self._compare(flight.rehearsal().trajectory)
        return found

    def _compare(self, flown: Trajectory) -> None:
        """Refuse a run that is not the recorded one to the bit."""
        for name in COMPARED_COLUMNS:
            if not np.array_equal(self.trajectory.columns[name], flown.columns[name]):
                raise NoCurve(
                    "the run cannot be flown again to the bit: it is of another core or program"
                )

    @property
    def cut_short(self) -> bool:
        """Return whether the record ends before the exercise does."""
        return self.last < last_tick(self.plan) and not point_of(0, self.own_card).lost

    @property
    def own_card(self) -> Scorecard:
        """Return the marks of the recorded run."""
        if self._card is None:
            self._card = self.judge(self.trajectory)
        return self._card

    _card: Scorecard | None = field(init=False, default=None)

    def at(self, tick: int) -> OpenMoment:
        """Return a moment of the recorded run."""
        here = self.departure(tick)
        strict = self.strict.get(tick)
        if here.tick < tick:
            _, here = fly(self.plan, here, self.recorded, until=tick)
        own = tuple(each for each in self.crew if each.tick <= tick)
        return OpenMoment(here, self.trajectory, own, strict)

    def point(self, tick: int, marks: float = 100.0, *, won: bool = True) -> AttainablePoint:
        """Return what could be earned from a tick on; search no further than these marks."""
        if tick not in self.points:
            if tick >= self.last:
                self.points[tick] = point_of(self.last, self.own_card)
            else:
                self.points[tick] = self.search.best_near(self.at(tick), marks, won=won)
            self._lift()
        return self.points[tick]

    def _lift(self) -> None:
        """Give each moment what any later one has: the crew itself goes there."""
        best: AttainablePoint | None = None
        for tick in sorted(self.points, reverse=True):
            point = self.points[tick]
            more = best and (best.marks > point.marks or (best.won and not point.won))
            if best is not None and more and not (self.cut_short and best.tick == self.last):
                self.points[tick] = point = replace(best, tick=tick)
            best = point

    def departure(self, tick: int) -> Departure:
        """Return the last departure that is not after a tick."""
        return self.departures[max(each for each in self.departures if each <= tick)]

    def with_orders(
        self, orders: OrdersByTick, since: int, until: int, hands: int | None = None
    ) -> OpenMoment:
        """Return a moment of the run with other orders.

        From the tick ``hands`` on the reference crew's hands work planes and rudder.
        """
        if hands is None:
            flown, there = fly(self.plan, self.departure(since), orders, until=until)
            past = join_runs(self.trajectory, flown.trajectory)
            self.search.flown += there.tick - since
        else:
            here = self.departure(since)
            there, past = self.search.steer_on(here, self.trajectory, orders, hands, until)
        crew = {each.id for each in self.crew}
        given = (each for tick in sorted(orders) for each in orders[tick] if tick <= until)
        own = tuple(e for e in given if e.id in crew or (not e.id and e.name in ANSWER_ORDERS))
        return OpenMoment(there, past, own)

    def due_tick(self, index: int) -> int | None:
        """Return the tick at which a rule's order was due, None if never."""
        return self._due.get(index)

    @property
    def _due(self) -> dict[int, int]:
        if self._known_due is None:
            self._known_due = {}
            for tick in sorted(self.departures):
                crew = self.departures[tick].crew
                for index, each in enumerate(crew.crew.followed if crew else ()):
                    seconds = each.due if each.due is not None else each.given
                    if seconds is not None:
                        due = math.ceil(seconds / self.step - 1e-9)
                        self._known_due.setdefault(index, due)
        return self._known_due

    _known_due: dict[int, int] | None = field(init=False, default=None)


def finest_period(last: int, step: float) -> int:
    """Return how many ticks lie between the nearest moments to depart from."""
    return max(round(FINEST_PERIOD_S / step), math.ceil(last / MAX_FINEST), 1)


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


def refuse_unfit(trajectory: Trajectory) -> None:
    """Raise NoCurve for a run that has no curve."""
    ticks = trajectory.ticks
    if ticks[0] != 0:
        raise NoCurve("the record does not begin at the start")
    if len(ticks) == 1:
        raise NoCurve("nothing was flown")
    if trajectory.holes:
        raise NoCurve(hole_words(trajectory.holes))

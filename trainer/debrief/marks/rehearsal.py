"""An exercise flown without a session, by nobody, its reference crew or given orders.

Debriefs and checks of exercises fly runs by it, because a run beside a recorded one needs no
stations and no clock. It is flown from its start, or from any moment of another run of it.
"""

import functools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import Boat
from trainer.boat.casualties import InstrumentReadings
from trainer.boat.crew_orders import ordered_fact
from trainer.boat.depths import collapse_of, crush_depth, is_crushed
from trainer.boat.due_orders import entries_due
from trainer.boat.flown_ticks import count_before
from trainer.boat.helm import obey_order
from trainer.boat.mute_crew import MuteCrew
from trainer.boat.reference_crew import CrewReaction, GivenOrder, ReferenceCrew
from trainer.boat.world.contacts import Contacts, contacts_in
from trainer.boat.world.encounters import collisions_in, passed_ships
from trainer.boat.world.hulls import POSE_NAMES, OwnHull
from trainer.boat.world.world import WORLD_PARTS
from trainer.config.exercise.reference_crew import MARK_ORDER, Crew
from trainer.core.kernel import Numbers, Record
from trainer.debrief.passage.ships_met import LOOKOUT_ROLE
from trainer.debrief.passage.trajectory import PASSAGE_COLUMNS, FlownRows, Trajectory
from trainer.io.orders.grammar import Order, Refused, Reply, parse
from trainer.io.orders.words import BOAT_ORDERS
from trainer.io.recording.facts import (
    NO_CREW_FACT,
    REFERENCE_GIVER,
    SCHEDULE_GIVER,
    CrewFact,
    Giver,
    GiverKind,
)
from trainer.io.recording.recording import RecordedEvent, RecordedOrder
from trainer.session.past.journal import WorldOrders
from trainer.session.past.layout import LAYOUT
from trainer.session.past.plan import Plan

LOOKOUT_GIVER: Final = Giver(GiverKind.REFERENCE, LOOKOUT_ROLE, LOOKOUT_ROLE)
GAUGE_COUNT: Final = len(InstrumentReadings._fields)
MAX_STRIDE_TICKS: Final = 4096  # ticks flown at once
HULL_COLUMNS: Final = ("z", "theta", "held_depth")
WATCHED_COLUMNS: Final = tuple(dict.fromkeys((*POSE_NAMES, *HULL_COLUMNS)))  # to see a boat lost

ComeAboard = Callable[[Boat, Crew, CrewReaction | None], ReferenceCrew]
OrdersByTick = Mapping[int, Sequence[RecordedOrder]]  # recorded orders, to be given again


@dataclass(frozen=True)
class Rehearsal:
    """The flight of a rehearsal."""

    plan: Plan
    trajectory: Trajectory
    lost: str  # why it ended before its time, "" if it did not
    rules_given: frozenset[int] = frozenset()  # of the reference crew, by their indices

    @property
    def refused(self) -> tuple[RecordedOrder, ...]:
        """Return the orders that the boat refused."""
        return tuple(each for each in self.trajectory.orders if each.accepted is False)


@dataclass(frozen=True)
class Departure:
    """The end of a tick in one run, from which another run can begin."""

    tick: int
    state: Record
    to_world: WorldOrders = ()  # orders before it
    crew: MuteCrew | None = None  # aboard so far


@dataclass
class ByReference:
    """The reference crew at work, or mute until a tick comes."""

    crew: ReferenceCrew | None = None
    mute: MuteCrew | None = None
    speaks_from: float = 0.0  # [tick]

    def look(self, given: Sequence[RecordedOrder], tick: int) -> list[GivenOrder]:
        """Return the orders of this tick; while it is mute it only follows those given."""
        if self.mute is not None and tick >= self.speaks_from:
            self.crew, self.mute = self.mute.speak(), None
        if self.mute is not None:
            parsed = (parse(each.text) for each in given)
            self.mute.follow(order for order in parsed if isinstance(order, Order))
        if self.crew is None:
            return []
        if given:
            self.crew.gauges.look_again()
        return self.crew.look()

    def quiet_ticks(self, step: float) -> float:
        """Return the tick up to which nobody does anything, as long as nobody orders anything."""
        crew, until = self._watcher, self.speaks_from if self.mute else math.inf
        if crew is None:
            return math.inf
        if crew.has_begun_anew:
            return 0
        seconds = crew.next_look()
        return min(math.ceil(seconds / step), until) if math.isfinite(seconds) else until

    def first_sight(self, column: Callable[[str], Numbers], readings: Numbers) -> int:
        """Return after how many ticks the crew may see what it waits for, or all.

        ``column`` and ``readings`` are those of ``ReferenceCrew.first_sight``.
        """
        if self.mute:
            return self.mute.crew.first_cause(column, readings)
        return self.crew.first_sight(column, readings) if self.crew else len(readings)

    def pass_over(self, begun: int, readings: Numbers) -> None:
        """Have the crew know what the gauges read at the ticks after one."""
        if self._watcher is not None and len(readings):
            self._watcher.pass_over(begun, readings)

    @property
    def _watcher(self) -> ReferenceCrew | None:
        """Return who looks at the gauges, mute or not."""
        return self.mute.crew if self.mute else self.crew


def fly_rehearsal(
    plan: Plan,
    crew: Crew | None = None,
    reaction: CrewReaction | None = None,
    come_aboard: ComeAboard = ReferenceCrew,
) -> Rehearsal:
    """Return the exercise flown from start to end, by its schedule and a crew.

    Nobody is aboard where no crew is given. ConfigError if it cannot begin, or has no end.
    """
    boat = plan.launch_boat()
    aboard = ByReference(None if crew is None else come_aboard(boat, crew, reaction))
    flight = Flight(plan, boat, aboard)
    flight.fly_schedule()
    return flight.rehearsal()


@functools.cache
def offsets_of(names: Sequence[str]) -> NDArray[np.int64]:
    """Return where a state has these fields."""
    return np.array([LAYOUT.index(name) for name in names], np.int64)


class Flight:
    """A plan under way without a session: a boat, whoever is aboard, and the journal."""

    def __init__(
        self,
        plan: Plan,
        boat: Boat,
        aboard: ByReference,
        columns: Sequence[str] = PASSAGE_COLUMNS,
    ) -> None:
        """Begin where the boat is, and keep these fields of the state after each tick."""
        self.plan, self.boat, self.aboard = plan, boat, aboard
        self.names = tuple(dict.fromkeys((*columns, *WATCHED_COLUMNS)))
        self.offsets = offsets_of(self.names)
        self.poses = [self.names.index(name) for name in POSE_NAMES]
        self.journal, self.first, self.lost = Journal(boat), boat.ticks, ""
        self.struck = ""  # the ship that the boat ran into
        self.stride = 1  # [ticks] flown at once, while nothing has somebody look sooner
        self.rows = FlownRows(self.names)
        self.rows.append(boat.records.state.view(np.float64)[None, self.offsets])
        contacts = contacts_in(boat)
        ends = contacts is not None and contacts.encounters.collision == "end"
        self.contacts = contacts if ends else None  # those whose touch ends the flight
        self.hull = OwnHull.of(boat)
        self.crush_depth = crush_depth(boat.file.hull)
        self.given: list[RecordedOrder] = []  # in this tick so far

    def give_scheduled(self, entries: Sequence[int]) -> None:
        """Give the orders at some entries of the schedule."""
        for entry in entries:
            order = self.plan.schedule[entry].order
            if order.name in BOAT_ORDERS:  # what is said to people moves nothing
                answer = obey_order(self.boat, order)
                fact = ordered_fact(self.boat, order)
                self.given.append(
                    self.journal.write(SCHEDULE_GIVER, order.text, answer, entry, fact)
                )

    def give_again(self, orders: Sequence[RecordedOrder]) -> None:
        """Give recorded orders again, as they were given."""
        for entry in orders:
            order, fact = parse(entry.text), entry.crew
            if isinstance(order, Order) and order.name == MARK_ORDER:
                self.given.append(entry)
                self.journal.mark(order.subject, entry.giver)
                continue
            reply: Reply = entry.answer
            if isinstance(order, Order) and order.name in BOAT_ORDERS:
                reply = obey_order(self.boat, order)
                fact = ordered_fact(self.boat, order)
            self.given.append(self.journal.repeat(entry, reply, fact))

    def fly_schedule(self) -> None:
        """Fly from start to end by the schedule, whoever is aboard at work."""
        due = entries_due(self.boat, self.plan.schedule)
        for tick, until in stretches(0, last_tick(self.plan), due):
            self.give_scheduled(due.get(tick, ()))
            if not self.fly_to(until):
                break

    def fly_to(self, until: int) -> bool:
        """Fly to a tick, whoever is aboard at work; return whether the boat goes on."""
        with np.errstate(all="ignore"):
            while self.boat.ticks < until and not self.lost:
                orders = self.aboard.look(self.given, self.boat.ticks)
                self.journal.note(orders)
                self.given = []
                self.stride = min(2 * self.stride, MAX_STRIDE_TICKS)
                quiet = self.aboard.quiet_ticks(self.plan.method.step)
                quiet = min(max(self.boat.ticks + 1, quiet), self.boat.ticks + self.stride, until)
                self._advance(int(quiet))
        return not self.lost

    def _advance(self, until: int) -> None:
        """Fly on to a tick at which somebody looks again, or to where the boat is lost."""
        boat, begun = self.boat, self.boat.ticks
        width = self.offsets.size
        rows = np.empty((until - begun, width + GAUGE_COUNT))
        status, rows = boat.fly_and_keep(self.offsets, rows, lambda rows: self._keep(begun, rows))
        self.stride = max(len(rows), 1)
        failure = boat.failure(status) if status else ""
        hit = self.struck and f"collision with {self.struck}"
        self.lost = collapse_of(boat) or hit or failure
        self.rows.append(rows)
        self.aboard.pass_over(begun, rows[:, width:])

    def _keep(self, begun: int, rows: Numbers) -> int:
        """Return after how many rows since a tick somebody has to look, or the boat is lost."""
        if len(rows) > 1:
            column = functools.partial(self._column, rows)
            rows = rows[: self.aboard.first_sight(column, rows[:, self.offsets.size :])]
        count, self.struck = self._end(begun, rows)
        return count

    def _column(self, rows: Numbers, name: str) -> Numbers:
        """Return a field of the state in some rows."""
        return rows[:, self.names.index(name)]

    def _end(self, begun: int, rows: Numbers) -> tuple[int, str]:
        """Return how many rows since a tick there are to the loss of the boat, or in all.

        Return the ship too that it then runs into, "" for none.
        """
        count = len(rows)
        if count > 1 and float(self._column(rows, "z").max()) >= self.crush_depth:
            columns = (self._column(rows, name) for name in HULL_COLUMNS)
            crushed = is_crushed(self.boat.file.hull, *columns)
            count = min(count_before(crushed) + 1, count)
        contacts, hull = self.contacts, self.hull
        if contacts is None or not count or self._is_clear(contacts, hull, begun, rows[:count]):
            return count, ""
        poses = np.vstack([self.rows.last[self.poses], rows[:count, self.poses]])
        ticks = np.arange(begun, begun + len(poses), dtype=np.int64)
        passed = passed_ships(contacts, ticks, poses.T)
        struck = collisions_in(passed, hull, poses.T)
        return struck[0] if struck else (count, "")

    def _is_clear(self, contacts: Contacts, hull: OwnHull, begun: int, rows: Numbers) -> bool:
        """Return whether no ship can have come near in the rows since a tick.

        A ship that the water carries, or that has a rudder, may go faster than its kind.
        """
        here, there = self.rows.last[self.poses[:2]], rows[:, self.poses[:2]]
        own = float(np.abs(there - here).max(axis=0).sum())  # [m] at most
        seconds, (north, east) = len(rows) * self.plan.method.step, here.tolist()
        fleet = contacts.fleet(begun)
        for ship, motion in zip(fleet.order, fleet.motions(begun), strict=True):
            apart = math.hypot(motion.north - north, motion.east - east)
            gone = own + ship.type.fastest * seconds
            if ship.drifts or ship.steered or not hull.far(apart - gone, 0.0, ship.body):
                return False
        return True

    def rehearsal(self) -> Rehearsal:
        """Return what was flown so far."""
        columns = self.rows.columns()
        count = len(columns["z"])
        trajectory = Trajectory(
            boat=self.boat,
            limits=self.plan.limits,
            orders=tuple(self.journal.entries),
            ticks=np.arange(self.first, self.first + count, dtype=np.int64),
            columns=columns,
            lateness=np.full(count, np.nan),
            work=np.full(count, np.nan),
            marks=tuple(self.journal.marks),
        )
        followed = self.aboard.crew.followed if self.aboard.crew else []
        given = frozenset(i for i, each in enumerate(followed) if each.given is not None)
        return Rehearsal(self.plan, trajectory, self.lost, given)


def fly(
    plan: Plan,
    since: Departure,
    orders: OrdersByTick,
    speaks_from: float = math.inf,
    until: int | None = None,
) -> tuple[Rehearsal, Departure]:
    """Return a plan flown by given orders from a moment on, and its end.

    The orders are all there are, those of the schedule among them. The crew of the moment follows;
    from the tick ``speaks_from`` on it gives its own.
    """
    boat = depart(plan, since)
    mute = since.crew.aboard(boat) if since.crew else None
    flight = Flight(plan, boat, ByReference(mute=mute, speaks_from=speaks_from))
    to_world = list(since.to_world)
    last = last_tick(plan) if until is None else until
    for tick, next_stop in stretches(since.tick, last, orders):
        now = orders.get(tick, ())
        to_world += world_orders_in(now, tick)
        flight.give_again(now)
        if not flight.fly_to(next_stop):
            break
    crew = flight.aboard.mute
    return flight.rehearsal(), Departure(boat.ticks, boat.snapshot(), to_world, crew)


def depart(plan: Plan, since: Departure) -> Boat:
    """Return a boat as it is at a moment."""
    boat = plan.launch_boat()
    boat.restore(since.state)
    boat.world.obey_anew(since.to_world)
    return boat


def world_orders_in(orders: Sequence[RecordedOrder], tick: int) -> WorldOrders:
    """Return the orders to the world among some of a tick."""
    parsed = (parse(each.text) for each in orders if each.text.partition(" ")[0] in WORLD_PARTS)
    return [(tick, order) for order in parsed if isinstance(order, Order)]


def last_tick(plan: Plan) -> int:
    """Return the tick at which a plan ends. The plan must have an end."""
    return round((plan.duration or 0.0) / plan.method.step)


def stretches(first: int, last: int, due: Iterable[int]) -> Iterator[tuple[int, int]]:
    """Return begin and end of each stretch with orders due only at its begin."""
    return pairwise(sorted({first, *(tick for tick in due if first < tick < last), last}))


def due_tick(plan: Plan, entry: int) -> int:
    """Return the tick in which the order at an entry of the schedule is due."""
    return math.ceil(plan.schedule[entry].seconds / plan.method.step - 1e-9)


class Journal:
    """The orders of a rehearsal, as a recording would hold them."""

    def __init__(self, boat: Boat) -> None:
        """Begin an empty one."""
        self.boat = boat
        self.entries: list[RecordedOrder] = []
        self.marks: list[RecordedEvent] = []

    def note(self, given: list[GivenOrder]) -> None:
        """Write down the orders and marks of the crew."""
        for crew_order in given:
            name, _, subject = crew_order.text.partition(" ")
            if name == MARK_ORDER:  # no order of the boat's
                self.mark(subject, LOOKOUT_GIVER)
            else:
                self.write(REFERENCE_GIVER, crew_order.text, crew_order.reply)

    def mark(self, text: str, giver: Giver) -> None:
        """Write down that somebody marked this moment."""
        tick = self.boat.ticks
        self.marks.append(RecordedEvent(1, tick, MARK_ORDER, giver.words, text, "", giver.role))

    def write(
        self,
        giver: Giver,
        text: str,
        reply: Reply,
        entry: int | None = None,
        fact: CrewFact = NO_CREW_FACT,
    ) -> RecordedOrder:
        """Write an order down with its reply; return it as it is written."""
        order = RecordedOrder(0, 1, 0, giver, text, entry, accepted=None, answer="")
        return self.repeat(order, reply, fact)

    def repeat(self, recorded: RecordedOrder, reply: Reply, fact: CrewFact) -> RecordedOrder:
        """Write a recorded order down again, with the reply of now; return it so."""
        refused = isinstance(reply, Refused)
        answer = reply.reason if isinstance(reply, Refused) else reply
        order = replace(
            recorded,
            id=len(self.entries) + 1,
            tick=self.boat.ticks,
            accepted=not refused,
            answer=answer,
            crew=NO_CREW_FACT if refused else fact,
        )
        self.entries.append(order)
        return order

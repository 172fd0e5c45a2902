"""An exercise flown without a session, by nobody, its reference crew or given orders.

It is flown from its start, or from any moment of another run of it.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.crew_orders import ordered_fact
from trainer.boat.depths import collapse_of
from trainer.boat.helm import obey_order
from trainer.boat.mute_crew import MuteCrew
from trainer.boat.reference_crew import CrewReaction, GivenOrder, ReferenceCrew
from trainer.boat.world.encounters import EncounterMonitor
from trainer.boat.world.world import WORLD_PARTS
from trainer.config.reference_crew import MARK_ORDER, Crew
from trainer.core.kernel import Record
from trainer.debrief.ships_met import LOOKOUT_ROLE
from trainer.debrief.trajectory import PASSAGE_COLUMNS, Trajectory
from trainer.io.orders.grammar import Order, Refused, Reply, parse
from trainer.io.orders.table import BOAT_ORDERS
from trainer.io.recording.facts import (
    NO_CREW_FACT,
    REFERENCE_GIVER,
    SCHEDULE_GIVER,
    CrewFact,
    Giver,
    GiverKind,
)
from trainer.io.recording.queries import RecordedEvent, RecordedOrder
from trainer.session.layout import LAYOUT
from trainer.session.plan import Plan
from trainer.session.world_orders import WorldOrders

LOOKOUT_GIVER: Final = Giver(GiverKind.REFERENCE, LOOKOUT_ROLE, LOOKOUT_ROLE)
COLUMN_PLACES: Final = np.array([LAYOUT.index(name) for name in PASSAGE_COLUMNS])


OrdersByTick = Mapping[int, Sequence[RecordedOrder]]  # recorded orders, to be given again


@dataclass(frozen=True)
class Rehearsal:
    """The flight of a rehearsal."""

    plan: Plan
    trajectory: Trajectory
    lost: str  # why it ended before its time, "" if it did not
    rules_given: frozenset[int] = frozenset()  # of the reference crew, by their places

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
        return self.crew.look() if self.crew is not None else []


def fly_rehearsal(
    plan: Plan, crew: Crew | None = None, reaction: CrewReaction | None = None
) -> Rehearsal:
    """Return the exercise flown from start to end, by its schedule and a crew.

    Nobody is aboard where no crew is given. ConfigError if it cannot begin, or has no end.
    """
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    aboard = ByReference(None if crew is None else ReferenceCrew(boat, crew, reaction))
    flight = Flight(plan, boat, aboard)
    for places in due_orders(plan):
        flight.give_scheduled(places)
        if not flight.advance():
            break
    return flight.rehearsal()


class Flight:
    """A plan under way without a session: a boat, whoever is aboard, and the journal."""

    def __init__(self, plan: Plan, boat: Boat, aboard: ByReference) -> None:
        """Begin where the boat is."""
        self.plan, self.boat, self.aboard = plan, boat, aboard
        self.journal, self.numbers = Journal(boat), boat.records.state.view(np.float64)
        self.first = boat.ticks
        self.rows, self.lost = [self.numbers[COLUMN_PLACES]], ""
        self.watch = EncounterMonitor.over(boat)
        self.given: list[RecordedOrder] = []  # in this tick so far

    def give_scheduled(self, places: range) -> None:
        """Give the orders at some places of the schedule."""
        for entry in places:
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

    def advance(self) -> bool:
        """Let who is aboard look, and do a tick; return whether the boat goes on."""
        boat = self.boat
        with np.errstate(all="ignore"):
            self.journal.note(self.aboard.look(self.given, boat.ticks))
            self.given = []
            status = boat.tick()
            self.lost = (
                boat.failure(status) if status else collapse_of(boat) or self.watch.ended_by(boat)
            )
            if not status:
                self.rows.append(self.numbers[COLUMN_PLACES])
        return not self.lost

    def rehearsal(self) -> Rehearsal:
        """Return what was flown so far."""
        columns, count = np.array(self.rows).T, len(self.rows)
        trajectory = Trajectory(
            boat=self.boat,
            limits=self.plan.limits,
            orders=tuple(self.journal.entries),
            ticks=np.arange(self.first, self.first + count, dtype=np.int64),
            columns=dict(zip(PASSAGE_COLUMNS, columns, strict=True)),
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
    for tick in range(since.tick, last_tick(plan) if until is None else until):
        now = orders.get(tick, ())
        to_world += world_orders_in(now, tick)
        flight.give_again(now)
        if not flight.advance():
            break
    crew = flight.aboard.mute
    return flight.rehearsal(), Departure(boat.ticks, boat.records.state.copy(), to_world, crew)


def depart(plan: Plan, since: Departure) -> Boat:
    """Return a boat as it is at a moment."""
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    boat.restore(since.state)
    boat.world.settle(since.to_world)
    return boat


def world_orders_in(orders: Sequence[RecordedOrder], tick: int) -> WorldOrders:
    """Return the orders to the world among some of a tick."""
    parsed = (parse(each.text) for each in orders if each.text.partition(" ")[0] in WORLD_PARTS)
    return [(tick, order) for order in parsed if isinstance(order, Order)]


def last_tick(plan: Plan) -> int:
    """Return the tick at which a plan ends. The plan must have an end."""
    return round((plan.duration or 0.0) / plan.method.step)


def due_orders(plan: Plan) -> Iterator[range]:
    """Yield for each tick of a plan the places of the orders due.

    An order is due in the first tick not before its time.
    """
    place = 0
    for tick in range(last_tick(plan)):
        begin = place
        while place < len(plan.schedule) and due_tick(plan, place) <= tick:
            place += 1
        yield range(begin, place)


def due_tick(plan: Plan, place: int) -> int:
    """Return the tick in which the order at a place of the schedule is due."""
    return math.ceil(plan.schedule[place].seconds / plan.method.step - 1e-9)


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
            order = parse(crew_order.text)
            if isinstance(order, Order) and order.name == MARK_ORDER:  # no order of the boat's
                self.mark(order.subject, LOOKOUT_GIVER)
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
        place: int | None = None,
        fact: CrewFact = NO_CREW_FACT,
    ) -> RecordedOrder:
        """Write an order down with its reply; return it as it is written."""
        refused = isinstance(reply, Refused)
        answer = reply.reason if isinstance(reply, Refused) else reply
        number = len(self.entries) + 1
        entry = RecordedOrder(
            number,
            1,
            self.boat.ticks,
            giver,
            text,
            place,
            not refused,
            answer,
            crew=NO_CREW_FACT if refused else fact,
        )
        self.entries.append(entry)
        return entry

    def repeat(self, recorded: RecordedOrder, reply: Reply, fact: CrewFact) -> RecordedOrder:
        """Write a recorded order down again, with the reply of now; return it so."""
        refused = isinstance(reply, Refused)
        answer = reply.reason if isinstance(reply, Refused) else reply
        entry = replace(
            recorded,
            id=len(self.entries) + 1,
            tick=self.boat.ticks,
            accepted=not refused,
            answer=answer,
            crew=NO_CREW_FACT if refused else fact,
        )
        self.entries.append(entry)
        return entry

"""An exercise flown without a session: by nobody, or by its reference crew.

It is flown from its start, or from a recorded moment at which the reference crew takes over.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.crew_orders import ordered_fact
from trainer.boat.depths import collapse_of
from trainer.boat.helm import obey_order
from trainer.boat.reference_crew import CrewReaction, GivenOrder, ReferenceCrew
from trainer.boat.world.encounters import EncounterMonitor
from trainer.config.reference_crew import MARK_ORDER, Crew
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
)
from trainer.io.recording.queries import Moment, RecordedEvent, RecordedOrder
from trainer.session.layout import LAYOUT, read_state
from trainer.session.plan import Plan
from trainer.session.world_orders import WorldOrders

COLUMN_PLACES: Final = np.array([LAYOUT.index(name) for name in PASSAGE_COLUMNS])


@dataclass(frozen=True)
class Rehearsal:
    """The flight of a rehearsal."""

    plan: Plan
    trajectory: Trajectory
    lost: str  # why it ended before its time, "" if it did not
    times: Mapping[int, float]  # [s] when each of the crew's rules was last carried out, by place

    @property
    def refused(self) -> tuple[RecordedOrder, ...]:
        """Return the orders that the boat refused."""
        return tuple(each for each in self.trajectory.orders if each.accepted is False)


@dataclass(frozen=True)
class Departure:
    """A recorded moment, from which a crew takes over."""

    moment: Moment
    layout: tuple[str, ...]  # of its state
    given: Mapping[int, float]  # [s] rules of the reference crew that were carried out before
    to_world: WorldOrders = ()  # orders before it


def fly_rehearsal(
    plan: Plan,
    crew: Crew | None = None,
    reaction: CrewReaction | None = None,
    since: Departure | None = None,
) -> Rehearsal:
    """Return the exercise flown to its end, from a recorded moment if there is one.

    Nobody is aboard where no crew is given. ConfigError if it cannot begin, or has no end.
    """
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    first, place = (since.moment.tick, since.moment.place) if since else (0, 0)
    if since is not None:
        boat.restore(read_state(since.moment.state, since.layout, boat.records.state))
        boat.world.settle(since.to_world)
    journal, numbers = Journal(boat), boat.records.state.view(np.float64)
    aboard = None if crew is None else ReferenceCrew(boat, crew, reaction)
    if aboard is not None and since is not None:
        aboard.take_over(since.given)
    rows, lost, watch = [numbers[COLUMN_PLACES]], "", EncounterMonitor.over(boat)
    with np.errstate(all="ignore"):
        for places in due_orders(plan, first, place):
            for entry in places:
                order = plan.schedule[entry].order
                if order.name in BOAT_ORDERS:  # what is said to people moves nothing
                    answer = obey_order(boat, order)
                    fact = ordered_fact(boat, order)
                    journal.write(SCHEDULE_GIVER, order.text, answer, entry, fact)
            if aboard is not None:
                journal.note(aboard.look())
            status = boat.tick()
            lost = boat.failure(status) if status else collapse_of(boat) or watch.ended_by(boat)
            if not status:
                rows.append(numbers[COLUMN_PLACES])
            if lost:
                break
    columns = np.array(rows).T
    trajectory = Trajectory(
        boat=boat,
        limits=plan.limits,
        orders=tuple(journal.entries),
        ticks=np.arange(first, first + len(rows), dtype=np.int64),
        columns=dict(zip(PASSAGE_COLUMNS, columns, strict=True)),
        lateness=np.full(len(rows), np.nan),
        work=np.full(len(rows), np.nan),
        marks=tuple(journal.marks),
    )
    return Rehearsal(plan, trajectory, lost, dict(journal.rules))


def last_tick(plan: Plan) -> int:
    """Return the tick at which a plan ends. The plan must have an end."""
    return round((plan.duration or 0.0) / plan.method.step)


def due_orders(plan: Plan, first: int = 0, place: int = 0) -> Iterator[range]:
    """Yield for each tick of a plan the places of the orders due.

    An order is due in the first tick not before its time. It begins at a tick, and at a place.
    """
    for tick in range(first, last_tick(plan)):
        begin = place
        while (
            place < len(plan.schedule)
            and math.ceil(plan.schedule[place].seconds / plan.method.step - 1e-9) <= tick
        ):
            place += 1
        yield range(begin, place)


class Journal:
    """The orders of a rehearsal, as a recording would hold them."""

    def __init__(self, boat: Boat) -> None:
        """Begin an empty one."""
        self.boat = boat
        self.entries: list[RecordedOrder] = []
        self.marks: list[RecordedEvent] = []
        self.rules: dict[int, float] = {}  # [s] when each was last carried out

    def note(self, given: list[GivenOrder]) -> None:
        """Write down the orders and marks of the crew."""
        for crew_order in given:
            if crew_order.rule is not None:
                self.rules[crew_order.rule] = self.boat.time
            order = parse(crew_order.text)
            if isinstance(order, Order) and order.name == MARK_ORDER:  # no order of the boat's
                noted = RecordedEvent(
                    1, self.boat.ticks, MARK_ORDER, LOOKOUT_ROLE, order.subject, "", LOOKOUT_ROLE
                )
                self.marks.append(noted)
            else:
                self.write(REFERENCE_GIVER, crew_order.text, crew_order.reply)

    def write(
        self,
        giver: Giver,
        text: str,
        reply: Reply,
        place: int | None = None,
        fact: CrewFact = NO_CREW_FACT,
    ) -> None:
        """Write an order down with its reply, and what it said to the crew."""
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

"""The journal of a run, and the present moment by it.

A moment is all that is needed to go back: the whole state, the last order that it includes, and the
next entry of the exercise's schedule. ``dispatch`` journals each order before it acts, and the run
at work (``run_modes``) has the state after each tick recorded.

A state holds the current and the ships near as they are at its tick, but not the orders by which
they go on: these follow from the orders given to the world so far. Those are found by the number of
the last order that the state includes (``_to_world``).

The recording has every moment. One each 10 s is kept in memory too, to go back to when the
recording cannot be read, or there is none.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.world.world import WORLD_PARTS
from trainer.core.state import STATE
from trainer.io.orders.grammar import Order, Refused, Reply, parse
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.facts import NO_CREW_FACT, CrewFact, Giver
from trainer.io.recording.recording import Moment, RecordedOrder, Recording, RecordingError

MOMENT_PERIOD_S: Final = 10.0  # [s] between moments kept in memory beside the recording
MAX_KEPT_MOMENTS: Final = 360  # one hour of them, as docs/recordings.md says
FILL_BYTE: Final = b"\xff"  # not zero, because a system gives zeroed memory only when it is used
WorldOrders = Sequence[tuple[int, Order]]  # each with its tick


class Moments:
    """A ring of moments in the order of their ticks. The oldest gives way to a new one.

    Its memory is taken once, because a tick that allocates may be late.
    """

    def __init__(self, most: int, size: int) -> None:
        """Take room for so many moments, each with a state of so many bytes."""
        self._most = most
        self._row = struct.Struct(f"=4q{size}s")  # branch, tick, after, next entry and state
        self._rows = bytearray(FILL_BYTE * (most * self._row.size))
        self._begin = 0
        self._count = 0

    def __len__(self) -> int:
        """Return how many moments are kept."""
        return self._count

    def append(self, moment: Moment) -> None:
        """Keep a moment, which has to be later than all that are kept."""
        numbers = moment.branch, moment.tick, moment.after, moment.entry
        self._row.pack_into(self._rows, self._offset(self._count), *numbers, moment.state)
        if self._count < self._most:
            self._count += 1
        else:
            self._begin = (self._begin + 1) % self._most

    def before(self, tick: int) -> Moment | None:
        """Return the last moment at a tick or before it, None if none is kept."""
        for back in range(self._count - 1, -1, -1):  # the wanted moment is mostly a late one
            moment = self._at(back)
            if moment.tick <= tick:
                return moment
        return None

    def since(self, tick: int) -> list[tuple[int, bytes]]:
        """Return tick and state of the moments at a tick or after it, oldest first."""
        every = (self._at(index) for index in range(self._count))
        return [(moment.tick, moment.state) for moment in every if moment.tick >= tick]

    def forget_after(self, tick: int) -> None:
        """Drop the moments after a tick."""
        while self._count and self._at(self._count - 1).tick > tick:
            self._count -= 1

    def clear(self) -> None:
        """Drop them all."""
        self._count = 0

    def _offset(self, index: int) -> int:
        return (self._begin + index) % self._most * self._row.size

    def _at(self, index: int) -> Moment:
        row = self._row.unpack_from(self._rows, self._offset(index))
        branch, tick, after, entry, state = row
        return Moment(branch, tick, state, after, entry)


class WorldOrder(NamedTuple):
    """An order to the world with its tick, and the one before it.

    A chain shares its beginning with the chains of other branches.
    """

    number: int
    tick: int
    order: Order
    before: "WorldOrder | None"


@dataclass
class Journal:
    """What was ordered in one run, and the moment to which it has led."""

    boat: Boat
    recording: Recording | NoRecording
    after: int = 0  # the last order that the present state includes
    entry: int = 0  # the schedule's next one
    before_order: dict[int, int] = field(default_factory=dict, repr=False)  # on any branch
    automatic: Moments = field(
        default_factory=lambda: Moments(MAX_KEPT_MOMENTS, STATE.itemsize), repr=False
    )
    _period: int = field(init=False)  # [ticks] between the automatic moments
    # by the number of the last order that a state includes: the latest order to the world by then
    _to_world: dict[int, WorldOrder | None] = field(default_factory=lambda: {0: None}, repr=False)

    def __post_init__(self) -> None:
        self._period = max(round(MOMENT_PERIOD_S / self.boat.method.step), 1)

    @property
    def tick(self) -> int:
        """Return the number of ticks done."""
        return self.boat.ticks

    def now(self) -> Moment:
        """Return the present moment."""
        branch = self.recording.branch
        return Moment(branch, self.tick, self._state(), self.after, self.entry)

    def order(self, giver: Giver, order: Order, entry: int | None = None) -> int:
        """Journal an order that is about to act; return its number."""
        if self.recording.reachable:
            self.recording.go_on(self.now())
        before = self._world_order(self.recording.branch, self.after)
        number = self.recording.order(self.tick, giver, order.text, entry)
        self.before_order[number], self.after = self.after, number
        ours = order.name in WORLD_PARTS
        self._to_world[number] = WorldOrder(number, self.tick, order, before) if ours else before
        if entry is not None:
            self.entry = entry + 1
        return number

    def answered(self, number: int, answer: Reply, crew: CrewFact = NO_CREW_FACT) -> None:
        """Journal the answer to an order, and the crew fact of it."""
        refused = isinstance(answer, Refused)
        text = answer.reason if isinstance(answer, Refused) else answer
        self.recording.answered(number, text, not refused, crew)
        latest = self._to_world.get(number)
        if refused and latest and latest.number == number:  # it has not changed the world
            self._to_world[number] = latest.before

    def include(self, given: RecordedOrder) -> None:
        """Note that the present state includes an order of the journal."""
        self.after = given.id
        if given.entry is not None:
            self.entry = given.entry + 1

    def read_world_orders(self, branch: int) -> None:
        """Read the orders to the world that led to a branch."""
        latest = None
        for entry in self.recording.orders(branch):
            latest = to_world(entry, latest)
            self._to_world[entry.id] = latest

    def _world_order(self, branch: int, after: int) -> WorldOrder | None:
        """Return the latest order to the world of a state that includes order ``after`` last."""
        if after not in self._to_world:
            self.read_world_orders(branch)
        return self._to_world.get(after)

    def record(self, tick: int, state: bytes) -> None:
        """Record the state after a tick of a live run."""
        # a branch that begins after a gap begins with this state
        if not (self.recording.reachable and self.recording.go_on(self.now())):
            self.recording.state(tick, state)
        if tick % self._period == 0:
            branch = self.recording.branch
            self.automatic.append(Moment(branch, tick, state, self.after, self.entry))

    def said(self) -> list[RecordedOrder]:
        """Return the orders that the present state includes; none while they cannot be read."""
        try:
            orders = self.recording.orders(self.recording.branch)
        except RecordingError:
            return []
        return [each for each in orders if each.id <= self.after]

    def _restore(self, moment: Moment) -> None:
        """Restore a whole moment. RecordingError leaves everything as it was."""
        latest = self._world_order(moment.branch, moment.after)  # may fail: before any change
        self.boat.restore(np.frombuffer(moment.state, STATE))
        self.boat.world.obey_anew(world_orders(latest))
        self.after, self.entry = moment.after, moment.entry

    def _state(self) -> bytes:
        return self.boat.plain.tobytes()


def order_of(given: RecordedOrder, schedule: Sequence[ScheduledOrder]) -> Order | None:
    """Return the order that was journalled, None if this version does not understand it.

    A scheduled order comes from the schedule, because a casualty there has more than its words.
    """
    if given.entry is not None and 0 <= given.entry < len(schedule):
        return schedule[given.entry].order
    order = parse(given.text)
    return order if isinstance(order, Order) else None


def world_orders(latest: WorldOrder | None) -> WorldOrders:
    """Return an order to the world and all before it, the first one first."""
    orders = []
    while latest:
        orders.append((latest.tick, latest.order))
        latest = latest.before
    return orders[::-1]


def to_world(entry: RecordedOrder, before: WorldOrder | None) -> WorldOrder | None:
    """Return the latest order to the world after an order of the journal."""
    if entry.accepted is False or entry.text.partition(" ")[0] not in WORLD_PARTS:  # most are not
        return before
    order = parse(entry.text)
    return WorldOrder(entry.id, entry.tick, order, before) if isinstance(order, Order) else before


def worlds_begun(recording: Recording) -> dict[int, WorldOrders]:
    """Return the orders to the world that hold where each branch begins.

    It goes through all branches once, because each of a long chain needs all before it.
    """
    begun: dict[int, WorldOrders] = {}
    flown: dict[int | None, WorldOrder | None] = {None: None}  # to the end of each branch
    for branch in recording.branches():
        if branch.parent not in flown:
            raise RecordingError(
                f"branch {branch.id} begins in branch {branch.parent}: there is none"
            )
        latest = flown[branch.parent]
        while latest and latest.number > branch.after:
            latest = latest.before
        begun[branch.id] = world_orders(latest)
        for entry in recording.orders(branch.id, branch.after):
            latest = to_world(entry, latest)
        flown[branch.id] = latest
    return begun


def restore_world(boat: Boat, recording: Recording, branch: int, after: int) -> None:
    """Bring a boat's world to what a branch's orders up to ``after`` made it."""
    latest = None
    for entry in recording.orders(branch):
        latest = to_world(entry, latest) if entry.id <= after else latest
    boat.world.obey_anew(world_orders(latest))

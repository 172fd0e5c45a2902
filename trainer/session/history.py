"""The past of a run: orders in the journal, moments, and going back to one.

A moment is everything that there is to go back to: the whole state, the orders it includes, and
what of the exercise's schedule is done. From a moment gone back to a new branch of the recording
begins; the old one stays. A replay flies the old branch again and begins a new one only where
somebody takes over.

The latest moments of a branch, in memory that is taken once and for all at the start.
"""

import math
import struct
from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.helm import obey
from trainer.boat.world.world import PARTS
from trainer.core.state import STATE
from trainer.io.orders.grammar import Order, Refused, Reply, parse
from trainer.io.orders.schedule import Scheduled
from trainer.io.orders.table import BOAT_ORDERS
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.recording import (
    Journalled,
    Moment,
    Noted,
    Recording,
    RecordingError,
)

TOUCHED: Final = b"\xff"  # written everywhere at first, so that the memory is really there


class Moments:
    """A ring of moments in the order of their ticks. The oldest gives way to a new one."""

    def __init__(self, most: int, size: int) -> None:
        """Take room for so many moments, each with a state of so many bytes."""
        self._most = most
        self._row = struct.Struct(f"=4q{size}s")  # branch, tick, after, place and state
        self._rows = bytearray(TOUCHED * (most * self._row.size))
        self._begin = 0
        self._count = 0

    def __len__(self) -> int:
        """Return how many are kept."""
        return self._count

    def append(self, moment: Moment) -> None:
        """Keep a moment, later than all that are kept."""
        numbers = moment.branch, moment.tick, moment.after, moment.place
        self._row.pack_into(self._rows, self._place(self._count), *numbers, moment.state)
        if self._count < self._most:
            self._count += 1
        else:
            self._begin = (self._begin + 1) % self._most

    def before(self, tick: int) -> Moment | None:
        """Return the last moment at a tick or before it, None if none is kept."""
        for back in range(self._count - 1, -1, -1):
            moment = self._at(back)
            if moment.tick <= tick:
                return moment
        return None

    def since(self, tick: int) -> list[tuple[int, bytes]]:
        """Return tick and state of those at a tick or after it, oldest first."""
        every = (self._at(index) for index in range(self._count))
        return [(moment.tick, moment.state) for moment in every if moment.tick >= tick]

    def forget_after(self, tick: int) -> None:
        """Drop those that are later than a tick."""
        while self._count and self._at(self._count - 1).tick > tick:
            self._count -= 1

    def clear(self) -> None:
        """Drop them all."""
        self._count = 0

    def _place(self, index: int) -> int:
        return (self._begin + index) % self._most * self._row.size

    def _at(self, index: int) -> Moment:
        row = self._row.unpack_from(self._rows, self._place(index))
        branch, tick, after, place, state = row
        return Moment(branch, tick, state, after, place)


FIRST: Final = 1  # the branch that begins with the run
AUTOMATIC_EVERY: Final = 10.0  # [s] between moments kept in memory beside the recording
AUTOMATIC_KEPT: Final = 360  # of them: one hour


def order_of(entry: Journalled, schedule: Sequence[Scheduled]) -> Order | None:
    """Return the order that was journalled, None if this version does not understand it.

    That of a schedule is taken from there: a casualty's has more to it than its words.
    """
    if entry.place is not None and 0 <= entry.place < len(schedule):
        return schedule[entry.place].order
    order = parse(entry.text)
    return order if isinstance(order, Order) else None


class WorldOrder(NamedTuple):
    """An order to the world with its tick, and the one before it."""

    number: int
    tick: int
    order: Order
    before: "WorldOrder | None"


WorldOrders = Sequence[tuple[int, Order]]  # each with its tick


def world_orders(latest: WorldOrder | None) -> WorldOrders:
    """Return an order to the world and all before it, the first one first."""
    found = []
    while latest:
        found.append((latest.tick, latest.order))
        latest = latest.before
    return found[::-1]


def to_world(entry: Journalled, before: WorldOrder | None) -> WorldOrder | None:
    """Return the latest order to the world after an order of the journal."""
    if entry.accepted is False or entry.text.partition(" ")[0] not in PARTS:  # most are not
        return before
    order = parse(entry.text)
    return WorldOrder(entry.id, entry.tick, order, before) if isinstance(order, Order) else before


def worlds_begun(recording: Recording) -> dict[int, WorldOrders]:
    """Return the orders to the world that stand where each branch begins.

    It goes once through all branches, because each of a long chain rests on all before it.
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


def recorded_world_orders(recording: Recording, branch: int, after: int) -> WorldOrders:
    """Return the orders to the world that a branch has up to ``after``."""
    latest = None
    for entry in recording.orders(branch):
        latest = to_world(entry, latest) if entry.id <= after else latest
    return world_orders(latest)


def settle_world(boat: Boat, recording: Recording, branch: int, after: int) -> None:
    """Bring a boat's world to what a branch's orders up to ``after`` made it."""
    boat.world.settle(recorded_world_orders(recording, branch, after))


@dataclass(frozen=True)
class Stretch:
    """One branch, as an instructor chooses among them."""

    number: int
    parent: int | None
    begun: float  # [s]
    last: float  # [s]
    why: str
    present: bool

    def __str__(self) -> str:
        begun = f"branch {self.number}: from {self.begun:g} s"
        of = f" of branch {self.parent}" if self.parent else ""
        here = "; the present one" if self.present else ""
        return f"{begun}{of} to {self.last:g} s; {self.why}{here}"

    @property
    def fields(self) -> str:
        """Return it as programs are told it; the reason last, since it may hold commas."""
        return f"{self.number},{self.parent or ''},{self.begun:.3f},{self.last:.3f},{self.why}"


@dataclass
class Rerun:
    """A replay under way: the orders still to come, and its last moment."""

    orders: deque[Journalled]
    end: Moment
    began: float  # [s]
    different: str = ""  # where it first left its recording


@dataclass
class History:
    """The past of one run."""

    boat: Boat
    recording: Recording | NoRecording
    after: int = 0  # the last order that the present state includes
    place: int = 0  # of the schedule's next entry
    rerun: Rerun | None = None
    automatic: Moments = field(
        default_factory=lambda: Moments(AUTOMATIC_KEPT, STATE.itemsize), repr=False
    )
    _period: int = field(init=False)  # [ticks] between the automatic moments
    # the latest order to the world, by the number of the order that a state includes last
    _to_world: dict[int, WorldOrder | None] = field(default_factory=lambda: {0: None}, repr=False)

    def __post_init__(self) -> None:
        self._period = max(round(AUTOMATIC_EVERY / self.boat.method.step), 1)

    @property
    def tick(self) -> int:
        """Return the number of ticks done."""
        return self.boat.ticks

    def now(self) -> Moment:
        """Return the present moment."""
        branch = self.recording.branch
        return Moment(branch, self.tick, self._state(), self.after, self.place)

    def order(self, who: str, order: Order, place: int | None = None) -> int:
        """Journal an order that is about to act; return its number."""
        if self.recording.reachable:
            self.recording.go_on(self.now())
        before = self._world_order(self.recording.branch, self.after)
        self.after = number = self.recording.order(self.tick, who, order.text, place)
        ours = order.name in PARTS
        self._to_world[number] = WorldOrder(number, self.tick, order, before) if ours else before
        if place is not None:
            self.place = place + 1
        return number

    def answered(self, number: int, answer: Reply) -> None:
        """Journal what became of an order."""
        refused = isinstance(answer, Refused)
        text = answer.reason if isinstance(answer, Refused) else answer
        self.recording.answered(number, text, not refused)
        latest = self._to_world.get(number)
        if refused and latest and latest.number == number:
            self._to_world[number] = latest.before

    def include(self, entry: Journalled) -> None:
        """Take it that the present state includes an order of the journal."""
        self.after = entry.id
        if entry.place is not None:
            self.place = entry.place + 1

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

    def ticked(self, tick: int) -> bytes:
        """Keep the state after a tick; return it."""
        state = self.boat.plain.tobytes()
        if self.rerun is None:
            if self.recording.reachable:  # its new branch begins with this state
                self.recording.go_on(self.now())
            else:
                self.recording.state(tick, state)
            if tick % self._period == 0:
                branch = self.recording.branch
                self.automatic.append(Moment(branch, tick, state, self.after, self.place))
        elif not self.rerun.different:
            self._compare(self.rerun, state)
        return state

    def keep(self, name: str) -> Reply:
        """Keep the present moment under a name."""
        if self.recording.trouble:
            return Refused(f"not kept: {self.recording.trouble}")
        known = name in self.snapshots()
        self.recording.snapshot(name, self.now())
        if self.recording.trouble:
            return Refused(f"not kept: {self.recording.trouble}")
        return f"snapshot {name} {'kept anew' if known else 'kept'} at {self.boat.time:g} s"

    def snapshots(self) -> dict[str, Moment]:
        """Return the named moments."""
        return dict(self.recording.snapshots())

    def before(self, seconds: float) -> Moment | Refused:
        """Return the moment so long [s] ago, the start if that is later.

        Where the recording cannot reach it, the automatic one before it.
        """
        ticks = math.ceil(seconds / self.boat.method.step - 1e-9)
        wanted = max(self.tick - ticks, 0)
        found = self.recording.moment(self.recording.branch, wanted)
        if found is not None:
            return found
        return self.automatic.before(wanted) or Refused("no moment so long ago is kept")

    def start(self) -> Moment | Refused:
        """Return the initial conditions, whatever was ordered in a freeze there."""
        return self.recording.moment(FIRST, 0) or self.before(self.boat.time)

    def branches(self) -> list[Stretch]:
        """Return all that has been flown, oldest first; the present one reaches up to now."""
        present, step = self.recording.branch, self.boat.method.step

        def last(branch: int) -> int:
            flown = self.recording.last_tick(branch)
            return flown if self.rerun or branch != present else max(flown, self.tick)

        return [
            Stretch(
                *(each.id, each.parent, each.tick * step, last(each.id) * step),
                *(each.why or "the start", each.id == present),
            )
            for each in self.recording.branches()
        ]

    def noted(self) -> list[Noted]:
        """Return what was noted on the present branch and on what led to it."""
        begun = {each.id: each for each in self.recording.branches()}
        ends: dict[int, float] = {}
        here, end = begun.get(self.recording.branch), math.inf
        while here:
            ends[here.id] = end
            end, here = here.tick, begun.get(here.parent or 0)
        return [each for each in self.recording.events() if each.tick <= ends.get(each.branch, -1)]

    def end_of(self, branch: int) -> Moment | Refused:
        """Return the last moment of a branch, without the orders that were given after it."""
        there = [each.id for each in self.recording.branches()]
        if branch not in there:
            known = f"there is 1 to {there[-1]}" if there else "nothing is recorded"
            return Refused(f"no branch {branch}: {known}; branches lists them")
        found = self.recording.moment(branch, self.recording.last_tick(branch))
        return found or Refused(f"the end of branch {branch} is not recorded")

    def return_to(self, end: Moment, why: str, schedule: Sequence[Scheduled]) -> None:
        """Go to the end of a branch, give again what was ordered there, and fork."""
        given = self.recording.orders(end.branch, end.after)  # before anything is changed
        self._restore(end)
        for entry in given:
            order = order_of(entry, schedule)
            if order is not None and order.name in BOAT_ORDERS and entry.accepted is not False:
                obey(self.boat, order)
            self.include(entry)
        self.go_to(Moment(end.branch, end.tick, self._state(), self.after, self.place), why)

    def go_to(self, moment: Moment, why: str) -> None:
        """Go back to a moment, and begin a new branch there."""
        self._restore(moment)
        if moment.branch != self.recording.branch:
            self.automatic.clear()  # the past of another branch
        self.recording.fork(moment, why)
        self.rerun = None
        self.automatic.forget_after(self.tick)

    def show_again(self, moment: Moment) -> int:
        """Go back to a moment, to fly on from there as it was recorded. Return the orders."""
        end = self.rerun.end if self.rerun else self.now()
        orders = self.recording.orders(self.recording.branch, moment.after)
        again = deque(each for each in orders if each.id <= end.after)
        self._restore(moment)
        self.rerun = Rerun(again, end, self.boat.time)
        return len(again)

    def take_over(self, why: str) -> None:
        """End a replay here: what follows is a new branch."""
        self.rerun = None
        self.recording.fork(self.now(), why)
        self.automatic.forget_after(self.tick)

    def said(self) -> list[Journalled]:
        """Return the orders that the present state includes; none while they cannot be read."""
        try:
            orders = self.recording.orders(self.recording.branch)
        except RecordingError:
            return []
        return [each for each in orders if each.id <= self.after]

    def due(self, schedule: Sequence[Scheduled]) -> Iterator[tuple[Order, str]]:
        """Yield the orders that a replay gives again at this tick, and who gave each."""
        rerun = self.rerun
        while rerun and rerun.orders and rerun.orders[0].tick <= self.tick:
            entry = rerun.orders.popleft()
            self.include(entry)
            order = order_of(entry, schedule)
            if order is not None:
                yield order, entry.who

    def arrive(self) -> str:
        """End a replay that has arrived where it led to; return what became of it."""
        rerun, self.rerun = self.rerun, None
        told = "the same to the last bit"
        if rerun and (rerun.different or rerun.end.state != self._state()):
            told = rerun.different or "it did not end in the state that it led to"
        return f"replay over at {self.boat.time:g} s: {told}; run goes on from here"

    @property
    def caught_up(self) -> bool:
        """Return whether a replay has arrived where it led to; the branch then goes on."""
        rerun = self.rerun
        return rerun is not None and self.tick >= rerun.end.tick and not rerun.orders

    def _restore(self, moment: Moment) -> None:
        """Take a moment whole; RecordingError with nothing changed."""
        latest = self._world_order(moment.branch, moment.after)
        self.boat.restore(np.frombuffer(moment.state, STATE))
        self.boat.world.settle(world_orders(latest))
        self.after, self.place = moment.after, moment.place

    def _state(self) -> bytes:
        return self.boat.plain.tobytes()

    def _compare(self, rerun: Rerun, state: bytes) -> None:
        """Note where the replay's state is not the one recorded."""
        try:
            recorded = self.recording.moment(self.recording.branch, self.tick)
        except RecordingError as error:
            rerun.different = str(error)
            return
        # a branch may begin with orders of its own tick, which the replay gives only now
        if recorded and recorded.after == self.after and recorded.state != state:
            rerun.different = f"the replay left its recording at tick {self.tick}"

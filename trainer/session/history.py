"""The past of a run: orders in the journal, moments, and going back to one.

A moment is all that is needed to go back: the whole state, the last order that it includes, and the
next entry of the exercise's schedule. Who goes back to a moment begins a new branch of the
recording there, and the old branch stays. A replay flies the old branch again. It begins a new one
only where somebody takes over.

Each session has one. ``dispatch`` journals orders by it, ``control`` goes back by it, and most
other parts of a session read the past from it.

A state holds the current and the ships near as they are at its tick, but not the orders by which
they go on. Those are found by the number of the last order that the state includes (``_to_world``).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.helm import obey_order
from trainer.boat.world.world import WORLD_PARTS
from trainer.core.state import STATE
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.orders.table import BOAT_ORDERS
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.facts import NO_CREW_FACT, BranchCause, CrewFact, Giver
from trainer.io.recording.recording import (
    Moment,
    RecordedEvent,
    RecordedOrder,
    Recording,
    RecordingError,
)
from trainer.session.moments import Moments
from trainer.session.run_faces import LiveRun, ReplayedRun, Run, ShownRun, order_of
from trainer.session.world_orders import WorldOrder, to_world, world_orders

FIRST_BRANCH: Final = 1  # the branch that begins with the run
MOMENT_PERIOD_S: Final = 10.0  # [s] between moments kept in memory beside the recording
MAX_KEPT_MOMENTS: Final = 360  # one hour of them, as docs/recordings.md says


@dataclass(frozen=True)
class Stretch:
    """One branch of the recording, as the list has it from which an instructor chooses."""

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
        """Return its fields for programs; the reason is last, because it may hold commas."""
        return f"{self.number},{self.parent or ''},{self.begun:.3f},{self.last:.3f},{self.why}"


@dataclass
class History:
    """The past of one run: its journal, the moments kept, the ways back to them."""

    boat: Boat
    recording: Recording | NoRecording
    after: int = 0  # the last order that the present state includes
    place: int = 0  # of the schedule's next entry
    flown: Run = field(init=False)
    automatic: Moments = field(
        default_factory=lambda: Moments(MAX_KEPT_MOMENTS, STATE.itemsize), repr=False
    )
    _period: int = field(init=False)  # [ticks] between the automatic moments
    # by the number of the last order that a state includes: the latest order to the world by then
    _to_world: dict[int, WorldOrder | None] = field(default_factory=lambda: {0: None}, repr=False)

    def __post_init__(self) -> None:
        self.flown = LiveRun(self)
        self._period = max(round(MOMENT_PERIOD_S / self.boat.method.step), 1)

    @property
    def tick(self) -> int:
        """Return the number of ticks done."""
        return self.boat.ticks

    def now(self) -> Moment:
        """Return the present moment."""
        branch = self.recording.branch
        return Moment(branch, self.tick, self._state(), self.after, self.place)

    def order(self, giver: Giver, order: Order, place: int | None = None) -> int:
        """Journal an order that is about to act; return its number."""
        if self.recording.reachable:
            self.recording.go_on(self.now())
        before = self._world_order(self.recording.branch, self.after)
        self.after = number = self.recording.order(self.tick, giver, order.text, place)
        ours = order.name in WORLD_PARTS
        self._to_world[number] = WorldOrder(number, self.tick, order, before) if ours else before
        if place is not None:
            self.place = place + 1
        return number

    def answered(self, number: int, answer: Reply, crew: CrewFact = NO_CREW_FACT) -> None:
        """Journal the answer to an order, and the crew fact of it."""
        refused = isinstance(answer, Refused)
        text = answer.reason if isinstance(answer, Refused) else answer
        self.recording.answered(number, text, not refused, crew)
        latest = self._to_world.get(number)
        if refused and latest and latest.number == number:  # it has not changed the world
            self._to_world[number] = latest.before

    def include(self, entry: RecordedOrder) -> None:
        """Note that the present state includes an order of the journal."""
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
        """Keep the state after a tick; return it.

        The run at work decides how: a live one records it, a replay compares it.
        """
        state = self.boat.plain.tobytes()
        self.flown.keep(tick, state)
        return state

    def record(self, tick: int, state: bytes) -> None:
        """Record the state after a tick of a live run."""
        # a branch that begins after a gap begins with this state
        if not (self.recording.reachable and self.recording.go_on(self.now())):
            self.recording.state(tick, state)
        if tick % self._period == 0:
            branch = self.recording.branch
            self.automatic.append(Moment(branch, tick, state, self.after, self.place))

    def keep(self, name: str) -> Reply:
        """Keep the present moment under a name."""
        if self.recording.trouble:
            return Refused(f"not kept: {self.recording.trouble}")
        try:
            known = name in self.snapshots()
            self.recording.snapshot(name, self.now())
        except RecordingError as error:
            return Refused(f"not kept: {error}")
        if self.recording.trouble:
            return Refused(f"not kept: {self.recording.trouble}")
        return f"snapshot {name} {'kept anew' if known else 'kept'} at {self.boat.time:g} s"

    def snapshots(self) -> dict[str, Moment]:
        """Return the named moments."""
        return dict(self.recording.snapshots())

    def before(self, seconds: float) -> Moment | Refused:
        """Return the moment so long [s] ago, at the earliest the start.

        Where the recording cannot be read, it is the automatic moment in memory before that time.
        """
        ticks = math.ceil(seconds / self.boat.method.step - 1e-9)
        wanted = max(self.tick - ticks, 0)
        moment = self.recording.moment(self.recording.branch, wanted)
        if moment is not None:
            return moment
        return self.automatic.before(wanted) or Refused("no moment so long ago is kept")

    def start(self) -> Moment | Refused:
        """Return the initial conditions, before any order that was given in a freeze there."""
        return self.recording.moment(FIRST_BRANCH, 0) or self.before(self.boat.time)

    def branches(self) -> list[Stretch]:
        """Return all branches, oldest first. The present one reaches up to now."""
        present, step = self.recording.branch, self.boat.method.step

        return [
            Stretch(
                branch.id,
                branch.parent,
                branch.tick * step,
                self.flown.last_tick(branch.id) * step,
                branch.why or "the start",
                branch.id == present,
            )
            for branch in self.recording.branches()
        ]

    def ends(self) -> dict[int, float]:
        """Return to which tick each branch leads to the present one. A present one has no end."""
        begun = {each.id: each for each in self.recording.branches()}
        ends: dict[int, float] = {}
        here, end = begun.get(self.recording.branch), math.inf
        while here:
            ends[here.id] = end
            end, here = here.tick, begun.get(here.parent or 0)
        return ends

    def noted(self) -> list[RecordedEvent]:
        """Return the events of the present branch and of those that led to it."""
        ends = self.ends()
        return [each for each in self.recording.events() if each.tick <= ends.get(each.branch, -1)]

    def end_of(self, branch: int) -> Moment | Refused:
        """Return the last moment of a branch, without the orders that were given after it."""
        branches = self.recording.branches()
        numbers = [each.id for each in branches]
        if branch not in numbers:
            known = f"there is 1 to {numbers[-1]}" if numbers else "nothing is recorded"
            return Refused(f"no branch {branch}: {known}; branches lists them")
        if any(each.id == branch and each.cause is BranchCause.SHOWN for each in branches):
            return Refused(f"branch {branch} is the reference crew's, which counts for no mark")
        moment = self.recording.moment(branch, self.recording.last_tick(branch))
        return moment or Refused(f"the end of branch {branch} is not recorded")

    def fork_at_end(self, end: Moment, why: str, schedule: Sequence[ScheduledOrder]) -> None:
        """Go to the end of a branch, give its last orders again, and fork.

        Orders after the last recorded tick are in no recorded state, so they are given again.
        """
        orders = self.recording.orders(end.branch, end.after)  # before anything is changed
        here = self.now()
        self._restore(end)
        for entry in orders:
            order = order_of(entry, schedule)
            if order is not None and order.name in BOAT_ORDERS and entry.accepted is not False:
                obey_order(self.boat, order)
            self.include(entry)
        last = Moment(end.branch, end.tick, self._state(), self.after, self.place)
        try:
            self.fork_at(last, why)
        except RecordingError:
            self._restore(here)
            raise

    def fork_at(self, moment: Moment, why: str) -> None:
        """Go back to a moment, and begin a new branch there.

        RecordingError leaves everything as it was: nothing is flown twice on one branch.
        """
        here = self.now()
        self._restore(moment)
        try:
            self.recording.fork(moment, why)
        except RecordingError:
            self._restore(here)
            raise
        if moment.branch != here.branch:
            self.automatic.clear()  # the past of another branch
        self.flown = LiveRun(self)
        self.automatic.forget_after(self.tick)

    def show_way(self, why: str, run: ShownRun) -> None:
        """Begin a branch at this moment, on which the reference crew shows the way."""
        self.recording.fork(self.now(), why, BranchCause.SHOWN)
        self.flown = run

    def show_again(self, moment: Moment) -> int:
        """Go back to a moment and begin a replay there. Return the number of its orders."""
        end = self.flown.end()
        orders = self.recording.orders(self.recording.branch, moment.after)
        again = [each for each in orders if each.id <= end.after]
        self._restore(moment)
        self.flown = ReplayedRun(self, again, end)
        return len(again)

    def take_over(self, why: str) -> None:
        """End a replay here: what follows is a new branch."""
        self.recording.fork(self.now(), why)
        self.flown = LiveRun(self)
        self.automatic.forget_after(self.tick)

    def said(self) -> list[RecordedOrder]:
        """Return the orders that the present state includes; none while they cannot be read."""
        try:
            orders = self.recording.orders(self.recording.branch)
        except RecordingError:
            return []
        return [each for each in orders if each.id <= self.after]

    def end_replay(self, difference: str) -> str:
        """End a replay that has reached its last moment; return its outcome in words."""
        self.flown = LiveRun(self)
        result = difference or "the same to the last bit"
        return f"replay over at {self.boat.time:g} s: {result}; run goes on from here"

    def _restore(self, moment: Moment) -> None:
        """Restore a whole moment. RecordingError leaves everything as it was."""
        latest = self._world_order(moment.branch, moment.after)  # may fail: before any change
        self.boat.restore(np.frombuffer(moment.state, STATE))
        self.boat.world.obey_anew(world_orders(latest))
        self.after, self.place = moment.after, moment.place

    def _state(self) -> bytes:
        return self.boat.plain.tobytes()

"""The past of a run: its branches, its moments, and going back to one.

Who goes back to a moment begins a new branch of the recording there, and the old branch stays. A
replay flies the old branch again. It begins a new one only where somebody takes over.

Each session has one. ``dispatch`` journals orders by it, ``control`` goes back by it, and most
other parts of a session read the past from it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from trainer.boat.helm import obey_order
from trainer.io.orders.grammar import Refused, Reply
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.orders.words import BOAT_ORDERS
from trainer.io.recording.facts import BranchCause
from trainer.io.recording.recording import Moment, RecordedEvent, RecordedOrder, RecordingError
from trainer.session.past.journal import Journal, order_of
from trainer.session.past.run_modes import LiveRun, ReplayedRun, Run, ShownRun

FIRST_BRANCH: Final = 1  # the branch that begins with the run


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
class History(Journal):
    """The past of one run: its journal, its branches, the ways back to them."""

    flown: Run = field(init=False)
    unanswered: list[RecordedOrder] = field(default_factory=list)  # when the program before ended

    def __post_init__(self) -> None:
        super().__post_init__()
        self.flown = LiveRun(self)

    def ticked(self, tick: int) -> bytes:
        """Keep the state after a tick; return it.

        The run at work decides how: a live one records it, a replay compares it.
        """
        state = self.boat.plain.tobytes()
        self.flown.keep(tick, state)
        return state

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
        wanted = max(self.tick - self.boat.ticks_in(seconds), 0)
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

        Orders after the last recorded tick are in no recorded state, so they are given again, each
        at its tick. RecordingError leaves everything as it was.
        """
        orders = self.recording.orders(end.branch, end.after)  # before anything is changed
        here = self.now()
        self._restore(end)
        try:
            for entry in orders:
                self._fly_to(entry.tick)
                order = order_of(entry, schedule)
                if order is not None and order.name in BOAT_ORDERS and entry.accepted:
                    obey_order(self.boat, order)
                self.include(entry)
            last = Moment(end.branch, self.tick, self._state(), self.after, self.entry)
            self.fork_at(last, why)
        except RecordingError:
            self._restore(here)
            raise

    def _fly_to(self, tick: int) -> None:
        """Fly to a tick of which no state is recorded; RecordingError if the boat cannot."""
        while self.tick < tick:
            if status := self.boat.tick():
                raise RecordingError(f"the end cannot be flown: {self.boat.failure(status)}")

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

    def end_replay(self) -> str:
        """End a replay that has reached its last moment; return its outcome in words."""
        result = self.flown.difference or "the same to the last bit"
        self.flown = LiveRun(self)
        return f"replay over at {self.boat.time:g} s: {result}; run goes on from here"

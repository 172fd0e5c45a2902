"""A live run and a replayed one: two objects with one face.

The session asks its run at every tick what is due, and gives it what came of it. Nothing else asks
whether it is a replay. A live run records; a replayed one takes its orders from the recording, and
compares the states, because a replay that leaves its recording is to say so.
"""

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

from trainer.boat.boat import Boat
from trainer.boat.world.encounters import EncounterMonitor
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.facts import Giver
from trainer.io.recording.recording import Moment, RecordedOrder, Recording, RecordingError


class Judge(Protocol):
    """Who judges a tick."""

    def collide(self, met: EncounterMonitor) -> None:
        """Do what the exercise has a collision do."""
        ...

    def tell_ground(self) -> object:
        """Tell of the ground."""
        ...

    def judge_hull(self) -> None:
        """Tell of the ground and the hull, and do what the exercise has them do."""
        ...

    def look(self) -> None:
        """End the exercise if this tick does."""
        ...


class Orders(Protocol):
    """Who carries out what is due."""

    def obey_schedule(self) -> None:
        """Carry out what the exercise has ordered."""
        ...

    def obey_plans(self) -> None:
        """Carry out the instructors' plans."""
        ...

    def obey_again(self) -> None:
        """Have recorded orders obeyed again."""
        ...

    def obey_watch(self) -> None:
        """Carry out what those on watch order."""
        ...

    def end_replay(self, outcome: str) -> None:
        """Let time stand still where a replay has arrived."""
        ...


class Talk(Protocol):
    """Where the words on board are recorded."""

    def event(self, tick: int, kind: str, who: str, text: str, role: str = "") -> None:
        """Take something that happened."""
        ...


class NoTalkRecord:
    """Records nothing: what a replay says again is in the recording."""

    def event(self, tick: int, kind: str, who: str, text: str, role: str = "") -> None:
        """Drop it."""


class RunHistory(Protocol):
    """The history of a run, as far as the run writes it."""

    boat: Boat
    recording: Recording | NoRecording
    after: int
    place: int
    flown: "Run"

    @property
    def tick(self) -> int:
        """Return the number of ticks done."""
        ...

    def now(self) -> Moment:
        """Return the present moment."""
        ...

    def record(self, tick: int, state: bytes) -> None:
        """Record the state after a tick of a live run."""
        ...

    def include(self, entry: RecordedOrder) -> None:
        """Take it that the present state includes an order of the journal."""
        ...

    def arrive(self, difference: str) -> str:
        """End a replay that has arrived; return what became of it."""
        ...


class LiveRun:
    """A run as it is flown for the first time. All of it is recorded."""

    barred = ""  # why nobody may order the boat
    replaying = False  # as it is shown

    def __init__(self, history: RunHistory) -> None:
        self._history = history
        self.talk: Talk = history.recording

    def has_orders(self, schedule: Sequence[ScheduledOrder]) -> bool:
        """Return whether orders of the schedule are still to come."""
        return self._history.place < len(schedule)

    def due_of_schedule(
        self, schedule: Sequence[ScheduledOrder]
    ) -> Iterator[tuple[int, ScheduledOrder]]:
        """Yield the entries that act on the next tick or before it, with their places."""
        history = self._history
        while history.flown is self and history.place < len(schedule):
            entry = schedule[history.place]
            if math.ceil(entry.seconds / history.boat.method.step - 1e-9) > history.tick:
                return
            yield history.place, entry

    def recorded(self, _schedule: Sequence[ScheduledOrder]) -> Iterator[tuple[Order, Giver]]:
        """Yield no order: all are given now."""
        return iter(())

    def obey_due(self, orders: Orders) -> bool:
        """Have the orders obeyed that act on the next tick. No run ends by that."""
        orders.obey_schedule()
        orders.obey_plans()
        return False

    def keep(self, tick: int, state: bytes) -> None:
        """Record the state after a tick."""
        self._history.record(tick, state)

    def keep_timing(self, tick: int, lateness: int, work: int) -> None:
        """Record how late [ns] a tick began, and how long [ns] it worked."""
        self._history.recording.timing(tick, lateness, work)

    def keep_row(self, write: Callable[[], None]) -> None:
        """Have the tick's row written."""
        write()

    def judge(self, judge: Judge, encounters: EncounterMonitor) -> None:
        """Have this tick judged: collisions, the ground, the hull, the exercise's end."""
        judge.collide(encounters)
        self.judge_hull(judge)
        judge.look()

    def judge_hull(self, judge: Judge) -> None:
        """Have the ground and the hull judged."""
        judge.judge_hull()

    def watch(self, orders: Orders) -> None:
        """Have those on watch order what this tick calls for."""
        orders.obey_watch()

    def last_tick(self, branch: int) -> int:
        """Return the last tick of a branch; that of the present one is now."""
        recording = self._history.recording
        flown = recording.last_tick(branch)
        return max(flown, self._history.tick) if branch == recording.branch else flown

    def end(self) -> Moment:
        """Return the moment that a replay from here leads to."""
        return self._history.now()


class ReplayedRun:
    """A run flown again by its recorded orders, and compared with its recorded states."""

    barred = "a replay is running: take over first"
    replaying = True

    def __init__(self, history: RunHistory, orders: Sequence[RecordedOrder], end: Moment) -> None:
        self._history = history
        self._orders = deque(orders)  # still to come
        self._end = end
        self.talk: Talk = NoTalkRecord()
        self.different = ""  # where it first left its recording

    def has_orders(self, _schedule: Sequence[ScheduledOrder]) -> bool:
        """Return that there may be orders, or its end."""
        return True

    def due_of_schedule(
        self, _schedule: Sequence[ScheduledOrder]
    ) -> Iterator[tuple[int, ScheduledOrder]]:
        """Yield nothing: what the schedule ordered is among the recorded orders."""
        return iter(())

    def recorded(self, schedule: Sequence[ScheduledOrder]) -> Iterator[tuple[Order, Giver]]:
        """Yield the orders that were given at this tick, and who gave each."""
        history = self._history
        while self._orders and self._orders[0].tick <= history.tick:
            entry = self._orders.popleft()
            history.include(entry)
            order = order_of(entry, schedule)
            if order is not None:
                yield order, entry.giver

    def obey_due(self, orders: Orders) -> bool:
        """Have the recorded orders of this tick obeyed; return whether the replay ends here."""
        orders.obey_again()
        if self._history.tick < self._end.tick or self._orders:
            return False
        orders.end_replay(self._history.arrive(self.difference))
        return True

    @property
    def difference(self) -> str:
        """Return where the replay left its recording, "" where it did not."""
        same = self._end.state == self._history.now().state
        return self.different or ("" if same else "it did not end in the state that it led to")

    def keep(self, tick: int, state: bytes) -> None:
        """Compare the state after a tick with the one that is recorded."""
        if self.different:
            return
        history = self._history
        try:
            recorded = history.recording.moment(history.recording.branch, tick)
        except RecordingError as error:
            self.different = str(error)
            return
        # a branch may begin with orders of its own tick, which the replay gives only now
        if recorded and recorded.after == history.after and recorded.state != state:
            self.different = f"the replay left its recording at tick {tick}"

    def keep_timing(self, tick: int, lateness: int, work: int) -> None:
        """Keep the timing as it was recorded."""

    def keep_row(self, write: Callable[[], None]) -> None:
        """Write no row: there is one of this tick."""

    def judge(self, judge: Judge, _encounters: EncounterMonitor) -> None:
        """Tell of the ground; the replay goes to its end anyway."""
        self.judge_hull(judge)

    def judge_hull(self, judge: Judge) -> None:
        """Tell of the ground."""
        judge.tell_ground()

    def watch(self, orders: Orders) -> None:
        """Leave the watch's orders to the recording, which has them."""

    def last_tick(self, branch: int) -> int:
        """Return the last tick of a branch that is recorded."""
        return self._history.recording.last_tick(branch)

    def end(self) -> Moment:
        """Return the moment that this replay leads to, and one from here likewise."""
        return self._end


Run = LiveRun | ReplayedRun


def order_of(entry: RecordedOrder, schedule: Sequence[ScheduledOrder]) -> Order | None:
    """Return the order that was journalled, None if this version does not understand it.

    That of a schedule is taken from there: a casualty's has more to it than its words.
    """
    if entry.place is not None and 0 <= entry.place < len(schedule):
        return schedule[entry.place].order
    order = parse(entry.text)
    return order if isinstance(order, Order) else None

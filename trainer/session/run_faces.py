"""A live run, a shown one and a replayed one: three objects with one face.

``history`` holds the one at work. At every tick the session asks its run which orders are due, and
hands it the new state. Nothing else asks whether it is a replay. A live run records the state. A
replayed one takes its orders from the recording and compares the states, because a replay that
leaves its recording has to say so. A shown one is recorded too, with the orders of the reference
crew.
"""

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

from trainer.boat.boat import Boat
from trainer.boat.depths import collapse_of
from trainer.boat.world.encounters import EncounterMonitor
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.facts import Giver
from trainer.io.recording.recording import Moment, RecordedOrder, Recording, RecordingError


class Judge(Protocol):
    """The judge of a tick, as a run needs it."""

    def collide(self, met: EncounterMonitor) -> None:
        """Freeze or end after a collision, as the exercise says."""

    def tell_ground(self) -> object:
        """Announce contact with the ground."""

    def judge_hull(self) -> None:
        """Announce grounding or collapse, and freeze or end as the exercise says."""

    def look(self) -> None:
        """End the exercise if this tick ends it."""


class Orders(Protocol):
    """The orders that may be due at a tick, as a run needs them."""

    def obey_schedule(self) -> None:
        """Carry out the exercise's scheduled orders."""

    def obey_plans(self) -> None:
        """Carry out the instructors' plans."""

    def obey_again(self) -> None:
        """Obey recorded orders again."""

    def obey_watch(self) -> None:
        """Carry out the orders of those on watch."""

    def end_replay(self, outcome: str) -> None:
        """Freeze time where a replay has come to its end."""


class Talk(Protocol):
    """The record of the words on board."""

    def event(self, tick: int, kind: str, who: str, text: str, role: str = "") -> None:
        """Record an event."""


class NoTalkRecord:
    """A record that keeps nothing, because the recording has the words of a replay already."""

    def event(self, tick: int, kind: str, who: str, text: str, role: str = "") -> None:
        """Drop an event."""


class RunHistory(Protocol):
    """The history of a run, as far as the run needs it."""

    boat: Boat
    recording: Recording | NoRecording
    after: int
    place: int
    flown: "Run"

    @property
    def tick(self) -> int:
        """Return the number of ticks done."""

    def now(self) -> Moment:
        """Return the present moment."""

    def record(self, tick: int, state: bytes) -> None:
        """Record the state after a tick of a live run."""

    def include(self, entry: RecordedOrder) -> None:
        """Take it that the present state includes an order of the journal."""

    def end_replay(self, difference: str) -> str:
        """End a replay that has reached its last moment; return its outcome in words."""


class LiveRun:
    """A run that is flown for the first time, and recorded whole."""

    barred = ""  # why nobody may order the boat
    replaying = False  # as it is shown
    shows_way = False  # the reference crew flies it

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
        while history.flown is self and self.next_due(schedule) <= history.tick:
            yield history.place, schedule[history.place]

    def next_due(self, schedule: Sequence[ScheduledOrder]) -> float:
        """Return the tick before which the next entry acts, infinity without one."""
        history = self._history
        if history.place >= len(schedule):
            return math.inf
        seconds = schedule[history.place].seconds
        return math.ceil(seconds / history.boat.method.step - 1e-9)

    def recorded(self, _schedule: Sequence[ScheduledOrder]) -> Iterator[tuple[Order, Giver]]:
        """Yield no order, because a live run's orders are not recorded ones."""
        return iter(())

    def obey_due(self, orders: Orders) -> bool:
        """Obey the orders that act on the next tick. Return False: a live run does not end so."""
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
        """Write the tick's row into the file of columns."""
        write()

    def judge(self, judge: Judge, encounters: EncounterMonitor) -> None:
        """Judge this tick: collisions, the ground, the hull, the exercise's end."""
        judge.collide(encounters)
        self.judge_hull(judge)
        judge.look()

    def judge_arrival(self, judge: Judge) -> None:
        """Judge a moment to which time has jumped. It may be the end of the exercise."""
        self.judge_hull(judge)
        judge.look()

    def judge_hull(self, judge: Judge) -> None:
        """Judge the ground and the hull."""
        judge.judge_hull()

    def watch(self, orders: Orders) -> None:
        """Carry out the orders of those on watch after this tick."""
        orders.obey_watch()

    def last_tick(self, branch: int) -> int:
        """Return the last tick of a branch, of the present one the present tick."""
        recording = self._history.recording
        flown = recording.last_tick(branch)
        return max(flown, self._history.tick) if branch == recording.branch else flown

    def end(self) -> Moment:
        """Return the moment that a replay from here leads to."""
        return self._history.now()


class ShownRun(LiveRun):
    """A run on which the reference crew shows the way, up to a tick."""

    barred = "the reference crew shows the way: demonstrate off ends it"
    shows_way = True

    def __init__(
        self,
        history: RunHistory,
        last_tick: int,
        speak: Callable[[], None],
        end: Callable[[], None],
    ) -> None:
        super().__init__(history)
        self.last = last_tick
        self._speak, self._end = speak, end

    def has_orders(self, _schedule: Sequence[ScheduledOrder]) -> bool:
        """Return True, because the crew may order something, or the end be there."""
        return True

    def obey_due(self, orders: Orders) -> bool:
        """Obey the schedule and then the crew; return whether the way has been shown."""
        if self._history.tick >= self.last:
            self._end()
            return True
        orders.obey_schedule()
        self._speak()
        return False

    def judge(self, _judge: Judge, encounters: EncounterMonitor) -> None:
        """Show no more of a boat that is lost. What is shown ends no exercise."""
        if encounters.struck or collapse_of(self._history.boat):
            self.last = self._history.tick

    def judge_hull(self, judge: Judge) -> None:
        """Tell of the ground."""
        judge.tell_ground()

    def watch(self, _orders: Orders) -> None:
        """Do nothing, because the crew's watch is not theirs."""


class ReplayedRun:
    """A run flown again by its recorded orders, and compared with its recorded states."""

    barred = "a replay is running: take over first"
    replaying = True
    shows_way = False

    def __init__(self, history: RunHistory, orders: Sequence[RecordedOrder], end: Moment) -> None:
        self._history = history
        self._orders = deque(orders)  # still to come
        self._end = end
        self.talk: Talk = NoTalkRecord()
        self.different = ""  # where it first left its recording

    def has_orders(self, _schedule: Sequence[ScheduledOrder]) -> bool:
        """Return True, because recorded orders or the end of the replay may be due."""
        return True

    def due_of_schedule(
        self, _schedule: Sequence[ScheduledOrder]
    ) -> Iterator[tuple[int, ScheduledOrder]]:
        """Yield nothing, because the recorded orders include those of the schedule."""
        return iter(())

    def next_due(self, _schedule: Sequence[ScheduledOrder]) -> float:
        """Return 0, because each tick is compared with the recorded one."""
        return 0.0

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
        """Obey the recorded orders of this tick; return whether the replay ends here."""
        orders.obey_again()
        if self._history.tick < self._end.tick or self._orders:
            return False
        orders.end_replay(self._history.end_replay(self.difference))
        return True

    @property
    def difference(self) -> str:
        """Return where the replay left its recording, "" where it did not."""
        same = self._end.state == self._history.now().state
        return self.different or ("" if same else "it did not end in the state that it led to")

    def keep(self, tick: int, state: bytes) -> None:
        """Compare the state after a tick with the recorded one."""
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
        """Record no timing, because the recording has that of the live run."""

    def keep_row(self, write: Callable[[], None]) -> None:
        """Write no row, because the live run has written one for this tick."""

    def judge(self, judge: Judge, _encounters: EncounterMonitor) -> None:
        """Announce contact with the ground. Nothing ends a replay before its end."""
        self.judge_hull(judge)

    def judge_hull(self, judge: Judge) -> None:
        """Tell of the ground."""
        judge.tell_ground()

    def judge_arrival(self, judge: Judge) -> None:
        """Tell of the ground: a replay flies on to its own end."""
        self.judge_hull(judge)

    def watch(self, orders: Orders) -> None:
        """Do nothing, because the recording has the watch's orders."""

    def last_tick(self, branch: int) -> int:
        """Return the last recorded tick of a branch."""
        return self._history.recording.last_tick(branch)

    def end(self) -> Moment:
        """Return the moment at which this replay ends, and also one that begins within it."""
        return self._end


Run = LiveRun | ShownRun | ReplayedRun


def order_of(entry: RecordedOrder, schedule: Sequence[ScheduledOrder]) -> Order | None:
    """Return the order that was journalled, None if this version does not understand it.

    A scheduled order comes from the schedule, because a casualty there has more than its words.
    """
    if entry.place is not None and 0 <= entry.place < len(schedule):
        return schedule[entry.place].order
    order = parse(entry.text)
    return order if isinstance(order, Order) else None

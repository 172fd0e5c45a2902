"""A live run, a shown one and a replayed one: three objects with one face.

``history`` holds the one at work. It says which orders are due at a tick and what is judged after
it, and is handed the new state. Nothing else asks whether it is a replay. A live run records the
state. A replayed one takes its orders from the recording and compares the states, because a replay
that leaves its recording has to say so. A shown one is recorded too, with the orders of the
reference crew.
"""

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from enum import Enum

from trainer.boat.depths import collapse_of
from trainer.boat.world.encounters import EncounterMonitor
from trainer.io.orders.grammar import Order, Refused
from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.recording.absence import NoRecording
from trainer.io.recording.facts import Giver
from trainer.io.recording.recording import Moment, RecordedOrder, RecordingError
from trainer.session.past.journal import Journal, order_of


class Due(Enum):
    """What may be due before a tick."""

    SCHEDULE = "the exercise's orders"
    PLANS = "the instructors' plans"
    CREW = "the orders of the reference crew, which shows the way"
    JOURNAL = "the orders that were recorded"
    END_OF_WAY = "the way has been shown"
    END_OF_REPLAY = "the replay is over"


class JudgementScope(Enum):
    """What is judged of a run."""

    NOTHING = "nothing"
    GROUND = "contact with the ground, which is told"
    ALL = "collisions, the ground, the hull and the exercise's end, each of which may end it"


class LiveRun:
    """A run that is flown for the first time, and recorded whole."""

    barred: Refused | None = None  # why nobody may order the boat
    replaying = False  # as it is shown
    shows_way = False  # the reference crew flies it
    watched = True  # by a crew, whose orders are its own
    judged = JudgementScope.ALL
    difference = ""  # from what is recorded of it

    def __init__(self, journal: Journal) -> None:
        self._journal = journal
        self.talk = journal.recording  # of the words on board

    def has_orders(self, schedule: Sequence[ScheduledOrder]) -> bool:
        """Return whether orders of the schedule are still to come."""
        return self._journal.entry < len(schedule)

    def due_of_schedule(
        self, schedule: Sequence[ScheduledOrder]
    ) -> Iterator[tuple[int, ScheduledOrder]]:
        """Yield the entries that act on the next tick or before it, with their indices."""
        journal = self._journal
        while self.next_due(schedule) <= journal.tick:
            yield journal.entry, schedule[journal.entry]

    def next_due(self, schedule: Sequence[ScheduledOrder]) -> float:
        """Return the tick before which the next entry acts, infinity without one."""
        journal = self._journal
        if journal.entry >= len(schedule):
            return math.inf
        return journal.boat.ticks_in(schedule[journal.entry].seconds)

    def recorded(self, _schedule: Sequence[ScheduledOrder]) -> Iterator[tuple[Order, Giver]]:
        """Yield no order, because a live run's orders are not recorded ones."""
        return iter(())

    def due(self) -> Iterator[Due]:
        """Yield what is due before a tick. Each is carried out before the next is asked for."""
        yield Due.SCHEDULE
        yield Due.PLANS

    def keep(self, tick: int, state: bytes) -> None:
        """Record the state after a tick."""
        self._journal.record(tick, state)

    def keep_timing(self, tick: int, lateness: int, work: int) -> None:
        """Record how late [ns] a tick began, and how long [ns] it worked."""
        self._journal.recording.timing(tick, lateness, work)

    def keep_row(self, write: Callable[[], None]) -> None:
        """Write the tick's row into the file of columns."""
        write()

    def last_tick(self, branch: int) -> int:
        """Return the last tick of a branch, of the present one the present tick."""
        recording = self._journal.recording
        flown = recording.last_tick(branch)
        return max(flown, self._journal.tick) if branch == recording.branch else flown

    def end(self) -> Moment:
        """Return the moment that a replay from here leads to."""
        return self._journal.now()


class ShownRun(LiveRun):
    """A run on which the reference crew shows the way, until the boat is lost."""

    barred = Refused("the reference crew shows the way: demonstrate off ends it")
    shows_way = True
    watched = False
    judged = JudgementScope.NOTHING  # what is shown ends no exercise

    def __init__(self, journal: Journal, last_tick: int, met: EncounterMonitor) -> None:
        super().__init__(journal)
        self._begun, self._last, self._met = journal.tick, last_tick, met

    def has_orders(self, _schedule: Sequence[ScheduledOrder]) -> bool:
        """Return True, because the crew may order something, or the end be there."""
        return True

    def due(self) -> Iterator[Due]:
        """Yield the schedule and then the crew, or that the way has been shown."""
        tick, boat = self._journal.tick, self._journal.boat
        lost = tick > self._begun and (self._met.struck or collapse_of(boat))
        if lost or tick >= self._last:
            yield Due.END_OF_WAY
        else:
            yield Due.SCHEDULE
            yield Due.CREW


class ReplayedRun:
    """A run flown again by its recorded orders, and compared with its recorded states."""

    barred = Refused("a replay is running: take over first")
    replaying = True
    shows_way = False
    watched = False  # the recording has the watch's orders
    judged = JudgementScope.GROUND  # nothing ends a replay before its end

    def __init__(self, journal: Journal, orders: Sequence[RecordedOrder], end: Moment) -> None:
        self._journal = journal
        self._orders = deque(orders)  # still to come
        self._end = end
        self.talk = NoRecording()  # which has these words already
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
        """Yield the orders that were obeyed at this tick, and who gave each."""
        journal = self._journal
        while self._orders and self._orders[0].tick <= journal.tick:
            entry = self._orders.popleft()
            journal.include(entry)
            order = order_of(entry, schedule)
            if order is not None and entry.accepted:
                yield order, entry.giver

    def due(self) -> Iterator[Due]:
        """Yield the recorded orders of this tick, and after the last ones the end."""
        yield Due.JOURNAL
        if self._journal.tick >= self._end.tick and not self._orders:
            yield Due.END_OF_REPLAY

    @property
    def difference(self) -> str:
        """Return where the replay left its recording, "" where it did not."""
        same = self._end.state == self._journal.now().state
        return self.different or ("" if same else "it did not end in the state that it led to")

    def keep(self, tick: int, state: bytes) -> None:
        """Compare the state after a tick with the recorded one."""
        if self.different:
            return
        journal = self._journal
        try:
            recorded = journal.recording.moment(journal.recording.branch, tick)
        except RecordingError as error:
            self.different = str(error)
            return
        # a branch may begin with orders of its own tick, which the replay gives only now
        if recorded and recorded.after == journal.after and recorded.state != state:
            self.different = f"the replay left its recording at tick {tick}"

    def keep_timing(self, tick: int, lateness: int, work: int) -> None:
        """Record no timing, because the recording has that of the live run."""

    def keep_row(self, write: Callable[[], None]) -> None:
        """Write no row, because the live run has written one for this tick."""

    def last_tick(self, branch: int) -> int:
        """Return the last recorded tick of a branch."""
        return self._journal.recording.last_tick(branch)

    def end(self) -> Moment:
        """Return the moment at which this replay ends, and also one that begins within it."""
        return self._end


Run = LiveRun | ReplayedRun

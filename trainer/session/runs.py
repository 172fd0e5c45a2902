"""How a run is flown: live, or again as it was recorded.

Both have one face, so that nobody else asks which of them it is. A live run is recorded; a replayed
one is compared with its recording, and nobody orders it.
"""

import math
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Protocol

from trainer.boat.world.encounters import EncounterMonitor
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.schedule import Scheduled
from trainer.io.recording.recording import Journalled, Moment, RecordingError

if TYPE_CHECKING:
    from trainer.session.conduct import Conduct
    from trainer.session.dispatch import Dispatch
    from trainer.session.history import History


class Talk(Protocol):
    """Where the words on board are recorded."""

    def event(self, tick: int, kind: str, who: str, text: str) -> None:
        """Take something that happened."""
        ...


class Unrecorded:
    """Records nothing: what a replay says again is in the recording."""

    def event(self, tick: int, kind: str, who: str, text: str) -> None:
        """Drop it."""


class LiveRun:
    """A run as it is flown for the first time. All of it is recorded."""

    barred = ""  # why nobody may order the boat
    replaying = False  # as it is shown

    def __init__(self, history: "History") -> None:
        self._history = history
        self.talk: Talk = history.recording

    def has_orders(self, schedule: Sequence[Scheduled]) -> bool:
        """Return whether orders of the schedule are still to come."""
        return self._history.place < len(schedule)

    def due_of_schedule(self, schedule: Sequence[Scheduled]) -> Iterator[tuple[int, Scheduled]]:
        """Yield the entries that act on the next tick or before it, with their places."""
        history = self._history
        while history.flown is self and history.place < len(schedule):
            entry = schedule[history.place]
            if math.ceil(entry.seconds / history.boat.method.step - 1e-9) > history.tick:
                return
            yield history.place, entry

    def recorded(self, _schedule: Sequence[Scheduled]) -> Iterator[tuple[Order, str]]:
        """Yield no order: all are given now."""
        return iter(())

    def obey_due(self, dispatch: "Dispatch") -> bool:
        """Have the orders obeyed that act on the next tick. No run ends by that."""
        dispatch.obey_schedule()
        dispatch.obey_plans()
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

    def judge(self, conduct: "Conduct", encounters: EncounterMonitor) -> None:
        """Have this tick judged: collisions, the ground, the hull, the exercise's end."""
        conduct.collide(encounters)
        self.judge_hull(conduct)
        conduct.look()

    def judge_hull(self, conduct: "Conduct") -> None:
        """Have the ground and the hull judged."""
        conduct.judge_hull()

    def watch(self, dispatch: "Dispatch") -> None:
        """Have those on watch order what this tick calls for."""
        dispatch.obey_watch()

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

    def __init__(self, history: "History", orders: Sequence[Journalled], end: Moment) -> None:
        self._history = history
        self._orders = deque(orders)  # still to come
        self._end = end
        self.talk: Talk = Unrecorded()
        self.different = ""  # where it first left its recording

    def has_orders(self, _schedule: Sequence[Scheduled]) -> bool:
        """Return that there may be orders, or its end."""
        return True

    def due_of_schedule(self, _schedule: Sequence[Scheduled]) -> Iterator[tuple[int, Scheduled]]:
        """Yield nothing: what the schedule ordered is among the recorded orders."""
        return iter(())

    def recorded(self, schedule: Sequence[Scheduled]) -> Iterator[tuple[Order, str]]:
        """Yield the orders that were given at this tick, and who gave each."""
        history = self._history
        while self._orders and self._orders[0].tick <= history.tick:
            entry = self._orders.popleft()
            history.include(entry)
            order = order_of(entry, schedule)
            if order is not None:
                yield order, entry.who

    def obey_due(self, dispatch: "Dispatch") -> bool:
        """Have the recorded orders of this tick obeyed; return whether the replay ends here."""
        dispatch.obey_again()
        if self._history.tick < self._end.tick or self._orders:
            return False
        dispatch.session.end_replay(self._history.arrive(self.difference))
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

    def judge(self, conduct: "Conduct", _encounters: EncounterMonitor) -> None:
        """Tell of the ground; the replay goes to its end anyway."""
        self.judge_hull(conduct)

    def judge_hull(self, conduct: "Conduct") -> None:
        """Tell of the ground."""
        conduct.tell_ground()

    def watch(self, dispatch: "Dispatch") -> None:
        """Leave the watch's orders to the recording, which has them."""

    def last_tick(self, branch: int) -> int:
        """Return the last tick of a branch that is recorded."""
        return self._history.recording.last_tick(branch)

    def end(self) -> Moment:
        """Return the moment that this replay leads to, and one from here likewise."""
        return self._end


Run = LiveRun | ReplayedRun


def order_of(entry: Journalled, schedule: Sequence[Scheduled]) -> Order | None:
    """Return the order that was journalled, None if this version does not understand it.

    That of a schedule is taken from there: a casualty's has more to it than its words.
    """
    if entry.place is not None and 0 <= entry.place < len(schedule):
        return schedule[entry.place].order
    order = parse(entry.text)
    return order if isinstance(order, Order) else None

"""The samples of a screen's charts, and the boat's track, present and past.

``model`` calls ``sample`` at each new reading, and ``recall`` when a past has come whole. Drawings
read ``trace`` and ``track``.
"""

import bisect
import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from typing import Final, NamedTuple

from trainer.console.past import EVENTS_CHANNEL, LATE_TIME_S, PastAnswers
from trainer.console.readings import ChannelReadings

MAX_TRACE_TICKS: Final = 4800  # ticks: 40 minutes at half a second
MAX_TRACK_POINTS: Final = 4000  # points of the track
TRACK_PERIOD_S: Final = 2.0  # [s] between them
GHOST_CHANNEL: Final = "ghost"  # of an aid
Numbers = Callable[[str, str], float | None]  # the value of a channel and its field


class Sample(NamedTuple):
    """A quantity at one time; None where nothing is ordered, or the boat lacks it."""

    actual: float | None
    ordered: float | None
    ghost: float | None = None  # of the reference crew's run


class Quantity(NamedTuple):
    """A quantity of a chart: name, unit, and the fields of value and order."""

    name: str
    unit: str
    actual: tuple[str, str]  # channel, field
    ordered: tuple[str, str] | None
    least: float  # shown range at least
    signs: tuple[str, str] = ("", "")  # before a positive and a negative value
    crew: str = ""  # the order to the crew that is shown in place of the autopilot's

    def channels(self) -> set[str]:
        """Return the channels of its fields."""
        orders = {"orders"} if self.crew else set()
        return {self.actual[0], *(self.ordered or ())[:1]} | orders

    def order(self, number: Numbers) -> float | None:
        """Return the order to the crew, else the autopilot's."""
        value = number("orders", self.crew) if self.crew else None
        return number(*self.ordered) if value is None and self.ordered else value

    def sample(self, number: Numbers) -> Sample:
        """Return its value, its order, and the ghost's value."""
        return Sample(number(*self.actual), self.order(number), number(GHOST_CHANNEL, self.name))


@dataclass
class Trace:
    """Samples of some quantities, by time."""

    times: list[float] = field(default_factory=list)  # [s]
    samples: list[Sequence[Sample]] = field(default_factory=list)

    def add(self, seconds: float, samples: Sequence[Sample]) -> None:
        """Add the samples of a time. Later ones are dropped, because time has gone back."""
        index = bisect.bisect_left(self.times, seconds)
        del self.times[index:], self.samples[index:]
        self.times.append(seconds)
        self.samples.append(tuple(samples))
        # a quarter more may gather, so that the lists are not cut at every tick
        if len(self.times) > MAX_TRACE_TICKS + MAX_TRACE_TICKS // 4:
            del self.times[:-MAX_TRACE_TICKS], self.samples[:-MAX_TRACE_TICKS]

    def recall(self, rows: Sequence[tuple[float, Sequence[Sample]]]) -> None:
        """Put samples of earlier times among the present ones, which stay."""
        traced = dict(zip(self.times, self.samples, strict=True))
        latest = self.times[-1] if self.times else math.inf
        whole = {seconds: samples for seconds, samples in rows if seconds < latest} | traced
        self.times = sorted(whole)[-MAX_TRACE_TICKS:]
        self.samples = [whole[seconds] for seconds in self.times]

    def recall_ghost(self, rows: Sequence[tuple[float, Sequence[float | None]]]) -> None:
        """Put the ghost's values of earlier times beside the samples."""
        times = [seconds for seconds, _ in rows]
        for index, (seconds, samples) in enumerate(zip(self.times, self.samples, strict=True)):
            row = bisect.bisect_right(times, seconds) - 1
            if row >= 0 and samples and samples[0].ghost is None:
                pairs = zip(samples, rows[row][1], strict=True)
                self.samples[index] = tuple(each._replace(ghost=value) for each, value in pairs)

    def series(self, quantity: int, span: float, columns: int) -> list[Sample | None]:
        """Return a quantity at times over the last ``span`` [s], None before the first."""
        if not self.times:
            return [None] * columns
        end, values = self.times[-1], []
        for column in range(columns):
            when = end - span * (columns - 1 - column) / max(columns - 1, 1)
            index = bisect.bisect_right(self.times, when + 1e-9) - 1
            values.append(self.samples[index][quantity] if index >= 0 else None)
        return values


@dataclass
class Charts:
    """All that the charts of a screen are drawn from."""

    quantities: tuple[Quantity, ...]
    gauges: str  # the channel of depth, heading, speed and attitude
    picture: ChannelReadings
    past: PastAnswers
    ask: Callable[[str], bool]  # sends an order of the screen's own
    trace: Trace = field(default_factory=Trace)
    caught_up: bool = False  # with what was shown before the line was there
    _ghost: bool = False  # it is shown

    def __post_init__(self) -> None:
        self._track: deque[tuple[float, float, float]] = deque(maxlen=MAX_TRACK_POINTS)  # [s, m, m]

    @property
    def track(self) -> list[tuple[float, float]]:
        """Return where the boat has been [m] north and east, oldest first."""
        reading = self.picture.reading("motion")
        north, east = reading.number("north"), reading.number("east")
        now = [] if north is None or east is None else [(north, east)]
        return [(n, e) for _, n, e in self._track] + now

    def sample(self) -> None:
        """Add the present values."""
        seconds = self.picture.reading(self.gauges).seconds
        self._catch_up(seconds)
        self._follow(seconds)
        number = self.picture.number
        ghost = number(GHOST_CHANNEL, "depth") is not None
        if ghost and not self._ghost:  # its past was not shown while it was off
            self.ask(f"history {GHOST_CHANNEL} 60 min")
        self._ghost = ghost
        if self.trace.times[-1:] != [seconds]:
            self.trace.add(seconds, [each.sample(number) for each in self.quantities])

    def _catch_up(self, seconds: float) -> None:
        """Ask for the past that a late or returning screen has not seen."""
        missed, self.caught_up = not self.caught_up, True
        seen = self.trace.times[-1] if self.trace.times else 0.0
        if missed and seconds - seen > LATE_TIME_S:
            channels = {self.gauges}.union(*(each.channels() for each in self.quantities))
            # only those that this role is shown
            self.past.ask(channels & set(self.picture.names), self.ask)

    def _follow(self, seconds: float) -> None:
        """Add the boat's location to its track. Later ones are dropped: time has gone back."""
        reading = self.picture.reading(self.gauges)
        north, east = reading.number("north"), reading.number("east")
        if north is None or east is None:
            return
        while self._track and self._track[-1][0] > seconds:
            self._track.pop()
        if not self._track or seconds - self._track[-1][0] >= TRACK_PERIOD_S:
            self._track.append((seconds, north, east))

    def recall(self, channel: str) -> None:
        """Put the past of a channel, which has come whole, before the present."""
        if channel == GHOST_CHANNEL:
            names = [each.name for each in self.quantities]
            ghosts = sorted(self.past.rows.get(GHOST_CHANNEL, {}).items())
            self.trace.recall_ghost([(s, [row.number(n) for n in names]) for s, row in ghosts])
        elif not self.past.wanted - {EVENTS_CHANNEL}:
            rows = sorted(self.past.rows.get(self.gauges, {}).items())
            numbers = [(s, partial(self.past.number, s)) for s, _ in rows]
            self.trace.recall([(s, [q.sample(n) for q in self.quantities]) for s, n in numbers])
            first = self._track[0][0] if self._track else math.inf
            points = [(s, r.number("north"), r.number("east")) for s, r in rows if s < first]
            earlier = [(s, n, e) for s, n, e in points if n is not None and e is not None]
            room = MAX_TRACK_POINTS - len(self._track)
            self._track.extendleft(islice(reversed(earlier), room))

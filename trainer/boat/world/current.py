"""The current around a boat: uniform, by depth or a tide, until an order.

``world`` makes it of the exercise's table, and writes it into the state before each tick, in which
the core moves the boat with it. A current goes towards its bearing, over the ground. Between two
depths of a table it is a straight line, ``water + shear z``, because the hull spans some depths.
"""

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from operator import itemgetter
from typing import Any, Final

from trainer.boat.world.bottom import STATE_OFFSETS, TICK_OFFSET, Z
from trainer.config.world.current import MIN_CHANGE_TIME_S, Current, Tide
from trainer.config.world.world import WorldTables
from trainer.core.current import north_and_east
from trainer.io.orders.grammar import Order, Reply
from trainer.units import KNOT

Line = tuple[float, float, float, float]  # water north, east [m/s] and shear north, east [1/s]
Flow = Callable[[float, float], Line]  # from time [s] and depth [m]
HOUR_S: Final = 3600.0  # [s]
CURRENT_OFFSET: Final = STATE_OFFSETS["current"]
STILL_WATER: Final[Line] = (0.0, 0.0, 0.0, 0.0)  # no current at any depth
SHIP_DRIFT_DEPTH_M: Final = 5.0  # [m] depth of the water that carries ships
TIDE_SPAN_S: Final = (
    60.0  # [s] of a tide that three points integrate to 1e-13 of the way, and better
)
GAUSS_POINTS: Final = ((-math.sqrt(0.6), 5 / 18), (0.0, 8 / 18), (math.sqrt(0.6), 5 / 18))
Mark = tuple[float, float, float]  # time [s], and how far water has gone [m] north and east
START_MARKS: Final[tuple[Mark, ...]] = ((0.0, 0.0, 0.0),)


def uniform_water(towards: float, drift: float) -> Line:
    """Return the same water at all depths; ``towards`` [rad] at ``drift`` [m/s]."""
    north, east = north_and_east(towards)
    return drift * north, drift * east, 0.0, 0.0


def current_vector(set_deg: float, drift_kn: float) -> tuple[float, float]:
    """Return a current north and east [m/s]."""
    return uniform_water(math.radians(set_deg), drift_kn * KNOT)[:2]


class WaterLayers:
    """Water by depth: a line between each row and the next."""

    def __init__(self, rows: tuple[tuple[float, ...], ...]) -> None:
        self.depths = [row[0] for row in rows]
        waters = [current_vector(*row[1:]) for row in rows]
        between = [
            _line(*both)
            for both in zip(self.depths[:-1], self.depths[1:], waters[:-1], waters[1:], strict=True)
        ]
        self.lines = [(*waters[0], 0.0, 0.0), *between, (*waters[-1], 0.0, 0.0)]

    def __call__(self, _time: float, depth: float) -> Line:
        """Return the line at a depth [m]."""
        return self.lines[bisect_right(self.depths, depth)]


def _line(
    above: float, below: float, upper: tuple[float, float], lower: tuple[float, float]
) -> Line:
    """Return the line from the water at one depth [m] to that at another."""
    north = (lower[0] - upper[0]) / (below - above)
    east = (lower[1] - upper[1]) / (below - above)
    return upper[0] - north * above, upper[1] - east * above, north, east


class TidalEllipse:
    """Water that turns with the tide about a mean: a cosine along, a sine across."""

    def __init__(self, tide: Tide) -> None:
        self.mean = current_vector(tide.mean_set_deg or 0.0, tide.mean_drift_kn or 0.0)
        self.ahead = current_vector(tide.towards_deg, tide.major_kn)
        self.across = current_vector(tide.towards_deg + 90.0, tide.minor_kn)
        self.rate = math.tau / (tide.period_h * HOUR_S)
        self.since = tide.phase_h * HOUR_S

    def __call__(self, time: float, _depth: float) -> Line:
        """Return the water of a time [s]."""
        turned = self.rate * (time + self.since)
        cosine, sine = north_and_east(turned)
        (a_north, a_east), (b_north, b_east) = self.ahead, self.across
        north, east = a_north * cosine + b_north * sine, a_east * cosine + b_east * sine
        return self.mean[0] + north, self.mean[1] + east, 0.0, 0.0


@dataclass(frozen=True)
class SteadyWater:
    """Water that goes the same way at all times and depths."""

    line: Line

    def __call__(self, _time: float, _depth: float) -> Line:
        """Return the water of any time and depth."""
        return self.line


def flow_of(current: Current | None) -> Flow | None:
    """Return the water of an exercise, None without any."""
    if current is None:
        return None
    if current.table:
        return WaterLayers(current.table)
    if current.tide:
        return TidalEllipse(current.tide)
    return SteadyWater((*current_vector(current.set_deg or 0.0, current.drift_kn or 0.0), 0.0, 0.0))


@dataclass(frozen=True)
class CurrentChange:
    """Another current, ordered at a tick."""

    tick: int
    line: Line


# the marks, after the changes that they know of
CurrentHistory = tuple[tuple[CurrentChange, ...], tuple[Mark, ...]]


@dataclass
class CurrentAround:
    """The current of one run, a part of its world."""

    step: float  # [s]
    ramp: float  # [s] of an order
    flow: Flow | None  # as the exercise has it
    changes: tuple[CurrentChange, ...] = ()  # in the order of their ticks
    _carried: CurrentHistory = field(default=((), START_MARKS), repr=False)

    @property
    def acts(self) -> bool:
        """Return whether there is any current, or was."""
        return self.flow is not None or bool(self.changes)

    def obey(self, order: Order, tick: int) -> Reply:
        """Replace all that there is by another current, over the ramp; return it in words."""
        line = STILL_WATER if order.word == "off" else uniform_water(order.numbers[0], order.value)
        before = tuple(each for each in self._carried[1] if each[0] <= tick * self.step)
        self.changes = (*self.changes, CurrentChange(tick, line))
        self._carried = self.changes, before or START_MARKS
        return f"{order.text}: {current_text(*line[:2])}, within {self.ramp:g} s"

    def forget(self) -> None:
        """Forget all orders: the current is that of the exercise."""
        self.changes, self._carried = (), ((), START_MARKS)

    def stands(self, tick: int) -> bool:
        """Return whether the current is the same from a tick on, at every depth."""
        if self.changes:
            return all(self._share(each, tick) >= 1.0 for each in self.changes)
        return isinstance(self.flow, SteadyWater)

    def write(self, numbers: Any) -> None:
        """Write the current at the boat's depth for the tick that comes."""
        for i, each in enumerate(self.at(int(numbers[TICK_OFFSET]), numbers[Z]), CURRENT_OFFSET):
            numbers[i] = each

    def at(self, tick: float, depth: float) -> Line:
        """Return the current at a tick, or between two ticks, as a line over depth."""
        if not self.changes:
            return self.flow(tick * self.step, depth) if self.flow else STILL_WATER
        whole = bisect_left(self.changes, 1, key=lambda each: self._share(each, tick) < 1.0)
        line = self.changes[whole - 1].line if whole else STILL_WATER  # it hides what was before
        if not whole and self.flow:
            line = self.flow(tick * self.step, depth)
        for each in self.changes[whole:]:
            if each.tick >= tick:
                break
            line = _between(line, each.line, self._share(each, tick))
        return line

    def floating(self, time: float) -> tuple[float, float]:
        """Return how the water that carries ships goes at a time, north and east [m/s]."""
        north, east, by_north, by_east = self.at(time / self.step, SHIP_DRIFT_DEPTH_M)
        return north + by_north * SHIP_DRIFT_DEPTH_M, east + by_east * SHIP_DRIFT_DEPTH_M

    def carried(self, time: float) -> tuple[float, float]:
        """Return how far [m] the water that carries ships has gone, north and east.

        The way is summed between fixed marks of time, so that its bits do not depend on when it is
        asked for.
        """
        changes, marks = self._carried
        if marks[-1][0] < time:
            marks = tuple(self._marks(marks, time))
            if changes is self.changes:  # not ordered anew meanwhile
                self._carried = changes, marks
        start, north, east = marks[bisect_right(marks, time, key=itemgetter(0)) - 1]
        by_north, by_east = self._way(start, time)
        return north + by_north, east + by_east

    def _marks(self, known: tuple[Mark, ...], time: float) -> Iterator[Mark]:
        """Yield the marks up to a time [s]: each TIDE_SPAN_S, and where a ramp begins or ends."""
        yield from known
        here, north, east = known[-1]
        ramps = (each.tick * self.step for each in self.changes)
        edges = sorted(edge for begun in ramps for edge in (begun, begun + self.ramp))
        while True:
            further = bisect_right(edges, here)
            end = min(here + TIDE_SPAN_S, edges[further] if further < len(edges) else math.inf)
            if end > time:
                return
            by_north, by_east = self._way(here, end)
            here, north, east = end, north + by_north, east + by_east
            yield here, north, east

    def _way(self, start: float, end: float) -> tuple[float, float]:
        """Return how far [m] the water goes from ``start`` to ``end``, by Gauss and Legendre."""
        long = end - start
        rates = [
            (weight, *self.floating(start + 0.5 * (1.0 + x) * long)) for x, weight in GAUSS_POINTS
        ]
        return (
            long * sum(weight * north for weight, north, _ in rates),
            long * sum(weight * east for weight, _, east in rates),
        )

    def _share(self, change: CurrentChange, tick: float) -> float:
        """Return how much of a change has come about, 0 to 1."""
        return min(max((tick - change.tick) * self.step / self.ramp, 0.0), 1.0)


def _between(old: Line, new: Line, share: float) -> Line:
    """Return what is ``share`` of the way from one line to another."""
    if share >= 1.0:
        return new  # exactly, without the rounding of a sum
    a, b, c, d = (here + share * (there - here) for here, there in zip(old, new, strict=True))
    return a, b, c, d


def make_current(boat: Any, tables: WorldTables) -> CurrentAround:
    """Return the current of an exercise around a boat."""
    current: Current | None = tables.get("current")
    ramp = current.ramp_s if current else MIN_CHANGE_TIME_S
    return CurrentAround(boat.method.step, ramp, flow_of(current))


def current_text(north: float, east: float) -> str:
    """Return water over ground [m/s] in words."""
    drift = math.hypot(north, east) / KNOT
    if drift < 0.005:  # it is written as zero
        return "no current"
    towards = round(math.degrees(math.atan2(east, north))) % 360
    return f"towards {towards:03d} at {drift:.3g} kn"

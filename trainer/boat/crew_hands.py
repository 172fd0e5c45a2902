"""The hands of a reference crew work planes and rudder by what the crew sees.

``reference_crew`` has a planesman and a helmsman, and ``authoring/trainees`` makes worse ones of
them. A hand looks at the gauges every few seconds, works out an angle by gains that the exercise
file gives ([planesman], [helmsman]), and orders whole degrees, as a person does. It knows nothing
that a person could not see, so that people can reach its marks.
"""

import math
from bisect import bisect_left
from collections.abc import Callable, Iterable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from operator import itemgetter
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.casualties import InstrumentReadings, instrument_readings
from trainer.boat.crew_orders import CREW_AXES
from trainer.config.exercise.reference_crew import Helmsman, Planesman
from trainer.core.casualties import DEPTH_GAUGE, GAUGES, GYRO
from trainer.core.kernel import Numbers, Record

GAUGE_MEMORY_S: Final = 601.0  # [s] of gauges that are remembered: mean_s of a rule is 600 at most
RATE_PERIOD_S: Final = 2.0  # [s] over which a rate is seen on a gauge
TIME_ROUNDING_S: Final = 1e-6  # [s] rounding of a sum of steps
ORDER_SLACK: Final = 1e-6  # [deg] or [m]: far more than numbers of many ticks are rounded otherwise
ORDER_OFFSET: Final = STATE_OFFSETS["crew_order"]  # of the orders to the crew, by axis
STAMP_OFFSET: Final = STATE_OFFSETS["crew_order_tick"]


@dataclass
class GaugeHistory:
    """The readings of the gauges over some minutes."""

    exact: ClassVar[bool] = True  # whether ``mean`` and ``now`` tell what was read
    boat: Boat
    seen: list[tuple[float, Sequence[float]]] = field(default_factory=list)  # each with its time

    def look(self) -> None:
        """Read the gauges at this tick, unless what was flown has told their readings."""
        if not self.seen or self.seen[-1][0] != self.boat.time:
            self.remember([(self.boat.time, instrument_readings(self.boat))])

    def look_again(self) -> None:
        """Read the gauges at this tick, because orders may have changed what they show."""
        if self.seen and self.seen[-1][0] == self.boat.time:
            del self.seen[-1]
        self.look()

    def remember(self, readings: Iterable[tuple[float, Sequence[float]]]) -> None:
        """Take readings with their times [s], the latest last."""
        self.seen += readings
        del self.seen[: self._index(self.seen[-1][0] - GAUGE_MEMORY_S)]

    def _index(self, time: float) -> int:
        """Return the index of the first reading not before a time [s]."""
        return bisect_left(self.seen, time, key=itemgetter(0))

    def now(self) -> InstrumentReadings:
        """Return the readings of the last look."""
        return InstrumentReadings(*self.seen[-1][1])

    def mean(self, name: str, seconds: float) -> float:
        """Return the mean of a gauge over the last seconds; 0: what it shows now."""
        return mean_of(self._last(name, seconds)[1])

    def rate(self, name: str, seconds: float) -> float:
        """Return how fast a gauge moves [1/s], by the two halves of the last seconds."""
        times, values = self._last(name, max(seconds, RATE_PERIOD_S))
        half = len(times) // 2
        if not half:
            return 0.0
        run = mean_of(values[:half]) - mean_of(values[-half:])
        return run / (mean_of(times[:half]) - mean_of(times[-half:]))

    def over(self, name: str, seconds: float, readings: Numbers, *, rate: bool) -> Numbers:
        """Return ``mean``, or ``rate``, at each of the ticks after the last look.

        ``readings`` (ticks, gauges) follow those seen. One call for many ticks finds where a
        condition first holds; sums are rounded otherwise than one by one.
        """
        step, gauge = self.boat.method.step, InstrumentReadings._fields.index(name)
        seconds = max(seconds, RATE_PERIOD_S) if rate else seconds
        most = math.floor(max(seconds - TIME_ROUNDING_S, 0.0) / step) + 1  # readings of a look
        before = [row[gauge] for _, row in self.seen[-most:]]
        sums = np.concatenate(([0.0], before, readings[:, gauge])).cumsum()
        ends = np.arange(len(before) + 1, sums.size)
        counts = np.minimum(ends, most)
        if not rate:
            return np.asarray((sums[ends] - sums[ends - counts]) / counts)
        half = np.maximum(counts // 2, 1)
        late, early = (
            sums[ends] - sums[ends - half],
            sums[ends - counts + half] - sums[ends - counts],
        )
        return np.asarray((late - early) / half / (np.maximum(counts - half, 1) * step))

    def _last(self, name: str, seconds: float) -> tuple[list[float], list[float]]:
        """Return times and values of the last seconds, the latest first."""
        begin = self._index(self.seen[-1][0] - seconds + TIME_ROUNDING_S)
        last = self.seen[min(begin, len(self.seen) - 1) :][::-1]
        gauge = InstrumentReadings._fields.index(name)
        return [time for time, _ in last], [readings[gauge] for _, readings in last]


def mean_of(values: list[float]) -> float:
    """Return the mean, to the bit that of ``numpy.mean`` in a third of its time."""
    return float(np.add.reduce(values)) / len(values)


@dataclass(frozen=True)
class TicksAhead:
    """The ticks since a crew's last look, as it could see them."""

    begun: int  # tick of the last look
    step: float  # [s]
    column: Callable[[str], Numbers]  # a field of the state at these ticks
    readings: Numbers  # [ticks, gauges]
    gauges: GaugeHistory  # up to the last look

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.readings)

    def looks(self, looked: float, every: float) -> range:
        """Return which of them a hand looks at that looked at a time [s]."""
        least = every - TIME_ROUNDING_S
        first = max(math.ceil((looked + least) / self.step) - self.begun - 1, 0)
        return range(first, len(self), max(math.ceil(least / self.step), 1))


def first_of(looks: range, may_order: NDArray[np.bool_], count: int) -> int:
    """Return after how many ticks comes the first look that may order something, or all."""
    first = int(may_order.argmax())
    return looks[first] + 1 if may_order[first] else count


@dataclass
class KnownOrder:
    """The order to the crew on one axis. A hand knows it some seconds after it came."""

    axis: str
    answer: float  # [s]
    value: float | None = None  # [SI] None: nothing is ordered
    stamp: float = 0.0  # of the order that was seen last, by its tick in the state
    since: float = 0.0  # [s] when it was seen

    def look(self, boat: Boat) -> None:
        """Take the order once it has stood for the answer time."""
        index = CREW_AXES.index(self.axis)
        stamp = boat.plain[STAMP_OFFSET + index]
        if stamp != self.stamp:
            self.stamp, self.since = stamp, boat.time
            self.since = min(self.since, (stamp - 1.0) * boat.method.step if stamp else math.inf)
        if boat.time - self.since >= self.answer - TIME_ROUNDING_S:
            self.value = boat.plain[ORDER_OFFSET + index] if stamp else None

    def next_change(self, boat: Boat) -> float:
        """Return the time [s] from which another order is known, while nobody orders."""
        index = CREW_AXES.index(self.axis)
        stands = boat.plain[ORDER_OFFSET + index] if boat.plain[STAMP_OFFSET + index] else None
        return math.inf if stands == self.value else self.since + self.answer


@dataclass
class PlanesHand:
    """The planesman looks every few seconds, and orders what is worth an order."""

    gauge: ClassVar[str] = GAUGES[DEPTH_GAUGE]  # that it steers by
    boat: Boat
    habits: Planesman  # gains and limits of the exercise file
    late: float = 0.0  # [s] slower than these
    looked: float = -math.inf  # [s]
    depth: KnownOrder = field(init=False)
    pitch: KnownOrder = field(init=False)
    stern: int = 0  # [deg] rise, as ordered last
    bow: int = 0

    def __post_init__(self) -> None:
        answer = self.habits.answer_s + self.late
        self.depth, self.pitch = KnownOrder("depth", answer), KnownOrder("pitch", answer)
        s, toward = self.boat.state, self.boat.toward
        self.stern = round(math.degrees(toward["stern"] * float(s.delta_s)))
        self.bow = round(math.degrees(toward["bow"] * float(s.delta_b)))

    def aboard(self, boat: Boat) -> "PlanesHand":
        """Return this hand with all it knows, at the planes of another boat."""
        hand = copy(self)
        hand.boat, hand.depth, hand.pitch = boat, replace(self.depth), replace(self.pitch)
        return hand

    def find_ordered(self) -> None:
        """Take what anybody ordered last as one's own: a hand goes on from there."""
        s, toward = self.boat.state, self.boat.toward
        self.stern = round(math.degrees(toward["stern"] * _ordered(s, "stern", "s")))
        self.bow = round(math.degrees(toward["bow"] * _ordered(s, "bow", "b")))

    def look(self, gauges: GaugeHistory) -> list[str]:
        """Return what is ordered at this tick."""
        self.depth.look(self.boat)
        self.pitch.look(self.boat)
        if self.boat.time - self.looked < self.habits.look_s - TIME_ROUNDING_S:
            return []
        self.looked = self.boat.time
        aim = self.depth.value
        aim = self.boat.plain[STATE_OFFSETS["ordered_depth"]] if aim is None else aim
        deeper = aim - gauges.mean("depth", self.habits.mean_s)
        rate = gauges.rate("depth", self.habits.mean_s)
        return [*self._stern(deeper, rate), *self._bow(deeper, rate)]

    def next_change(self) -> float:
        """Return the time [s] from which it knows another order, while nobody orders."""
        return min(each.next_change(self.boat) for each in (self.depth, self.pitch))

    def first_order(self, ahead: TicksAhead) -> int:
        """Return after how many ticks it may order something, or all of them; ``look`` decides."""
        habits, looks = self.habits, ahead.looks(self.looked, self.habits.look_s)
        if not looks:
            return len(ahead)
        at, gauges = slice(looks.start, None, looks.step), ahead.gauges
        mean, rate = (
            gauges.over("depth", habits.mean_s, ahead.readings, rate=rate)[at]
            for rate in (False, True)
        )
        aim = ahead.column("ordered_depth")[at] if self.depth.value is None else self.depth.value
        deeper = aim - mean
        theta, q = (np.degrees(ahead.column(name)[at]) for name in ("theta", "q"))
        up = self._up(deeper, rate)
        bubble, far = bounded(up, habits.bubble_deg_max), np.abs(deeper)
        may = np.abs(far - habits.bow_within_m) < ORDER_SLACK
        if (ordered := self.pitch.value) is not None:
            away = (far > habits.leave_m) & (ordered * deeper < 0.0)
            bubble = np.where(away, math.degrees(ordered), bubble)
            may |= (np.abs(far - habits.leave_m) < ORDER_SLACK) | (far < ORDER_SLACK)
        rise = self._stern_rise(bubble - theta, q)
        may |= may_turn(rise, habits.stern_deg_max, self.stern, habits.stern_off_deg)
        rise = bounded(self._bow_rise(deeper, rate), habits.bow_deg_max)
        within = far <= habits.bow_within_m
        for slack in (-ORDER_SLACK, ORDER_SLACK):
            steps = np.trunc(habits.bow_step_deg * np.rint((rise + slack) / habits.bow_step_deg))
            wanted = np.where(within, steps, 0.0)
            near = np.abs(rise + slack - self.bow) < 0.6 * habits.bow_step_deg
            may |= (wanted != self.bow) & ~(near & (wanted != 0.0))
        return first_of(looks, may, len(ahead))

    # The laws of one look and of many at once, numbers or arrays: numpy alone would take four times
    # as long for one look.

    def _up(self, deeper: Any, rate: Any) -> Any:
        """Return the pitch [deg] that leads to the depth."""
        return self.habits.bubble_s * rate - self.habits.bubble_deg_per_m * deeper

    def _stern_rise(self, error: Any, turn: Any) -> Any:
        """Return how far stern planes are to rise [deg], by the error and rate of pitch."""
        return self.habits.stern_per_bubble * error - self.habits.stern_s * turn

    def _bow_rise(self, deeper: Any, rate: Any) -> Any:
        """Return how far bow planes are to rise [deg]."""
        return self.habits.bow_s * rate - self.habits.bow_deg_per_m * deeper

    def _bubble(self, deeper: float, rate: float) -> float:
        """Return the pitch [deg] to aim at, bow up: the bubble of the inclinometer.

        An ordered pitch counts while the boat is far from its depth, and leads towards it.
        ``deeper`` [m] is how far the boat is to go down, ``rate`` [m/s] how fast it goes.
        """
        habits, ordered = self.habits, self.pitch.value
        if ordered is not None and abs(deeper) > habits.leave_m and ordered * deeper < 0.0:
            return math.degrees(ordered)
        up: float = self._up(deeper, rate)
        return min(max(up, -habits.bubble_deg_max), habits.bubble_deg_max)

    def _stern(self, deeper: float, rate: float) -> list[str]:
        habits, (theta, q) = self.habits, self.boat.numbers(("theta", "q"))
        error = self._bubble(deeper, rate) - math.degrees(theta)
        rise = self._stern_rise(error, math.degrees(q))
        wanted = round(min(max(rise, -habits.stern_deg_max), habits.stern_deg_max))
        if abs(wanted - self.stern) < habits.stern_off_deg:
            return []
        self.stern = wanted
        return [_tilt("stern", wanted)]

    def _bow(self, deeper: float, rate: float) -> list[str]:
        habits = self.habits
        rise = self._bow_rise(deeper, rate)
        rise = min(max(rise, -habits.bow_deg_max), habits.bow_deg_max)
        within = abs(deeper) <= habits.bow_within_m
        wanted = int(habits.bow_step_deg * round(rise / habits.bow_step_deg)) if within else 0
        if wanted == self.bow or (abs(rise - self.bow) < 0.6 * habits.bow_step_deg and wanted):
            return []
        self.bow = wanted
        return [_tilt("bow", wanted)]


@dataclass
class RudderHand:
    """The helmsman looks every few seconds, meets the swing and steadies."""

    gauge: ClassVar[str] = GAUGES[GYRO]  # that it steers by
    boat: Boat
    habits: Helmsman  # gains and limits of the exercise file
    late: float = 0.0  # [s] slower than these
    looked: float = -math.inf  # [s]
    course: KnownOrder = field(init=False)
    rudder: int = 0  # [deg] right, as ordered last

    def __post_init__(self) -> None:
        self.course = KnownOrder("course", self.habits.answer_s + self.late)
        s = self.boat.state
        self.rudder = round(math.degrees(self.boat.toward["rudder"] * float(s.delta_r)))

    def aboard(self, boat: Boat) -> "RudderHand":
        """Return this hand with all it knows, at the rudder of another boat."""
        hand = copy(self)
        hand.boat, hand.course = boat, replace(self.course)
        return hand

    def find_ordered(self) -> None:
        """Take what anybody ordered last as one's own: a hand goes on from there."""
        ordered = _ordered(self.boat.state, "rudder", "r")
        self.rudder = round(math.degrees(self.boat.toward["rudder"] * ordered))

    def look(self, gauges: GaugeHistory) -> list[str]:
        """Return what is ordered at this tick."""
        self.course.look(self.boat)
        if self.boat.time - self.looked < self.habits.look_s - TIME_ROUNDING_S:
            return []
        self.looked = self.boat.time
        error = self._to_go(gauges.now().heading)
        rate = math.degrees(self.boat.plain[STATE_OFFSETS["r"]])
        wanted = self._turn(error, rate)
        wanted = round(min(max(wanted, -self.habits.rudder_deg_max), self.habits.rudder_deg_max))
        if abs(wanted - self.rudder) < self.habits.rudder_off_deg:
            return []
        self.rudder = wanted
        if not wanted:
            return ["rudder amidships"]
        return [f"rudder {'right' if wanted > 0 else 'left'} {abs(wanted)}"]

    def next_change(self) -> float:
        """Return the time [s] from which it knows another order, while nobody orders."""
        return self.course.next_change(self.boat)

    def first_order(self, ahead: TicksAhead) -> int:
        """Return after how many ticks it may order something, or all of them; ``look`` decides."""
        habits, looks = self.habits, ahead.looks(self.looked, self.habits.look_s)
        if not looks:
            return len(ahead)
        at = slice(looks.start, None, looks.step)
        heading = ahead.readings[at, InstrumentReadings._fields.index("heading")]
        may = np.zeros(heading.size, np.bool_)
        if self.course.value is None:
            error = ahead.column("ordered_psi")[at] - heading
            error = np.degrees(error - math.tau * np.rint(error / math.tau))
            may |= np.abs(np.abs(error) - 180.0) < ORDER_SLACK
        else:
            error = np.degrees(self.course.value - heading)
        turn = self._turn(error, np.degrees(ahead.column("r")[at]))
        may |= may_turn(turn, habits.rudder_deg_max, self.rudder, habits.rudder_off_deg)
        return first_of(looks, may, len(ahead))

    def _turn(self, error: Any, rate: Any) -> Any:
        """Return the rudder [deg] for an error of course and a rate of turn, numbers or arrays."""
        return self.habits.rudder_per_error * error - self.habits.rudder_s * rate

    def _to_go(self, heading: float) -> float:
        """Return how far there is to turn [deg], right positive, the way that was ordered."""
        if self.course.value is None:
            aim = float(self.boat.state.ordered_psi)
            return math.degrees(math.remainder(aim - heading, math.tau))
        return math.degrees(self.course.value - heading)


def bounded(values: Numbers, most: float) -> Numbers:
    """Return values of that size at most, sooner than ``numpy.clip`` does."""
    return np.minimum(np.maximum(values, -most), most)


def may_turn(wanted: Numbers, most: float, stands: int, off: float) -> NDArray[np.bool_]:
    """Return where whole degrees, ``most`` at most, may be ``off`` or more from what stands."""
    wanted = bounded(wanted, most)
    above = np.rint(wanted + ORDER_SLACK) - stands >= off
    result: NDArray[np.bool_] = above | (stands - np.rint(wanted - ORDER_SLACK) >= off)
    return result


def _ordered(state: Record, surface: str, letter: str) -> float:
    """Return the angle [rad] that a surface is ordered to by hand; else the one that it has."""
    by_hand = state[f"{surface}_by_hand"] != 0.0
    return float(state[f"ordered_{letter}" if by_hand else f"delta_{letter}"])


def _tilt(planes: str, rise: int) -> str:
    """Return the order that puts planes to an angle [deg], rise positive."""
    if not rise:
        return f"{planes} planes zero"
    return f"{planes} planes {'rise' if rise > 0 else 'dive'} {abs(rise)}"

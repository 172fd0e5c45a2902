"""The hands of a reference crew work planes and rudder by what the crew sees."""

import math
from collections import deque
from copy import copy
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.casualties import InstrumentReadings, instrument_readings
from trainer.boat.crew_orders import CREW_AXES
from trainer.config.reference_crew import Helmsman, Planesman
from trainer.core.kernel import Record

GAUGE_MEMORY_S: Final = 601.0  # [s] of gauges that are remembered: mean_s of a rule is 600 at most
RATE_PERIOD_S: Final = 2.0  # [s] over which a rate is seen on a gauge
TIME_ROUNDING_S: Final = 1e-6  # [s] rounding of a sum of steps


@dataclass
class GaugeHistory:
    """The readings of the gauges over some minutes."""

    boat: Boat
    seen: deque[tuple[float, InstrumentReadings]] = field(default_factory=deque)

    def look(self) -> None:
        """Read the gauges at this tick."""
        self.seen.append((self.boat.time, instrument_readings(self.boat)))
        while self.seen[-1][0] - self.seen[0][0] > GAUGE_MEMORY_S:
            self.seen.popleft()

    def now(self) -> InstrumentReadings:
        """Return the readings of the last look."""
        return self.seen[-1][1]

    def mean(self, name: str, seconds: float) -> float:
        """Return the mean of a gauge over the last seconds; 0: what it shows now."""
        return float(np.mean(self._last(name, seconds)[1]))

    def rate(self, name: str, seconds: float) -> float:
        """Return how fast a gauge moves [1/s], by the two halves of the last seconds."""
        times, values = self._last(name, max(seconds, RATE_PERIOD_S))
        half = len(times) // 2
        if not half:
            return 0.0
        run = np.mean(values[:half]) - np.mean(values[-half:])
        return float(run / (np.mean(times[:half]) - np.mean(times[-half:])))

    def _last(self, name: str, seconds: float) -> tuple[list[float], list[float]]:
        """Return times and values of the last seconds, the latest first."""
        begin = self.seen[-1][0] - seconds + TIME_ROUNDING_S
        times, values = [self.seen[-1][0]], [getattr(self.seen[-1][1], name)]
        for i in range(len(self.seen) - 2, -1, -1):
            if self.seen[i][0] < begin:
                break
            times.append(self.seen[i][0])
            values.append(getattr(self.seen[i][1], name))
        return times, values


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
        s, place = boat.state, CREW_AXES.index(self.axis)
        stamp = float(s.crew_order_tick[place])
        if stamp != self.stamp:
            self.stamp, self.since = stamp, boat.time
            self.since = min(self.since, (stamp - 1.0) * boat.method.step if stamp else math.inf)
        if boat.time - self.since >= self.answer - TIME_ROUNDING_S:
            self.value = float(s.crew_order[place]) if stamp else None


@dataclass
class PlanesHand:
    """The planesman looks every few seconds, and orders what is worth an order."""

    boat: Boat
    ways: Planesman
    late: float = 0.0  # [s] beyond the ways
    looked: float = -math.inf  # [s]
    depth: KnownOrder = field(init=False)
    pitch: KnownOrder = field(init=False)
    stern: int = 0  # [deg] rise, as ordered last
    bow: int = 0

    def __post_init__(self) -> None:
        answer = self.ways.answer_s + self.late
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
        if self.boat.time - self.looked < self.ways.look_s - TIME_ROUNDING_S:
            return []
        self.looked = self.boat.time
        aim = self.depth.value
        aim = float(self.boat.state.ordered_depth) if aim is None else aim
        deeper = aim - gauges.mean("depth", self.ways.mean_s)
        rate = gauges.rate("depth", self.ways.mean_s)
        return [*self._stern(deeper, rate), *self._bow(deeper, rate)]

    def _bubble(self, deeper: float, rate: float) -> float:
        """Return the pitch [deg] to aim at, bow up."""
        ways, ordered = self.ways, self.pitch.value
        if ordered is not None and abs(deeper) > ways.leave_m and ordered * deeper < 0.0:
            return math.degrees(ordered)
        up = ways.bubble_s * rate - ways.bubble_deg_per_m * deeper
        return min(max(up, -ways.bubble_deg_max), ways.bubble_deg_max)

    def _stern(self, deeper: float, rate: float) -> list[str]:
        ways, s = self.ways, self.boat.state
        error = self._bubble(deeper, rate) - math.degrees(s.theta)
        rise = ways.stern_per_bubble * error - ways.stern_s * math.degrees(s.q)
        wanted = round(min(max(rise, -ways.stern_deg_max), ways.stern_deg_max))
        if abs(wanted - self.stern) < ways.stern_off_deg:
            return []
        self.stern = wanted
        return [_tilt("stern", wanted)]

    def _bow(self, deeper: float, rate: float) -> list[str]:
        ways = self.ways
        rise = ways.bow_s * rate - ways.bow_deg_per_m * deeper
        rise = min(max(rise, -ways.bow_deg_max), ways.bow_deg_max)
        within = abs(deeper) <= ways.bow_within_m
        wanted = int(ways.bow_step_deg * round(rise / ways.bow_step_deg)) if within else 0
        if wanted == self.bow or (abs(rise - self.bow) < 0.6 * ways.bow_step_deg and wanted):
            return []
        self.bow = wanted
        return [_tilt("bow", wanted)]


@dataclass
class RudderHand:
    """The helmsman looks every few seconds, meets the swing and steadies."""

    boat: Boat
    ways: Helmsman
    late: float = 0.0  # [s] beyond the ways
    looked: float = -math.inf  # [s]
    course: KnownOrder = field(init=False)
    rudder: int = 0  # [deg] right, as ordered last

    def __post_init__(self) -> None:
        self.course = KnownOrder("course", self.ways.answer_s + self.late)
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
        if self.boat.time - self.looked < self.ways.look_s - TIME_ROUNDING_S:
            return []
        self.looked = self.boat.time
        error = self._to_go(gauges.now().heading)
        rate = math.degrees(float(self.boat.state.r))
        wanted = self.ways.rudder_per_error * error - self.ways.rudder_s * rate
        wanted = round(min(max(wanted, -self.ways.rudder_deg_max), self.ways.rudder_deg_max))
        if abs(wanted - self.rudder) < self.ways.rudder_off_deg:
            return []
        self.rudder = wanted
        if not wanted:
            return ["rudder amidships"]
        return [f"rudder {'right' if wanted > 0 else 'left'} {abs(wanted)}"]

    def _to_go(self, heading: float) -> float:
        """Return how far there is to turn [deg], right positive, the way that was ordered."""
        if self.course.value is None:
            aim = float(self.boat.state.ordered_psi)
            return math.degrees(math.remainder(aim - heading, math.tau))
        return math.degrees(self.course.value - heading)


def _ordered(state: Record, surface: str, letter: str) -> float:
    """Return the angle [rad] that a surface is ordered to by hand; else the one that it has."""
    by_hand = state[f"{surface}_by_hand"] != 0.0
    return float(state[f"ordered_{letter}" if by_hand else f"delta_{letter}"])


def _tilt(planes: str, rise: int) -> str:
    """Return the order that puts planes to an angle [deg], rise positive."""
    if not rise:
        return f"{planes} planes zero"
    return f"{planes} planes {'rise' if rise > 0 else 'dive'} {abs(rise)}"

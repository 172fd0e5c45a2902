"""How steadily a vehicle turns: pull-out, direct spiral and reverse spiral.

``catalogue`` offers them. They show whether a boat is stable on its course. After a pull-out a
stable boat stops turning. In a direct spiral (Dieudonne) the rudder is stepped through its angles,
and an unstable boat jumps from one branch of the curve to the other; a reverse spiral (Bech) finds
the part between.
"""

import math
from bisect import bisect_left
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from trainer.analysis.manoeuvres.flight import Conn, Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import (
    DIRECTION_SIGNS,
    PORT,
    STARBOARD,
    Measure,
    Side,
    part_measure,
    share_measure,
    show_only,
)

RUDDER_PARTS: Final = (1.0, 2 / 3, 1 / 3, 1 / 6, 0.0, -1 / 6, -1 / 3, -2 / 3, -1.0)
MIN_PART_LENGTHS: Final = 3.0  # [lengths run] of each part, before it can count as steady
MAX_PART_LENGTHS: Final = 40.0  # [lengths run] of a part that does not become steady
LOOK_BACK_LENGTHS: Final = 2.0  # [lengths run] over which a steady yaw rate hardly changes
# [-] of the yaw rate seen so far, by which it may change in LOOK_BACK_LENGTHS
STEADY_RATE_CHANGE: Final = 2e-3
MIN_SWIRL: Final = 1e-3  # [-] yaw rate times length over speed that counts as no turn
FIRST_MARK: Final = "largest"  # mark of the turn that finds the largest yaw rate
SPIRAL_WAYS: Final = ("down", "up")  # of a direct spiral: from one side to the other, and back
HELM_GAIN: Final = 1.0  # [rad] of rudder per error of r L/U
HELM_INTEGRAL_GAIN: Final = 0.5  # [rad] the same, per length run


def swirl(conn: Conn) -> float:
    """Return the yaw rate r L/U [-]."""
    speed = max(math.hypot(conn.value("u"), conn.value("v")), 1e-6)
    return conn.value("r") * conn.vehicle.length / speed


def settle_turn(conn: Conn, seen: list[float]) -> Generator[None, None, bool]:
    """Advance until the turn is steady. Return whether it became steady.

    ``seen`` holds the largest yaw rate of the manoeuvre so far. It is a list of one number, because
    it is updated here and goes on to the next turn.
    """
    run, rates, runs = 0.0, [swirl(conn)], [0.0]
    while run < MAX_PART_LENGTHS:
        yield
        run += (
            math.hypot(conn.value("u"), conn.value("v")) * conn.vehicle.step / conn.vehicle.length
        )
        rates.append(swirl(conn))
        runs.append(run)
        seen[0] = max(seen[0], abs(rates[-1]))
        recent = rates[bisect_left(runs, run - LOOK_BACK_LENGTHS) :]
        if run > MIN_PART_LENGTHS and max(recent) - min(recent) <= STEADY_RATE_CHANGE * max(
            seen[0], MIN_SWIRL
        ):
            return True
    return False


@dataclass(frozen=True)
class PullOut(Manoeuvre):
    """A steady turn to either side, and the rudder put amidships: what turning is left.

    Yaw rates count to the side of the first turn.
    """

    needs: ClassVar[tuple[str, ...]] = ("rudder",)
    shows: ClassVar[tuple[str, ...]] = ("r", "delta_r")

    angle_deg: float = 20.0  # rudder
    side: Side = STARBOARD  # of the first turn

    @property
    def sides(self) -> tuple[Side, Side]:
        """Return the sides in the order they are turned to."""
        return (STARBOARD, PORT) if self.side == STARBOARD else (PORT, STARBOARD)

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of both turns."""
        conn.vehicle.keep("depth")
        most = [0.0]
        for side in self.sides:
            conn.order("rudder", DIRECTION_SIGNS[side] * math.radians(self.angle_deg))
            yield from settle_turn(conn, most)
            conn.mark("amidships")
            conn.order("rudder", 0.0)
            yield from settle_turn(conn, most)
            conn.mark("left")

    def measures(self, flight: Flight) -> list[Measure]:
        """Return the yaw rate in the turn and its remainder, to either side."""
        flight = flight.counted_to(self.side)
        turned = [mark.t for mark in flight.marks if mark.name == "amidships"]
        left_times = [mark.t for mark in flight.marks if mark.name == "left"]
        measures = []
        for side, *times in zip(self.sides, turned, left_times, strict=False):
            rates = [flight.at(time, "r") for time in times]
            measures.append(share_measure(f"yaw rate, rudder to {side}", "rad/s", rates[0]))
            measures.append(show_only(f"yaw rate left after {side}", "rad/s", rates[1]))
        return measures


@dataclass(frozen=True)
class Spiral(Manoeuvre):
    """The direct spiral. The rudder goes from side to side and back in steps, each until steady.

    Rudder and yaw rates count to the side that it begins with.
    """

    needs: ClassVar[tuple[str, ...]] = ("rudder",)
    shows: ClassVar[tuple[str, ...]] = ("turns", "r", "delta_r")

    angle_deg: float = 15.0  # rudder, the largest
    side: Side = STARBOARD  # at first

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of all steps."""
        conn.vehicle.keep("depth")
        most = [0.0]
        for way, parts in zip(SPIRAL_WAYS, (RUDDER_PARTS, RUDDER_PARTS[::-1]), strict=True):
            for share_of_it in parts:
                angle = share_of_it * self.angle_deg
                conn.order("rudder", self.sign * math.radians(angle))
                yield from settle_turn(conn, most)
                conn.mark(f"{way} {angle:+.3g}")

    def measures(self, flight: Flight) -> list[Measure]:
        """Return yaw rate by rudder, and how far the two ways lie apart."""
        flight = flight.counted_to(self.side)
        rates: dict[str, dict[str, float]] = {way: {} for way in SPIRAL_WAYS}
        for mark in flight.marks:
            way, angle = mark.name.split()
            rates[way][angle] = flight.at(mark.t, "r") or 0.0
        most = max((abs(rate) for rate in rates["down"].values()), default=0.0)
        measures = [
            part_measure(f"yaw rate at {angle} deg", "rad/s", rate, most)
            for angle, rate in rates["down"].items()
        ]
        gaps = [abs(rate - rates["up"].get(angle, rate)) for angle, rate in rates["down"].items()]
        return [*measures, show_only("width of the loop", "rad/s", max(gaps) if gaps else None)]


@dataclass(frozen=True)
class ReverseSpiral(Manoeuvre):
    """Bech's reverse spiral: the rudder that holds each of a series of yaw rates."""

    needs: ClassVar[tuple[str, ...]] = ("rudder",)
    shows: ClassVar[tuple[str, ...]] = ("turns", "r", "delta_r")

    angle_deg: float = 15.0  # rudder that finds the largest yaw rate
    side: Side = STARBOARD  # at first

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of a turn that finds the largest rate, then each rate held."""
        conn.vehicle.keep("depth")
        most = [0.0]
        conn.order("rudder", self.sign * math.radians(self.angle_deg))
        yield from settle_turn(conn, most)
        largest = swirl(conn)
        conn.mark(FIRST_MARK)
        for wanted in RUDDER_PARTS[1:-1]:
            yield from self._held(conn, wanted * largest)
            conn.mark(f"{100.0 * wanted:.0f} %")

    def _held(self, conn: Conn, wanted: float) -> Iterator[None]:
        """Yield the cycles in which the rudder brings r L/U to ``wanted`` and keeps it."""
        low, high = conn.vehicle.controls["rudder"]
        integral = conn.ordered["rudder"]
        for _ in settle_turn(conn, [abs(wanted)]):
            error = wanted - swirl(conn)
            order = integral + HELM_GAIN * error
            if low < order < high:
                speed = math.hypot(conn.value("u"), conn.value("v"))
                integral += (
                    HELM_INTEGRAL_GAIN * error * speed * conn.vehicle.step / conn.vehicle.length
                )
            conn.order("rudder", min(max(order, low), high))
            yield

    def measures(self, flight: Flight) -> list[Measure]:
        """Return the rudder of each yaw rate, positive to the side it begins with."""
        flight = flight.counted_to(self.side)
        if not flight.has("delta_r") or not flight.marks:
            return []
        measures = []
        rudder = math.copysign(1.0, flight.at(flight.marks[0].t, "delta_r") or 0.0) * flight.change(
            "delta_r"
        )
        for mark in flight.marks[1:]:
            measures.append(show_only(f"yaw rate at {mark.name}", "rad/s", flight.at(mark.t, "r")))
            angle = float(np.interp(mark.t, flight.t, rudder))
            measures.append(
                part_measure(f"rudder at {mark.name}", "rad", angle, math.radians(self.angle_deg))
            )
        return measures

"""Changes of speed: in steps, to the utmost, and back to nothing.

They are manoeuvres of the ``catalogue``. ``trainer boat manoeuvre`` and reductions fly them,
because they show thrust and drag at all ratios of speed and command.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Final

from trainer.analysis.manoeuvres.flight import Conn, Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import (
    Measure,
    Watch,
    first_time,
    largest_value,
    part_measure,
    share_measure,
    show_only,
)
from trainer.units import KNOT

ENGINE_STEP_M_S: Final = 5.0 * KNOT  # [m/s] the steps of 1969
MIN_ENGINE_STEPS: Final = 3.0  # [-] of a vehicle too slow for three steps of 1969
STEP_ROUNDING: Final = 1e-9  # [-] a quotient this much above a whole number is that number
READING_SHARES: Final = (0.1, 0.25, 0.5, 0.6, 0.8, 1.0)  # of the duration
EXTRA_STOP_SHARE = 0.1  # [-] of the time to stop, flown on after it


def ahead_speed(conn: Conn, knots: float | None) -> float:
    """Return an ordered speed [m/s]; None [kn]: full ahead."""
    return conn.vehicle.controls["engine"].high if knots is None else knots * KNOT


def depth_change(flight: Flight) -> list[Measure]:
    """Return how far the depth went, of a vehicle that has one."""
    if not flight.has("z"):
        return []
    return [show_only("largest depth change", "m", largest_value(flight.change("z")))]


@dataclass(frozen=True)
class Acceleration(Manoeuvre):
    """The engine goes up from rest in equal steps, and down in as many."""

    needs: ClassVar[tuple[str, ...]] = ("engine",)
    compared: ClassVar[tuple[str, ...]] = ("u",)
    shows: ClassVar[tuple[str, ...]] = ("u", "z", "theta", "q", "delta_s", "delta_b")

    each_s: float = 230.0
    from_rest: ClassVar[bool] = True
    step_kn: float | None = None  # at most; None: 5 kn, or a third of the last where that is less
    ahead_kn: float | None = None  # the last; None: full ahead

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the steps up and down."""
        conn.vehicle.keep("depth")
        most = ahead_speed(conn, self.ahead_kn)
        step = (
            min(ENGINE_STEP_M_S, most / MIN_ENGINE_STEPS)
            if self.step_kn is None
            else self.step_kn * KNOT
        )
        # equal steps: the last order is then exactly the speed asked for
        steps = math.ceil(most / step - STEP_ROUNDING)
        for i in [*range(1, steps + 1), *range(steps - 1, -1, -1)]:
            conn.order("engine", most * i / steps)
            conn.mark("step")
            yield from conn.hold(self.each_s)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return the speed at the end of each step."""
        ends = [*(mark.t for mark in flight.marks[1:]), float(flight.t[-1])]
        top = float(flight.column("u").max())
        speeds = [flight.at(end, "u") for end in ends]
        return [
            part_measure(f"speed after step {i}", "m/s", u, top)
            for i, u in enumerate(speeds, start=1)
        ]


@dataclass(frozen=True)
class UtmostAcceleration(Manoeuvre):
    """From rest, ahead for half the time, then stop; depth kept where it can be."""

    needs: ClassVar[tuple[str, ...]] = ("engine",)
    compared: ClassVar[tuple[str, ...]] = ("u",)
    shows: ClassVar[tuple[str, ...]] = ("u", "z", "theta", "q", "delta_s", "delta_b")
    from_rest: ClassVar[bool] = True

    duration_s: float = 1000.0
    ahead_kn: float | None = None  # None: full ahead
    ahead_s: float | None = None  # None: half the duration

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles ahead and stopped."""
        conn.vehicle.keep("depth")
        conn.order("engine", ahead_speed(conn, self.ahead_kn))
        conn.mark("ahead")
        until = 0.5 * self.duration_s if self.ahead_s is None else self.ahead_s
        yield from conn.hold_to(min(until, self.duration_s))
        conn.order("engine", 0.0)
        conn.mark("stop")
        yield from conn.hold_to(self.duration_s)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return speeds on the way, and how far the depth went."""
        top = float(flight.column("u").max())
        times = [part * self.duration_s for part in READING_SHARES]
        measures = [
            part_measure(f"speed after {time:g} s", "m/s", flight.at(time, "u"), top)
            for time in times
        ]
        return measures + depth_change(flight)


@dataclass(frozen=True)
class CrashStop(Manoeuvre):
    """Full astern from steady speed until the way is off."""

    needs: ClassVar[tuple[str, ...]] = ("engine",)
    shows: ClassVar[tuple[str, ...]] = ("u", "x")

    duration_s: float = 600.0

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles until the vehicle stands."""
        conn.vehicle.keep("depth")
        conn.order("engine", conn.vehicle.controls["engine"].low)
        conn.mark("astern")
        yield from conn.until(Watch("u", 0.0, -1.0), self.duration_s)
        # a boat flown beside this one may stop later: its stop must be within the flight
        yield from conn.hold(EXTRA_STOP_SHARE * conn.time)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return time, head reach, side reach and change of heading."""
        stopped = first_time(flight.t, flight.column("u"), 0.0)
        ahead = None if stopped is None else flight.at(stopped, "x")
        aside = None if stopped is None else flight.at(stopped, "y")
        return [
            share_measure("time to stop", "s", stopped),
            share_measure("head reach", "m", ahead),
            share_measure(
                "head reach, in lengths", "-", None if ahead is None else ahead / flight.length
            ),
            show_only("side reach", "m", aside),
            show_only("change of heading", "rad", float(flight.change("psi")[-1])),
        ]


@dataclass(frozen=True)
class Backing(Manoeuvre):
    """From rest, full astern and held; planes and rudder amidships."""

    needs: ClassVar[tuple[str, ...]] = ("engine",)
    shows: ClassVar[tuple[str, ...]] = ("u", "z", "theta", "psi")
    from_rest: ClassVar[bool] = True

    duration_s: float = 300.0

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles astern."""
        conn.order("engine", conn.vehicle.controls["engine"].low)
        conn.mark("astern")
        yield from conn.hold_to(self.duration_s)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return speeds and the way made astern. Where the boat then goes by itself is shown."""
        fastest, furthest = largest_value(flight.column("u")), largest_value(flight.change("x"))
        measures = []
        for reading in READING_SHARES:
            time = reading * self.duration_s
            speed, way = flight.at(time, "u"), flight.at(time, "x")
            measures.append(part_measure(f"speed after {time:g} s", "m/s", speed, fastest))
            measures.append(part_measure(f"way after {time:g} s", "m", way, furthest))
        measures.append(show_only("change of heading", "rad", float(flight.change("psi")[-1])))
        return measures + depth_change(flight)

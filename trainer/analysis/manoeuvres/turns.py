"""Turns: the rudder is thrown over and held, and the path is measured.

Advance, transfer and tactical diameter are those of sea trials. ``steadiness`` has pull-out and
spirals. ``catalogue`` offers these manoeuvres; guides and ``trainer boat estimate`` fly them too.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from trainer.analysis.manoeuvres.flight import Conn, Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import (
    ALLOWED_PERCENT,
    DIRECTION_SIGNS,
    RISE,
    STARBOARD,
    Direction,
    Measure,
    Side,
    first_time,
    heel_measure,
    largest_value,
    part_measure,
    peaks_of,
    share_measure,
    show_only,
)

TURN_END_PARTS: Final = 10  # a tenth of the turn is its end,
# [-] of the last heel: it is steady that swings no more than this there
SETTLED_HEEL_RATIO: Final = 0.1
MIN_SNAP_RATIO: Final = 0.2  # [-] of the largest roll: a smaller first flick is none
LEVEL_DEPTH_LENGTHS: Final = 0.01  # [lengths] of depth, and ...
LEVEL_PLANES_RAD: Final = math.radians(0.25)  # ... of the planes: less is level flight; estimates
HEADING_READ_TIME_S: Final = 60.0  # [s] of rudder, when the heading is read


@dataclass(frozen=True)
class Turn(Manoeuvre):
    """Rudder over to a side and held; depth kept where it can be."""

    needs: ClassVar[tuple[str, ...]] = ("rudder",)
    compared: ClassVar[tuple[str, ...]] = ("u", "psi")
    shows: ClassVar[tuple[str, ...]] = ("track", "psi", "phi", "u", "z", "delta_s", "delta_r")

    angle_deg: float = 15.0  # rudder
    duration_s: float = 300.0
    keep: tuple[str, ...] = ("depth",)
    lead_s: float = 5.0  # of straight motion
    side: Side = STARBOARD

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the turn."""
        for quantity in self.keep:
            conn.vehicle.keep(quantity)
        yield from conn.hold(self.lead_s)
        conn.order("rudder", self.sign * math.radians(self.angle_deg))
        conn.mark("rudder")
        yield from conn.hold_to(self.duration_s)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return circle, times, speed, roll and depth; what is sideways counts to the side."""
        flight = flight.counted_to(self.side)
        return circle(flight) + steady(flight) + heel(flight) + depth(flight)


@dataclass(frozen=True)
class ClimbingTurn(Manoeuvre):
    """The rudder goes over and the planes move with it, and both are held."""

    needs: ClassVar[tuple[str, ...]] = ("rudder", "planes")
    compared: ClassVar[tuple[str, ...]] = ("u", "z", "psi")
    shows: ClassVar[tuple[str, ...]] = ("track", "z", "theta", "phi", "u")

    angle_deg: float = 15.0  # rudder
    planes_deg: float = 10.0
    duration_s: float = 300.0
    lead_s: float = 5.0
    side: Side = STARBOARD
    direction: Direction = RISE

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the turn."""
        yield from conn.hold(self.lead_s)
        conn.order("rudder", self.sign * math.radians(self.angle_deg))
        conn.order("planes", DIRECTION_SIGNS[self.direction] * math.radians(self.planes_deg))
        conn.mark("rudder")
        yield from conn.hold_to(self.duration_s)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return circle, speed, roll, pitch and climb.

        The turn may press the boat down while the planes lift it. The climb is then a small
        difference of large rates, and may differ by ALLOWED_PERCENT of the fastest climb or
        sinking.
        """
        flight = flight.counted_to(self.side)
        climbing = -np.diff(flight.column("z")) / np.diff(flight.t)
        climb = [
            share_measure("steady pitch", "rad", float(flight.column("theta")[-1])),
            part_measure("steady climb", "m/s", float(climbing[-1]), largest_value(climbing)),
        ]
        return circle(flight) + steady(flight) + climb + heel(flight) + depth(flight)


def circle(flight: Flight) -> list[Measure]:
    """Return advance, transfer, tactical diameter and the times to get there.

    The track is the origin's, from where it was when the rudder was ordered.
    """
    begin = flight.time_of("rudder") or 0.0
    turned = abs(flight.change("psi"))
    quarter, half = (first_time(flight.t, turned, angle) for angle in (math.pi / 2, math.pi))
    heading = flight.at(begin + HEADING_READ_TIME_S, "psi")
    change = None if heading is None else heading - float(flight.column("psi")[0])
    return [
        share_measure("advance", "m", _run_since(flight, "x", begin, quarter)),
        share_measure("transfer", "m", _run_since(flight, "y", begin, quarter)),
        share_measure("tactical diameter", "m", _run_since(flight, "y", begin, half)),
        share_measure("time to 90 degrees", "s", None if quarter is None else quarter - begin),
        share_measure("time to 180 degrees", "s", None if half is None else half - begin),
        share_measure("heading after 60 s", "rad", change),
    ]


def _run_since(flight: Flight, name: str, begin: float, end: float | None) -> float | None:
    """Return the change of x or y from ``begin`` to ``end`` [s]; None without an end."""
    first, last = flight.at(begin, name), None if end is None else flight.at(end, name)
    return None if first is None or last is None else abs(last - first)


def yaw_rate(flight: Flight) -> float:
    """Return the rate of the heading [rad/s] at the end, by exact kinematics."""
    r = float(flight.column("r")[-1])
    if not flight.has("theta"):
        return r
    q, phi, theta = (float(flight.column(name)[-1]) for name in ("q", "phi", "theta"))
    return (q * math.sin(phi) + r * math.cos(phi)) / math.cos(theta)


def steady(flight: Flight) -> list[Measure]:
    """Return diameter, speed and rates at the end."""
    u = float(flight.column("u")[-1])
    v = float(flight.column("v")[-1])
    yaw = yaw_rate(flight)
    diameter = 2.0 * math.hypot(u, v) / abs(yaw) if yaw else None
    return [
        share_measure("steady diameter", "m", diameter),
        share_measure("steady speed", "m/s", u),
        share_measure(
            "steady speed, of the first", "-", u / flight.speed if flight.speed else None
        ),
        share_measure("steady yaw rate", "rad/s", yaw),
        share_measure("steady drift angle", "rad", math.atan2(-v, u)),
    ]


def heel(flight: Flight) -> list[Measure]:
    """Return the snap roll, which is the first extreme, the largest and the last heel.

    The extremes are sought in what the turn adds to the heel of straight flight, and told with it,
    because a propeller's torque heels the boat in straight flight as well. The last heel is judged
    if it is steady: a roll that still swings has no last heel.
    """
    if not flight.has("phi"):
        return []
    begin = flight.time_of("rudder") or 0.0
    after = flight.since(begin)
    straight, rolls = float(flight.column("phi")[0]), flight.change("phi")[after]
    most = largest_value(rolls)
    tops = [y for _, y in peaks_of(flight.t[after], rolls) if abs(y) > MIN_SNAP_RATIO * abs(most)]
    steady_roll = straight + float(rolls[-1])
    swing = np.ptp(rolls[-max(len(rolls) // TURN_END_PARTS, 1) :])
    swings = swing > SETTLED_HEEL_RATIO * abs(rolls[-1])
    return [
        heel_measure("snap roll", straight + tops[0] if tops else None),
        heel_measure("largest roll", straight + most),
        show_only("steady roll", "rad", steady_roll)
        if swings
        else heel_measure("steady roll", steady_roll),
    ]


def depth(flight: Flight) -> list[Measure]:
    """Return how far depth went either way, and where planes and rudder were.

    Depth may differ by ALLOWED_PERCENT of its change or by LEVEL_DEPTH_LENGTHS lengths, the stern
    planes by ALLOWED_PERCENT of theirs or by LEVEL_PLANES_RAD. The fixed allowances are there
    because depth and planes hardly change where depth is kept.
    """
    if not flight.has("z"):
        return []
    changes = flight.change("z")
    most = largest_value(changes)
    room = max(abs(most), 100.0 / ALLOWED_PERCENT * LEVEL_DEPTH_LENGTHS * flight.length)
    measures = [
        part_measure("largest depth change", "m", most, room),
        part_measure("last depth change", "m", float(changes[-1]), room),
    ]
    for name, surface in (("delta_s", "stern planes"), ("delta_r", "rudder")):
        if flight.has(name):
            angles = flight.change(name)
            room = max(abs(largest_value(angles)), 100.0 / ALLOWED_PERCENT * LEVEL_PLANES_RAD)
            measures.append(
                part_measure(f"largest change, {surface}", "rad", largest_value(angles), room)
            )
            measures.append(part_measure(f"last change, {surface}", "rad", float(angles[-1]), room))
    return measures

"""Turns: the rudder thrown over and held, put amidships, or stepped through its angles.

Advance, transfer and tactical diameter are those of sea trials. Pull-out and spirals show whether a
boat is stable on its course: after a pull-out a stable boat stops turning. In a direct spiral
(Dieudonne) the rudder is stepped through its angles, and an unstable boat jumps from one branch of
the curve to the other; a reverse spiral (Bech) finds the part between. ``catalogue`` offers these
manoeuvres; guides and ``trainer boat estimate`` fly them too.
"""

import math
from bisect import bisect_left
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from trainer.analysis.manoeuvres.flight import Conn, Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import (
    ALLOWED_PERCENT,
    DIRECTION_SIGNS,
    PORT,
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

    The track is the origin's, from where it was when the rudder was ordered, along and across the
    heading of then.
    """
    flight, begin = flight.along("rudder"), flight.time_of("rudder") or 0.0
    course = flight.at(begin, "psi") or 0.0
    turned = abs(flight.column("psi") - course)
    quarter, half = (first_time(flight.t, turned, angle) for angle in (math.pi / 2, math.pi))
    heading = flight.at(begin + HEADING_READ_TIME_S, "psi")
    change = None if heading is None else heading - course
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
        share_measure("steady speed", "m/s", flight.last_speed),
        share_measure("steady speed, of the first", "-", flight.speed_left),
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

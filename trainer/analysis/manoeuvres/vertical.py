"""Manoeuvres in the vertical plane: small disturbances, the meander and the overshoot of 1969.

They show whether a boat with fixed planes returns to its depth and pitch (meander), and how far it
goes on after planes are reversed (overshoot). The ``catalogue`` offers them.
"""

import math
from collections.abc import Generator, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, Final

from trainer.analysis.manoeuvres.flight import LEAD_TIME_S, TIME_ROUNDING_S, Conn, Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import (
    DIVE,
    RISE,
    STARBOARD,
    Direction,
    Measure,
    Side,
    Watch,
    largest_value,
    peaks_of,
    share_measure,
    show_only,
    swing_measures,
    zero_crossings,
)

SHOWN_CYCLES: Final = 5  # of a decay that are reported


@dataclass(frozen=True)
class TrimChange(Manoeuvre):
    """The longitudinal trim of 1969: planes offset, to dive in 1969, and held."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)
    compared: ClassVar[tuple[str, ...]] = ("u", "z", "theta", "w")
    shows: ClassVar[tuple[str, ...]] = ("theta", "z", "u", "w")

    angle_deg: float = 3.0  # planes
    duration_s: float = 240.0
    lead_s: float = LEAD_TIME_S
    direction: Direction = DIVE

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the offset."""
        yield from conn.hold(self.lead_s)
        conn.order("planes", self.sign * math.radians(self.angle_deg))
        conn.mark("planes")
        yield from conn.hold_to(self.duration_s)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return how much of everything the offset changes by its end."""
        return [
            show_only("last change of speed", "m/s", float(flight.change("u")[-1])),
            show_only("last change of pitch", "rad", float(flight.change("theta")[-1])),
            show_only("last change of depth", "m", float(flight.change("z")[-1])),
            show_only("last change of w", "m/s", float(flight.change("w")[-1])),
            show_only("largest pitch rate", "rad/s", largest_value(flight.column("q"))),
        ]


@dataclass(frozen=True)
class Pulse(Manoeuvre):
    """A short pulse of one control, and the swings that follow."""

    control: ClassVar[str]
    column: ClassVar[str]
    called: ClassVar[str]

    angle_deg: float = 5.0  # control
    pulse_lengths: float = 0.5  # run while it lasts
    duration_s: float = 200.0

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of pulse and response."""
        yield from conn.hold(LEAD_TIME_S)
        conn.order(self.control, self.sign * math.radians(self.angle_deg))
        conn.mark("pulse")
        yield from conn.hold(self.pulse_lengths * conn.vehicle.length / conn.value("u"))
        conn.order(self.control, 0.0)
        conn.mark("neutral")
        yield from conn.hold_to(self.duration_s)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return the response's size and the swings it makes, counted to the side."""
        flight = flight.counted_to(getattr(self, "side", STARBOARD))
        after = flight.since(flight.time_of("neutral") or 0.0)
        response = flight.change(self.column)
        measures = [share_measure(f"largest {self.called}", "rad", largest_value(response))]
        period, ratio = swing(peaks_of(flight.t[after], response[after]))
        return [
            *measures,
            show_only("period of its swing", "s", period),
            show_only("damping ratio of its swing", "-", ratio),
        ]


@dataclass(frozen=True)
class Impulse(Pulse):
    """A short pulse of the planes, and the modes that the pitch then shows."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)
    compared: ClassVar[tuple[str, ...]] = ("theta",)
    shows: ClassVar[tuple[str, ...]] = ("theta", "q")
    control: ClassVar[str] = "planes"
    column: ClassVar[str] = "theta"
    called: ClassVar[str] = "pitch"

    direction: Direction = RISE


@dataclass(frozen=True)
class RudderImpulse(Pulse):
    """A short pulse of the rudder, and the roll that follows."""

    needs: ClassVar[tuple[str, ...]] = ("rudder",)
    compared: ClassVar[tuple[str, ...]] = ("phi",)
    shows: ClassVar[tuple[str, ...]] = ("phi", "r")
    control: ClassVar[str] = "rudder"
    column: ClassVar[str] = "phi"
    called: ClassVar[str] = "roll"

    side: Side = STARBOARD


def swing(tops: list[tuple[float, float]]) -> tuple[float | None, float | None]:
    """Return period [s] and damping ratio [-] that extremes show; None of fewer than three.

    From the ranges between neighbouring extremes, so that a slow drift does not count.
    """
    if len(tops) < 3:
        return None, None
    (t1, y1), (_, y2), (t3, y3) = tops[:3]
    decrement = math.log(abs((y1 - y2) / (y2 - y3))) if y1 != y2 != y3 else 0.0
    return t3 - t1, decrement / math.hypot(math.pi, decrement)


@dataclass(frozen=True)
class RollDecay(Manoeuvre):
    """Lying still, heeled and let go."""

    compared: ClassVar[tuple[str, ...]] = ("phi",)
    shows: ClassVar[tuple[str, ...]] = ("phi",)
    from_rest: ClassVar[bool] = True

    angle_deg: float = 5.0  # heel
    duration_s: float = 70.0
    side: Side = STARBOARD  # heeled to

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the decay."""
        conn.vehicle.incline(self.sign * math.radians(self.angle_deg))
        conn.mark("let go")
        yield from conn.hold_to(self.duration_s)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return the period, and the amplitude once every cycle."""
        roll = flight.counted_to(self.side).column("phi")
        zeros = zero_crossings(flight.t, roll)
        begin = zeros[0] if zeros else math.inf
        crests = [y for t, y in peaks_of(flight.t, roll) if y > 0.0 and t > begin][:SHOWN_CYCLES]
        amplitudes = [math.radians(self.angle_deg), *crests]
        swings = (len(zeros) - 1) // 2  # whole ones between the first and the last zero
        period = (zeros[2 * swings] - begin) / swings if swings > 0 else None
        measures = [share_measure("period", "s", period)]
        for i, (before, amplitude) in enumerate(pairwise(amplitudes), 1):
            measures.append(share_measure(f"amplitude after cycle {i}", "rad", amplitude))
            measures.append(show_only(f"kept over cycle {i}", "-", amplitude / before))
        return measures


@dataclass(frozen=True)
class Pitching(Manoeuvre):
    """The planes move until the pitch reaches its mark."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)
    compared: ClassVar[tuple[str, ...]] = ("u", "z", "theta")
    shows: ClassVar[tuple[str, ...]] = ("theta", "z", "u", "delta_s")

    angle_deg: float = 20.0  # planes
    execute_deg: float = 10.0  # pitch, absolute
    duration_s: float = 400.0
    direction: Direction = RISE  # at first

    def pitched(self, conn: Conn) -> Generator[None, None, bool]:
        """Order the planes and advance to the mark. Return whether it was reached in time."""
        yield from conn.hold(LEAD_TIME_S)
        conn.order("planes", self.sign * math.radians(self.angle_deg))
        conn.mark("planes")
        pitch = Watch("size of theta", math.radians(self.execute_deg))
        return (yield from conn.until(pitch, self.duration_s - conn.time))


@dataclass(frozen=True)
class Meander(Pitching):
    """The planes move until the pitch reaches its mark, then stay at neutral."""

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the meander."""
        if not (yield from self.pitched(conn)):
            return
        conn.order("planes", 0.0)
        conn.mark("execute")
        yield from conn.hold_to(self.duration_s)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return the execute, peaks and zeros of the pitch from neutral, and its damping."""
        execute = flight.time_of("execute")
        measures = [show_only("time of execute", "s", execute)]
        if execute is None:
            return measures
        after = flight.since(execute)
        t, pitch = flight.t[after], flight.change("theta")[after]
        measures += swing_measures("pitch", "rad", t, pitch)
        return [*measures, show_only("damping ratio", "-", half_cycle_damping(measures))]


def half_cycle_damping(found: list[Measure]) -> float | None:
    """Return the damping ratio [-] that the first two pitch peaks show. None without a second.

    Half a cycle takes an oscillation of damping ratio d to exp(-pi d/sqrt(1 - d^2)) of itself.
    """
    tops = {one.name: one.value for one in found if one.value}
    first, second = tops.get("pitch peak 1"), tops.get("pitch peak 2")
    if not first or not second or first * second > 0.0:
        return None
    decrement = math.log(abs(first / second))
    return decrement / math.hypot(math.pi, decrement)


@dataclass(frozen=True)
class Overshoot(Pitching):
    """The planes go one way until a pitch, then back until depth turns, then neutral."""

    execute_deg: float = 5.0
    duration_s: float = 200.0

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the overshoot."""
        if not (yield from self.pitched(conn)):
            return
        conn.order("planes", -self.sign * math.radians(self.angle_deg))
        conn.mark("execute")
        rising = not conn.passed(Watch("depth rate", 0.0))
        turning = Watch("depth rate", 0.0, 1.0 if rising else -1.0)
        reached = yield from conn.until(turning, self.duration_s - conn.time)
        if not reached:
            return
        conn.order("planes", 0.0)
        conn.mark("reversal")
        yield from conn.hold_to(self.duration_s)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return times, overshoot angle, depth and speed lost, pitch peaks and zeros."""
        execute, reversal = flight.time_of("execute"), flight.time_of("reversal")
        measures = [
            show_only("time of execute", "s", execute),
            show_only("time of reversal", "s", reversal),
        ]
        if execute is None:
            return measures
        pitch, depth = flight.column("theta"), flight.change("z")
        begin = int(flight.t.searchsorted(execute - TIME_ROUNDING_S))
        until = len(pitch)
        if reversal is not None:
            until = int(flight.t.searchsorted(reversal)) + 1
        sense = math.copysign(1.0, pitch[begin])  # the pitch at the execute goes on this way
        top, deep = int((sense * pitch[:until]).argmax()), int(abs(depth[:until]).argmax())
        peak = float(pitch[top])
        measures += [
            share_measure("largest pitch", "rad", peak),
            show_only("time of largest pitch", "s", float(flight.t[top])),
            show_only("overshoot angle", "rad", abs(peak) - math.radians(self.execute_deg)),
            share_measure("depth change", "m", float(depth[deep])),
            show_only("time of depth change", "s", float(flight.t[deep])),
        ]
        after = flight.since(execute)
        t, swing = flight.t[after], flight.change("theta")[after]
        return measures + swing_measures("pitch", "rad", t, swing)

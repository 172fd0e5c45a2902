"""Casualties as manoeuvres: a changed weight, jammed planes or rudder, and the answer.

``trainer boat manoeuvre`` and the guide fly them without a crew: the answer is ordered a stated
time after the failure, so that boats and equations can be compared.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Final, Protocol, runtime_checkable

from trainer.analysis.manoeuvres.flight import LEAD_TIME_S, Conn, Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import (
    DIVE,
    STARBOARD,
    Direction,
    Measure,
    Side,
    Watch,
    heel_measure,
    largest_value,
    part_measure,
    share_measure,
    surface_limit,
)

UPRIGHT_COLUMNS: Final = {"q": "rad/s", "w": "m/s", "theta": "rad", "z": "m", "u": "m/s"}
TURNING_COLUMNS: Final = {"r": "rad/s", "v": "m/s", "psi": "rad", "phi": "rad", "u": "m/s"}
RUN_SIXTHS: Final = tuple(i / 6 for i in range(1, 7))  # of a run
WATCHED_LENGTHS: Final = 12.0  # [lengths run] that are watched once the planes are free


def readings(flight: Flight, begin: float, columns: dict[str, str]) -> list[Measure]:
    """Return the change of columns at each sixth from ``begin`` [s], by name with unit.

    All readings of a column share the tolerance of its largest change, because one near zero would
    else allow no difference at all.
    """
    end = float(flight.t[-1])
    measures = []
    for name, unit in columns.items():
        most = float(abs(flight.change(name)).max())
        for reading in RUN_SIXTHS:
            value = flight.at(begin + reading * (end - begin), name)
            change = None if value is None else value - float(flight.column(name)[0])
            measures.append(part_measure(f"{name} after {reading:.2g} of it", unit, change, most))
    return measures


@runtime_checkable
class LoadableVehicle(Protocol):
    """A vehicle that weight can be put on."""

    def load(self, share: float) -> None:
        """Take on a ``share`` [-] of its weight, or lose it where that is negative."""


@dataclass(frozen=True)
class OutOfBalance(Manoeuvre):
    """Weight lost or taken on, the depth kept or not. It shows floods, blows and suction."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)
    shows: ClassVar[tuple[str, ...]] = ("z", "theta", "delta_s", "u")

    share: float = -0.01  # of the weight
    keep: tuple[str, ...] = ("depth",)
    run_lengths: float = 10.0

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles."""
        for quantity in self.keep:
            conn.vehicle.keep(quantity)
        yield from conn.hold(LEAD_TIME_S)
        speed = conn.value("u")
        if isinstance(conn.vehicle, LoadableVehicle):  # a Nomoto ship has no weight
            conn.vehicle.load(self.share)
        conn.mark("weight")
        yield from conn.hold(self.run_lengths * conn.vehicle.length / speed)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return readings along the way."""
        return readings(flight, flight.time_of("weight") or 0.0, UPRIGHT_COLUMNS)


@dataclass(frozen=True)
class PlaneJam(Manoeuvre):
    """Stern planes jam, the engine is stopped; free again, hard the other way, to level."""

    needs: ClassVar[tuple[str, ...]] = ("planes", "engine")
    shows: ClassVar[tuple[str, ...]] = ("theta", "z", "delta_s", "u")

    angle_deg: float = 10.0  # planes
    jammed_lengths: float = 3.0  # run while they are
    direction: Direction = DIVE

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of jam and recovery."""
        length, speed, sign = conn.vehicle.length, conn.value("u"), self.sign
        yield from conn.hold(LEAD_TIME_S)
        conn.order("planes", sign * math.radians(self.angle_deg))
        conn.mark("jam")
        conn.order("engine", 0.0)
        yield from conn.hold(self.jammed_lengths * length / speed)
        conn.order("planes", -sign * surface_limit(conn.vehicle, "planes"))
        conn.mark("free")
        # the other way and hard over brings the pitch back; where it does not in time the boat is
        # not ordered back to depth, and has no time to level
        level = yield from conn.until(Watch("theta", 0.0, -sign), WATCHED_LENGTHS * length / speed)
        if not level:
            return
        conn.mark("level")
        conn.order("engine", speed)
        conn.vehicle.keep("depth")
        yield from conn.hold(WATCHED_LENGTHS * length / speed)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return pitch and depth at their furthest, the least speed, the time to level."""
        free, level = flight.time_of("free") or 0.0, flight.time_of("level")
        begin = flight.time_of("jam") or 0.0
        return [
            share_measure("largest pitch", "rad", largest_value(flight.change("theta"))),
            share_measure("depth lost", "m", largest_value(flight.change("z"))),
            share_measure("speed lost", "m/s", float(flight.change("u").min())),
            share_measure("time to level", "s", None if level is None else level - begin),
            share_measure("depth when free", "m", flight.at(free, "z")),
            share_measure("largest pitch rate up", "rad/s", float(flight.column("q").max())),
            share_measure("largest pitch rate down", "rad/s", float(flight.column("q").min())),
        ]


@dataclass(frozen=True)
class RudderJam(Manoeuvre):
    """The rudder jams. Some lengths later the engine is stopped; depth kept where it can be."""

    needs: ClassVar[tuple[str, ...]] = ("rudder", "engine")
    shows: ClassVar[tuple[str, ...]] = ("track", "psi", "phi", "u", "z")

    angle_deg: float = 30.0  # rudder
    jammed_lengths: float = 3.0  # run before the engine is stopped
    side: Side = STARBOARD

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of jam and way lost."""
        conn.vehicle.keep("depth")
        length, speed = conn.vehicle.length, conn.value("u")
        yield from conn.hold(LEAD_TIME_S)
        conn.order("rudder", self.sign * math.radians(self.angle_deg))
        conn.mark("jam")
        yield from conn.hold(self.jammed_lengths * length / speed)
        conn.order("engine", 0.0)
        conn.mark("stop")
        yield from conn.hold(WATCHED_LENGTHS * length / speed)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return readings along the way and the largest roll, counted to the side."""
        flight = flight.counted_to(self.side)
        most = heel_measure("largest roll", largest_value(flight.column("phi")))
        return [most, *readings(flight, flight.time_of("jam") or 0.0, TURNING_COLUMNS)]

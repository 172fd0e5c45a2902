"""Manoeuvres that only the reduction flies: weaves by the clock, a stern-plane jam recovered."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Final

from trainer.study.manoeuvres.conn import Conn
from trainer.study.manoeuvres.flight import Flight, Manoeuvre
from trainer.study.manoeuvres.measures import Measure, largest, part, peaks, share
from trainer.study.manoeuvres.vehicle import Watch

LEAD: Final = 2.0  # [s] of straight flight
LEGS: Final = (3.0, 6.0, 6.0)  # [lengths run] of the weave, rudder to starboard, port, starboard
READINGS: Final = (1 / 3, 2 / 3, 1.0)  # of a leg
LEVEL: Final = {"r": "rad/s", "v": "m/s", "psi": "rad", "u": "m/s", "phi": "rad"}
UPRIGHT: Final = {"q": "rad/s", "w": "m/s", "theta": "rad", "z": "m", "u": "m/s"}
AFTER: Final = 12.0  # [lengths run] that are watched once the planes are free


@dataclass(frozen=True)
class Weave(Manoeuvre):
    """Rudder from side to side by the clock, whatever the heading does; depth kept."""

    needs: ClassVar[tuple[str, ...]] = ("rudder",)
    keep: ClassVar[tuple[str, ...]] = ("depth",)
    watched: ClassVar[Mapping[str, str]] = LEVEL
    swinging: ClassVar[str] = "psi"

    angle_deg: float = 15.0  # control

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the legs."""
        for quantity in self.keep:
            conn.vehicle.keep(quantity)
        yield from conn.hold(LEAD)
        length, speed, side = conn.vehicle.length, conn.value("u"), 1.0
        for run in LEGS:
            conn.order(self.needs[0], side * math.radians(self.angle_deg))
            conn.mark("leg")
            yield from conn.hold(run * length / speed)
            side = -side

    def measures(self, flight: Flight) -> list[Measure]:
        """Return readings along the legs, and the first extremes of what swings."""
        begins = [mark.t for mark in flight.marks]
        ends = [*begins[1:], float(flight.t[-1])]
        times = {
            f"{reading:.2g} of leg {i}": begin + reading * (end - begin)
            for i, (begin, end) in enumerate(zip(begins, ends, strict=True), start=1)
            for reading in READINGS
        }
        found = []
        for name, unit in self.watched.items():
            most = float(abs(flight.change(name)).max())
            for told, time in times.items():
                found.append(part(f"{name} after {told}", unit, flight.at(time, name), most))
        swing = flight.change(self.swinging)
        for i, (_, value) in enumerate(peaks(flight.t, swing)[:2], start=1):
            told = f"peak {i} of {self.swinging}"
            found.append(part(told, "rad", value, float(abs(swing).max())))
        return found


@dataclass(frozen=True)
class VerticalWeave(Weave):
    """Planes from side to side by the clock, whatever the pitch does."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)
    keep: ClassVar[tuple[str, ...]] = ()
    watched: ClassVar[Mapping[str, str]] = UPRIGHT
    swinging: ClassVar[str] = "theta"

    angle_deg: float = 5.0  # control


@dataclass(frozen=True)
class PlaneJam(Manoeuvre):
    """Stern planes jam to dive, the engine is stopped; free again, hard to rise, to level."""

    needs: ClassVar[tuple[str, ...]] = ("planes", "engine")

    angle_deg: float = 10.0  # planes
    jammed_lengths: float = 3.0  # run while they are

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of jam and recovery."""
        angle, length = math.radians(self.angle_deg), conn.vehicle.length
        speed = conn.value("u")
        yield from conn.hold(LEAD)
        conn.order("planes", -angle)
        conn.mark("jam")
        conn.order("engine", 0.0)
        yield from conn.hold(self.jammed_lengths * length / speed)
        conn.order("planes", conn.vehicle.controls["planes"].high)
        conn.mark("free")
        level = yield from conn.until(Watch("theta", 0.0), AFTER * length / speed)
        if not level:
            return
        conn.mark("level")
        conn.order("engine", speed)
        conn.vehicle.keep("depth")
        yield from conn.hold(AFTER * length / speed)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return pitch and depth at their furthest, speed at its least, and the time to level."""
        free, level = flight.time_of("free") or 0.0, flight.time_of("level")
        begin = flight.time_of("jam") or 0.0
        return [
            share("largest pitch", "rad", largest(flight.change("theta"))),
            share("depth lost", "m", largest(flight.change("z"))),
            share("speed lost", "m/s", float(flight.change("u").min())),
            share("time to level", "s", None if level is None else level - begin),
            share("depth when free", "m", flight.at(free, "z")),
            share("largest pitch rate up", "rad/s", float(flight.column("q").max())),
            share("largest pitch rate down", "rad/s", float(flight.column("q").min())),
        ]

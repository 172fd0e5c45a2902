"""Manoeuvres that only the reduction flies: weaves by the clock, a stern-plane jam recovered."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Final, Protocol, runtime_checkable

from trainer.analysis.manoeuvres.flight import Conn, Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import Measure, Watch, largest, part, share

LEAD: Final = 2.0  # [s] of straight flight
LEGS: Final = (3.0, 6.0, 6.0)  # [lengths run] of the weave, rudder to starboard, port, starboard
READINGS: Final = (1 / 3, 2 / 3, 1.0)  # of a leg
LEVEL: Final = {"r": "rad/s", "v": "m/s", "psi": "rad", "u": "m/s", "phi": "rad"}
UPRIGHT: Final = {"q": "rad/s", "w": "m/s", "theta": "rad", "z": "m", "u": "m/s"}
SIXTHS: Final = tuple(i / 6 for i in range(1, 7))  # of a run out of balance
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
        """Return readings along the legs, and the extremes of what swings."""
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
        most = float(abs(swing).max())
        found.append(part(f"largest {self.swinging}", "rad", float(swing.max()), most))
        found.append(part(f"smallest {self.swinging}", "rad", float(swing.min()), most))
        return found


@dataclass(frozen=True)
class VerticalWeave(Weave):
    """Planes from side to side by the clock, whatever the pitch does."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)
    keep: ClassVar[tuple[str, ...]] = ()
    watched: ClassVar[Mapping[str, str]] = UPRIGHT
    swinging: ClassVar[str] = "theta"

    angle_deg: float = 5.0  # control


@runtime_checkable
class Loadable(Protocol):
    """A vehicle that weight can be put on."""

    def load(self, share: float) -> None:
        """Take a ``share`` [-] of its weight on, or lose it."""
        ...


@dataclass(frozen=True)
class OutOfBalance(Manoeuvre):
    """Weight lost or taken on, the depth kept or not: how floods, blows and suction are borne."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)

    share: float = -0.01  # of the weight
    keep: tuple[str, ...] = ("depth",)
    run_lengths: float = 10.0

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles."""
        for quantity in self.keep:
            conn.vehicle.keep(quantity)
        yield from conn.hold(LEAD)
        speed = conn.value("u")
        if isinstance(conn.vehicle, Loadable):
            conn.vehicle.load(self.share)
        conn.mark("weight")
        yield from conn.hold(self.run_lengths * conn.vehicle.length / speed)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return readings along the way."""
        begin, end = flight.time_of("weight") or 0.0, float(flight.t[-1])
        found = []
        for name, unit in UPRIGHT.items():
            most = float(abs(flight.change(name)).max())
            for reading in SIXTHS:
                value = flight.at(begin + reading * (end - begin), name)
                change = None if value is None else value - float(flight.column(name)[0])
                found.append(part(f"{name} after {reading:.2g} of it", unit, change, most))
        return found


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

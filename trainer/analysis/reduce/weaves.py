"""Weaves that only the reduction flies: a control from side to side by the clock."""

import math
from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, Final

from trainer.analysis.manoeuvres.casualties import UPRIGHT
from trainer.analysis.manoeuvres.flight import Conn, Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import (
    RISE,
    SIGNS,
    STARBOARD,
    Direction,
    Measure,
    Side,
    part,
)

LEAD: Final = 2.0  # [s] of straight flight
LEGS: Final = (3.0, 6.0, 6.0)  # [lengths run] to one side, the other, and the first again
READINGS: Final = (1 / 3, 2 / 3, 1.0)  # of a leg
LEVEL: Final = {"r": "rad/s", "v": "m/s", "psi": "rad", "u": "m/s", "phi": "rad"}


@dataclass(frozen=True)
class _Weave(Manoeuvre):
    """One control from side to side by the clock, whatever the boat does."""

    keep: ClassVar[tuple[str, ...]] = ()
    watched: ClassVar[Mapping[str, str]]  # columns and their units
    swinging: ClassVar[str]

    angle_deg: float = 15.0  # control

    @property
    @abstractmethod
    def sign(self) -> float:
        """Return the sign of the first order."""

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the legs."""
        for quantity in self.keep:
            conn.vehicle.keep(quantity)
        yield from conn.hold(LEAD)
        length, speed, sign = conn.vehicle.length, conn.value("u"), self.sign
        for run in LEGS:
            conn.order(self.needs[0], sign * math.radians(self.angle_deg))
            conn.mark("leg")
            yield from conn.hold(run * length / speed)
            sign = -sign

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
class Weave(_Weave):
    """Rudder from side to side; depth kept."""

    needs: ClassVar[tuple[str, ...]] = ("rudder",)
    keep: ClassVar[tuple[str, ...]] = ("depth",)
    watched: ClassVar[Mapping[str, str]] = LEVEL
    swinging: ClassVar[str] = "psi"

    side: Side = STARBOARD

    @property
    def sign(self) -> float:
        """Return the sign of the first order: positive to starboard."""
        return SIGNS[self.side]

    def measures(self, flight: Flight) -> list[Measure]:
        """Return readings and extremes, counted to the side."""
        return super().measures(flight.counted_to(self.side))


@dataclass(frozen=True)
class VerticalWeave(_Weave):
    """Planes from side to side."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)
    watched: ClassVar[Mapping[str, str]] = UPRIGHT
    swinging: ClassVar[str] = "theta"

    angle_deg: float = 5.0  # control
    direction: Direction = RISE

    @property
    def sign(self) -> float:
        """Return the sign of the first order: positive to rise."""
        return SIGNS[self.direction]

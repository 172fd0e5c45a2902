"""The meander of 1969: planes to rise until a pitch, then neutral, and what the boat does of it."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Final

from trainer.study.manoeuvres.conn import Conn
from trainer.study.manoeuvres.flight import Flight, Manoeuvre
from trainer.study.manoeuvres.measures import Measure, shown, swing_measures
from trainer.study.manoeuvres.vehicle import Watch

LEAD: Final = 2.0  # [s] of straight flight


@dataclass(frozen=True)
class Meander(Manoeuvre):
    """Planes to rise until the pitch reaches its mark, then neutral, and held."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)
    compared: ClassVar[tuple[str, ...]] = ("u", "z", "theta")
    shows: ClassVar[tuple[str, ...]] = ("theta", "z", "u", "delta_s")

    angle_deg: float = 20.0  # planes
    execute_deg: float = 10.0  # pitch, absolute
    duration_s: float = 400.0

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the meander."""
        execute = math.radians(self.execute_deg)
        yield from conn.hold(LEAD)
        conn.order("planes", math.radians(self.angle_deg))
        conn.mark("planes")
        reached = yield from conn.until(
            Watch("size of theta", execute), self.duration_s - conn.time
        )
        if not reached:
            return
        conn.order("planes", 0.0)
        conn.mark("execute")
        yield from conn.hold_to(self.duration_s)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return the execute, peaks and zeros of the pitch from neutral, and its damping."""
        execute = flight.time_of("execute")
        found = [shown("time of execute", "s", execute)]
        if execute is None:
            return found
        after = flight.since(execute)
        t, pitch = flight.t[after], flight.change("theta")[after]
        found += swing_measures("pitch", "rad", t, pitch)
        return [*found, shown("damping ratio", "-", half_cycle_damping(found))]


def half_cycle_damping(found: list[Measure]) -> float | None:
    """Return the damping ratio [-] that the first two pitch peaks show; None without a second.

    Half a cycle takes an oscillation of damping ratio d to exp(-pi d/sqrt(1 - d^2)) of itself.
    """
    tops = {one.name: one.value for one in found if one.value}
    first, second = tops.get("pitch peak 1"), tops.get("pitch peak 2")
    if not first or not second or first * second > 0.0:
        return None
    decrement = math.log(abs(first / second))
    return decrement / math.hypot(math.pi, decrement)

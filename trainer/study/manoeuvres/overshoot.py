"""The vertical overshoot of 1969: planes reversed at a pitch, until the depth turns back."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Final

from trainer.study.manoeuvres.conn import Conn
from trainer.study.manoeuvres.flight import Flight, Manoeuvre
from trainer.study.manoeuvres.measures import Measure, share, shown, swing_measures
from trainer.study.manoeuvres.vehicle import Watch

LEAD: Final = 2.0  # [s] of straight flight
EARLY: Final = 1e-9  # [s] rounding


@dataclass(frozen=True)
class Overshoot(Manoeuvre):
    """Planes to rise until a pitch, to dive as far until the depth turns back, then neutral."""

    needs: ClassVar[tuple[str, ...]] = ("planes",)
    compared: ClassVar[tuple[str, ...]] = ("u", "z", "theta")
    shows: ClassVar[tuple[str, ...]] = ("theta", "z", "u", "delta_s")

    angle_deg: float = 20.0  # planes
    execute_deg: float = 5.0  # pitch, absolute
    duration_s: float = 200.0

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles of the overshoot."""
        angle, execute = math.radians(self.angle_deg), math.radians(self.execute_deg)
        yield from conn.hold(LEAD)
        conn.order("planes", angle)
        conn.mark("planes")
        reached = yield from conn.until(
            Watch("size of theta", execute), self.duration_s - conn.time
        )
        if not reached:
            return
        conn.order("planes", -angle)
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
        found = [shown("time of execute", "s", execute), shown("time of reversal", "s", reversal)]
        if execute is None:
            return found
        pitch, depth = flight.column("theta"), flight.change("z")
        begin = int(flight.t.searchsorted(execute - EARLY))
        until = len(pitch)
        if reversal is not None:
            until = int(flight.t.searchsorted(reversal)) + 1
        sense = math.copysign(1.0, pitch[begin])  # the pitch at the execute goes on this way
        top, deep = int((sense * pitch[:until]).argmax()), int(abs(depth[:until]).argmax())
        peak = float(pitch[top])
        found += [
            share("largest pitch", "rad", peak),
            shown("time of largest pitch", "s", float(flight.t[top])),
            shown("overshoot angle", "rad", abs(peak) - math.radians(self.execute_deg)),
            share("depth change", "m", float(depth[deep])),
            shown("time of depth change", "s", float(flight.t[deep])),
        ]
        after = flight.since(execute)
        t, swing = flight.t[after], flight.change("theta")[after]
        return found + swing_measures("pitch", "rad", t, swing)

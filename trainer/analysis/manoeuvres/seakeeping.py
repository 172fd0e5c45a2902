"""A boat in a beam sea: how much it moves with the waves.

The guide and the search for a compact set fly it, because a set can be right in every manoeuvre of
a calm and wrong in waves: these push on all the mass that the hull carries along. The sea is of the
boat's size, so that every hull meets waves of about the same steepness at the same depth in lengths
of wave.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Final, Protocol, runtime_checkable

import numpy as np

from trainer.analysis.manoeuvres.flight import Conn, Flight, Manoeuvre
from trainer.analysis.manoeuvres.vehicle import Measure
from trainer.core.kernel import Numbers

# The sea of a hull of BB2's length is sea state 5: 3.25 m, 9 s. Smaller boats go out in less: the
# exponent is this project's estimate, and gives 5.4 s for a boat of 5 m, 4.1 s for one of 1.3 m.
PEAK_PERIOD_S, PEAK_PERIOD_LENGTH_M, PEAK_PERIOD_POWER = 9.0, 70.2, 0.2
WAVE_STEEPNESS: Final = 0.0257  # [-] significant height over the peak's length, as in that sea
G_M_S2: Final = 9.81  # [m/s2] of the size of a sea, which needs no other planet
SETTLING_PERIODS: Final = 25.0  # [peak periods] until the boat moves as the waves do
JUDGED_PERIODS: Final = 150.0  # [peak periods] measured after that
SLOWEST_PERIODS: Final = 3.3  # [peak periods] what is slower is drift, and taken off: 30 s of BB2
SEA_ALLOWANCE: Final = 0.1  # [-] by which the motion in waves may differ
MOVING_COLUMNS: Final = {
    "v": "m/s",
    "w": "m/s",
    "phi": "rad",
    "theta": "rad",
    "r": "rad/s",
    "z": "m",
}


def peak_period(length: float) -> float:
    """Return the peak's period [s] in the sea for a boat of ``length`` [m]."""
    return float(PEAK_PERIOD_S * (length / PEAK_PERIOD_LENGTH_M) ** PEAK_PERIOD_POWER)


def wave_number(length: float) -> float:
    """Return the peak's wave number [1/m] in the sea for a boat of ``length`` [m]."""
    return (2.0 * math.pi / peak_period(length)) ** 2 / G_M_S2


def fast_part(values: Numbers, count: int) -> Numbers:
    """Return ``values`` (n,) less their mean over ``count`` about each; ends are left out."""
    sums = np.cumsum(np.concatenate(([0.0], values)))
    means = (sums[count:] - sums[:-count]) / count
    begin = count // 2
    return np.asarray(values[begin : begin + means.size] - means)


@runtime_checkable
class SeagoingVehicle(Protocol):
    """A vehicle that waves move."""

    def meet_sea(self, height: float, period: float) -> None:
        """Let waves run to starboard, unless the vehicle is in a sea of its own.

        ``height`` [m] is their significant height, ``period`` [s] that of their peak.
        """


@dataclass(frozen=True)
class BeamSea(Manoeuvre):
    """Waves from port, depth and course kept: how much the boat moves with them."""

    shows: ClassVar[tuple[str, ...]] = ("phi", "z", "theta", "v")
    in_waves: ClassVar[bool] = True

    def schedule(self, conn: Conn) -> Iterator[None]:
        """Yield the cycles."""
        length = conn.vehicle.length
        period = peak_period(length)
        for quantity in ("depth", "course"):
            conn.vehicle.keep(quantity)
        if isinstance(conn.vehicle, SeagoingVehicle):  # a Nomoto ship feels no sea
            conn.vehicle.meet_sea(WAVE_STEEPNESS * 2.0 * math.pi / wave_number(length), period)
        yield from conn.hold(SETTLING_PERIODS * period)
        conn.mark("measured")
        yield from conn.hold(JUDGED_PERIODS * period)

    def measures(self, flight: Flight) -> list[Measure]:
        """Return the standard deviation of what the waves move."""
        begin = flight.time_of("measured")
        if begin is None:
            return []
        measured = flight.since(begin)
        count = round(SLOWEST_PERIODS * peak_period(flight.length) / flight.step)
        measures = []
        for name, unit in MOVING_COLUMNS.items():
            if flight.has(name):
                size = float(np.std(fast_part(flight.column(name)[measured], count)))
                measures.append(Measure(f"rms of {name}", unit, size, SEA_ALLOWANCE * size))
        return measures

"""What a tick costs by one equation set and by the other, here and now."""

from dataclasses import dataclass
from time import perf_counter_ns
from typing import Final

import numpy as np

from trainer.boat import Boat
from trainer.config import ConfigError
from trainer.core.sortie import COLUMNS, LOOKOUT, sail
from trainer.files.vessel_file import VesselFile
from trainer.fitout import Method
from trainer.units import KNOT

TICKS: Final = 2000
TIMES: Final = 7
DEEP: Final = 1000.0  # [m]


@dataclass(frozen=True)
class Cost:
    """The least time of a tick, the whole boat's, back to back."""

    full_ns: float
    compact_ns: float

    @property
    def ratio(self) -> float:
        """Return the compact set's cost as a share of the full set's."""
        return self.compact_ns / self.full_ns


def cost(file: VesselFile) -> Cost | None:
    """Return the cost of a tick, full set exact, compact lagged; None of a boat that cannot start.

    Both by Adams, at the boat's own step and speed.
    """
    try:
        full, compact = (
            _nanoseconds(file, Method(equations, rates, "exact", "adams2", file.run.step_s))
            for equations, rates in (("full", "exact"), ("modified", "lagged"))
        )
    except ConfigError:
        return None
    return Cost(full, compact)


def _nanoseconds(file: VesselFile, method: Method) -> float:
    """Return the least time [ns] of a tick."""
    boat = Boat(file, method)
    eye = np.zeros(1, LOOKOUT)
    eye["last"], eye["steepest"] = 1e18, 10.0
    rows = np.empty((TICKS, COLUMNS))
    least = float("inf")
    for _ in range(TIMES):
        boat.start(file.run.start_speed_kn * KNOT, DEEP, 0.0)
        begin = perf_counter_ns()
        flown = sail(tuple(boat.records), eye, rows)
        least = min(least, (perf_counter_ns() - begin) / max(flown, 1))
    return least

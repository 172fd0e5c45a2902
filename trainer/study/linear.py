"""The boat's equations about straight level flight, as matrices."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trainer.boat import Boat
from trainer.core.rates import rates
from trainer.core.state import MOTION

CONTROLS = ("delta_r", "delta_s", "delta_b", "u_c")
INTERNAL = tuple(MOTION.index(name) for name in ("u", "v", "w", "p", "q", "r", "phi", "theta"))

Matrix = NDArray[np.float64]


@dataclass(frozen=True)
class Linear:
    """d(motion)/dt = A motion + B controls, in the orders of MOTION and CONTROLS, SI."""

    A: Matrix
    B: Matrix

    def part(self, *names: str) -> Matrix:
        """Return A restricted to the named motions."""
        places = [MOTION.index(name) for name in names]
        return self.A[np.ix_(places, places)]

    def inputs(self, names: tuple[str, ...], controls: tuple[str, ...]) -> Matrix:
        """Return B restricted to the named motions and controls."""
        rows = [MOTION.index(name) for name in names]
        return self.B[np.ix_(rows, [CONTROLS.index(name) for name in controls])]


def linearise(boat: Boat, nudge: float = 1e-5) -> Linear:
    """Return the matrices at the boat's present state, by central differences, exact solve.

    The terms with |.| have no second derivative at zero; their slope there is the mean of the two
    sides, as a small motion sees it.
    """
    vessel, compact, scheme, state, scratch = (record.copy() for record in boat.records)
    scheme["exact"] = 1

    def column(name: str) -> Matrix:
        centre = state[name][0]
        slopes = []
        for side in (1.0, -1.0):
            state[name] = centre + side * nudge
            rates(vessel, compact, scheme, state, scratch)
            slopes.append(state["rates"][0].copy())
        state[name] = centre
        return np.asarray((slopes[0] - slopes[1]) / (2.0 * nudge))

    return Linear(
        np.column_stack([column(name) for name in MOTION]),
        np.column_stack([column(name) for name in CONTROLS]),
    )


def at_speed(boat: Boat, speed: float) -> Linear | None:
    """Return the matrices in trim at ``speed`` [m/s], None if there is no such trim."""
    if not boat.trimmed(speed):
        return None
    return linearise(boat)

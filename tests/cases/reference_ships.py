"""Ships whose numbers are known, under experiments: what estimation is rehearsed on.

The ships are those of the report's sections 6 to 10 as its tables have them, bis system, the rudder
positive to port. Where the tables' errors and disturbances are not legible they are of the size
that makes the documented scatter. Many records of one ship count how often the truth is inside.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.experiment import hold_bits, prbs
from trainer.identify.fitting.problem import Problem
from trainer.identify.model.models import Ship
from trainer.identify.monte_carlo import KnownShip, SimulatedRun, one_run
from trainer.units import DEGREE, KNOT

SHIP_DERIVATIVES: Final = ("Y_v", "Y_r", "N_v", "N_r", "Y_delta", "l_delta")
STATE: Final = ("x1_0", "x2_0", "x3_0")


@dataclass(frozen=True)
class Coverage:
    """Many runs and the truth behind them."""

    names: tuple[str, ...]
    truth: Numbers  # (f,)
    runs: tuple[SimulatedRun, ...]

    @property
    def estimates(self) -> Numbers:
        """Return the estimates (runs, f)."""
        return np.array([run.theta for run in self.runs])

    @property
    def deviations(self) -> Numbers:
        """Return their standard deviations (runs, f)."""
        return np.array([run.deviations for run in self.runs])

    @property
    def inside(self) -> Numbers:
        """Return of each parameter the share of 95 % intervals that hold the truth (f,)."""
        low, high = np.moveaxis(np.array([run.intervals for run in self.runs]), 2, 0)
        return np.asarray(((low <= self.truth) & (self.truth <= high)).mean(axis=0))

    @property
    def pooled(self) -> float:
        """Return the share of all intervals that hold the truth."""
        return float(self.inside.mean())

    @property
    def converged(self) -> float:
        """Return the share of runs whose minimiser came to its end."""
        return float(np.mean([run.converged for run in self.runs]))


def study(
    problem: Problem,
    truth: Numbers,
    seeds: range,
    each: Callable[[Iterator[SimulatedRun]], Iterator[SimulatedRun]],
) -> Coverage:
    """Return the runs of ``seeds``. ``each`` passes them on and may show how far it is."""
    runs = each(one_run(problem, truth, seed) for seed in seeds)
    return Coverage(problem.names, truth, tuple(runs))


def sequence(count: int, bit: float, amplitude: float, period: float) -> Numbers:
    """Return rudder angles (count,) [deg]: a binary sequence with bits of ``bit`` [s]."""
    return np.resize(hold_bits(prbs(7), amplitude, max(1, round(bit / period))), count)


TANKER_SHIP: Final = {
    "m11": 1.7,
    "m22": 0.105,
    "Y_v": -1.59,
    "Y_r": -0.616,
    "N_v": -0.183,
    "N_r": -0.125,
    "Y_delta": 0.199,
    "l_delta": 0.065 / 0.199,
}
TANKER_BEGIN: Final = {
    "Y_v": -1.23,
    "Y_r": -0.525,
    "N_v": -0.2,
    "N_r": -0.26,
    "Y_delta": 0.197,
    "l_delta": 0.094 / 0.197,
}

# Sea Splendour, Table 9.1, read every 5 s at the centre of mass: the ship of speed and coverage
TANKER: Final = KnownShip(
    "1",
    Ship(329.0, 15.9 * KNOT, 120.0, 130.0),
    ("sway", "yaw_rate", "heading"),
    5.0,
    {
        **TANKER_SHIP,
        "Y_0": 1e-4,
        "N_0": 1e-5,
        "r_0": 1e-3,
        "R1_Y": 2e-3,
        "R1_N": 1.2e-5,
        "R1_YN": 0.3,
        "R2_v1": 0.01,
        "R2_r": 1e-4,
        "R2_psi": 0.01,
        "lag": 0.3,
        "x1_0": 0.1,
        "x2_0": 0.01,
        "x3_0": 1.0,
    },
    (
        *(*SHIP_DERIVATIVES, "Y_0", "N_0", "r_0", "R1_Y", "R1_N", "R1_YN"),
        *("R2_v1", "R2_r", "R2_psi", *STATE, "lag"),
    ),
    {
        **TANKER_BEGIN,
        "Y_0": 0.0,
        "N_0": 0.0,
        "r_0": 0.0,
        "R1_Y": 1e-3,
        "R1_N": 1e-5,
        "R1_YN": 0.0,
        "R2_v1": 0.02,
        "R2_r": 2e-4,
        "R2_psi": 0.02,
        "lag": 0.1,
        "x1_0": 0.0,
        "x2_0": 0.0,
        "x3_0": 0.0,
    },
)
TANKER_RUDDER: Final = sequence(2000, 30.0, 5.0, 5.0)

# Compass Island, Tables 10.2 and 10.4
ISLAND: Final = KnownShip(
    "1",
    Ship(160.93, 8.74 * KNOT),
    ("sway", "yaw_rate", "heading"),
    6.0,
    {
        "m11": 1.935,
        "m12": 0.033,
        "m21": 0.015,
        "m22": 0.104,
        "Y_v": -1.105,
        "Y_r": -0.558,
        "N_v": -0.004,
        "N_r": -0.129,
        "Y_delta": 0.544,
        "l_delta": 0.13 / 0.544,
        "R1_Y": 2e-3,
        "R1_N": 1e-5,
        "R2_v1": 0.01,
        "R2_r": 1e-4,
        "R2_psi": 0.04,
        "lag": math.asin(5.35 / 6.0),
    },
    (
        *("Y_v", "Y_r", "N_v", "N_r", "Y_delta", "l_delta", "Y_0", "N_0", "r_0"),
        *("R1_Y", "R1_N", "R2_v1", "R2_r", "R2_psi", *STATE, "lag"),
    ),
    {
        "Y_v": -1.452,
        "Y_r": -0.658,
        "N_v": -0.364,
        "N_r": -0.23,
        "Y_delta": 0.348,
        "l_delta": 0.166 / 0.348,
        "R1_Y": 4e-3,
        "R1_N": 2e-5,
        "lag": 0.5,
    },
)


def zigzag_rudder(rehearsal: KnownShip, angle: float, count: int) -> Numbers:
    """Return the rudder (n,) [deg] of a zig-zag angle/angle of the model without any noise."""
    problem = rehearsal.problem(np.zeros(count))
    mean, _, start = problem.sampled(problem.start).at(0)
    z = np.array([*start[:, 0], 0.0, 0.0, 1.0])
    rudder, side = np.empty(count), 1.0
    for k in range(count):
        if -side * z[2] / DEGREE >= angle:
            side = -side
        z[3], z[4] = rudder[k - 1] if k else side * angle, side * angle
        rudder[k] = side * angle
        z[:3] = (mean[0] @ z)[:3]
    return rudder

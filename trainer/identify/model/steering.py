"""Steering of a boat by its vessel file, in Model 1's terms.

``study_problem`` starts from it, and ``trainer ship prbs`` and ``trainer ship steering`` show it.
The rudder of a vessel file and that of the models have one sign: positive turns to port. Roll is
left out of the models: what it does to sway and yaw is small.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.analysis.programs.characteristic import (
    HORIZONTAL_STATES,
    STEADY_MOTIONS,
    MeanMotions,
    dimensional_constants,
    horizontal_system,
)
from trainer.config.derivatives import DerivativesFile
from trainer.config.vessel import VesselFile
from trainer.core.kernel import Numbers
from trainer.identify.model.nomoto import Nomoto, levers, nomoto, solve_motion, transfer
from trainer.units import KNOT

STEERED_STATES: Final = ("v", "r")


@dataclass(frozen=True)
class SteeringModel:
    """M d(v, r)/dt = F (v, r) + g delta at a speed [m/s], SI."""

    M: Numbers
    F: Numbers
    g: Numbers
    speed: float
    length: float
    density: float

    @property
    def nomoto(self) -> Nomoto:
        """Return gains and time constants, SI."""
        return nomoto(transfer(*solve_motion(self.M, self.F, self.g)))

    @property
    def levers(self) -> tuple[float, ...]:
        """Return the lever arms and the margin of stability [m]."""
        return levers(self.F, self.g)

    @property
    def prime(self) -> dict[str, float]:
        """Return Model 1's twelve parameters but the wind's, prime system."""
        mass = 0.5 * self.density * self.length**3
        L, V = self.length, self.speed
        Y, N = self.g / (mass * V**2 / np.array([L, 1.0]))
        return {
            "m11": self.M[0, 0] / mass,
            "m12": self.M[0, 1] / (mass * L),
            "m21": self.M[1, 0] / (mass * L),
            "m22": self.M[1, 1] / (mass * L**2),
            "Y_v": self.F[0, 0] * L / (mass * V),
            "Y_r": self.F[0, 1] / (mass * V),
            "N_v": self.F[1, 0] / (mass * V),
            "N_r": self.F[1, 1] / (mass * V * L),
            "Y_delta": float(Y),
            "l_delta": float(-N / Y),
        }


def find_steering(
    file: VesselFile, speed: float, means: MeanMotions = STEADY_MOTIONS
) -> SteeringModel:
    """Return the steering of a boat at ``speed`` [m/s], quadratic terms averaged by ``means``."""
    linear = horizontal_system(file, speed, means)
    indices = [HORIZONTAL_STATES.index(name) for name in STEERED_STATES]
    pick = np.ix_(indices, indices)
    c = dimensional_constants(file)
    g = speed**2 * np.array([c.Y_dr, c.N_dr])
    length, density = file.hull.length, file.fluid.rho
    return SteeringModel(linear.E[pick], linear.F[pick], g, speed, length, density)


def tabled_steering(ship: DerivativesFile) -> SteeringModel:
    """Return the steering of a table's derivatives, its unit of mass as 1 kg."""
    L, V = ship.length_m, ship.speed_kn * KNOT
    arms = np.array([1.0, L])
    powers = np.outer(arms, arms)
    M = np.array([[ship.m11, ship.m12], [ship.m21, ship.m22]]) * powers
    F = np.array([[ship.Y_v, ship.Y_r], [ship.N_v, ship.N_r]]) * powers * V / L
    g = np.array([ship.Y_delta, ship.N_delta]) * arms * V**2 / L
    return SteeringModel(M, F, g, V, L, density=2.0 / L**3)


def limits(file: VesselFile) -> tuple[float, float]:
    """Return limit [rad] and rate [rad/s] of the rudder.

    A Nomoto file that is written from a vessel takes them over.
    """
    surfaces = file.surfaces
    return math.radians(surfaces.rudder_limit_deg), math.radians(surfaces.rate_deg_s)

"""Transfer functions of a steered ship or boat, in the form of Nomoto.

Nomoto's form says how a ship steers in a gain K and a few time constants. ``derived`` brings fitted
models to it, ``find_steering`` a vessel file, in Model 1's terms. Model identification, section 3.
The rudder turns a stable ship to port when positive: K < 0; that of a vessel file has the same
sign. Roll is left out: what it does to sway and yaw is small. Everything is in whatever system the
matrices are in: SI, prime or bis.
"""

import math
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from trainer.analysis.programs.characteristic import (
    HORIZONTAL_STATES,
    STEADY_MOTIONS,
    MeanMotions,
    dimensional_constants,
    horizontal_system,
)
from trainer.config.boat.vessel import VesselFile
from trainer.config.ship.derivatives import DerivativesFile
from trainer.core.kernel import Numbers
from trainer.units import KNOT

GRAVITY_M_S2: Final = 9.81  # [m/s^2] in the bis system

STEERED_STATES: Final = ("v", "r")


class Transfer(NamedTuple):
    """The transfer functions of a ship by rudder.

    They are G1 = (b1 s + b2)/D to heading, G2 = (c1 s^2 + c2 s + c3)/D to sway.

    D = s^3 + a1 s^2 + a2 s + a3.
    """

    a1: float
    a2: float
    a3: float
    b1: float
    b2: float
    c1: float
    c2: float
    c3: float


@dataclass(frozen=True)
class Nomoto:
    """Yaw rate and sway by rudder.

    Yaw rate is K (1 + T3 s)/((1 + T1 s)(1 + T2 s)), sway K_v (1 + T3v s)/(same).

    With complex roots ``T1`` and ``T2`` are a complex pair.
    """

    K: float  # [1/s], where the matrices are SI
    T1: complex  # [s]
    T2: complex  # [s]
    T3: float  # [s]
    K_v: float  # [m/s]
    T3v: float  # [s]

    @property
    def first_order(self) -> float:
        """Return T = T1 + T2 - T3. It is that of the first-order model K/(1 + T s)."""
        return float((self.T1 + self.T2).real) - self.T3

    @property
    def stable(self) -> bool:
        """Return whether the ship keeps a straight course with the rudder held."""
        return self.T1.real > 0.0 and self.T2.real > 0.0


def solve_motion(M: Numbers, F: Numbers, g: Numbers) -> tuple[Numbers, Numbers]:
    """Return A (2, 2) or (2, 3) and b (2,). They are those of M x' = F x + g delta (3.1)."""
    return np.asarray(np.linalg.solve(M, F), float), np.asarray(np.linalg.solve(M, g), float)


def transfer(A: Numbers, b: Numbers) -> Transfer:
    """Return the transfer functions of sway and yaw (3.2).

    ``A`` is (2, 2), or (2, 3) with wind: the third column is what heading does.
    """
    (a11, a12), (a21, a22) = A[0, :2], A[1, :2]
    a13, a23 = (A[0, 2], A[1, 2]) if A.shape[1] == 3 else (0.0, 0.0)
    b11, b21 = b
    return Transfer(
        a1=-a11 - a22,
        a2=a11 * a22 - a12 * a21 - a23,
        a3=a11 * a23 - a13 * a21,
        b1=b21,
        b2=a21 * b11 - a11 * b21,
        c1=b11,
        c2=a12 * b21 - a22 * b11,
        c3=a13 * b21 - a23 * b11,
    )


def time_constants(a1: float, a2: float) -> tuple[complex, complex]:
    """Return T1 and T2 of s^2 + a1 s + a2 (3.3). T1 is from the right-most root.

    The root whose sum does not cancel is computed first, and the other one from the product,
    because a difference of nearly equal numbers would lose digits.
    """
    half = 0.5 * a1
    inside = half * half - a2
    if inside < 0.0:
        root = complex(-half, math.sqrt(-inside))
        return -1.0 / root, -1.0 / root.conjugate()
    far = -half - math.copysign(math.sqrt(inside), half)
    if far == 0.0:
        return complex(math.inf), complex(math.inf)
    roots = sorted((far, a2 / far), reverse=True)
    first, second = (complex(math.inf if root == 0.0 else -1.0 / root) for root in roots)
    return first, second


def rate_coefficients(K: float, T1: float, T2: float, T3: float) -> tuple[float, ...]:
    """Return a1, a2, b1, b2 of the yaw rate by rudder (3.3).

    They are those of (b1 s + b2)/(s^2 + a1 s + a2).
    """
    a2 = 1.0 / (T1 * T2)
    return 1.0 / T1 + 1.0 / T2, a2, K * T3 * a2, K * a2


def nomoto(f: Transfer) -> Nomoto:
    """Return the gains and time constants of a ship without wind (3.3). They leave out a3 and c3.

    Neutral straight-line stability (a2 = 0) leaves K and T1 infinite.
    """
    T1, T2 = time_constants(f.a1, f.a2)
    return Nomoto(
        K=_ratio(f.b2, f.a2),
        T1=T1,
        T2=T2,
        T3=_ratio(f.b1, f.b2),
        K_v=_ratio(f.c2, f.a2),
        T3v=_ratio(f.c1, f.c2),
    )


def _ratio(over: float, under: float) -> float:
    """Return a quotient, infinite or not a number where it divides by zero."""
    if under == 0.0:
        return math.copysign(math.inf, over) if over else math.nan
    return float(over / under)


def levers(F: Numbers, g: Numbers) -> tuple[float, float, float, float]:
    """Return lever arms of sway, yaw and rudder, and the margin of stability (3.4, 3.5).

    The margin is l_r - l_v: above zero the ship keeps a straight course. They are of F = [Y_v, Y_r
    - m u. N_v, N_r - m x_G u] and g.
    """
    l_v, l_r = _ratio(F[1, 0], F[0, 0]), _ratio(F[1, 1], F[0, 1])
    return l_v, l_r, _ratio(g[1], g[0]), l_r - l_v


class Scale(NamedTuple):
    """The units of a dimensionless system in SI."""

    time: float  # [s]
    speed: float  # [m/s]
    length: float  # [m]


def scale(system: str, length: float, speed: float) -> Scale:
    """Return the units of "prime" or "bis" (3.6)."""
    if system == "prime":
        return Scale(length / speed, speed, length)
    time = math.sqrt(length / GRAVITY_M_S2)
    return Scale(time, length / time, length)


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

"""The boat's equations about straight level flight as matrices: modes, and waves from ahead.

The engineer's programs judge by these matrices how a boat answers (``trainer report-1969 modes``,
``check``, ``gains``), and ``stability`` finds the longest step of an integrator. The slopes are
central differences of the core's own rates, so that they hold for every equation set.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import Boat
from trainer.core.rates import rates
from trainer.core.scheme import equations_alone
from trainer.core.sea.forces import wave_forces
from trainer.core.state import MOTION, new_scratch, new_state

CONTROLS = ("delta_r", "delta_s", "delta_b", "u_c")
# What the rates depend on; heading and position only follow.
INTERNAL_MOTION = ("u", "v", "w", "p", "q", "r", "phi", "theta")
LONGITUDINAL_MOTION = ("u", "w", "q", "theta")
BODY_VELOCITIES = MOTION[:6]
VERTICAL_MOTION = (*LONGITUDINAL_MOTION, "z")

Matrix = NDArray[np.float64]
MODE_GROUPS = {
    "surge": ("u",),
    "pitch": ("w", "q", "theta"),
    "roll": ("p", "phi"),
    "sway-yaw": ("v", "r"),
}
# [1/s] An eigenvalue this near the imaginary axis neither grows nor decays: it is as large as the
# difference quotients' own error.
NEUTRAL_TOLERANCE = 1e-7


@dataclass(frozen=True)
class LinearModel:
    """Matrices of d(motion)/dt = A motion + B controls, by MOTION and CONTROLS, SI."""

    A: Matrix
    B: Matrix

    def part(self, *names: str) -> Matrix:
        """Return A restricted to the named motions."""
        indices = [MOTION.index(name) for name in names]
        return self.A[np.ix_(indices, indices)]

    def inputs(self, names: tuple[str, ...], controls: tuple[str, ...]) -> Matrix:
        """Return B restricted to the named motions and controls."""
        rows = [MOTION.index(name) for name in names]
        return self.B[np.ix_(rows, [CONTROLS.index(name) for name in controls])]


def linearise(boat: Boat, nudge: float = 1e-5) -> LinearModel:
    """Return the matrices at the boat's present state, by central differences, exact solve.

    ``nudge`` [m/s, rad, rad/s, m] is the half width of a difference: small against any motion, and
    large against rounding.

    The terms with |.| have no second derivative at zero; their slope there is the mean of the two
    sides, as a small motion sees it.
    """
    vessel, compact, scheme, state, scratch = (record.copy() for record in boat.records)
    scheme = equations_alone(scheme)
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

    return LinearModel(
        np.column_stack([column(name) for name in MOTION]),
        np.column_stack([column(name) for name in CONTROLS]),
    )


def linearise_at_speed(boat: Boat, speed: float) -> LinearModel | None:
    """Return the matrices in trim at ``speed`` [m/s], None if there is no such trim."""
    if not boat.trimmed(speed):
        return None
    return linearise(boat)


def bring_to(boat: Boat, speed: float) -> bool:
    """Return whether ``boat`` trims at ``speed`` [m/s]; its state is that trim, else level flight.

    Level flight without trim: planes at zero, forces unbalanced.
    """
    if boat.trimmed(speed):
        return True
    s = boat.state
    for name in ("v", "w", "phi", "theta", "delta_r", "delta_s", "delta_b"):
        s[name] = 0.0
    s.u = s.u_c = speed
    return False


def head_waves(boat: Boat, omega: float, depth: float, speed: float) -> NDArray[np.complex128]:
    """Return the forces [N, N m] of regular waves from ahead, of amplitude 1 m.

    At a wave phase A at the origin they are the real part of the result times exp(i A). ``speed``
    [m/s] is that at which the hull's lift feels the water's own motion: 0 leaves it out.
    """
    parts = []
    for elevation, quadrature in ((1.0, 0.0), (0.0, 1.0)):
        state, force = new_state(), np.zeros(6)
        s = state[0]
        # 4 m: the filter's outputs are of variance 1, and a significant height is 4 deviations
        s.sea_1969, s.sea_height, s.sea_omega, s.sea_direction = 1.0, 4.0, omega, math.pi
        s.sea_elevation, s.sea_quadrature, s.z, s.u = elevation, quadrature, depth, speed
        wave_forces(boat.records.vessel, new_scratch(), state, force)
        parts.append(force)
    return np.asarray(parts[0] - 1j * parts[1])


def head_wave_response(
    boat: Boat, forces: NDArray[np.complex128], omega: float
) -> tuple[float, float]:
    """Return heave [-] and pitch [rad/m] over the amplitude of regular waves from ahead.

    Linear, planes fixed, about the boat's present trim in deep water; ``forces`` [N, N m] are
    those of ``head_waves`` of frequency ``omega`` [rad/s].
    """
    linear = linearise(boat)
    vessel, compact, scheme, state, scratch = (record.copy() for record in boat.records)
    scheme = equations_alone(scheme)
    scheme["exact"] = 1
    rates(vessel, compact, scheme, state, scratch)
    still = state["rates"][0].copy()
    pushed = np.zeros(len(VERTICAL_MOTION), complex)
    indices = [MOTION.index(name) for name in VERTICAL_MOTION]
    for part, unit in ((forces.real, 1.0), (forces.imag, 1j)):
        scratch["external"][0] = part
        rates(vessel, compact, scheme, state, scratch)
        pushed += unit * (state["rates"][0] - still)[indices]
    # the frequency at which a boat under way meets waves from ahead, in deep water
    met = omega + omega * omega / float(boat.vessel.g) * float(boat.state.u)
    motion = np.linalg.solve(
        1j * met * np.eye(len(VERTICAL_MOTION)) - linear.part(*VERTICAL_MOTION), pushed
    )
    return float(abs(motion[VERTICAL_MOTION.index("z")])), float(
        abs(motion[VERTICAL_MOTION.index("theta")])
    )


@dataclass(frozen=True)
class RateResponse:
    """The boat's scheme gives rates = J motion + G last rates, in ``names``, SI.

    With the exact solve G is zero. With lagged accelerations, each equation takes the others' rates
    of the cycle before, and G says how they come in.
    """

    names: tuple[str, ...]
    J: Matrix
    G: Matrix

    @cached_property
    def nature(self) -> Matrix:
        """Return A of d(motion)/dt = A motion, accelerations satisfying all equations at once."""
        return np.asarray(np.linalg.solve(np.eye(len(self.J)) - self.G, self.J))

    @cached_property
    def eigenvalues(self) -> NDArray[np.complex128]:
        """Return the eigenvalues [1/s] of the boat itself, whatever integrates it."""
        return np.asarray(np.linalg.eigvals(self.nature), complex)


def measure_response(boat: Boat, nudge: float = 1e-5) -> RateResponse:
    """Return how the rates follow motion and last rates about the boat's present state.

    ``nudge`` is as in ``linearise``.
    """
    vessel, compact, scheme, state, scratch = (record.copy() for record in boat.records)
    scheme = equations_alone(scheme)
    names = LONGITUDINAL_MOTION if boat.method.equations == "longitudinal" else INTERNAL_MOTION
    indices = [MOTION.index(name) for name in names]

    def slope(field: str, index: int, size: float) -> Matrix:
        state["rates"] = 0.0
        centre = float(state[field][0, index])
        ends = []
        for side in (size, -size):
            state["rates"] = 0.0
            state[field][0, index] = centre + side
            rates(vessel, compact, scheme, state, scratch)
            ends.append(state["rates"][0, indices])
        state[field][0, index] = centre
        return np.asarray((ends[0] - ends[1]) / (2.0 * size))

    J = np.column_stack([slope("motion", index, nudge) for index in indices])
    G = np.zeros_like(J)
    if boat.method.rates == "lagged":
        for column, name in enumerate(names):
            if name in BODY_VELOCITIES:  # the rates are linear in them: any size does
                G[:, column] = slope("rates", indices[column], 1.0)
    return RateResponse(names, J, G)


@dataclass(frozen=True)
class Mode:
    """One real eigenvalue or one pair, real + i imaginary [1/s]."""

    name: str
    real: float
    imaginary: float  # not negative

    @property
    def eigenvalue(self) -> complex:
        """Return the eigenvalue [1/s] in the upper half plane."""
        return complex(self.real, self.imaginary)

    @property
    def stable(self) -> bool:
        """Return whether the boat itself damps this mode."""
        return decays(self.eigenvalue)

    @property
    def period(self) -> float | None:
        """Return the period [s] of one swing, None if it does not swing."""
        return 2.0 * math.pi / self.imaginary if self.imaginary > 0.0 else None

    @property
    def damping_ratio(self) -> float | None:
        """Return -Re/|.| [-], None if it does not swing."""
        return -self.real / abs(self.eigenvalue) if self.imaginary > 0.0 else None

    @property
    def time_constant(self) -> float | None:
        """Return the time [s] of change by a factor e. None: there is no change."""
        return 1.0 / abs(self.real) if abs(self.real) > NEUTRAL_TOLERANCE else None


def decays(eigenvalue: complex) -> bool:
    """Return whether ``eigenvalue`` [1/s] decays: more than differences can err."""
    return eigenvalue.real < -NEUTRAL_TOLERANCE


def mode_group(names: tuple[str, ...], shares: NDArray[np.float64]) -> str:
    """Return the motion that takes part most, given the share of each of ``names``."""
    part = dict(zip(names, shares, strict=True))
    return max(
        MODE_GROUPS, key=lambda motion: sum(part.get(name, 0.0) for name in MODE_GROUPS[motion])
    )


def _name(names: tuple[str, ...], shares: NDArray[np.float64], imaginary: float) -> str:
    """Return the name of one mode; a real one of the vertical plane is heave if w leads in it."""
    motion = mode_group(names, shares)
    if motion == "pitch" and imaginary == 0.0:
        part = dict(zip(names, shares, strict=True))
        return "heave" if part["w"] > part["q"] + part["theta"] else "pitch"
    return motion


def modes(matrix: Matrix, names: tuple[str, ...]) -> list[Mode]:
    """Return the modes of d(motion)/dt = ``matrix`` motion, by motion and then fastest first.

    Each is named by the motion with the largest participation, |left| |right| eigenvector. Of two
    real ones of sway and yaw the slower is the spiral.
    """
    values, right = np.linalg.eig(matrix)
    shares = abs(right) * abs(np.linalg.pinv(right)).T
    named = [
        Mode(_name(names, shares[:, i], value.imag), float(value.real), float(value.imag))
        for i, value in enumerate(values)
        if value.imag >= 0.0
    ]
    turning = [mode for mode in named if mode.name == "sway-yaw" and mode.imaginary == 0.0]
    if len(turning) > 1:
        slowest = min(turning, key=lambda mode: abs(mode.real))
        named[named.index(slowest)] = Mode("spiral", slowest.real, 0.0)
    order = ("surge", "heave", "pitch", "sway-yaw", "spiral", "roll")
    return sorted(named, key=lambda mode: (order.index(mode.name), -abs(mode.eigenvalue)))

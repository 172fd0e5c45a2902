"""The natural modes of a boat: eigenvalues with a name, a period and a damping."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trainer.study.linear import Matrix

GROUPS = {
    "surge": ("u",),
    "pitch": ("w", "q", "theta"),
    "roll": ("p", "phi"),
    "sway-yaw": ("v", "r"),
}
# [1/s] An eigenvalue this near the imaginary axis neither grows nor decays: it is as large as the
# difference quotients' own error.
NEUTRAL = 1e-7


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
        return damped(self.eigenvalue)

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
        """Return the time [s] of change by a factor e, None if there is no change."""
        return 1.0 / abs(self.real) if abs(self.real) > NEUTRAL else None


def damped(eigenvalue: complex) -> bool:
    """Return whether ``eigenvalue`` [1/s] decays."""
    return eigenvalue.real < -NEUTRAL


def group(names: tuple[str, ...], shares: NDArray[np.float64]) -> str:
    """Return the motion that takes part most, given the share of each of ``names``."""
    part = dict(zip(names, shares, strict=True))
    return max(GROUPS, key=lambda motion: sum(part.get(name, 0.0) for name in GROUPS[motion]))


def _name(names: tuple[str, ...], shares: NDArray[np.float64], imaginary: float) -> str:
    """Return the name of one mode; a real one of the vertical plane is heave if w leads in it."""
    motion = group(names, shares)
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
    found = [
        Mode(_name(names, shares[:, i], value.imag), float(value.real), float(value.imag))
        for i, value in enumerate(values)
        if value.imag >= 0.0
    ]
    turning = [mode for mode in found if mode.name == "sway-yaw" and mode.imaginary == 0.0]
    if len(turning) > 1:
        slowest = min(turning, key=lambda mode: abs(mode.real))
        found[found.index(slowest)] = Mode("spiral", slowest.real, 0.0)
    order = ("surge", "heave", "pitch", "sway-yaw", "spiral", "roll")
    return sorted(found, key=lambda mode: (order.index(mode.name), -abs(mode.eigenvalue)))

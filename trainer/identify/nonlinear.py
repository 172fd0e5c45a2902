"""Large manoeuvres from linear constants and one number more, kappa (MI 12).

r - kappa K |r| r = K delta is the steady turn: kappa > 0 damps the stable ship (K < 0) and closes
the loop of the unstable one (K > 0). All in SI, rad and s.
"""

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.kernels.nonlinear_steering import run_bent
from trainer.identify.measurements import Record
from trainer.identify.sampled import STEP

FINE: Final = 0.05  # [-] of the smallest time constant: a step of Runge and Kutta
CLOSE: Final = 1e-10  # [-] relative step at which a fit has come to its end
MOST: Final = 100  # steps of a fit


@dataclass(frozen=True)
class Bent:
    """A ship with linear constants and kappa."""

    K: float  # [1/s]
    T1: float  # [s]
    T2: float  # [s]
    T3: float  # [s]
    kappa: float  # [s^2]
    delta_0: float = 0.0  # [rad] residual helm

    @property
    def numbers(self) -> Numbers:
        """Return the constants as the kernels take them."""
        return np.array([self.K, self.T1, self.T2, self.T3, self.kappa, self.delta_0])

    @property
    def loop(self) -> tuple[float, float, float] | None:
        """Return an unstable ship's rate at zero helm [rad/s], and the spiral's fold (12.2).

        The fold is a rate [rad/s] and a helm [rad]. None for a ship that has no loop.
        """
        if self.kappa * self.K <= 0.0:
            return None
        rate = 1.0 / (self.kappa * self.K)
        return rate, 0.5 * rate, 0.25 * rate / self.K

    def helm(self, rate: Numbers) -> Numbers:
        """Return the rudder [rad] that holds steady ``rate`` [rad/s] (12.1)."""
        return (rate - self.kappa * self.K * np.abs(rate) * rate) / self.K + self.delta_0

    def rates(self, helm: float) -> tuple[float, ...]:
        """Return all yaw rates [rad/s] that are steady under a rudder [rad], rising (12.1).

        Two to each side at most; of three the middle one does not last.
        """
        pull, bend = self.K * (helm - self.delta_0) + 0.0, self.kappa * self.K
        if bend == 0.0:
            return (pull,)
        found = {
            root.real + 0.0
            for side in (1.0, -1.0)
            for root in np.roots([-side * bend, 1.0, -pull])
            if root.imag == 0.0 and side * root.real >= 0.0
        }
        return tuple(sorted(map(float, found)))


def predict(ship: Bent, rudder: Numbers, step: float, start: Numbers) -> Numbers:
    """Return yaw rate [rad/s] and heading [rad] (n, 2) under ``rudder`` (n,) [rad].

    ``start``: yaw rate and heading at the first sample; the ship is in steady change there.
    """
    found = _run(ship.numbers.astype(complex), rudder, step, start.astype(complex))
    return np.asarray(found[:, 1:].real)


def _run(
    ship: NDArray[np.complex128], rudder: Numbers, step: float, start: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Return (z, r, psi) at each sample (n, 3); r' is zero at the first."""
    K, T1, T2, T3 = ship[:4]
    z = (T1 + T2) * start[0] - K * T3 * (rudder[0] - ship[5])
    fastest = FINE * min(abs(T1.real), abs(T2.real))
    parts = max(1, math.ceil(step / fastest))
    out = np.empty((len(rudder), 3), complex)
    run_bent(ship, np.array([z, *start]), rudder, step, parts, out)
    return out


@dataclass(frozen=True)
class Bend:
    """A ship with the kappa that was found, and its standard deviation [s^2]."""

    ship: Bent
    deviation: float


def kappa_from_turns(ship: Bent, rudder: Numbers, rate: Numbers) -> Bend:
    """Return ``ship`` with the kappa of steady turns, a spiral or turning circles (12.1).

    ``rudder`` (n,) [rad] and ``rate`` (n,) [rad/s]; least squares in helm, by rate squared.
    ConfigError with fewer than two turns.
    """
    turning = np.abs(rate) > 0.0
    if np.count_nonzero(turning) < 2:
        raise ConfigError("kappa needs two steady turns or more")
    r, delta = rate[turning], rudder[turning] - ship.delta_0
    bend, rest = np.abs(r) * r, r / ship.K - delta
    kappa = float(bend @ rest) / float(bend @ bend)
    left = rest - kappa * bend
    variance = float(left @ left) / (len(left) - 1)
    return Bend(replace(ship, kappa=kappa), math.sqrt(variance / float(bend @ bend)))


def kappa_from_record(ship: Bent, record: Record) -> Bend:
    """Return ``ship`` with the kappa that predicts the yaw rate of a manoeuvre best.

    From the ship's kappa, together with yaw rate and residual helm at the start: Gauss-Newton with
    exact derivatives. ConfigError if the interval varies, or no kappa is any better.
    """
    step = record.interval
    if np.ptp(np.diff(record.t)) > 1e-6 * step:
        raise ConfigError(f"{record.source}: kappa is fitted at one interval; this one varies")
    rudder, rate = record.column("rudder"), record.column("yaw_rate")
    known = ~np.isnan(rate)
    guess = np.array(
        [
            ship.kappa or 1.0 / (ship.K * float(np.nanmax(np.abs(rate)))) * 0.1,
            rate[known][0],
            ship.delta_0,
        ]
    )
    scale = np.array([1.0 / abs(ship.K) / float(np.nanmax(np.abs(rate))), 0.01, 0.01])
    found, spread = _least_squares(ship, (rudder, step), rate, (guess, scale))
    return Bend(replace(ship, kappa=float(found[0]), delta_0=float(found[2])), spread)


def _errors(
    ship: Bent, drive: tuple[Numbers, float], rate: Numbers, theta: NDArray[np.complex128]
) -> NDArray[np.complex128]:
    """Return what is left of the known yaw rates for kappa, first rate and residual helm."""
    numbers = ship.numbers.astype(complex)
    numbers[4], numbers[5] = theta[0], theta[2]
    run = _run(numbers, *drive, np.array([theta[1], 0.0]))
    return np.asarray((rate - run[:, 1])[~np.isnan(rate)])


def _least_squares(
    ship: Bent, drive: tuple[Numbers, float], rate: Numbers, begin: tuple[Numbers, Numbers]
) -> tuple[Numbers, float]:
    """Return the best (kappa, first rate, residual helm) and the deviation of kappa."""
    theta, scale = begin
    error = _errors(ship, drive, rate, theta.astype(complex)).real
    damping = 1e-3
    for _ in range(MOST):
        aside = theta + 1j * STEP * np.diag(scale)
        J = np.column_stack([_errors(ship, drive, rate, row).imag / STEP for row in aside])
        gram = J.T @ J
        move = -scale * np.linalg.solve(gram + damping * np.diag(np.diag(gram)), J.T @ error)
        trial = _errors(ship, drive, rate, (theta + move).astype(complex)).real
        if np.isfinite(trial).all() and trial @ trial <= error @ error:
            theta, error, damping = theta + move, trial, 0.1 * damping
            if np.max(np.abs(move / scale)) < CLOSE:
                break
        elif damping > 1e9:
            break
        else:
            damping *= 10.0
    variance = float(error @ error) / max(len(error) - 3, 1)
    spread = float(np.sqrt(variance * np.linalg.inv(gram)[0, 0])) * scale[0]
    return theta, spread

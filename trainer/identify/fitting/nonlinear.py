"""Large manoeuvres from linear constants and the helm of steady turns (model document 12).

``judge/validation`` asks for ``trainer identify --kappa``, ``--bech`` and ``--spiral``. Numbers in
brackets are equations of the model document (MI). H(r) = H1 r + H2 |r| r + H3 r^3 is the helm that
holds the yaw rate r: Bech's reversed spiral. With H1 = 1/K, H2 = -kappa, H3 = 0 it is r - kappa K
|r| r = K delta: kappa > 0 damps the stable ship (K < 0) and closes the loop of the unstable one (K
> 0). All in SI, rad and s.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.kernels.nonlinear_steering import BENT, run_bent
from trainer.identify.model.sampled import COMPLEX_STEP
from trainer.identify.record.measurements import Record, lines_between

FINE_STEP_SHARE: Final = 0.05  # [-] of the smallest time constant: a step of Runge and Kutta
FIT_TOLERANCE: Final = 1e-12  # [-] relative change at which a fit has come to its end
HELM_TOLERANCE_RAD: Final = 1e-12  # [rad] helm that is exact
MAX_CONDITION: Final = 1e8  # [-] condition of derivatives from which numbers are not told apart
LINEAR_NAMES: Final = ("K", "T1", "T2", "T3")
CURVE_NAMES: Final = ("H1", "H2", "H3")
CURVE_SHAPES: Final = ((0,), (0, 1), (0, 2), (0, 1, 2))  # terms of H(r) that turns choose among


@dataclass(frozen=True)
class BentShip:
    """A ship whose helm of steady turns bends with the yaw rate.

    It has linear constants and kappa, or ``H`` for 1/K, -kappa, 0.
    """

    K: float  # [1/s]
    T1: float  # [s]
    T2: float  # [s]
    T3: float  # [s]
    kappa: float = 0.0  # [s^2]
    delta_0: float = 0.0  # [rad] residual helm
    H: tuple[float, float, float] | None = None  # [s], [s^2], [s^3]

    @property
    def curve(self) -> tuple[float, float, float]:
        """Return H1 [s], H2 [s^2] and H3 [s^3]."""
        return self.H or (1.0 / self.K, -self.kappa, 0.0)

    @property
    def numbers(self) -> Any:
        """Return the constants as the kernels take them."""
        return np.array([self.K, self.T1, self.T2, self.T3, *self.curve, self.delta_0])

    @property
    def loop(self) -> tuple[float, float, float] | None:
        """Return an unstable ship's rate at zero helm [rad/s], and the spiral's fold (12.2).

        The fold is a rate [rad/s] and a helm [rad]. None for a ship that has no loop.
        """
        H1, H2, H3 = self.curve
        rate, fold = _least_root(H1, H2, H3), _least_root(H1, 2.0 * H2, 3.0 * H3)
        if rate is None or fold is None:
            return None
        return rate, fold, abs(float(self.helm(np.array([fold]))[0]) - self.delta_0)

    def helm(self, rate: Numbers) -> Numbers:
        """Return the rudder [rad] that holds steady ``rate`` [rad/s] (12.1)."""
        return np.asarray(_powers(rate) @ self.curve + self.delta_0)

    def rates(self, helm: float) -> tuple[float, ...]:
        """Return all yaw rates [rad/s] that are steady under a rudder [rad], rising (12.1).

        Of three the middle one is unstable.
        """
        H1, H2, H3 = self.curve
        roots = {
            float(root.real) + 0.0
            for side in (1.0, -1.0)
            for root in np.roots([H3, side * H2, H1, self.delta_0 - helm])
            # |r| r has the sign of r: of either sign's cubic only the roots of that sign count
            if abs(root.imag) <= HELM_TOLERANCE_RAD * abs(root) and side * root.real >= 0.0
        }
        return tuple(sorted(roots))

    def changed(self, names: Sequence[str], values: Sequence[Any]) -> "BentShip":
        """Return the ship with other numbers, linear or of its curve, by name."""
        numbers_by_name = dict(zip(names, values, strict=True))
        curve = [
            numbers_by_name.pop(name, own)
            for name, own in zip(CURVE_NAMES, self.curve, strict=True)
        ]
        whole = any(name in CURVE_NAMES for name in names) or self.H is not None
        return replace(self, H=(curve[0], curve[1], curve[2]) if whole else None, **numbers_by_name)


def _least_root(a: float, b: float, c: float) -> float | None:
    """Return the least positive root of a + b x + c x^2; None if there is none."""
    roots = np.roots([c, b, a])
    positive_roots = [
        float(x.real) for x in roots if abs(x.imag) <= HELM_TOLERANCE_RAD * abs(x) and x.real > 0.0
    ]
    return min(positive_roots, default=None)


def _powers(rate: Numbers) -> Numbers:
    """Return r, |r| r and r^3 (n, 3)."""
    return np.column_stack([rate, np.abs(rate) * rate, rate**3])


def predict_turning(ship: BentShip, record: Record, start: Numbers) -> Numbers:
    """Return yaw rate [rad/s] and heading [rad] (n, 2) under a record's rudder.

    ``start`` has yaw rate and heading at the first sample, where the yaw rate is taken as constant.
    """
    return np.asarray(_run(ship, record, start.astype(complex))[:, 1:].real)


def _run(ship: BentShip, record: Record, start: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return (z, r, psi) at each sample (n, 3); r' is zero at the first."""
    rudder, step = record.column("rudder"), record.interval
    numbers = ship.numbers.astype(complex)
    K, T1, T2, T3 = numbers[:4]
    z = (T1 + T2) * start[0] - K * T3 * (rudder[0] - numbers[BENT.delta_0])
    # a search may try a time constant near zero: 1e4 bounds the steps
    fastest = FINE_STEP_SHARE * min(abs(T1.real), abs(T2.real))
    parts = max(1, math.ceil(min(step / fastest, 1e4)))
    out = np.empty((len(rudder), 3), complex)
    helm = np.hstack(lines_between(record.t, rudder[:, None], record.between_readings))
    run_bent(numbers, np.array([z, *start]), helm, step, parts, out)
    return out


@dataclass(frozen=True)
class BendEstimate:
    """A ship with the numbers that were found, and their standard deviations, SI."""

    source: str
    ship: BentShip
    deviations: dict[str, float]
    rms: float  # what is left: of helm [rad] by turns, of yaw rate [rad/s] by a record
    rate_0: float | None = None  # [rad/s] at the start of the record; None by turns


def curve_from_turns(ship: BentShip, source: str, rudder: Numbers, rate: Numbers) -> BendEstimate:
    """Return ``ship`` with the H(r) of steady turns, a spiral or turning circles (12.1).

    ``rudder`` (n,) [rad] and ``rate`` (n,) [rad/s]. Least squares of the helm, with a residual
    helm; Schwarz's criterion chooses the terms of H(r). ConfigError with fewer than four turns.
    """
    known = ~np.isnan(rate) & ~np.isnan(rudder)
    rate, rudder = rate[known], rudder[known]
    if len(np.unique(rate)) < 4:
        raise ConfigError(f"{source}: H(r) needs four steady turns or more; it has {len(rate)}")
    tried = [_regress(shape, rudder, rate) for shape in CURVE_SHAPES if len(shape) + 1 < len(rate)]
    _, names, values, deviations, rms = min(tried, key=lambda one: one[0])
    turned = ship.changed(CURVE_NAMES, (0.0, 0.0, 0.0)).changed(names, list(map(float, values)))
    return BendEstimate(source, turned, dict(zip(names, map(float, deviations), strict=True)), rms)


def _regress(
    shape: tuple[int, ...], rudder: Numbers, rate: Numbers
) -> tuple[float, list[str], Numbers, Numbers, float]:
    """Return Schwarz's criterion, names, numbers, deviations and rms of helm [rad] of a shape."""
    count, scale = len(rate), float(np.max(np.abs(rate)))
    terms = np.column_stack([_powers(rate / scale)[:, shape], np.ones(count)])
    solution = np.linalg.lstsq(terms, rudder, rcond=None)[0]
    square = max(float(np.sum((rudder - terms @ solution) ** 2)), count * HELM_TOLERANCE_RAD**2)
    variance = square / (count - len(solution)) * np.diag(np.linalg.pinv(terms.T @ terms))
    unit = np.array([*(scale ** -(index + 1.0) for index in shape), 1.0])
    names = [*(CURVE_NAMES[index] for index in shape), "delta_0"]
    criterion = count * math.log(square / count) + len(solution) * math.log(count)
    return criterion, names, solution * unit, np.sqrt(variance) * unit, math.sqrt(square / count)


@dataclass(frozen=True, eq=False)
class _Records:
    """Yaw rates to be predicted by a ship whose numbers ``free`` are sought.

    These numbers are common to all records. Each record has its own residual helm and its own yaw
    rate at the start.
    """

    ship: BentShip
    records: Sequence[Record]
    free: tuple[str, ...]

    @property
    def start(self) -> Numbers:
        """Return the numbers to begin from (p,): the ship's own."""
        names = (*LINEAR_NAMES, *CURVE_NAMES, "kappa")
        numbers = (*self.ship.numbers[:7], self.ship.kappa)
        numbers_by_name = dict(zip(names, numbers, strict=True))
        rates = [record.column("yaw_rate") for record in self.records]
        starts = [x for rate in rates for x in (rate[~np.isnan(rate)][0], self.ship.delta_0)]
        return np.array([*(numbers_by_name[name] for name in self.free), *starts])

    def errors(self, theta: Any) -> NDArray[np.complex128]:
        """Return what is left of the known yaw rates, record by record."""
        count, residuals = len(self.free), []
        for i, record in enumerate(self.records):
            first, helm = theta[count + 2 * i : count + 2 * i + 2]
            ship = self.ship.changed([*self.free, "delta_0"], [*theta[:count], helm])
            start = np.array([first, 0.0], complex)
            with np.errstate(all="ignore"):  # of trials that go astray
                run = _run(ship, record, start)
            rate = record.column("yaw_rate")
            residuals.append((rate - run[:, 1])[~np.isnan(rate)])
        return np.concatenate(residuals)

    def value(self, theta: Numbers) -> Numbers:
        """Return the errors (n,) [rad/s]."""
        return np.asarray(self.errors(theta).real)

    def slopes(self, theta: Numbers) -> Numbers:
        """Return their exact derivatives (n, p)."""
        aside = theta + 1j * COMPLEX_STEP * np.eye(len(theta))
        return np.column_stack([self.errors(row).imag / COMPLEX_STEP for row in aside])


def bend_from_records(
    ship: BentShip, records: Sequence[Record], free: tuple[str, ...] = ("kappa",)
) -> BendEstimate:
    """Return ``ship`` with the numbers ``free`` that predict the yaw rates of records best.

    The deviations assume that errors are white and of one size. The residual helm returned is the
    last record's. ConfigError if an interval varies, or the records do not determine the numbers.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 - an extra, imported on use

    for record in records:
        if np.ptp(np.diff(record.t)) > 1e-6 * record.interval:
            raise ConfigError(f"{record.source}: H(r) is fitted at one interval; this one varies")
    problem, source = _Records(ship, records, free), records[-1].source
    with np.errstate(all="ignore"):
        solution = least_squares(
            problem.value,
            problem.start,
            problem.slopes,
            x_scale="jac",
            xtol=FIT_TOLERANCE,
            ftol=FIT_TOLERANCE,
            gtol=None,
        )
    size = np.linalg.norm(solution.jac, axis=0)
    unit = solution.jac / np.maximum(size, 1e-300)
    if not solution.success or np.linalg.cond(unit) > MAX_CONDITION:
        raise ConfigError(f"{source}: this record does not tell {', '.join(free)}")
    variance = 2.0 * solution.cost / max(len(solution.fun) - len(size), 1)
    widths = np.sqrt(variance * np.diag(np.linalg.inv(unit.T @ unit))) / size
    names, indices = [*free, "delta_0"], [*range(len(free)), -1]
    return BendEstimate(
        source,
        ship.changed(names, [float(solution.x[index]) for index in indices]),
        {name: float(widths[index]) for name, index in zip(names, indices, strict=True)},
        math.sqrt(2.0 * solution.cost / len(solution.fun)),
        float(solution.x[-2]),
    )

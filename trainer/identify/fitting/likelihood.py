"""The costs of a problem: minus a log-likelihood, by covariances or by a predictor's errors.

``study_problem`` chooses one by the study's noise. Where it is "covariance" the sums over the
samples are compiled, in ``kernels/sensitivity`` (model document, 6.1, 6.3 and 8.1). Else there is a
predictor: output error, innovations, several steps (6.2-6.5). Where the model does not give the
errors' covariance, the best one is put in its place. So the second derivatives of a cost are the
inverse covariance of the estimates (8.3). Where a model is impossible (a covariance not positive
definite) the cost is infinite, so that a search turns back.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.fitting.problem import Problem
from trainer.identify.kernels.covariance_filter import (
    FLAG_COUNTED,
    FilterRun,
    FixedGain,
    SampledSystem,
    run_predictor,
    show_filter,
)
from trainer.identify.kernels.kernel import Complexes, Entries
from trainer.identify.kernels.sensitivity import ScoreRows, score_rows
from trainer.identify.model.sampled import COMPLEX_STEP, SampledSystems
from trainer.identify.record.measurements import Samples

LOG_2_PI: Final = math.log(2.0 * math.pi)
EIGENVALUE_SLACK: Final = 1e-9  # [-] below zero, that rounding may bring an eigenvalue
PIECE_ROWS: Final = 256  # rows that are multiplied at once
FLAG_REASONS: Final = ("counted", "missing", "rejected", "singular")
Gains = Callable[[Problem, SampledSystems], Complexes | None]
MAX_GAIN_STEPS: Final = 5000  # of the iteration for the settled gain
COVARIANCE_TOLERANCE: Final = 1e-13  # [-] relative change of P at which it has settled


def possible(sampled: SampledSystems) -> bool:
    """Return whether the system is finite and P(t0) of the first row positive semidefinite.

    A search may try parameters that are no model; it turns back where this is false.
    """
    system = sampled.at(0)
    if not all(np.isfinite(part).all() for part in system):
        return False
    P = system.start[:, 1:]
    width = np.sqrt(np.maximum(np.diag(P), 1e-300))
    sizes = np.linalg.eigvalsh(P / np.outer(width, width))
    return bool(sizes[0] >= -EIGENVALUE_SLACK)


def _gram(rows: Numbers) -> Numbers:
    """Return the matrix of inner products of the columns of ``rows``, piece by piece.

    A piece is too small for the library to hand it to several threads, whose waking costs more.
    """
    count = rows.shape[1]
    total = np.zeros((count, count))
    for first in range(0, len(rows), PIECE_ROWS):
        piece = rows[first : first + PIECE_ROWS]
        total += piece.T @ piece
    return total


class Score(NamedTuple):
    """Cost and gradient at a point, and the rows whose squares are the information."""

    cost: float
    gradient: Numbers
    rows: tuple[tuple[Numbers, Numbers], ...]  # of each run, as wide as Sampled.slopes


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Minus the log-likelihood by covariances: a cost to minimise over a problem's parameters.

    The cost of several runs is the sum of theirs.
    """

    problem: Problem
    _last: dict[str, Any] = field(default_factory=dict, init=False, repr=False)

    def value(self, theta: Numbers) -> float:
        """Return -log L [-]."""
        runs = ((run, run.sampled(theta[at])) for run, at in self.problem.runs)
        return sum(_score(run, sampled).cost for run, sampled in runs)

    def slope(self, theta: Numbers) -> tuple[float, Numbers]:
        """Return the cost and its exact gradient (f,)."""
        score = self._score(theta)
        return score.cost, score.gradient

    def information(self, theta: Numbers) -> Numbers:
        """Return the expected information (f, f); not a number where the model is impossible."""
        score = self._score(theta)
        if not math.isfinite(score.cost):
            return np.full((len(theta), len(theta)), math.nan)
        total = np.zeros((len(theta), len(theta)))
        for rows, (_, at) in zip(score.rows, self.problem.runs, strict=True):
            for part in rows:
                total[np.ix_(at, at)] += _gram(part)[: len(at), : len(at)]
        return total * np.outer(self.problem.scale, self.problem.scale)

    def _score(self, theta: Numbers) -> Score:
        """Return cost, gradient and rows at ``theta``, from memory if it is the last point.

        A search asks for gradient and information of the same point, one after the other.
        """
        key = theta.tobytes()
        if self._last.get("key") != key:
            runs = [_score(run, run.sloped(theta[at])) for run, at in self.problem.runs]
            gradient = np.zeros(len(theta))
            for one, (_, at) in zip(runs, self.problem.runs, strict=True):
                gradient[at] += one.gradient
            cost = sum(one.cost for one in runs)
            score = Score(cost, gradient, tuple(rows for one in runs for rows in one.rows))
            self._last.update(key=key, score=score)
        last_score: Score = self._last["score"]
        return last_score


def _score(problem: Problem, sampled: SampledSystems) -> Score:
    """Return cost, gradient and rows of one run; the last two are empty without slopes."""
    samples, count = problem.samples, len(sampled.start) - 1
    impossible = Score(math.inf, np.full(count, math.nan), ())
    if not possible(sampled):
        return impossible
    length, readings = samples.outputs.shape
    slopes = sampled.slopes()
    wide = slopes.mean.shape[-1]  # with the zeros that fill up the processor's lanes
    errors, covariances = (np.empty((length, n, wide)) for n in (readings, readings * readings))
    slope = np.empty(wide)
    out = ScoreRows(errors, covariances, slope)
    stages, cost = score_rows(sampled.at(0), slopes, samples.table, samples.steps[1], out)
    if not stages:
        return impossible
    constant = 0.5 * np.count_nonzero(~np.isnan(samples.outputs)) * LOG_2_PI
    rows = errors.reshape(-1, max(wide, 1)), covariances[:stages].reshape(-1, max(wide, 1))
    return Score(float(cost + constant), slope[:count] * problem.scale[:count], (rows,))


@dataclass(frozen=True, eq=False)
class PredictionRun:
    """The filter's run over a record; errors are NaN where a reading is missing."""

    states: Numbers  # (n, x) predicted from the samples before, SI
    predictions: Numbers  # (n, y)
    errors: Numbers  # (n, y) reading less prediction
    covariances: Numbers  # (n, x, x) P of the states
    spreads: Numbers  # (n, y, y) R, their covariance
    squares: Numbers  # (n,) error' R^-1 error
    flags: NDArray[np.int64]  # (n,) indices in FLAG_REASONS

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Return which samples the losses are made of (n,)."""
        return np.asarray(self.flags == int(FLAG_COUNTED))

    @property
    def standardised(self) -> Numbers:
        """Return errors divided by the Cholesky factor of R (n, y). NaN where one is missing."""
        scaled_errors = np.full_like(self.errors, np.nan)
        whole = self.counted & ~np.isnan(self.errors).any(axis=1)
        roots = np.linalg.cholesky(self.spreads[whole])
        scaled_errors[whole] = np.linalg.solve(roots, self.errors[whole][..., None])[..., 0]
        return scaled_errors


def no_limits(readings: int) -> Numbers:
    """Return limits (y+1,) that reject nothing."""
    return np.full(readings + 1, np.inf)


def chi_square_limits(probability: float, readings: int) -> Numbers:
    """Return limits (y+1,) that a good sample exceeds with ``probability`` (MI 6.5).

    They are of the chi-square distribution, with as many degrees of freedom as there are readings.
    """
    from scipy.special import chdtri  # noqa: PLC0415 - an extra, imported on use

    return np.array([math.inf, *(chdtri(count, probability) for count in range(1, readings + 1))])


def run_filter(problem: Problem, theta: Numbers, limits: Numbers) -> PredictionRun:
    """Return the filter's run with ``theta`` (f,); ``limits`` (y+1,) as chi_square_limits."""
    return filter_samples(problem.sampled(theta).at(0), problem.samples, limits)


def filter_samples(system: SampledSystem, samples: Samples, limits: Numbers) -> PredictionRun:
    """Return the filter's run by a system's mean, noise and start, real or complex."""
    (count, readings), states = samples.outputs.shape, len(system.start)
    rows, kind = states + readings, system.mean.dtype
    out = np.empty((count, rows + readings + 2), kind)
    covariances = np.empty((count, states, states), kind)
    spreads = np.empty((count, readings, readings), kind)
    run = FilterRun(out, covariances, spreads)
    show_filter(system, samples.table, samples.steps[1], limits, run)
    return PredictionRun(
        out[:, :states],
        out[:, states:rows],
        out[:, rows : rows + readings],
        covariances,
        spreads,
        out[:, -2],
        out[:, -1].real.astype(np.int64),
    )


def loss_1(errors: Numbers) -> float:
    """Return V1 = (1/n) log det of the sum of error error' (6.3).

    The page compares it one step ahead with that by rudder alone.
    """
    whole = errors[~np.isnan(errors).any(axis=1)]
    sign, size = np.linalg.slogdet(whole.T @ whole)
    return float(size) / len(whole) if len(whole) and sign > 0.0 else math.nan


def no_gain(problem: Problem, sampled: SampledSystems) -> Complexes:
    """Return zero gains (b, x, y). The model runs alone, all error is in the readings."""
    batch, states = sampled.start.shape[:2]
    return np.zeros((batch, states, problem.samples.outputs.shape[1]), complex)


def settled_gain(problem: Problem, sampled: SampledSystems) -> Complexes | None:
    """Return the gains (b, x, y) that the filter settles at. None if it does not.

    ConfigError if the interval varies: there is no such gain then.
    """
    if sampled.mean.shape[1] != 1:
        raise ConfigError(
            "a stationary gain needs one interval; this record has "
            f"{sampled.mean.shape[1]}: take the covariance form"
        )
    del problem
    sampled = sampled.as_complex()
    settled = settle_filter(sampled.mean[:, 0], sampled.noise[:, 0], sampled.start[..., 1:])
    return settled[1] if settled else None


def settle_filter(
    mean: Complexes, noise: Complexes, P: Complexes
) -> tuple[Complexes, Complexes] | None:
    """Return P (b, x, x) and gain (b, x, y) of settled filters, else None."""
    states = P.shape[1]
    Phi = mean[..., :states]
    for _ in range(MAX_GAIN_STEPS):
        J = Phi @ P @ Phi.swapaxes(1, 2) + noise
        N, R = J[:, :states, states:], J[:, states:, states:]
        try:
            np.linalg.cholesky(R.real)  # R must be positive definite
            gain = N @ np.linalg.inv(R)
        except np.linalg.LinAlgError:
            return None
        before, P = P, J[:, :states, :states] - gain @ N.swapaxes(1, 2)
        P = 0.5 * (P + P.swapaxes(1, 2))  # else rounding grows
        moved, size = (_sizes(part) for part in (P - before, P))
        if (moved <= COVARIANCE_TOLERANCE * size.max(axis=0)).all():
            return P, gain
    return None


def _sizes(matrices: Complexes) -> Numbers:
    """Return the sizes of the real parts, and of the derivatives in the imaginary ones (2, b)."""
    parts = np.array([matrices.real, matrices.imag / COMPLEX_STEP])
    return np.asarray(np.sqrt(np.sum(parts**2, axis=(2, 3))))


def own_gain(problem: Problem, sampled: SampledSystems) -> Complexes | None:
    """Return the gains (b, x, y) that the model gives.

    A user's own system may state its gain.
    """
    del problem
    gain = sampled.as_complex().gain
    return None if gain is None or not np.isfinite(gain).all() else gain


@dataclass(frozen=True, eq=False)
class Innovations:
    """The cost of a predictor with a gain: ``no_gain``, ``settled_gain`` or ``own_gain``.

    ``gains`` may be any other function too; imaginary parts of its result are derivatives.
    """

    problem: Problem
    gains: Gains

    def value(self, theta: Numbers) -> float:
        """Return (n/2) log det(S/n) + n y (1 + log 2 pi)/2. S is the sum of error error'."""
        errors = self._errors(theta, sloped=False)
        return math.inf if errors is None else _concentrate(errors[0].real)

    def slope(self, theta: Numbers) -> tuple[float, Numbers]:
        """Return the cost and its exact gradient (f,)."""
        errors = self._errors(theta, sloped=True)
        if errors is None:
            return math.inf, np.full(len(theta), math.nan)
        value, weighted, slopes = errors[0].real, *self._weighted(errors)
        gradient = np.einsum("kc,pkc->p", weighted, slopes)
        return _concentrate(value), gradient * self.problem.scale

    def information(self, theta: Numbers) -> Numbers:
        """Return n sum error_i' S^-1 error_j (f, f): the expected second derivatives."""
        errors = self._errors(theta, sloped=True)
        if errors is None:
            return np.full((len(theta), len(theta)), math.nan)
        value = errors[0].real
        spread = np.linalg.cholesky(value.T @ value / len(value))
        _, slopes = self._weighted(errors)
        standard = np.linalg.solve(spread, np.moveaxis(slopes, 2, 1)).reshape(len(theta), -1)
        scale = self.problem.scale
        return np.asarray(standard @ standard.T * np.outer(scale, scale))

    def shown(self, theta: Numbers, number: int = 0) -> tuple[Numbers, Numbers]:
        """Return a run's predicted states (n, x) and prediction errors (n, y)."""
        run, at = self.problem.runs[number]
        sampled = run.sampled(theta[at]).as_complex()
        gains = self.gains(run, sampled)
        if gains is None:
            raise ConfigError("the filter does not settle: its gain is not known")
        states, errors = _run(run, sampled, gains, 0)
        return states.real, errors.real

    def _weighted(self, errors: Complexes) -> tuple[Numbers, Numbers]:
        """Return n S^-1 error (n, y) and the errors' slopes (f, n, y)."""
        value = errors[0].real
        weighted = len(value) * np.linalg.solve(value.T @ value, value.T).T
        return weighted, errors[1:].imag / COMPLEX_STEP

    def _errors(self, theta: Numbers, *, sloped: bool) -> Complexes | None:
        """Return the errors of whole samples of all runs (1+f, k, y), or only the first row.

        Imaginary parts from the second row on are slopes. None if the model is impossible.
        """
        parts = []
        for run, at in self.problem.runs:
            sampled = run.sloped(theta[at]) if sloped else run.sampled(theta[at]).as_complex()
            gains = self.gains(run, sampled) if possible(sampled) else None
            if gains is None:
                return None
            errors = np.stack([_run(run, sampled, gains, row)[1] for row in range(len(gains))])
            # V1 needs complete samples: errors of all outputs are multiplied (MI 6.3)
            errors = errors[:, ~np.isnan(run.samples.outputs).any(axis=1)]
            part = np.zeros((1 + sloped * len(theta), *errors.shape[1:]), complex)
            part[[0, *(1 + at)] if sloped else [0]] = errors
            parts.append(part)
        whole = np.concatenate(parts, axis=1)
        return whole if np.isfinite(whole).all() and whole.shape[1] else None


def _run(
    problem: Problem, sampled: SampledSystems, gains: Complexes, row: int
) -> tuple[Entries, Entries]:
    """Return states (n, x) and errors (n, y) of one row; NaN where a reading is missing."""
    samples, states = problem.samples, sampled.start.shape[1]
    out = np.empty((len(samples.t), states + samples.outputs.shape[1]), complex)
    first = np.ascontiguousarray(sampled.start[row, :, 0])
    system = FixedGain(sampled.mean[row], gains[row], first)
    run_predictor(system, samples.table, samples.steps[1], np.zeros((len(out), states)), out)
    return out[:, :states], samples.outputs - out[:, states:]


def _concentrate(errors: Numbers) -> float:
    """Return minus the log-likelihood of ``errors`` (n, y) with the covariance that fits best.

    Infinite where errors are one another's multiples, or too large to be squared.
    """
    count, readings = errors.shape
    with np.errstate(over="ignore"):
        covariance = errors.T @ errors / count
    if not np.isfinite(covariance).all():
        return math.inf
    sign, determinant = np.linalg.slogdet(covariance)
    if sign <= 0.0:
        return math.inf
    return float(0.5 * count * (determinant + readings * (1.0 + LOG_2_PI)))


@dataclass(frozen=True, eq=False)
class MultiStep:
    """The cost of predictions ``first`` to ``last`` samples ahead, pooled (MI 6.4).

    Only if both are 1 is it the likelihood, and only then do standard deviations follow from it.
    """

    problem: Problem
    first: int
    last: int

    def value(self, theta: Numbers) -> float:
        """Return n V2, n the samples that have a reading; the sum of all runs."""
        return float(sum(costs[0].real for costs in self._costs(theta, sloped=False)))

    def slope(self, theta: Numbers) -> tuple[float, Numbers]:
        """Return n V2 and its exact gradient (f,)."""
        gradient, value = np.zeros(len(theta)), 0.0
        for costs, (_, at) in zip(self._costs(theta, sloped=True), self.problem.runs, strict=True):
            value += float(costs[0].real)
            gradient[at] += costs[1:].imag / COMPLEX_STEP
        return value, gradient * self.problem.scale

    def information(self, theta: Numbers) -> Numbers:
        """Return the information of one step: a metric for minimisers, not for deviations."""
        return Likelihood(self.problem).information(theta)

    def _costs(self, theta: Numbers, *, sloped: bool) -> list[Complexes]:
        """Return n V2 of each run, in the first row, and its slopes in the next ones."""
        step_costs = []
        for run, at in self.problem.runs:
            sampled = run.sloped(theta[at]) if sloped else run.sampled(theta[at]).as_complex()
            if possible(sampled):
                costs = [self._cost(run, sampled, row) for row in range(len(sampled.start))]
            else:
                costs = [complex(math.inf)] * len(sampled.start)
            step_costs.append(np.array(costs))
        return step_costs

    def _cost(self, problem: Problem, sampled: SampledSystems, row: int) -> complex:
        """Return n V2 of a row."""
        start = np.ascontiguousarray(sampled.start[row])
        system = SampledSystem(sampled.mean[row], sampled.noise[row], start)
        try:
            total, count = self._look_ahead(system, problem.samples)
        except (ZeroDivisionError, np.linalg.LinAlgError):  # compiled code raises of complex ones
            return complex(math.inf)
        mean = total / count if count else complex(math.inf)
        return mean * problem.samples.counted if np.isfinite(mean) else complex(math.inf)

    def _look_ahead(self, system: SampledSystem, samples: Samples) -> tuple[complex, int]:
        """Return the sum of all predictions' -log L, and how many there are."""
        readings, (mean, noise, start) = samples.outputs.shape[1], system
        shown, x = filter_samples(system, samples, no_limits(readings)), len(start)
        z, P, total, count = shown.states, shown.covariances, 0j, 0
        for ahead in range(min(self.last, len(samples.t))):
            table, which = samples.table[ahead:], samples.steps[1][ahead:]
            W, whole = mean[which], np.column_stack([z, table[:, readings:], np.ones(len(z))])
            v = np.einsum("kij,kj->ki", W, whole)
            J = W[..., :x] @ P @ W[..., :x].swapaxes(1, 2) + noise[which]
            if ahead >= self.first - 1:
                total += np.sum(_surprises(table[:, :readings] - v[:, x:], J[:, x:, x:]))
                count += int(np.count_nonzero(~np.isnan(table[:, :readings]).all(axis=1)))
            z, P = v[:-1, :x], J[:-1, :x, :x]
        return total, count


def _surprises(errors: Entries, R: Entries) -> Complexes:
    """Return -log L (n,) of errors (n, y) with covariances R (n, y, y).

    It is infinite where R is not positive definite.
    """
    present = ~np.isnan(errors)
    # a missing reading has error 0 and variance 1, alone: it adds nothing to -log L
    R = np.where(present[:, :, None] & present[:, None, :], R, np.eye(errors.shape[1]))
    present_errors, size = np.where(present, errors, 0.0), np.linalg.det(R)
    squares = np.einsum(
        "ki,ki->k", present_errors, np.linalg.solve(R, present_errors[..., None])[..., 0]
    )
    logs = np.log(np.where(size.real > 0.0, size, math.inf))
    return np.asarray(0.5 * (logs + squares + present.sum(axis=1) * LOG_2_PI))

"""A record run through the filter of a model: errors, what was screened, and what was predicted.

Section 6.1 with screening (6.5): a sample whose squared error, weighted by its covariance, is
improbable is rejected; it neither moves the filter nor counts.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.config import ConfigError
from trainer.identify.problem import Problem

Numbers = NDArray[np.float64]

COUNTED, MISSING, REJECTED, SINGULAR = 0, 1, 2, 3  # of each sample


@dataclass(frozen=True)
class Filtered:
    """One-step errors of a record, in knots and degrees; NaN where a reading did not count."""

    errors: Numbers  # (n, y)
    standardised: Numbers  # (n, y) by the Cholesky factor of their covariance
    predicted: Numbers  # (n, y)
    squares: Numbers  # (n,) error' R^-1 error
    status: NDArray[np.int64]  # (n,)

    @property
    def counted(self) -> int:
        """Return how many samples counted."""
        return int(np.count_nonzero(self.status == COUNTED))

    def loss_1(self) -> float:
        """Return V1 = (1/n) log det of the sum of error error' of whole samples (6.3)."""
        whole = self.errors[~np.isnan(self.errors).any(axis=1)]
        if not len(whole):
            return float("nan")
        return float(np.linalg.slogdet(whole.T @ whole)[1]) / len(whole)


MOST: Final = np.inf  # of the squares, without screening


def run_filter(problem: Problem, theta: Numbers, most: dict[int, float]) -> Filtered:
    """Return the errors of the parameters ``theta`` (f,).

    ``most`` is the largest square that counts, by the number of readings of a sample; a number
    that is not there has no limit. ConfigError if the model is impossible.
    """
    mean, noise, start = problem.sampled(theta).at(0)
    samples = problem.samples
    states, count = len(start), samples.outputs.shape[1]
    _, which = samples.steps
    x, P = start[:, 0].copy(), start[:, 1:].copy()
    shape = samples.outputs.shape
    errors, standard = np.full(shape, np.nan), np.full(shape, np.nan)
    predicted = np.empty(shape)
    squares, status = np.full(len(which), np.nan), np.zeros(len(which), np.int64)
    for k, place in enumerate(which):
        W, z = mean[place], np.concatenate([x, samples.table[k, count:], [1.0]])
        v, J = W @ z, W[:, :states] @ P @ W[:, :states].T + noise[place]
        predicted[k] = v[states:]
        left = samples.outputs[k] - v[states:]
        rows = states + np.flatnonzero(~np.isnan(left))
        x, P = v[:states], 0.5 * (J + J.T)[:states, :states]
        if not rows.size:
            status[k] = MISSING
            continue
        R = J[np.ix_(rows, rows)]
        try:
            factor = np.linalg.cholesky(R)
        except np.linalg.LinAlgError:
            status[k] = SINGULAR
            continue
        own = left[rows - states]
        unit = np.linalg.solve(factor, own)
        squares[k] = float(unit @ unit)
        if squares[k] > most.get(len(rows), MOST):
            status[k] = REJECTED
            continue
        errors[k, rows - states], standard[k, rows - states] = own, unit
        gain = np.linalg.solve(R, J[rows, :states]).T
        x = x + gain @ own
        P = P - gain @ R @ gain.T
    if not np.isfinite(predicted).all():
        raise ConfigError("the model's prediction of this record is not finite")
    return Filtered(errors, standard, predicted, squares, status)


def limits_of(probability: float, readings: int) -> dict[int, float]:
    """Return the chi-square limits of 1 to ``readings`` readings that one in 1/p samples exceeds."""
    from scipy.stats import chi2  # noqa: PLC0415

    return {count: float(chi2.isf(probability, count)) for count in range(1, readings + 1)}

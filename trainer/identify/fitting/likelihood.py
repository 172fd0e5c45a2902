"""The likelihood of a record under a model with noise covariances, its gradient and information.

It is the cost that ``trainer identify`` minimises where ``noise`` is "covariance". The sums over
the samples are compiled, in ``kernels/likelihood`` and ``kernels/sensitivity``. Model document,
6.1, 6.3 and 8.1. Where a model is impossible (a covariance not positive definite) the cost is
infinite, so that a search turns back.
"""

import math
from dataclasses import dataclass, field
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.fitting.problem import Problem
from trainer.identify.kernels.likelihood import (
    LOG_DETERMINANTS,
    READINGS,
    SQUARES,
    is_possible,
    likelihood_sums,
)
from trainer.identify.kernels.sensitivity import ScoreRows, score_rows
from trainer.identify.model.sampled import SampledSystems

LOG_2_PI: Final = math.log(2.0 * math.pi)
PIECE_ROWS: Final = 256  # rows that are multiplied at once


def possible(sampled: SampledSystems) -> bool:
    """Return whether the system is finite and P(t0) of the first row positive semidefinite.

    A search may try parameters that are no model; it turns back where this is false.
    """
    return bool(is_possible(*sampled.at(0)))


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
        return sum(_cost(run, theta[at]) for run, at in self.problem.runs)

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
            runs = [_score(run, theta[at]) for run, at in self.problem.runs]
            gradient = np.zeros(len(theta))
            for one, (_, at) in zip(runs, self.problem.runs, strict=True):
                gradient[at] += one.gradient
            cost = sum(one.cost for one in runs)
            score = Score(cost, gradient, tuple(rows for one in runs for rows in one.rows))
            self._last.update(key=key, score=score)
        last_score: Score = self._last["score"]
        return last_score


def _cost(problem: Problem, theta: Numbers) -> float:
    """Return -log L of one run."""
    system, samples = problem.sampled(theta).at(0), problem.samples
    if not is_possible(*system):
        return math.inf
    sums = np.empty(4)
    likelihood_sums(*system, samples.table, samples.steps[1], sums)
    cost = 0.5 * (sums[LOG_DETERMINANTS] + sums[SQUARES] + sums[READINGS] * LOG_2_PI)
    return float(cost) if math.isfinite(cost) else math.inf


def _score(problem: Problem, theta: Numbers) -> Score:
    """Return cost, gradient and rows of one run."""
    sampled, samples, count = problem.sloped(theta), problem.samples, len(theta)
    impossible = Score(math.inf, np.full(count, math.nan), ())
    if not possible(sampled):
        return impossible
    length, readings = samples.outputs.shape
    slopes = sampled.slopes()
    wide = slopes.mean.shape[-1]  # with the zeros that fill up the processor's lanes
    errors = np.empty((length, readings, wide))
    covariances = np.empty((length, readings * readings, wide))
    slope = np.empty(wide)
    out = ScoreRows(errors, covariances, slope)
    stages, cost = score_rows(sampled.at(0), slopes, samples.table, samples.steps[1], out)
    if not stages:
        return impossible
    constant = 0.5 * np.count_nonzero(~np.isnan(samples.outputs)) * LOG_2_PI
    rows = errors.reshape(-1, wide), covariances[:stages].reshape(-1, wide)
    return Score(float(cost + constant), slope[:count] * problem.scale, (rows,))

"""The likelihood of a record under a model with noise covariances, its gradient and information.

Model document, 6.1, 6.3 and 8.1. Where a model is impossible (a covariance not positive definite)
the cost is infinite.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.adjoint import likelihood_slope, trail
from trainer.identify.kernels.likelihood import likelihood_sums
from trainer.identify.kernels.sensitivity import information_rows
from trainer.identify.problem import Problem
from trainer.identify.sampled import Sampled

LOG_2_PI: Final = math.log(2.0 * math.pi)
PIECE: Final = 256  # rows


def possible(sampled: Sampled) -> bool:
    """Return whether the system is finite and P(t0) of the first row positive semidefinite."""
    mean, noise, start = sampled.mean[0], sampled.noise[0], sampled.start[0]
    if not (np.isfinite(mean).all() and np.isfinite(noise).all() and np.isfinite(start).all()):
        return False
    P = start[:, 1:].real
    if not P.any():
        return True
    width = np.sqrt(np.maximum(np.diag(P), 1e-300))
    return bool(np.linalg.eigvalsh(P / np.outer(width, width))[0] > -1e-9)


def _gram(rows: Numbers) -> Numbers:
    """Return rows' rows, in pieces that no library hands to several threads: waking them costs."""
    count = rows.shape[1]
    total = np.zeros((count, count))
    for first in range(0, len(rows), PIECE):
        piece = rows[first : first + PIECE]
        total += piece.T @ piece
    return total


@dataclass(frozen=True, eq=False)
class Likelihood:
    """Minus the log-likelihood by covariances: a cost to minimise over a problem's parameters."""

    problem: Problem

    def value(self, theta: Numbers) -> float:
        """Return -log L [-]."""
        sampled = self.problem.sampled(theta)
        if not possible(sampled):
            return math.inf
        samples = self.problem.samples
        sums = np.empty(4)
        likelihood_sums(*sampled.at(0), samples.table, samples.steps[1], sums)
        cost = 0.5 * (sums[0] + sums[1] + sums[3] * LOG_2_PI)
        return float(cost) if math.isfinite(cost) else math.inf

    def slope(self, theta: Numbers) -> tuple[float, Numbers]:
        """Return -log L [-] and its exact gradient (f,), by the adjoint."""
        sampled = self.problem.sloped(theta)
        failed = math.inf, np.full(len(theta), math.nan)
        if not possible(sampled):
            return failed
        mean, noise, start = sampled.at(0)
        table, which = self.problem.samples.table, self.problem.samples.steps[1]
        states, rows, columns = len(start), mean.shape[1], mean.shape[2]
        path = np.empty((len(table), columns + rows - states + 2))
        joints = np.empty((len(table), rows, rows + states))
        path[0, :columns] = [*start[:, 0], *np.ones(columns - states)]
        joints[0, :states, rows:] = start[:, 1:]
        stages = trail(mean, noise, table, which, path, joints)
        if stages == 0:
            return failed
        by_system, by_start = np.empty((*mean.shape[:2], columns + rows)), np.empty(start.shape)
        likelihood_slope(mean, which, path, joints, by_system, by_start)
        d_mean, d_noise, d_start = sampled.slopes()
        slope = (
            np.tensordot(by_system[..., :columns], d_mean, 3)
            + np.tensordot(by_system[..., columns:], d_noise, 3)
            + np.tensordot(by_start, d_start, 2)
        )
        constant = np.count_nonzero(~np.isnan(self.problem.samples.outputs)) * LOG_2_PI
        cost = 0.5 * float(path[:, -2].sum() + constant)
        return cost, np.asarray(slope) * self.problem.scale

    def information(self, theta: Numbers) -> Numbers:
        """Return the expected information (f, f); not a number where the model is impossible."""
        sampled = self.problem.sloped(theta)
        count = len(theta)
        if not possible(sampled):
            return np.full((count, count), math.nan)
        samples = self.problem.samples
        readings = samples.outputs.shape[1]
        errors = np.empty((len(samples.t), readings, count))
        covariances = np.empty((len(samples.t), readings * readings, count))
        stages = information_rows(
            sampled.at(0), sampled.slopes(), samples.table, samples.steps[1], errors, covariances
        )
        if stages == 0:
            return np.full((count, count), math.nan)
        total = _gram(errors.reshape(-1, count)) + _gram(covariances[:stages].reshape(-1, count))
        return np.asarray(total * np.outer(self.problem.scale, self.problem.scale))

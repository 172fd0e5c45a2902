"""The likelihood of a record under a model with noise covariances, its gradient and information.

Model document, 6.1, 6.3 and 8.1. Where a model is impossible (a covariance not positive definite)
the cost is infinite.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trainer.identify.discrete import Sampled
from trainer.identify.kernels.adjoint import likelihood_slope, trail
from trainer.identify.kernels.covariance_filter import likelihood_sums
from trainer.identify.kernels.sensitivity import information_rows
from trainer.identify.problem import Problem

Numbers = NDArray[np.float64]


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
        cost = 0.5 * (sums[0] + sums[1] + sums[3] * math.log(2.0 * math.pi))
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
        path = np.empty((len(table), columns + rows - states + 1))
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
        return self._cost(path, joints, stages), np.asarray(slope) * self.problem.scale

    def _cost(self, path: Numbers, joints: Numbers, stages: int) -> float:
        """Return -log L [-] of a trail."""
        rows = joints.shape[1]
        readings = self.problem.samples.outputs.shape[1]
        inverse = -joints[:stages, rows - readings : rows, rows - readings : rows]
        stage = path[:, -1].astype(int)
        s = path[:, -1 - readings : -1]
        there = np.einsum("kii->ki", inverse) > 0.0
        padded = inverse + np.einsum("ki,ij->kij", ~there, np.eye(readings))
        determinants = -np.linalg.slogdet(padded)[1]
        # error' R^-1 error = s' R s, on the readings that are there
        squares = np.einsum("ki,kij,kj->", s, np.linalg.inv(padded)[stage], s)
        count = int(np.count_nonzero(there[stage]))
        weights = np.bincount(stage, minlength=stages)
        total = float(weights @ determinants) + float(squares) + count * math.log(2.0 * math.pi)
        return 0.5 * total

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
        first = errors.reshape(-1, count)
        second = covariances[:stages].reshape(-1, count)
        total = first.T @ first + second.T @ second
        return np.asarray(total * np.outer(self.problem.scale, self.problem.scale))

"""A model's view of a record by sample: predictions, errors, outliers, losses."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import Entries
from trainer.identify.kernels.prediction import COUNTED, show
from trainer.identify.measurements import Samples
from trainer.identify.problem import Problem

REASONS: Final = ("counted", "missing", "rejected", "singular")


@dataclass(frozen=True, eq=False)
class Shown:
    """The filter's run over a record; errors are NaN where a reading is missing."""

    states: Numbers  # (n, x) predicted from the samples before, SI
    predictions: Numbers  # (n, y)
    errors: Numbers  # (n, y) reading less prediction
    covariances: Numbers  # (n, x, x) P of the states
    spreads: Numbers  # (n, y, y) R, their covariance
    squares: Numbers  # (n,) error' R^-1 error
    flags: NDArray[np.int64]  # (n,) places in REASONS

    @property
    def counted(self) -> NDArray[np.bool_]:
        """Return which samples the losses are made of (n,)."""
        return np.asarray(self.flags == int(COUNTED))

    @property
    def standardised(self) -> Numbers:
        """Return errors divided by the Cholesky factor of R (n, y). NaN where one is missing."""
        found = np.full_like(self.errors, np.nan)
        whole = self.counted & ~np.isnan(self.errors).any(axis=1)
        roots = np.linalg.cholesky(self.spreads[whole])
        found[whole] = np.linalg.solve(roots, self.errors[whole][..., None])[..., 0]
        return found


def no_limits(readings: int) -> Numbers:
    """Return limits (y+1,) that reject nothing."""
    return np.full(readings + 1, np.inf)


def chi_square_limits(probability: float, readings: int) -> Numbers:
    """Return limits (y+1,): a good sample is beyond its own with ``probability`` (MI 6.5).

    By the chi-square distribution with as many degrees of freedom as there are readings.
    """
    from scipy.special import chdtri  # noqa: PLC0415 - an extra, imported on use

    return np.array([math.inf, *(chdtri(count, probability) for count in range(1, readings + 1))])


def run_filter(problem: Problem, theta: Numbers, limits: Numbers) -> Shown:
    """Return the filter's run with ``theta`` (f,); ``limits`` (y+1,) as chi_square_limits."""
    return filtered(problem.sampled(theta).at(0), problem.samples, limits)


def filtered(system: tuple[Entries, Entries, Entries], samples: Samples, limits: Numbers) -> Shown:
    """Return the filter's run by a system's mean, noise and start; complex as they are."""
    (count, readings), states = samples.outputs.shape, len(system[2])
    rows, kind = states + readings, system[0].dtype
    out = np.empty((count, rows + readings + 2), kind)
    covariances = np.empty((count, states, states), kind)
    spreads = np.empty((count, readings, readings), kind)
    show(system, samples.table, samples.steps[1], limits, (out, covariances, spreads))
    return Shown(
        out[:, :states],
        out[:, states:rows],
        out[:, rows : rows + readings],
        covariances,
        spreads,
        out[:, -2],
        out[:, -1].real.astype(np.int64),
    )


def loss_1(errors: Numbers) -> float:
    """Return V1 = (1/n) log det of the sum of error error' over whole samples (6.3)."""
    whole = errors[~np.isnan(errors).any(axis=1)]
    sign, size = np.linalg.slogdet(whole.T @ whole)
    return float(size) / len(whole) if len(whole) and sign > 0.0 else math.nan

"""A model's view of a record by sample: predictions, errors, outliers, losses."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.identify.kernels.screening import COUNTED, show
from trainer.identify.likelihood import LOG_2_PI
from trainer.identify.problem import Problem

REASONS: Final = ("counted", "missing", "rejected", "singular")


@dataclass(frozen=True, eq=False)
class Shown:
    """The filter's run over a record; errors are NaN where a reading is missing."""

    states: Numbers  # (n, x) predicted from the samples before, SI
    predictions: Numbers  # (n, y)
    errors: Numbers  # (n, y) reading less prediction
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


@dataclass(frozen=True)
class Losses:
    """The losses of a record (MI 6.3), over ``samples`` that count.

    V1 needs whole samples and is NaN where none is; it is shown as the report defines it and as
    its programs' comments do.
    """

    samples: int
    V1: float  # log det S / n
    log_det_mean: float  # log det (S/n)
    det_mean: float  # det S / n
    V2: float  # -log L / n


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
    system = problem.sampled(theta).at(0)
    samples = problem.samples
    count, readings = samples.outputs.shape
    states = problem.plant.model.states
    out = np.empty((count, states + 2 * readings + 2))
    spreads = np.empty((count, readings, readings))
    show(system, samples.table, samples.steps[1], limits, out, spreads)
    rows = states + readings
    return Shown(
        out[:, :states],
        out[:, states:rows],
        out[:, rows : rows + readings],
        spreads,
        out[:, -2],
        out[:, -1].astype(np.int64),
    )


def losses(run: Shown) -> Losses:
    """Return the losses of a run."""
    count = int(np.count_nonzero(run.counted))
    readings = run.errors.shape[1]
    whole = run.errors[run.counted & ~np.isnan(run.errors).any(axis=1)]
    sign, determinant = np.linalg.slogdet(whole.T @ whole)
    n = len(whole)
    good = n > 0 and sign > 0.0
    total = 0.0
    for error, R, size in zip(
        run.errors[run.counted], run.spreads[run.counted], run.squares[run.counted], strict=True
    ):
        there = ~np.isnan(error)
        part = np.linalg.slogdet(R[np.ix_(there, there)])[1]
        total += float(part) + float(size) + float(there.sum()) * LOG_2_PI
    return Losses(
        count,
        float(determinant) / n if good else math.nan,
        float(determinant) - readings * math.log(n) if good else math.nan,
        math.exp(determinant) / n if good else math.nan,
        0.5 * total / count if count else math.nan,
    )

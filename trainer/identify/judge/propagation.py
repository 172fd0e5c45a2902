"""Numbers that follow from the parameters, by derivatives and by draws (8.3, 8.5).

``fitted`` and ``pages/results`` call it for time constants, gains and whatever else follows from
what was estimated. Numbers in brackets are equations of the model document (MI). The delta method
takes the numbers as linear in the parameters. Time constants near a double root bend sharply, and
there only draws give intervals that contain the truth (docs/identification.md has the shares).
"""

from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers

Derived = Callable[[Numbers], Numbers]
TAIL_SHARE: Final = 0.025  # [-] of the draws, left out at each end of an interval
DIFFERENCE_STEP: Final = 1e-4  # [standard deviations] of each parameter, for the quotients


class Spread(NamedTuple):
    """Numbers and their covariance."""

    values: Numbers  # (m,)
    covariance: Numbers  # (m, m)

    @property
    def deviations(self) -> Numbers:
        """Return the standard deviations."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def propagate_covariance(derived: Derived, theta: Numbers, covariance: Numbers) -> Spread:
    """Return ``derived(theta)`` (m,) with J cov J^T, J from central differences (8.3).

    A step is a small part of the parameter's own standard deviation, because that is the scale on
    which the numbers matter, whatever the unit.
    """
    steps = DIFFERENCE_STEP * np.sqrt(np.diag(covariance))
    columns = []
    for i, step in enumerate(steps):
        if step == 0.0:
            columns.append(np.zeros_like(derived(theta)))
            continue
        aside = np.zeros_like(theta)
        aside[i] = step
        columns.append((derived(theta + aside) - derived(theta - aside)) / (2.0 * step))
    J = np.column_stack(columns)
    return Spread(derived(theta), J @ covariance @ J.T)


class Span(NamedTuple):
    """95 % intervals of numbers, from draws of the parameters that they follow from."""

    low: Numbers  # (m,)
    high: Numbers  # (m,)


def span_draws(derived: Derived, draws: Numbers) -> tuple[Numbers, Span]:
    """Return ``derived`` of each of the ``draws`` (count, n), and its intervals.

    A draw may lack one number (NaN); its other numbers still count.
    """
    values = np.array([derived(draw) for draw in draws])
    known_values = np.where(np.isnan(values).all(axis=0), 0.0, values)  # no quantile of nothing
    low, high = np.nanquantile(known_values, (TAIL_SHARE, 1.0 - TAIL_SHARE), axis=0)
    nothing = np.isnan(values).all(axis=0)
    return values, Span(np.where(nothing, np.nan, low), np.where(nothing, np.nan, high))


def draw_parameters(theta: Numbers, covariance: Numbers, count: int, seed: int) -> Numbers:
    """Return ``count`` parameter vectors (count, n) from N(theta, covariance) (8.5)."""
    stream = np.random.Generator(np.random.PCG64(seed))
    return np.asarray(
        theta + stream.standard_normal((count, len(theta))) @ covariance_root(covariance).T
    )


def covariance_root(covariance: Numbers) -> Numbers:
    """Return C with C C' = ``covariance`` (..., n, n), which may be singular.

    Rows are scaled to a unit diagonal first, because units differ by many powers of ten; negative
    eigenvalues are rounding and are taken as zero.
    """
    width = np.sqrt(np.maximum(np.einsum("...ii->...i", covariance), 0.0))
    unit = np.where(width > 0.0, width, 1.0)
    sizes, vectors = np.linalg.eigh(covariance / (unit[..., None] * unit[..., None, :]))
    return np.asarray(
        width[..., None] * vectors * np.sqrt(np.maximum(sizes, 0.0))[..., None, :], float
    )

"""How uncertain numbers are that are computed from estimated ones: the delta method and draws."""

from collections.abc import Callable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
Derived = Callable[[Numbers], Numbers]

NUDGE: Final = 1e-4  # [standard deviations] of each parameter, for the difference quotients


class Spread(NamedTuple):
    """Numbers and their covariance."""

    values: Numbers  # (m,)
    covariance: Numbers  # (m, m)

    @property
    def deviations(self) -> Numbers:
        """Return the standard deviations."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))


def propagated(derived: Derived, theta: Numbers, covariance: Numbers) -> Spread:
    """Return ``derived(theta)`` (m,) with J cov J^T, J from central differences (8.3).

    The steps are a small part of each parameter's own standard deviation, so that they fit the
    scale on which it is known.
    """
    steps = NUDGE * np.sqrt(np.diag(covariance))
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


def drawn(theta: Numbers, covariance: Numbers, count: int, seed: int) -> Numbers:
    """Return ``count`` parameter vectors (count, n) from N(theta, covariance) (8.5).

    A covariance that is not positive definite by rounding is taken by its eigenvalues.
    """
    sizes, vectors = np.linalg.eigh(covariance)
    root = vectors * np.sqrt(np.maximum(sizes, 0.0))
    stream = np.random.Generator(np.random.PCG64(seed))
    return np.asarray(theta + stream.standard_normal((count, len(theta))) @ root.T)

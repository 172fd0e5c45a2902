"""Derivatives by an imaginary step: exact to the last digits, since nothing is subtracted."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.sampling import Complexes

STEP: Final = 1e-100  # imaginary part that carries a derivative without rounding


def aside(theta: Numbers, free: Sequence[int]) -> Complexes:
    """Return ``theta`` (n,) and, below it, one row for each place in ``free`` a step aside."""
    rows = np.empty((1 + len(free), len(theta)), complex)
    rows[:] = theta
    for row, place in enumerate(free, 1):
        rows[row, place] += 1j * STEP
    return rows

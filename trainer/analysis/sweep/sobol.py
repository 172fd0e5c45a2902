"""The plan ``sobol``: its members' numbers, and the indices that they give.

The design is Saltelli's: two independent sets A and B of base points, and for each variable j the
set AB_j, which is A with column j of B. First-order indices are by Saltelli et al. (Comput. Phys.
Commun. 181 (2010) 259, table 2b), total ones by Jansen (Comput. Phys. Commun. 117 (1999) 35). The
points are of the sequence of Sobol with the directions of Joe and Kuo, by scipy, shifted by digits
of the study's seed. So a member flown alone has the same numbers, with any version of scipy.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers

SOBOL_SAMPLE: Final = "sobol"
POINT_BITS: Final = 30  # of a coordinate, as scipy's sequence has them
FIRST_SET, SECOND_SET = 0, 1  # A and B; the mixed ones follow, one a variable
SET_COUNT: Final = 2
BOOTSTRAP_DRAWS: Final = 400
CONFIDENCE_PERCENT: Final = (2.5, 97.5)
MIN_BASE_POINTS: Final = 8  # fewer give no indices


@dataclass(frozen=True)
class SobolIndex:
    """The share of a measure's variance that a variable makes, with intervals of 95 %."""

    variable: str
    first: float  # [-] alone
    first_interval: tuple[float, float]
    total: float  # [-] with all that it does together with others
    total_interval: tuple[float, float]


def places_of(
    variables: int, first: int, count: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the base point and the set of members from ``first`` on."""
    members = np.arange(first, first + count)
    return members // (variables + SET_COUNT), members % (variables + SET_COUNT)


def sobol_shares(shifts: Numbers, variables: int, first: int, count: int) -> Numbers:
    """Return shares (count, variables) above 0 and below 1 of members from ``first`` on.

    ``shifts`` [-] has two numbers from 0 to 1 a variable, of which the digits are turned over.
    """
    from scipy.stats import qmc  # noqa: PLC0415  what few studies have

    points, sets = places_of(variables, first, count)
    base = int(points[0])
    sequence = qmc.Sobol(SET_COUNT * variables, scramble=False, bits=POINT_BITS)
    if base:
        sequence.fast_forward(base)
    whole = 2.0**POINT_BITS
    wanted = int(points[-1]) - base + 1
    drawn = sequence.random(wanted if base else 2 ** (wanted - 1).bit_length())[:wanted]
    shifted = (drawn * whole).astype(np.int64) ^ (shifts * whole).astype(np.int64)
    pairs = ((shifted + 0.5) / whole)[points - base].reshape(count, SET_COUNT, variables)
    mixed = sets[:, None] == np.arange(variables) + SET_COUNT
    of_second = mixed | (sets == SECOND_SET)[:, None]
    return np.asarray(np.where(of_second, pairs[:, SECOND_SET], pairs[:, FIRST_SET]))


def sobol_indices(variables: Sequence[str], values: Numbers, seed: int) -> tuple[SobolIndex, ...]:
    """Return the indices of each variable for a measure, the largest total first.

    ``values`` are those of all members in their order. A base point with a member that came to
    nothing is left out. None are returned of fewer than eight points, or of a constant.
    """
    runs = np.asarray(values).reshape(-1, len(variables) + SET_COUNT)
    runs = runs[np.isfinite(runs).all(axis=1)]
    if len(runs) < MIN_BASE_POINTS or not np.ptp(runs):
        return ()
    runs = runs - runs[:, :SET_COUNT].mean()  # which makes the products of the first order small
    chance = np.random.Generator(np.random.PCG64(seed))
    drawn = np.array(
        [_indices(runs[chance.integers(len(runs), size=len(runs))]) for _ in range(BOOTSTRAP_DRAWS)]
    )
    low, high = np.nanpercentile(drawn, CONFIDENCE_PERCENT, axis=0)
    first, total = _indices(runs)
    found = [
        SobolIndex(
            *(name, float(first[j]), (float(low[0, j]), float(high[0, j]))),
            *(float(total[j]), (float(low[1, j]), float(high[1, j]))),
        )
        for j, name in enumerate(variables)
    ]
    return tuple(sorted(found, key=lambda index: -index.total))


def _indices(runs: Numbers) -> Numbers:
    """Return first-order and total indices [2, variables] of runs (points, sets)."""
    first, second, mixed = runs[:, FIRST_SET], runs[:, SECOND_SET], runs[:, SET_COUNT:]
    variance = runs[:, :SET_COUNT].var()
    if variance == 0.0:
        return np.full((2, mixed.shape[1]), np.nan)
    alone = (second[:, None] * (mixed - first[:, None])).mean(axis=0)
    whole = ((first[:, None] - mixed) ** 2).mean(axis=0) / 2.0
    return np.asarray(np.array([alone, whole]) / variance)

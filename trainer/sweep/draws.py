"""What each member's numbers are, by the plan of a study.

Every number is a pure function of the study's seed, the variable's name and the member, so that a
member alone has the same, and a variable added leaves those of the others as they are.
"""

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.sweep.kernels.draws import fill_normals, fill_uniforms
from trainer.sweep.study_records import Sample, Vary

GRID, LATIN, MONTE_CARLO = "grid", "latin-hypercube", "monte-carlo"
SEEDS: Final = 2.0**49  # seeds are whole numbers below it, which an exercise may have too


def stream(purpose: str, name: str) -> int:
    """Return the number of a stream of random numbers."""
    return zlib.crc32(f"sweep {purpose} {name}".encode())


def uniforms(seed: int, of: int, first: int, count: int) -> Numbers:
    """Return numbers between 0 and 1, ends never reached, of members from ``first`` on."""
    out = np.empty(count)
    fill_uniforms(seed, of, first, out)
    return out


@lru_cache(maxsize=64)
def strata(seed: int, name: str, members: int) -> NDArray[np.int64]:
    """Return which of ``members`` equal parts each member has of one variable: a permutation."""
    keys = uniforms(seed, stream("strata", name), 0, members)
    found = np.empty(members, np.int64)
    found[np.argsort(keys, kind="stable")] = np.arange(members)
    return found


@dataclass(frozen=True)
class Draws:
    """The numbers of all members of a study."""

    sample: Sample
    rows: tuple[Vary, ...]

    @property
    def members(self) -> int:
        """Return how many members there are."""
        if self.sample.plan != GRID:
            return int(self.sample.members or 0)
        return int(np.prod([len(row.values or ()) for row in self.rows], dtype=object))

    def seeds(self, first: int, count: int) -> NDArray[np.int64]:
        """Return the seed of all that is random in each member's flight."""
        if self.sample.seeds == "one":
            return np.full(count, int(self.sample.seed), np.int64)
        drawn = uniforms(int(self.sample.seed), stream("seed", ""), first, count)
        return (drawn * SEEDS).astype(np.int64)

    def drawn(self, first: int, count: int) -> dict[str, NDArray[Any]]:
        """Return the numbers, or words, of members from ``first`` on, by variable."""
        if self.sample.plan == GRID:
            return self._grid(np.arange(first, first + count))
        return {row.name: of_shares(row, self._shares(row.name, first, count)) for row in self.rows}

    def middle(self) -> dict[str, Any]:
        """Return the middle of each variable: what a study is tried with."""
        half = np.array([0.5])
        return {row.name: of_shares(row, half).tolist()[0] for row in self.rows}

    def _shares(self, name: str, first: int, count: int) -> Numbers:
        """Return how far up its distribution each member is in a variable, between 0 and 1."""
        seed, members = int(self.sample.seed), self.members
        drawn = uniforms(seed, stream("share", name), first, count)
        if self.sample.plan == MONTE_CARLO:
            return drawn
        return np.asarray((strata(seed, name, members)[first : first + count] + drawn) / members)

    def _grid(self, members: NDArray[np.int64]) -> dict[str, NDArray[Any]]:
        """Return the values on a grid, the last variable changing fastest."""
        sizes = [len(row.values or ()) for row in self.rows]
        steps = [*accumulate(reversed(sizes[1:]), int.__mul__, initial=1)][::-1]
        return {
            row.name: listed(row.values or ())[members // step % size]
            for row, step, size in zip(self.rows, steps, sizes, strict=True)
        }


def listed(values: Sequence[float | str]) -> NDArray[Any]:
    """Return given values as an array of numbers or of words."""
    return np.array(values, object if isinstance(values[0], str) else np.float64)


def of_shares(row: Vary, shares: Numbers) -> NDArray[Any]:
    """Return the values of a variable below which ``shares`` of its distribution lie."""
    if row.values is not None:
        places = np.minimum((shares * len(row.values)).astype(int), len(row.values) - 1)
        return np.asarray(listed(row.values)[places])
    if row.distribution == "normal":
        deviates = np.empty(len(shares))
        fill_normals(shares, deviates)
        return np.asarray((row.mean or 0.0) + (row.std or 0.0) * deviates)
    if row.distribution == "triangular":
        return triangular(row.low or 0.0, row.mode or 0.0, row.high or 0.0, shares)
    low, high = row.low or 0.0, row.high or 0.0
    return np.asarray(low + shares * (high - low))


def triangular(low: float, mode: float, high: float, shares: Numbers) -> Numbers:
    """Return the quantiles of the distribution that rises from ``low`` to ``mode`` and falls."""
    whole, rising = high - low, mode - low
    up = low + np.sqrt(shares * whole * rising)
    down = high - np.sqrt((1.0 - shares) * whole * (high - mode))
    return np.where(shares * whole < rising, up, down)

"""The numbers of each member, by the plan of a study.

``study`` reads the plan, and ``job`` asks for the members of each chunk. Every number is a pure
function of the study's seed, the variable's name and the member, so that a member flown alone has
the same numbers, and a new variable leaves those of the others unchanged; but in the plan
``sobol``, whose points have as many places as there are variables.
"""

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import accumulate
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.analysis.sweep.records import ESTIMATE_DISTRIBUTION, Sample, VaryRow
from trainer.analysis.sweep.sobol import SOBOL_SAMPLE, places_of, sobol_shares
from trainer.core.elementary import logarithm
from trainer.core.kernel import Numbers, kernel
from trainer.core.noise import uniform

GRID_SAMPLE, LATIN_SAMPLE, MONTE_CARLO_SAMPLE = "grid", "latin-hypercube", "monte-carlo"
SEED_LIMIT: Final = 2.0**49  # seeds are whole numbers below it, which an exercise may have too
# M. Wichura, Algorithm AS 241, Appl. Statist. 37 (1988) 477: numerator
# and denominator near the middle, in the tails, and far out in them, the highest power first
MIDDLE_HALF_WIDTH, MIDDLE_SQUARED, TAIL_END = 0.425, 0.180625, 5.0
# fmt: off
MIDDLE_UP = (
    2509.0809287301226727, 33430.575583588128105, 67265.770927008700853,
    45921.953931549871457, 13731.693765509461125, 1971.5909503065514427,
    133.14166789178437745, 3.387132872796366608,
)
MIDDLE_DOWN = (
    5226.495278852545925, 28729.085735721942674, 39307.89580009271061,
    21213.794301586595867, 5394.1960214247511077, 687.1870074920579083,
    42.313330701600911252, 1.0,
)
TAIL_UP = (
    7.7454501427834140764e-4, 0.0227238449892691845833, 0.24178072517745061177,
    1.27045825245236838258, 3.64784832476320460504, 5.7694972214606914055,
    4.6303378461565452959, 1.42343711074968357734,
)
TAIL_DOWN = (
    1.05075007164441684324e-9, 5.475938084995344946e-4, 0.0151986665636164571966,
    0.14810397642748007459, 0.68976733498510000455, 1.6763848301838038494,
    2.05319162663775882187, 1.0,
)
FAR_UP = (
    2.01033439929228813265e-7, 2.71155556874348757815e-5, 0.0012426609473880784386,
    0.026532189526576123093, 0.29656057182850489123, 1.7848265399172913358,
    5.4637849111641143699, 6.6579046435011037772,
)
FAR_DOWN = (
    2.04426310338993978564e-15, 1.4215117583164458887e-7, 1.8463183175100546818e-5,
    7.868691311456132591e-4, 0.0148753612908506148525, 0.13692988092273580531,
    0.59983220655588793769, 1.0,
)
# fmt: on


@kernel
def ratio(up: tuple[float, ...], down: tuple[float, ...], x: float) -> float:
    """Return the quotient [-] of two polynomials, highest powers first."""
    above, below = 0.0, 0.0
    for i in range(len(up)):
        above = above * x + up[i]
        below = below * x + down[i]
    return above / below


@kernel
def normal_quantile(share: float) -> float:
    """Return the normal deviate [-] below which ``share`` of all lie.

    ``share`` [-] is above 0 and below 1.
    """
    away = share - 0.5
    if abs(away) <= MIDDLE_HALF_WIDTH:
        return away * ratio(MIDDLE_UP, MIDDLE_DOWN, MIDDLE_SQUARED - away * away)
    tail = share if away < 0.0 else 1.0 - share
    r = math.sqrt(-logarithm(tail))
    size = (
        ratio(TAIL_UP, TAIL_DOWN, r - 1.6)
        if r <= TAIL_END
        else ratio(FAR_UP, FAR_DOWN, r - TAIL_END)
    )
    return -size if away < 0.0 else size


@kernel
def fill_uniforms(seed: int, stream: int, first: int, out: Numbers) -> None:
    """Write the numbers [-] between 0 and 1 of the members from ``first`` on."""
    for i in range(out.size):
        out[i] = uniform(seed, stream, first + i)


@kernel
def fill_normals(shares: Numbers, out: Numbers) -> None:
    """Write the normal deviates [-] below which ``shares`` of all lie."""
    for i in range(out.size):
        out[i] = normal_quantile(shares[i])


def stream_number(purpose: str, name: str) -> int:
    """Return the number of a stream of random numbers."""
    return zlib.crc32(f"sweep {purpose} {name}".encode())


def uniforms(seed: int, of: int, first: int, count: int) -> Numbers:
    """Return numbers between 0 and 1 of members from ``first`` on, ends never reached."""
    out = np.empty(count)
    fill_uniforms(seed, of, first, out)
    return out


@lru_cache(maxsize=64)
def strata(seed: int, name: str, members: int) -> NDArray[np.int64]:
    """Return which of ``members`` equal parts of a variable each member has: a permutation."""
    keys = uniforms(seed, stream_number("strata", name), 0, members)
    parts = np.empty(members, np.int64)
    parts[np.argsort(keys, kind="stable")] = np.arange(members)
    return parts


@dataclass(frozen=True)
class Draws:
    """The numbers of all members of a study."""

    sample: Sample
    rows: tuple[VaryRow, ...]

    @property
    def members(self) -> int:
        """Return how many members there are."""
        if self.sample.plan != GRID_SAMPLE:
            return int(self.sample.members or 0)
        return int(np.prod([len(row.values or ()) for row in self.rows], dtype=object))

    def seeds(self, first: int, count: int) -> NDArray[np.int64]:
        """Return the seed of each member's flight. All that is random follows from it."""
        if self.sample.seeds == "one":
            return np.full(count, int(self.sample.seed), np.int64)
        of_seeds = stream_number("seed", "")
        if self.sample.plan == SOBOL_SAMPLE:  # what is compared flies in the same sea
            points, _ = places_of(len(self.rows), first, count)
            base = int(points[0])
            drawn = uniforms(int(self.sample.seed), of_seeds, base, int(points[-1]) - base + 1)
            return (drawn * SEED_LIMIT).astype(np.int64)[points - base]
        drawn = uniforms(int(self.sample.seed), of_seeds, first, count)
        return (drawn * SEED_LIMIT).astype(np.int64)

    def drawn(self, first: int, count: int) -> dict[str, NDArray[Any]]:
        """Return the numbers, or words, of members from ``first`` on, by variable."""
        if self.sample.plan == GRID_SAMPLE:  # the last variable changes fastest
            members = np.arange(first, first + count)
            sizes = [len(row.values or ()) for row in self.rows]
            steps = [*accumulate(reversed(sizes[1:]), int.__mul__, initial=1)][::-1]
            return {
                row.name: list_values(row.values or ())[members // step % size]
                for row, step, size in zip(self.rows, steps, sizes, strict=True)
            }
        seed, columns = int(self.sample.seed), dict[str, NDArray[Any]]()
        if self.sample.plan == SOBOL_SAMPLE:
            pairs = [uniforms(seed, stream_number("digits", row.name), 0, 2) for row in self.rows]
            shifts = np.transpose(pairs).ravel()
            mixed = sobol_shares(shifts, len(self.rows), first, count)
            return {row.name: of_shares(row, mixed[:, j]) for j, row in enumerate(self.rows)}
        for row in self.rows:
            shares = uniforms(seed, stream_number("share", row.name), first, count)
            if self.sample.plan != MONTE_CARLO_SAMPLE:
                part = strata(seed, row.name, self.members)[first : first + count]
                shares = np.asarray((part + shares) / self.members)
            columns[row.name] = of_shares(row, shares)
        return columns

    def middle(self) -> dict[str, Any]:
        """Return each variable's middle, of draws the estimate. A study is tried with it first."""
        half = np.array([0.5])
        return {
            row.name: 0
            if row.distribution == ESTIMATE_DISTRIBUTION
            else of_shares(row, half).tolist()[0]
            for row in self.rows
        }


def list_values(values: Sequence[float | str]) -> NDArray[Any]:
    """Return given values as an array of numbers or of words."""
    return np.array(values, object if isinstance(values[0], str) else np.float64)


def of_shares(row: VaryRow, shares: Numbers) -> NDArray[Any]:
    """Return the values of a variable below which ``shares`` of its distribution lie."""
    if row.values is not None:
        indices = np.minimum((shares * len(row.values)).astype(int), len(row.values) - 1)
        return np.asarray(list_values(row.values)[indices])
    if row.distribution == ESTIMATE_DISTRIBUTION:
        return np.asarray(1 + (shares * (SEED_LIMIT - 1.0)).astype(np.int64))  # numbers of draws
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

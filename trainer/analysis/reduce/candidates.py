"""Candidates fly side by side, one in each process.

A candidate is a compact set that the search tries: the full set's coefficients times factors.
``search`` asks for the differences of many at once, and for slopes; each takes a flight of every
leg, so they are spread over processes.
"""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import Final, Self

import numpy as np

from trainer.analysis.guide.programme import Leg
from trainer.analysis.reduce.objective import Candidate, Yardstick
from trainer.analysis.workers import worker_pool
from trainer.config.vessel import load_vessel
from trainer.core.kernel import Numbers

FACTOR_NUDGE: Final = 1e-3  # [-] of a factor, for the difference quotients
MAX_SLOPE: Final = 500.0  # [-] slope; a steeper one is a number that jumps, and tells nothing
CHUNK_FLIGHTS: Final = 4  # flights handed to a process at once


_worker_posts: dict[tuple[Path, str, tuple[Leg, ...]], tuple[Candidate, Yardstick]] = {}


def _differences(path: Path, equations: str, legs: tuple[Leg, ...], factors: Numbers) -> Numbers:
    """Return the differences of a candidate from the full set.

    Each process makes candidate and yardstick once and keeps them, because the yardstick flies all
    legs by the full set.
    """
    post = path, equations, legs
    if post not in _worker_posts:
        file = load_vessel(str(path))
        _worker_posts[post] = Candidate(file, equations), Yardstick(file, legs)
    candidate, yardstick = _worker_posts[post]
    candidate.take(factors)
    return yardstick.differences(candidate)


class CandidatePool:
    """Processes that each fly a candidate of the same boat."""

    def __init__(self, path: Path, equations: str, legs: tuple[Leg, ...], cores: int) -> None:
        """Start ``cores`` processes for the boat in the file at ``path``, to fly ``legs``."""
        self.legs = legs
        yardstick = Yardstick(load_vessel(str(path)), legs)
        self.rows, self._determined = yardstick.rows, yardstick.determined
        self._fly = partial(_differences, path, equations, legs)
        self._cores = cores
        self._pool = worker_pool(cores) if cores > 1 else None

    def __enter__(self) -> Self:
        """Return the pool."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the processes."""
        if self._pool:
            self._pool.shutdown(cancel_futures=True)

    def differences(self, several: Sequence[Numbers]) -> list[Numbers]:
        """Return the differences of several candidates by row, in the order of the candidates.

        A number that the hull's own coefficients do not determine has the difference 0.
        """
        if self._pool is None or len(several) == 1:
            flown: Iterable[Numbers] = map(self._fly, several)
        else:
            chunk = max(1, min(CHUNK_FLIGHTS, len(several) // self._cores))
            flown = self._pool.map(self._fly, several, chunksize=chunk)
        return [self._determined * differences for differences in flown]

    def slopes(self, factors: Numbers, free: Sequence[int], here: Numbers) -> Numbers:
        """Return the slopes of the differences by ``free`` factors, (rows, all factors)."""
        nudged = []
        for index in free:
            point = factors.copy()
            point[index] += FACTOR_NUDGE
            nudged.append(point)
        slopes = np.zeros((here.size, factors.size))
        for index, point in zip(free, self.differences(nudged), strict=True):
            slopes[:, index] = (point - here) / FACTOR_NUDGE
        return np.where(abs(slopes) > MAX_SLOPE, 0.0, slopes)

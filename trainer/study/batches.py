"""The cost of short work, measured over batches long enough for the clock."""

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

BATCHES: Final = 21
BATCH_NS: Final = 10_000_000  # [ns] a batch takes at least; the clock resolves far better


@dataclass(frozen=True)
class Batches:
    """The cost of one repetition: over batches of equal length, the median and the least."""

    median_ns: float
    least_ns: float
    batches: int
    repetitions: int  # in a batch


def time_batches(works: Sequence[Callable[[int], None]]) -> list[Batches]:
    """Return the cost of one repetition of each of ``works``, called with how many to do.

    Their batches take turns, so that a change of the machine's pace meets them all.
    """
    counts = [long_enough(work) for work in works]
    costs = [
        [clocked(work, count) / count for work, count in zip(works, counts, strict=True)]
        for _ in range(BATCHES)
    ]
    return [
        Batches(statistics.median(cost), min(cost), BATCHES, count)
        for cost, count in zip(zip(*costs, strict=True), counts, strict=True)
    ]


def long_enough(work: Callable[[int], None]) -> int:
    """Return a number of repetitions that takes at least a batch's time, also undisturbed.

    The best of three tells: neither the compiling of a first call nor an interruption counts.
    """
    count = 1
    while min(clocked(work, count) for _ in range(3)) < BATCH_NS:
        count *= 2
    return count


def clocked(work: Callable[[int], None], count: int) -> int:
    """Return the time [ns] that ``count`` repetitions take."""
    start = time.perf_counter_ns()
    work(count)
    return time.perf_counter_ns() - start

"""Works timed in turn, so that a change of the machine's pace meets them all."""

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

ROUNDS: Final = 25
BATCH_S: Final = 4e-3  # [s] a batch takes at least

Work = Callable[[], object]


@dataclass(frozen=True)
class Paces:
    """Times [s] of one call of each work, by this thread's clock, in rounds."""

    rounds: tuple[tuple[float, ...], ...]

    def median(self, work: int) -> float:
        """Return the time [s] of a call."""
        return statistics.median(times[work] for times in self.rounds)

    def ratio(self, work: int, other: int) -> float:
        """Return the median over rounds of a work's time by another's [-]."""
        return statistics.median(times[work] / times[other] for times in self.rounds)


def time_in_turn(works: Sequence[Work]) -> Paces:
    """Return what each of ``works`` takes, in short batches that take turns."""
    counts = [_enough(work) for work in works]
    return Paces(
        tuple(
            tuple(_seconds(work, count) for work, count in zip(works, counts, strict=True))
            for _ in range(ROUNDS)
        )
    )


def _enough(work: Work) -> int:
    """Return how many calls make a batch."""
    work()  # compiles
    count = 1
    while count * _seconds(work, count) < BATCH_S:
        count *= 2
    return count


def _seconds(work: Work, count: int) -> float:
    """Return the thread's time [s] of one of ``count`` calls."""
    begun = time.thread_time()
    for _ in range(count):
        work()
    return (time.thread_time() - begun) / count

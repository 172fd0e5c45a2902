"""The time of work by batches that take turns.

Batches are long against the clock's resolution, and the median of them counts, because other
programs can only make a batch longer. A boat is put back before each.
"""

import statistics
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

from trainer.analysis.bench.ticks import BATCH_COUNT, trouble_of
from trainer.boat.boat import Boat
from trainer.config.files import ConfigError

BATCH_NS: Final = 10_000_000  # [ns] a batch takes at least; the clock resolves far better
SEA_NAME: Final = "sea-state-5"


@dataclass(frozen=True)
class BatchCost:
    """The cost of one repetition: over batches of equal length, the median and the least."""

    median_ns: float
    least_ns: float
    batches: int
    repetitions: int  # in a batch


def time_batches(works: Sequence[Callable[[int], object]]) -> list[BatchCost]:
    """Return the cost of one repetition of each of ``works``. Each is called with a count.

    The batches of all works take turns, because the machine's pace may change and must then change
    for all of them.
    """
    counts = [long_enough(work) for work in works]
    costs = [
        [time_repetitions(work, count) / count for work, count in zip(works, counts, strict=True)]
        for _ in range(BATCH_COUNT)
    ]
    return [
        BatchCost(statistics.median(cost), min(cost), BATCH_COUNT, count)
        for cost, count in zip(zip(*costs, strict=True), counts, strict=True)
    ]


def long_enough(work: Callable[[int], object]) -> int:
    """Return a number of repetitions that takes at least a batch's time.

    The shortest of three times decides, because the first call may compile and another program may
    interrupt: both only lengthen a time.
    """
    count = 1
    while min(time_repetitions(work, count) for _ in range(3)) < BATCH_NS:
        count *= 2
    return count


def time_repetitions(work: Callable[[int], object], count: int) -> int:
    """Return the time [ns] that ``count`` repetitions take.

    A boat's ``Voyage`` is put back before; ConfigError where it was none afterwards.
    """
    if isinstance(work, Voyage):
        work.put_back()
    start = time.perf_counter_ns()
    work(count)
    taken = time.perf_counter_ns() - start
    if isinstance(work, Voyage) and (trouble := work.trouble(count)):
        raise ConfigError(f"{work.name} has no figure in a benchmark: {trouble}")
    return taken


@dataclass(frozen=True)
class Voyage:
    """Work with a boat that is put back before each batch."""

    name: str
    work: Callable[[int], object]
    put_back: Callable[[], object]
    trouble: Callable[[int], str]  # after so many repetitions; "" for none

    def __call__(self, count: int) -> None:
        """Do so many repetitions."""
        self.work(count)

    @classmethod
    def of(cls, boat: Boat, work: Callable[[int], object]) -> "Voyage":
        """Return work with a boat that takes a tick at least in each repetition."""
        put_back = partial(boat.restore, boat.snapshot())
        return cls(boat.file.path.name, work, put_back, partial(trouble_of, boat, boat.ticks))

"""Counters and histograms of the ticks: how long each worked, and how late it began.

Times are integer nanoseconds. A histogram has bins whose width grows with the duration (1/32 of
it), so its memory does not grow with the run. ``pacer`` fills it at each tick; ``status`` and the
summary of a run read it.
"""

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Final

import numpy as np

SECOND_NS: Final = 1_000_000_000  # [ns]
OCTAVE_BITS = 6  # [bits] of a duration that its bin keeps: the first one and the next five
OCTAVE_BINS = 32  # [-] histogram bins to a factor of two: a percentile is at most 1/32 too high
EXACT_BELOW_NS = 2 * OCTAVE_BINS  # [ns] what is below it has a bin of its own


@dataclass(frozen=True)
class Spread:
    """Three percentiles of durations, at most 1/32 too high, and the exact maximum."""

    p50_ns: int
    p99_ns: int
    p999_ns: int
    max_ns: int


@dataclass(frozen=True)
class Summary:
    """The ledger in a few numbers."""

    ticks: int
    duty_cycle: float  # [-] work / (ticks h): share of real time, whatever the speed was
    work: Spread
    lateness: Spread
    overruns: int  # ticks that were still at work at the next deadline, or for over a period
    caught_up: int  # ticks begun more than a period late
    skipped: int  # deadlines given up by slipping
    gaps: int  # times the process was not running
    gap_ns: int


class Histogram:
    """Counts of durations in fixed logarithmic bins."""

    def __init__(self) -> None:
        self._counts = [0] * (59 * OCTAVE_BINS)  # up to 2^63 ns; a list counts four times as fast
        self._largest = 0

    def add(self, duration: int, count: int = 1) -> None:
        """Count ``duration`` [ns] so often; a negative one counts as 0."""
        index = duration if duration > 0 else 0  # noqa: FURB136  max() takes as long as all the rest
        if index >= EXACT_BELOW_NS:
            shift = index.bit_length() - OCTAVE_BITS
            index = shift * OCTAVE_BINS + (index >> shift)
        self._counts[index] += count
        if duration > self._largest:  # noqa: PLR1730
            self._largest = duration

    def spread(self) -> Spread:
        """Return the percentiles [ns], all 0 when nothing was counted."""
        reached = np.cumsum(self._counts)
        ranks = [-(-int(reached[-1]) * permille // 1000) for permille in (500, 990, 999)]
        p50, p99, p999 = (self._top(int(np.searchsorted(reached, rank))) for rank in ranks)
        return Spread(p50, p99, p999, self._largest)

    def _top(self, index: int) -> int:
        shift = max(index // OCTAVE_BINS - 1, 0)
        return min(((index - shift * OCTAVE_BINS + 1) << shift) - 1, self._largest)


class Ledger:
    """The counts of the ticks. Its size never changes."""

    def __init__(self, step: float) -> None:
        """Take the step h [s]; ValueError unless it is finite and above 0."""
        if not (math.isfinite(step) and step > 0):
            raise ValueError(f"step {step} s is not a finite time above 0")
        self.step = Fraction(str(step))  # [s] 1/10 when 0.1 was typed
        self.ticks = self.overruns = self.caught_up = self.skipped = self.gaps = 0
        self.gap_ns = 0
        self.lateness = self.work = 0  # [ns] of the last tick
        self._worked = 0
        self._work, self._lateness = Histogram(), Histogram()

    def record(self, deadline: int, start: int, work: int, count: int = 1) -> None:
        """Enter one tick [ns], or so many alike."""
        self.work, self.lateness = work, (lateness := start - deadline)
        self.ticks += count
        self._worked += work * count
        self._work.add(work, count)
        self._lateness.add(lateness, count)

    def summary(self) -> Summary:
        """Return the state of the ledger."""
        return Summary(
            ticks=self.ticks,
            duty_cycle=float(self._worked / (max(self.ticks, 1) * self.step * SECOND_NS)),
            work=self._work.spread(),
            lateness=self._lateness.spread(),
            overruns=self.overruns,
            caught_up=self.caught_up,
            skipped=self.skipped,
            gaps=self.gaps,
            gap_ns=self.gap_ns,
        )

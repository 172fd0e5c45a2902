"""Axes: from numbers to places on the paper, round ticks, and lines thinned to what shows."""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers

ROUND: Final = (1.0, 2.0, 2.5, 5.0, 10.0)
ANGLES: Final = (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0)  # [deg]
TIMES: Final = (5.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 3600.0, 7200.0)  # [s]


@dataclass(frozen=True)
class Axis:
    """A stretch of numbers laid on a stretch of paper."""

    low: float
    high: float
    begin: float  # [px] where low is
    end: float

    def at(self, value: float) -> float:
        """Return the place [px] of a number."""
        return self.begin + (value - self.low) / (self.high - self.low) * (self.end - self.begin)

    def places(self, values: Numbers) -> Numbers:
        """Return the places [px] of numbers."""
        share = (values - self.low) / (self.high - self.low)
        return self.begin + share * (self.end - self.begin)


def step_of(span: float, most: int, steps: tuple[float, ...] = ()) -> float:
    """Return a round step that goes into ``span`` at most ``most`` times, of ``steps`` if any."""
    for step in steps:
        if span / step <= most:
            return step
    power = 10.0 ** math.floor(math.log10(span / most))
    return next(power * each for each in ROUND if span / (power * each) <= most + 1e-9)


def ticks(low: float, high: float, step: float) -> list[float]:
    """Return the multiples of ``step`` from ``low`` to ``high``."""
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [step * i for i in range(first, last + 1)]


def clock(seconds: float) -> str:
    """Return a time as minutes and seconds, from an hour on with hours."""
    tenths = round(seconds * 10.0)
    whole, tenth = divmod(tenths, 10)
    minutes, second = divmod(whole, 60)
    rest = f"{second:02d}" + (f".{tenth}" if tenth else "")
    if minutes < 60:
        return f"{minutes}:{rest}"
    return f"{minutes // 60}:{minutes % 60:02d}:{rest}"


def thinned(x: Numbers, y: Numbers, most: int) -> tuple[Numbers, Numbers]:
    """Return at most about ``most`` points of a line, with the extremes of every stretch."""
    if x.size <= most:
        return x, y
    kept = {0, x.size - 1}
    for stretch in np.array_split(np.arange(x.size), most // 2):
        kept |= {int(stretch[np.argmin(y[stretch])]), int(stretch[np.argmax(y[stretch])])}
    rows = np.array(sorted(kept))
    return x[rows], y[rows]

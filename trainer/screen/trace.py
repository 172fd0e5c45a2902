"""What has been ordered and what has become of it over the last minutes, for strip charts."""

import bisect
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, NamedTuple

KEPT: Final = 4800  # ticks: 40 minutes at half a second


class Sample(NamedTuple):
    """A quantity at one time; None where nothing is ordered, or the boat lacks it."""

    actual: float | None
    ordered: float | None


@dataclass
class Trace:
    """Samples of some quantities, by time."""

    quantities: int
    times: list[float] = field(default_factory=list)  # [s]
    samples: list[Sequence[Sample]] = field(default_factory=list)

    def add(self, seconds: float, samples: Sequence[Sample]) -> None:
        """Add what there is at a time; what was later is forgotten: time has gone back."""
        place = bisect.bisect_left(self.times, seconds)
        del self.times[place:], self.samples[place:]
        self.times.append(seconds)
        self.samples.append(tuple(samples))
        if len(self.times) > KEPT + KEPT // 4:
            del self.times[:-KEPT], self.samples[:-KEPT]

    def series(self, quantity: int, span: float, columns: int) -> list[Sample | None]:
        """Return a quantity over the last ``span`` [s] at so many times, None before the first."""
        if not self.times:
            return [None] * columns
        end, found = self.times[-1], []
        for column in range(columns):
            when = end - span * (columns - 1 - column) / max(columns - 1, 1)
            place = bisect.bisect_right(self.times, when + 1e-9) - 1
            found.append(self.samples[place][quantity] if place >= 0 else None)
        return found

"""The states after ticks that were flown at once, for monitors of each tick.

A monitor says of them after how many ticks it may have something to call (``quiet_ticks``), and
takes those as seen that come before (``pass_over``). So it need not look at each.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import STATE_OFFSETS
from trainer.core.kernel import Numbers
from trainer.core.state import STATE

ALL_OFFSETS: Final = np.arange(STATE.itemsize // 8)  # of a state's numbers

Mask = NDArray[np.bool_]  # one for each tick


class FlownTicks:
    """The states after ticks in a row, by the names of their numbers."""

    def __init__(self, rows: Numbers, step: float) -> None:
        """Take whole states, a row each, and the time [s] from tick to tick."""
        self.rows = rows
        self.ticks: NDArray[np.int64] = self["tick"].astype(np.int64)
        self.times = self["tick"] * step  # [s]

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.rows)

    def __getitem__(self, name: str) -> Numbers:
        """Return a number of the state, or the first of a block, at each tick."""
        return self.rows[:, STATE_OFFSETS[name]]

    def table(self, names: Sequence[str]) -> list[list[float]]:
        """Return numbers of the state, a row for each tick; ``t`` is the time [s]."""
        columns = [self.times if name == "t" else self[name] for name in names]
        rows: list[list[float]] = np.column_stack(columns).tolist() if columns else []
        return rows

    def block(self, name: str, count: int) -> Numbers:
        """Return the first numbers of a block at each tick, a row each."""
        first = STATE_OFFSETS[name]
        return self.rows[:, first : first + count]


def count_before(mask: Mask) -> int:
    """Return how many ticks there are before the first in the mask, or all.

    So many may be passed over without a look.
    """
    return int(mask.argmax()) if mask.any() else mask.size

"""The latest moments of a branch, in memory that is taken once and for all at the start."""

from typing import Final

import numpy as np

from trainer.io.recording import Moment

NUMBERS: Final = 4  # branch, tick, after and place of a moment
TOUCHED: Final = 255  # written everywhere at first, so that the memory is really there


class Moments:
    """A ring of moments in the order of their ticks; the oldest gives way to a new one."""

    def __init__(self, most: int, size: int) -> None:
        """Take room for so many moments, each with a state of so many bytes."""
        self._states = np.full((most, size), TOUCHED, dtype=np.uint8)
        self._numbers = np.full((most, NUMBERS), TOUCHED, dtype=np.int64)
        self._begin = 0
        self._count = 0

    def __len__(self) -> int:
        """Return how many are kept."""
        return self._count

    def append(self, moment: Moment) -> None:
        """Keep a moment, later than all that are kept."""
        most = len(self._states)
        at = (self._begin + self._count) % most
        self._states[at] = np.frombuffer(moment.state, np.uint8)
        self._numbers[at] = (moment.branch, moment.tick, moment.after, moment.place)
        if self._count < most:
            self._count += 1
        else:
            self._begin = (self._begin + 1) % most

    def before(self, tick: int) -> Moment | None:
        """Return the last moment at a tick or before it, None if none is kept."""
        for back in range(self._count - 1, -1, -1):
            if self._tick(back) <= tick:
                return self._at(back)
        return None

    def forget_after(self, tick: int) -> None:
        """Drop those that are later than a tick."""
        while self._count and self._tick(self._count - 1) > tick:
            self._count -= 1

    def clear(self) -> None:
        """Drop them all."""
        self._count = 0

    def _place(self, index: int) -> int:
        return (self._begin + index) % len(self._states)

    def _tick(self, index: int) -> int:
        return int(self._numbers[self._place(index), 1])

    def _at(self, index: int) -> Moment:
        at = self._place(index)
        branch, tick, after, place = self._numbers[at].tolist()
        return Moment(branch, tick, self._states[at].tobytes(), after, place)

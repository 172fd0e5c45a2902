"""The latest moments of a branch, in a ring of memory allocated at the start.

``history`` keeps one moment every 10 s here, to go back to when the recording cannot be read, or
there is none. The memory is allocated once, because a tick that allocates may be late.
"""

import struct
from typing import Final

from trainer.io.recording.recording import Moment

FILL_BYTE: Final = b"\xff"  # not zero, because a system gives zeroed memory only when it is used


class Moments:
    """A ring of moments in the order of their ticks. The oldest gives way to a new one."""

    def __init__(self, most: int, size: int) -> None:
        """Take room for so many moments, each with a state of so many bytes."""
        self._most = most
        self._row = struct.Struct(f"=4q{size}s")  # branch, tick, after, place and state
        self._rows = bytearray(FILL_BYTE * (most * self._row.size))
        self._begin = 0
        self._count = 0

    def __len__(self) -> int:
        """Return how many moments are kept."""
        return self._count

    def append(self, moment: Moment) -> None:
        """Keep a moment, which has to be later than all that are kept."""
        numbers = moment.branch, moment.tick, moment.after, moment.place
        self._row.pack_into(self._rows, self._place(self._count), *numbers, moment.state)
        if self._count < self._most:
            self._count += 1
        else:
            self._begin = (self._begin + 1) % self._most

    def before(self, tick: int) -> Moment | None:
        """Return the last moment at a tick or before it, None if none is kept."""
        for back in range(self._count - 1, -1, -1):  # the wanted moment is mostly a late one
            moment = self._at(back)
            if moment.tick <= tick:
                return moment
        return None

    def since(self, tick: int) -> list[tuple[int, bytes]]:
        """Return tick and state of the moments at a tick or after it, oldest first."""
        every = (self._at(index) for index in range(self._count))
        return [(moment.tick, moment.state) for moment in every if moment.tick >= tick]

    def forget_after(self, tick: int) -> None:
        """Drop the moments after a tick."""
        while self._count and self._at(self._count - 1).tick > tick:
            self._count -= 1

    def clear(self) -> None:
        """Drop them all."""
        self._count = 0

    def _place(self, index: int) -> int:
        return (self._begin + index) % self._most * self._row.size

    def _at(self, index: int) -> Moment:
        row = self._row.unpack_from(self._rows, self._place(index))
        branch, tick, after, place, state = row
        return Moment(branch, tick, state, after, place)

"""The track: straight pieces between places that the boat has come by."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.session.rerun.batch import Block, Times


class Track:
    """Where the last piece ended, from block to block."""

    def __init__(self, spacing: float) -> None:
        """Take the distance [m] from place to place."""
        self._spacing = spacing
        self._kept: Numbers = np.zeros(3)  # the last place
        self._tick = self._branch = -1  # of the last row, which may be beyond it; none yet

    def pieces(self, block: Block) -> Iterator[tuple[Times, NDArray[np.float32]]]:
        """Yield the new pieces, two ends each, with the times at which they were finished.

        A new line begins where the run was wound back, or went on from elsewhere.
        """
        places, ticks = block.several("x", "y", "z"), block.times.ticks
        broken = np.diff(ticks, prepend=self._tick) <= 0
        broken |= np.diff(block.branch, prepend=self._branch) != 0
        for rows in np.split(np.arange(ticks.size), np.flatnonzero(broken)):
            if not rows.size:
                continue
            if broken[rows[0]]:
                self._kept = places[rows[0]]
            ends, strips = self._follow(places[rows])
            if ends.size:
                yield Times(ticks[rows[ends]], block.times.seconds[rows[ends]]), strips
        self._tick, self._branch = int(ticks[-1]), int(block.branch[-1])

    def _follow(self, places: Numbers) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
        """Return at which places pieces end, and the pieces."""
        line = np.concatenate((self._kept[None], places))
        run = np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)) // self._spacing
        ends = np.flatnonzero(np.diff(run, prepend=0.0) > 0.0)
        corners = np.concatenate((line[:1], places[ends])).astype(np.float32)
        self._kept = places[ends[-1]] if ends.size else self._kept
        return ends, np.stack((corners[:-1], corners[1:]), axis=1)

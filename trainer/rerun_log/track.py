"""The track: straight pieces between places that the boat has come by."""

from collections.abc import Iterator

import numpy as np

from trainer.rerun_log.batch import Block, Numbers, Times


class Track:
    """Where the last piece ended, from block to block."""

    def __init__(self, spacing: float) -> None:
        """Take the distance [m] from place to place."""
        self._spacing = spacing
        self._kept: Numbers | None = None  # the last place
        self._tick = 0  # of the last row, which may be beyond it

    def pieces(self, block: Block) -> Iterator[tuple[Times, Numbers]]:
        """Yield the new pieces with the times at which they were finished.

        Where the run was wound back a new line begins.
        """
        places, ticks = block.several("x", "y", "z"), block.times.ticks
        if not ticks.size:
            return
        unbroken = np.diff(ticks, prepend=self._tick) > 0
        unbroken[0] &= self._kept is not None
        for stretch in np.split(np.arange(ticks.size), np.flatnonzero(~unbroken)):
            if stretch.size:
                if not unbroken[stretch[0]]:
                    self._kept = places[stretch[0]]
                yield from self._stretch(block.times, places, stretch)
        self._tick = int(ticks[-1])

    def _stretch(
        self, times: Times, places: Numbers, rows: np.ndarray
    ) -> Iterator[tuple[Times, Numbers]]:
        """Yield the pieces of rows that follow one another."""
        line = np.concatenate((self._kept[None], places[rows])) if self._kept is not None else places
        run = np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)) // self._spacing
        ends = np.flatnonzero(np.diff(run, prepend=0.0) > 0.0)
        if not ends.size:
            return
        corners = np.concatenate((line[:1], line[ends + 1]))
        self._kept = corners[-1]
        found = rows[ends]
        strips = np.stack((corners[:-1], corners[1:]), axis=1)
        yield Times(times.ticks[found], times.seconds[found]), strips

"""Changes: of what seldom changes, the rows at which it does."""

import numpy as np
from numpy.typing import NDArray


class Changes:
    """The last value of each thing, from block to block."""

    def __init__(self) -> None:
        self._last: dict[str, NDArray[np.generic]] = {}

    def of(self, name: str, values: NDArray[np.generic]) -> NDArray[np.bool_]:
        """Return at which rows a thing is not what it was in the row before."""
        rows = np.ones(len(values), np.bool_)
        if len(values) == 0:
            return rows
        before = values[:-1]
        if name in self._last:
            before = np.concatenate((self._last[name][None], before))
        same = before == values[len(values) - len(before) :]
        rows[len(values) - len(before) :] = ~same.reshape(len(before), -1).all(axis=1)
        self._last[name] = values[-1].copy()
        return rows

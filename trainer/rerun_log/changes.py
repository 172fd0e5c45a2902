"""Changes: of what seldom changes, the rows at which it does."""

import numpy as np
from numpy.typing import NDArray


class Changes:
    """The last value of each thing, from block to block."""

    def __init__(self) -> None:
        self._last: dict[str, NDArray[np.generic]] = {}

    def of(self, name: str, values: NDArray[np.generic]) -> NDArray[np.bool_]:
        """Return at which rows, one at least, a thing is not what it was in the row before."""
        last = self._last.get(name)
        before = np.concatenate((values[:1] if last is None else last[None], values[:-1]))
        rows: NDArray[np.bool_] = (before != values).reshape(len(values), -1).any(axis=1)
        rows[0] |= last is None
        self._last[name] = values[-1].copy()
        return rows

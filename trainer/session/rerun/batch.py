"""The subject that the viewer shows, and batches of columns on their way there."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import Boat
from trainer.config.exercise import Limits
from trainer.core.kernel import Numbers
from trainer.session.layout import LAYOUT
from trainer.session.plan import Plan


@dataclass(frozen=True, eq=False)
class Subject:
    """The subject of a picture. Nothing of the boat that moves is looked at."""

    boat: Boat
    limits: Limits
    title: str

    @classmethod
    def of(cls, plan: Plan, boat: Boat) -> "Subject":
        """Return the boat of a plan as the subject."""
        return cls(boat, plan.limits, plan.title or boat.file.name)

    @property
    def length(self) -> float:
        """Return the boat's length [m]."""
        return float(self.boat.vessel.ell)

    @property
    def step(self) -> float:
        """Return the time [s] from tick to tick."""
        return self.boat.method.step


Whole = NDArray[np.int64]

PLACES: Final[Mapping[str, int]] = {name: i for i, name in enumerate(LAYOUT)}


class Times(NamedTuple):
    """When each row was."""

    ticks: Whole  # [-] of the run: they go back where it is wound back
    seconds: Numbers  # [s] these never do

    @classmethod
    def of(cls, ticks: Sequence[int], seconds: Sequence[float]) -> "Times":
        """Return the times of rows of these ticks and times [s]."""
        return cls(np.array(ticks, np.int64), np.array(seconds, np.float64))

    def at(self, rows: NDArray[np.bool_]) -> "Times":
        """Return the times of some of the rows."""
        return Times(self.ticks[rows], self.seconds[rows])


@dataclass(frozen=True, eq=False)
class Block:
    """The states of some ticks, one row each."""

    times: Times
    whole: Numbers  # [SI] by row and by place of LAYOUT
    branch: Whole  # [-] of the recording
    replaying: NDArray[np.bool_]

    def __getitem__(self, name: str) -> Numbers:
        """Return a number of the state [SI], by its name in the layout, for each row."""
        return self.whole[:, PLACES[name]]

    def several(self, *names: str) -> Numbers:
        """Return numbers of the state [SI], with a row for each tick."""
        return self.whole[:, [PLACES[name] for name in names]]


class Worked(NamedTuple):
    """The results of ticks that were timed."""

    times: Times
    lateness: Numbers  # [ns]
    work: Numbers  # [ns]


class Told(NamedTuple):
    """Things that happened, one kind and text for each row."""

    times: Times
    kinds: tuple[str, ...]
    texts: tuple[str, ...]


class Batch(NamedTuple):
    """All of some ticks; any part may be empty."""

    block: Block
    worked: Worked
    told: Told


def states(parts: list[bytes], layout: tuple[str, ...]) -> Numbers:
    """Return states of a layout as rows of this version's. What that layout lacks is zero.

    ValueError if one of them is not of the layout's length.
    """
    read = np.frombuffer(b"".join(parts)).reshape(len(parts), len(layout))
    if layout == LAYOUT:
        return read
    whole = np.zeros((len(parts), len(LAYOUT)))
    for i, name in enumerate(layout):
        if name in PLACES:
            whole[:, PLACES[name]] = read[:, i]
    return whole


class Changes:
    """The last value of each thing, from block to block."""

    def __init__(self) -> None:
        self._last: dict[str, NDArray[np.generic]] = {}

    def of(self, name: str, values: NDArray[np.generic]) -> NDArray[np.bool_]:
        """Return the rows, at least one, where a thing differs from the row before."""
        last = self._last.get(name)
        before = np.concatenate((values[:1] if last is None else last[None], values[:-1]))
        rows: NDArray[np.bool_] = (before != values).reshape(len(values), -1).any(axis=1)
        rows[0] |= last is None
        self._last[name] = values[-1].copy()
        return rows

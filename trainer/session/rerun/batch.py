"""The states and events of a run, gathered into arrays as Rerun's viewer takes them.

``feed`` collects what the session hands over, and gives it on in batches, because a call of Rerun's
library for each tick would cost more than the tick. ``drawing`` makes columns of each batch. Ticks
go back where a run is wound back, but the viewer's time always goes on. The work of a tick is known
only after its state has been handed over, so it comes with the next one.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import Boat
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.core.kernel import Numbers
from trainer.session.past.layout import LAYOUT
from trainer.session.past.plan import Plan
from trainer.session.stations.view import Pace

IntArray = NDArray[np.int64]

STATE_OFFSETS: Final[Mapping[str, int]] = {name: i for i, name in enumerate(LAYOUT)}


@dataclass(frozen=True, eq=False)
class Subject:
    """The subject of a picture: a boat, for its constants alone."""

    boat: Boat
    limits: ExerciseLimits
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


class Times(NamedTuple):
    """When each row was."""

    ticks: IntArray  # [-] of the run: they go back where it is wound back
    seconds: Numbers  # [s] these never do

    def at(self, rows: NDArray[np.bool_]) -> "Times":
        """Return the times of some of the rows."""
        return Times(self.ticks[rows], self.seconds[rows])


@dataclass(frozen=True, eq=False)
class Block:
    """The states of some ticks, one row each."""

    times: Times
    whole: Numbers  # [SI] by row and by offset of LAYOUT
    branch: IntArray  # [-] of the recording
    replaying: NDArray[np.bool_]

    def __getitem__(self, name: str) -> Numbers:
        """Return a number of the state [SI], by its name in the layout, for each row."""
        return self.whole[:, STATE_OFFSETS[name]]

    def several(self, *names: str) -> Numbers:
        """Return numbers of the state [SI], with a row for each tick."""
        return self.whole[:, [STATE_OFFSETS[name] for name in names]]


class TickTimings(NamedTuple):
    """The results of ticks that were timed."""

    times: Times
    lateness: Numbers  # [ns]
    work: Numbers  # [ns]


class NewsRows(NamedTuple):
    """Things that happened, one kind and text for each row."""

    times: Times
    kinds: tuple[str, ...]
    texts: tuple[str, ...]


class Batch(NamedTuple):
    """All of some ticks; any part may be empty."""

    block: Block
    worked: TickTimings
    told: NewsRows


def states(parts: list[bytes], layout: tuple[str, ...]) -> Numbers:
    """Return states of a layout as rows of this version's. Numbers it lacks are zero.

    ValueError if one of them is not of the layout's length.
    """
    read = np.frombuffer(b"".join(parts)).reshape(len(parts), len(layout))
    if layout == LAYOUT:
        return read
    whole = np.zeros((len(parts), len(LAYOUT)))
    for i, name in enumerate(layout):
        if name in STATE_OFFSETS:
            whole[:, STATE_OFFSETS[name]] = read[:, i]
    return whole


class TakenPicture(NamedTuple):
    """A picture as it was handed over, and the ledger at that moment."""

    tick: int
    state: bytes
    pace: Pace
    timed: int  # ticks in the ledger
    lateness: int  # [ns] of the last of them
    work: int  # [ns]


class TakenNews(NamedTuple):
    """News, as they were handed over."""

    tick: int
    kind: str
    text: str


class TimedRows:
    """Some of what was handed over, with its times. Columns spare Python's garbage collector."""

    def __init__(self) -> None:
        self.handed: list[Any] = []
        self.ticks: list[int] = []
        self.seconds: list[float] = []

    def add(self, handed: TakenPicture | TakenNews, tick: int, seconds: float) -> None:
        """Take one with its tick and time [s]."""
        self.handed.append(handed)
        self.ticks.append(tick)
        self.seconds.append(seconds)

    @property
    def times(self) -> Times:
        """Return when each was."""
        return Times(np.array(self.ticks, np.int64), np.array(self.seconds, np.float64))


def batch_of(
    pictures: TimedRows, timed: TimedRows, told: TimedRows, layout: tuple[str, ...] = LAYOUT
) -> Batch:
    """Return a batch of pictures, of those whose work was timed, and of news."""
    taken: list[TakenPicture] = pictures.handed
    block = Block(
        pictures.times,
        states([each.state for each in taken], layout),
        np.array([each.pace.branch for each in taken], np.int64),
        np.array([each.pace.replaying for each in taken], np.bool_),
    )
    lateness = np.array([each.lateness for each in timed.handed], np.float64)
    work = np.array([each.work for each in timed.handed], np.float64)
    kinds = tuple(heard.kind for heard in told.handed)
    texts = tuple(heard.text for heard in told.handed)
    return Batch(
        block, TickTimings(timed.times, lateness, work), NewsRows(told.times, kinds, texts)
    )


class BatchCollector:
    """A maker of batches, which knows from one to the next where the run stands."""

    def __init__(self, step: float) -> None:
        """Take the step [s]."""
        self._step = step
        self._last: TakenPicture | None = None
        self._seconds = 0.0  # of the last picture

    def batch(self, handed: Sequence[TakenPicture | TakenNews]) -> Batch:
        """Return what was handed over, in that order."""
        pictures, timed, news = TimedRows(), TimedRows(), TimedRows()
        for item in handed:
            if isinstance(item, TakenNews):
                news.add(item, item.tick, self._seconds)
                continue
            last = self._last
            if last is not None and item.timed != last.timed:
                timed.add(item, last.tick, self._seconds)
            if self._moved(last, item):
                pictures.add(item, item.tick, self._seconds)
            self._last = item
        return batch_of(pictures, timed, news)

    def _moved(self, last: TakenPicture | None, taken: TakenPicture) -> bool:
        """Advance the viewer's time to a picture; return whether it is a new one."""
        if last is None:
            self._seconds = taken.tick * self._step
            return True
        ahead, same = taken.tick - last.tick, taken.pace.branch == last.pace.branch
        if ahead == 0 and (same or taken.state == last.state):
            return False  # what was ordered at a tick is seen after it
        self._seconds += (ahead if ahead > 0 and same else 1) * self._step
        return True


class Changes:
    """A finder of changes, which keeps the last value of each thing between blocks."""

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


class Track:
    """A maker of the pieces of the track, the line that the boat leaves behind.

    It keeps the last end between blocks.
    """

    def __init__(self, spacing: float) -> None:
        """Take the distance [m] from point to point."""
        self._spacing = spacing
        self._kept: Numbers = np.zeros(3)  # the last point
        self._tick = self._branch = -1  # of the last row, which may be beyond it; none yet

    def pieces(self, block: Block) -> Iterator[tuple[Times, NDArray[np.float32]]]:
        """Yield the new pieces, two ends each, with the times at which they were finished.

        A new line begins where the run was wound back, or went on from elsewhere.
        """
        points, ticks = block.several("x", "y", "z"), block.times.ticks
        broken = np.diff(ticks, prepend=self._tick) <= 0
        broken |= np.diff(block.branch, prepend=self._branch) != 0
        for rows in np.split(np.arange(ticks.size), np.flatnonzero(broken)):
            if not rows.size:
                continue
            if broken[rows[0]]:
                self._kept = points[rows[0]]
            ends, strips = self._follow(points[rows])
            if ends.size:
                yield Times(ticks[rows[ends]], block.times.seconds[rows[ends]]), strips
        self._tick, self._branch = int(ticks[-1]), int(block.branch[-1])

    def _follow(self, points: Numbers) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
        """Return at which points pieces end, and the pieces."""
        line = np.concatenate((self._kept[None], points))
        run = np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1)) // self._spacing
        ends = np.flatnonzero(np.diff(run, prepend=0.0) > 0.0)
        corners = np.concatenate((line[:1], points[ends])).astype(np.float32)
        self._kept = points[ends[-1]] if ends.size else self._kept
        return ends, np.stack((corners[:-1], corners[1:]), axis=1)

"""Gathering: what the tick has handed over, made into batches in another thread.

A run may be wound back, so that its ticks do; the time in the viewer goes on all the same. The time
of a tick's work is known only after its state has been handed over: it comes with the next.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from trainer.session.layout import LAYOUT
from trainer.session.rerun.batch import Batch, Block, Times, Told, Worked, states
from trainer.session.stations.view import Pace


class Taken(NamedTuple):
    """A picture as it was handed over, and the ledger at that moment."""

    tick: int
    state: bytes
    pace: Pace
    timed: int  # ticks in the ledger
    lateness: int  # [ns] of the last of them
    work: int  # [ns]


class Heard(NamedTuple):
    """News, as they were handed over."""

    tick: int
    kind: str
    text: str


Handed = Taken | Heard


class Gathering:
    """Where the run stands, from batch to batch."""

    def __init__(self, step: float) -> None:
        """Take the step [s]."""
        self._step = step
        self._last: Taken | None = None
        self._seconds = 0.0  # of the last picture

    def batch(self, handed: Sequence[Handed]) -> Batch:
        """Return what was handed over, in that order."""
        pictures, worked, told = Rows(), Rows(), Rows()
        for each in handed:
            if isinstance(each, Heard):
                told.add(each, each.tick, self._seconds)
                continue
            last = self._last
            if last is not None and each.timed != last.timed:
                worked.add(each, last.tick, self._seconds)
            if self._moved(last, each):
                pictures.add(each, each.tick, self._seconds)
            self._last = each
        return Batch(_block(pictures), _timings(worked), _told_rows(told))

    def _moved(self, last: Taken | None, taken: Taken) -> bool:
        """Let time go on to a picture; return whether it is another than the last."""
        if last is None:
            self._seconds = taken.tick * self._step
            return True
        ahead = taken.tick - last.tick
        if ahead == 0 and taken.state == last.state:
            return False
        same = ahead > 0 and taken.pace.branch == last.pace.branch
        self._seconds += (ahead if same else 1) * self._step
        return True


class Rows:
    """Some of what was handed over, with its times. In columns, which the collector passes by."""

    def __init__(self) -> None:
        self.handed: list[Any] = []
        self.ticks: list[int] = []
        self.seconds: list[float] = []

    def add(self, handed: Handed, tick: int, seconds: float) -> None:
        """Take one with its tick and time [s]."""
        self.handed.append(handed)
        self.ticks.append(tick)
        self.seconds.append(seconds)

    @property
    def times(self) -> Times:
        """Return when each was."""
        return Times.of(self.ticks, self.seconds)


def _block(rows: Rows) -> Block:
    paces = [taken.pace for taken in rows.handed]
    return Block(
        rows.times,
        states([taken.state for taken in rows.handed], LAYOUT),
        np.array([pace.branch for pace in paces], np.int64),
        np.array([pace.replaying for pace in paces], np.bool_),
    )


def _timings(rows: Rows) -> Worked:
    return Worked(
        rows.times,
        np.array([taken.lateness for taken in rows.handed], np.float64),
        np.array([taken.work for taken in rows.handed], np.float64),
    )


def _told_rows(rows: Rows) -> Told:
    kinds = tuple(heard.kind for heard in rows.handed)
    return Told(rows.times, kinds, tuple(heard.text for heard in rows.handed))

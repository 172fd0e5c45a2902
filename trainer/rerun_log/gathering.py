"""Gathering: what the tick has handed over, made into batches in another thread.

A run may be wound back, so that its ticks do; the time in the viewer goes on all the same. The time
of a tick's work is known only after its state has been handed over: it comes with the next.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from trainer.frame import Pace
from trainer.layout import LAYOUT
from trainer.rerun_log.batch import Batch, Block, Times, Told, Worked, states


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
        self._timed = 0

    def batch(self, handed: Sequence[Handed]) -> Batch:
        """Return what was handed over, in that order."""
        pictures: list[tuple[Taken, float]] = []
        worked: list[tuple[int, float, int, int]] = []
        told: list[tuple[Heard, float]] = []
        for each in handed:
            if isinstance(each, Heard):
                told.append((each, self._seconds))
                continue
            if self._last is not None and each.timed != self._timed:
                worked.append((self._last.tick, self._seconds, each.lateness, each.work))
            self._timed = each.timed
            if self._moved(each):
                pictures.append((each, self._seconds))
            self._last = each
        return Batch(_block(pictures), _worked(worked), _told(told))

    def _moved(self, taken: Taken) -> bool:
        """Let time go on to a picture; return whether it is another than the last."""
        last = self._last
        if last is None:
            self._seconds = taken.tick * self._step
            return True
        if taken.tick == last.tick and taken.state == last.state:
            return False
        ahead = taken.tick - last.tick
        flown = ahead if ahead > 0 and taken.pace.branch == last.pace.branch else 1
        self._seconds = math.fsum((self._seconds, flown * self._step))
        return True


def _block(pictures: list[tuple[Taken, float]]) -> Block:
    return Block(
        Times.of((taken.tick, seconds) for taken, seconds in pictures),
        states([taken.state for taken, _ in pictures], LAYOUT),
        np.array([taken.pace.branch for taken, _ in pictures], np.int64),
        np.array([taken.pace.replaying for taken, _ in pictures], np.bool_),
    )


def _worked(rows: list[tuple[int, float, int, int]]) -> Worked:
    return Worked(
        Times.of((tick, seconds) for tick, seconds, _, _ in rows),
        np.array([lateness for *_, lateness, _ in rows], np.float64),
        np.array([work for *_, work in rows], np.float64),
    )


def _told(rows: list[tuple[Heard, float]]) -> Told:
    return Told(
        Times.of((heard.tick, seconds) for heard, seconds in rows),
        tuple(heard.kind for heard, _ in rows),
        tuple(heard.text for heard, _ in rows),
    )

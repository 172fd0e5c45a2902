"""Scripts that go on from where others came for the first time.

When its time is over, a process may go on with other chance, more than once (``forks``), so the way
to a place is never flown twice. It goes on as long as it reaches something new: three milestones of
one process, in an order in which nobody has reached them. Where that is more than the mean of late,
it goes on in two ways; so processes grow long that meet something new (A. Ecoffet and others,
*Nature* 590, 2021: first return, then explore).
"""

import os
import pickle
import traceback
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count
from typing import Any, Final, NamedTuple

import numpy as np

from simulation.drawing import draw_script, redraw
from simulation.forks import FAILED, end_child, fork
from simulation.laws import Breach, Docket
from simulation.milestones import MILESTONES
from simulation.play import Stage, folder_in_memory
from simulation.script import Script

NEAR_S: Final = 12.0  # for which a process goes on at a time, at most (estimate)
LONG_S: Final = 100.0  # that a process has lived which goes on no more (estimate)
MOST_TICKS: Final = 1000  # that a script has flown which goes on no more (estimate)
MOST_LIVES: Final = 2  # processes that go on, one after the other (estimate)
MOST_WAYS: Final = 2  # on from one place (estimate)
MOST_OF_TREE: Final = 60  # times that something goes on from one beginning (estimate)
MOST_IDLE: Final = 2  # parts of a process that reach nothing new, before it ends (estimate)
FADE: Final = 0.9  # [-] of the mean that is left after each part of a process (estimate)
NUMBERS: Final = {name: number for number, name in enumerate(MILESTONES)}
Counts = dict[str, int]
Row = tuple[str, ...]  # the milestones of a process, in order


class Leaf(NamedTuple):
    """A script that was played to its end."""

    script: Script
    breaches: tuple[Breach, ...]
    trace: str  # the digest of all bytes
    processes: int
    reached: frozenset[str]
    counts: Counts  # of what no other script has that was played
    rows: tuple[Row, ...]  # of its processes
    at: float  # [s] of the processor that were used until then, by all who came before


class GoneOnError(Exception):
    """A process has gone on in its children, and needs no end of its own."""


@dataclass
class Explorer:
    """What was reached so far, and what is tried next."""

    seed: int
    longest: float  # that a process of a script lives which begins from nothing [s]
    known: Any = field(default_factory=lambda: np.zeros(3 * (len(MILESTONES),), dtype=bool))
    new: int = 0  # that was reached since the process went on itself
    idle: int = 0  # parts that reached nothing new, one after the other
    mean: float = 0.0  # of what is new in a part, of late
    _drawn: int = 0  # scripts
    _left: int = 0  # times that something may go on from this beginning
    _leaves: list[Leaf] = field(default_factory=list)
    _is_child: bool = False
    _used: float = 0.0  # [s] of the processor before this process, by those it comes from
    _counted: Counts = field(default_factory=dict)  # by others that have gone on from here
    _rows: dict[int, list[int]] = field(default_factory=dict)  # of each process
    _pairs: Any = None  # of the present process

    def explore(self) -> Iterator[Leaf]:
        """Play scripts, and those that go on from them, without end."""
        for _ in count():
            yield from self.grow()

    def grow(self) -> list[Leaf]:
        """Play a new script, and those that go on from it."""
        self._drawn += 1
        self._left, self._leaves = MOST_OF_TREE, []
        self._rows, self._counted, self.new, self.idle = {}, {}, 0, 0
        with folder_in_memory():
            stage = Stage(draw_script(self.seed + self._drawn, self.longest))
            stage.at_end = self._go_on
            stage.docket.log.note = lambda name: self.see(stage.docket.life, name)
            try:
                leaf = self._leaf(stage, stage.play())
                self._leaves.append(leaf)
            except GoneOnError:
                stage.machine.kill()
            except BaseException:
                if not self._is_child:
                    raise
                end_child(traceback.format_exc().encode(), FAILED)
            self._end_child()
        return self._leaves

    def see(self, life: int, name: str) -> None:
        """Note a milestone of a process, and how many new threes end with it."""
        number = NUMBERS.get(name)
        if number is None:
            return
        if life not in self._rows:
            self._rows[life] = []
            self._pairs = np.zeros(2 * (len(MILESTONES),), dtype=bool)
        row, pairs = self._rows[life], self._pairs
        if row and row[-1] == number:
            return
        known = self.known[:, :, number]
        self.new += int(np.count_nonzero(pairs & ~known))
        known |= pairs
        if row:
            pairs[row, number] = True
        row.append(number)

    def ways(self) -> int:
        """Return in how many ways a process goes on, by what is new."""
        new, self.new = self.new, 0
        before, self.mean = self.mean, FADE * self.mean + (1.0 - FADE) * new
        self.idle = 0 if new else self.idle + 1
        return MOST_WAYS if new > before else int(self.idle < MOST_IDLE)

    def _go_on(self, stage: Stage) -> bool:
        """Go on from here in children. Return whether this is one of them, which goes on."""
        point = stage.where()
        is_long = point.seconds > LONG_S or stage.docket.ticks > MOST_TICKS
        is_long = is_long or point.life > MOST_LIVES
        ways = 0 if is_long else min(self.ways(), self._left)
        for _ in range(ways):
            self._left -= 1
            self._drawn += 1
            used = self._used + processor_s()
            told = fork()
            if told is None:
                self._is_child, self._leaves, self._used = True, [], used
                seed = self.seed + self._drawn
                stage.go_on(redraw(stage.script, point, seed, NEAR_S, MOST_LIVES))
                return True
            leaves, (self._left, self._drawn, self.mean, known) = pickle.loads(told)  # noqa: S301
            self._leaves += leaves
            self.known |= np.unpackbits(known, count=self.known.size).reshape(self.known.shape) > 0
            self._counted = counts_of(stage.docket)
        if ways:  # whatever breaks a law here breaks it in the children
            self._end_child()
            raise GoneOnError
        return False

    def _end_child(self) -> None:
        """Tell the parent what was found, and end this process, if it has a parent."""
        if self._is_child:
            found = self._left, self._drawn, self.mean, np.packbits(self.known)
            end_child(pickle.dumps((self._leaves, found)))

    def _leaf(self, stage: Stage, docket: Docket) -> Leaf:
        rows = tuple(tuple(MILESTONES[each] for each in row) for row in self._rows.values())
        counts = {what: n - self._counted.get(what, 0) for what, n in counts_of(docket).items()}
        return Leaf(
            *(stage.script, tuple(docket.breaches), docket.trace.hexdigest(), docket.life),
            *(frozenset(docket.log.reached), counts, rows, self._used + processor_s()),
        )


def processor_s() -> float:
    """Return the time [s] of the processor that this process and its children have used."""
    used = os.times()
    return used.user + used.system + used.children_user + used.children_system


def counts_of(docket: Docket) -> Counts:
    """Return how much was done in a script so far."""
    return {
        "processes": docket.life,
        "kills": docket.kills,
        "power cuts": docket.power_cuts,
        "orders": docket.orders,
        "answers": docket.answers,
        "ticks": docket.ticks,
    }

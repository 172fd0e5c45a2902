"""The ground that some boats touch, tick by tick, for ``judge``.

``groundings`` finds the same in a whole record. A touch is judged by the last numbers off the
ground, so these are remembered; a boat that was laid down has a while to come to lie.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.boat.boat import Boat
from trainer.boat.grounding import (
    AGROUND_TICKS,
    RECALL_AFLOAT_S,
    SETTLING_TIME_S,
    GroundTouch,
    lies_well,
    touch_of,
)
from trainer.boat.world.bottom import ground_under
from trainer.config.world.bottom import Bottom
from trainer.core.kernel import Numbers
from trainer.debrief.marks.tally_sheet import AskedColumns

LYING_NAMES: Final = ("aground", "bottom_load", "u_c")


@dataclass
class TickGrounding:
    """One touch of the ground so far."""

    tick: int
    touch: GroundTouch
    hard: bool
    lies: bool = False

    def is_fault(self, bottom: Bottom) -> bool:
        """Return whether it was not meant, or is not well so far."""
        return not (bottom.bottoming and not self.spoilt and self.lies)

    @property
    def spoilt(self) -> bool:
        """Return whether nothing that comes can make it well."""
        return self.hard or bool(self.touch.faults)


class GroundWatch:
    """The groundings of some boats over the ground of an exercise."""

    def __init__(self, boat: Boat, bottom: Bottom, count: int, reads: tuple[str, ...]) -> None:
        self.bottom, self._step, self._length = bottom, boat.method.step, float(boat.vessel.ell)
        self._gravity = float(boat.vessel.g)
        self._places = {name: reads.index(name) for name in (*LYING_NAMES, *touch_names())}
        self._afloat = np.zeros((count, len(reads)))  # the last row off the ground, or the first
        self._down = np.full(count, -np.inf)  # [s] when the ground carried it last
        self._now = np.zeros(count)  # [s]
        self.groundings: list[list[TickGrounding]] = [[] for _ in range(count)]

    def begin(self, index: int, start: Numbers) -> None:
        """Begin with a boat whose numbers are those at the start."""
        self._afloat[index], self._down[index] = start, -np.inf
        self.groundings[index] = []

    def watch(self, rows: Numbers, which: list[int]) -> list[int]:
        """Take the next ticks [boats, ticks, columns] of some boats; return which are judged anew.

        The tick is the first column.
        """
        touching = np.any(rows[:, :, self._places["aground"]] > 0.0, axis=1).tolist()
        changed = []
        for index in which:
            if touching[index] or self._awaited(index):
                changed.append(index)
                for row in rows[index]:
                    self._look(index, row)
            else:
                self._afloat[index] = rows[index, -1, : self._afloat.shape[1]]
                self._now[index] = rows[index, -1, 0] * self._step
        return changed

    def is_over(self, index: int, grounding: TickGrounding) -> bool:
        """Return whether a fault is one for good."""
        late = self._now[index] > grounding.tick * self._step + SETTLING_TIME_S
        return not self.bottom.bottoming or grounding.spoilt or bool(late)

    def faults(self, index: int) -> list[TickGrounding]:
        """Return the groundings of a boat that are faults so far."""
        return [each for each in self.groundings[index] if each.is_fault(self.bottom)]

    def _awaited(self, index: int) -> bool:
        """Return whether a boat may yet come to lie, or has just failed to."""
        latest = self.groundings[index][-1:]
        return any(not each.lies and not self.is_over(index, each) for each in latest)

    def _look(self, index: int, row: Numbers) -> None:
        """Take one tick of a boat that is on the ground, or was."""
        tick, seconds = int(row[0]), row[0] * self._step
        aground, load, u_c = (float(row[self._places[name]]) for name in LYING_NAMES)
        if aground == 0.0:
            self._afloat[index] = row[: self._afloat.shape[1]]
        elif aground >= AGROUND_TICKS:
            if tick and seconds - self._down[index] > RECALL_AFLOAT_S:
                self.groundings[index].append(self._touched(index, tick))
            self._down[index] = seconds
        tonnes = load / self._gravity / 1000.0
        for each in self.groundings[index]:
            if not each.lies and seconds <= each.tick * self._step + SETTLING_TIME_S:
                each.lies = lies_well(tonnes, u_c)
        self._now[index] = seconds

    def _touched(self, index: int, tick: int) -> TickGrounding:
        before, places = self._afloat[index], self._places
        touch = touch_of(lambda name: float(before[places[name]]), self._length)
        return TickGrounding(tick, touch, touch.is_hard(self.bottom.kind))


def touch_names() -> list[str]:
    """Return the fields of the state by which a touch is judged."""
    columns = AskedColumns()
    touch_of(lambda name: float(columns[name][0]), 1.0)
    return list(columns)


def ground_reads(boat: Boat) -> tuple[str, ...]:
    """Return the fields of the state that are to be watched over a boat's ground."""
    return () if ground_under(boat) is None else (*LYING_NAMES, *touch_names())

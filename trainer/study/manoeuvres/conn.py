"""Who has the conn: gives a vehicle the orders of a schedule, cycle by cycle, and marks events.

A schedule is a generator: between two yields the vehicle moves by one cycle, with the controls as
they are ordered before. Events are seen at the starts of cycles, as in the program CONTR: up to a
cycle after they happen. Where one vehicle sees an event in one cycle and another in the next, that
alone parts their ways; a vehicle flown beside another therefore takes the other's time of an event
where its own is not more than a cycle away.
"""

import math
from collections.abc import Generator, Sequence
from typing import NamedTuple

import numpy as np

from trainer.core.kernel import Numbers
from trainer.study.manoeuvres.vehicle import Swift, Vehicle, Watch

Cycles = Generator[None, None, None]
EARLY = 1e-9  # [s] rounding of a sum of steps


class Mark(NamedTuple):
    """An event of the schedule."""

    name: str
    t: float  # [s]


class Conn:
    """A vehicle under orders."""

    def __init__(self, vehicle: Vehicle, others: Sequence[float | None] = ()) -> None:
        """Take the conn of a vehicle that has been started; ``others`` are another's events."""
        self.vehicle = vehicle
        self.events: list[float | None] = []  # [s] of each that was waited for; None: never
        self._others = list(others)
        self.marks: list[Mark] = []
        self.ordered: dict[str, float] = {}  # what was ordered last, by control
        self._places = {name: i for i, name in enumerate(vehicle.columns)}
        self.seen: tuple[float, ...] = ()
        self._blocks: list[Numbers] = []
        self._rows: list[tuple[float, ...]] = []
        self.look()

    def look(self) -> None:
        """Remember the columns as they stand."""
        self.seen = self.vehicle.observe()
        self._rows.append(self.seen)

    @property
    def table(self) -> Numbers:
        """Return all that was seen, a row for every cycle."""
        self._close()
        return np.concatenate(self._blocks)

    def _close(self) -> None:
        """Make a block of the rows seen one by one."""
        if self._rows:
            self._blocks.append(np.array(self._rows))
            self._rows = []

    def value(self, column: str) -> float:
        """Return a column as it stands at the start of this cycle."""
        return self.seen[self._places[column]]

    @property
    def time(self) -> float:
        """Return the time [s] since the start."""
        return self.value("t")

    def order(self, control: str, value: float) -> None:
        """Order a control, and remember it."""
        self.ordered[control] = value
        self.vehicle.order(control, value)

    def mark(self, name: str) -> None:
        """Mark an event here and now."""
        self.marks.append(Mark(name, self.time))

    def hold(self, seconds: float) -> Cycles:
        """Let time pass, all controls held."""
        yield from self._pass(self.time + seconds - EARLY, None)

    def hold_to(self, time: float) -> Cycles:
        """Let time pass up to ``time`` [s] since the start."""
        yield from self.hold(time - self.time)

    def until(self, watch: Watch, most: float) -> Generator[None, None, bool]:
        """Let at most ``most`` [s] pass until what is watched passes; return whether it did."""
        end = self.time + most - EARLY
        other = self._others.pop(0) if self._others else None
        passed = other is not None and (yield from self._beside(watch, other))
        if not passed:
            yield from self._pass(end, watch)
            passed = self.passed(watch)
        self.events.append(self.time if passed else None)
        return passed

    def _beside(self, watch: Watch, other: float) -> Generator[None, None, bool]:
        """Let time pass to the ``other``'s event [s], or one's own if that comes too early.

        Return whether one's own is within a cycle of it, by the rate if it is still to come.
        """
        cycle = self.vehicle.step
        yield from self._pass(other - 1.5 * cycle, watch)
        if self.time < other - 1.5 * cycle:
            return False
        before = self._beyond(watch)
        yield from self._pass(other - 0.5 * cycle, None)
        now = self._beyond(watch)
        return max(before, now, 2.0 * now - before) >= 0.0

    def passed(self, watch: Watch) -> bool:
        """Return whether a quantity has passed its mark, at the start of this cycle."""
        return self._beyond(watch) >= 0.0

    def _beyond(self, watch: Watch) -> float:
        """Return how far a quantity is beyond its mark, negative before it."""
        return watch.side * (self._quantity(watch.quantity) - watch.mark)

    def _quantity(self, name: str) -> float:
        """Return a quantity that can be watched."""
        if name == "depth rate":
            theta = self.value("theta")
            return self.value("w") * math.cos(theta) - self.value("u") * math.sin(theta)
        if name == "size of theta":
            return abs(self.value("theta"))
        return self.value(name)

    def _pass(self, end: float, watch: Watch | None) -> Cycles:
        """Let time pass to ``end`` [s] or until what is watched passes."""
        if isinstance(self.vehicle, Swift) and self.vehicle.swift:
            self._close()
            rows = self.vehicle.sail(end, watch)
            if len(rows):
                self._blocks.append(rows)
                self.seen = tuple(rows[-1].tolist())
            self.vehicle.sound()
            return
        while self.time < end and not (watch and self.passed(watch)):
            yield

"""Who has the conn: gives a vehicle the orders of a schedule, cycle by cycle, and marks events.

A schedule is a generator: between two yields the vehicle moves by one cycle, with the controls as
they are ordered before. Events are seen at the starts of cycles, as in the program CONTR.
"""

from collections.abc import Callable, Generator
from typing import NamedTuple

from trainer.study.manoeuvres.vehicle import Vehicle

Cycles = Generator[None, None, None]
EARLY = 1e-9  # [s] rounding of a sum of steps


class Mark(NamedTuple):
    """An event of the schedule."""

    name: str
    t: float  # [s]


class Conn:
    """A vehicle under orders."""

    def __init__(self, vehicle: Vehicle) -> None:
        """Take the conn of a vehicle that has been started."""
        self.vehicle = vehicle
        self.marks: list[Mark] = []
        self.ordered: dict[str, float] = {}  # what was ordered last, by control
        self._places = {name: i for i, name in enumerate(vehicle.columns)}
        self.seen = vehicle.observe()

    def look(self) -> tuple[float, ...]:
        """Return the columns as they stand, and remember them."""
        self.seen = self.vehicle.observe()
        return self.seen

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
        end = self.time + seconds - EARLY
        while self.time < end:
            yield

    def hold_to(self, time: float) -> Cycles:
        """Let time pass up to ``time`` [s] since the start."""
        yield from self.hold(time - self.time)

    def until(self, condition: Callable[[], bool], most: float) -> Generator[None, None, bool]:
        """Let time pass until ``condition``, at most ``most`` [s]; return whether it came true."""
        end = self.time + most - EARLY
        while not condition():
            if self.time >= end:
                return False
            yield
        return True

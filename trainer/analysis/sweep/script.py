"""A manoeuvre is written down before its flight, where it asks only for time."""

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, NamedTuple

from trainer.analysis.manoeuvres.flight import LONGEST, Conn, Manoeuvre, Mark
from trainer.analysis.manoeuvres.vehicle import Control


class Line(NamedTuple):
    """One thing done, before the tick of that number."""

    tick: int
    verb: str  # "order" or "keep"
    what: str  # control or quantity
    value: float  # SI, of a surface from its neutral angle


class Script(NamedTuple):
    """All that is done in a manoeuvre, and how long it takes."""

    lines: tuple[Line, ...]
    marks: tuple[Mark, ...]
    ticks: int


class Scribe:
    """A vehicle that goes nowhere and writes down what it is told."""

    name = "scribe"
    length = 1.0
    columns = ("t",)

    def __init__(self, step: float, controls: Mapping[str, Control]) -> None:
        """Begin at the first tick."""
        self.step = step
        self.controls = controls
        self.tick = 0
        self.lines: list[Line] = []

    def start(self, speed: float) -> None:
        """Begin anew."""
        del speed
        self.tick = 0

    def incline(self, heel: float) -> None:
        """Raise KeyError: heel [rad] is no order, and not written down."""
        raise KeyError(heel)

    def order(self, control: str, value: float) -> None:
        """Write down an order."""
        self.lines.append(Line(self.tick, "order", control, value))

    def keep(self, quantity: str) -> None:
        """Write down what is to be kept."""
        self.lines.append(Line(self.tick, "keep", quantity, 0.0))

    def observe(self) -> tuple[float, ...]:
        """Return the time [s]."""
        return (self.tick * self.step,)

    def advance(self) -> None:
        """Advance by a cycle."""
        self.tick += 1


def script_of(manoeuvre: Manoeuvre, step: float, controls: Mapping[str, Control]) -> Script | None:
    """Return what is done when; None where that depends on how the vehicle moves."""
    return _write(manoeuvre, step, tuple(controls.items()))


@lru_cache(maxsize=4096)
def _write(
    manoeuvre: Manoeuvre, step: float, controls: tuple[tuple[str, Control], ...]
) -> Script | None:
    scribe = Scribe(step, dict(controls))
    conn: Any = Conn(scribe)
    try:
        for _ in manoeuvre.schedule(conn):
            scribe.advance()
            conn.look()
            if scribe.tick > LONGEST:
                return None
    except KeyError:  # it asks for what the scribe has not
        return None
    if any(line.verb == "keep" and (line.tick or line.what != "depth") for line in scribe.lines):
        return None  # what is kept is as it is then, which is known at the start alone
    return Script(tuple(scribe.lines), tuple(conn.marks), scribe.tick)

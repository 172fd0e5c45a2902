"""A field of a channel: its name, its unit, and how it is read off a frame and written."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from trainer.stations.frame import Frame
from trainer.units import KNOT

Value = float | str | None  # None: the boat lacks it, or it stands for nothing at present


@dataclass(frozen=True)
class Field:
    """One thing shown; ``unit`` is "" for a word, "-" for a plain number."""

    name: str
    unit: str
    decimals: int
    read: Callable[[Frame], Value]

    def text(self, frame: Frame) -> str:
        """Return the value with its decimals, "" for none."""
        value = self.read(frame)
        if value is None:
            return ""
        if isinstance(value, str):
            return value
        return f"{round(value, self.decimals) + 0.0:.{self.decimals}f}"


@dataclass(frozen=True)
class Channel:
    """Fields that are sent together."""

    name: str
    says: str
    fields: tuple[Field, ...]

    def values(self, frame: Frame) -> list[str]:
        """Return the fields of one tick."""
        return [field.text(frame) for field in self.fields]


def word(name: str, read: Callable[[Frame], Value]) -> Field:
    """Return a field that is a word."""
    return Field(name, "", 0, read)


def compass(angle: float, decimals: int = 1) -> float:
    """Return an angle [rad] as a course [deg] that is below 360 when written."""
    return round(math.degrees(angle), decimals) % 360.0


def degrees(name: str, place: str, unit: str = "deg", decimals: int = 1) -> Field:
    """Return a field of an angle, or of its rate, at a place of the state."""
    return Field(name, unit, decimals, lambda frame: math.degrees(frame[place]))


def metres(name: str, place: str, unit: str = "m", decimals: int = 1) -> Field:
    """Return a field of a length, or of its rate, at a place of the state."""
    return Field(name, unit, decimals, lambda frame: frame[place])


def knots(name: str, place: str, unit: str = "kn", decimals: int = 1) -> Field:
    """Return a field of a speed, or of its rate, at a place of the state."""
    return Field(name, unit, decimals, lambda frame: frame[place] / KNOT)


TONNE: Final = 1000.0  # [kg]

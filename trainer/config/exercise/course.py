"""The shipped exercises in the order in which a crew learns: the first lesson first.

``trainer exercises``, the console's list, the pages and the order ``next`` all follow it. The order
is that of the key ``lesson`` in the files, so that an exercise brings its own number.
"""

import math
from typing import Final, NamedTuple

from trainer.config.files import (
    LESSONS_FOLDER,
    parse_toml,
    read_text,
    shipped_names,
    shipped_path,
)

AXIS_STATIONS: Final = {  # of the hand axes: the station that works it
    "rudder": "helm",
    "planes": "planes",
    "speed": "helm",
    "ballast": "ballast",
}
STANDARD_VESSEL: Final = "bb2"  # the boat of an exercise that names none


class Lesson(NamedTuple):
    """An exercise: its number in the course, its name, and the crew's title and briefing."""

    number: float
    name: str
    title: str
    briefing: str
    seconds: float | None = None  # its length, None where it has no end
    hand: tuple[str, ...] = ()  # what the crew works by hand
    vessel: str = STANDARD_VESSEL  # the boat
    steps: int = 0  # that lead through it

    @property
    def word(self) -> str:
        """Return what chooses it and tells nothing: ``exercise-5``, or the name of a lesson."""
        numbered = not self.steps and math.isfinite(self.number)
        return f"exercise-{self.number:.0f}" if numbered else self.name

    @property
    def length(self) -> str:
        """Return how long it is, in minutes, in steps without an end by the clock."""
        if self.seconds is None:
            return f"{self.steps} steps" if self.steps else ""
        return f"{self.seconds / 60.0:.0f} min"

    @property
    def in_hand(self) -> str:
        """Return what is worked by hand, in words."""
        automatic = [axis for axis in AXIS_STATIONS if axis not in self.hand]
        if len(automatic) > 1:
            return ", ".join(self.hand)
        return " but ".join(("all", *automatic))

    @property
    def stations(self) -> tuple[str, ...]:
        """Return the stations that share what is worked by hand."""
        return tuple(dict.fromkeys(AXIS_STATIONS[axis] for axis in self.hand))


def course() -> list[Lesson]:
    """Return every shipped exercise; ConfigError if a file cannot be read.

    The files are not checked, because the checks load the core, which takes long.
    """
    return sorted(lesson(name) for name in shipped_names("exercises"))


def lessons() -> list[Lesson]:
    """Return the shipped lessons that lead step by step, before the course; ConfigError."""
    return sorted(lesson(name) for name in shipped_names(LESSONS_FOLDER))


def following(name: str) -> Lesson | None:
    """Return what comes after an exercise in the course, None after the last.

    After one that is none of the course it is the first.
    """
    offered = [*lessons(), *course()]
    names = [each.name for each in offered]
    after = names.index(name) + 1 if name in names else 0
    return offered[after] if after < len(offered) else None


def lesson(name: str) -> Lesson:
    """Return a shipped exercise as a lesson. One without a number in the course comes last."""
    path = shipped_path("exercises", name)
    table = parse_toml(read_text(path), path.name)
    number = float(table.get("lesson", math.inf))
    length = table.get("duration_s")
    return Lesson(
        number,
        name,
        str(table["name"]),
        str(table["briefing"]),
        seconds=None if length is None else float(length),
        hand=tuple(map(str, table.get("hand", ()))),
        vessel=str(table.get("vessel", STANDARD_VESSEL)),
        steps=len(table.get("steps", ())),
    )

"""The shipped exercises in the order in which a crew learns: the first lesson first."""

import math
from typing import Final, NamedTuple

from trainer.config.files import parse_toml, read_text, shipped_names, shipped_path

STANDARD_VESSEL: Final = "bb2"  # the boat of an exercise that names none


class Lesson(NamedTuple):
    """An exercise: its place in the course, its name, and the crew's title and briefing."""

    place: float
    name: str
    title: str
    briefing: str
    seconds: float | None = None  # its length, None where it has no end
    hand: tuple[str, ...] = ()  # what the crew works by hand
    vessel: str = STANDARD_VESSEL  # the boat


def course() -> list[Lesson]:
    """Return every shipped exercise; ConfigError if a file cannot be read.

    The files are not checked, because the checks load the core, which takes long.
    """
    return sorted(lesson(name) for name in shipped_names("exercises"))


def lesson(name: str) -> Lesson:
    """Return a shipped exercise as a lesson. One without a place in the course comes last."""
    path = shipped_path("exercises", name)
    table = parse_toml(read_text(path), path.name)
    place = float(table.get("lesson", math.inf))
    length = table.get("duration_s")
    return Lesson(
        place,
        name,
        str(table["name"]),
        str(table["briefing"]),
        seconds=None if length is None else float(length),
        hand=tuple(map(str, table.get("hand", ()))),
        vessel=str(table.get("vessel", STANDARD_VESSEL)),
    )

"""The course of a class: exercises in their order, and the marks to go on.

Its rows stand in a class file (``class_file``). A session that is given one goes on by it: ``next``
begins the row after its own, once the marks of its own are reached. A boat's place is the row of
the exercise that it sails, so that it needs no keeping.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trainer.config.files import ConfigError, parse_toml, path_named, read_text
from trainer.config.schema import Text, optional, required, within

MAX_COURSE_ROWS: Final = 50


@dataclass(frozen=True, kw_only=True)
class CourseRow:
    """One exercise of a course."""

    exercise: str = required(Text(400, "its name, or the path of a file"))
    reach: float | None = optional("-", within(1, 100), "marks to go on; else its end will do")

    @property
    def name(self) -> str:
        """Return the exercise's name, also where its row has a path."""
        return Path(self.exercise).stem

    @property
    def told(self) -> str:
        """Return the row in words."""
        return f"{self.name}, {self.reach:g} marks to go on" if self.reach else self.name


@dataclass(frozen=True)
class ClassCourse:
    """The rows of a course in their order; none where each session is for itself."""

    rows: tuple[CourseRow, ...] = ()

    def place_of(self, exercise: str) -> int:
        """Return an exercise's place, 1 for the first; 0 where it has none."""
        names = [row.name for row in self.rows]
        return names.index(exercise) + 1 if exercise in names else 0

    def row_of(self, exercise: str) -> CourseRow | None:
        """Return the row of an exercise by its name, None where it has none."""
        place = self.place_of(exercise)
        return self.rows[place - 1] if place else None

    def following(self, exercise: str) -> str:
        """Return the name of what comes after an exercise; "" after the last.

        After one that is not of the course it is the first.
        """
        after = self.rows[self.place_of(exercise) :]
        return after[0].name if after else ""

    def told(self, exercise: str) -> str:
        """Return an exercise's place, how many there are, and the marks to reach.

        They stand between commas, as a fact for programs; "" for an exercise of no course.
        """
        row = self.row_of(exercise)
        if row is None:
            return ""
        reach = "" if row.reach is None else f"{row.reach:g}"
        return f"{self.place_of(exercise)},{len(self.rows)},{reach}"

    def problems(self) -> Iterator[str]:
        """Yield what is wrong with the rows, such as one that is there twice."""
        for place, row in enumerate(self.rows, 1):
            key = f"[[course]] {place}"
            if self.place_of(row.name) != place:
                yield f"{key}: exercise = {row.name}: is there already; a place is known by it"
            try:
                path = path_named(row.exercise, "exercises")
                table = parse_toml(read_text(path), path.name)
            except ConfigError as wrong:
                yield f"{key}: {wrong}"
                continue
            if row.reach is not None and not table.get("scores"):
                yield f"{key}: reach = {row.reach:g}: {row.name} has no marks; leave it out"


NO_COURSE: Final = ClassCourse()

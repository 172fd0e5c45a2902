"""Where each boat of a class is in its course, for the debrief.

A boat is at the exercise of the recording that it began last. Its marks there are those of its
latest run of that exercise.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from trainer.config.exercise.class_course import ClassCourse
from trainer.config.exercise.class_file import ClassFile


@dataclass(frozen=True)
class BoatPlace:
    """The place of one boat in the course of its class."""

    boat: int
    name: str  # of the boat, "" for none
    exercise: str
    place: int  # 1 for the first of the course; 0 beside it
    of: int  # exercises of the course
    reach: float | None  # marks [%] to go on, None where the end will do
    marks: float | None  # of its run, None without any

    @property
    def told(self) -> str:
        """Return it in words, as the class page has it."""
        where = f"{self.place} of {self.of}" if self.place else "beside the course"
        had = None if self.marks is None else math.floor(self.marks)
        if self.reach is None:
            rest = "" if had is None else f", {had} marks"
        else:
            rest = (
                f", {self.reach:g} marks to go on" if had is None else f", {had} of {self.reach:g}"
            )
        return f"{where}: {self.exercise}{rest}"


def boat_places(
    planned: ClassFile,
    latest: Mapping[int, str],
    marks: Mapping[tuple[int, str], float | None],
) -> tuple[BoatPlace, ...]:
    """Return the places of boats whose ``latest`` exercise is known; none without a course.

    ``marks`` [%] are those of boats in exercises.
    """
    course = ClassCourse(planned.course)
    if not course.rows:
        return ()
    return tuple(
        BoatPlace(
            boat,
            planned.row_of(boat).name or "",
            exercise,
            course.place_of(exercise),
            len(course.rows),
            row.reach if (row := course.row_of(exercise)) else None,
            marks.get((boat, exercise)),
        )
        for boat, exercise in sorted(latest.items())
    )

"""The file of a class: exercise or course, boats, and what is each one's own.

``trainer class`` begins a class by it, and keeps it beside the recordings, so that the class can go
on another day. What is not said of a boat is the same for all.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, Final

from trainer.config.exercise.class_course import MAX_COURSE_ROWS, ClassCourse, CourseRow
from trainer.config.files import (
    ConfigError,
    Position,
    collecting,
    is_path,
    parse_toml,
    path_named,
    raise_problems,
    read_text,
    relative_name,
    toml_value,
    write_once,
)
from trainer.config.schema import (
    Choice,
    Rows,
    Text,
    Texts,
    WholeNumber,
    file_schema,
    optional,
    read_record,
    record_schema,
    required,
    with_default,
    within,
)

MAX_BOATS: Final = 24
MAX_SEED: Final = 2**53 - 1
MAX_SPACING_M: Final = 5000.0
CLASS_FILE_NAME: Final = "class.toml"  # in the folder of a class
SAME_SEEDS, OWN_SEEDS = "same", "by-boat"
# By how much a boat may be elsewhere than the others in its sea are told.
PLACE_ERROR_M: Final = 5.0
DEPTH_ERROR_M: Final = 2.0
HEADING_KEYS: Final = frozenset({"exercise", "boats"})  # an exercise file has none of them


@dataclass(frozen=True, kw_only=True)
class BoatRow:
    """What is one boat's own."""

    number: int = required(WholeNumber(1, MAX_BOATS, "which boat"))
    name: str | None = optional(Text(24, "what it is called beside its number"))
    trainees: tuple[str, ...] = with_default(
        (),
        Texts(Text(60, "a name"), 8),  # as a recording takes names
    )
    seed: int | None = optional(WholeNumber(0, MAX_SEED, "of its random numbers"))
    on: str | None = optional(Text(200, "tcp://HOST:PORT of its session on another machine"))

    @property
    def title(self) -> str:
        """Return its number, and its name if it has one."""
        return f"boat {self.number}" + (f" {self.name}" if self.name else "")


@dataclass(frozen=True, kw_only=True)
class ClassFile:
    """A class: its exercise or its course, its boats, their seeds and trainees."""

    exercise: str | None = optional(Text(400, "its name, or the path of a file"))
    course: tuple[CourseRow, ...] = with_default(
        (),
        Rows(CourseRow, ("note",), 0, MAX_COURSE_ROWS, "exercises in their order, in its place"),
    )
    boats: int = required(WholeNumber(1, MAX_BOATS, "how many"))
    seed: int = with_default(1, WholeNumber(0, MAX_SEED, "of random numbers; else 1"))
    seeds: str = with_default(
        SAME_SEEDS,
        Choice(
            (SAME_SEEDS, OWN_SEEDS), "every boat has that seed, or one more than the boat before"
        ),
    )
    one_sea_m: float | None = optional(
        "m",
        within(0, MAX_SPACING_M),
        "all boats in one sea, each so far east of the one before; else each alone",
    )
    boat: tuple[BoatRow, ...] = with_default(
        (), Rows(BoatRow, ("note",), 0, MAX_BOATS, "what is one boat's own")
    )

    @property
    def exercises(self) -> tuple[str, ...]:
        """Return the exercise, or all of the course; every boat begins with the first."""
        return (self.exercise,) if self.exercise else tuple(row.exercise for row in self.course)

    @property
    def numbers(self) -> range:
        """Return the numbers of the boats."""
        return range(1, self.boats + 1)

    def row_of(self, number: int) -> BoatRow:
        """Return what is a boat's own, with its seed."""
        row = next((row for row in self.boat if row.number == number), BoatRow(number=number))
        common_seed = self.seed + (number - 1) * (self.seeds == OWN_SEEDS)
        return replace(row, seed=common_seed if row.seed is None else row.seed)


def is_class_file(name: str) -> bool:
    """Return whether a name is a class file's, and no exercise's; ConfigError."""
    if not is_path(name):
        return False
    path = Path(name)
    return not HEADING_KEYS.isdisjoint(parse_toml(read_text(path), path.name))


def load_class(path: Path) -> ClassFile:
    """Return the class in a file; ConfigError with all faults.

    Its exercise is there, and was not read, because that would load the core.
    """
    planned, position = read_class(path), Position(path.name, "")
    planned = with_exercises(planned, partial(relative_name, path))
    problems = [position.problem(problem) for problem in _row_problems(planned)]
    if planned.exercise:
        with collecting(problems):
            read_text(path_named(planned.exercise, "exercises"))
    raise_problems(problems)
    return planned


def with_exercises(planned: ClassFile, renamed: Callable[[str], str]) -> ClassFile:
    """Return a class with each of its exercises under another name or path."""
    return replace(
        planned,
        exercise=planned.exercise and renamed(planned.exercise),
        course=tuple(replace(row, exercise=renamed(row.exercise)) for row in planned.course),
    )


def read_class(path: Path) -> ClassFile:
    """Return the class in a file as it is written; ConfigError."""
    table = parse_toml(read_text(path), path.name)
    return read_record(ClassFile, table, Position(path.name, ""), ("note",))


def recording_folders(folder: Path) -> list[Path]:
    """Return a folder, and those of the boats of classes kept in it."""
    return [folder, *(boat for kept in class_folders(folder) for boat in kept.glob("boat-*/"))]


def class_folders(folder: Path) -> list[Path]:
    """Return the folders of classes in a folder, or itself if it is one."""
    found = (folder / CLASS_FILE_NAME, *sorted(folder.glob(f"*/{CLASS_FILE_NAME}")))
    return [path.parent for path in found if path.is_file()]


def kept_class(folder: Path) -> ClassFile:
    """Return the class of a folder as its file says it; ConfigError without one."""
    if not (folder / CLASS_FILE_NAME).is_file():
        raise ConfigError(f"{folder}: there is no class: it would have a {CLASS_FILE_NAME}")
    return read_class(folder / CLASS_FILE_NAME)


def _row_problems(planned: ClassFile) -> Iterator[str]:
    """Yield what is wrong with the boats' own tables among each other, and with its course."""
    if bool(planned.exercise) is bool(planned.course):
        yield "exercise: say that, or the rows [[course]]: one of them, and not both"
    yield from ClassCourse(planned.course).problems()
    for row in planned.boat:
        if row.on and (row.seed is not None or row.trainees):
            yield f"[[boat]] number = {row.number}: on: seed and trainees are its own session's"
    counts = Counter(row.number for row in planned.boat)
    for number, count in counts.items():
        if count > 1:
            yield f"[[boat]] number = {number}: is there {count} times; one table a boat"
        if number > planned.boats:
            yield f"[[boat]] number = {number}: there are boats = {planned.boats}"


def class_text(planned: ClassFile) -> str:
    """Return a class as its file has it."""
    lines = _key_lines(planned, ("exercise", "boats", "seed", "seeds", "one_sea_m"))
    for course_row in planned.course:
        lines += ["", "[[course]]", *_key_lines(course_row, ("exercise", "reach"))]
    for row in planned.boat:
        lines += ["", "[[boat]]", *_key_lines(row, ("number", "name", "trainees", "seed", "on"))]
    return "\n".join(lines) + "\n"


def _key_lines(record: object, keys: Iterable[str]) -> list[str]:
    """Return the keys that a record has values for, a line each."""
    told = {key: getattr(record, key) for key in keys}
    return [f"{key} = {toml_value(each)}" for key, each in told.items() if each not in (None, ())]


TEMPLATE: Final = """\
# A class of the trainer: begin it with `trainer class {file} --web HOST:PORT --token WORD`.
exercise = {exercise}   # `trainer exercises` lists them; or the path of a file
boats = {boats}         # 1 to {most}
seed = 1                # of random numbers
seeds = "same"          # every boat has that seed; "by-boat": 1, 2, 3 ...

# one_sea_m = 1000      # all boats in one sea, each starts so far east of the one before

# A course in place of the exercise: each boat goes on by `next` at its own pace, once it has the
# marks of its row; without `reach` the end of the exercise will do.
# [[course]]
# exercise = "first-depth-change"
# reach = 60
# [[course]]
# exercise = "depth-changes"

# What is one boat's own, in any order; each key but the number may be left out. Names of trainees
# are kept with the recordings on this machine.
# [[boat]]
# number = 1
# name = "Alpha"
# trainees = ["A. Jones"]
# seed = 7
# on = "tcp://bridge:17800"  # in their place: its session runs there, by `trainer serve`
"""


def write_new_class(path: Path, exercise: str, boats: int) -> str:
    """Write a class file with comments, to be changed; return what to do next. ConfigError."""
    path_named(exercise, "exercises")
    words = {"file": path, "boats": boats, "most": MAX_BOATS, "exercise": toml_value(exercise)}
    write_once(path, TEMPLATE.format(**words))
    return f"{path} written; `trainer class check {path}` reads it"


def class_schema() -> dict[str, Any]:
    """Return the JSON Schema of a class file."""
    whole = record_schema(ClassFile, ("note",))
    return file_schema("class", whole["properties"], whole["required"])


def refuse_many(boats: int, elsewhere: int = 0) -> None:
    """Raise ConfigError for more boats than a class has, those elsewhere among them."""
    if boats < 0 or not 1 <= boats + elsewhere <= MAX_BOATS:
        beside = f" and {elsewhere} by --on" if elsewhere else ""
        raise ConfigError(f"--boats {boats}{beside}: a class has 1 to {MAX_BOATS} boats")

"""What each trainee has done so far, and what is best flown next.

There is one file a trainee. The files lie beside the folder of recordings.
``debrief/trainees/progress`` adds a run when its exercise has ended. The menu of ``trainer run``
and ``trainer recordings`` read them. A file that cannot be read is never written over: it is set
aside under another name, and that is told.
"""

import contextlib
import json
import time
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from datetime import date
from itertools import count
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, NamedTuple

from trainer.config.exercise.course import Lesson
from trainer.config.exercise.outcome import Outcome
from trainer.config.files import ConfigError, quote
from trainer.io.file_lock import holding
from trainer.io.outputs import renew_whole
from trainer.io.paths import made_folder, recordings_folder

PROGRESS_SCHEMA: Final = "progress/1"
TRAINEES_FOLDER: Final = "trainees"
LOCK_TIMEOUT_S: Final = 10.0  # [s] for another session to have written
LOCK_PERIOD_S: Final = 0.05  # [s] between tries
LATEST_RUNS: Final = 5  # runs of which is told what cost most
MARKLESS_NEED: Final = 40.0  # [%] of marks that an exercise without any counts as having lost
MAX_AGE_NEED: Final = 30.0  # [%] of marks that time alone makes of a need
PASSED_OUTCOMES: Final = (Outcome.WON, Outcome.DONE)
BARRED_IN_NAMES: Final = frozenset("/\\\0")
COST_KINDS: Final = ("late", "overshoot", "wrong way", "trim", "other")


@dataclass(frozen=True)
class ProgressRun:
    """One run of a trainee, and what it came to."""

    recording: str  # the file's name
    branch: int
    exercise: str  # its name, "" without one
    title: str
    started: str
    seconds: float
    outcome: Outcome
    total: float | None  # [%] None: no marks
    counts: bool = True  # neither free nor practice
    aids: str = ""
    costs: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))  # marks [%]
    standard_error: float | None = None  # [%] of the mark, from run to run; None: unknown
    own_marks: float | None = None  # [%] of the tasks that this trainee alone worked; None: none

    @property
    def passed(self) -> bool:
        """Return whether the exercise was won, or each step of the lesson done."""
        return self.outcome in PASSED_OUTCOMES


class Suggestion(NamedTuple):
    """What a trainee is offered next, and why."""

    lesson: Lesson
    reason: str


@dataclass(frozen=True)
class Progress:
    """The runs of one trainee, oldest first."""

    trainee: str
    runs: tuple[ProgressRun, ...] = ()

    def of(self, exercise: str) -> list[ProgressRun]:
        """Return the runs of one exercise."""
        return [each for each in self.runs if each.exercise == exercise]

    def passed(self, exercise: str) -> bool:
        """Return whether any run has passed it."""
        return any(each.passed for each in self.of(exercise))

    def best(self, exercise: str) -> str:
        """Return the best marks of an exercise, or how far it came.

        "" is for one without any run.
        """
        runs = self.of(exercise)
        marks = [each.total for each in runs if each.total is not None]
        if marks:
            return f"{max(marks):.0f}"
        return "done" if self.passed(exercise) else "begun" if runs else ""

    def suggest(self, offered: Iterable[Lesson], today: date) -> Suggestion | None:
        """Return what is weakest and longest ago, None where nothing is offered.

        Lessons come first, in their order, because exercises need what they teach.
        """
        known = list(offered)
        undone = [each for each in known if each.steps and not self.passed(each.name)]
        if undone:
            return Suggestion(undone[0], "a lesson that is not done yet")
        exercises = [each for each in known if not each.steps] or known
        weakest = max(exercises, key=lambda each: self._need(each, today), default=None)
        return Suggestion(weakest, self._reason(weakest, today)) if weakest else None

    def _need(self, exercise: Lesson, today: date) -> float:
        """Return how much an exercise is worth flying, in marks [%] that were lost.

        What the kind that costs most of late cost there counts twice. Each day, and each run since,
        counts as a mark, because skill fades.
        """
        run = self._latest(exercise.name)
        if run is None or run.total is None:
            return MARKLESS_NEED
        since = self.runs[self.runs.index(run) + 1 :]
        age = min(float(_days_since(run, today) + len(since)), MAX_AGE_NEED)
        return 100.0 - run.total + run.costs.get(self.dearest, 0.0) + age

    def _reason(self, exercise: Lesson, today: date) -> str:
        run = self._latest(exercise.name)
        if run is None or run.total is None:
            return "no marks in it yet, and the next of the course"
        days = _days_since(run, today)
        when = f"{days} days ago" if days > 1 else "yesterday" if days else "today"
        cost = run.costs.get(self.dearest, 0.0)
        dearest = f"; {self.dearest}, which costs you most of late, cost {cost:.0f} here"
        return f"{run.total:.0f} marks {when}{dearest if cost >= 1.0 else ''}"

    def _latest(self, exercise: str) -> ProgressRun | None:
        """Return the last run of an exercise that has marks."""
        return next((each for each in self.of(exercise)[::-1] if each.total is not None), None)

    @property
    def dearest(self) -> str:
        """Return the kind that cost most in the latest runs, "" where nothing did."""
        costs = self.costs
        return max(costs, key=lambda kind: costs[kind]) if any(costs.values()) else ""

    @property
    def costs(self) -> dict[str, float]:
        """Return the marks [%] that the latest runs lost, by kind."""
        latest = [each for each in self.runs if each.total is not None][-LATEST_RUNS:]
        return {kind: sum(each.costs.get(kind, 0.0) for each in latest) for kind in COST_KINDS}

    def with_run(self, run: ProgressRun) -> "Progress":
        """Return it with one run more, in place of the same one."""
        key = run.recording, run.branch
        others = (each for each in self.runs if (each.recording, each.branch) != key)
        runs = sorted((*others, run), key=lambda each: (each.started, each.branch))
        return replace(self, runs=tuple(runs))


def _days_since(run: ProgressRun, today: date) -> int:
    """Return how many days ago a run was; 0 where its file does not tell a date."""
    try:
        return max((today - date.fromisoformat(run.started[:10])).days, 0)
    except ValueError:
        return 0


def trainees_folder() -> Path:
    """Return the folder of the files."""
    return recordings_folder().parent / TRAINEES_FOLDER


def progress_path(name: str) -> Path:
    """Return the file of a trainee; ConfigError for a name that is no file name."""
    return trainees_folder() / f"{file_stem(name)}.json"


def file_stem(name: str) -> str:
    """Return a name as a file has it, however it is written; ConfigError."""
    stem = " ".join(name.split()).casefold()
    if not stem or stem.startswith(".") or BARRED_IN_NAMES & set(stem):
        raise ConfigError(
            f"--trainee {quote(name)}: is no name of a file, which a trainee's progress needs: "
            "leave out / and \\, and a dot at its begin"
        )
    return stem


def read_progress(name: str) -> Progress:
    """Return a trainee's progress, an empty one if there is no file; ConfigError."""
    path = progress_path(name)
    return read_file(path) if path.exists() else Progress(name)


def read_file(path: Path) -> Progress:
    """Return the progress in a file. ConfigError says what is wrong with it."""
    try:
        table = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror}") from None
    except (ValueError, RecursionError):
        raise ConfigError(f"{path}: is damaged: it is no JSON") from None
    schema = table.get("schema") if isinstance(table, dict) else None
    if schema != PROGRESS_SCHEMA:
        what = f"schema = {quote(schema)}: this version reads {quote(PROGRESS_SCHEMA)}"
        raise ConfigError(f"{path}: {what}")
    try:
        return Progress(str(table["trainee"]), tuple(map(read_run, table["runs"])))
    except (KeyError, TypeError, ValueError, AttributeError):
        raise ConfigError(f"{path}: is damaged: a run in it is of another form") from None


def read_run(row: Mapping[str, Any]) -> ProgressRun:
    """Return a run as its file has it; TypeError, ValueError or AttributeError if damaged."""
    known = {each.name for each in fields(ProgressRun)}
    run = ProgressRun(**{name: value for name, value in row.items() if name in known})
    total, costs = run.total, {str(kind): float(marks) for kind, marks in run.costs.items()}
    figures = total, run.standard_error, run.own_marks
    marks, error, own = (None if n is None else float(n) for n in figures)
    run = replace(run, costs=costs, seconds=float(run.seconds), outcome=Outcome(run.outcome))
    return replace(run, total=marks, standard_error=error, own_marks=own)


def all_progress() -> Iterator[Progress | ConfigError]:
    """Yield the progress of every trainee by name, or what is wrong with a file."""
    for path in sorted(trainees_folder().glob("*.json")):
        try:
            yield read_file(path)
        except ConfigError as wrong:
            yield wrong


def add_run(name: str, run: ProgressRun) -> str:
    """Add a run to a trainee's file; return what was set aside, "" for nothing. OSError."""
    path = progress_path(name)
    made_folder(path.parent)
    with _alone(path):
        text = ""
        try:
            known = read_progress(name)
        except ConfigError as wrong:
            known, aside = Progress(name), _free_name(path)
            path.rename(aside)
            text = f"{wrong}; it is kept as {aside.name}, and a new one begins"
        written = {"schema": PROGRESS_SCHEMA, "trainee": known.trainee}
        runs = [asdict(replace(each, costs=dict(each.costs))) for each in known.with_run(run).runs]
        renew_whole(path, json.dumps({**written, "runs": runs}, indent=1) + "\n")
    return text


def forget_progress(name: str) -> list[Path]:
    """Remove a trainee's file and what was set aside of it; return what was removed."""
    path = progress_path(name)
    files = path.parent.glob("*") if path.parent.is_dir() else iter(())
    own = [
        each
        for each in files
        if each.name in (path.name, f"{path.stem}.lock")
        or each.name.startswith(f"{path.name}.damaged")
    ]
    for each in own:
        each.unlink()
    return [each for each in own if each.suffix != ".lock"]


def _free_name(path: Path) -> Path:
    names = (path.with_name(f"{path.name}.damaged{'-' * bool(n)}{n or ''}") for n in count())
    return next(each for each in names if not each.exists())


@contextlib.contextmanager
def _alone(path: Path) -> Iterator[None]:
    """Hold a trainee's file inside the block, as soon as no other session does."""
    until = time.monotonic() + LOCK_TIMEOUT_S
    while True:
        with holding(path.with_suffix(".lock")) as other:
            if not other or time.monotonic() > until:
                yield
                return
        time.sleep(LOCK_PERIOD_S)

"""The debrief of a class: its boats beside one another, and what tomorrow's lesson is.

The latest run of each boat in each exercise counts. What two boats or more lost in the same minute
is a lesson for all. ``class_page`` draws it; here are its figures, its words and its table.
"""

import contextlib
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import count
from pathlib import Path
from textwrap import fill
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.config.exercise.class_course import NO_COURSE, ClassCourse
from trainer.config.exercise.class_file import kept_class
from trainer.config.exercise.progress import Progress, ProgressRun
from trainer.config.files import ConfigError, write_over
from trainer.debrief.marks.forms import forms_path
from trainer.debrief.page.data import compare_debrief
from trainer.debrief.page.page import TEXT_WIDTH, read_dossier, render
from trainer.debrief.passage.class_places import BoatPlace, boat_places
from trainer.debrief.trainees.history import unforeseen
from trainer.debrief.trainees.progress_words import CSV_HEADER, class_rows
from trainer.debrief.trainees.run_summary import (
    LostMarks,
    RunSummary,
    keep_summary,
    kept_summary,
    summary_of,
    summary_path,
)
from trainer.io.lines import plain
from trainer.io.paths import RECORDING_SUFFIX, made_folder
from trainer.report.svg import clock
from trainer.session.past.header import exercise_of, open_recording
from trainer.workers import map_tasks

SAME_TIME_S: Final = 60.0  # within which losses of several boats are one lesson
MIN_LESSON_BOATS: Final = 2
MAX_LESSONS: Final = 5  # told of an exercise
BOAT_HEADER: Final = ("class", "boat", "boat_name")
COURSE_HEADER: Final = ("course_place", "marks_to_reach")  # "" where the class has no course
CLASS_HEADER: Final = (*BOAT_HEADER, *CSV_HEADER, *COURSE_HEADER)


class FoundRun(NamedTuple):
    """The latest recording of a boat in an exercise."""

    boat: int
    exercise: str
    path: Path
    attempts: int  # recordings of this exercise by this boat


@dataclass(frozen=True)
class BoatRun:
    """One boat's run of an exercise, judged."""

    boat: int
    name: str  # of the boat, "" for none
    attempts: int
    summary: RunSummary
    page: str = ""  # the file's name of its own debrief, "" without one


@dataclass(frozen=True)
class ClassLesson:
    """A minute in which several boats lost marks."""

    begin: float  # [s]
    end: float
    boats: tuple[int, ...]
    marks: float  # [%] that each of them lost, in the mean
    task: str  # that lost most

    def told(self, of: int) -> str:
        """Return it as a sentence; ``of`` is how many boats sailed it."""
        begin, end = clock(self.begin), clock(self.end)
        when = begin if begin == end else f"{begin} to {end}"
        task = f', most of them in "{self.task}"' if self.task else ""
        which = ", ".join(map(str, self.boats))
        return (
            f"{when}: {len(self.boats)} of {of} boats lost "
            f"{counted(round(self.marks), 'mark')} each in the mean"
            f"{task} (boats {which})."
        )


@dataclass(frozen=True)
class ClassExercise:
    """An exercise as the boats of a class have sailed it."""

    exercise: str
    title: str
    runs: tuple[BoatRun, ...]  # by the boats' numbers
    lessons: tuple[ClassLesson, ...]  # the one of most boats first

    @property
    def mean(self) -> float | None:
        """Return the mean of the marks that count [%], None without any."""
        runs = [each.summary.run for each in self.runs]
        marks = [each.total for each in runs if each.total is not None and each.counts]
        return sum(marks) / len(marks) if marks else None


@dataclass(frozen=True)
class ClassDebrief:
    """A class, exercise by exercise: in its course's order, else as they were begun."""

    name: str  # of its folder
    exercises: tuple[ClassExercise, ...]
    course: ClassCourse = NO_COURSE
    places: tuple[BoatPlace, ...] = ()  # of the boats in the course
    troubles: tuple[str, ...] = ()  # recordings that could not be judged


def gather_class(folder: Path, pages: Path | None, cores: int) -> ClassDebrief:
    """Return the debrief of the class in a folder; ConfigError without a run.

    With ``pages`` each boat's own debrief is written into that folder. What is kept beside a
    recording is taken from there, and what is missing is judged on so many processors.
    """
    planned, troubles = kept_class(folder), list[str]()
    dated = sorted(found_runs(folder, troubles))
    found = list(latest_runs(dated))
    page_of = {run: pages / page_name(run) if pages else None for run in found}
    summaries: dict[FoundRun, RunSummary | str | None] = {
        run: ready_summary(run.path, page_of[run]) for run in found
    }
    if pages and found:
        made_folder(pages)
    missing = [run for run in found if summaries[run] is None]
    with counted_progress(len(missing)) as count_one:
        tasks = [(run.path, page_of[run]) for run in missing]
        for run, made in zip(missing, map_tasks(make_summary, tasks, cores), strict=True):
            summaries[run] = made
            count_one()
    troubles += [each for each in summaries.values() if isinstance(each, str)]
    known = [(run, each) for run, each in summaries.items() if isinstance(each, RunSummary)]
    judged = [(run, each) for run, each in known if each.run.seconds]
    troubles += [f"boat {run.boat} has not begun" for run, each in known if not each.run.seconds]
    if not judged:
        raise ConfigError(*(troubles or [f"{folder}: no boat of this class has a recording"]))
    by_exercise: dict[str, list[BoatRun]] = defaultdict(list)
    for run, summary in judged:
        name, page = planned.row_of(run.boat).name or "", page_of[run]
        boat_run = BoatRun(run.boat, name, run.attempts, summary, page.name if page else "")
        by_exercise[run.exercise].append(boat_run)
    course = ClassCourse(planned.course)
    names = sorted(by_exercise, key=lambda name: course.place_of(name) or len(by_exercise))
    exercises = tuple(class_exercise(name, by_exercise[name]) for name in names)
    marks = {(run.boat, run.exercise): summary.run.total for run, summary in judged}
    places = boat_places(planned, {boat: name for _, boat, name, _ in dated}, marks)
    return ClassDebrief(folder.resolve().name, exercises, course, places, tuple(troubles))


def found_runs(folder: Path, troubles: list[str]) -> Iterator[tuple[str, int, str, Path]]:
    """Yield when each recording of a class began, its boat, exercise and path.

    What cannot be read is added to ``troubles``.
    """
    for path in sorted(folder.glob(f"boat-*/*{RECORDING_SUFFIX}")):
        number = path.parent.name.removeprefix("boat-")
        if not number.isdecimal():
            continue
        try:
            with open_recording(path) as recording:
                header = recording.header()
            yield header.get("started", ""), int(number), exercise_of(header), path
        except ConfigError as wrong:
            troubles.append(str(wrong))


def latest_runs(dated: Sequence[tuple[str, int, str, Path]]) -> Iterator[FoundRun]:
    """Yield the latest run of each boat in each exercise, exercises as they were begun.

    ``dated`` are all runs, in the order in which they began.
    """
    exercises = list(dict.fromkeys(exercise for _, _, exercise, _ in dated))
    attempts = Counter((boat, exercise) for _, boat, exercise, _ in dated)
    latest = {(boat, exercise): path for _, boat, exercise, path in dated}
    for exercise in exercises:
        for boat in sorted(boat for boat, sailed in latest if sailed == exercise):
            key = boat, exercise
            yield FoundRun(boat, exercise, latest[key], attempts[key])


def page_name(run: FoundRun) -> str:
    """Return the name of a boat's own page in the folder of a class's pages."""
    return f"boat-{run.boat}-{run.path.stem}.html"


def ready_summary(path: Path, page: Path | None) -> RunSummary | None:
    """Return a kept summary, None if that or its page has to be made."""
    summary = kept_summary(path)
    if summary is None or page is None:
        return summary
    sources = (each for each in (summary_path(path), forms_path(path)) if each.exists())
    newest = max(each.stat().st_mtime_ns for each in sources)
    return summary if page.exists() and page.stat().st_mtime_ns >= newest else None


def make_summary(path: Path, page: Path | None) -> RunSummary | str:
    """Judge a recording and write its page; return its summary, or why there is none."""
    try:
        with np.errstate(all="ignore"):  # a state may hold any number
            debrief = compare_debrief(read_dossier(path, None))
            summary = summary_of(debrief)
            keep_summary(path, summary)
            if page is not None:
                write_over(page, render(debrief))
    except ConfigError as wrong:
        return str(wrong)
    except Exception as wrong:  # noqa: BLE001 whatever one file does, the others are judged
        return unforeseen(path, wrong)
    return summary


@contextlib.contextmanager
def counted_progress(whole: int) -> Iterator[Callable[[], None]]:
    """Show on a terminal how many recordings are judged; the function counts one more."""
    done = count()

    def show() -> None:
        if whole and sys.stderr.isatty():
            sys.stderr.write(f"\rjudging recordings ... {next(done)} of {whole} ")
            sys.stderr.flush()

    show()
    try:
        yield show
    finally:
        if whole and sys.stderr.isatty():
            sys.stderr.write("\r\x1b[K")


def class_exercise(exercise: str, runs: Sequence[BoatRun]) -> ClassExercise:
    """Return an exercise with its runs, and what several boats lost."""
    losses = {each.boat: each.summary.losses for each in runs}
    title = runs[0].summary.run.title or exercise or "Without an exercise"
    return ClassExercise(exercise, title, tuple(runs), class_lessons(losses))


def class_lessons(losses: Mapping[int, Iterable[LostMarks]]) -> tuple[ClassLesson, ...]:
    """Return the minutes in which several boats lost marks, that of most boats first.

    A loss belongs to one lesson: the minute of most boats, then of most marks, takes it.
    """
    rest = sorted(
        ((each.seconds, boat, each) for boat, own in losses.items() for each in own),
        key=lambda entry: entry[:2],
    )
    lessons: list[ClassLesson] = []
    while rest and len(lessons) < MAX_LESSONS:
        groups = [
            [each for each in rest if begin <= each[0] < begin + SAME_TIME_S]
            for begin in dict.fromkeys(entry[0] for entry in rest)
        ]
        best = max(groups, key=lambda each: (len({boat for _, boat, _ in each}), _lost(each)))
        boats = sorted({boat for _, boat, _ in best})
        if len(boats) < MIN_LESSON_BOATS:
            break
        by_task: dict[str, float] = defaultdict(float)
        for _, _, loss in best:
            by_task[loss.task] += loss.marks
        task = max(by_task, key=lambda name: by_task[name])
        lessons.append(
            ClassLesson(best[0][0], best[-1][0], tuple(boats), _lost(best) / len(boats), task)
        )
        rest = [each for each in rest if each not in best]
    return tuple(lessons)


def _lost(group: Iterable[tuple[float, int, LostMarks]]) -> float:
    return sum(loss.marks for _, _, loss in group)


def lesson_lines(exercise: ClassExercise) -> list[str]:
    """Return what the class lost together, a sentence each."""
    curves = sum(bool(each.summary.points) for each in exercise.runs)
    if not curves:
        return [f"There are no curves: {exercise.runs[0].summary.no_curve}."]
    if not exercise.lessons:
        return ["No two boats lost marks in the same minute."]
    return [each.told(curves) for each in exercise.lessons]


def counted(number: int, noun: str) -> str:
    """Return a number of things in words: 1 boat, 2 boats."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def marks_words(run: ProgressRun) -> str:
    """Return the marks of a run with their standard error, "-" for none."""
    if run.total is None:
        return "-"
    error = run.standard_error
    sure = f" \N{PLUS-MINUS SIGN}{error:.0f}" if error is not None else ""
    return f"{run.total:.0f}{sure}" + ("" if run.counts else " (practice or free)")


def class_text(debrief: ClassDebrief) -> str:
    """Return the debrief of a class for a terminal of 80 columns."""
    lines: list[str] = []
    for exercise in debrief.exercises:
        mean = "" if exercise.mean is None else f", mean {exercise.mean:.0f}"
        lines.append(f"{exercise.title}: {counted(len(exercise.runs), 'boat')}{mean}")
        for each in exercise.runs:
            run, boat = each.summary.run, f"{each.boat:3} {each.name}".rstrip()
            who = ", ".join(each.summary.trainees) or "-"
            lines.append(f"{boat:16} {marks_words(run):>9}  {run.outcome or '-':11}  {who}")
        lines += [*lesson_lines(exercise), ""]
    lines += [f"boat {each.boat} is at {each.told}" for each in debrief.places]
    lines += debrief.troubles
    wrapped = (fill(plain(line), TEXT_WIDTH) if len(line) > TEXT_WIDTH else line for line in lines)
    return "\n".join(wrapped).rstrip()


def class_table(debrief: ClassDebrief) -> Iterator[tuple[object, ...]]:
    """Yield a row for each trainee and exercise; a nameless boat has one too."""
    for exercise in debrief.exercises:
        row = debrief.course.row_of(exercise.exercise)
        place = debrief.course.place_of(exercise.exercise) or ""
        for each in exercise.runs:
            own = dict(zip(each.summary.trainees, each.summary.own_marks, strict=True))
            for name in each.summary.trainees or ("",):
                run = replace(each.summary.run, own_marks=own.get(name))
                (told,) = class_rows([Progress(name, (run,))])
                boat = debrief.name, each.boat, each.name
                yield (*boat, *told, place, row.reach if row else None)


def class_figures(debrief: ClassDebrief) -> dict[str, Any]:
    """Return the debrief of a class for programs; times in s, marks in per cent."""
    return {
        "class": debrief.name,
        "exercises": [
            {
                "exercise": exercise.exercise,
                "title": exercise.title,
                "mean": exercise.mean,
                "lessons": [asdict(each) for each in exercise.lessons],
                "boats": [_boat_figures(each) for each in exercise.runs],
            }
            for exercise in debrief.exercises
        ],
        "course": [{"exercise": row.name, "reach": row.reach} for row in debrief.course.rows],
        "places": [asdict(place) for place in debrief.places],
        "troubles": list(debrief.troubles),
    }


def _boat_figures(each: BoatRun) -> dict[str, Any]:
    run, summary = each.summary.run, each.summary
    return {
        "boat": each.boat,
        "name": each.name,
        "attempts": each.attempts,
        "recording": run.recording,
        "branch": run.branch,
        "outcome": run.outcome,
        "marks": run.total,
        "standard_error": run.standard_error,
        "counts": run.counts,
        "trainees": [
            {"name": name, "own_marks": marks}
            for name, marks in zip(summary.trainees, summary.own_marks, strict=True)
        ],
        "attainable": [{"seconds": at, "marks": marks} for at, marks in summary.points],
        "losses": [asdict(loss) for loss in summary.losses],
        "why_no_curve": summary.no_curve,
    }

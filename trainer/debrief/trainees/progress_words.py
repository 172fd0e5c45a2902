"""A trainee's way through the course for a terminal, and a class as a table.

``trainer recordings`` calls it: ``--progress`` prints the way, from which a trainee sees what is
next and what cost most; ``--csv`` writes the runs of all trainees, or of one, for a spreadsheet.
"""

import csv
import glob
import shlex
import shutil
import sys
import textwrap
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import click

from trainer.config.exercise.course import Lesson, course, lessons
from trainer.config.exercise.progress import (
    COST_KINDS,
    LATEST_RUNS,
    Progress,
    ProgressRun,
    all_progress,
    file_stem,
    progress_path,
    read_file,
)
from trainer.config.files import ConfigError, nearest, quote
from trainer.debrief.trainees.history import recordings_in
from trainer.io.lines import plain
from trainer.io.outputs import replacing

HEIGHTS: Final = "▁▂▃▄▅▆▇█"  # of marks, from none to all
TITLE_COLUMNS: Final = 34
DRAWN_RUNS: Final = 12  # the latest, a column each
WORD_COLUMNS: Final = 11  # of outcomes and kinds
MAX_COLUMNS: Final = 80
CSV_HEADER: Final = (
    *("trainee", "exercise", "title", "started", "minutes", "outcome", "marks", "standard_error"),
    *("own_marks", "counts", "aids"),
    *(kind.replace(" ", "_") for kind in COST_KINDS),
    *("recording", "branch"),
)


def progress_lines(progress: Progress, width: int = MAX_COLUMNS) -> Iterator[str]:
    """Yield the way of a trainee: lessons, exercises, what cost most, and what is next."""
    all_lessons, exercises = lessons(), course()
    hours, minutes = divmod(round(sum(each.seconds for each in progress.runs) / 60.0), 60)
    runs = "1 run" if len(progress.runs) == 1 else f"{len(progress.runs)} runs"
    sailed = f"{runs}, {hours} h {minutes:02d} min"
    name = plain(progress.trainee)
    yield f"{name[: width - len(sailed) - 2]:<{width - len(sailed)}}{sailed}"
    for title, offered in (("Lessons", all_lessons), ("Exercises", exercises)):
        passed = [each for each in offered if progress.passed(each.name)]
        done = "".join("■" if each in passed else "·" for each in offered)
        yield ""
        yield f"{title:<{WORD_COLUMNS}}{done}  {len(passed)} of {len(offered)}"
        yield from (
            exercise_line(each, progress.of(each.name))
            for each in offered
            if progress.of(each.name)
        )
    known = {each.name for each in (*all_lessons, *exercises)}
    others = {each.exercise: each for each in progress.runs if each.exercise not in known}
    for exercise, run in others.items():
        lesson = Lesson(0.0, exercise, run.title or "sailed freely", "")
        yield exercise_line(lesson, progress.of(exercise))
    yield from cost_lines(progress, width)
    yield ""
    if suggestion := progress.suggest([*all_lessons, *exercises], datetime.now(UTC).date()):
        following, reason = suggestion
        yield f"Next: {following.title}"
        indent = " " * len("Next: ")
        yield from textwrap.wrap(reason, width, initial_indent=indent, subsequent_indent=indent)
        yield f"{indent}trainer run {following.name} --train --trainee {shlex.quote(name)}"


def exercise_line(lesson: Lesson, runs: Sequence[ProgressRun]) -> str:
    """Return the line of an exercise: best run, marks as columns, how often, aids."""
    marked = [each.total for each in runs if each.total is not None]
    best = max(runs, key=lambda each: (each.passed, each.total or 0.0))
    drawn = "".join(HEIGHTS[min(int(mark / 12.5), 7)] for mark in marked[-DRAWN_RUNS:])
    marks = f"{best.total:3.0f}" if best.total is not None else "   "
    aids = f" with {best.aids}" if best.aids else ""
    practice = "" if best.counts else " practice"
    title = plain(lesson.title)[:TITLE_COLUMNS]
    row = f"  {title:<{TITLE_COLUMNS}} {best.outcome or 'sailed':<{WORD_COLUMNS}} {marks}"
    return f"{row} {drawn:<{DRAWN_RUNS}} {len(runs):2d}x{aids}{practice}"[:MAX_COLUMNS].rstrip()


def cost_lines(progress: Progress, width: int) -> Iterator[str]:
    """Yield a bar for each kind of loss over the latest runs with marks."""
    costs = progress.costs
    most = max(costs.values())
    if not most:
        return
    yield ""
    yield f"What cost most in the last {LATEST_RUNS} runs with marks [marks]"
    room = width - WORD_COLUMNS - 8
    for kind, marks in sorted(costs.items(), key=lambda each: -each[1]):
        if marks:
            yield f"  {kind:<{WORD_COLUMNS}}{marks:4.0f} {'█' * max(round(marks / most * room), 1)}"


def find_progress(name: str) -> Progress:
    """Return a trainee's progress; ConfigError naming the nearest trainee without one."""
    file_stem(name)
    path = progress_path(name)
    if path.exists():
        return read_file(path)
    names = [each.trainee for each in all_progress() if isinstance(each, Progress)]
    raise ConfigError(
        f"--trainee {quote(name)}: has no progress yet{nearest(name, names)}; "
        "trainer run --trainee NAME keeps one"
    )


def print_progress(name: str) -> None:
    """Print a trainee's way through the course; ConfigError."""
    columns = shutil.get_terminal_size().columns if sys.stdout.isatty() else MAX_COLUMNS
    path = progress_path(name)
    for damaged in sorted(path.parent.glob(f"{glob.escape(path.name)}.damaged*")):
        click.echo(f"trainer: {damaged}: could not be read, and is kept", err=True)
    for line in progress_lines(find_progress(name), min(columns, MAX_COLUMNS)):
        click.echo(line)


def write_class(path: Path, name: str | None, places: Sequence[Path] = ()) -> None:
    """Write the runs of all trainees, or of one, as CSV; ConfigError.

    With ``places`` they are those whose recordings lie there.
    """
    found = [find_progress(name)] if name is not None else list(all_progress())
    for wrong in (each for each in found if isinstance(each, ConfigError)):
        click.echo(f"trainer: left out: {wrong}", err=True)
    known = [each for each in found if isinstance(each, Progress)]
    if places:
        names = {each.name for each in recordings_in(places)}
        chosen = [replace(each, runs=runs_of(each, names)) for each in known]
        known = [each for each in chosen if each.runs]
    write_table(path, CSV_HEADER, class_rows(known))
    runs = sum(len(each.runs) for each in known)
    click.echo(f"{path}: {runs} runs of {len(known)} trainees")


def runs_of(progress: Progress, recordings: Container[str]) -> tuple[ProgressRun, ...]:
    """Return the runs of a trainee that some recordings keep, by the files' names."""
    return tuple(each for each in progress.runs if each.recording in recordings)


def write_table(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a table as CSV; ConfigError."""
    try:
        with replacing(path) as made, made.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(header)
            writer.writerows(rows)
    except OSError as error:
        raise ConfigError(f"--csv {path}: {error.strerror}") from None


def _figures(run: ProgressRun) -> Iterable[float | None]:
    return run.total, run.standard_error, run.own_marks


def class_rows(found: Iterable[Progress]) -> Iterator[tuple[object, ...]]:
    """Yield the row of each run."""
    for progress in found:
        for run in progress.runs:
            figures = ("" if n is None else f"{n:.1f}" for n in _figures(run))
            known = run.costs  # nothing before they are known: a flight of its own finds them
            costs = (f"{known.get(kind, 0.0):.1f}" if known else "" for kind in COST_KINDS)
            yield (
                *(progress.trainee, run.exercise, run.title, run.started),
                *(f"{run.seconds / 60.0:.1f}", run.outcome, *figures),
                *("yes" if run.counts else "no", run.aids, *costs, run.recording, run.branch),
            )

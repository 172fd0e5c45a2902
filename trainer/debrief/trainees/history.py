"""Recordings and their trainees: the list, and a trainee's history.

``trainer recordings`` prints them. The result of a recording is computed once and kept beside it:
drill.marks.json beside drill.trainer. That file may be removed at any time. It has no names,
because names stand in the recordings alone.
"""

import json
import math
import shutil
import sys
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from trainer import __version__
from trainer.config.exercise.class_file import recording_folders
from trainer.config.exercise.outcome import Outcome
from trainer.config.files import ConfigError, nearest, quote
from trainer.debrief.marks.changes import changes_path
from trainer.debrief.page.data import DebriefData, gather_debrief, standard_error_of
from trainer.io.lines import plain
from trainer.io.outputs import renew_whole
from trainer.io.paths import RECORDING_SUFFIX, recordings_folder
from trainer.io.recording.recording import ExcessRows
from trainer.session.past.header import (
    FAMILIARISATION_KEY,
    open_recording,
    open_whole_recording,
    trainees_of,
)

MARKS_SUFFIX: Final = ".marks.json"  # ends the name of the file
MARKS_SCHEMA: Final = "marks/1"
MEAN_ATTEMPTS: Final = 3  # attempts whose mean is told
MIN_LIST_WIDTH: Final = 60  # [columns] that a line of the list needs
MAX_QUICK_BYTES: Final = 10_000_000  # of a recording that is judged in its turn in the list
MARK_TYPES: Final[Mapping[str, Any]] = {  # of what is kept
    **dict.fromkeys(("exercise", "width", "outcome"), str),
    **dict.fromkeys(("counts", "changed"), bool),
    **dict.fromkeys(("seed", "branch", "branches"), int),
    **dict.fromkeys(("total", "standard_error"), float | int | None),
    "aids": str,
}


@dataclass(frozen=True)
class RecordedResult:
    """The result of a recording."""

    exercise: str  # its title, "" without one
    seed: int
    width: str
    outcome: Outcome
    total: float | None  # [%] None: no marks
    counts: bool  # neither free nor practice
    changed: bool  # by the instructor
    aids: str = ""  # that were used
    branch: int = 1  # that was judged
    branches: int = 1  # in all
    standard_error: float | None = None  # [%] of the mark, from run to run; None: unknown


@dataclass(frozen=True)
class ListedRecording:
    """A recording as it is listed."""

    path: Path
    started: str
    trainees: tuple[str, ...]
    came: RecordedResult | None
    trouble: str = ""  # why it cannot be read
    familiarisation: bool = False  # a run to get to know the simulator, without marks
    excess: tuple[ExcessRows, ...] = ()  # of what it has more than is read


@dataclass(frozen=True)
class AttemptHistory:
    """The history of a trainee in one exercise at one width, the oldest first."""

    exercise: str
    width: str
    attempts: int
    seeds: tuple[int, ...]
    marks: tuple[float, ...]  # [%] of those that count

    @property
    def mean(self) -> float | None:
        """Return the mean of the last marks, None without any."""
        last = self.marks[-MEAN_ATTEMPTS:]
        return math.fsum(last) / len(last) if last else None


def searched(sources: Sequence[Path]) -> Sequence[Path]:
    """Return the sources that are asked for, or the recordings' folder if it is there."""
    return sources or [folder for folder in (recordings_folder(),) if folder.is_dir()]


def recordings_in(sources: Sequence[Path]) -> Iterator[Path]:
    """Yield the recordings that are searched, also of classes, the newest first; ConfigError."""
    dated: list[tuple[float, Path]] = []
    for source in searched(sources):
        folders = recording_folders(source) if source.is_dir() else ()
        inside = [path for folder in folders for path in folder.glob(f"*{RECORDING_SUFFIX}")]
        try:
            dated += [(path.stat().st_mtime, path) for path in (inside if folders else [source])]
        except OSError as error:
            raise ConfigError(f"{source}: {error.strerror}") from None
    yield from (path for _, path in sorted(dated, key=lambda each: each[0], reverse=True))


def latest_recording() -> Path:
    """Return the recording that was written last; ConfigError if there is none."""
    for recording in recordings_in(()):
        return recording
    raise ConfigError(
        f"--last: no recording is in {recordings_folder()}: trainer run EXERCISE makes one, "
        "or name a FILE"
    )


def list_recording(path: Path) -> ListedRecording:
    """Return a recording for the list. One that cannot be read has the reason instead."""
    try:
        return _listed(path)
    except Exception as wrong:  # noqa: BLE001 whatever one file does, the others are listed
        return ListedRecording(path, "", (), None, unforeseen(path, wrong))


def unforeseen(path: Path, wrong: Exception) -> str:
    """Return in a line what a file made the program do that nobody has foreseen."""
    return f"{path}: cannot be read: {type(wrong).__name__}: {quote(str(wrong))}"


def _listed(path: Path) -> ListedRecording:
    try:
        with open_recording(path) as recording:
            header, excess = recording.header(), recording.excess()
    except ConfigError as wrong:
        return ListedRecording(path, "", (), None, str(wrong))
    listed = ListedRecording(
        path,
        header.get("started", ""),
        trainees_of(header),
        None,
        excess=excess,
        familiarisation=FAMILIARISATION_KEY in header,
    )
    try:
        return replace(listed, came=kept_result(path) or compute_result(path))
    except ConfigError as wrong:
        return replace(listed, trouble=str(wrong))


def kept_result(path: Path) -> RecordedResult | None:
    """Return the result kept beside a recording; None if recording or program has changed."""
    try:
        marks = json.loads(marks_path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(marks, dict) or marks.get("of") != recording_stamp(path):
        return None
    came = marks.get("came")
    if not isinstance(came, dict) or came.keys() != MARK_TYPES.keys():
        return None
    if not all(isinstance(came[name], kind) for name, kind in MARK_TYPES.items()):
        return None
    known = came["outcome"] in tuple(Outcome)
    return RecordedResult(**{**came, "outcome": Outcome(came["outcome"])}) if known else None


def compute_result(path: Path) -> RecordedResult:
    """Return the result of a recording, and keep it if the folder allows; ConfigError."""
    with np.errstate(all="ignore"), open_whole_recording(path) as recording:
        came = came_of(gather_debrief(recording, path, None))
    if not path.with_name(f"{path.name}-wal").exists():  # else it is being written
        text = json.dumps({"of": recording_stamp(path), "came": asdict(came)}, indent=1)
        try:
            renew_whole(marks_path(path), text + "\n")
        except OSError:  # a folder that is not ours
            return came
    return came


def came_of(debrief: DebriefData) -> RecordedResult:
    """Return the result of a run, with the instructor's changes."""
    verdict = debrief.final.verdict
    return RecordedResult(
        exercise=debrief.plan.title,
        seed=debrief.plan.seed,
        width=debrief.width,
        outcome=verdict.outcome if verdict else Outcome.UNDECIDED,
        total=debrief.total,
        counts=not (debrief.free or debrief.practice or debrief.familiarisation),
        changed=debrief.changed is not None,
        aids=", ".join(debrief.aids),
        branch=debrief.branch.id,
        branches=len(debrief.branches),
        standard_error=standard_error_of(debrief) if debrief.total is not None else None,
    )


def recording_stamp(path: Path) -> dict[str, Any]:
    """Return the stamp by which a changed recording, change file or program is noticed."""
    state = path.stat()
    try:
        changes = changes_path(path).stat().st_mtime_ns
    except OSError:
        changes = None
    return {
        "schema": MARKS_SCHEMA,
        "trainer": __version__,
        "size": state.st_size,
        "mtime_ns": state.st_mtime_ns,
        "changes_ns": changes,
    }


def marks_path(recording: Path) -> Path:
    """Return the path of a recording's result, which is kept beside it."""
    return recording.with_name(f"{recording.stem}{MARKS_SUFFIX}")


# Trainees


def fold_name(name: str) -> str:
    """Return a name in the form in which names are compared."""
    return " ".join(name.split()).casefold()


def of_trainee(found: Sequence[ListedRecording], name: str) -> list[ListedRecording]:
    """Return the recordings of a trainee; ConfigError naming the nearest if there are none."""
    own_recordings = [each for each in found if fold_name(name) in map(fold_name, each.trainees)]
    if not own_recordings:
        names = sorted({each for one in found for each in one.trainees})
        raise ConfigError(
            f"--trainee {quote(name)}: no recording has that name{nearest(name, names)}; "
            "trainer run EXERCISE --trainee NAME keeps one"
        )
    return own_recordings


def trainee_history(own: Iterable[ListedRecording]) -> list[AttemptHistory]:
    """Return a trainee's attempts by exercise and width; recordings come newest first."""
    by_kind: dict[tuple[str, str], list[RecordedResult]] = {}
    for entry in own:
        if entry.came is not None and not entry.familiarisation:
            by_kind.setdefault((entry.came.exercise, entry.came.width), []).insert(0, entry.came)
    return [
        AttemptHistory(
            exercise or "without an exercise",
            width,
            len(came),
            tuple(sorted({each.seed for each in came})),
            tuple(each.total for each in came if each.counts and each.total is not None),
        )
        for (exercise, width), came in sorted(by_kind.items())
    ]


# As printed


def print_list(sources: Sequence[Path], *, as_json: bool) -> None:
    """Print the recordings, each as soon as it is known; slow ones come last."""
    paths = list(recordings_in(sources))
    paths.sort(key=lambda path: path.stat().st_size > MAX_QUICK_BYTES and kept_result(path) is None)
    if as_json:
        click.echo(json.dumps(as_figures(map(list_recording, paths)), indent=1))
        return
    if not paths:
        where = ", ".join(map(str, sources)) or recordings_folder()
        click.echo(f"no recording is in {where}: trainer run EXERCISE makes one")
    columns = shutil.get_terminal_size().columns if sys.stdout.isatty() else None
    for line in list_lines(map(list_recording, paths), columns):
        click.echo(plain(line))


def print_history(sources: Sequence[Path], name: str, *, as_json: bool) -> None:
    """Print a trainee's attempts; ConfigError if no recording has that name."""
    own = of_trainee(list(map(list_recording, recordings_in(sources))), name)
    attempts = trainee_history(own)
    if as_json:
        figures = [asdict(each) | {"mean_of_last": each.mean} for each in attempts]
        click.echo(json.dumps(figures, indent=1))
        return
    click.echo("\n".join(map(plain, [*history_lines(attempts), *familiarisation_lines(own)])))


def list_lines(found: Iterable[ListedRecording], columns: int | None = None) -> Iterator[str]:
    """Yield a line for each recording: time, exercise, trainees and result.

    Exercise, names and file are shortened with an ellipsis to fit ``columns``, with None not.
    """
    width = None if columns is None else max(columns, MIN_LIST_WIDTH)
    for recording in found:
        if recording.came is not None:
            yield _row(recording, recording.came, width)
            continue
        trouble = f"{recording.path.name}: cannot be read: {recording.trouble}"
        line = f"{_day(recording.started):16}  {trouble}"
        if width is None:
            yield line
        else:  # names of files stay in one piece
            rest = " " * 18
            yield from textwrap.wrap(
                plain(line), width, subsequent_indent=rest, break_on_hyphens=False
            )


def _row(each: ListedRecording, came: RecordedResult, width: int | None) -> str:
    """Return the line of a recording that can be read, in ``width`` columns if there is one."""
    star = "*" if came.changed else ""
    free = "" if came.counts else " (practice or free)"
    free = " (familiarisation)" if each.familiarisation else free
    free += f" (with {came.aids})" if came.aids else ""
    free += f" (branch {came.branch} of {came.branches})" if came.branch < came.branches else ""
    free += "".join(f" ({one})" for one in each.excess)
    exercise, who = came.exercise or "-", ", ".join(each.trainees) or "-"
    result = f"{came.outcome or '-':11}  {_mark(came.total):>4}{star:1}"
    day = f"{_day(each.started):16}"
    if width is None:
        return f"{day}  {exercise:26}  {result}  {who}  {each.path.name}{free}"
    room = width // 5  # of the exercise
    head = f"{day}  {shorten_text(plain(exercise), room):{room}}  {result}  "
    tail = [who, each.path.name, free.strip()] if free else [who, each.path.name]
    return head + "  ".join(fit_texts(tail, width - len(head)))


def shorten_text(text: str, most: int) -> str:
    """Return a text in ``most`` characters, one at least; an ellipsis ends what is cut."""
    return text if len(text) <= most else f"{text[: most - 1].rstrip()}…"


def fit_texts(texts: Iterable[str], room: int) -> list[str]:
    """Return texts that fit ``room`` [columns] with two between them; the longest are cut."""
    whole = [plain(text) for text in texts]
    room_left = room - 2 * (len(whole) - 1)
    most = room_left
    for done, size in enumerate(sorted(map(len, whole))):
        most = room_left // (len(whole) - done)
        if size > most:
            break
        room_left -= size
    return [shorten_text(text, max(most, 1)) for text in whole]


def history_lines(found: Iterable[AttemptHistory]) -> Iterator[str]:
    """Yield the history of a trainee, a line for each exercise."""
    yield f"{'exercise':28}  {'width':9}  mean of last {MEAN_ATTEMPTS}  attempts  seeds"
    for attempts in found:
        seeds = ", ".join(map(str, attempts.seeds))
        yield (
            f"{attempts.exercise:28}  {attempts.width:9}  {_mark(attempts.mean):>14}  "
            f"{attempts.attempts:8}  {seeds}"
        )


def familiarisation_lines(own: Iterable[ListedRecording]) -> Iterator[str]:
    """Yield a line for each familiarisation run, the newest first."""
    for each in own:
        if each.familiarisation:
            exercise = (each.came and each.came.exercise) or "without an exercise"
            yield f"familiarisation  {_day(each.started)}  {exercise}  {each.path.name}"


def as_figures(found: Iterable[ListedRecording]) -> list[dict[str, Any]]:
    """Return recordings for programs."""
    return [
        {
            "file": str(recording.path),
            "started": recording.started,
            "trainees": list(recording.trainees),
            "trouble": recording.trouble,
            "familiarisation": recording.familiarisation,
            "left_out": [asdict(one) for one in recording.excess],
            **(asdict(recording.came) if recording.came else {}),
        }
        for recording in found
    ]


def _day(started: str) -> str:
    return started[:16].replace("T", " ")


def _mark(total: float | None) -> str:
    return "-" if total is None else f"{total:.0f}"

"""Recordings and who was trained in them: the list, the history of a trainee, a name forgotten.

What a recording came to is computed once and kept beside it: drill.marks.json beside
drill.trainer. It may be removed at any time; names stand in the recordings alone.
"""

import json
import statistics
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer import __version__
from trainer.analysis.debrief.changes import changes_path
from trainer.analysis.debrief.data import DebriefData, gather
from trainer.config.files import ConfigError, nearest, quote
from trainer.io.atomic_write import write_whole
from trainer.io.paths import SUFFIX, recordings_folder
from trainer.session.header import reading, trainees_of

MARKS: Final = ".marks.json"  # ends the name of the file
SCHEMA: Final = "marks/1"
LAST: Final = 3  # attempts whose mean is told


@dataclass(frozen=True)
class Came:
    """What a recording came to."""

    exercise: str  # its title, "" without one
    seed: int
    width: str
    outcome: str  # "" where nothing decides it
    total: float | None  # [%] None: no marks
    counts: bool  # neither free nor practice
    changed: bool  # by the instructor


KINDS: Final[Mapping[str, Any]] = {  # of what is kept
    **dict.fromkeys(("exercise", "width", "outcome"), str),
    **dict.fromkeys(("counts", "changed"), bool),
    "seed": int,
    "total": float | int | None,
}


@dataclass(frozen=True)
class Listed:
    """A recording as it is listed."""

    path: Path
    started: str
    trainees: tuple[str, ...]
    came: Came | None
    trouble: str = ""  # why it cannot be read


@dataclass(frozen=True)
class Attempts:
    """What a trainee has done in one exercise at one width, the oldest first."""

    exercise: str
    width: str
    attempts: int
    seeds: tuple[int, ...]
    marks: tuple[float, ...]  # [%] of those that count

    @property
    def mean(self) -> float | None:
        """Return the mean of the last marks, None without any."""
        return statistics.fmean(self.marks[-LAST:]) if self.marks else None


def recordings_in(places: Iterable[Path]) -> Iterator[Path]:
    """Yield the recordings in folders, and those named, the newest first; ConfigError."""
    found: list[tuple[float, Path]] = []
    for place in places:
        inside = place.glob(f"*{SUFFIX}") if place.is_dir() else iter((place,))
        try:
            found += [(path.stat().st_mtime, path) for path in inside]
        except OSError as error:
            raise ConfigError(f"{place}: {error.strerror}") from None
    yield from (path for _, path in sorted(found, key=lambda each: each[0], reverse=True))


def latest() -> Path:
    """Return the recording that was written last; ConfigError, saying what to do, without any."""
    folder = recordings_folder()
    found = next(recordings_in([folder] if folder.is_dir() else []), None)
    if found is None:
        raise ConfigError(
            f"--last: no recording is in {folder}: trainer run EXERCISE makes one, or name a FILE"
        )
    return found


def listed(path: Path) -> Listed:
    """Return a recording as it is listed; one that cannot be read says why."""
    try:
        with reading(path) as recording:
            header = recording.header()
    except ConfigError as wrong:
        return Listed(path, "", (), None, str(wrong))
    started, names = header.get("started", ""), trainees_of(header)
    try:
        return Listed(path, started, names, kept(path) or computed(path))
    except ConfigError as wrong:
        return Listed(path, started, names, None, str(wrong))


def kept(path: Path) -> Came | None:
    """Return what is kept beside a recording, None where that is of another state of it."""
    try:
        found = json.loads(marks_path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    if not isinstance(found, dict) or found.get("of") != stamp(path):
        return None
    came = found.get("came")
    if not isinstance(came, dict) or came.keys() != KINDS.keys():
        return None
    good = all(isinstance(came[name], kind) for name, kind in KINDS.items())
    return Came(**came) if good else None


def computed(path: Path) -> Came:
    """Return what a recording came to, and keep it where that can be; ConfigError."""
    with np.errstate(all="ignore"), reading(path) as recording:
        came = came_of(gather(recording, path, None))
    if not _beside(path, "-wal").exists():  # else it is being written
        text = json.dumps({"of": stamp(path), "came": asdict(came)}, indent=1)
        try:
            write_whole(marks_path(path), text + "\n")
        except OSError:  # a folder that is not ours
            return came
    return came


def came_of(debrief: DebriefData) -> Came:
    """Return what a run came to, as the instructor has changed it."""
    verdict = debrief.final.verdict
    return Came(
        exercise=debrief.plan.title,
        seed=debrief.plan.seed,
        width=debrief.width,
        outcome=verdict.outcome if verdict else "",
        total=debrief.total,
        counts=not (debrief.free or debrief.practice),
        changed=debrief.changed is not None,
    )


def stamp(path: Path) -> dict[str, Any]:
    """Return by what is told whether a recording, its changes or the program are others now."""
    state = path.stat()
    try:
        changes = changes_path(path).stat().st_mtime_ns
    except OSError:
        changes = None
    return {
        "schema": SCHEMA,
        "trainer": __version__,
        "size": state.st_size,
        "mtime_ns": state.st_mtime_ns,
        "changes_ns": changes,
    }


def marks_path(recording: Path) -> Path:
    """Return where it is kept what a recording came to: beside it."""
    return recording.with_name(f"{recording.stem}{MARKS}")


def _beside(path: Path, ending: str) -> Path:
    return path.with_name(path.name + ending)


# Trainees


def folded(name: str) -> str:
    """Return a name as names are compared."""
    return " ".join(name.split()).casefold()


def of_trainee(found: Sequence[Listed], name: str) -> list[Listed]:
    """Return the recordings of a trainee; ConfigError naming the nearest if there are none."""
    own = [each for each in found if folded(name) in map(folded, each.trainees)]
    if not own:
        names = sorted({each for one in found for each in one.trainees})
        raise ConfigError(
            f"--trainee {quote(name)}: no recording has that name{nearest(name, names)}; "
            "trainer run EXERCISE --trainee NAME keeps one"
        )
    return own


def history(own: Iterable[Listed]) -> list[Attempts]:
    """Return what a trainee has done, by exercise and width; recordings come newest first."""
    by_kind: dict[tuple[str, str], list[Came]] = {}
    for each in own:
        if each.came is not None:
            by_kind.setdefault((each.came.exercise, each.came.width), []).insert(0, each.came)
    return [
        Attempts(
            exercise or "without an exercise",
            width,
            len(came),
            tuple(sorted({each.seed for each in came})),
            tuple(each.total for each in came if each.counts and each.total is not None),
        )
        for (exercise, width), came in sorted(by_kind.items())
    ]

"""The summary of a judged run: its result, its curve, where marks were lost.

``class_debrief`` puts many of them beside one another. To find a curve the reference crew flies on
from many moments, so a summary is made once and kept beside the recording: drill.summary.json
beside drill.trainer. That file may be removed at any time. It may name who gave an order, so it
goes when a name is forgotten.
"""

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Final

from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import ProgressRun, read_run
from trainer.debrief.attainable.changes import FaultKind, MarkChange
from trainer.debrief.attainable.curve import AttainableCurve
from trainer.debrief.attainable.words import change_words
from trainer.debrief.marks.judgement import dearest_rule
from trainer.debrief.page.data import DebriefData
from trainer.debrief.trainees.history import recording_stamp
from trainer.debrief.trainees.progress import costs_of, own_marks_of, run_of
from trainer.io.outputs import renew_whole

SUMMARY_SUFFIX: Final = ".summary.json"  # ends the name of the file


@dataclass(frozen=True)
class LostMarks:
    """Marks that a run lost for good at one moment, and of which task."""

    seconds: float
    marks: float  # [%] above zero
    task: str
    told: str  # why, in words


@dataclass(frozen=True)
class RunSummary:
    """What a run came to, and what could still be earned over it."""

    run: ProgressRun
    trainees: tuple[str, ...]  # with what each alone has earned beside it [%]
    own_marks: tuple[float | None, ...]
    points: tuple[tuple[float, float], ...] = ()  # time [s], marks that could still be earned [%]
    losses: tuple[LostMarks, ...] = ()
    no_curve: str = ""  # why there are no points


def summary_of(debrief: DebriefData) -> RunSummary:
    """Return the summary of a compared debrief."""
    comparison, step = debrief.compared, debrief.step
    own = tuple(own_marks_of(debrief, name) for name in debrief.trainees)
    run = replace(run_of(debrief, Outcome.LEFT), costs={})  # a plain one crosses processes
    summary = RunSummary(run, debrief.trainees, own)
    if comparison is None or comparison.curve is None:
        why = comparison.no_curve if comparison else "this exercise has no reference crew"
        return replace(summary, no_curve=why)
    curve = comparison.curve
    return replace(
        summary,
        run=replace(run, costs=costs_of(curve.changes)),
        points=tuple((each.tick * step, each.marks) for each in curve.points),
        losses=tuple(losses_of(curve, step)),
    )


def losses_of(curve: AttainableCurve, step: float) -> Iterator[LostMarks]:
    """Yield what the crew lost; a record that ends early is no loss."""
    for change in curve.changes:
        if change.marks < 0.0 and change.fault is not FaultKind.RECORD_ENDS:
            words = change_words(change, step)
            yield LostMarks(change.told_at * step, -change.marks, lost_task(curve, change), words)


def lost_task(curve: AttainableCurve, change: MarkChange) -> str:
    """Return the score that lost most over a change, "" for none."""
    before = [each for each in curve.points if each.tick <= change.begin][-1:]
    after = [each for each in curve.points if each.tick >= change.end][:1]
    cards = [each.card for each in (*before, *after) if each.card is not None]
    return dearest_rule(*cards) if len(cards) == 2 else ""


def summary_path(recording: Path) -> Path:
    """Return the path of a recording's summary, which is kept beside it."""
    return recording.with_name(f"{recording.stem}{SUMMARY_SUFFIX}")


def kept_summary(path: Path) -> RunSummary | None:
    """Return the summary kept beside a recording; None if recording or program has changed."""
    try:
        kept = json.loads(summary_path(path).read_text(encoding="utf-8"))
        if kept["of"] != recording_stamp(path):
            return None
        table = kept["summary"]
        return RunSummary(
            read_run(table["run"]),
            tuple(map(str, table["trainees"])),
            tuple(None if marks is None else float(marks) for marks in table["own_marks"]),
            tuple((float(seconds), float(marks)) for seconds, marks in table["points"]),
            tuple(LostMarks(**each) for each in table["losses"]),
            str(table["no_curve"]),
        )
    except (OSError, ValueError, TypeError, LookupError, AttributeError, RecursionError):
        return None


def keep_summary(path: Path, summary: RunSummary) -> None:
    """Keep a summary beside its recording, if that is complete and the folder allows it."""
    if path.with_name(f"{path.name}-wal").exists():  # it is being written
        return
    kept = {"of": recording_stamp(path), "summary": asdict(summary)}
    try:
        renew_whole(summary_path(path), json.dumps(kept, indent=1, default=float) + "\n")
    except OSError:  # a folder that is not ours
        return

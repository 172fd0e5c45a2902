"""A run that has ended, put into the files of its trainees (``config/exercise/progress``).

A session starts it as a process of its own, by name, with FILE BRANCH HOW. The marks are written
first. What cost most takes longer, because the reference crew flies on from many
moments of the run; it is added when it is known.
"""

import sys
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import COST_KINDS, ProgressRun, add_run
from trainer.config.files import ConfigError
from trainer.debrief.attainable.changes import FaultKind, MarkChange
from trainer.debrief.marks.station_marks import marks_of_person
from trainer.debrief.page.data import DebriefData, compare_debrief, standard_error_of
from trainer.debrief.page.page import read_dossier
from trainer.debrief.passage.controls import SURFACE_ORDERS
from trainer.io.orders.grammar import name_of
from trainer.io.orders.words import ORDER_WORDS
from trainer.session.past.header import exercise_of

FAULT_KINDS: Final[Mapping[FaultKind, str]] = {
    **dict.fromkeys((FaultKind.LATE, FaultKind.MISSING, FaultKind.TURNED), "late"),
    **dict.fromkeys((FaultKind.STEERING, FaultKind.WRONG_AMOUNT), "overshoot"),
    **dict.fromkeys((FaultKind.UNPROVED, FaultKind.RECORD_ENDS), "other"),
}


def run_of(debrief: DebriefData, how: Outcome) -> ProgressRun:
    """Return the entry of a run; ``how`` it ended is told where nothing decides it."""
    verdict = debrief.final.verdict if debrief.plan.scores else None  # a lesson has no marks
    return ProgressRun(
        recording=debrief.source.name,
        branch=debrief.branch.id,
        exercise=exercise_of(debrief.header),
        title=debrief.plan.title,
        started=debrief.header.get("started", ""),
        seconds=float(debrief.trajectory.seconds[-1]),
        outcome=verdict.outcome if verdict else how,
        total=debrief.total if debrief.plan.scores else None,
        counts=not (debrief.free or debrief.practice),
        aids=", ".join(debrief.aids),
        standard_error=standard_error_of(debrief) if debrief.plan.scores else None,
    )


def own_marks_of(debrief: DebriefData, name: str) -> float | None:
    """Return the marks [%] of the tasks that a trainee alone worked, None for none.

    Who is alone aboard needs no relief to be known by name.
    """
    lone = len(debrief.trainees) == 1 and not debrief.manned
    return marks_of_person(debrief.task_marks, "" if lone else name)


def costs_of(changes: Iterable[MarkChange]) -> dict[str, float]:
    """Return the marks [%] that were lost, by kind."""
    costs = dict.fromkeys(COST_KINDS, 0.0)
    for change in changes:
        costs[kind_of(change)] -= change.marks
    return {kind: round(marks, 1) for kind, marks in costs.items()}


def kind_of(change: MarkChange) -> str:
    """Return the kind of a fall, by what was done.

    The right order too late is late; an order the wrong way, or that nobody needs, is the wrong
    way; too much, and what planes and rudder did else, is overshoot. Water that was never moved,
    too much of it, or moved without need, is trim.
    """
    timely = change.fault not in (FaultKind.LATE, FaultKind.WRONG_WAY)
    name = name_of(change.order)
    if timely and name in ORDER_WORDS and "ballast" in ORDER_WORDS[name].moves(""):
        return "trim"
    if change.fault is FaultKind.STEERING and not change.order:  # nobody steered in time
        return "late"
    if change.fault is FaultKind.NEEDLESS and name in SURFACE_ORDERS:
        return "overshoot"
    return FAULT_KINDS.get(change.fault, "wrong way")


def remember_run(path: Path, branch: int, how: Outcome) -> list[str]:
    """Put a run into the files of its trainees; return what was set aside. ConfigError, OSError."""
    with np.errstate(all="ignore"):
        debrief = read_dossier(path, branch)
        if debrief.shown:  # by the reference crew
            return []
        run = run_of(debrief, how)
        own = {name: own_marks_of(debrief, name) for name in debrief.trainees}
        texts = [add_run(name, replace(run, own_marks=own[name])) for name in own]
        comparison = compare_debrief(debrief).compared if debrief.total is not None else None
    if comparison is not None and comparison.curve is not None:
        run = replace(run, costs=costs_of(comparison.curve.changes))
        texts += [add_run(name, replace(run, own_marks=own[name])) for name in own]
    return [each for each in texts if each]


def main() -> None:
    """Remember one run, and print what its user has to know."""
    path, branch, how = sys.argv[1:]
    try:
        texts = remember_run(Path(path), int(branch), Outcome(how))
    except (ConfigError, OSError) as error:
        texts = [f"the progress is not kept: {error}"]
    sys.stdout.write("".join(f"{text}\n" for text in texts))


if __name__ == "__main__":
    main()

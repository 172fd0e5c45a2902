"""Marks of practice runs are told, and count in no mean."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Final

import pytest

from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import ProgressRun
from trainer.debrief.trainees.class_debrief import (
    BoatRun,
    ClassDebrief,
    ClassExercise,
    class_exercise,
    class_figures,
    class_text,
)
from trainer.debrief.trainees.class_page import render_class
from trainer.debrief.trainees.history import ListedRecording, RecordedResult, trainee_history
from trainer.debrief.trainees.run_summary import RunSummary

RUN: Final = ProgressRun(
    "a.trainer", 1, "watch", "The watch", "2026-01-01", 60.0, Outcome.WON, 40.0
)


RESULT: Final = RecordedResult(
    "The watch", 1, "full", Outcome.WON, 40.0, counts=True, changed=False
)
LISTED: Final = ListedRecording(Path("a.trainer"), "2026-01-01", ("Ann",), RESULT)


def boat(number: int, total: float | None, *, counts: bool) -> BoatRun:
    run = replace(RUN, total=total, counts=counts)
    return BoatRun(number, "", 1, RunSummary(run, (), (), no_curve="none is wanted"))


def sailed(*runs: BoatRun) -> ClassExercise:
    return class_exercise("watch", runs)


COUNTED: Final = (boat(1, 40.0, counts=True), boat(2, 50.0, counts=True))
BESIDE: Final = (boat(3, 100.0, counts=False), boat(4, None, counts=True))


def in_figures(exercise: ClassExercise) -> float | None:
    (found,) = class_figures(ClassDebrief("class", (exercise,)))["exercises"]
    mean: float | None = found["mean"]
    return mean


def in_words(exercise: ClassExercise) -> float | None:
    found = re.search(r", mean (\d+)", class_text(ClassDebrief("class", (exercise,))))
    return float(found[1]) if found else None


def on_the_page(exercise: ClassExercise) -> float | None:
    page = render_class(ClassDebrief("class", (exercise,)))
    found = re.search(r"The mean of the marks is (\d+)\.", page)
    return float(found[1]) if found else None


TOLD: Final = (in_figures, in_words, on_the_page)


@pytest.mark.parametrize("told", TOLD)
def test_practice_and_boats_without_marks_change_no_mean_of_a_class(
    told: Callable[[ClassExercise], float | None],
) -> None:
    assert told(sailed(*COUNTED, *BESIDE)) == told(sailed(*COUNTED)) == 45.0
    assert told(sailed(*BESIDE)) is None


def test_each_boats_own_marks_are_told_with_whether_they_count() -> None:
    exercise = sailed(*COUNTED, *BESIDE)
    (found,) = class_figures(ClassDebrief("class", (exercise,)))["exercises"]

    told = [(each["boat"], each["marks"], each["counts"]) for each in found["boats"]]
    assert told == [(1, 40.0, True), (2, 50.0, True), (3, 100.0, False), (4, None, True)]
    assert class_text(ClassDebrief("class", (exercise,))).count("(practice or free)") == 1


def test_practice_changes_no_mean_of_a_trainee() -> None:
    def listed(total: float | None, *, counts: bool) -> ListedRecording:
        came = replace(RESULT, total=total, counts=counts)
        return replace(LISTED, came=came)

    counted = [listed(40.0, counts=True), listed(50.0, counts=True)]
    (known,) = trainee_history([*counted, listed(100.0, counts=False), listed(None, counts=True)])

    assert known.mean == 45.0
    assert known.attempts == 4

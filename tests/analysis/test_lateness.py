"""Late is told from prompt: ladders of lateness in the shipped exercises, and what is urgent."""

import functools

import pytest
from helpers.lanes import sample_cases
from helpers.rehearsed import flown

from trainer.authoring.exercise_page import plan_exercise
from trainer.authoring.lateness import (
    LATENESS_S,
    MAX_URGENT_MARKS,
    URGENT_LATE_S,
    Ladder,
    fly_ladders,
    is_urgent,
)
from trainer.config.files import shipped_names
from trainer.debrief.marks.judgement import judge_run

NAMES = shipped_names("exercises")
URGENT = (
    *("air-bank-failure", "flooding-aft", "grounding-forward", "rise-jam-shallow"),
    "steering-jam",
    *("stern-plane-jam", "stern-servo", "watch"),
)
# In these the boat itself changes so fast, as docs/validation.md tells.
STEEP_BOATS = (
    *("depth-gauge-failure", "emergency-deep", "rise-jam-shallow", "steering-jam"),
    *("stern-plane-jam", "stern-servo"),
)
ROUGH_SEAS = ("depth-gauge-failure", "emergency-deep")  # later is not always worse there


@functools.cache
def ladders_of(name: str) -> tuple[Ladder, ...]:
    nobody = flown(name).nobody_marks
    plan = flown(name).plan
    return fly_ladders(plan, lambda flight: judge_run(flight.trajectory, plan, nobody))


def test_holes_and_jams_are_urgent() -> None:
    assert tuple(name for name in sorted(NAMES) if is_urgent(plan_exercise(name))) == URGENT


@pytest.mark.long
@pytest.mark.parametrize("name", URGENT)
def test_forty_seconds_late_is_not_won_where_a_hole_or_a_jam_is_open(name: str) -> None:
    for ladder in ladders_of(name):
        assert ladder.at(URGENT_LATE_S) <= MAX_URGENT_MARKS, ladder.kind


@pytest.mark.long
@pytest.mark.parametrize("name", sample_cases(NAMES, *STEEP_BOATS, "canyon", "backing"))
def test_five_seconds_cost_15_marks_at_most_but_where_the_boat_changes_so_fast(name: str) -> None:
    falls = [each for ladder in ladders_of(name) for each in ladder.falls]
    assert bool(falls) == (name in STEEP_BOATS), falls


@pytest.mark.long
@pytest.mark.parametrize("name", sample_cases(NAMES, "canyon", "watch"))
def test_who_is_later_has_not_more_marks(name: str) -> None:
    if name not in ROUGH_SEAS:
        assert not [each for ladder in ladders_of(name) for each in ladder.rises]


def test_a_steep_fall_is_told_with_what_did_it() -> None:
    (falls,) = (each.falls for each in ladders_of("stern-plane-jam")[:1])
    assert (
        "each step late, 10 and 15 s: 84, then 48 marks: Greatest depth 147 m, then 159 m" in falls
    )
    assert len(ladders_of("stern-plane-jam")[0].marks) == len(LATENESS_S)

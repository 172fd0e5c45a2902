"""The shipped exercises flown by nobody and by their reference crews, once for all tests."""

import functools

from trainer.authoring.exercise_page import FlownExercise, fly_at
from trainer.boat.reference_crew import CrewReaction
from trainer.config.exercise.reference_crew import Crew
from trainer.debrief.marks.judgement import judge_run
from trainer.debrief.marks.rehearsal import fly_rehearsal
from trainer.debrief.marks.scoring import Scorecard


@functools.cache
def flown(name: str) -> FlownExercise:
    """Return the flights of an exercise at its own seed."""
    return fly_at(name)


def marks_of(name: str, crew: Crew, reaction: CrewReaction | None = None) -> Scorecard:
    """Return the marks of another crew in an exercise."""
    plan = flown(name).plan
    return judge_run(fly_rehearsal(plan, crew, reaction).trajectory, plan, flown(name).nobody_marks)

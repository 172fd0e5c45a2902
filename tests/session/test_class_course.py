"""A session of a class with a course: what ``next`` begins there, and what is missing to it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from helpers.crewed import Begin, Crewed

from trainer.config.exercise.class_course import ClassCourse, CourseRow
from trainer.config.files import ConfigError
from trainer.session.past.options import RunOptions
from trainer.session.people.briefing import Briefing, in_words
from trainer.session.run import course_of, following_options
from trainer.session.stations.roles import TRAINEE_ROLE

OWN = Path(__file__).parents[2] / "configs/exercises/backing.toml"
ROWS = (
    CourseRow(exercise="first-depth-change", reach=42.5),
    CourseRow(exercise=str(OWN)),
    CourseRow(exercise="steady-course", reach=10.0),
)


def at_end(crewed: Begin, exercise: str, rows: Sequence[CourseRow] = ROWS) -> Crewed:
    """Return a session whose exercise of a course is over, and judged with 42 marks."""
    ship = crewed(seconds=5.0)
    ship.allow_next()
    training = ship.conduct.training
    terms = replace(training.terms, exercise=exercise, course=ClassCourse(tuple(rows)))
    training.terms = ship.conduct.terms = terms
    return ship


def judged(ship: Crewed) -> None:
    """Fly to the end of the exercise, and wait for its marks."""
    ship.fly(60)
    ship.settle(lambda: ship.conduct.marks.found is not None)


def test_next_is_refused_with_what_is_missing_until_an_instructor_lets_go_on(
    crewed: Begin,
) -> None:
    ship = at_end(crewed, "first-depth-change")
    trainee = ship.comes("trainee")
    assert "is not over" in ship.refused("next course")
    judged(ship)

    assert "42 of 42.5 marks" in ship.refused("next course")
    ok, told = ship.say(trainee, "next")
    assert (ok, told.partition(":")[0]) == ("no", "42.5 marks not reached")
    ship.order("release marks")
    assert ship.say(trainee, "next")[1].startswith("42 of 42.5 marks: again")
    assert "next in the course is backing" in ship.say(trainee, "next depth-changes")[1]
    assert not ship.session.control.ended

    ship.order("next backing")  # the instructor's word lets go on, by the path of the row
    assert ship.session.control.following == str(OWN)


@pytest.mark.parametrize(
    ("exercise", "follows"), [("backing", "steady-course"), ("depth-changes", "first-depth-change")]
)
def test_each_goes_on_by_the_order_of_the_course(
    crewed: Begin, exercise: str, follows: str
) -> None:
    ship = at_end(crewed, exercise)
    trainee = ship.comes("trainee")
    judged(ship)

    assert ship.say(trainee, "next") == ("ok", "next: the one after this in the course")
    assert ship.session.control.following == follows


def test_marks_that_are_reached_let_go_on_and_after_the_last_nothing_follows(
    crewed: Begin,
) -> None:
    rows = (replace(ROWS[0], reach=42.0), *ROWS[1:])
    ship = at_end(crewed, "first-depth-change", rows)
    judged(ship)
    ship.order("next course")
    assert ship.session.control.following == str(OWN)

    last = at_end(crewed, "steady-course")
    judged(last)
    assert "last of the course" in last.refused("next course")


def test_marks_that_are_not_made_yet_are_waited_for(crewed: Begin) -> None:
    ship = at_end(crewed, "first-depth-change")
    judged(ship)
    ship.conduct.marks.found = None

    assert "being made" in ship.refused("next course")


def test_who_trains_goes_on_between_two_runs_though_an_instructor_is_there(crewed: Begin) -> None:
    ship = at_end(crewed, "backing")
    trainee = ship.comes("trainee")
    assert ship.say(trainee, "run")[0] == "ok"
    ship.fly(3)
    for words in ("freeze", "run", "again", "next"):  # a run is under way
        assert ship.say(trainee, words)[1].startswith("an instructor is here")
    judged(ship)
    assert ship.say(trainee, "end exercise")[0] == "no"
    assert ship.say(trainee, "again")[0] == "ok"
    assert ship.session.time.frozen
    assert ship.say(trainee, "run")[0] == "ok"


def test_without_a_course_there_is_none_to_go_on_in(crewed: Begin) -> None:
    ship = at_end(crewed, "first-depth-change", ())
    judged(ship)

    assert "no class with a course" in ship.refused("next course")


def test_a_boat_keeps_its_seed_through_a_course_and_else_the_exercise_has_its_own() -> None:
    given = frozenset({"seed", "step"})
    begun = RunOptions(exercise="backing", seed=7, step=0.25, given=given, course=Path("c.toml"))

    after = following_options(begun, "steady-course")
    assert (after.seed, after.given, after.step) == (7, frozenset({"seed"}), None)
    alone = following_options(replace(begun, course=None), "steady-course")
    assert (alone.seed, alone.given) == (1, frozenset())


def test_whoever_comes_is_told_the_place_in_the_course() -> None:
    course = ClassCourse(ROWS)
    assert [course.told(name) for name in ("first-depth-change", "backing", "watch")] == [
        "1,3,42.5",
        "2,3,",
        "",
    ]
    briefing = Briefing(title="Back", course=course.told("first-depth-change"))
    facts = dict(briefing.facts(TRAINEE_ROLE, 0.0))

    assert facts["course"] == "1,3,42.5"
    assert "of the course: 1 of 3, 42.5 marks to go on" in in_words(facts.items())


def test_a_class_file_without_a_course_is_refused_as_one(tmp_path: Path) -> None:
    path = tmp_path / "tuesday.toml"
    path.write_text('exercise = "backing"\nboats = 1\n', encoding="utf-8")

    with pytest.raises(ConfigError, match="no rows"):
        course_of(RunOptions(course=path))

"""Whose the marks of a task are: a station's and its person's, the crew's, or nobody's."""

from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import pytest
from helpers.givers import journalled
from helpers.passages import alert, trajectory
from helpers.recorded import record

from trainer.config.exercise.derived import ALL_QUANTITIES
from trainer.config.exercise.exercise import parse_exercise
from trainer.config.exercise.score_rules import SCORE_MEASURES, ScoreRule
from trainer.debrief.marks.scoring import score_rules
from trainer.debrief.marks.station_marks import TaskMarks, attribute_marks, marks_of_person
from trainer.debrief.page.data import debrief_figures
from trainer.debrief.page.page import as_text, read_dossier, render
from trainer.debrief.passage.controls import MOVING_AXES
from trainer.debrief.passage.watches import Watch
from trainer.io.recording.facts import CrewFact, CrewNews

EXERCISE: Final = 'schema = "exercise/1"\nname = "Drill"\nbriefing = "Steer."\n'
TASKS: Final = """
[[scores]]
name = "Course"
measure = "final"
quantity = "course_deg"
target = 0
full = 0
zero = 10
[[scores]]
name = "Depth"
measure = "final"
quantity = "depth"
target = 0
full = 0
zero = 10
from_s = 10
weight = 3
"""
ORDERS: Final = {
    4: ("helm", "rudder left 5"),
    6: ("planes", "stern planes dive 5"),
    30: ("helm", "rudder amidships"),
    40: ("planes", "stern planes zero"),
}


def rules(text: str) -> tuple[ScoreRule, ...]:
    return parse_exercise(EXERCISE + text, Path("drill.toml")).scores


def told(
    orders: dict[int, tuple[str, str]], watches: tuple[Watch, ...] = (), text: str = TASKS
) -> dict[str, TaskMarks]:
    """Return whose each task is, after orders by their ticks of 0.5 s, in a passage of 60."""
    given = [
        journalled(n, tick, who, said)
        for n, (tick, (who, said)) in enumerate(sorted(orders.items()), start=1)
    ]
    flown: Any = trajectory(orders=given, z=[5.0] * 60)
    found = attribute_marks(flown, score_rules(flown, rules(text)), watches)
    return {each.name: each for each in found}


def whose(orders: dict[int, tuple[str, str]], *watches: Watch) -> tuple[str, str]:
    """Return in words whose the course is, and whose the depth."""
    found = told(orders, watches)
    return found["Course"].whose, found["Depth"].whose


def test_a_task_is_of_the_station_that_alone_worked_its_axis() -> None:
    found = told(ORDERS)
    assert whose(ORDERS) == ("helm", "planes")
    assert found["Course"].able == ("helm", "pilot")
    assert found["Depth"].able == ("planes", "pilot", "ballast", "diving")
    assert [round(each.marks) for each in found.values()] == [100, 50]


def test_planes_that_are_taken_over_in_the_time_of_a_task_are_shared() -> None:
    shared = {**ORDERS, 35: ("pilot", "have planes")}
    assert whose(shared) == ("helm", "the crew's: planes and pilot")
    assert told(shared)["Depth"].own is None
    before = {**ORDERS, 10: ("pilot", "have planes"), 40: ("pilot", "stern planes zero")}
    assert whose(before) == ("helm", "pilot")  # it had them as the time of the task began


def test_water_that_another_station_moves_shares_the_depth_and_not_the_course() -> None:
    pumped = {**ORDERS, 50: ("ballast", "pump depth-control 1")}
    assert whose(pumped) == ("helm", "the crew's: planes and ballast")
    assert whose({**ORDERS, 50: ("diving", "blow all")})[1] == "the crew's: planes and diving"
    early = {**ORDERS, 10: ("ballast", "pump depth-control 1")}
    assert whose(early) == ("helm", "planes")


def test_a_lone_trainee_has_all_marks_also_of_what_he_left_alone() -> None:
    lone = {4: ("trainee", "rudder left 5"), 6: ("trainee", "stern planes dive 5")}
    assert whose(lone) == ("trainee", "trainee")
    assert whose({4: ("trainee", "rudder left 5")}) == ("trainee", "trainee")
    assert whose({4: ("helm", "rudder left 5"), 6: ("ballast", "pump depth-control 1")})[1] == (
        "nobody's: nobody worked it"
    )


def test_a_relief_within_a_task_splits_it_by_name() -> None:
    stood = (Watch("helm", "Ann", 1, 20), Watch("helm", "Bo", 20), Watch("planes", "Cy", 2))
    assert whose(ORDERS, *stood) == ("helm (Ann, then Bo)", "planes (Cy)")
    found = told(ORDERS, stood)
    assert (found["Course"].person, found["Depth"].person) == ("", "Cy")
    assert marks_of_person(found.values(), "cy") == pytest.approx(50.0)
    assert marks_of_person(found.values(), "Ann") is None
    late = whose(ORDERS, Watch("helm", "Bo", 15))[0]
    assert late == "helm (not named, then Bo)"


def test_what_an_instructor_worked_is_nobody_s_mark() -> None:
    meddled = {**ORDERS, 35: ("instructor", "stern planes rise 10")}
    assert whose(meddled) == ("helm", "nobody's: planes and instructor had it")
    assert not told(meddled)["Depth"].crewed


def test_what_an_automatic_held_by_order_is_no_station_s_own() -> None:
    given_up = {6: ("planes", "planes auto"), 4: ("helm", "rudder left 5")}
    assert whose(given_up) == ("helm", "nobody's: the autopilot had it")
    later = {**ORDERS, 50: ("planes", "planes auto")}
    assert whose(later)[1] == "the crew's: planes and the autopilot"
    scheduled = {**ORDERS, 0: ("schedule", "planes manual")}
    assert whose(scheduled) == ("helm", "planes")


def test_the_officer_of_the_deck_shares_the_course_that_he_orders_anew() -> None:
    heard = [
        journalled(1, 4, "helm", "rudder left 5"),
        journalled(2, 20, "deck", "order course 045", "noted"),
        journalled(3, 30, "planes", "stern planes zero"),
    ]
    heard[1] = type(heard[1])(
        *(2, 1, 20, heard[1].giver, heard[1].text, None, True, ""),
        CrewFact(CrewNews.ORDERED, "course 045"),
    )
    flown = trajectory(orders=heard, z=[5.0] * 60)
    course, depth = attribute_marks(flown, score_rules(flown, rules(TASKS)), ())
    assert (course.whose, depth.whose) == ("the crew's: helm and deck", "planes")


def test_an_answer_to_a_casualty_is_of_who_gave_it() -> None:
    text = (
        "[[casualties]]\nname = 'stern-stuck'\nat_s = 5\n"
        "[[scores]]\nname = 'Answer'\nmeasure = 'response'\ncasualty = 'stern-stuck'\n"
        "full = 5\nzero = 60\n"
    )
    given = [
        journalled(1, 4, "planes", "stern planes dive 5"),
        journalled(2, 20, "helm", "bell astern full"),
        journalled(3, 25, "planes", "bow planes rise 5"),
    ]
    flown = trajectory(orders=given, jam=[0.0] * 11 + [1.0] * 49)
    (answer,) = attribute_marks(flown, score_rules(flown, rules(text)), ())
    assert answer.whose == "helm"


def test_each_quantity_and_each_measure_has_the_axes_that_move_it() -> None:
    alone = {name for name, each in SCORE_MEASURES.items() if "quantity" not in each.needs}
    assert MOVING_AXES.keys() == ALL_QUANTITIES.keys() | alone


def test_a_debrief_tells_whose_the_marks_are_where_a_watch_was_named(tmp_path: Path) -> None:
    said = [(1.0, "relief Ott"), (2.0, "stern planes dive 5"), (9.0, "stern planes zero")]
    path = record(tmp_path / "depth.trainer", "first-depth-change", said, duration=60.0)
    debrief = read_dossier(path, None)
    first = debrief_figures(debrief)["task_marks"][0]
    assert (first["station"], first["person"]) == ("planes", "")
    assert first["whose"] == "planes (not named, then Ott)"
    assert "planes (not named, then Ott)" in render(debrief)
    assert f"{first['name']}: {first['marks']:.0f}, {first['whose']}" in as_text(debrief)
    silent = record(tmp_path / "alone.trainer", "first-depth-change", said[1:], duration=20.0)
    assert "Whose the marks are" not in render(read_dossier(silent, None))


def test_an_answer_to_an_alert_is_of_who_acknowledged_it() -> None:
    text = "[[scores]]\nname = 'Seen'\nmeasure = 'alert-response'\nfull = 5\nzero = 20\n"
    orders = [journalled(1, 4, "planes", "stern planes dive 5")]
    flown = replace(trajectory(orders=orders, z=[5.0] * 60), alerts=(alert(6, 12, "ballast"),))
    (seen,) = attribute_marks(flown, score_rules(flown, rules(text)), ())
    assert seen.whose == "ballast"

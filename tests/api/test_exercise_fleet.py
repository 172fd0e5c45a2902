"""Many boats in an exercise by numbers: what they earn from step to step is the debrief's mark."""

from functools import cache

import numpy as np
import pytest

import trainer
from trainer.api.exercise_fleet import SIGHT_NAMES, drill_of, start_of
from trainer.boat.due_orders import entries_due
from trainer.boat.effects import Effect, numbered_orders
from trainer.config.files import shipped_names
from trainer.core.kernel import Numbers
from trainer.debrief.marks.judgement import judge_run
from trainer.debrief.marks.rehearsal import ByReference, Flight
from trainer.debrief.ticks.judge import nobody_aboard
from trainer.units import KNOT

LIKENESS = 1e-9  # [%]
FLOWN = (
    "backing", "bottoming", "canyon", "course-changes", "crash-stop", "crossing-traffic",
    "depth-changes", "emergency-deep", "first-depth-change", "heavy-boat", "hover-by-pump",
    "ordered-bubble", "periscope-approach", "periscope-depth", "periscope-sea-3", "steady-course",
    "surface-and-steer", "visitor-dive",
)  # fmt: skip


@cache
def fleet_of(name: str, count: int) -> trainer.ExerciseFleet:
    return trainer.ExerciseFleet(name, count)


def fly_drawn(fleet: trainer.ExerciseFleet, draws: list[int]) -> tuple[Numbers, Numbers]:
    """Return the actions of boats that steer by what they see, and what each earned."""
    random = np.random.default_rng(7)
    shape = (fleet.count, len(fleet.controls), len(SIGHT_NAMES))
    weights = random.choice((0.02, 0.1, 0.3), (fleet.count, 1, 1)) * random.standard_normal(shape)
    weights[0] = 0.0
    weights[0, :, SIGHT_NAMES.index("depth less ordered")] = 0.5  # one that goes the right way
    weights[0, :, SIGHT_NAMES.index("theta")] = -0.5
    actions: list[Numbers] = []
    seen, earned = fleet.reset(draws=draws), np.zeros(fleet.count)
    for _ in range(fleet.steps):
        marks = fleet.marks.copy() if actions else np.zeros(fleet.count)
        actions.append(np.einsum("bcs,bs->bc", weights, seen))
        seen = fleet.step(actions[-1])
        earned += fleet.marks - marks
    return np.array(actions), earned


def marks_by_debrief(fleet: trainer.ExerciseFleet, actions: Numbers, draw: int) -> float:
    """Return the debrief's mark of one boat's flight, its numbers written one by one."""
    drill, plan = fleet.drill, fleet.plan_of(draw)
    boat = plan.launch_boat()
    flight, known = Flight(plan, boat, ByReference()), numbered_orders(boat)
    entries = entries_due(boat, plan.schedule)
    for step, action in enumerate(actions):
        tick = step * drill.ticks
        flight.give_scheduled(entries.get(tick, ()))
        for name, value in zip(drill.controls, drill.values(action).tolist(), strict=True):
            Effect(name, known[name].writes, "").write(boat, value)
        if not flight.fly_to(tick + drill.ticks):
            break
    return judge_run(flight.rehearsal().trajectory, plan, nobody_aboard(plan)).total or 0.0


def fly_and_compare(name: str, count: int) -> set[float]:
    """Return the marks of drawn flights, each that of the debrief, also where a flight is lost."""
    fleet, draws = fleet_of(name, count), list(range(count))
    actions, earned = fly_drawn(fleet, draws)
    sound = np.flatnonzero(fleet._fleet.status == 0).tolist()  # noqa: SLF001  to the last tick
    for index in sound:
        steps = int(fleet._at[index]) // fleet.drill.ticks  # noqa: SLF001  when it was over
        theirs = marks_by_debrief(fleet, actions[:steps, index], draws[index])
        assert earned[index] == pytest.approx(theirs, abs=LIKENESS), index
    assert sound
    assert fleet.over.all()
    return set(earned.round(6).tolist())


def test_what_boats_earn_from_step_to_step_is_the_debrief_s_mark() -> None:
    assert len(fly_and_compare("first-depth-change", 4)) > 1


@pytest.mark.slow
@pytest.mark.parametrize("name", FLOWN)
def test_twenty_flights_by_numbers_earn_the_debrief_s_marks(name: str) -> None:
    fly_and_compare(name, 20)


def test_a_look_out_marks_ships_in_words_and_alone_is_paid_for_it() -> None:
    fleet = fleet_of("crossing-traffic", 2)
    fleet.reset()
    rudder = np.zeros((2, 1))
    for _ in range(3):
        fleet.step(rudder)
    fleet.order(1, "scope raise")
    for _ in range(3):
        fleet.step(rudder)
    before = fleet.marks.copy()
    for bearing in ("064", "332", "309"):
        fleet.order(1, f"mark contact {bearing}")

    fleet.step(rudder)

    assert fleet.marks[1] > before[1] + 5.0
    assert fleet.marks[0] == before[0]
    with pytest.raises(trainer.TrainerError, match="'rudder left 5': a look-out takes scope raise"):
        fleet.order(1, "rudder left 5")


def test_a_boat_that_begins_anew_leaves_the_others_as_they_are() -> None:
    fleet = fleet_of("first-depth-change", 4)
    fleet.reset()
    for _ in range(50):
        before = fleet.step(np.full((4, 2), 0.02))

    after = fleet.reset(np.array([False, True, False, False]), [5])

    others = [0, 2, 3]
    assert np.array_equal(before[others], after[others])
    assert after[1, SIGHT_NAMES.index("time left")] == pytest.approx(600.0 / 120.0)
    assert fleet.begun.tolist() == [True, False, True, True]


def test_one_is_the_limit_of_a_control_and_right_rise_and_ahead_are_positive() -> None:
    boat = drill_of("emergency-deep"), drill_of("heavy-boat")
    planes = np.radians(30.0)

    assert boat[0].controls == ("stern", "bow", "turns")
    full = boat[0].values([[1.0, -1.0, 2.0], [0.5, -0.5, -1.0]])
    assert full == pytest.approx(
        np.array([[planes, -planes, 20.0 * KNOT], [planes / 2, -planes / 2, -8.0 * KNOT]])
    )
    assert boat[1].values([0.3, -0.2]).tolist() == [3000.0, -2000.0]


def test_the_same_draw_is_the_same_sea_and_another_is_not() -> None:
    starts = [start_of("emergency-deep", draw) for draw in (3, 3, 4)]

    assert np.array_equal(starts[0].whole, starts[1].whole)
    assert not np.array_equal(starts[0].whole, starts[2].whole)
    assert start_of("first-depth-change", 3) is start_of("first-depth-change", 4)


def test_a_number_that_is_none_moves_no_boat() -> None:
    fleet = fleet_of("first-depth-change", 4)
    before = fleet.reset()
    actions = np.zeros((4, 2))
    actions[2, 1] = np.nan

    with pytest.raises(trainer.TrainerError, match="boat 2: bow must be"):
        fleet.step(actions)

    assert np.array_equal(before, fleet.reset(np.zeros(4, bool)))
    assert not fleet.begun.any()


@pytest.mark.parametrize(
    ("name", "step", "why"),
    [
        ("watch", None, "an answer is an order in words"),
        ("gyro-stuck", None, "its casualties deceive the gauges"),
        ("first-depth-change", 7.0, "a step of 7 s has an order, or the end, within it at 60 s"),
        ("first-depth-change", 0.7, "a step of 0.7 s is no whole number of ticks"),
        ("first-deep-change", None, "nearest is first-depth-change"),
    ],
)
def test_an_exercise_that_numbers_cannot_fly_says_why(
    name: str, step: float | None, why: str
) -> None:
    with pytest.raises(trainer.TrainerError, match=why):
        trainer.ExerciseFleet(name, 1, step_s=step)


@pytest.mark.slow
def test_every_shipped_exercise_is_flown_or_refused_as_the_page_says() -> None:
    flown = []
    for name in shipped_names("exercises"):
        try:
            drill_of(name)
        except trainer.TrainerError:
            continue
        flown.append(name)

    assert tuple(flown) == FLOWN

"""Whether marks order skill: graded crews, silly crews, and what is made of their marks."""

import json
import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from trainer.authoring import validation
from trainer.authoring.exercise_page import plan_exercise
from trainer.authoring.lateness import LATE_KINDS, LATENESS_S, Ladder
from trainer.authoring.trainees import (
    ALL_CREWS,
    GRADED_CREWS,
    SILLY_POLICIES,
    Moment,
    SillyPolicy,
    Skill,
    Trainee,
    coarse_order,
    make_harsh,
    silly_orders,
)
from trainer.authoring.validation import (
    LEAST_CORRELATION,
    SeedTrial,
    Validation,
    fly_silly,
    fly_skilled,
    fly_trial,
    rank_correlation,
    swapped_share,
    trial_seeds,
    validation_of,
)
from trainer.boat.reference_crew import CrewReaction
from trainer.cli.main import cli
from trainer.config.files import shipped_names
from trainer.debrief.marks.rehearsal import Rehearsal, fly_rehearsal
from trainer.debrief.passage.controls import opposite_order
from trainer.io.orders.grammar import Order, parse

DRILL = "stern-plane-jam"
IDEAL = (100.0, 80.0, 60.0, 40.0, 20.0)  # [%] of the grades


@cache
def flown_by(skill: Skill, name: str = DRILL, seed: int = 2) -> Rehearsal:
    return fly_skilled(plan_exercise(name), skill, seed)


def given(flight: Rehearsal) -> list[tuple[int, str]]:
    """Return the ticks and orders of the crew."""
    orders = flight.trajectory.orders
    return [(each.tick, each.text) for each in orders if each.entry is None]


def found(
    grades: tuple[float, ...] = IDEAL, silly: float = 20.0, nobody: float = 0.0
) -> Validation:
    """Return the validation of made-up marks, the same at two seeds."""
    marks = dict(zip((each.name for each in GRADED_CREWS), grades, strict=True))
    skilled = {each.name: marks.get(each.name, 50.0) for each in ALL_CREWS}
    others = {each.name: silly for each in SILLY_POLICIES[1:]}
    trial = partial(
        SeedTrial, DRILL, skilled=skilled, silly={SILLY_POLICIES[0].name: nobody, **others}
    )
    return validation_of([trial(seed=1), trial(seed=2)])


def typed(*words: str) -> Result:
    return CliRunner().invoke(cli, ["exercise", "validate", *words])


# What is made of marks


@pytest.mark.parametrize("seed", range(5))
def test_the_rank_correlation_is_spearman_s_with_ties(seed: int) -> None:
    rows = np.random.default_rng(seed).integers(0, 6, (2, 40)).astype(float)
    from scipy import stats  # noqa: PLC0415  half a second of every collection

    expected = stats.spearmanr(*rows).statistic
    assert rank_correlation(list(rows[0]), list(rows[1])) == pytest.approx(expected, abs=1e-12)


def test_marks_that_are_all_alike_order_nothing() -> None:
    assert rank_correlation([0.0, 1.0, 2.0], [7.0, 7.0, 7.0]) == 0.0


def test_marks_that_differ_in_their_last_bits_are_a_tie() -> None:
    trial = fly_trial("first-depth-change", 1, with_silly=False)

    # its hands and its delays are the reference crew's, but for a sum in another order
    assert trial.skilled["good"] == trial.skilled["reference crew"]


def test_neighbours_are_swapped_where_the_worse_crew_has_more() -> None:
    assert swapped_share([[3.0, 3.0], [3.0, 4.0], [1.0, 1.0]]) == pytest.approx(2.0 / 8.0)


@pytest.mark.parametrize(
    ("made_up", "fault"),
    [
        (found(), None),
        (found((100.0, 60.0, 80.0, 20.0, 40.0)), "rank correlation 0.80, not 0.9"),
        (found(silly=41.0), "run away has 41 marks, not 40 at most"),
        (found(nobody=1.0), "nobody aboard has 1 marks, not 0"),
        (found((96.0, 80.0, 60.0, 40.0, 20.0)), "the reference crew has 96 marks, not 97"),
    ],
)
def test_a_verdict_names_what_is_wrong_with_the_marks(
    made_up: Validation, fault: str | None
) -> None:
    assert made_up.faults == ((fault,) if fault else ())


def test_a_late_crew_has_60_marks_at_most_where_a_hole_or_a_jam_is_open() -> None:
    def judged(marks: float) -> Validation:
        ladder = Ladder("late to begin", (marks,) * len(LATENESS_S), (), ())
        return replace(found(), ladders=(ladder,), urgent=True)

    fault = "late to begin by 40 s, 61 marks are left, not 60 at most"
    assert judged(61.0).faults == (fault,)
    assert judged(60.0).faults == ()
    assert replace(judged(61.0), urgent=False).faults == ()


# The crews


def test_a_late_crew_answers_by_so_much_later() -> None:
    first = [given(flown_by(skill))[0] for skill in (Skill("quick"), Skill("late", late_s=10.0))]
    (quick, order), (late, same) = first
    assert order == same == "bell astern full"
    assert 16 <= late - quick <= 24  # 10 s in ticks of 0.5 s, spread by a fifth


def test_a_forgetful_crew_gives_four_orders_in_five() -> None:
    forgetful = flown_by(Skill("forgetful", forgets=5), "course-changes")
    plan = plan_exercise("course-changes")
    other = flown_by(Skill("other", forgets=5), "course-changes", 3)
    assert given(forgetful)[:3] != given(other)[:3]
    assert len(given(forgetful)) < len(given(fly_rehearsal(plan, plan.crew)))


def test_a_crew_that_goes_the_wrong_way_puts_it_right_after_so_long() -> None:
    orders = given(flown_by(Skill("wrong", wrong_s=10.0)))
    wrong, right = ("bow planes dive 30", "bow planes rise 30")
    ticks = {text: tick for tick, text in reversed(orders)}
    assert ticks[right] - ticks[wrong] == 20


def test_a_hand_that_goes_the_wrong_way_goes_on_so_until_it_is_put_right() -> None:
    orders = given(flown_by(Skill("wrong", wrong_s=20.0), "steady-course"))
    first = next(tick for tick, text in orders if text.startswith("rudder"))
    early = {text for tick, text in orders if tick < first + 40}
    later = next(text for tick, text in orders if tick >= first + 40)
    assert len(early) > 1  # the hand has looked again
    assert not [text for text in early if text.startswith("rudder right")]
    assert later.startswith("rudder right")


def test_a_crew_late_to_begin_does_what_follows_in_time() -> None:
    def times(skill: Skill) -> list[int]:
        plan = plan_exercise("flooding-aft")
        flight = fly_rehearsal(plan, plan.crew, CrewReaction(20.0), partial(Trainee, skill))
        return [tick for tick, text in given(flight) if text in ("bell ahead full", "drain aft")]

    (begun, follows), (same, late) = times(LATE_KINDS["late to begin"]), times(Skill("each step"))
    assert begun == same
    assert follows - begun == 4  # 2 s after it, in ticks of 0.5 s
    assert late - same == 44


def test_harsh_hands_look_rarely_and_take_no_angle_off_in_time() -> None:
    habits = plan_exercise("steady-course").crew.helmsman
    harsh = make_harsh(habits, 10.0)
    assert (harsh.look_s, harsh.rudder_s) == (10.0, 0.0)
    assert harsh.rudder_per_error == pytest.approx(1.5 * habits.rudder_per_error)
    exact, rough = (
        given(flown_by(skill, "steady-course"))
        for skill in (Skill("exact"), Skill("harsh", look_s=10.0))
    )
    ticks = [tick for tick, _ in rough]
    assert rough != exact
    assert min(b - a for a, b in pairwise(ticks)) >= 20


def test_a_panic_is_taken_back_20_s_later() -> None:
    plan = plan_exercise("flooding-aft")
    panic = next(each for each in SILLY_POLICIES if each.moment is Moment.PANIC)
    orders = [(seconds, order.text) for seconds, order in silly_orders(panic, plan)]
    blown = [seconds for seconds, text in orders if text == "emergency blow"]
    stopped = [seconds for seconds, text in orders if text == "blow stop"]
    assert len(blown) > 1
    assert stopped == [seconds + 20.0 for seconds in blown]


def test_gauges_are_misread_by_a_share_and_not_alike() -> None:
    exact, misread = (
        given(flown_by(skill, "depth-changes"))
        for skill in (Skill("exact"), Skill("misreads", misread_share=0.05))
    )
    assert misread != exact
    assert given(flown_by(Skill("misreads", misread_share=0.0), "depth-changes")) == exact


def test_a_rule_about_a_gauge_is_not_misread() -> None:
    exact, misread = (
        given(flown_by(skill, "bottoming"))
        for skill in (Skill("exact"), Skill("misreads", misread_share=0.05))
    )
    assert misread == exact


def test_hands_in_steps_set_whole_steps() -> None:
    texts = [text for _, text in given(flown_by(Skill("coarse", step_deg=5), "depth-changes"))]
    angles = [int(text.split()[-1]) for text in texts if re.search(r"planes (rise|dive)", text)]
    assert len(angles) > 5
    assert {angle % 5 for angle in angles} == {0}


@pytest.mark.parametrize(
    ("change", "text", "other"),
    [
        (partial(coarse_order, step=5), "rudder left 7", "rudder left 5"),
        (partial(coarse_order, step=5), "rudder left 2", "rudder amidships"),
        (partial(coarse_order, step=5), "stern planes rise 1", "stern planes zero"),
        (partial(coarse_order, step=5), "stern planes zero", "stern planes zero"),
        (opposite_order, "pump trim aft 3", "pump trim forward 3"),
        (opposite_order, "flood depth-control 4", "pump depth-control 4"),
        (opposite_order, "rudder right 10", "rudder left 10"),
        (opposite_order, "bell astern full", "bell ahead full"),
        (opposite_order, "bell stop", "bell stop"),
    ],
)
def test_words_of_orders_are_changed(change: Callable[[str], str], text: str, other: str) -> None:
    assert change(text) == other


# Silly crews


def test_every_order_of_a_silly_crew_is_an_order() -> None:
    texts = {text for each in SILLY_POLICIES for row in each.orders for text in row.split("; ")}
    assert {text for text in texts if not isinstance(parse(text), Order)} == set()
    assert len(SILLY_POLICIES) > 20


def test_a_silly_crew_is_not_given_what_a_station_would_refuse() -> None:
    words = "planes auto; hover on; autopilot on; rudder right 5"
    both = SillyPolicy("both", Moment.BEGIN, (words,))
    by_planes = [order.text for _, order in silly_orders(both, plan_exercise("depth-changes"))]
    by_ballast = [order.text for _, order in silly_orders(both, plan_exercise("heavy-boat"))]
    assert by_planes == ["hover on", "rudder right 5"]
    assert by_ballast == ["planes auto", "rudder right 5"]


def test_a_silly_crew_s_orders_come_after_those_of_the_schedule() -> None:
    plan = plan_exercise(DRILL)
    alone = fly_rehearsal(plan)
    flight = fly_silly(plan, SillyPolicy("blow", Moment.EVENT, ("blow all",)), alone)
    ticks = [tick for tick, _ in given(flight)]
    events = [e.seconds for e in plan.schedule if e.order.name in ("order", "tell", "casualty")]
    assert ticks == [round((seconds + 6.0) / plan.method.step) for seconds in events]
    assert not np.array_equal(flight.trajectory.columns["z"], alone.trajectory.columns["z"])


# The shipped exercises


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped_names("exercises"))
def test_the_marks_of_every_shipped_exercise_order_skill(name: str) -> None:
    rows: list[tuple[int, float]] = []
    for _, seed, _ in trial_seeds(name, 4):
        skilled = fly_trial(name, seed, with_silly=False).skilled
        rows += [(-place, skilled[grade.name]) for place, grade in enumerate(GRADED_CREWS)]
    skills, marks = zip(*rows, strict=True)
    assert rank_correlation(skills, marks) >= LEAST_CORRELATION


# The command


@pytest.mark.slow
def test_the_same_seeds_give_the_same_page(tmp_path: Path) -> None:
    pages = [tmp_path / "one.html", tmp_path / "two.html"]
    words = (DRILL, "--seeds", "1", "--cores", "1", "--html")
    results = [typed(*words, str(page)) for page in pages]
    assert results[0].stdout == results[1].stdout
    assert pages[0].read_bytes() == pages[1].read_bytes()
    assert b"<svg" in pages[0].read_bytes()
    assert max(map(len, results[0].stdout.splitlines())) <= 79


def test_the_exit_code_says_whether_marks_order_skill(monkeypatch: pytest.MonkeyPatch) -> None:
    trials = iter((found(), found(silly=90.0)))
    monkeypatch.setattr(validation, "validate_exercises", lambda *_: iter([next(trials)]))
    good, bad = typed(DRILL), typed(DRILL, "--json")
    assert good.exit_code == 0
    assert "The marks order skill in 1 exercise." in good.stdout
    assert bad.exit_code == 1
    (row,) = json.loads(bad.stdout)["exercises"]
    assert row["faults"] == ["run away has 90 marks, not 40 at most"]


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ('name = "Drill"\nbriefing = "Sail."', "lacks duration_s"),
        ('name = "Drill"\nbriefing = "Sail."\nduration_s = 60', "lacks a reference crew"),
    ],
)
def test_an_exercise_that_cannot_be_validated_is_told(
    tmp_path: Path, line: str, complaint: str
) -> None:
    path = tmp_path / "drill.toml"
    path.write_text(f'schema = "exercise/1"\n{line}\n')
    result = typed(str(path), "--seeds", "1")
    assert complaint in str(result.exception)
    assert path.name in str(result.exception)

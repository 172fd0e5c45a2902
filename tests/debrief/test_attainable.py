"""What could still be earned at each moment of a run, and what cost it."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers.explored import (
    by_crew,
    explored,
    late,
    nobody_of,
    plan_of,
    planted,
    with_nobody_else,
)
from helpers.givers import journalled
from helpers.sessions import start_plan

from trainer.boat.effects import effects_of_boat
from trainer.boat.mute_crew import MuteCrew, is_same_order
from trainer.config.files import shipped_names
from trainer.debrief.attainable.changes import ChangeCause
from trainer.debrief.attainable.curve import AttainableCurve, attainable_curve
from trainer.debrief.attainable.explorer import NoCurve, RunExplorer
from trainer.debrief.attainable.falls import PassedKind, SteepFall, parted_falls, what_passes
from trainer.debrief.attainable.stretches import (
    MAX_TICKS,
    POINT_PERIODS,
    AttainablePoint,
    changed_stretches,
    finest_period,
    without_luck,
)
from trainer.debrief.attainable.words import change_words, until_words
from trainer.debrief.marks.judgement import judge_run
from trainer.debrief.marks.rehearsal import Departure, fly, fly_rehearsal
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.facts import GiverKind
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")
STEP_S = 0.5  # [s] of the boats that fly here
# an order more at a time [s], or one less
PLANTED = (
    ("first-depth-change", 150.0, "blow all", ""),
    ("gyro-stuck", 200.0, "rudder right 20", ""),
    ("gyro-stuck", None, "", "rudder left 10"),
    ("hover-by-pump", 300.0, "flood depth-control 6", ""),
    ("flooding-aft", 320.0, "stern planes dive 20", ""),
    ("depth-changes", 200.0, "stern planes dive 25", ""),
    ("course-changes", 500.0, "rudder left 30", ""),
    ("steady-course", 300.0, "rudder right 20", ""),
    ("air-bank-failure", None, "", "drain centre"),
    ("heavy-boat", 700.0, "flood depth-control 10", ""),
    ("rise-jam-shallow", 250.0, "emergency blow", ""),
    ("loss-of-propulsion", 700.0, "flood depth-control 10", ""),
    ("crash-stop", 600.0, "bell ahead standard", ""),
    ("power-loss", 500.0, "flood depth-control 10", ""),
    ("surface-and-steer", 500.0, "rudder left 30", ""),
    ("stern-plane-jam", None, "", "bell astern full"),
    ("steering-jam", None, "", "bell astern full"),
    ("surface-and-steer", None, "", "surface"),
    ("rise-jam-shallow", None, "", "bow planes dive 30"),
    ("backing", None, "", "hover on"),
)
# an order of the reference crew, and what comes in its place: another one, none, or it later [s]
FAULTS = (
    # the wrong way
    ("backing", "bell astern two-thirds", "bell ahead two-thirds", 0.0),
    ("stern-plane-jam", "bow planes rise 30", "bow planes dive 30", 0.0),
    ("gyro-stuck", "rudder right 10", "rudder left 10", 0.0),
    ("loss-of-propulsion", "pump depth-control 5 t", "flood depth-control 5 t", 0.0),
    ("rise-jam-shallow", "bow planes dive 30", "bow planes rise 30", 0.0),
    # missing
    ("air-bank-failure", "drain centre", None, 0.0),
    ("surface-and-steer", "surface", None, 0.0),
    ("steering-jam", "bell astern full", None, 0.0),
    ("crash-stop", "bell astern full", None, 0.0),
    ("hover-by-pump", "pump depth-control 2 t", None, 0.0),
    # late
    ("stern-plane-jam", "bell astern full", "bell astern full", 15.0),
    ("steering-jam", "bell astern full", "bell astern full", 30.0),
    ("backing", "bell astern two-thirds", "bell astern two-thirds", 60.0),
    ("periscope-depth", "periscope depth", "periscope depth", 60.0),
    ("crash-stop", "bell astern full", "bell astern full", 40.0),
    # too much
    ("heavy-boat", "pump depth-control 8 t", "pump depth-control 20 t", 0.0),
    ("gyro-stuck", "rudder left 10", "rudder left 35", 0.0),
    ("hover-by-pump", "pump depth-control 2 t", "pump depth-control 10 t", 0.0),
    ("bottoming", "flood depth-control 1 t", "flood depth-control 15 t", 0.0),
    ("periscope-depth", "flood depth-control 4 t", "flood depth-control 20 t", 0.0),
)
SHIPPED = shipped_names("exercises")
SPREAD_FACTOR = 4  # times apart are points here; falls between them are halved as finely as else


@pytest.fixture(autouse=True)
def wider_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Look at fewer moments than a user's debrief does."""
    monkeypatch.setattr(
        "trainer.debrief.attainable.curve.POINT_PERIODS", SPREAD_FACTOR * POINT_PERIODS
    )


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "step_s"),
    [
        ("stern-plane-jam", 30),
        *[pytest.param(name, 10, id=f"{name}-all", marks=pytest.mark.slow) for name in SHIPPED],
    ],
)
def test_on_the_reference_crew_s_own_run_nothing_is_ever_lost(name: str, step_s: int) -> None:
    run = explored(name, by_crew(name))
    own = run.judge(run.trajectory).total
    assert own
    lost = {tick / 2.0: run.point(tick).marks for tick in range(0, run.last, 2 * step_s)}
    assert {at: marks for at, marks in lost.items() if abs(marks - own) > 1.0} == {}


@cache
def late_curve(name: str, seconds: float) -> AttainableCurve:
    """Return what could still be earned in that run."""
    return attainable_curve(explored(name, late(name, seconds)))


def sentences(run: RunExplorer) -> list[str]:
    return [change_words(each, run.step) for each in attainable_curve(run).changes]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "seconds", "told"),
    [
        pytest.param(
            "steering-jam",
            40,
            'full" was due at 1:12 and came 40 s late, at 1:52.',
            marks=pytest.mark.slow,
        ),
        ("stern-plane-jam", 15, 'full" was due at 1:11 and came 15 s late, at 1:26.'),
    ],
)
def test_an_order_that_came_late_is_told_with_how_late_it_came(
    name: str, seconds: float, told: str
) -> None:
    said = [change_words(each, STEP_S) for each in late_curve(name, seconds).changes]
    assert told in said[0]
    assert not [each for each in said if "did not come" in each]


def test_the_better_order_is_told_at_each_fall_from_its_moment_on() -> None:
    (first, *others) = late_curve("stern-plane-jam", 15).changes
    assert first.better == ((142, "bell astern full"), (146, "bow planes rise 30"))
    told = 'The reference crew orders "bell astern full" at 1:11 and "bow planes rise 30" at 1:13.'
    assert change_words(first, STEP_S).endswith(told)
    assert all(each.better is not None for each in others if each.marks < 0.0)
    begins = [min(tick for tick, _ in each.better) for each in others if each.better]
    assert all(tick >= each.told_at for tick, each in zip(begins, others, strict=False))


def test_the_work_for_a_curve_does_not_grow_with_the_length_of_the_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """From each point the rest is flown: points lie further apart in a long run, as is told."""
    for last in (1_200, 4_000, 40_000, 200_000):
        finest = finest_period(last, 0.5)
        assert last**2 / (2 * POINT_PERIODS * finest) <= MAX_TICKS
        assert finest == 2 or last > 4_000
    monkeypatch.setattr("trainer.debrief.attainable.stretches.MAX_TICKS", 1_500)
    shares: list[float] = []
    run = explored("stern-plane-jam", late("stern-plane-jam", 15))
    run.progress = shares.append
    shorter = attainable_curve(run)
    flown = range(0, run.last, POINT_PERIODS * run.finest)
    assert sum(run.last - tick for tick in flown) <= 1_500 + run.last
    assert len(run.departures) < 10 * len(flown)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    told = f"a point each {5 * run.finest:g} s, and down to {run.finest / 2:g} s at a change."
    assert until_words(shorter, run.step).endswith(told)
    assert "came 15 s late" in change_words(shorter.changes[0], run.step)
    assert "long" not in until_words(replace(shorter, finest=2), run.step)


def test_points_lie_near_each_other_only_where_somebody_orders_anything(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run = explored("stern-plane-jam", with_nobody_else("stern-plane-jam", 300.0, "blow all"))
    monkeypatch.setattr(
        run, "_point", lambda tick: AttainablePoint(tick, 50.0, won=False, lost=False)
    )
    near = SPREAD_FACTOR * POINT_PERIODS * run.finest

    ticks = [each.tick for each in attainable_curve(run).points]

    gaps = {(before, after): after - before for before, after in pairwise(ticks)}
    assert [gap for (before, after), gap in gaps.items() if before <= 600 < after] == [near]
    assert max(gaps.values()) >= 4 * near


def test_until_when_the_boat_could_be_saved_is_found_to_the_finest_period(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    run = explored("stern-plane-jam", fly_rehearsal(plan_of("stern-plane-jam")))
    last_saved = 30 * run.finest
    points = lambda tick: AttainablePoint(tick, 0.0, won=False, lost=tick > last_saved)  # noqa: E731
    monkeypatch.setattr(run, "_point", points)

    assert attainable_curve(run).until_saved == last_saved


def test_where_the_reference_crew_would_wait_the_debrief_says_so() -> None:
    run = explored("first-depth-change", planted("first-depth-change", 20.0, "blow all"))
    (dearest, *_) = sorted(attainable_curve(run).changes, key=lambda change: change.marks)
    assert dearest.better == ()
    said = change_words(dearest, run.step)
    assert said.endswith("The reference crew orders nothing for 30 s from 0:20 on.")


@pytest.mark.slow
def test_a_fatal_order_is_named_where_without_it_nobody_does_anything() -> None:
    order = "stern planes rise 10"
    said = sentences(
        explored("first-depth-change", with_nobody_else("first-depth-change", 65.0, order))
    )
    assert any(each.startswith(f'1:05: "{order}", by panel, the wrong way') for each in said)


@pytest.mark.slow
def test_planes_that_nobody_touched_were_not_worked_by_anybody() -> None:
    name = "first-depth-change"
    (told,) = sentences(explored(name, fly_rehearsal(plan_of(name))))
    assert "lost; nobody worked the planes from 1:04 on." in told
    touched = sentences(explored(name, with_nobody_else(name, 90.0, "bow planes rise 1")))
    (again,) = [each for each in touched if "nobody worked" in each]
    assert "nobody worked the planes from 5:34 on." in again


@pytest.mark.slow
def test_an_order_of_a_file_is_somebody_s(tmp_path: Path) -> None:
    (tmp_path / "mine.orders").write_text("65 stern planes rise 10\n")
    options = RunOptions(exercise="first-depth-change", orders_file=tmp_path / "mine.orders")
    plan = plan_run(options)
    run = fly_rehearsal(plan)
    judge = partial(judge_run, plan=plan, nobody=nobody_of("first-depth-change"))
    explorer = RunExplorer(plan, run.trajectory, judge)
    explorer.fly_again()
    said = sentences(explorer)
    assert any("by the file of orders, the wrong way" in each for each in said)
    assert not [each for each in said if "nobody worked" in each]


def curve_of(*marks: float) -> tuple[AttainablePoint, ...]:
    """Return points every 10 s with these marks; the step is 0.5 s."""
    return tuple(
        AttainablePoint(20 * place, each, won=each >= 60.0, lost=False)
        for place, each in enumerate(marks)
    )


def found(*marks: float) -> list[tuple[int, int, int]]:
    """Return begin and end [s] and marks of the stretches of a curve."""
    return [
        (each.begin.tick // 2, each.end.tick // 2, round(each.marks))
        for each in changed_stretches(curve_of(*marks), 0.5)
    ]


def test_a_slow_fall_is_told_whole() -> None:
    slow = [100.0 - 0.42 * place for place in range(82)]
    assert found(*[100.0] * 10, *slow) == [(110, 900, -34)]
    assert found(*[100.0 - 0.05 * place for place in range(81)]) == [(0, 800, -4)]


def test_two_falls_with_a_minute_between_them_are_two() -> None:
    assert found(100, 100, *[70] * 9, 30, 30) == [(10, 20, -30), (100, 110, -40)]
    assert found(100, 100, 70, 70, 30, 30) == [(10, 40, -70)]


def test_all_marks_lost_and_won_are_accounted_for() -> None:
    draws = np.random.default_rng(7)
    for _ in range(200):
        marks = np.clip(np.cumsum(draws.normal(0.0, draws.uniform(0.05, 8.0), 90)), -50, 50) + 50
        told = sum(each.marks for each in changed_stretches(curve_of(*marks), 0.5))
        assert abs(told - (marks[-1] - marks[0])) <= 3.0


def test_marks_that_come_back_while_nobody_does_anything_were_never_lost() -> None:
    level = without_luck(curve_of(100, 74, 100, 60, 90, 50), [70])  # at 35 s
    assert [each.marks for each in level] == [100, 100, 100, 60, 90, 50]
    assert [each.tick for each in level] == [0, 20, 40, 60, 80, 100]


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        *(pytest.param(each, marks=pytest.mark.slow) for each in ("canyon", "heavy-boat")),
        "hover-by-pump",
    ],
)
def test_with_nobody_aboard_no_marks_are_won_and_all_are_accounted_for(name: str) -> None:
    curve = attainable_curve(explored(name, fly_rehearsal(plan_of(name))))
    assert [each for each in curve.changes if each.marks > 0.0] == []
    lost = curve.points[0].marks - curve.points[-1].marks
    assert -sum(each.marks for each in curve.changes) == pytest.approx(lost, abs=3.0)


def named(name: str, seconds: float | None, more: str, less: str) -> bool:
    """Return whether a planted order is named within 5 s of its moment."""
    if seconds is None:
        orders = by_crew(name).trajectory.orders
        seconds = next(each.tick / 2.0 for each in orders if each.text == less)
    curve = attainable_curve(explored(name, planted(name, seconds, more, less)))
    causes = (ChangeCause.ORDER, ChangeCause.WRONG_WAY) if more else (ChangeCause.MISSING,)
    return any(
        each.cause in causes
        and each.order == (more or less)
        and each.tick is not None
        and abs(each.tick / 2.0 - seconds) <= 5.0
        for each in curve.changes
    )


@pytest.mark.long
@pytest.mark.parametrize("case", PLANTED[1:3])  # one order more, and one less
def test_a_planted_order_is_named(case: tuple[str, float | None, str, str]) -> None:
    assert named(*case)


@pytest.mark.slow
def test_nine_of_ten_planted_orders_are_named() -> None:
    missed = [case for case in PLANTED if not named(*case)]
    assert len({name for name, *_ in PLANTED}) >= 12
    assert len(missed) <= len(PLANTED) // 10, missed


def is_named(name: str, right: str, wrong: str | None, late: float) -> bool:
    """Return whether the debrief of a crew's fault has its order at its moment, within 5 s."""
    plan = plan_of(name)
    boat = start_plan(plan)
    given = by_crew(name).trajectory.orders
    own = (each for each in given if each.text == right)
    due = next(each for each in own if each.giver.kind is GiverKind.REFERENCE)
    fault = [journalled(9000, due.tick + round(2 * late), "panel", wrong, "")] if wrong else []
    orders: dict[int, list[Any]] = {}
    for entry in (*(each for each in given if each is not due), *fault):
        orders.setdefault(entry.tick, []).append(entry)
    run = explored(name, fly(plan, Departure(0, boat.records.state.copy()), orders)[0])
    return any(
        each.order in (right, wrong) and abs((each.tick or 0) - due.tick) <= 10
        for each in attainable_curve(run).changes
    )


@pytest.mark.slow
def test_nine_of_ten_faults_of_a_crew_are_named_at_their_moments() -> None:
    missed = [fault for fault in FAULTS if not is_named(*fault)]
    assert len({name for name, *_ in FAULTS}) >= 8
    assert len(missed) <= len(FAULTS) // 10, missed


def test_a_run_of_another_core_has_no_curve() -> None:
    flown = by_crew("stern-plane-jam").trajectory
    columns = {**flown.columns, "z": flown.columns["z"] + 1e-12}
    other = replace(by_crew("stern-plane-jam"), trajectory=replace(flown, columns=columns))
    with pytest.raises(NoCurve, match="cannot be flown again to the bit"):
        explored("stern-plane-jam", other)


@pytest.mark.parametrize(
    ("kept", "why"),
    [
        ([*range(40), *range(90, 200)], "no tick was recorded between 19.5 s and 45 s"),
        (range(5, 200), "the record does not begin at the start"),
        ([0], "nothing was flown"),
    ],
)
def test_a_record_that_is_not_whole_has_no_curve_and_says_what_is_missing(
    kept: Sequence[int], why: str
) -> None:
    flown = by_crew("stern-plane-jam").trajectory
    columns = {name: column[kept] for name, column in flown.columns.items()}
    part = replace(flown, ticks=flown.ticks[kept], columns=columns)
    with pytest.raises(NoCurve, match=why):
        explored("stern-plane-jam", replace(by_crew("stern-plane-jam"), trajectory=part))


def test_orders_are_the_same_that_say_the_same_to_the_same_control() -> None:
    first, same, other = map(parse, ("rudder left 10", "rudder left 10 deg", "rudder right 10"))
    assert isinstance(first, Order)
    assert isinstance(same, Order)
    assert isinstance(other, Order)
    assert is_same_order(first, same)
    assert not is_same_order(first, other)


def test_orders_that_move_other_controls_are_never_taken_for_one() -> None:
    effects = effects_of_boat(plan_of("leaking-leg").launch_boat())
    plain = [(parse(each.words), each) for each in effects if each.number is None]
    for (one, first), (other, second) in combinations(plain, 2):
        if isinstance(one, Order) and isinstance(other, Order):
            assert not is_same_order(one, other) or first.writes == second.writes, first.words


UNDONE = (  # an order more, the order it comes for, and until when [s] brute force wins
    ("fire-aft", 130.0, "ventilation run", "", 310),
    ("port-bus-lost", 130.0, "loads back", "", 149),
    ("flooding-aft", 110.0, "bell stop", "", 550),
    ("leaking-leg", 95.0, "bow planes emergency", "stern planes emergency", 285),
)


@pytest.mark.long
@pytest.mark.parametrize(("name", "seconds", "text", "instead", "won_s"), UNDONE)
def test_what_was_undone_or_done_to_the_wrong_surface_can_be_put_right_until_it_is_too_late(
    name: str, seconds: float, text: str, instead: str, won_s: int
) -> None:
    curve = attainable_curve(explored(name, planted(name, seconds, text, instead)))
    assert curve.until_won is not None
    assert abs(curve.until_won * STEP_S - won_s) <= 5.0


def test_only_the_order_that_was_undone_is_given_again() -> None:
    run = explored("fire-aft", planted("fire-aft", 130.0, "ventilation run"))
    assert [each.text for each in run.reference_orders(2 * 150)] == ["ventilation secure"]


def test_where_an_undoing_has_served_by_now_it_is_left_so() -> None:
    run = explored("steering-jam", planted("steering-jam", 84.0, "bell ahead full"))
    own = run.judge(run.trajectory).total
    assert own
    assert all(run.point(tick).marks > own - 1.0 for tick in range(0, run.last, 20))


@pytest.mark.parametrize(
    "name",
    [
        *("stern-servo", "fire-aft"),
        *(pytest.param(name, marks=pytest.mark.slow, id=f"{name}-all") for name in SHIPPED),
    ],
)
def test_the_reference_crew_never_undoes_what_it_has_ordered(name: str) -> None:
    run = explored(name, by_crew(name))
    crews = (each.crew.crew for each in run.departures.values() if each.crew)
    assert not any(each.undone for crew in crews for each in crew.followed)


def test_a_mast_that_nobody_raised_is_not_up_and_its_order_is_overdue() -> None:
    plan = plan_of("crossing-traffic")
    boat = start_plan(plan)
    mute = MuteCrew(boat, plan.crew)
    for _ in range(60):
        mute.follow(())
        assert boat.tick() == 0
    assert "scope raise" in [each.rule.order.text for each in mute.pending(boat.time)]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kind"),
    [
        pytest.param("depth-gauge-failure", PassedKind.LIMIT, marks=pytest.mark.slow),
        ("stern-plane-jam", PassedKind.RULE),
        ("stern-plane-jam", PassedKind.LOSS),
    ],
)
def test_where_marks_fall_within_a_second_the_debrief_says_what_passes(
    name: str, kind: PassedKind
) -> None:
    run = explored(name, fly_rehearsal(plan_of(name)))
    curve = attainable_curve(run)
    told = {fall.kind: fall.text for each in curve.changes for fall in each.falls}
    steep = [
        after.tick
        for before, after in pairwise(curve.points)
        if after.tick - before.tick <= 2 and before.marks - after.marks > 3.0
    ]
    explained = [each for each in curve.changes if each.falls]
    assert steep
    assert all(any(each.begin < tick <= each.end for each in explained) for tick in steep)
    assert kind in told
    assert any(told[kind] in change_words(each, run.step) for each in explained)


def test_no_part_of_a_change_is_told_with_more_marks_than_it_cost() -> None:
    before, after = (SteepFall(tick, 37.0, PassedKind.RULE, "Settled") for tick in (384, 410))
    for own, rest, parts in (
        (-20.0, -64.0, ((), (before,))),
        (-20.0, -80.0, ((), (before, after))),
        (-64.0, -20.0, ((after,), ())),
        (-44.0, -40.0, ((after,), (before,))),
    ):
        assert parted_falls((before, after), 400, own, rest) == parts


def test_a_limit_that_takes_marks_within_a_second_is_what_passes() -> None:
    run = explored("stern-plane-jam", by_crew("stern-plane-jam"))
    before = run.point(0)
    assert before.card
    assert before.card.verdict
    verdict = replace(before.card.verdict, gate="depth 140 m", gate_cap=50.0, cap=50.0)
    after = replace(before, marks=50.0, card=replace(before.card, verdict=verdict))
    assert what_passes(before, after) == (PassedKind.LIMIT, "depth 140 m")


def test_who_takes_over_gives_at_once_what_is_overdue() -> None:
    """The crew has been aboard since the jam: an order at 1:13 still wins, so 1:13 is no loss."""
    run = explored("stern-plane-jam", fly_rehearsal(plan_of("stern-plane-jam")))
    prompt, overdue = run.point(2 * 71), run.point(2 * 73)
    assert overdue.won
    assert prompt.marks - overdue.marks < 10.0
    taken = run.from_moment(2 * 73).trajectory.orders
    first = next(each for each in taken if each.giver.kind is GiverKind.REFERENCE)
    assert (first.text, first.tick) == ("bell astern full", 2 * 73)


@pytest.mark.long
def test_nobody_who_steers_straight_on_loses_a_task_between_two_seconds() -> None:
    curve = attainable_curve(explored("steady-course", fly_rehearsal(plan_of("steady-course"))))
    assert not any(each.falls for each in curve.changes)

"""Blame that is right: which order, which way, how late, and how many marks in the end."""

import re
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest
from helpers.explored import by_crew, explored, late, plan_of, with_nobody_else
from helpers.givers import journalled
from helpers.sessions import start_plan

from trainer.authoring.trainees import Skill
from trainer.authoring.validation import fly_skilled
from trainer.debrief.attainable.changes import (
    ChangeCause,
    MarkChange,
    join_changes,
    net_changes,
)
from trainer.debrief.attainable.curve import AttainableCurve, attainable_curve
from trainer.debrief.attainable.falls import (
    PassedKind,
    SteepFall,
    bound_falls,
    lasting_points,
)
from trainer.debrief.attainable.stretches import POINT_PERIODS, AttainablePoint
from trainer.debrief.attainable.words import change_words
from trainer.debrief.marks.judgement import costs
from trainer.debrief.marks.rehearsal import Departure, Rehearsal, fly, fly_rehearsal
from trainer.debrief.passage.controls import control_of, is_alike, is_wrong_way, share_of
from trainer.debrief.trainees.progress import costs_of

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")
STEP_S = 0.5  # [s] of the boats that fly here


@pytest.fixture(autouse=True)
def wider_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """Look at fewer moments than a user's debrief does."""
    places = "trainer.debrief.attainable.curve.POINT_PERIODS"
    monkeypatch.setattr(places, 4 * POINT_PERIODS)


class Edit(NamedTuple):
    """An order of the reference crew, "" for none, and what comes instead at a time [s]."""

    order: str
    instead: str
    seconds: float


def edited(name: str, *edits: Edit) -> Rehearsal:
    """Return the reference crew's run with some orders given otherwise."""
    left_out = {each.order for each in edits}
    given = [each for each in by_crew(name).trajectory.orders if each.text not in left_out]
    more = [
        journalled(9000 + i, round(each.seconds / STEP_S), "panel", each.instead, "")
        for i, each in enumerate(edits)
    ]
    orders: dict[int, list[Any]] = {}
    for entry in sorted((*given, *more), key=lambda each: each.tick):
        orders.setdefault(entry.tick, []).append(entry)
    boat = start_plan(plan_of(name))
    return fly(plan_of(name), Departure(0, boat.records.state.copy()), orders)[0]


def curve_of(name: str, run: Rehearsal) -> AttainableCurve:
    return attainable_curve(explored(name, run))


@cache
def late_curve(name: str, seconds: float) -> AttainableCurve:
    return curve_of(name, late(name, seconds))


def words_of(curve: AttainableCurve) -> list[str]:
    return [change_words(each, STEP_S) for each in curve.changes]


def costs_by_kind(curve: AttainableCurve) -> dict[str, float]:
    return {kind: marks for kind, marks in costs_of(curve.changes).items() if marks}


FORWARD = Edit("pump trim aft 3 t", "pump trim forward 3 t", 182.5)


@pytest.mark.long
def test_the_order_that_came_late_is_named_and_not_one_that_the_reference_crew_gives_too() -> None:
    curve = late_curve("crash-stop", 45.0)
    assert [each.order for each in curve.changes] == ["bell astern full", "hover on"]
    assert {each.cause for each in curve.changes} == {ChangeCause.MISSING}
    assert '"hover on" was due at 8:52 and came 45 s late, at 9:37.' in words_of(curve)[1]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ordered-bubble", "rise-jam-shallow", "depth-gauge-failure"])
def test_no_order_is_blamed_that_the_reference_crew_gives_at_that_moment(name: str) -> None:
    skill = Skill("faulty", late_s=60.0, misread_share=0.05, wrong_s=10.0)
    for run in (fly_skilled(plan_of(name), skill, 1), late(name, 60.0)):
        curve = curve_of(name, run)
        blamed = [each for each in curve.changes if each.who and each.marks < 0.0]
        soon = [[text for _, text in each.better or ()] for each in blamed]
        assert not [each.order for each, own in zip(blamed, soon, strict=True) if each.order in own]


@pytest.mark.long
def test_an_order_the_wrong_way_is_told_as_that_and_not_as_one_that_did_not_come() -> None:
    curve = curve_of("heavy-boat", edited("heavy-boat", FORWARD))
    (change,) = curve.changes
    assert (change.cause, change.order) == (ChangeCause.WRONG_WAY, "pump trim forward 3 t")
    (told,) = words_of(curve)
    way = 'the wrong way for "pump trim aft 3 t"'
    assert told.startswith(f'3:02: "pump trim forward 3 t", by panel, {way}, cost 64 marks.')
    assert "did not come" not in told
    assert costs_by_kind(curve) == {"wrong way": pytest.approx(64.0, abs=1.0)}


@pytest.mark.long
def test_a_right_order_that_came_too_late_to_be_right_is_late() -> None:
    curve = late_curve("canyon", 60.0)
    assert [each.order for each in curve.changes] == ["course 353", "course 353"]
    assert all("came 60 s late" in each for each in words_of(curve))
    assert list(costs_by_kind(curve)) == ["late"]


@pytest.mark.long
def test_an_order_taken_back_is_told_by_its_net_cost() -> None:
    flood = Edit("", "flood depth-control 6 t", 300.0)
    pump = Edit("", "pump depth-control 6 t", 330.0)
    curve = curve_of("hover-by-pump", edited("hover-by-pump", flood, pump))
    (change,) = curve.changes
    lost = curve.points[0].marks - curve.points[-1].marks
    assert change.marks == pytest.approx(-lost, abs=1.0)
    (told,) = words_of(curve)
    start = '5:00: "flood depth-control 6 t", by panel, taken back at 5:30, cost'
    assert told.startswith(f"{start} {lost:.0f} marks.")
    assert "even the reference crew loses" not in told  # 30 s later it did not


def test_a_point_that_a_later_take_over_beats_is_no_point_of_no_return() -> None:
    marks = (100.0, 30.0, 20.0, 70.0, 70.0, 10.0)
    points = [AttainablePoint(i, each, won=False, lost=each < 50.0) for i, each in enumerate(marks)]
    lasting = lasting_points(points)
    assert [each.marks for each in lasting] == [100.0, 70.0, 70.0, 70.0, 70.0, 10.0]
    assert [each.lost for each in lasting] == [False, False, False, False, False, True]
    assert [each.tick for each in lasting] == [*range(6)]


@pytest.mark.long
def test_marks_that_rise_and_fall_between_two_hands_are_not_called_better() -> None:
    told = words_of(late_curve("stern-plane-jam", 15.0))
    assert any("9 marks more to be had; no one order did it." in each for each in told)
    assert not [each for each in told if "better than the reference crew" in each]


def test_parts_of_a_fall_are_told_with_no_more_marks_than_the_whole() -> None:
    draws = np.random.default_rng(11)
    for _ in range(300):
        falls = tuple(
            SteepFall(10 * i, each, PassedKind.RULE, str(i))
            for i, each in enumerate(draws.uniform(3.0, 30.0, 5))
        )
        whole = min(float(draws.uniform(3.0, 140.0)), sum(each.marks for each in falls))
        kept = bound_falls(falls, whole)
        told = change_words(MarkChange(0, 60, -whole, ChangeCause.STEERING, falls=kept), STEP_S)
        parts = [int(each) for each in re.findall(r"Of these, (\d+)", told)]
        assert len(parts) == len(kept)
        assert sum(parts) <= round(whole)
    assert bound_falls(falls, 150.0) == falls


def test_what_an_order_won_is_taken_off_what_it_cost() -> None:
    cause = ChangeCause
    lost = MarkChange(0, 9, -30.0, cause.ORDER, "blow all", tick=4)
    stop = MarkChange(20, 25, 12.0, cause.BETTER, "blow stop", tick=20)
    other = MarkChange(20, 25, 12.0, cause.BETTER, "rudder left 5", tick=20)
    more = MarkChange(20, 25, 40.0, cause.BETTER, "blow stop", tick=20)
    (net,) = net_changes([lost, stop])
    assert (net.marks, net.back, net.end) == (-18.0, 20, 25)
    assert net_changes([lost, other]) == [lost, other]
    assert [each.marks for each in net_changes([lost, more])] == [10.0]
    missing = MarkChange(0, 9, -30.0, cause.MISSING, "course 335", tick=4, came=20)
    late_one = MarkChange(20, 25, 12.0, cause.BETTER, "course 335", tick=20)
    (net,) = net_changes([missing, late_one])
    assert (net.marks, net.back) == (-18.0, None)
    assert len(join_changes([lost, stop, lost])) == 3


@pytest.mark.parametrize(
    ("name", "seconds"),
    [("first-depth-change", 70.0), ("steady-course", 70.0), ("course-changes", 20.0)],
)
@pytest.mark.long
def test_who_is_late_with_every_order_right_is_filed_as_late(name: str, seconds: float) -> None:
    curve = late_curve(name, seconds)
    assert list(costs_by_kind(curve)) == ["late"]
    assert all("until" in each and "s late" in each for each in words_of(curve))


@pytest.mark.long
@pytest.mark.parametrize(
    ("order", "kind"),
    [("stern planes dive 10", "overshoot"), ("stern planes rise 10", "wrong way")],
)
def test_planes_left_where_they_are_overshoot_or_go_the_wrong_way(order: str, kind: str) -> None:
    name = "first-depth-change"
    assert list(costs_by_kind(curve_of(name, with_nobody_else(name, 65.0, order)))) == [kind]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["depth-gauge-failure", "crossing-traffic"])
def test_what_is_lost_while_an_order_is_overdue_is_late_and_not_a_hand_s(name: str) -> None:
    assert list(costs_by_kind(late_curve(name, 60.0))) == ["late"]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stern-plane-jam", "canyon", "crossing-traffic", "watch"])
def test_the_costs_of_a_run_add_up_to_the_marks_lost(name: str) -> None:
    curve = late_curve(name, 50.0)
    lost = curve.points[0].marks - curve.points[-1].marks
    assert sum(costs_of(curve.changes).values()) == pytest.approx(lost, abs=3.0)
    for change in curve.changes:
        assert sum(each.marks for each in change.falls) <= abs(change.marks)


@pytest.mark.parametrize(
    ("order", "right", "wrong"),
    [
        ("pump trim forward 3", "pump trim aft 3", True),
        ("flood depth-control 8", "pump depth-control 5", True),
        ("bell ahead two-thirds", "bell astern two-thirds", True),
        ("rudder left 10", "rudder right 15", True),
        ("hover off", "hover on", True),
        ("flood auxiliary 8", "pump depth-control 5", False),
        ("stern planes rise 5", "bow planes dive 5", False),
        ("rudder amidships", "rudder right 15", False),
    ],
)
def test_the_wrong_way_is_the_other_way_at_the_same_control(
    order: str, right: str, *, wrong: bool
) -> None:
    assert is_wrong_way(order, right) is wrong


def test_orders_are_alike_where_a_hand_would_not_tell_them_apart() -> None:
    assert is_alike("stern planes dive 9", "stern planes dive 10")
    assert is_alike("rudder amidships", "rudder left 1")
    assert is_alike("planesman on", "planesman on")
    assert not is_alike("stern planes dive 9", "stern planes dive 12")
    assert not is_alike("stern planes dive 1", "stern planes auto")
    assert not is_alike("stern planes dive 9", "bow planes dive 9")
    assert control_of("speed 4") == control_of("bell stop") == control_of("turns 5")
    assert share_of("stern planes dive 5", "stern planes dive 10") == pytest.approx(0.5)
    assert share_of("stern planes rise 10", "stern planes dive 10") == pytest.approx(-1.0)
    assert share_of("bow planes dive 5", "stern planes dive 10") == 0.0


def test_it_is_said_not_to_be_carried_out_only_of_what_was_not() -> None:
    plan = plan_of("stern-plane-jam")
    cards = [
        explored("stern-plane-jam", run).judge(run.trajectory)
        for run in (late("stern-plane-jam", 20.0), fly_rehearsal(plan))
    ]
    came, never = (" ".join(each.told for each in costs(card, None)) for card in cards)
    assert "it fell short of 80, beside its own marks" in came
    assert "it was not carried out" not in came
    assert "it was not carried out, beside its own marks" in never

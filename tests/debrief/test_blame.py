"""Blame that is proved: which order, what was wrong with it, what it cost, until when."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from helpers.explored import by_crew, explored, late, plan_of, planted, with_fault, with_nobody_else
from helpers.sessions import start_plan

from trainer.debrief.attainable.causes import FaultFinder
from trainer.debrief.attainable.changes import FaultKind, MarkChange, join_changes
from trainer.debrief.attainable.curve import AttainableCurve, attainable_curve
from trainer.debrief.attainable.search import AttainablePoint
from trainer.debrief.attainable.words import change_words, until_words
from trainer.debrief.marks.judgement import costs
from trainer.debrief.marks.rehearsal import Departure, Rehearsal, fly, fly_rehearsal
from trainer.debrief.passage.controls import is_wrong_way
from trainer.debrief.trainees.progress import costs_of

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")
STEP_S = 0.5  # [s] of the boats that fly here
KINDS = FaultKind
Make = Callable[..., Rehearsal]
# what was done, and the fault that is told of it: kind, order, its moment [s], what was right
TOLD = (
    (
        planted,
        ("fire-aft", 130.0, "ventilation run"),
        (KINDS.UNDONE, "ventilation run", 130.0, "ventilation secure"),
    ),
    (
        planted,
        ("flooding-aft", 110.0, "bell stop"),
        (KINDS.UNDONE, "bell stop", 110.0, "bell ahead full"),
    ),
    (
        with_fault,
        ("gyro-stuck", "rudder right 10", "rudder left 10", 0.0),
        (KINDS.WRONG_WAY, "rudder left 10", 64.0, "rudder right 10"),
    ),
    (
        planted,
        ("leaking-leg", 95.0, "bow planes emergency", "stern planes emergency"),
        (KINDS.WRONG_PLACE, "bow planes emergency", 95.0, "stern planes emergency"),
    ),
    (
        with_fault,
        ("hover-by-pump", "pump depth-control 2 t", "pump depth-control 6 t", 0.0),
        (KINDS.WRONG_AMOUNT, "pump depth-control 6 t", 60.0, "pump depth-control 2 t"),
    ),
    (
        with_fault,
        ("fire-aft", "ventilation secure", "ventilation secure", 100.0),
        (KINDS.LATE, "ventilation secure", 117.0, ""),
    ),
    (
        with_fault,
        ("air-bank-failure", "drain centre", None, 0.0),
        (KINDS.MISSING, "drain centre", 82.0, ""),
    ),
    (
        planted,
        ("depth-changes", 10.0, "rudder left 10"),
        (KINDS.NEEDLESS, "rudder left 10", 10.0, ""),
    ),
    (
        planted,
        ("steady-course", 300.0, "rudder right 20"),
        (KINDS.STEERING, "rudder right 20", 300.0, ""),
    ),
)


def curve_of(name: str, run: Rehearsal) -> AttainableCurve:
    return attainable_curve(explored(name, run))


def words_of(curve: AttainableCurve) -> list[str]:
    return [change_words(each, STEP_S) for each in curve.changes]


def costs_by_kind(curve: AttainableCurve) -> dict[str, float]:
    return {kind: marks for kind, marks in costs_of(curve.changes).items() if marks}


@pytest.mark.parametrize(
    ("make", "how", "told"),
    [
        pytest.param(
            *each, id=each[2][0].value, marks=[pytest.mark.slow] if i not in (0, 2, 5) else []
        )
        for i, each in enumerate(TOLD)
    ],
)
def test_a_fault_is_told_by_its_kind_its_order_its_moment_and_its_price(
    make: object, how: tuple[object, ...], told: tuple[FaultKind, str, float, str]
) -> None:
    assert callable(make)
    curve = curve_of(str(how[0]), make(*how))
    dearest = min(curve.changes, key=lambda each: each.marks)
    found = (dearest.fault, dearest.order, float(int((dearest.tick or 0) * STEP_S)), dearest.right)
    assert found == told
    lost = curve.points[0].marks - curve.points[-1].marks
    assert -sum(each.marks for each in curve.changes) == pytest.approx(lost, abs=3.0)


def test_a_fault_that_cost_nothing_is_not_told() -> None:
    curve = curve_of("flooding-aft", with_fault("flooding-aft", "drain aft", "drain forward", 0.0))
    assert curve.points[-1].marks > 97.0
    assert curve.changes == ()


@pytest.mark.parametrize("case", [TOLD[0], TOLD[2]], ids=["undone", "wrong-way"])
def test_the_edit_of_a_sentence_flown_by_itself_keeps_what_is_told(
    case: tuple[object, tuple[object, ...], object],
) -> None:
    make, how, _ = case
    assert callable(make)
    name = str(how[0])
    run = explored(name, make(*how))
    (change,) = attainable_curve(run).changes
    finder = FaultFinder(run)
    gains = 0.0
    for begin, end in finder.falls():
        edits = [each for each in finder.edits(begin, end) if each.told.cause == change.cause]
        loss = run.points[begin].marks - run.points[end].marks
        gains += min(max(finder.gain(each, begin, end) for each in edits), loss)
    assert gains == pytest.approx(-change.marks, abs=3.0)


@pytest.mark.long
def test_two_faults_of_one_fall_are_both_told_and_add_up() -> None:
    name = "fire-aft"
    plan, given = plan_of(name), by_crew(name).trajectory.orders
    orders: dict[int, list[Any]] = {}
    for each in given:
        wrong = each.text == "breaker starboard open"
        text = "breaker port open" if wrong else each.text
        tick = each.tick + (80 if each.text == "fight fire aft" else 0)
        orders.setdefault(tick, []).append(replace(each, tick=tick, text=text))
    run, _ = fly(plan, Departure(0, start_plan(plan).records.state.copy()), orders)
    curve = curve_of(name, run)
    assert {each.fault for each in curve.changes} == {KINDS.LATE, KINDS.WRONG_PLACE}
    lost = curve.points[0].marks - curve.points[-1].marks
    assert -sum(each.marks for each in curve.changes) == pytest.approx(lost, abs=1.0)


@pytest.mark.long
def test_the_order_that_came_late_is_named_with_how_late_it_came() -> None:
    curve = curve_of("crash-stop", late("crash-stop", 45.0))
    assert {each.fault for each in curve.changes} == {KINDS.LATE}
    assert "came 45 s late, at" in words_of(curve)[0]
    assert list(costs_by_kind(curve)) == ["late"]


def test_planes_that_nobody_touched_were_not_worked_by_anybody() -> None:
    name = "first-depth-change"
    curve = curve_of(name, fly_rehearsal(plan_of(name)))
    told = words_of(curve)
    assert any("lost; nobody worked planes or rudder" in each for each in told)
    assert list(costs_by_kind(curve)) == ["late"]


@pytest.mark.long
def test_planes_left_where_they_are_overshoot_and_are_told_from_their_order_on() -> None:
    name = "first-depth-change"
    curve = curve_of(name, with_nobody_else(name, 65.0, "stern planes dive 10"))
    assert list(costs_by_kind(curve)) == ["overshoot"]
    assert 'from "stern planes dive 10" at 1:05 on' in words_of(curve)[0]


def test_parts_of_a_fault_are_one_change() -> None:
    one = MarkChange(0, 10, -5.0, KINDS.UNDONE, "bell stop", tick=3, right="bell ahead full")
    other = MarkChange(40, 50, -7.0, KINDS.UNDONE, "bell stop", tick=3, right="bell ahead full")
    steered = MarkChange(20, 30, -4.0, KINDS.STEERING)
    joined = join_changes([one, steered, other, steered])
    assert [(each.marks, each.end) for each in joined] == [(-12.0, 50), (-4.0, 30)]


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


@pytest.mark.parametrize(
    ("make", "how", "told"),
    [
        (
            planted,
            ("flooding-aft", 173.0, "blow aft"),
            (KINDS.UNDONE, "blow aft", "blow stop"),
        ),
        (
            with_fault,
            ("rise-jam-shallow", "bell ahead two-thirds", "bell astern two-thirds", 0.0),
            (KINDS.WRONG_WAY, "bell astern two-thirds", "bell ahead two-thirds"),
        ),
        pytest.param(
            with_fault,
            ("gyro-stuck", "rudder left 10", "rudder left 10", 60.0),
            (KINDS.LATE, "rudder left 10", ""),
            marks=pytest.mark.long,
        ),
    ],
)
def test_a_rule_s_order_that_comes_again_or_early_is_told_as_what_it_was(
    make: Make, how: tuple[Any, ...], told: tuple[FaultKind, str, str]
) -> None:
    curve = curve_of(how[0], make(*how))
    assert [(each.fault, each.order, each.right) for each in curve.changes] == [told]


def test_a_record_that_ends_early_has_no_point_of_no_return() -> None:
    points = tuple(
        AttainablePoint(tick, marks, won=marks > 50.0, lost=False)
        for tick, marks in ((0, 100.0), (190, 100.0), (192, 0.0))
    )
    whole = AttainableCurve(points, ())
    assert until_words(whole, STEP_S) == "Until 1:35 this could still be won."
    short = until_words(replace(whole, cut_short=True), STEP_S)
    assert short == "To its end nothing was lost that decides the exercise."


def test_a_debrief_that_may_fly_no_more_says_that_no_cause_was_looked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("trainer.debrief.attainable.causes.MAX_TICKS", 0)
    curve = curve_of("gyro-stuck", planted("gyro-stuck", 200.0, "rudder right 20"))
    assert {each.fault for each in curve.changes} == {KINDS.UNSEARCHED}
    assert "the cause of so long a run is not looked for" in words_of(curve)[0]

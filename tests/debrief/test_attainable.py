"""What could still be earned at each moment of a run, and what cost it."""

from dataclasses import replace
from functools import cache, partial
from typing import Any

import pytest
from helpers.givers import journalled

from trainer.boat.boat import Boat
from trainer.boat.mute_crew import MuteCrew, is_same_order
from trainer.debrief.attainable import (
    ChangeCause,
    NoCurve,
    RunExplorer,
    attainable_curve,
)
from trainer.debrief.judgement import judge_run, plain_marks
from trainer.debrief.rehearsal import Departure, Rehearsal, fly, fly_rehearsal
from trainer.io.orders.grammar import Order, parse
from trainer.session.options import RunOptions
from trainer.session.plan import Plan, plan_run

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")
SHORT = ("stern-plane-jam", "rise-jam-shallow", "steering-jam", "flooding-aft", "hover-by-pump")


@cache
def plan_of(name: str) -> Plan:
    return plan_run(RunOptions(exercise=name)).alone()


@cache
def nobody_of(name: str) -> dict[str, float]:
    return plain_marks(fly_rehearsal(plan_of(name)).trajectory, plan_of(name))


@cache
def by_crew(name: str) -> Rehearsal:
    return fly_rehearsal(plan_of(name), plan_of(name).crew)


def explored(name: str, run: Rehearsal) -> RunExplorer:
    plan = plan_of(name)
    judge = partial(judge_run, plan=plan, nobody=nobody_of(name))
    explorer = RunExplorer(plan, run.trajectory, judge)
    explorer.fly_again()
    return explorer


def planted(name: str, seconds: float, text: str, without: str = "") -> Rehearsal:
    """Return the reference crew's run with one order more, and perhaps one less."""
    plan = plan_of(name)
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    given = [each for each in by_crew(name).trajectory.orders if each.text != without]
    orders: dict[int, list[Any]] = {}
    more = [journalled(9000, round(2 * seconds), "panel", text, "")] if text else []
    for entry in (*given, *more):
        orders.setdefault(entry.tick, []).append(entry)
    return fly(plan, Departure(0, boat.records.state.copy()), orders)[0]


@pytest.mark.parametrize("name", SHORT)
def test_on_the_reference_crew_s_own_run_nothing_is_ever_lost(name: str) -> None:
    run = explored(name, by_crew(name))
    own = run.judge(run.trajectory).total
    assert own
    for tick in range(0, run.last, 60):
        assert run.point(tick).marks == pytest.approx(own, abs=1.0), tick


@pytest.mark.parametrize(
    ("name", "seconds", "order"),
    [
        ("stern-plane-jam", 300.0, "blow all"),
        ("first-depth-change", 150.0, "blow all"),
        ("flooding-aft", 300.0, "stern planes dive 20"),
    ],
)
def test_a_harmful_order_is_named_within_five_seconds(
    name: str, seconds: float, order: str
) -> None:
    curve = attainable_curve(explored(name, planted(name, seconds, order)))
    dearest = min(curve.changes, key=lambda change: change.marks)
    assert (dearest.cause, dearest.order) == (ChangeCause.ORDER, order)
    assert dearest.tick is not None
    assert abs(dearest.tick / 2.0 - seconds) <= 5.0


def test_an_order_that_is_missing_is_named() -> None:
    left_out = planted("stern-plane-jam", 0.0, "", without="bell astern full")
    (change, *_) = attainable_curve(explored("stern-plane-jam", left_out)).changes
    assert (change.cause, change.order) == (ChangeCause.MISSING, "bell astern full")


def test_a_run_of_another_core_has_no_curve() -> None:
    flown = by_crew("stern-plane-jam").trajectory
    columns = {**flown.columns, "z": flown.columns["z"] + 1e-12}
    other = replace(by_crew("stern-plane-jam"), trajectory=replace(flown, columns=columns))
    with pytest.raises(NoCurve, match="cannot be flown again to the bit"):
        explored("stern-plane-jam", other)


def test_a_mute_crew_gives_nothing_and_knows_what_is_overdue() -> None:
    plan = plan_of("backing")
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    mute = MuteCrew(boat, plan.crew)
    for tick in range(160):
        due = [each.order for each in plan.schedule if 2 * each.seconds == tick]
        for order in due:
            planned = parse(order.text)
            assert isinstance(planned, Order)
        before = boat.records.state.tobytes()
        mute.follow(due)
        assert boat.records.state.tobytes() == before
        assert boat.tick() == 0
    assert mute.crew.boat is boat
    assert [each.given for each in mute.crew.followed].count(None) > 0


def test_orders_are_the_same_that_say_the_same_to_the_same_control() -> None:
    first, same, other = map(parse, ("rudder left 10", "rudder left 10 deg", "rudder right 10"))
    assert isinstance(first, Order)
    assert isinstance(same, Order)
    assert isinstance(other, Order)
    assert is_same_order(first, same)
    assert not is_same_order(first, other)

"""Flights without a session: flown in long stretches, they are those of one tick after another."""

import math
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from helpers.lanes import sample_cases

from trainer.analysis.sweep.exercises import go_out
from trainer.authoring.trainees import Skill, Trainee
from trainer.boat.boat import Boat
from trainer.boat.casualties import InstrumentReadings
from trainer.boat.crew_hands import GaugeHistory, PlanesHand, RudderHand, TicksAhead
from trainer.boat.due_orders import entries_due
from trainer.boat.helm import obey_order
from trainer.boat.mute_crew import MuteCrew
from trainer.boat.reference_crew import ReferenceCrew
from trainer.config.exercise.reference_crew import Helmsman, Planesman
from trainer.debrief.attainable.explorer import RunExplorer
from trainer.debrief.marks import rehearsal
from trainer.debrief.marks.judgement import judge_run
from trainer.debrief.marks.rehearsal import (
    ByReference,
    Flight,
    Rehearsal,
    fly_rehearsal,
    last_tick,
)
from trainer.io.recording.facts import SCHEDULE_GIVER
from trainer.io.tables import MOTION_COLUMNS
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run


def plan_of(name: str) -> Plan:
    """Return a shipped exercise, nobody else aboard."""
    return plan_run(RunOptions(exercise=name)).alone()


def assert_same(one: Rehearsal, other: Rehearsal) -> None:
    """Check that two flights are the same to the bit."""
    for name, column in one.trajectory.columns.items():
        assert column.tobytes() == other.trajectory.columns[name].tobytes(), name
    assert one.trajectory.orders == other.trajectory.orders
    assert one.trajectory.marks == other.trajectory.marks
    assert (one.lost, one.rules_given) == (other.lost, other.rules_given)


# hands at work; rules by gauges and their means; a rate; currents by depth; ships and a periscope
CREWED = (
    *("stern-plane-jam", "depth-gauge-failure", "periscope-depth", "canyon", "crossing-traffic"),
    *("ordered-bubble", "course-changes"),  # an ordered pitch; turns, and depths by automatic
)


@pytest.mark.parametrize("name", sample_cases(CREWED, "stern-plane-jam", *CREWED[-2:]))
def test_a_crew_that_looks_when_it_must_gives_the_orders_of_one_that_always_looks(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    plan = plan_of(name)
    flown = fly_rehearsal(plan, plan.crew)
    monkeypatch.setattr(rehearsal, "MAX_STRIDE_TICKS", 1)
    assert flown.trajectory.orders
    assert_same(flown, fly_rehearsal(plan, plan.crew))


@pytest.mark.parametrize("name", sample_cases(CREWED, "stern-plane-jam", *CREWED[-2:]))
def test_a_mute_crew_that_looks_when_it_must_knows_what_one_knows_that_always_looks(
    monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """It knows it at each moment kept, whether the run is the reference crew's or nobody's."""
    plan, moments = plan_of(name), 0
    for crew in (plan.crew, None):
        flown = fly_rehearsal(plan, crew).trajectory
        known = []
        for stride in (rehearsal.MAX_STRIDE_TICKS, 1):
            monkeypatch.setattr(rehearsal, "MAX_STRIDE_TICKS", stride)
            run = RunExplorer(plan, flown, lambda each: judge_run(each, plan, {}))
            run.finest = 60
            run.fly_again()
            known.append([(tick, knowledge(each.crew)) for tick, each in run.departures.items()])
            monkeypatch.undo()
        assert known[0] == known[1]
        moments += len(known[0])
    assert moments > 10


def knowledge(mute: MuteCrew | None) -> object:
    """Return what a mute crew knows of its rules, and of its hands."""
    assert mute is not None
    hands = [{**vars(hand), "boat": None} for hand in mute.crew.hands.values()]
    seen = [(time, *row) for time, row in mute.crew.gauges.seen]
    return [replace(each) for each in mute.crew.followed], hands, seen


def test_a_crew_that_misreads_its_gauges_looks_as_often_as_one_that_always_looks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plan = plan_of("stern-plane-jam")
    aboard = partial(Trainee, Skill("misreads", misread_share=0.1))
    flown = fly_rehearsal(plan, plan.crew, come_aboard=aboard)
    monkeypatch.setattr(rehearsal, "MAX_STRIDE_TICKS", 1)
    assert_same(flown, fly_rehearsal(plan, plan.crew, come_aboard=aboard))


@pytest.mark.parametrize("seed", range(40))
def test_it_is_known_when_a_hand_orders_next(seed: int) -> None:
    """Of readings drawn at random, over north and round the compass too."""
    draws = np.random.default_rng(seed)
    plan = plan_of("depth-changes")
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    gauges, count = GaugeHistory(boat), 80
    gauges.look()
    walk = {name: np.cumsum(draws.normal(0.0, 0.004, count)) for name in ("theta", "q", "r")}
    course = boat.state.ordered_psi + math.tau * draws.integers(-3, 4)
    course += np.cumsum(draws.normal(0.0, 0.004, count))
    readings = np.zeros((count, len(InstrumentReadings._fields)))
    readings[:, InstrumentReadings._fields.index("heading")] = course
    depth = 60.0 + np.cumsum(draws.normal(0.0, 0.4, count))
    readings[:, InstrumentReadings._fields.index("depth")] = depth
    helm, planes = RudderHand(boat, Helmsman()), PlanesHand(boat, Planesman())
    hands: tuple[RudderHand | PlanesHand, ...] = helm, planes
    helm.looked = planes.looked = 0.0
    aims = {name: np.full(count, boat.state[name]) for name in ("ordered_psi", "ordered_depth")}
    ahead = TicksAhead(0, boat.method.step, {**walk, **aims}.__getitem__, readings, gauges)
    known = [hand.first_order(ahead) for hand in hands]
    given = [count, count]
    for i, row in enumerate(readings.tolist()):
        boat.state.tick = i + 1
        for name, values in walk.items():
            boat.state[name] = values[i]
        gauges.remember([(boat.time, InstrumentReadings(*row))])
        for j, hand in enumerate(hands):
            orders = hand.look(gauges)
            given[j] = min(given[j], i + 1) if orders else given[j]
    assert known == given


AHEAD = """
schema = "exercise/1"
name = "Ahead"
briefing = "A ship lies ahead."
duration_s = 300
[initial]
speed_kn = 6
depth_m = 17.5
[[contact]]
name = "anchored"
type = "tanker"
points = [[200, 0]]
course_deg = 90
[contacts]
collision = "end"
"""


def test_a_boat_that_is_lost_on_the_way_is_where_it_was_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The hull collapses, or the boat runs into a ship, in the middle of a stretch."""
    (tmp_path / "ahead.toml").write_text(AHEAD)
    plans = plan_of("flooding-aft"), plan_of(str(tmp_path / "ahead.toml"))
    flights = [fly_rehearsal(plan) for plan in plans]
    monkeypatch.setattr(rehearsal, "MAX_STRIDE_TICKS", 1)
    for flown, plan in zip(flights, plans, strict=True):
        assert_same(flown, fly_rehearsal(plan))
        assert flown.trajectory.boat.ticks == flown.trajectory.ticks[-1]
    assert [each.lost for each in flights] == ["collapse at 450 m", "collision with anchored"]
    assert [go_out(plan).flight.lost for plan in plans] == [each.lost for each in flights]


def test_a_member_of_a_sweep_flies_as_tick_by_tick() -> None:
    plan = plan_of("course-changes")
    outing = go_out(plan)
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    due = entries_due(boat, plan.schedule)
    rows = [boat.numbers(MOTION_COLUMNS)]
    for tick in range(last_tick(plan)):
        for place in due.get(tick, ()):
            obey_order(boat, plan.schedule[place].order)
        assert boat.tick() == 0
        rows.append(boat.numbers(MOTION_COLUMNS))
    for name, column in zip(MOTION_COLUMNS, np.array(rows).T, strict=True):
        assert np.array_equal(outing.flight.series.columns[name], column), name


def test_a_gauge_that_an_order_breaks_is_read_anew_in_that_tick() -> None:
    plan = plan_of("depth-changes")
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    crew = ReferenceCrew(boat, plan.crew)
    flight = Flight(plan, boat, ByReference(crew))
    flight.fly_to(20)
    before = crew.gauges.now().depth
    broken = flight.journal.write(SCHEDULE_GIVER, "casualty depth-gauge-biased 1 ramp 0", "")
    flight.give_again([broken])
    flight.fly_to(21)
    time, row = crew.gauges.seen[-2]
    assert time == 20 * plan.method.step
    assert InstrumentReadings(*row).depth == pytest.approx(before + 10.0)  # [m] of the table
    assert [each for each, _ in crew.gauges.seen].count(time) == 1


@pytest.mark.parametrize(
    ("seconds", "rate"), [(0.0, False), (7.0, False), (0.0, True), (9.0, True)]
)
def test_sliding_means_of_gauges_are_those_of_a_look(seconds: float, *, rate: bool) -> None:
    plan = plan_of("depth-changes")
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    gauges = GaugeHistory(boat)
    gauges.look()
    ahead = np.random.default_rng(3).normal(50.0, 9.0, (40, 4))
    slid = gauges.over("depth", seconds, ahead, rate=rate)
    for tick, row in enumerate(ahead.tolist(), 1):
        gauges.remember([(tick * boat.method.step, InstrumentReadings(*row))])
        look = gauges.rate if rate else gauges.mean
        assert slid[tick - 1] == pytest.approx(look("depth", seconds), abs=1e-9)

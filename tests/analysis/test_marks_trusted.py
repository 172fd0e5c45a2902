"""Marks that can be trusted: late crews, slips, cliffs, silly crews and hunting hands."""

import functools
from collections.abc import Sequence
from dataclasses import replace

import pytest
from helpers.lanes import sample_cases
from helpers.rehearsed import flown, marks_of

from trainer.authoring.trainees import Skill, Trainee
from trainer.boat.boat import Boat
from trainer.boat.reference_crew import CrewReaction, GivenOrder
from trainer.config.exercise.reference_crew import read_crew
from trainer.config.files import Position, shipped_names
from trainer.debrief.marks.judgement import judge_run, whole_share
from trainer.debrief.marks.rehearsal import Departure, OrdersByTick, fly, fly_rehearsal
from trainer.debrief.marks.scoring import Scorecard
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.facts import REFERENCE_GIVER
from trainer.io.recording.queries import RecordedOrder
from trainer.session.crew.manning import in_hand

NAMES = shipped_names("exercises")
# in these a second counts
URGENT = (
    *("emergency-deep", "steering-jam", "stern-plane-jam", "stern-servo"),
    "rise-jam-shallow",
)
HUNTING_S = 4.0  # [s] from twitch to twitch


def total(card: Scorecard | None) -> float:
    assert card is not None
    return card.total or 0.0


@functools.cache
def late(name: str, seconds: float) -> Scorecard:
    return marks_of(name, flown(name).plan.crew, CrewReaction(late=seconds))


@functools.cache
def jittering(name: str, seed: int) -> Scorecard:
    return marks_of(name, flown(name).plan.crew, CrewReaction(jitter=8.0, seed=seed))


def by_orders(name: str, orders: Sequence[tuple[float, str]]) -> Scorecard:
    """Return the marks of a crew that gives orders by the clock, as far as they are allowed."""
    plan = flown(name).plan
    rules = []
    for at, text in orders:
        order = parse(text)
        assert isinstance(order, Order), text
        if at < plan.hand_from or in_hand(order, plan.hand, plan.allowed) is None:
            rules.append({"at_s": at, "order": text})
    crew = read_crew({"crew": rules}, Position("test", ""))
    return marks_of(name, crew)


@functools.cache
def hunting(name: str, surface: str) -> Scorecard:
    """Return the marks of the reference crew whose other hand twitches planes or rudder."""
    plan, run = flown(name).plan, flown(name).flights["crew"].trajectory
    sides = {"stern": ("stern planes rise 4", "stern planes dive 4")}.get(
        surface, ("rudder left 4", "rudder right 4")
    )
    step = plan.method.step
    orders: dict[int, list[RecordedOrder]] = {}
    for entry in run.orders:
        orders.setdefault(entry.tick, []).append(entry)
    twitches = range(round(60.0 / step), int(run.ticks[-1]), round(HUNTING_S / step))
    for i, tick in enumerate(twitches):
        twitch = RecordedOrder(0, 1, tick, REFERENCE_GIVER, sides[i % 2], None, None, "")
        orders.setdefault(tick, []).append(twitch)
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    given: OrdersByTick = orders
    hunted, _ = fly(plan, Departure(0, boat.records.state.copy()), given)
    return judge_run(hunted.trajectory, plan, flown(name).nobody_marks)


@pytest.mark.long
@pytest.mark.parametrize("name", sample_cases(NAMES, *URGENT, *NAMES[::5]))
def test_a_crew_40_s_late_is_below_90_and_one_15_s_late_above_it(name: str) -> None:
    assert total(late(name, 40.0)) < 90.0
    if name not in URGENT:
        assert total(late(name, 15.0)) > 90.0


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_eight_seconds_cost_ten_marks_at_most(name: str) -> None:
    own = total(flown(name).crew)
    assert own >= 97.0
    assert total(late(name, 8.0)) >= own - 10.0
    for seed in (1, 2, 3, 4):
        assert total(jittering(name, seed)) >= own - 10.0


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_hunting_with_planes_or_rudder_costs_something(name: str) -> None:
    for surface in ("stern", "rudder"):
        assert total(hunting(name, surface)) <= total(flown(name).crew) - 1.0, surface


SILLY = {
    "hover-by-pump": (
        [(61.0, "bell ahead one-third")],
        [(61.0, "bell ahead flank")],
        [(61.0, "emergency blow")],
    ),
    "depth-gauge-failure": (
        [(200.0, "depth 60"), (200.0, "depth 17.5")],
        [(200.0, "depth 60"), (200.0, "hover on")],
    ),
    "flooding-aft": (
        [(61.0, "emergency blow")],
        [(130.0, "emergency blow")],
        [(61.0, "surface")],
        [(61.0, "bell ahead flank")],
    ),
    "canyon": (
        [(61.0, "emergency blow")],
        [(61.0, "surface")],
        [(61.0, "stern planes rise 10"), (61.0, "bow planes rise 20")],
    ),
    "stern-plane-jam": ([(11.0, "bell astern full")],),
    "rise-jam-shallow": ([(11.0, "bell astern full")], [(61.0, "bell astern full")]),
    "heavy-boat": ([(11.0, "autopilot on"), (11.0, "depth 60")],),
    "loss-of-propulsion": ([(61.0, "pump depth-control 5")],),
    "main-oil-lost": ([(68.0, "isolate main")], [(68.0, "planes hand")]),
    "port-bus-lost": (  # tied before the loads are shed
        [(72.0, "bus tie shut"), (184.0, "depth 40")],
        [(184.0, "depth 40")],
    ),
    "leaking-leg": (  # what moves the planes shut off, and another leg
        [(95.0, "isolate stern")],
        [(95.0, "stern planes emergency"), (98.0, "isolate bow")],
    ),
    "grounding-forward": ([(66.0, "emergency blow")], [(66.0, "isolate bow")]),
    "periscope-approach": (  # up at once, fast, and without a look astern
        [(31.0, "bow planes rise 10"), (720.0, "bell ahead full"), (720.0, "bow planes dive 20")],
        [(31.0, "emergency blow")],
    ),
    "fire-aft": (
        [(110.0, "fight fire aft")],
        [(110.0, "ventilation secure"), (113.0, "breaker starboard open")],
        [(110.0, "fight fire control"), (113.0, "ventilation secure")],
    ),
    "crossing-traffic": (
        [(61.0, "bell ahead flank")],
        [(61.0, "rudder right 30")],
        [(61.0, "rudder left 30")],
    ),
}


@pytest.mark.parametrize("name", SILLY)
def test_silly_things_earn_40_at_most(name: str) -> None:
    for orders in SILLY[name]:
        assert total(by_orders(name, orders)) <= 40.0, orders


class Panicking(Trainee):
    """A crew that goes astern before it does what is right."""

    def look(self) -> list[GivenOrder]:
        panic = self.boat.time == 72.0
        text = "bell astern full"
        return [*([self._give(text)] if panic else []), *super().look()]

    def next_look(self) -> float:
        return self.boat.time


def test_to_go_astern_in_a_flooding_for_20_s_costs_ten_marks() -> None:
    went, skill = flown("flooding-aft"), Skill("panic", prompt_steps=True)
    run = fly_rehearsal(
        went.plan, went.plan.crew, CrewReaction(14.0), functools.partial(Panicking, skill)
    )
    card = judge_run(run.trajectory, went.plan, went.nobody_marks)
    assert total(card) <= total(went.crew) - 10.0
    assert total(card) > total(late("flooding-aft", 30.0))


def test_an_emergency_dive_that_no_hand_holds_at_its_depth_is_not_half_won() -> None:
    own = flown("emergency-deep").plan.crew
    rows = [{"at_s": 360, "order": "planesman off"}, {"at_s": 361, "order": "stern planes rise 1"}]
    leaving = read_crew({"crew": rows}, Position("test", ""))
    crew = replace(own, rules=(*own.rules, *leaving.rules))
    assert total(marks_of("emergency-deep", crew)) <= 45.0


@pytest.mark.parametrize(("marks", "share"), [(40.0, 0.5), (80.0, 1.0), (90.0, 1.0)])
def test_the_weakest_task_takes_over_a_range_and_not_at_once(marks: float, share: float) -> None:
    card = flown("first-depth-change").crew
    assert card is not None
    weak = replace(card.scores[0], marks=marks, earned=marks)
    assert whole_share(weak) == pytest.approx(share)


def test_one_tick_at_the_end_decides_nothing() -> None:
    name = "first-depth-change"
    plan, run = flown(name).plan, flown(name).flights["crew"].trajectory
    depth = run.columns["z"].copy()
    depth[-1] += 5.0  # out of the band at the last tick
    slip = replace(run, columns={**run.columns, "z": depth})
    card = judge_run(slip, plan, flown(name).nobody_marks)
    assert total(card) >= total(flown(name).crew) - 3.0

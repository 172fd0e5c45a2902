"""The marks at each tick are those that the debrief gives a record that ends there."""

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from helpers import whole_passage

from trainer.api.boat import plan_boat
from trainer.boat.boat import Boat
from trainer.boat.due_orders import entries_due
from trainer.boat.reference_crew import ReferenceCrew
from trainer.boat.world.bottom import ground_under
from trainer.boat.world.contacts import contacts_in
from trainer.config.exercise.exercise import parse_exercise
from trainer.config.exercise.score_rules import SCORE_MEASURES, ScoreRule
from trainer.config.files import shipped_names
from trainer.core.kernel import Numbers
from trainer.debrief.marks import gates, judgement
from trainer.debrief.marks.judgement import judge_run
from trainer.debrief.marks.rehearsal import (
    ByReference,
    Flight,
    fly_rehearsal,
    last_tick,
    stretches,
)
from trainer.debrief.marks.tallied_record import tally_record
from trainer.debrief.passage.groundings import groundings
from trainer.debrief.passage.trajectory import Trajectory
from trainer.debrief.ticks.ground import GroundWatch, ground_reads
from trainer.debrief.ticks.judge import TickJudge, nobody_aboard
from trainer.io.recording.facts import Giver, GiverKind
from trainer.io.recording.recording import RecordedOrder
from trainer.session.past.plan import Plan

EXERCISES = shipped_names("exercises")
OF_SHIPS = "crossing-traffic", "periscope-approach"
OF_GROUND = "bottoming", "canyon"
CREW = Giver(GiverKind.STATION, "planesman", "tester")
LOOK_OUT = Giver(GiverKind.STATION, "scope", "tester")
LIKENESS = 1e-9  # [%]
# fmt: off
WORDS = (
    "stern planes rise {}", "stern planes dive {}", "bow planes rise {}", "bow planes dive {}",
    "rudder left {}", "rudder right {}", "turns {}", "stern planes auto", "bow planes auto",
    "rudder auto", "bell stop", "bell back full", "blow all", "emergency blow", "vent all open",
    "flood auxiliary {}", "pump auxiliary {}", "pump trim forward {}", "depth {}0", "course {}0",
    "drain aft", "hover on", "surface", "speed {}",
)
LOOK_OUT_WORDS = (
    *("scope raise", "scope raise", "scope lower", "mark contact {}", "depth 17"),
    *("report no close contacts", "report contact 0{}"),
)
DOWN_WORDS = (
    *("depth 9{}", "flood depth-control 3", "bell stop", "hover on", "hover off", "course 35{}"),
)
# fmt: on


@cache
def planned(name: str) -> Plan:
    return plan_boat({"exercise": name})[1]


@cache
def nobody_in(name: str) -> dict[str, float]:
    return nobody_aboard(planned(name))


def flight_of(name: str, seed: int) -> Trajectory:
    """Return a flight by orders drawn at random, half of them with the reference crew as well."""
    drawn, plan = np.random.default_rng(seed), planned(name)
    boat, last = plan.launch_boat(), last_tick(plan)
    crew = ReferenceCrew(boat, plan.crew, None) if seed % 2 else None
    flight = Flight(plan, boat, ByReference(crew))
    given: dict[int, list[RecordedOrder]] = {}
    words = WORDS + (name in OF_SHIPS) * (3 * LOOK_OUT_WORDS) + (name in OF_GROUND) * DOWN_WORDS
    for _ in range(int(drawn.choice((1, 3, 30)))):
        tick, text, giver = int(drawn.integers(last)), str(drawn.choice(words)), CREW
        if "mark" in text:
            text = text.format(bearing_drawn(boat, tick, drawn))
            giver = (CREW, LOOK_OUT)[int(drawn.integers(2))]
        text = text.format(drawn.integers(1, 31))
        given.setdefault(tick, []).append(RecordedOrder(0, 1, tick, giver, text, None, None, ""))
    due = entries_due(boat, plan.schedule)
    for tick, until in stretches(0, last, {*due, *given}):
        flight.give_scheduled(due.get(tick, ()))
        flight.give_again(given.get(tick, ()))
        if not flight.fly_to(until):
            break
    return flight.rehearsal().trajectory


def bearing_drawn(boat: Boat, tick: int, drawn: np.random.Generator) -> int:
    """Return a bearing [deg] at which a ship may be seen from the start."""
    contacts = contacts_in(boat)
    ship = drawn.choice(np.array(contacts.seen(tick), object)) if contacts else None
    true = math.degrees(math.atan2(ship.east, ship.north)) if ship else 0.0
    return round(true + float(drawn.choice((0.0, 30.0)))) % 360


def cut(flown: Trajectory, row: int) -> Trajectory:
    """Return a flight as its record is when a row is the last."""
    return replace(
        flown,
        ticks=flown.ticks[: row + 1],
        columns={name: column[: row + 1] for name, column in flown.columns.items()},
        lateness=flown.lateness[: row + 1],
        work=flown.work[: row + 1],
        orders=tuple(each for each in flown.orders if each.tick < row),
        marks=tuple(each for each in flown.marks if each.tick < row),
    )


def rows_of(judge: TickJudge, flown: Trajectory) -> Numbers:
    columns = {"tick": flown.ticks.astype(float), **flown.columns}
    return np.array([columns[name] for name in judge.reads]).T.copy()


def compared(
    name: str, flown: Trajectory, ends: list[int], also: tuple[ScoreRule, ...] = ()
) -> Iterator[tuple[int, float, float]]:
    """Yield each end with the judge's total and the debrief's, with rules beside the plan's."""
    plan, nobody = planned(name), nobody_in(name)
    plan = replace(plan, scores=(*plan.scores, *also))
    judge = TickJudge(plan)
    rows, heard, begun = rows_of(judge, flown), heard_in(flown), 0
    yield 0, judge.begin(0, rows[0], nobody), judged(cut(flown, 0), plan, nobody)
    for end in ends:
        while heard and heard[0].tick < end:
            judge.hear(0, heard.pop(0))
        total = float(judge.look(rows[None, begun + 1 : end + 1])[0])
        begun = end
        yield end, total, judged(cut(flown, end), plan, nobody)


def heard_in(flown: Trajectory) -> list[RecordedOrder]:
    """Return the orders and marks of a flight, by their ticks."""
    marks = [
        RecordedOrder(
            0, 1, each.tick, Giver(GiverKind.STATION, each.role, ""), text, None, None, ""
        )
        for each in flown.marks
        for text in [f"mark {each.text}"]
    ]
    return sorted((*flown.orders, *marks), key=lambda each: each.tick)


def judged(flown: Trajectory, plan: Plan, nobody: dict[str, float]) -> float:
    return judge_run(flown, plan, nobody).total or 0.0


def ends_of(flown: Trajectory, count: int, seed: int) -> list[int]:
    """Return rows at which a record may end, its last among them."""
    last = len(flown.ticks) - 1
    drawn = np.random.default_rng(seed).integers(1, max(last, 2), count).tolist()
    return sorted({*(row for row in drawn if row < last), last})


@pytest.mark.parametrize("name", ["first-depth-change", "watch", "rise-jam-shallow"])
def test_the_marks_at_a_tick_are_those_of_a_record_that_ends_there(name: str) -> None:
    totals = []
    for seed in (1, 2):
        flown = flight_of(name, seed)
        for end, ours, theirs in compared(name, flown, ends_of(flown, 5, seed)):
            assert ours == pytest.approx(theirs, abs=LIKENESS), (seed, end)
            totals.append(ours)

    assert max(totals) > 10.0


@pytest.mark.parametrize(("name", "seed"), [("bottoming", 1), ("crossing-traffic", 16)])
def test_ground_and_ships_are_judged_as_the_debrief_judges_them(name: str, seed: int) -> None:
    flown = flight_of(name, seed)
    last = len(flown.ticks) - 1

    for end, ours, theirs in compared(name, flown, [*range(last // 3, last, 97), last]):
        assert ours == pytest.approx(theirs, abs=LIKENESS), end

    plan, nobody = planned(name), nobody_in(name)
    crew = fly_rehearsal(plan, plan.crew).trajectory
    *_, (_, ours, theirs) = compared(name, crew, ends_of(crew, 3, 1))
    assert ours == pytest.approx(theirs, abs=LIKENESS)
    assert ours > judged(flown, plan, nobody) + 20.0


def test_who_runs_into_a_ship_that_ends_it_has_ended() -> None:
    flown = flight_of("crossing-traffic", 16)
    judge = TickJudge(planned("crossing-traffic"))
    rows = rows_of(judge, flown)
    judge.begin(0, rows[0], {})
    judge.look(rows[None, 1:-1])
    assert not judge.ended[0]

    judge.look(rows[None, -1:])

    assert judge.ended[0]


@pytest.mark.parametrize(("name", "seed"), [("bottoming", 5), ("bottoming", 9), ("canyon", 18)])
def test_groundings_tick_by_tick_are_those_of_the_record(name: str, seed: int) -> None:
    flown, boat = flight_of(name, seed), planned(name).launch_boat()
    bottom, reads = ground_under(boat), ("tick", *ground_reads(boat))
    assert bottom
    watch = GroundWatch(boat, bottom, 1, reads)
    columns = {"tick": flown.ticks.astype(float), **flown.columns}
    rows = np.array([columns[each] for each in reads]).T
    watch.begin(0, rows[0])
    for begun in range(0, len(rows), 10):
        watch.watch(rows[None, begun : begun + 10], [0])

    theirs = groundings(flown)
    ours = [(each.tick, each.touch, each.hard) for each in watch.groundings[0]]
    assert ours == [(each.row, each.touch, each.hard) for each in theirs]
    assert len(watch.faults(0)) == sum(each.at_fault for each in theirs)
    assert len(ours) > 1


@cache
def every_rule() -> tuple[ScoreRule, ...]:
    """Return rules of all measures: of the whole record, windows and a condition."""
    rules: tuple[ScoreRule, ...] = ()
    head = 'schema = "exercise/1"\nname = "Drill"\nbriefing = "Steer."\n'
    head += '[[casualties]]\nname = "stern-hard-over"\nat_s = 60\n[[scores]]\n'
    for name, measure in SCORE_MEASURES.items():
        keys = {"quantity": "'depth'", "target": "65", "band": "4", "casualty": "'stern-hard-over'"}
        quantity = f"'{measure.quantities[0]}'" if measure.quantities else keys["quantity"]
        given = {key: keys[key] for key in measure.needs} | {"full": "5", "zero": "90"}
        for key in {"quantity", "target"} & {*measure.may}:
            given[key] = quantity if key == "quantity" else keys[key]
        windows: tuple[dict[str, str], ...] = (
            {},
            {"from_s": "70", "to_s": "260"},
            {"when": "'speed > 4'"},
            {"since": "'stern-hard-over'", "from_s": "5", "to_s": "200"},
        )
        for number, window in enumerate(windows[: 1 if name == "response" else 4]):
            rule = {"name": f"'{name} {number}'", "measure": f"'{name}'", **given, **window}
            lines = "".join(f"{key} = {value}\n" for key, value in rule.items())
            rules += parse_exercise(head + lines, Path("drill.toml")).scores
    return rules


def assert_judged_as_a_whole(flown: Trajectory, plan: Plan) -> None:
    """Check each value, its moment, and what caps the marks by the other way of counting."""
    rules = (*plan.scores, *every_rule())
    record = tally_record(flown, rules, plan)
    for rule in rules:
        ours, theirs = record.measurement(rule), whole_passage.take_measure(flown, rule)
        assert replace(ours, value=None) == replace(theirs, value=None), rule.score.name
        assert (ours.value or 0.0) == pytest.approx(theirs.value or 0.0, LIKENESS, LIKENESS), rule
        assert (ours.value is None) == (theirs.value is None)
    limits, lost = whole_passage.told_of_caps(flown, plan)
    assert dict(gates._broken(record)) == pytest.approx(limits)  # noqa: SLF001
    words = judgement._turned_over, judgement._ended  # noqa: SLF001
    turned, ended = (word(record) for word in words)
    assert [turned, *judgement._losses(record), ended] == lost  # noqa: SLF001


@pytest.mark.parametrize(
    ("name", "seed"), [("bottoming", 9), ("crossing-traffic", 16), ("stern-plane-jam", 3)]
)
def test_each_of_all_measures_is_judged_tick_by_tick(name: str, seed: int) -> None:
    flown = flight_of(name, seed)
    assert_judged_as_a_whole(flown, planned(name))
    for rule in every_rule():
        for end, ours, theirs in compared(name, flown, ends_of(flown, 3, seed), (rule,)):
            assert ours == pytest.approx(theirs, abs=LIKENESS), (rule.score.name, end)


@pytest.mark.slow
@pytest.mark.parametrize("name", EXERCISES)
def test_twenty_flights_have_the_debrief_s_marks_all_along(name: str) -> None:
    totals = set()
    for seed in range(20):
        flown = flight_of(name, seed)
        assert_judged_as_a_whole(flown, planned(name))
        for end, ours, theirs in compared(name, flown, ends_of(flown, 8, seed)):
            assert ours == pytest.approx(theirs, abs=LIKENESS), (seed, end)
            totals.add(round(ours, 3))

    assert len(totals) > 5


def test_boats_side_by_side_are_judged_as_each_alone() -> None:
    flights = [flight_of("first-depth-change", seed) for seed in (1, 2, 3)]
    together = TickJudge(planned("first-depth-change"), 3)
    nobody = nobody_in("first-depth-change")
    rows = np.array([rows_of(together, each) for each in flights])
    for index in range(3):
        together.begin(index, rows[index, 0], nobody)
    together.look(rows[:, 1:400])
    resting = np.array([True, False, True])

    totals = together.look(rows[:, 400:], resting)

    alone = [list(compared("first-depth-change", each, [1200]))[-1][1] for each in flights]
    assert totals[[0, 2]].tolist() == [alone[0], alone[2]]
    assert math.isnan(totals[1])
    together.begin(1, rows[1, 0], nobody)
    assert together.look(rows[:, 1:], ~resting)[1] == alone[1]


@pytest.mark.parametrize(
    ("name", "field", "value", "seconds", "most"),
    [
        ("first-depth-change", "theta", math.radians(16.0), 20.0, 99.0),
        ("depth-changes", "z", 106.0, 1.5, 100.0),  # too short to cost
        ("depth-changes", "z", 110.0, 40.0, 92.0),
        ("rise-jam-shallow", "u", 1.0, 2.0, 25.0),  # less than 6 kn before 90 s loses it
    ],
)
def test_a_broken_limit_and_a_loss_leave_what_the_debrief_leaves(
    name: str, field: str, value: float, seconds: float, most: float
) -> None:
    plan = planned(name)
    flown = fly_rehearsal(plan, plan.crew).trajectory
    broken = flown.columns[field].copy()
    broken[150 : 150 + round(2.0 * seconds)] = value
    flown = replace(flown, columns={**flown.columns, field: broken})

    *_, (_, ours, theirs) = compared(name, flown, [160, len(broken) - 1])

    assert ours == pytest.approx(theirs, abs=LIKENESS)
    assert 20.0 < ours <= most


def test_a_boat_that_turned_over_has_ended_without_marks() -> None:
    flown = flight_of("first-depth-change", 1)
    judge = TickJudge(planned("first-depth-change"))
    rows = rows_of(judge, flown)
    judge.begin(0, rows[0], {})
    assert judge.look(rows[None, 1:]) > 0.0
    assert not judge.ended[0]

    rows[-1, judge.reads.index("theta")] = math.radians(46.0)

    assert judge.look(rows[None, -1:]) == 0.0
    assert judge.ended[0]

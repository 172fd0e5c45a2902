"""What could still be earned at each moment of a run: laws of its curve, and of its witnesses."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, pairwise
from typing import Any

import pytest
from helpers.explored import by_crew, explored, late, plan_of, planted, with_fault
from helpers.sessions import start_plan

from trainer.boat.effects import effects_of_boat
from trainer.boat.mute_crew import MuteCrew, is_same_order
from trainer.config.files import shipped_names
from trainer.debrief.attainable.curve import attainable_curve, fly_points
from trainer.debrief.attainable.explorer import MAX_FINEST, RunExplorer, finest_period
from trainer.debrief.attainable.search import AttainablePoint, NoCurve
from trainer.debrief.attainable.words import until_words
from trainer.debrief.marks.rehearsal import Departure, fly, fly_rehearsal
from trainer.io.orders.grammar import Order, parse
from trainer.io.recording.facts import GiverKind

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")
STEP_S = 0.5  # [s] of the boats that fly here
WORTH = 3.0  # [%] of marks, up to which nothing is told
SHIPPED = shipped_names("exercises")
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


def slow(cases: Sequence[Any]) -> list[Any]:
    return [pytest.param(each, marks=pytest.mark.slow, id=f"all-{each}") for each in cases]


@pytest.mark.parametrize("name", ["stern-plane-jam", *slow(SHIPPED)])
def test_of_the_reference_crew_s_own_run_nothing_is_told(name: str) -> None:
    run = explored(name, by_crew(name))
    curve = attainable_curve(run)
    assert curve.changes == ()
    assert min(each.marks for each in curve.points) >= 97.0
    assert run.search.flown <= 3 * run.last


def assert_lawful(run: RunExplorer) -> None:
    """See that marks never rise, end where the run did, and are those of flights."""
    points = [run.points[tick] for tick in sorted(run.points)]
    assert points[-1].marks == run.judge(run.trajectory).total
    assert points[0].marks >= 97.0
    assert all(before.marks >= after.marks for before, after in pairwise(points))
    last_won = [each for each in points if each.won][-1:]
    falls = [a for a, b in pairwise(points) if a.marks - b.marks > WORTH]
    for point in (*last_won, *falls[:2]):
        assert marks_of_witness(run, point) == pytest.approx(point.marks, abs=1e-9)


def marks_of_witness(run: RunExplorer, point: AttainablePoint) -> float:
    """Return the marks of a witness written down as orders, given again from the start."""
    if point.since >= run.last:
        return run.judge(run.trajectory).total or 0.0
    flown = run.search.fly(run.at(point.since), point.way).trajectory
    crew = run.crew[0].giver
    orders: dict[int, list[Any]] = {}
    past = (each for given in run.recorded.values() for each in given)
    own = (each for each in flown.orders if each.accepted is not False)
    for each in (*(e for e in past if e.tick < point.since), *own):
        entry = replace(each, giver=crew) if each.giver.kind is GiverKind.REFERENCE else each
        orders.setdefault(entry.tick, []).append(entry)
    boat = run.plan.launch_boat()
    again, _ = fly(run.plan, Departure(0, boat.snapshot()), orders)
    return run.judge(again.trajectory).total or 0.0


@pytest.mark.parametrize("case", [PLANTED[1], PLANTED[2], *slow(PLANTED)])
def test_after_a_planted_order_the_curve_is_lawful(
    case: tuple[str, float | None, str, str],
) -> None:
    name, seconds, more, less = case
    if seconds is None:
        orders = by_crew(name).trajectory.orders
        seconds = next(each.tick * STEP_S for each in orders if each.text == less)
    run = explored(name, planted(name, seconds, more, less))
    fly_points(run)
    assert_lawful(run)


@pytest.mark.parametrize("fault", slow(FAULTS))
def test_after_a_fault_of_a_crew_the_curve_is_lawful(
    fault: tuple[str, str, str | None, float],
) -> None:
    run = explored(fault[0], with_fault(*fault))
    fly_points(run)
    assert_lawful(run)


@pytest.mark.parametrize("name", slow(SHIPPED))
@pytest.mark.parametrize("seconds", [20.0, 45.0])
def test_behind_a_late_crew_the_curve_is_lawful(name: str, seconds: float) -> None:
    run = explored(name, late(name, seconds))
    fly_points(run)
    assert_lawful(run)


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
    run = explored(name, planted(name, seconds, text, instead))
    fly_points(run)
    won = max(tick for tick, point in run.points.items() if point.won)
    assert won_s - 5.0 <= won * STEP_S <= won_s + 5.0


@pytest.mark.parametrize(
    ("name", "done", "back"),
    [
        ("port-bus-lost", "loads shed", "loads back"),
        ("fire-aft", "ventilation secure", "ventilation run"),
    ],
)
def test_an_order_and_its_undoing_before_the_first_task_cost_nothing(
    name: str, done: str, back: str
) -> None:
    flown = by_crew(name).trajectory.orders
    undone = replace(flown[-1], id=9001, tick=20, text=done, entry=None)
    orders: dict[int, list[Any]] = {}
    for each in (*flown, undone, replace(undone, id=9002, tick=40, text=back)):
        orders.setdefault(each.tick, []).append(each)
    boat = start_plan(plan_of(name))
    run, _ = fly(plan_of(name), Departure(0, boat.records.state.copy()), orders)
    assert attainable_curve(explored(name, run)).changes == ()


def test_where_an_undoing_has_served_by_now_it_is_left_so() -> None:
    run = explored("steering-jam", planted("steering-jam", 84.0, "bell ahead full"))
    own = run.judge(run.trajectory).total
    assert own
    assert all(run.point(tick).marks > own - 1.0 for tick in range(0, run.last, 40))


def test_a_debrief_flies_no_more_than_it_may_and_says_how_far_moments_are_apart(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    name = "stern-plane-jam"
    for last in (1_200, 4_000, 40_000, 200_000):
        assert last / finest_period(last, 0.5) <= MAX_FINEST
        assert finest_period(last, 0.5) == 2 or last > 8_000
    for module in ("curve", "causes"):
        monkeypatch.setattr(f"trainer.debrief.attainable.{module}.MAX_TICKS", 4_000)
    shares: list[float] = []
    run = explored(name, late(name, 15))
    run.progress = shares.append
    curve = attainable_curve(run)
    assert run.search.flown < 4_000 + 40 * run.last
    assert len(run.points) < 20
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert "long" not in until_words(curve, run.step)
    told = "The run is long: moments are 12 s apart."
    assert until_words(replace(curve, finest=24), run.step).endswith(told)


def test_nobody_aboard_loses_all_and_all_is_accounted_for() -> None:
    run = explored("hover-by-pump", fly_rehearsal(plan_of("hover-by-pump")))
    curve = attainable_curve(run)
    lost = curve.points[0].marks - curve.points[-1].marks
    assert -sum(each.marks for each in curve.changes) == pytest.approx(lost, abs=WORTH)


def test_an_order_on_the_same_control_answers_a_rule_that_is_due_and_no_other_does() -> None:
    """What follows in the chain may then come; what the rule wants is still wanted."""
    for text, answered in (("bell ahead full", True), ("rudder left 5", False)):
        run = explored(
            "stern-plane-jam", planted("stern-plane-jam", 72.0, text, "bell astern full")
        )
        crew = run.departures[2 * 80].crew
        assert crew is not None
        assert crew.answered is answered
        (rule,) = [e for e in crew.crew.followed if e.rule.order.text == "bell astern full"]
        assert (rule.given is not None) is answered


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


def test_a_mast_that_nobody_raised_is_not_up_and_its_order_is_overdue() -> None:
    plan = plan_of("crossing-traffic")
    boat = start_plan(plan)
    mute = MuteCrew(boat, plan.crew)
    for _ in range(60):
        mute.follow(())
        assert boat.tick() == 0
    assert "scope raise" in [each.rule.order.text for each in mute.pending(boat.time)]


def test_a_shift_under_way_stands_and_a_party_is_not_sent_anew() -> None:
    for name, seconds, text in (
        ("leaking-leg", 95.5, "stern planes emergency"),
        ("fire-aft", 118.0, "fight fire aft"),
    ):
        run = explored(name, by_crew(name))
        given = [e.tick for e in run.crew if e.text == text]
        moment = run.at(max(2 * round(seconds), given[0] + 2 - given[0] % 2))
        assert text not in run.search.ways(moment)[0].first


@pytest.mark.slow
def test_what_can_be_had_again_later_was_not_lost() -> None:
    """Hovering on again wins 13 s after it was switched off, and not in the seconds before."""
    run = explored("bottoming", planted("bottoming", 183.5, "hover off"))
    fly_points(run)
    assert max(tick for tick, each in run.points.items() if each.won) >= 2 * 196

"""The reference crew shows the way from a frozen moment, and the boat is back there afterwards."""

from contextlib import closing
from dataclasses import replace
from typing import Any

import pytest
from helpers.crewed import Begin, Crewed
from helpers.evaluating import evaluate_here
from helpers.sessions import start_plan

from trainer.boat.depths import lowest_depth
from trainer.boat.due_orders import entries_due
from trainer.boat.mute_crew import MuteCrew
from trainer.debrief.marks.rehearsal import Departure, fly, fly_rehearsal
from trainer.io.recording.facts import NO_CREW_FACT, SCHEDULE_GIVER, BranchCause, GiverKind
from trainer.io.recording.recording import RecordedOrder, Recording, RecordingError
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")

JAMMED = 160  # [tick] some seconds after the stern planes have jammed
SHOWN_TICKS = 60


def planned(exercise: str | None) -> Plan:
    """Return the plan of a shipped exercise, or of free sailing."""
    return plan_run(RunOptions(exercise=exercise, given=frozenset({"exercise"})))


@pytest.fixture
def crewed(crewed: Begin, monkeypatch: pytest.MonkeyPatch) -> Begin:
    """Return what begins sessions whose runs are evaluated."""

    def begin(**words: Any) -> Crewed:
        ship = crewed(**words)
        evaluate_here(ship, monkeypatch, words["plan"])
        return ship

    return begin


@pytest.fixture
def jam(crewed: Begin) -> Crewed:
    """Return the jam, frozen where nobody has answered it yet."""
    ship = crewed(plan=planned("stern-plane-jam"), seconds=600.0)
    ship.fly(JAMMED)
    ship.order("freeze")
    return ship


def order_of_schedule(plan: Plan, place: int, tick: int) -> RecordedOrder:
    """Return a scheduled order as a recording has it."""
    text = plan.schedule[place].order.text
    return RecordedOrder(
        place + 1, 1, tick, SCHEDULE_GIVER, text, place, accepted=True, answer="", crew=NO_CREW_FACT
    )


def shows(ship: Crewed, words: str = "demonstrate for 30 s") -> None:
    """Have the way shown: wait until the crew is aboard."""
    ship.order(words)
    ship.settle(lambda: ship.session.dispatch.way.origin is not None)


def test_the_way_is_shown_on_a_branch_of_its_own_and_the_boat_is_back_frozen(jam: Crewed) -> None:
    helm = jam.comes("helm")
    before, orders = jam.boat.snapshot().tobytes(), jam.session.history.said()

    shows(jam)
    assert not jam.session.time.frozen
    jam.fly(SHOWN_TICKS + 5)

    assert jam.session.time.frozen
    assert jam.boat.snapshot().tobytes() == before
    assert jam.session.history.said() == orders
    assert "shown: bell astern full" in jam.events(helm, "shown")
    assert "bow planes rise 30" in jam.facts(helm, "shown")
    assert jam.facts(helm, "back") == ["demonstrate off"]
    first, shown, after = jam.recording.branches()
    assert (shown.cause, shown.parent, shown.tick) == (BranchCause.SHOWN, first.id, JAMMED)
    assert (after.cause, after.parent, after.tick) == (BranchCause.JUMP, first.id, JAMMED)
    assert jam.recording.last_tick(shown.id) == JAMMED + SHOWN_TICKS
    given = [each for each in jam.recording.orders(shown.id) if each.branch == shown.id]
    crew = [each.text for each in given if each.giver.kind is GiverKind.REFERENCE]
    assert crew[:2] == ["bell astern full", "bow planes rise 30"]
    assert all(each.accepted for each in given)


def test_what_is_shown_is_what_the_debrief_would_have_the_crew_do_from_there(jam: Crewed) -> None:
    plan = planned("stern-plane-jam")
    boat = start_plan(plan)
    due = {
        tick: [order_of_schedule(plan, place, tick) for place in places]
        for tick, places in entries_due(boat, plan.schedule).items()
    }
    start = Departure(0, boat.snapshot(), (), MuteCrew(boat, plan.crew))
    last = JAMMED + SHOWN_TICKS
    _, there = fly(plan, start, due, speaks_from=JAMMED, until=last)

    shows(jam)
    jam.fly(SHOWN_TICKS + 5)

    flown = jam.recording.state_at(2, last)
    assert flown == there.state.tobytes()


def test_the_crew_does_not_order_again_what_somebody_has_ordered(jam: Crewed) -> None:
    jam.order("bell astern full")
    jam.order("bow planes rise 30")
    jam.fly(30)
    jam.order("freeze")

    shows(jam)
    jam.fly(SHOWN_TICKS + 5)

    given = jam.facts(jam.instructor, "shown")
    assert "bell ahead two-thirds" in given
    assert not {"bell astern full", "bow planes rise 30"} & set(given)


def test_while_the_way_is_shown_nobody_else_moves_the_boat_or_time_but_to_stop_it(
    jam: Crewed,
) -> None:
    shows(jam)
    jam.fly(5)
    barred = "the reference crew shows the way: demonstrate off ends it"
    words = ("rudder left 5", "backtrack 5 s", "replay 5 s", "snapshot here-i-am", "again")
    for order in (*words, "end exercise", "order depth 90", "ghost on", "demonstrate"):
        assert jam.refused(order) == barred, order
    assert jam.order("freeze") == "frozen"
    assert jam.refused("what if rudder left 5") == barred
    assert jam.order("status") == ""
    jam.order("run")
    assert jam.order("demonstrate off") == "back"
    assert jam.session.time.frozen
    assert jam.boat.ticks == JAMMED
    assert jam.refused("demonstrate off") == "the way is not being shown"


def test_what_is_shown_is_not_evaluated(jam: Crewed, monkeypatch: pytest.MonkeyPatch) -> None:
    evaluation = jam.session.evaluation
    woken: list[int] = []
    monkeypatch.setattr(evaluation, "why_none", None)
    monkeypatch.setattr(evaluation, "_wake", lambda: woken.append(jam.recording.branch))
    shows(jam)
    jam.fly(SHOWN_TICKS + 5)
    assert set(woken) <= {1, 3}
    jam.fly(30)
    assert 3 in woken


def test_the_crew_never_goes_on_from_what_was_shown(jam: Crewed) -> None:
    shows(jam)
    jam.fly(SHOWN_TICKS + 5)
    assert "counts for no mark" in jam.refused("branch 2")
    listed = [str(each) for each in jam.session.history.branches()]
    assert "demonstrate for 30 s, by instructor" in listed[1]


def test_it_is_told_why_the_way_cannot_be_shown_now(jam: Crewed) -> None:
    helm, trainee = jam.comes("helm"), jam.comes("trainee")
    assert jam.refused("demonstrate for 0") == "0 s: a time to be shown is 1 to 3600 s"
    assert "is the instructor's" in jam.refused("demonstrate", helm)
    assert jam.refused("demonstrate", trainee).startswith("an instructor is here")
    jam.order("run")
    assert jam.refused("demonstrate").startswith("time runs: freeze first")
    jam.order("replay 5 s")
    assert jam.refused("demonstrate") == "a replay is running: take over first"
    jam.order("take over")
    jam.order("freeze")
    jam.order("demonstrate")
    assert jam.refused("demonstrate") == "the reference crew is coming aboard already"
    jam.settle(lambda: jam.session.dispatch.way.origin)
    jam.order("demonstrate off")
    jam.order("end exercise")
    assert jam.refused("demonstrate").startswith("the exercise is over")


@pytest.mark.parametrize("meanwhile", ["rudder left 5", "end exercise"])
def test_who_orders_while_the_crew_comes_aboard_is_told_that_nothing_is_shown(
    jam: Crewed, meanwhile: str
) -> None:
    jam.order("demonstrate")
    jam.order(meanwhile)
    jam.settle(lambda: not jam.session.dispatch.way.preparing)
    assert jam.session.dispatch.way.origin is None
    assert jam.events(jam.instructor, "shown")[-1].endswith("something was ordered meanwhile")


def test_what_is_shown_ends_with_the_exercise_and_never_ends_it(crewed: Begin) -> None:
    ship = crewed(plan=planned("stern-plane-jam"), seconds=85.0, lost=("depth > 106",))
    ship.fly(JAMMED)
    ship.order("freeze")
    shows(ship)
    ship.fly(100)
    assert ship.boat.ticks == JAMMED
    assert ship.recording.last_tick(2) == 170
    assert not ship.conduct.ending.over


LATE_S = 165.0  # [s] of a boat whose stern planes nobody has helped, and which goes down
TICKS_A_SECOND = 2


@pytest.mark.parametrize(
    ("lost", "seconds", "found"),
    [
        ((), 90.0, ""),
        (("depth > 200",), 90.0, ""),
        (("depth > 200",), 140.0, "loses: deeper than 200 m at 2:30.5;"),
        ((), LATE_S, "loses: deeper than 200 m at 2:30.5;"),
    ],
)
def test_a_way_that_loses_is_not_shown_and_it_is_told_what_was_found(
    crewed: Begin, lost: tuple[str, ...], seconds: float, found: str
) -> None:
    ship = crewed(plan=planned("stern-servo"), seconds=480.0, lost=lost)
    ship.fly(round(TICKS_A_SECOND * 85))
    ship.order("bow planes emergency")
    ship.fly(round(TICKS_A_SECOND * (seconds - 85)))
    ship.order("freeze")
    before = ship.boat.snapshot().tobytes()

    ship.order("demonstrate for 30 s")
    ship.settle(lambda: not ship.session.dispatch.way.preparing)

    told = ship.events(ship.instructor, "shown")[0]
    assert (ship.session.dispatch.way.origin is None) is bool(found)
    if found:
        assert told.startswith(f"the way is not shown: the best that was found from here {found}")
        assert ship.boat.snapshot().tobytes() == before
    else:
        ship.fly(SHOWN_TICKS + 5)
        assert ship.facts(ship.instructor, "shown")[0] == "stern planes emergency"


def test_a_session_that_ends_meanwhile_ends_on_the_crews_branch(jam: Crewed) -> None:
    shows(jam)
    jam.fly(10)
    jam.session.dispatch.way.end()
    assert (jam.recording.branch, jam.boat.ticks) == (3, JAMMED)


def test_a_way_that_ends_while_nothing_can_be_read_waits_and_ends_nobody(
    jam: Crewed, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise RecordingError("not readable now")

    shows(jam)
    with monkeypatch.context() as unreadable:
        unreadable.setattr(Recording, "fork", fail)
        jam.fly(SHOWN_TICKS + 5)
        assert jam.session.time.frozen
        assert jam.boat.ticks == JAMMED + SHOWN_TICKS
        assert "not readable now; run tries it again" in jam.events(jam.instructor, "trouble")[-1]
        assert "not readable now" in jam.refused("demonstrate off")
    jam.order("run")
    jam.fly(2)
    assert (jam.recording.branch, jam.boat.ticks, jam.session.time.frozen) == (3, JAMMED, True)


def test_a_recording_that_was_cut_short_goes_on_where_the_crew_was(jam: Crewed) -> None:
    shows(jam)
    jam.fly(10)
    path = jam.conduct.marks.kept
    assert path
    jam.recording.close()

    with closing(Recording.reopen(path)) as recording:
        recording.leave_shown()
        latest = recording.latest()

    assert (latest.branch, latest.tick) == (3, JAMMED)


def test_a_way_past_test_depth_is_not_shown(crewed: Begin) -> None:
    """The jam takes the boat some metres deeper: here that is past test depth."""
    plan = planned("stern-plane-jam")
    file = plan.launch_boat().file
    columns = fly_rehearsal(plan).trajectory.columns
    here = lowest_depth(columns["z"][JAMMED], columns["theta"][JAMMED], file.hull.length)
    hull = replace(file.hull, test_depth_m=float(here) + 0.5)
    ship = crewed(plan=replace(plan, file=replace(plan.file, hull=hull)), seconds=600.0)
    ship.fly(JAMMED)
    ship.order("freeze")
    ship.order("demonstrate for 30 s")
    ship.settle(lambda: not ship.session.dispatch.way.preparing)
    told = ship.events(ship.instructor, "shown")[0]
    assert "the best that was found from here goes past test depth, " in told

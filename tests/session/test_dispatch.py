"""The road of an order: one table of order words, and gates in one order."""

import sqlite3
from collections.abc import Callable
from contextlib import closing

import pytest
from helpers.crewed import Begin, Crewed
from helpers.orders import read_order
from helpers.places import ROOT

from trainer.io.orders.schedule import ScheduledOrder
from trainer.io.orders.words import BOAT_ORDERS, CREW_TALK, ORDER_WORDS, Obeyer
from trainer.session.dispatch import ORDER_GATES, Gate, refusal
from trainer.session.stations.station import Station


@pytest.mark.parametrize("words", ["mark", "status", "who", "end exercise", "again"])
def test_a_schedule_goes_on_past_what_has_no_place_in_it(crewed: Begin, words: str) -> None:
    orders = [read_order(text) for text in (words, "rudder right 10")]
    ship = crewed(seconds=5, schedule=[ScheduledOrder(1.0, order, 1) for order in orders])
    ship.fly(10)
    assert ship.session.dispatch.refused == [
        f"1 s: {words}: refused: {words} has no place in a schedule"
    ]
    assert ship.session.history.entry == 2


def test_no_schedule_is_read_that_holds_what_nobody_may_schedule() -> None:
    unheard = [word for word in ORDER_WORDS.values() if not word.passed_on]
    assert unheard
    assert not [word.name for word in unheard if word.scheduled]


def test_whatever_is_not_passed_on_has_somebody_who_answers_it(crewed: Begin) -> None:
    duties = crewed().session.dispatch.duties
    answered = {word for word, row in ORDER_WORDS.items() if not row.passed_on}
    assert answered - set(duties) == {
        w for w, row in ORDER_WORDS.items() if row.obeyer is Obeyer.LINE
    }
    assert set(duties) <= answered


def test_what_moves_the_boat_or_is_said_on_board_is_journalled() -> None:
    journalled = {word for word, row in ORDER_WORDS.items() if row.journalled}
    assert journalled == BOAT_ORDERS | CREW_TALK | {
        *("plan", "cancel", "ghost", "predictor", "role"),
    }


def shut(ship: Crewed, words: str, station: Station) -> list[Gate]:
    """Return all gates that are shut to an order."""
    order = read_order(words)
    return [gate for gate in ORDER_GATES if gate(order, station, ship.session)]


Prepared = tuple[str, Station, Callable[[], object]]  # words, who gives them, what comes before


@pytest.mark.parametrize("gate", ORDER_GATES, ids=lambda gate: gate.__name__)
def test_each_gate_is_shut_to_what_it_is_there_for_and_to_nothing_else(
    gate: Gate, crewed: Begin
) -> None:
    ship = crewed(seconds=None, hand=frozenset({"planes"}))
    roles = ("pilot", "instructor", "visitor", "trainee")
    helm, second, visitor, trainee = (ship.comes(role) for role in roles)
    at = {each.line: each for each in ship.session.event_log.stations}
    ship.order("status")  # the first instructor has command
    prepared: dict[str, Prepared] = {
        "command_gate": ("run", at[second], lambda: None),
        "quit_gate": ("quit", at[ship.instructor], lambda: None),
        "visitor_gate": ("restart", at[visitor], lambda: None),
        "trainee_gate": ("freeze", at[trainee], lambda: None),
        "lost_gate": (
            "step",
            at[ship.instructor],
            lambda: setattr(ship.session.control, "failure", "u"),
        ),
        "end_gate": ("rudder left 5", at[helm], lambda: ship.order("end exercise")),
        "frozen_gate": ("what if rudder left 5", at[ship.instructor], lambda: None),
        "chair_gate": ("role planes", at[helm], lambda: None),
        "hand_gate": ("depth 80", at[helm], lambda: None),
        "replay_gate": ("rudder left 5", at[helm], lambda: ship.order("replay 2 s")),
    }
    words, station, prepare = prepared[gate.__name__]
    ship.fly(8)
    prepare()
    assert shut(ship, words, station) == [gate]
    assert shut(ship, "status", station) == []


def test_of_two_gates_that_are_shut_the_first_one_answers(ship: Crewed) -> None:
    second = ship.comes("instructor")
    ship.order("end exercise")
    station = next(each for each in ship.session.event_log.stations if each.line is second)

    answers = [gate(read_order("run"), station, ship.session) for gate in ORDER_GATES]
    reasons = list(filter(None, answers))
    assert len(reasons) == 2
    found = refusal(read_order("run"), station, ship.session)
    assert found is not None
    assert found == reasons[0]
    assert "has command" in found.reason


def test_a_refused_way_back_leaves_the_end_of_an_exercise_as_it_is(drill: Crewed) -> None:
    drill.fly(20)
    over = drill.conduct.ending.over
    assert over
    assert "no snapshot nowhere" in drill.refused("restore nowhere")
    assert drill.conduct.ending.over == over


def test_a_question_about_a_past_that_cannot_be_read_is_refused_and_the_session_goes_on(
    ship: Crewed, monkeypatch: pytest.MonkeyPatch
) -> None:
    ship.fly(10)
    ship.order("snapshot a")
    with monkeypatch.context() as broken, closing(sqlite3.connect(":memory:")) as empty:
        broken.setattr(ship.recording, "_connection", empty)
        for words in (
            *("branches", "snapshots", "snapshot b", "restore a", "branch 1", "backtrack 1 s"),
            *("again", "replay 1 s"),
        ):
            assert "cannot be read" in ship.refused(words)

    assert "branch 1" in ship.order("branches") + str(ship.said)
    ship.fly(10)
    assert ship.boat.ticks == 20


def test_a_session_has_few_attributes_and_few_lines(crewed: Begin) -> None:
    source = (ROOT / "trainer" / "session" / "session.py").read_text(encoding="utf-8")
    assert len(source.splitlines()) <= 280
    assert len(vars(crewed().session)) <= 20

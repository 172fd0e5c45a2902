"""The orders that are ahead: planned, told to the instructor alone, come, taken away."""

from contextlib import closing

import pytest
from helpers.crewed import PLACE, Begin, Crewed
from helpers.line import Line, fields_of

from trainer.config.exercise.derived import compile_condition
from trainer.config.exercise.exercise import ConditionalCasualty
from trainer.core.casualties import KINDS
from trainer.io.orders.grammar import Order, parse
from trainer.io.orders.schedule import ScheduledOrder, parse_schedule
from trainer.io.recording.facts import Giver, GiverKind
from trainer.io.recording.recording import Recording
from trainer.session.crew.agenda import Agenda, Plans
from trainer.session.crew.crew import CrewTalk
from trainer.session.crew.manning import HandWork
from trainer.session.crew.orders_in_force import OrdersInForce
from trainer.session.stations.roles import ROLES

CAPTAIN = Giver(GiverKind.STATION, "instructor", "instructor at a desk")


def broken(ship: Crewed) -> list[str]:
    """Return the casualties that the boat suffers."""
    return [KINDS[int(code) - 1] for code in ship.boat.state.casualty if code]


def planned(ship: Crewed, line: Line | None = None) -> list[str]:
    """Return the list of what is ahead as a program has it now."""
    told = [fields[2:4] for fields in fields_of((line or ship.instructor).sent, "TRF")]
    begins = max(at for at, (what, _) in enumerate(told) if what == "plans")
    count = int(told[begins][1])
    return [subject for what, subject in told[begins + 1 :] if what == "planned"][:count]


def scheduled(text: str) -> list[ScheduledOrder]:
    """Return the orders of a schedule."""
    made = parse_schedule(text, "test")
    assert isinstance(made, list)
    return made


def test_a_casualty_comes_at_its_time_and_so_long_from_now(ship: Crewed) -> None:
    ship.fly(4)
    assert ship.order("at 5 rudder left 5") == "planned: 1: at 00:00:05: rudder left 5"
    assert (
        ship.order("in 6 s casualty rudder-stuck")
        == "planned: 2: at 00:00:08: casualty rudder-stuck"
    )
    assert planned(ship) == ["1,5.000,rudder left 5", "2,8.000,casualty rudder-stuck"]

    ship.fly(6)
    assert not ship.boat.state.rudder_by_hand
    ship.fly(1)  # an order acts on the first tick not before its time
    assert ship.boat.state.rudder_by_hand
    assert planned(ship) == ["2,8.000,casualty rudder-stuck"]
    ship.fly(5)
    assert broken(ship) == []
    ship.fly(1)
    assert broken(ship) == ["rudder-stuck"]
    assert planned(ship) == []
    assert ship.facts(ship.instructor, "order")[-1] == "casualty rudder-stuck"
    assert "2: at 00:00:08: casualty rudder-stuck" in ship.events(ship.instructor, "exercise")[-1]


def test_an_order_waits_for_a_condition(ship: Crewed) -> None:
    ship.order("when depth >= 62 m then casualty bow-stuck")
    ship.order("when depth > 64 then freeze")
    assert planned(ship)[0] == "1,depth >= 62 m,casualty bow-stuck"
    ship.order("depth 90")
    while ship.boat.state.z < 62.0:
        assert broken(ship) == []
        ship.fly(1)
    ship.fly(1)
    assert broken(ship) == ["bow-stuck"]
    ship.fly(200)
    assert ship.session.time.frozen
    assert ship.boat.ticks < 200
    assert ship.boat.state.z > 64.0
    assert planned(ship) == []


def test_a_plan_is_taken_away_by_its_number(crewed: Begin) -> None:
    ship = crewed(seconds=None, schedule=scheduled("100 depth 80"))
    ship.order("in 2 casualty rudder-stuck")
    ship.order("in 2 depth 70")
    ship.order("in 2 course 090")
    assert ship.order("cancel 2").startswith("cancelled: 2: at 00:00:02: depth 70")
    assert planned(ship) == [
        *("1,2.000,casualty rudder-stuck", "3,2.000,course 090", ",100.000,depth 80 m"),
    ]
    assert ship.refused("cancel 2") == "no such plan of an instructor's; there is 1, 3"
    ship.order("cancel all")
    ship.fly(10)
    assert broken(ship) == []
    assert ship.boat.state.ordered_depth == 60.0
    assert planned(ship) == [",100.000,depth 80 m"]
    assert ship.refused("cancel all").endswith("there is none")


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("in 5 casualty ruder-stuck", "no casualty 'ruder-stuck'"),
        ("in 5 casualty stern-hard-over 9", "severity 9"),
        ("when depht > 60 then depth 70", "no quantity 'depht'"),
        ("when depth then depth 70", "write it as depth > 100"),
        ("at 1 depth 80", "00:00:01 is past: it is 00:00:02"),
        ("in 5 quit", "quit cannot be planned"),
        ("in 5 in 6 depth 70", "cannot be planned"),
        ("in 5 role helm word", "role helm cannot be planned"),
        ("at noon depth 80", "expected a time"),
        ("when depth > 60 casualty rudder-stuck", "expected then"),
    ],
)
def test_a_plan_that_cannot_come_is_refused_at_once(ship: Crewed, words: str, why: str) -> None:
    ship.fly(4)
    assert why in ship.refused(words)
    assert planned(ship) == []
    assert "word" not in "".join(ship.instructor.sent).replace("words", "") or "word" not in words


def test_a_replay_gives_what_came_and_waits_for_the_rest(ship: Crewed) -> None:
    ship.order("at 3 casualty rudder-stuck")
    ship.order("at 30 depth 70")
    ship.fly(16)
    state = ship.boat.records.state.tobytes()
    ship.order("replay 8 s")
    assert "replay is running" in ship.refused("in 5 depth 80")
    for _ in range(40):
        if ship.session.history.flown.replaying:
            ship.fly(1)
    assert ship.boat.records.state.tobytes() == state
    assert "the same to the last bit" in ship.events(ship.instructor, "moment")[-1]
    assert planned(ship) == ["2,30.000,depth 70 m"]


def test_the_exercise_s_own_events_are_told_to_the_instructor_alone(crewed: Begin) -> None:
    first = crewed()
    casualty = first.boat.casualties["rudder-stuck"]
    waits = [
        ConditionalCasualty(
            condition=compile_condition(text, PLACE), casualty=casualty, rule="once"
        )
        for text in ("depth > 61", "time > 400 s")
    ]
    ship = crewed(seconds=None, schedule=scheduled("5 order depth 80"), armed=waits)
    others = [ship.comes(role) for role in ROLES if role != "instructor"]
    ship.order("in 3 casualty bow-stuck")
    second = ship.comes("instructor")
    ahead = [
        *("1,3.000,casualty bow-stuck", ",5.000,order depth 80 m"),
        *(",400.000,casualty rudder-stuck", ",depth > 61,casualty rudder-stuck"),
    ]
    assert planned(ship, second) == planned(ship) == ahead
    assert ship.order("plans") == ""
    assert ship.said[-1] == "exercise: when deeper than 61 m: casualty rudder-stuck"

    ship.order("depth 90")
    while ship.boat.state.z < 61.0:
        ship.fly(1)
    ship.fly(2)
    assert planned(ship) == [",400.000,casualty rudder-stuck"]
    for line in others:
        assert ship.say(line, "plans")[0] == "no"
        assert ship.say(line, "in 5 casualty bow-stuck")[0] == "no"
        assert not any(
            "planned" in each or "stuck" in each for each in line.sent if "TRA" not in each
        )


def test_an_answer_is_in_the_file_before_it_goes_out(ship: Crewed) -> None:
    ship.fly(4)
    ship.order("at 60 depth 70")
    ship.refused("at 1 emergency blow")
    ship.refused("speed 50 kn")
    assert ship.conduct.past.kept
    with closing(Recording.look(ship.conduct.past.kept)) as reader:
        answers = [(each.text, each.accepted) for each in reader.orders(1)]
    assert answers[-3:] == [
        ("at 60 s depth 70 m", True),
        ("at 1 s emergency blow", False),
        ("speed 50 kn", False),
    ]


def test_a_plan_that_was_refused_is_none_after_a_replay_or_by_the_journal_alone(
    ship: Crewed,
) -> None:
    ship.fly(4)
    ship.order("at 60 depth 70")
    ship.refused("at 1 emergency blow")
    ship.fly(6)
    ship.order("replay 4 s")
    while ship.session.history.flown.replaying:
        ship.fly(1)
        assert planned(ship) in ([], ["1,60.000,depth 70 m"])
    assert planned(ship) == ["1,60.000,depth 70 m"]
    assert ship.session.agenda.plans == by_journal(ship)


def test_a_plan_that_its_time_has_refused_is_over_by_the_journal_too(crewed: Begin) -> None:
    ship = crewed(seconds=None, hand=frozenset(("planes",)))
    assert ship.order("in 2 depth 70").startswith("planned")
    ship.fly(8)
    assert "refused" in ship.events(ship.instructor, "exercise")[-1]
    assert planned(ship) == []
    assert by_journal(ship).planned == ()


def test_what_nobody_was_answered_before_a_kill_is_asked_again(ship: Crewed) -> None:
    ship.fly(4)
    history = ship.session.history
    for text in ("at 1 emergency blow", "at 60 depth 70", "tell helm steady"):
        order = parse(text)
        assert isinstance(order, Order)
        history.order(CAPTAIN, order)
    history.unanswered += ship.recording.orders(1)[-3:]
    ship.session.dispatch.answer_left_orders()
    assert [each.accepted for each in ship.recording.orders(1)[-3:]] == [False, True, True]
    assert [each.order.text for each in ship.session.agenda.planned.values()] == ["depth 70 m"]
    assert ship.session.agenda.plans == by_journal(ship)


def by_journal(ship: Crewed) -> Plans:
    """Return the plans as another process would read them from the recording."""
    session = ship.session
    agenda = Agenda(session.boat)
    crew = CrewTalk(session.boat, HandWork(session.boat))
    afresh = OrdersInForce(crew, agenda, session.history)
    afresh.read_journal()
    afresh.put_back_plans()
    return agenda.plans


def test_a_jump_to_an_order_that_a_page_journalled_has_its_plans(ship: Crewed) -> None:
    ship.order("at 60 depth 70")
    hint = parse("hint")
    assert isinstance(hint, Order)
    history = ship.session.history
    history.answered(history.order(CAPTAIN, hint), "hint, 2 marks: depth 80")
    ship.order("snapshot told")
    ship.order("cancel 1")
    assert planned(ship) == []
    ship.order("restore told")
    assert planned(ship) == ["1,60.000,depth 70 m"]
    assert ship.session.agenda.plans == by_journal(ship)

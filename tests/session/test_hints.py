"""A hint tells what the reference crew would have ordered by now, and costs marks."""

import re
from contextlib import closing
from dataclasses import replace
from typing import Any

import pytest
from helpers.crewed import Begin, Crewed
from helpers.evaluating import evaluate_here
from helpers.line import Line

from trainer.config.exercise.reference_crew import Crew
from trainer.debrief.live.advice import COMPARE_TEXT
from trainer.io.orders.sentences import order_sentence, parse_sentence
from trainer.io.orders.words import CREW_ROLES
from trainer.io.recording.recording import Recording
from trainer.session.exercise import evaluation
from trainer.session.exercise.hints import NO_MORE_TEXT, NOTHING_TEXT
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")

JAMMED = 160  # [tick] some seconds after the stern planes have jammed
TOLD = (
    "hint, 5 marks: bell astern full and bow planes rise 30, due since 00:01:11, "
    "for the gauges show stern < -4: 85 marks lost by waiting 30 s more"
)


def planned(exercise: str | None) -> Plan:
    return plan_run(RunOptions(exercise=exercise, given=frozenset({"exercise"})))


def trainee(ship: Crewed) -> Line:
    """Return the line of who trains, alone from now on."""
    if not ship.instructor.ended:
        ship.leaves(ship.instructor)
    return ship.comes("trainee")


@pytest.fixture
def crewed(crewed: Begin, monkeypatch: pytest.MonkeyPatch) -> Begin:
    """Return what begins sessions whose runs are evaluated."""

    def begin(**words: Any) -> Crewed:
        ship = crewed(**words)
        if words["plan"].crew.rules:
            evaluate_here(ship, monkeypatch, words["plan"])
        return ship

    return begin


@pytest.fixture
def jam(crewed: Begin) -> Crewed:
    """Return the jam where nobody has answered it yet."""
    ship = crewed(plan=planned("stern-plane-jam"), seconds=600.0)
    ship.fly(JAMMED)
    return ship


@pytest.fixture
def line(jam: Crewed) -> Line:
    return trainee(jam)


def asks(ship: Crewed, line: Line, words: str = "hint") -> tuple[str, str]:
    """Ask for a hint as a program; wait for the answer, and return it."""
    before = len(line.sent)
    line.waiting = [order_sentence(words, "8")]
    ship.session.attendance.listen()

    def answers() -> list[tuple[str, ...]]:
        told = [parse_sentence(each) for each in line.sent[before:]]
        return [each.fields for each in told if each and each.tag == "8"]

    ship.settle(answers)
    ((kind, text),) = answers()
    return kind, text


def told_in(ship: Crewed, branch: int) -> list[tuple[int, str]]:
    """Return the hints that the recording has on a branch, with their ticks."""
    ship.recording.flush()
    return [
        (each.tick, each.answer) for each in ship.recording.orders(branch) if each.text == "hint"
    ]


def test_a_hint_tells_the_overdue_order_and_why_while_time_runs_and_is_recorded(
    line: Line, jam: Crewed
) -> None:
    assert not jam.session.time.frozen
    assert asks(jam, line) == ("ok", TOLD)
    assert told_in(jam, 1) == [(JAMMED, TOLD)]
    assert asks(jam, line) == ("ok", f"{TOLD} (told before: no marks more)")
    assert told_in(jam, 1) == [(JAMMED, TOLD)]
    kept = jam.conduct.marks.kept
    assert kept
    with closing(Recording.look(kept)) as recording:
        events = [each for each in recording.events() if each.text == TOLD]
    assert [(each.tick, each.kind) for each in events] == [(JAMMED, "shown")]


def test_what_is_ordered_meanwhile_is_overdue_no_more(line: Line, jam: Crewed) -> None:
    jam.say(line, "bell astern full")
    jam.fly(4)
    assert asks(jam, line)[1].startswith("hint, 5 marks: bow planes rise 30, due since")
    jam.say(line, "bow planes rise 30")
    jam.fly(2)
    assert asks(jam, line) == ("ok", NOTHING_TEXT)
    assert len(told_in(jam, 1)) == 1


def test_after_the_wrong_surface_the_hint_is_the_right_one(crewed: Begin) -> None:
    ship = crewed(plan=planned("leaking-leg"), seconds=600.0)
    line = trainee(ship)
    ship.fly(190)
    ship.say(line, "bow planes emergency")
    ship.fly(20)
    assert asks(ship, line)[1].startswith("hint, 5 marks: stern planes emergency, due since")


def test_what_is_undone_is_due_again_and_the_hint_says_why(line: Line, jam: Crewed) -> None:
    for order in ("bell astern full", "bow planes rise 30"):
        jam.say(line, order)
        jam.fly(4)
    jam.say(line, "bell ahead full")
    jam.fly(4)
    undone = "hint, 5 marks: bell astern full, which was ordered and does not stand: 6"
    assert asks(jam, line)[1].startswith(undone)


def test_where_no_order_is_due_a_hint_is_what_the_hands_would_steer(crewed: Begin) -> None:
    ship = crewed(plan=planned("first-depth-change"), seconds=600.0)
    line = trainee(ship)
    ship.fly(160)
    told = r"hint, 5 marks: (stern|bow) planes [a-z0-9 ]+, as its planesman would steer: \d+ marks "
    assert re.match(told + "lost by waiting 30 s more", asks(ship, line)[1])
    ship.fly(900)
    assert asks(ship, line) == ("ok", NO_MORE_TEXT)


@pytest.mark.parametrize("casualty", ["depth-gauge-biased 0.4", "gyro-biased 0.5"])
def test_where_the_gauge_that_a_hand_steers_by_lies_no_order_of_it_is_sold(
    crewed: Begin, casualty: str
) -> None:
    ship = crewed(plan=planned("first-depth-change"), seconds=600.0)
    ship.fly(100)
    assert ship.say(ship.instructor, f"casualty {casualty}")[0] == "ok"
    line = trainee(ship)
    ship.fly(60)
    own = casualty.startswith("depth")
    told = asks(ship, line)[1]
    assert (told == f"hint, 5 marks: {COMPARE_TEXT}") is own
    assert ("as its planesman would steer" in told) is not own


def test_no_hint_is_of_an_order_that_is_not_due(crewed: Begin) -> None:
    ship = crewed(plan=planned("depth-gauge-failure"), seconds=1200.0)
    line = trainee(ship)
    for _ in range(5):
        ship.fly(60)
        told = asks(ship, line)[1]
        known = "due since" in told or "would steer" in told
        assert known or told in (NOTHING_TEXT, NO_MORE_TEXT, f"hint, 5 marks: {COMPARE_TEXT}"), told


def test_a_hint_stays_with_who_goes_back_before_it_and_not_with_a_run_from_the_start(
    line: Line, jam: Crewed
) -> None:
    asks(jam, line)
    jam.say(line, "freeze")
    assert jam.say(line, "backtrack 20 s")[0] == "ok"
    jam.fly(1)
    assert told_in(jam, 2) == [(JAMMED - 40, TOLD)]
    jam.say(line, "freeze")
    jam.say(line, "again")
    jam.fly(1)
    assert told_in(jam, 3) == []


def test_who_may_ask_and_when(line: Line, jam: Crewed) -> None:
    for role in CREW_ROLES:
        other = jam.comes(role)
        assert "hint" in jam.refused("hint", other)
        jam.leaves(other)
    instructor = jam.comes("instructor")
    assert jam.refused("hint", line).startswith("an instructor is here")
    helm = jam.comes("helm")
    assert asks(jam, instructor) == ("ok", TOLD)  # the crew hears it, too
    assert jam.events(helm, "shown") == [TOLD] == jam.events(line, "shown")
    jam.say(instructor, "end exercise")
    assert jam.refused("hint", instructor).startswith("the exercise is over")


@pytest.mark.parametrize("words", ["hint", "demonstrate"])
@pytest.mark.parametrize(
    ("exercise", "why"),
    [(None, "this free run has no reference crew"), ("visitor-dive", "this exercise has no refer")],
)
def test_without_a_reference_crew_nobody_hints_or_shows_the_way(
    crewed: Begin, exercise: str | None, why: str, words: str
) -> None:
    plan = replace(planned(exercise), crew=Crew())
    assert crewed(plan=plan, seconds=None).refused(words).startswith(why)


def test_in_a_lesson_the_hint_of_its_step_comes_at_once_and_costs_nothing(crewed: Begin) -> None:
    plan = planned("wheel-and-course")
    ship = crewed(plan=plan, seconds=None)
    line = trainee(ship)
    ship.fly(2)
    hint = plan.steps[0].row.hint
    assert ship.say(line, "hint") == ("ok", f"hint: {hint}")
    assert ship.facts(line, "step-hint") == [hint]
    assert told_in(ship, 1) == []


def test_a_process_that_dies_is_told_and_the_next_hint_is_asked(
    line: Line, jam: Crewed, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr(evaluation.EvaluatorProcess, "ask", lambda *_: None)
        told = "the evaluation's process has ended with 0: ask again"
        assert asks(jam, line) == ("no", told)
    assert asks(jam, line) == ("ok", TOLD)


def test_a_hint_of_a_moment_that_was_left_is_not_told(line: Line, jam: Crewed) -> None:
    line.waiting = [order_sentence("hint", "8"), order_sentence("hint", "9")]
    jam.session.attendance.listen()
    assert "a hint is being found already" in line.sent[-1]
    jam.say(line, "freeze")
    jam.say(line, "backtrack 5 s")
    jam.settle(lambda: not jam.conduct.hints.preparing)
    assert "time has gone elsewhere meanwhile: ask again" in line.sent[-1]
    assert told_in(jam, 1) == []

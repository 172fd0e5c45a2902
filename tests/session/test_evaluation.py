"""What a careful crew could still earn, told to the instructor while the run goes on."""

import threading
from collections.abc import Mapping, Sequence
from typing import Any

import pytest
from helpers.crewed import Begin, Crewed

from trainer.session.exercise import evaluation as module
from trainer.session.exercise.evaluation import Question
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run
from trainer.session.stations.roles import ROLES

ANSWER = {"marks": 82.0, "so_far": 14.0, "won": True, "lost": False}


class Answering:
    """A process that answers as the test says."""

    answer: Mapping[str, Any] | None = ANSWER
    begun = 0
    asked: list[Question]
    gate = threading.Event()

    def __init__(self, words: Sequence[str]) -> None:
        assert words[-1].endswith(".trainer")
        type(self).begun += 1

    def ask(self, question: Question) -> Mapping[str, Any] | None:
        type(self).gate.wait(30.0)
        type(self).asked.append(question)
        return type(self).answer

    def end(self) -> int:
        type(self).gate.set()
        return -9


@pytest.fixture
def ship(crewed: Begin, monkeypatch: pytest.MonkeyPatch) -> Crewed:
    """Return a session whose evaluation is by a process that the test plays."""
    Answering.answer, Answering.begun, Answering.asked = ANSWER, 0, []
    Answering.gate.set()
    monkeypatch.setattr(module, "EvaluatorProcess", Answering)
    aboard = crewed(seconds=600.0)
    aboard.session.evaluation.begin(("-m", "it"), aboard.conduct.marks.kept, plan_of("heavy-boat"))
    return aboard


def plan_of(name: str | None) -> Plan:
    return plan_run(RunOptions(exercise=name))


def settled(ship: Crewed, answers: int) -> None:
    ship.settle(lambda: len(ship.facts(ship.instructor, "attainable")) >= answers)


def test_the_instructor_alone_is_told_every_ten_seconds(ship: Crewed) -> None:
    crew = {role: ship.comes(role) for role in ROLES if role != "instructor"}
    for count, ticks in enumerate((1, 19, 20, 20), 1):
        ship.fly(ticks)
        settled(ship, count)
    told = ship.facts(ship.instructor, "attainable")
    assert [each.split(",")[1:] for each in told] == [["82.0", "14.0", "won", "1", "0"]] * len(told)
    times = [float(each.split(",")[0]) for each in told]
    assert times == [0.5, 10.0, 20.0, 30.0]
    for role, line in crew.items():
        assert not [each for each in line.sent if "attainable" in each or "82" in each], role
        assert ship.say(line, "status")[0] == "ok"
        assert not [each for each in ship.said if "earn" in each], role
        assert ship.say(line, "what if planes zero")[0] == "no", role
    ship.order("status")
    assert "could still earn 82 marks, 14 so far (at 00:00:30, branch 1)" in ship.said
    late = ship.comes("instructor")
    assert ship.facts(late, "attainable")[-1] == told[-1]


def test_a_tick_waits_for_nothing_and_what_is_left_out_is_counted(ship: Crewed) -> None:
    for count, ticks in enumerate((1, 19), 1):
        ship.fly(ticks)
        settled(ship, count)
    Answering.gate.clear()
    ship.fly(100)  # it would stand still if a tick waited
    assert ship.boat.ticks == 120
    behind = [each for each in ship.events(ship.instructor, "exercise") if "behind" in each]
    assert behind == ["the evaluation is behind: it leaves moments out"]
    Answering.gate.set()
    ship.settle(lambda: ship.facts(ship.instructor, "attainable")[-1].startswith("60.000"))
    left_out = int(ship.facts(ship.instructor, "attainable")[-1].split(",")[-1])
    assert left_out >= 3
    assert left_out + len(Answering.asked) == 7  # of ticks 1, 20, 40, ...
    assert "caught up" in ship.events(ship.instructor, "exercise")[-1]


def test_a_freeze_a_jump_and_an_order_in_a_freeze_are_evaluated_at_once(ship: Crewed) -> None:
    ship.fly(23)
    ship.order("freeze")
    ship.settle(lambda: [each.moment.tick for each in Answering.asked][-1:] == [23])
    ship.order("stern planes dive 5")
    ship.settle(lambda: Answering.asked[-1].moment.after > 0)
    ship.order("backtrack 5")
    ship.settle(lambda: Answering.asked[-1].moment.branch == 2)
    ship.settle(lambda: ship.facts(ship.instructor, "attainable")[-1].split(",")[4] == "2")


def test_a_replay_that_is_taken_over_is_evaluated_from_there_on(ship: Crewed) -> None:
    ship.fly(200)
    ship.order("replay 95 s")
    ship.fly(5)
    ship.order("take over")
    ship.fly(25)
    ship.order("time x1")  # not frozen, which would have it evaluated
    ship.settle(lambda: Answering.asked[-1].moment.branch == 2)
    assert Answering.asked[-1].moment.tick <= 40


def test_what_if_says_what_an_order_would_bring_and_changes_nothing(ship: Crewed) -> None:
    for count, ticks in enumerate((1, 19), 1):
        ship.fly(ticks)
        settled(ship, count)
    assert "first freeze" in ship.refused("what if planes zero")
    ship.order("freeze")
    Answering.answer = {**ANSWER, "marks": 64.0, "with": 82.0, "refused": ""}
    before = ship.boat.records.state.tobytes()
    sent = len(ship.instructor.sent)
    ship.instructor.waiting = ["what if stern planes dive 10"]
    answer = "with `stern planes dive 10` and no other for 30 s: 82, without: 64 (from 00:00:10)"
    ship.settle(lambda: answer in ship.instructor.sent[sent:])
    assert ship.boat.records.state.tobytes() == before
    assert Answering.asked[-1].order == "stern planes dive 10"
    kept = [each.text for each in ship.recording.events() if each.kind == "exercise"]
    assert f"what if: {answer}" in kept
    Answering.answer = {**ANSWER, "refused": "no such depth"}
    ship.instructor.waiting = ["what if depth 900"]
    ship.settle(lambda: any("depth 900 m: no such depth" in each for each in ship.instructor.sent))
    assert "only of orders that move the boat" in ship.refused("what if freeze")
    assert "no order" in ship.refused("what if banana")


def test_a_process_that_dies_is_told_and_begun_again_three_times(ship: Crewed) -> None:
    Answering.answer = None
    for count in range(1, 6):
        ship.fly(20)
        ship.settle(lambda: Answering.begun >= min(count, 3))  # noqa: B023
    ship.settle(lambda: ship.facts(ship.instructor, "no-attainable"))
    assert Answering.begun == 3
    told = ship.events(ship.instructor, "exercise")
    assert sum("has ended with -9; it begins again" in each for each in told) == 3
    assert told[-1] == "no evaluation: its process has ended 3 times"
    ship.fly(20)  # and the session goes on
    ship.order("freeze")
    assert "ended 3 times" in ship.refused("what if planes zero")


def test_a_branch_without_marks_is_told_once_and_the_next_one_is_evaluated(ship: Crewed) -> None:
    Answering.answer = {"free": "a free run has no marks"}
    ship.fly(1)
    ship.settle(lambda: ship.facts(ship.instructor, "no-attainable"))
    ship.fly(40)
    ship.order("status")
    assert "evaluation: a free run has no marks" in ship.said
    Answering.answer = ANSWER
    ship.order("freeze")
    ship.order("backtrack 10")
    ship.settle(lambda: ship.facts(ship.instructor, "attainable"))
    assert ship.facts(ship.instructor, "no-attainable") == ["a free run has no marks"]


def test_a_fall_of_the_marks_is_told_in_words_and_recorded(ship: Crewed) -> None:
    for count, ticks in enumerate((1, 19), 1):
        ship.fly(ticks)
        settled(ship, count)
    Answering.answer = {**ANSWER, "marks": 64.0}
    ship.fly(20)
    settled(ship, 3)
    fall = "00:00:20: 64 marks could still be earned, 18 less than at"
    assert [each for each in ship.events(ship.instructor, "exercise") if each.startswith(fall)]
    assert [each for each in ship.recording.events() if each.text.startswith(fall)]


def test_marks_that_are_not_for_what_the_instructor_ordered_say_so(ship: Crewed) -> None:
    for count, ticks in enumerate((1, 19), 1):
        ship.fly(ticks)
        settled(ship, count)
    Answering.answer = {**ANSWER, "marks": 31.0, "beyond": "order course left 330"}
    ship.fly(20)
    settled(ship, 3)
    told = ship.facts(ship.instructor, "attainable")
    assert told[-1] == "20.000,31.0,14.0,won,1,0,order course left 330"
    basis = "; for the exercise's own orders, not for `order course left 330`"
    (fall,) = [each for each in ship.events(ship.instructor, "exercise") if "31 marks" in each]
    assert fall.endswith(basis)
    ship.order("status")
    assert f"could still earn 31 marks, 14 so far (at 00:00:20, branch 1){basis}" in ship.said


@pytest.mark.parametrize(
    ("exercise", "kept", "why"),
    [
        (None, True, "the boat sails freely"),
        ("wheel-and-course", True, "this exercise has no reference crew"),
        ("heavy-boat", False, "this session is not recorded"),
    ],
)
def test_what_has_no_evaluation_says_so_in_a_line(
    crewed: Begin, exercise: str | None, *, kept: bool, why: str
) -> None:
    ship = crewed(seconds=None)
    path = ship.conduct.marks.kept if kept else None
    ship.session.evaluation.begin(("-m", "it"), path, plan_of(exercise))
    ship.order("freeze")
    assert ship.refused("what if planes zero") == f"no evaluation: {why}"
    ship.order("status")
    assert f"evaluation: {why}" in ship.said
    late = ship.comes("instructor")
    assert ship.facts(late, "no-attainable") == ([why] if exercise else [])

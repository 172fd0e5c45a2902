"""Each hint costs the marks that the exercise states, and a debrief tells of it."""

from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
from helpers.givers import giver_at
from helpers.recorded import record

from trainer.cli.run import debriefing
from trainer.config.exercise.outcome import Outcome
from trainer.debrief.marks.judgement import costs, judge_run
from trainer.debrief.marks.rehearsal import fly_rehearsal
from trainer.debrief.marks.scoring import Scorecard
from trainer.debrief.page import sections
from trainer.debrief.page.data import DebriefData, compare_debrief, gather_debrief
from trainer.debrief.passage.trajectory import Trajectory
from trainer.io.recording.recording import RecordedOrder, Recording
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import Plan, plan_run

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")
WHO = "trainee at line 1"
HELPFUL = {80.0: "bell astern full", 82.0: "bow planes rise 30"}
HINTED = {70.0: "hint", **HELPFUL}


def planned(exercise: str) -> Plan:
    return plan_run(RunOptions(exercise=exercise, given=frozenset({"exercise"})))


def hinted(trajectory: Trajectory, count: int, *, taken: bool = True) -> Trajectory:
    """Return a run in which so many hints were told."""
    hints = tuple(
        RecordedOrder(900 + n, 1, 10 + n, giver_at(WHO), "hint", None, taken, "hint, 5 marks: x")
        for n in range(count)
    )
    return replace(trajectory, orders=(*hints, *trajectory.orders))


def test_a_hint_takes_its_marks_off_before_a_win_and_before_a_cap() -> None:
    plan = planned("stern-plane-jam")
    run = fly_rehearsal(plan, plan.crew).trajectory
    without = judge_run(run, plan, {})
    assert without.total is not None
    assert without.verdict
    assert without.verdict.outcome is Outcome.WON

    def with_hints(count: int, plan: Plan = plan) -> Scorecard:
        return judge_run(hinted(run, count), plan, {})

    for count in (1, 3):
        card = with_hints(count)
        assert card.total == pytest.approx(without.total - 5.0 * count)
        (told,) = (each for each in costs(card, None) if each.told.startswith("Hints"))
        assert told.marks == pytest.approx(5.0 * count)
        assert told.told == f"Hints: it cost {5 * count} marks."
    lost = with_hints(12)
    assert lost.verdict
    assert lost.verdict.outcome is Outcome.NOT_REACHED
    assert with_hints(40).total == 0.0
    dear = replace(plan, hint_marks=30.0)
    assert with_hints(1, dear).total == pytest.approx(without.total - 30.0)
    refused = judge_run(hinted(run, 2, taken=False), plan, {})
    assert refused.total == without.total


def test_without_tasks_a_hint_takes_its_marks_off_the_mean() -> None:
    plan = planned("stern-plane-jam")
    rules = tuple(replace(each, score=replace(each.score, part=None)) for each in plan.scores)
    plan = replace(plan, scores=rules, hand=(), lost=())
    assert not plan.judged_by_tasks
    run = fly_rehearsal(plan, plan.crew).trajectory
    total = judge_run(run, plan, {}).total
    assert total is not None
    assert judge_run(hinted(run, 2), plan, {}).total == pytest.approx(total - 10.0)


def debriefed(path: Path) -> DebriefData:
    with closing(Recording.look(path)) as recording:
        return gather_debrief(recording, path, None)


def test_hints_stand_in_the_debrief_in_the_marks_told_live_and_are_no_answer(
    tmp_path: Path,
) -> None:
    plain = debriefed(record(tmp_path / "plain.trainer", "stern-plane-jam", HELPFUL, WHO))
    path = record(tmp_path / "run.trainer", "stern-plane-jam", HINTED, WHO)
    debrief = debriefed(path)

    assert debrief.aids == ("1 hint",)
    assert [each.order for each in debrief.casualties] == [
        replace(each.order, id=each.order.id + 1) for each in plain.casualties if each.order
    ]
    page = sections.verdict(debrief)
    assert "Flown with 1 hint." in page
    assert "At 1:10: noted: hint." in page
    assert ", less 5 for hints" in page
    assert plain.total is not None
    assert debrief.total == pytest.approx(max(plain.total - 5.0, 0.0))

    marks = debriefing().judge(path, 1)
    assert "with 1 hint" in str(marks)
    place = marks.reasons.index("noted: hint")
    assert marks.times[place] == 70.0


@pytest.mark.slow
@pytest.mark.usefixtures("few_points")
def test_a_hint_moves_nothing_in_what_could_still_be_earned(tmp_path: Path) -> None:
    plain = record(tmp_path / "plain.trainer", "stern-plane-jam", HELPFUL, WHO)
    path = record(tmp_path / "run.trainer", "stern-plane-jam", HINTED, WHO)
    before, curve = (compare_debrief(debriefed(each)).compared for each in (plain, path))
    assert before is not None
    assert before.curve is not None
    assert curve is not None
    assert curve.curve is not None
    causes = [(each.cause, each.order) for each in before.curve.changes]
    assert [(each.cause, each.order) for each in curve.curve.changes] == causes

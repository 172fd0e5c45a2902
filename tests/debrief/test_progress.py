"""What a trainee has done: kept, drawn, offered on, forgotten; and files that cannot be read."""

import csv
import json
import shlex
from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pytest
from helpers.recorded import record

from trainer.cli.main import main
from trainer.config.exercise.course import course, lessons
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import (
    Progress,
    ProgressRun,
    add_run,
    file_stem,
    progress_path,
    read_progress,
    trainees_folder,
)
from trainer.config.files import ConfigError
from trainer.debrief.attainable.changes import FaultKind, MarkChange
from trainer.debrief.page.page import read_dossier
from trainer.debrief.trainees.progress import costs_of, own_marks_of, remember_run
from trainer.debrief.trainees.progress_words import progress_lines
from trainer.session.past.header import names_of

pytestmark = [
    pytest.mark.filterwarnings("ignore::RuntimeWarning"),
    pytest.mark.usefixtures("few_points"),
]
ANN = "Ann O Briain"
LOST = ProgressRun(
    *("a.trainer", 1, "first-depth-change", "Depth, first steps", "2026-01-01T10:00:00"),
    *(600.0, Outcome.NOT_REACHED),
    total=40.0,
    costs={"late": 35.0, "trim": 5.0},
    standard_error=24.5,
    own_marks=62.0,
)
WON = replace(
    LOST,
    recording="b.trainer",
    started="2026-01-02",
    outcome=Outcome.WON,
    total=91.0,
    costs={},
    standard_error=None,
    own_marks=None,
)
LESSON = replace(
    WON, exercise="wheel-and-course", outcome=Outcome.DONE, total=None, recording="c.trainer"
)


@pytest.fixture(autouse=True)
def own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))


def told(capsys: pytest.CaptureFixture[str], *words: str, code: int = 0) -> str:
    """Return what a command prints, its complaint too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("sys.argv", ["trainer", *words])
        with pytest.raises(SystemExit) as ended:
            main()
    assert (ended.value.code or 0) == code
    return "".join(capsys.readouterr())


@pytest.mark.slow
def test_a_run_is_kept_with_its_marks_and_what_cost_most(tmp_path: Path) -> None:
    dive = {100.0: "stern planes dive 10"}
    path = record(tmp_path / "dive.trainer", "first-depth-change", dive, trainee=(ANN, "Bob"))
    assert remember_run(path, 1, Outcome.ENDED) == []
    assert remember_run(path, 1, Outcome.ENDED) == []  # the same run, once more
    for name in (ANN.upper(), "bob"):
        (run,) = read_progress(name).runs
        assert (run.exercise, run.outcome, run.recording) == (
            *("first-depth-change", "not reached", "dive.trainer"),
        )
        assert run.total is not None
        assert 90.0 < sum(run.costs.values()) < 110.0  # of the 100 that it had at its start
        assert max(run.costs, key=lambda kind: run.costs[kind]) == "overshoot"


def test_a_trainee_has_the_marks_of_the_tasks_that_this_person_alone_worked(tmp_path: Path) -> None:
    dive = [(0.0, "relief Ann O Briain"), (1.0, "stern planes dive 10")]
    path = record(tmp_path / "d.trainer", "first-depth-change", dive, trainee=(ANN, "Bob"))
    debrief = read_dossier(path, None)
    tasks = debrief.task_marks
    assert {each.person for each in tasks} == {ANN}
    mean = sum(each.marks * each.weight for each in tasks) / sum(each.weight for each in tasks)
    assert own_marks_of(debrief, ANN) == pytest.approx(mean)
    assert own_marks_of(debrief, "Bob") is None
    alone = replace(debrief, watches=(), trainees=("Bob",))
    assert own_marks_of(alone, "Bob") == pytest.approx(mean)


def test_a_lesson_has_no_marks_but_is_done(tmp_path: Path) -> None:
    path = record(tmp_path / "l.trainer", "wheel-and-course", {}, duration=2.0, trainee=(ANN,))
    remember_run(path, 1, Outcome.DONE)
    (run,) = read_progress(ANN).runs
    assert (run.outcome, run.total, run.passed, run.costs) == ("done", None, True, {})


def test_a_lesson_with_a_step_undone_is_kept_as_not_done_and_comes_again(tmp_path: Path) -> None:
    path = record(tmp_path / "l.trainer", "wheel-and-course", {}, duration=2.0, trainee=(ANN,))
    remember_run(path, 1, Outcome.NOT_DONE)
    progress = read_progress(ANN)
    (run,) = progress.runs
    assert (run.outcome, run.passed) == ("not done", False)
    assert progress.best("wheel-and-course") == "begun"
    suggestion = progress.suggest(lessons(), TODAY)
    assert suggestion
    assert suggestion.lesson.name == "wheel-and-course"


def test_kinds_of_loss_follow_from_the_faults_of_the_curve() -> None:
    fault = FaultKind
    changes = [
        MarkChange(0, 10, -20.0, fault.MISSING, "bell astern full"),
        MarkChange(10, 20, -7.0, fault.MISSING, "pump trim aft 3"),
        MarkChange(20, 30, -9.0, fault.STEERING, "bow planes rise 5"),
        MarkChange(30, 40, -4.0, fault.NEEDLESS, "rudder left 20"),
    ]
    found = {"late": 20.0, "trim": 7.0, "overshoot": 13.0, "wrong way": 0.0, "other": 0.0}
    assert costs_of(changes) == found


def test_late_overshoot_wrong_way_and_trim_are_told_apart_by_what_was_done() -> None:
    fault = FaultKind
    kinds = {
        MarkChange(0, 1, -9.0, fault.LATE, "hover on", tick=0, came=70): "late",
        MarkChange(0, 1, -9.0, fault.LATE, "pump trim aft 3", tick=0, came=70): "late",
        MarkChange(0, 1, -9.0, fault.STEERING, came=70): "late",
        MarkChange(0, 1, -9.0, fault.MISSING, "pump trim aft 3", tick=0): "trim",
        MarkChange(0, 1, -9.0, fault.WRONG_AMOUNT, "pump trim aft 9"): "trim",
        MarkChange(0, 1, -9.0, fault.NEEDLESS, "flood auxiliary 9"): "trim",
        MarkChange(0, 1, -9.0, fault.WRONG_WAY, "pump trim forward 3"): "wrong way",
        MarkChange(0, 1, -9.0, fault.UNDONE, "bell stop"): "wrong way",
        MarkChange(0, 1, -9.0, fault.NEEDLESS, "blow all"): "wrong way",
        MarkChange(0, 1, -9.0, fault.WRONG_AMOUNT, "bell ahead one-third"): "overshoot",
        MarkChange(0, 1, -9.0, fault.STEERING, "stern planes dive 9"): "overshoot",
        MarkChange(0, 1, -9.0, fault.UNPROVED): "other",
    }
    for change, kind in kinds.items():
        assert {each for each, marks in costs_of([change]).items() if marks} == {kind}


def test_what_cost_marks_adds_up_to_what_was_lost() -> None:
    cause, draws = FaultKind, np.random.default_rng(3)
    for _ in range(200):
        marks = -draws.exponential(12.0, 8)
        falls = [MarkChange(i, i, each, cause.STEERING) for i, each in enumerate(marks)]
        lost = -float(marks.sum())
        assert sum(costs_of(falls).values()) == pytest.approx(lost, abs=0.3)


def test_what_cost_most_is_of_the_last_five_runs_with_marks() -> None:
    runs = [replace(LOST, recording=f"{n}", started=f"2026-01-{n:02d}") for n in range(1, 8)]
    assert Progress(ANN, tuple(runs)).costs["late"] == 5 * 35.0
    assert Progress(ANN, (*runs, LESSON)).costs["trim"] == 25.0


TODAY = date(2026, 2, 1)


def next_of(*runs: ProgressRun, with_lessons: bool = False) -> tuple[str, str]:
    """Return the name of what is offered next, and why."""
    done = replace(WON, total=None, outcome=Outcome.DONE, recording="lesson")
    lesson_runs = () if with_lessons else tuple(replace(done, exercise=x.name) for x in lessons())
    offered = [*lessons(), *course()]
    found = Progress(ANN, (*lesson_runs, *runs)).suggest(offered, TODAY)
    assert found is not None
    return found.lesson.name, found.reason


def flown(exercise: str, total: float, day: int, **costs: float) -> ProgressRun:
    started = f"2026-01-{day:02d}T10:00:00"
    named = {kind.replace("_", " "): marks for kind, marks in costs.items()}
    recording = f"{exercise}{day}"
    outcome = Outcome.WON if total >= 60.0 else Outcome.NOT_REACHED
    return ProgressRun(recording, 1, exercise, "", started, 60.0, outcome, total, costs=named)


def test_the_next_is_a_lesson_until_all_are_done_and_then_the_course() -> None:
    assert next_of(LOST, LESSON, with_lessons=True) == (
        lessons()[1].name,
        "a lesson that is not done yet",
    )
    first = course()[0].name
    assert next_of() == (first, "no marks in it yet, and the next of the course")
    assert next_of(flown(first, 95.0, 31))[0] == course()[1].name


def test_the_next_is_what_is_weakest_and_longest_ago_and_says_so() -> None:
    every = [flown(each.name, 95.0, 31) for each in course()]
    weak, old = course()[3].name, course()[7].name
    assert next_of(*every[:3], flown(weak, 52.0, 31), *every[4:]) == (weak, "52 marks yesterday")
    longer = [flown(old, 90.0, 10), *every[:7], *every[8:]]
    assert next_of(*longer) == (old, "90 marks 22 days ago")
    again = [flown(old, 90.0, 10), *every]  # flown again since
    assert next_of(*again)[0] == every[0].exercise


def test_of_two_as_weak_the_next_is_the_one_that_trains_what_cost_most() -> None:
    every = {each.name: flown(each.name, 90.0, 20) for each in course()}
    one, other = course()[2].name, course()[5].name
    every[one] = flown(one, 50.0, 20, late=50.0)
    every[other] = flown(other, 50.0, 20, trim=46.0, late=4.0)
    last = every.pop(course()[0].name)
    for kind, weaker, cost in (("late", one, 50), ("trim", other, 46)):
        told = f"50 marks 12 days ago; {kind}, which costs you most of late, cost {cost} here"
        assert next_of(*every.values(), replace(last, costs={kind: 40.0})) == (weaker, told)


def test_a_run_without_a_date_is_as_of_today() -> None:
    every = [replace(flown(each.name, 90.0, 1), started="") for each in course()]
    assert next_of(*every)[1].endswith("today")


def test_progress_is_drawn_in_eighty_columns(capsys: pytest.CaptureFixture[str]) -> None:
    long = replace(
        LOST, recording="d", exercise="heavy-boat", aids="ghost, predictor", counts=False
    )
    for run in (LOST, WON, LESSON, long):
        add_run(ANN, run)
    text = told(capsys, "recordings", "--trainee", "ann o briain", "--progress")
    lines = text.splitlines()
    assert max(map(len, lines)) <= 80
    assert any(
        "Depth, first steps" in line and "won" in line and " 91 ▄█ " in line for line in lines
    )
    assert next(line.split()[:2] for line in lines if "█████" in line) == ["late", "70"]
    assert f"1 of {len(lessons())}" in text
    assert f"--train --trainee '{ANN}'" in lines[-1]
    own = list(progress_lines(Progress("Zoë O'Brian")))[-1]
    assert shlex.split(own)[-1] == "Zoë O'Brian"  # as the shell reads it back
    drawn = list(progress_lines(Progress(ANN)))
    assert not any("cost most" in line for line in drawn)  # nothing has cost anything yet


def test_one_run_is_counted_as_one() -> None:
    for runs, counted in (((LOST,), "1 run, 0 h"), ((LOST, WON), "2 runs, 0 h")):
        assert counted in next(progress_lines(Progress(ANN, runs)))


def test_a_class_is_a_table_with_a_row_for_each_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    add_run(ANN, LOST)
    add_run(ANN, WON)
    add_run("Bob", LOST)
    (trainees_folder() / "eve.json").write_text("{", encoding="utf-8")
    table = tmp_path / "class.csv"
    text = told(capsys, "recordings", "--csv", str(table))
    assert "3 runs of 2 trainees" in text
    assert "left out" in text
    rows = list(csv.DictReader(table.read_text(encoding="utf-8").splitlines()))
    columns = ("trainee", "marks", "standard_error", "own_marks", "late")
    assert [tuple(row[column] for column in columns) for row in rows] == [
        (ANN, "40.0", "24.5", "62.0", "35.0"),
        (ANN, "91.0", "", "", ""),  # none is known
        ("Bob", "40.0", "24.5", "62.0", "35.0"),
    ]


@pytest.mark.parametrize("name", ["a/b", "..", ".hidden", "a\\b", " "])
def test_a_name_that_is_no_file_name_is_told(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ConfigError, match="trainee"):
        names_of([name])
    assert "--trainee" in told(capsys, "recordings", "--trainee", name, "--progress", code=2)
    assert file_stem("  Bób  & sons ") == "bób & sons"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("{", "it is no JSON"),
        (json.dumps({"schema": "progress/0", "trainee": ANN, "runs": []}), "this version reads"),
        (json.dumps({"schema": "progress/1", "trainee": ANN, "runs": [{"branch": 1}]}), "a run"),
    ],
)
def test_a_file_that_cannot_be_read_is_told_and_set_aside_whole(
    text: str, why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = progress_path(ANN)
    path.parent.mkdir(parents=True)
    path.write_text(text, encoding="utf-8")
    assert why in told(capsys, "recordings", "--trainee", ANN, "--progress", code=2)
    assert path.read_text(encoding="utf-8") == text
    assert "it is kept as" in add_run(ANN, LOST)
    assert path.with_name(f"{path.name}.damaged").read_text(encoding="utf-8") == text
    assert read_progress(ANN).runs == (LOST,)
    assert "damaged" in told(capsys, "recordings", "--trainee", ANN, "--progress")


def test_a_forgotten_trainee_leaves_no_file(capsys: pytest.CaptureFixture[str]) -> None:
    for name in (ANN, "Ann", "Ann O Briain Junior"):
        add_run(name, LOST)
    progress_path(ANN).with_name("ann o briain.json.damaged").write_text("{", encoding="utf-8")
    text = told(capsys, "recordings", "--forget", "ANN o briain")
    assert text.count("removed") == 2
    left = {each.name for each in trainees_folder().iterdir()}
    assert left == {
        *("ann.json", "ann.lock", "ann o briain junior.json", "ann o briain junior.lock"),
    }
    assert "no recording has that name" in told(capsys, "recordings", "--forget", ANN, code=2)

"""The debrief of a class: curves beside one another, the lesson for all, and names forgotten."""

import csv
import json
import os
import pickle
import re
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import platformdirs
import pytest
from helpers.few_points import look_at_few_moments
from helpers.recorded import record
from helpers.sessions import begin_run
from helpers.typed import type_command

from trainer.cli.main import cli
from trainer.config.exercise.class_course import CourseRow
from trainer.config.exercise.class_file import BoatRow, ClassFile, class_text
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import ProgressRun, add_run
from trainer.config.files import ConfigError
from trainer.debrief.page.page import read_dossier
from trainer.debrief.passage.class_places import boat_places
from trainer.debrief.trainees import class_debrief
from trainer.debrief.trainees.class_debrief import CLASS_HEADER, class_lessons, gather_class
from trainer.debrief.trainees.run_summary import LostMarks, kept_summary, summary_of, summary_path
from trainer.io.recording.recording import Recording
from trainer.session.past.options import RunOptions

pytestmark = [pytest.mark.long, pytest.mark.filterwarnings("ignore::RuntimeWarning")]
EXERCISE = "steady-course"
ANN, BOB = "Ann O Briain", "Bób <b>"
NAMES = {1: (ANN,), 2: (BOB, "C. Lee"), 3: ()}


def loss(seconds: float, marks: float, task: str = "Depth") -> LostMarks:
    return LostMarks(seconds, marks, task, "")


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a class of three boats that all turned away from the course."""
    folder = tmp_path_factory.mktemp("kept") / "class-tuesday"
    rows = [BoatRow(number=number, trainees=names) for number, names in NAMES.items()]
    rows[1] = BoatRow(number=2, trainees=NAMES[2], name="Bravo")
    for number, names in NAMES.items():
        (folder / f"boat-{number}").mkdir(parents=True)
        path = folder / f"boat-{number}" / "steady.trainer"
        record(path, EXERCISE, {60.0 + number: "rudder right 20"}, trainee=names)
    text = class_text(ClassFile(exercise=EXERCISE, boats=3, boat=tuple(rows)))
    (folder / "class.toml").write_text(text, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        look_at_few_moments(patch)
        gather_class(folder, None, cores=1)
    return folder


@pytest.fixture
def folder(sailed: Path, tmp_path: Path) -> Path:
    """Return a copy of it for a test, with what is kept beside its recordings."""
    return Path(shutil.copytree(sailed, tmp_path / sailed.name))


def typed(*words: object, code: int = 0) -> str:
    return type_command(cli, "class", "debrief", *words, code=code).output


def test_the_minute_in_which_most_boats_lost_marks_is_the_first_lesson() -> None:
    losses = {
        1: [loss(10.0, 30.0), loss(200.0, 5.0, "Course")],
        2: [loss(190.0, 4.0, "Depth"), loss(500.0, 50.0)],
        3: [loss(245.0, 6.0, "Course"), loss(305.0, 9.0)],
    }
    (lesson,) = class_lessons(losses)

    assert (lesson.begin, lesson.end, lesson.boats) == (190.0, 245.0, (1, 2, 3))
    assert (lesson.marks, lesson.task) == (5.0, "Course")
    words = '3:10 to 4:05: 3 of 4 boats lost 5 marks each in the mean, most of them in "Course"'
    assert "lost 1 mark each" in replace(lesson, marks=0.6).told(4)
    assert lesson.told(4) == f"{words} (boats 1, 2, 3)."


def test_a_loss_is_told_in_one_lesson_alone() -> None:
    losses = {boat: [loss(50.0 * place, 10.0) for place in range(4)] for boat in (1, 2)}
    lessons = class_lessons(losses)

    assert [(each.begin, each.end) for each in lessons] == [(0.0, 50.0), (100.0, 150.0)]
    assert sum(each.marks for each in lessons) == 40.0
    assert class_lessons({1: losses[1]}) == ()


@pytest.mark.usefixtures("few_points")
def test_a_class_has_a_page_that_leads_to_each_boats_own(folder: Path) -> None:
    told = typed(folder, "--cores", 1)
    page = (folder / "debrief" / "index.html").read_text(encoding="utf-8")

    assert "3 boats" in told
    assert "3 of 3 boats lost" in told
    assert "Bób &lt;b&gt;" in page
    assert "Bób <b>" not in page
    assert re.findall(r'class="line (boat-\d)" d="M\d', page) == ["boat-1", "boat-2", "boat-3"] * 2
    links = re.findall(r'href="(boat-[^"]+)"', page)
    assert links == [f"boat-{boat}-steady.html" for boat in (1, 2, 2, 3)]  # a row for each trainee
    for link in links:
        assert "What each minute cost" in (folder / "debrief" / link).read_text(encoding="utf-8")


def never(*_: object) -> None:
    raise AssertionError("judged again")


def test_what_is_judged_once_is_taken_from_beside_the_recordings(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(class_debrief, "read_dossier", never)
    figures = json.loads(typed(folder, "--json", "--cores", 1))

    (exercise,) = figures["exercises"]
    assert [each["boat"] for each in exercise["boats"]] == [1, 2, 3]
    assert all(each["standard_error"] and each["attainable"] for each in exercise["boats"])
    assert exercise["lessons"][0]["boats"] == [1, 2, 3]
    assert not figures["troubles"]


@pytest.mark.parametrize("text", ["", "[]", '{"of": 1}', "{"])
def test_what_is_kept_of_another_recording_is_judged_anew(folder: Path, text: str) -> None:
    path = folder / "boat-1" / "steady.trainer"
    known = kept_summary(path)
    os.utime(path, ns=(1, 1))
    assert known
    assert kept_summary(path) is None
    summary_path(path).write_text(text, encoding="utf-8")
    assert kept_summary(path) is None


def table_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_the_schools_books_have_a_row_for_each_trainee(folder: Path) -> None:
    path = folder / "books.csv"
    typed(folder, "--csv", path, "--cores", 1)
    rows = table_of(path)

    assert tuple(rows[0]) == CLASS_HEADER
    assert [(each["boat"], each["trainee"]) for each in rows] == [
        *(("1", ANN), ("2", BOB), ("2", "C. Lee"), ("3", "")),
    ]
    assert {each["class"] for each in rows} == {"class-tuesday"}
    assert rows[1]["boat_name"] == "Bravo"
    assert all(float(each["standard_error"]) > 0.0 for each in rows)
    assert not (folder / "debrief").exists()


def files_with(folder: Path, name: str) -> Sequence[str]:
    """Return the files of a folder in whose bytes a name stands."""
    found = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return [path.name for path in found if name.encode() in path.read_bytes()]


@pytest.mark.usefixtures("few_points")
def test_a_forgotten_name_is_gone_from_all_that_a_class_has(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(platformdirs, "user_data_dir", lambda *_, **__: str(tmp_path / "own"))
    typed(folder, "--csv", folder / "books.csv", "--html", folder / "pages", "--cores", 1)
    (folder / "boat-1.log").write_text(f"noted: {ANN} has the helm\n", encoding="utf-8")
    before = files_with(folder, ANN)
    assert {"books.csv", "class.toml", "index.html", "steady.summary.json"} <= {*before}
    type_command(cli, "recordings", folder, "--forget", ANN.lower())

    assert not files_with(folder, ANN)
    assert len(table_of(folder / "books.csv")) == 4
    told = typed(folder, "--cores", 1)
    assert "3 boats" in told
    assert not files_with(folder, ANN)
    assert "index.html" in files_with(folder, "C. Lee")


def test_the_table_of_recordings_in_a_folder_has_their_runs_alone(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(platformdirs, "user_data_dir", lambda *_, **__: str(tmp_path / "own"))
    run = ProgressRun("steady.trainer", 1, EXERCISE, "", "2026-01-01", 60.0, Outcome.WON, 90.0)
    add_run(ANN, run)
    other = ProgressRun("other.trainer", 1, EXERCISE, "", "2026-01-02", 60.0, Outcome.WON, 80.0)
    add_run(ANN, other)
    add_run("D. Kay", other)
    path = tmp_path / "runs.csv"
    type_command(cli, "recordings", folder, "--csv", path)

    assert [(each["trainee"], each["recording"]) for each in table_of(path)] == [
        (ANN, "steady.trainer")
    ]


def test_one_damaged_recording_leaves_the_others_their_debrief(folder: Path) -> None:
    path = folder / "boat-2" / "steady.trainer"
    path.write_bytes(b"no recording")
    told = typed(folder, "--json", "--cores", 1)
    figures = json.loads(told)

    assert [each["boat"] for each in figures["exercises"][0]["boats"]] == [1, 3]
    assert str(path) in figures["troubles"][0]


def test_what_nobody_has_foreseen_in_one_recording_is_told_with_its_file(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = folder / "boat-3" / "steady.trainer"
    summary_path(path).unlink()
    monkeypatch.setattr(class_debrief, "read_dossier", lambda *_: 1 // 0)

    (told,) = gather_class(folder, None, cores=1).troubles
    assert told.startswith(f"{path}: cannot be read: ZeroDivisionError")


def test_a_boat_that_has_not_begun_counts_for_nothing(folder: Path) -> None:
    path = folder / "boat-3" / "steady.trainer"
    path.unlink()
    plan, _, header = begin_run(RunOptions(exercise=EXERCISE, given=frozenset()))
    state = plan.launch_boat().records.state.tobytes()
    Recording.create(path, header, state).close()
    debrief = gather_class(folder, None, cores=1)

    assert [each.boat for each in debrief.exercises[0].runs] == [1, 2]
    assert debrief.troubles == ("boat 3 has not begun",)


def test_a_run_without_a_curve_is_judged_by_a_process_of_its_own_too(folder: Path) -> None:
    summary = summary_of(read_dossier(folder / "boat-1" / "steady.trainer", None))

    assert not summary.points
    assert pickle.loads(pickle.dumps(summary)) == summary  # noqa: S301  made here


def test_a_folder_without_a_class_or_without_a_run_is_told(tmp_path: Path, folder: Path) -> None:
    with pytest.raises(ConfigError, match=r"there is no class: it would have a class\.toml"):
        typed(tmp_path)
    for boat in NAMES:
        shutil.rmtree(folder / f"boat-{boat}")
    with pytest.raises(ConfigError, match="no boat of this class has a recording"):
        typed(folder)
    assert not (folder / "debrief").exists()


@pytest.mark.usefixtures("few_points")
def test_a_class_with_a_course_is_told_where_each_boat_is(folder: Path) -> None:
    rows = (CourseRow(exercise="watch"), CourseRow(exercise=EXERCISE, reach=99.5))
    planned = ClassFile(boats=3, course=rows, boat=(BoatRow(number=2, name="Bravo"),))
    (folder / "class.toml").write_text(class_text(planned), encoding="utf-8")
    path = folder / "books.csv"
    told = typed(folder, "--csv", path, "--html", folder / "debrief", "--cores", 1)
    figures = json.loads(typed(folder, "--json", "--cores", 1))

    places = re.findall(r"boat (\d) is at 2 of 2: steady-course, \d+ of 99.5", told)
    assert places == ["1", "2", "3"]
    page = (folder / "debrief" / "index.html").read_text(encoding="utf-8")
    assert page.count("2 of 2: steady-course, ") == 3
    assert {(row["course_place"], row["marks_to_reach"]) for row in table_of(path)} == {
        ("2", "99.5")
    }
    assert figures["course"][0] == {"exercise": "watch", "reach": None}
    marks = {each["boat"]: each["marks"] for each in figures["exercises"][0]["boats"]}
    assert {each["boat"]: each["marks"] for each in figures["places"]} == marks


def test_a_place_is_told_with_what_is_missing() -> None:
    course = (CourseRow(exercise="watch"), CourseRow(exercise=EXERCISE, reach=70.0))
    planned = ClassFile(boats=4, course=course)
    latest = {3: "backing", 1: EXERCISE, 2: "watch", 4: EXERCISE}
    places = boat_places(planned, latest, {(1, EXERCISE): 69.9, (2, "watch"): 80.0})

    assert [each.told for each in places] == [
        "2 of 2: steady-course, 69 of 70",
        "1 of 2: watch, 80 marks",
        "beside the course: backing",
        "2 of 2: steady-course, 70 marks to go on",
    ]
    assert boat_places(ClassFile(exercise="watch", boats=1), latest, {}) == ()

"""Runs to get to know the simulator; what assessors and peers think of a run, beside its marks."""

import json
from pathlib import Path

import pytest
from helpers.recorded import record
from helpers.typed import type_command

from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.debrief.marks.changes import change_of
from trainer.debrief.marks.forms import form_text, judged_names, read_forms, with_forms, write_forms
from trainer.debrief.page.data import debrief_figures
from trainer.debrief.page.page import DebriefRequest, as_text, read_compared, read_dossier, render
from trainer.debrief.trainees.forgetting import files_of, forget_trainee
from trainer.debrief.trainees.history import (
    familiarisation_lines,
    list_lines,
    list_recording,
    trainee_history,
)
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.session.run import run_boat

pytestmark = [
    pytest.mark.filterwarnings("ignore::RuntimeWarning"),
    pytest.mark.usefixtures("few_points"),
]
EXERCISE = "steady-course"
MARKS = {"B. Smith": 80, "C. Brown": 60, "D. White": 70}


@pytest.fixture(scope="module")
def flown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a recording of a trainee."""
    folder = tmp_path_factory.mktemp("flown")
    return record(folder / "drill.trainer", EXERCISE, {}, "helm", trainee=("A. Jones",))


def filled(folder: Path, by: str, kind: str, mark: float, **others: str) -> Path:
    """Return a form that somebody has filled in, of two measures and the whole run."""
    text = form_text(plan_run(RunOptions(exercise=EXERCISE)), kind)
    text = text.replace('by = ""', f"by = {json.dumps(by)}").replace('on = ""', 'on = "2026-11-25"')
    for name in ("Quiet rudder", "Usual procedures", "The whole run"):
        assert f'# "{name}" = ' in text
        text = text.replace(f'# "{name}" = ', f'"{name}" = {mark}')
    for key, value in others.items():
        text = text.replace("[marks]", f"{key} = {json.dumps(value)}\n[marks]")
    path = folder / f"{by}.toml"
    path.write_text(text, encoding="utf-8")
    return path


# Familiarisation


def test_a_familiarisation_run_is_kept_with_the_trainee_s_recordings_and_has_no_marks(
    tmp_path: Path, flown: Path
) -> None:
    names = ("A. Jones",)
    path = record(
        tmp_path / "known.trainer", EXERCISE, {}, "helm", trainee=names, familiarisation=True
    )
    known, marked = list_recording(path), list_recording(flown)
    assert known.came
    assert marked.came
    assert (known.came.total, known.came.counts) == (None, False)
    assert marked.came.total is not None
    assert next(list_lines([known])).endswith("known.trainer (familiarisation)")
    (attempts,) = trainee_history([known, marked])
    assert attempts.attempts == 1
    (line,) = familiarisation_lines([known, marked])
    assert line.startswith("familiarisation  ")
    assert "known.trainer" in line
    debrief = read_compared(path, DebriefRequest())
    assert "A familiarisation run: to get to know the simulator" in render(debrief)
    assert as_text(debrief).endswith("a familiarisation run, without marks")
    assert debrief_figures(debrief)["familiarisation"]
    with pytest.raises(ConfigError, match="no scoring rules"):
        change_of("outcome: won, he was kind", 1, debrief.plan)


def test_a_familiarisation_run_is_of_somebody() -> None:
    with pytest.raises(ConfigError, match=r"--familiarisation: .*--trainee NAME"):
        run_boat(RunOptions(headless=True, duration=1.0, familiarisation=True))


# Forms


@pytest.mark.parametrize("kind", ["assessor", "peer"])
def test_a_form_to_print_has_all_that_is_judged_and_a_place_to_sign(
    kind: str, tmp_path: Path
) -> None:
    page = tmp_path / "form.html"
    options = ["--peer"] if kind == "peer" else []
    type_command(cli, "exercise", "form", EXERCISE, *options, "-o", page)
    text = page.read_text(encoding="utf-8")
    plan = plan_run(RunOptions(exercise=EXERCISE))
    assert all(f"<td>{name}</td>" in text for name in judged_names(plan))
    assert "Signed" in text
    assert ("to my satisfaction" in text) is (kind == "assessor")
    assert ("Peer&#39;s form" in text) is (kind == "peer")


def test_marks_of_three_assessors_and_a_peer_are_laid_beside_the_program_s(
    flown: Path, tmp_path: Path
) -> None:
    plan = plan_run(RunOptions(exercise=EXERCISE))
    files = [filled(tmp_path, by, "assessor", mark) for by, mark in MARKS.items()]
    peer = filled(tmp_path, "E. Green", "peer", 10, remark="He <b>never</b> looked up.")
    write_forms(flown, with_forms(read_forms(flown), [*files, peer], plan))
    debrief = read_dossier(flown, None)
    compared = {each["name"]: each for each in debrief_figures(debrief)["compared_marks"]}
    assert list(compared) == ["Quiet rudder", "Usual procedures", "The whole run"]
    assert compared["Usual procedures"]["program"] is None
    assert compared["The whole run"]["program"] == debrief.total
    for each in compared.values():
        assert each["marks"] == (80, 60, 70, 10)
        assert (each["mean"], each["spread"]) == (70, 20)  # the peer's does not count
    page = render(debrief)
    assert "Assessors, peers and the program" in page
    assert "He &lt;b&gt;never&lt;/b&gt; looked up." in page
    whole = f"The whole run: program {debrief.total:.0f}; B. Smith 80, C. Brown 60,"
    assert whole in as_text(debrief)
    assert "mean 70, spread 20" in as_text(debrief).replace("\n", " ")

    later = [filled(tmp_path, "B. Smith", "assessor", 90)]
    write_forms(flown, with_forms(read_forms(flown), later, plan))
    assert [form.marks["The whole run"] for form in read_forms(flown)] == [90, 60, 70, 10]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            '"Quiet rudder" = 80',
            '"Quiet ruder" = 80',
            r"line 10: .* judged; nearest is Quiet rudder",
        ),
        ('"Quiet rudder" = 80', '"Quiet rudder" = 101', "Quiet rudder.* 101"),
        ("Steering, first steps", "Backing", 'the recording is of "Steering, first steps"'),
        ('kind = "assessor"', 'kind = "judge"', 'kind = "judge"'),
        ('by = "B. Smith"', 'by = ""', "by = "),
        ('schema = "form/1"', 'schema = "form/2"', 'must be "form/1"'),
    ],
)
def test_a_form_that_is_wrong_is_refused(old: str, new: str, told: str, tmp_path: Path) -> None:
    path = filled(tmp_path, "B. Smith", "assessor", 80)
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(ConfigError, match=told):
        with_forms((), [path], plan_run(RunOptions(exercise=EXERCISE)))


def test_a_name_is_forgotten_in_forms_too(tmp_path: Path) -> None:
    path = record(tmp_path / "drill.trainer", EXERCISE, {}, "helm")
    form = filled(tmp_path, "E. Green", "peer", 10, remark="said E. Green, beside him")
    write_forms(path, with_forms((), [form], plan_run(RunOptions(exercise=EXERCISE))))
    assert list(forget_trainee("e. green", files_of([path], []), []))
    (kept,) = read_forms(path)
    assert (kept.by, kept.remark) == ("(name removed)", "said (name removed), beside him")

"""A name that is forgotten is gone from every file that the trainer itself has written."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

import platformdirs
import pytest
from helpers.sessions import begin_run
from helpers.typed import type_command

from trainer.cli.main import cli
from trainer.config.exercise.class_file import BoatRow, ClassFile, class_text
from trainer.config.exercise.outcome import Outcome
from trainer.config.exercise.progress import ProgressRun, add_run, progress_path
from trainer.debrief.marks.changes import Change, write_changes
from trainer.debrief.marks.forms import WHOLE_RUN_NAME, EvaluationForm, write_forms
from trainer.debrief.page.page import PAGE_BADGE
from trainer.debrief.trainees.class_debrief import CLASS_HEADER
from trainer.debrief.trainees.history import marks_path
from trainer.debrief.trainees.progress_words import CSV_HEADER
from trainer.debrief.trainees.run_summary import LostMarks, RunSummary, keep_summary
from trainer.io.recording.recording import MARK_KIND, Recording
from trainer.session.past.options import RunOptions

NAME, OTHER = "Zoe Quine", "C. Lee"
RUN: Final = ProgressRun(
    "a.trainer", 1, "watch", "", "2026-01-01", 60.0, Outcome.WON, 40.0, costs={}
)
FORM: Final = EvaluationForm(
    exercise="Watch",
    on="1 January",
    by=NAME,
    kind="peer",
    remark=f"{NAME} was late",
    marks={WHOLE_RUN_NAME: 50.0},
)


def make_recording(path: Path) -> None:
    """Record a session that has just begun, with the name in its header and in a remark."""
    chosen = RunOptions(exercise="watch", trainee=(NAME, OTHER), given=frozenset({"trainee"}))
    plan, _, header = begin_run(chosen)
    state = plan.launch_boat().records.state.tobytes()
    recording = Recording.create(path, header, state)
    recording.event(0, MARK_KIND, "instructor", f"{NAME} has the helm", "instructor")
    recording.close()


def table(header: tuple[str, ...], name: str) -> str:
    rows = (header, tuple(name if each == "trainee" else "1" for each in header))
    return "".join(",".join(row) + "\r\n" for row in rows)


def page(name: str) -> str:
    return f"<html><head>{PAGE_BADGE}</head><body>{name} had the helm</body></html>"


# What lies beside a recording, or in the folder of its class, by who writes it there.
KEPT: Final[Mapping[str, Callable[[Path, Path], object]]] = {
    "summary": lambda recording, _: keep_summary(
        recording,
        RunSummary(RUN, (NAME, OTHER), (1.0, 2.0), losses=(LostMarks(1.0, 2.0, "", f"by {NAME}"),)),
    ),
    "marks": lambda recording, _: marks_path(recording).write_text(f'{{"of": "{NAME}"}}'),
    "changes": lambda recording, _: write_changes(
        recording,
        [Change(branch=1, name="Depth", what="strike", reason=f"{NAME} was ill", at="now")],
    ),
    "forms": lambda recording, _: write_forms(recording, [FORM, replace(FORM, by=OTHER)]),
    "page": lambda recording, _: recording.with_suffix(".html").write_text(page(NAME)),
    "page of a branch": lambda recording, _: recording.with_name(
        f"{recording.stem}-2.html"
    ).write_text(page(NAME)),
    "page of a class": lambda _, folder: write_in(folder / "debrief" / "index.html", page(NAME)),
    "what a boat said": lambda _, folder: write_in(folder / "boat-1.log", f"noted: {NAME}\n"),
    "what the last boat said": lambda _, folder: write_in(folder / "boat-12.log", f"{NAME}\n"),
    "books": lambda _, folder: write_in(folder / "books.csv", table(CLASS_HEADER, NAME)),
    "books of a folder": lambda _, folder: write_in(
        folder / "debrief" / "marks.csv", table(CSV_HEADER, NAME)
    ),
    "class file": lambda _, folder: write_in(
        folder / "class.toml",
        class_text(
            ClassFile(exercise="watch", boats=1, boat=(BoatRow(number=1, trainees=(NAME, OTHER)),))
        ),
    ),
}


def write_in(path: Path, text: str) -> None:
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding="utf-8", newline="")


def files_with(folder: Path, name: str) -> list[str]:
    """Return the files in whose bytes or names a name stands."""
    found = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return [str(path) for path in found if name.encode().lower() in path.read_bytes().lower()]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of a class with one recording, and all that may lie there."""
    monkeypatch.setattr(platformdirs, "user_data_dir", lambda *_, **__: str(tmp_path / "own"))
    folder = tmp_path / "class-tuesday"
    recording = folder / "boat-1" / "watch.trainer"
    recording.parent.mkdir(parents=True)
    make_recording(recording)
    before = set(files_with(tmp_path, NAME))
    for what, keep in KEPT.items():
        keep(recording, folder)
        after = set(files_with(tmp_path, NAME))
        assert len(after) == len(before) + 1, what
        before = after
    add_run(NAME, RUN)
    return folder


def test_no_file_has_a_name_that_was_forgotten(folder: Path) -> None:
    assert len(files_with(folder.parent, NAME)) == 1 + len(KEPT)
    assert progress_path(NAME).exists()
    type_command(cli, "recordings", folder, "--forget", NAME.lower())

    assert not files_with(folder.parent, NAME)
    assert not progress_path(NAME).exists()
    assert files_with(folder, OTHER)

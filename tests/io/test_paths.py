"""The default places of a session's files, and what is told where there can be none."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from trainer.config.exercise.progress import ProgressRun, add_run
from trainer.io import paths

RUN = ProgressRun.__new__(ProgressRun)  # it is not reached


@pytest.mark.parametrize(
    "wanted",
    [lambda: next(paths.recording_paths("drill")), lambda: add_run("Ann", RUN)],
)
def test_where_no_folder_can_be_made_the_next_step_is_told(
    wanted: Callable[[], object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))

    with pytest.raises(
        NotADirectoryError, match=r"recordings .* go there; XDG_STATE_HOME="
    ) as told:
        wanted()
    assert "--no-record" in (told.value.strerror or "")
    assert told.value.filename.startswith(str(tmp_path))


def test_a_folder_that_may_not_be_written_is_told_before_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "access", lambda *_: False)

    with pytest.raises(PermissionError, match=r"--no-record keeps none"):
        paths.made_folder(tmp_path / "recordings")


def test_a_user_without_a_home_is_told_the_next_step(monkeypatch: pytest.MonkeyPatch) -> None:
    def homeless() -> Path:
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.delenv("XDG_STATE_HOME", raising=False)
    monkeypatch.setattr(Path, "home", homeless)

    with pytest.raises(FileNotFoundError, match=r"no home folder: .*XDG_STATE_HOME=FOLDER"):
        paths.recordings_folder()

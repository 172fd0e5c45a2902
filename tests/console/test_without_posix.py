"""The console where POSIX is not, and on terminals that show no more than lines."""

import subprocess
import sys
from pathlib import Path

import pytest
from helpers.places import ROOT, environment

from trainer.console.terminal import draws

LACKING = str(ROOT / "tests" / "helpers" / "without_posix.py")
HERE = ROOT / "tests" / "console"


def without_posix(file: str, folder: Path, *, patience: float) -> list[str]:
    """Run a file where only what every system has can be imported; return what it prints."""
    done = subprocess.run(
        [sys.executable, LACKING, str(HERE / file)],
        capture_output=True, text=True, timeout=patience, check=False,
        env=environment(XDG_RUNTIME_DIR=str(folder)),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


@pytest.mark.process
def test_no_module_imports_what_only_posix_has(tmp_path: Path) -> None:
    *wrong, count = without_posix("import_all.py", tmp_path, patience=120.0)
    assert wrong == []
    assert int(count) > 300


@pytest.mark.process
@pytest.mark.long
def test_a_session_of_one_s_own_is_reached_over_loopback_with_a_token(tmp_path: Path) -> None:
    (tmp_path / "submarine-trainer").mkdir(mode=0o700)
    told = without_posix("attend_session.py", tmp_path, patience=180.0)
    assert told[:2] == ["joined tcp://127.0.0.1", "answered"]
    assert told[-1] == "left ('', '')"
    assert any("simulated" in text for text in told)  # the session's last words


@pytest.mark.parametrize(
    ("environment", "encoding", "drawn"),
    [
        ({"TERM": "xterm-256color"}, "utf-8", True),
        ({"TERM": "xterm", "LANG": "C"}, "utf-8", True),  # as programs make of it: C.UTF-8
        ({"TERM": "dumb"}, "utf-8", False),
        ({"TERM": "xterm", "LC_ALL": "C"}, "utf-8", False),
        ({"TERM": "xterm", "LC_ALL": "POSIX"}, "ascii", False),
        ({"TERM": "xterm", "LC_ALL": "de_DE.ISO-8859-1"}, "iso8859-1", False),
        ({"TERM": "xterm", "LC_ALL": "en_GB.UTF-8", "LC_CTYPE": "C"}, "UTF-8", True),
        ({}, "cp65001", False),
        ({}, "utf-8", True),
    ],
)
def test_a_terminal_that_draws_nothing_has_plain_lines(
    environment: dict[str, str], encoding: str, *, drawn: bool
) -> None:
    assert draws(environment, encoding) is drawn

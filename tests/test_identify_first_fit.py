"""The first fit of a version: by the interpreter, until the machine code is there."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from trainer.identify import first_fit
from trainer.identify.first_fit import _answer

NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]\d+)?")
SLOW = "import sys; sys.stdin.read()"  # ends when it is let
WAITS = "from trainer.identify import first_fit\nwith first_fit.alone():\n    pass"
TELLS = """
from trainer.identify import first_fit
from trainer.identify.first_fit import _answer
print(first_fit.wanted())
first_fit.keep()
print(first_fit.wanted())
import trainer.core.kernel
"""
RECORD = "\n".join(
    ["t,helm,rate", *(f"{i},{5 * (-1) ** (i // 7)},{0.1 * ((i * 37) % 11)}" for i in range(60))]
)
STUDY = """
schema = "identify/1"
name = "a record"
data = "record.csv"
columns = [
  {channel = "t", column = "t", unit = "s"},
  {channel = "rudder", column = "helm", unit = "deg"},
  {channel = "yaw_rate", column = "rate", unit = "deg/s"},
]
[ship]
length_m = 120
speed_kn = 12
[model]
kind = "nomoto1"
outputs = ["yaw_rate"]
"""


def process(code, **more):
    return subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, **more)


def test_the_interpreted_answer_is_given_where_it_comes_first(monkeypatch):
    monkeypatch.setattr(first_fit, "kept", lambda: False)  # whatever this machine has compiled
    compiler = process(SLOW)
    with process("print('found')", stdout=subprocess.PIPE) as fit:
        assert _answer(fit, compiler) == f"found{os.linesep}"
    assert fit.returncode == 0
    compiler.communicate()


def test_the_interpreted_fit_is_ended_where_machine_code_comes_first():
    compiler = process("")
    compiler.communicate()
    with process("import signal; signal.pause()", stdout=subprocess.PIPE) as fit:
        assert _answer(fit, compiler) is None
    assert fit.returncode != 0


def python(folder: Path, *words, **more):
    """Return what a fresh process with a cache of its own prints."""
    env = {**os.environ, "NUMBA_CACHE_DIR": str(folder), **more}
    told = subprocess.run(
        [sys.executable, *words], env=env, capture_output=True, text=True, check=False, cwd=folder
    )
    return told.stdout, told.stderr


def test_a_fit_is_interpreted_until_its_kernels_are_kept(tmp_path):
    told, _ = python(tmp_path, "-c", TELLS)
    assert told.split() == ["True", "False"]


def test_whoever_does_without_machine_code_is_not_raced(tmp_path):
    told, _ = python(tmp_path, "-c", TELLS, NUMBA_DISABLE_JIT="1")
    assert told.split() == ["False", "False"]


def study(folder):
    (folder / "record.csv").write_text(RECORD + "\n")
    (folder / "study.toml").write_text(STUDY)
    return str(folder / "study.toml")


def code(folder):
    return {path.name for path in folder.rglob("*.nbc")}


def numbers(page):
    """Return the numbers on a page, of which some are what is left where others cancel."""
    return [float(each) for each in NUMBER.findall(page)]


@pytest.mark.long
def test_what_is_compiled_beside_is_all_that_a_fit_needs_and_gives_the_same_numbers(tmp_path):
    path = study(tmp_path)
    page, _ = python(tmp_path, "-m", "trainer", "identify", path, NUMBA_DISABLE_JIT="1")
    assert "settled" in page
    assert python(tmp_path, "-m", "trainer.identify.compiling") == ("", "")
    before = code(tmp_path)
    assert any("information_rows" in name for name in before)
    again, said = python(tmp_path, "-m", "trainer", "identify", path)
    assert numbers(again) == pytest.approx(numbers(page), rel=2e-3)
    assert NUMBER.sub("", again) == NUMBER.sub("", page)
    assert "first fit" not in said
    assert code(tmp_path) == before


@pytest.mark.long
def test_a_first_fit_answers_while_its_kernels_are_being_compiled(tmp_path):
    page, said = python(tmp_path, "-m", "trainer", "identify", study(tmp_path))
    assert "settled" in page
    assert "are being compiled beside it" in said
    python(tmp_path, "-c", WAITS)  # for the compiler, which goes on

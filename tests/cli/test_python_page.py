"""The pages of the Python face and its notebook, run as they stand."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from helpers import notebooks, python_reference
from helpers.lanes import sample_cases
from helpers.places import ROOT, TESTS, environment

PAGE, LEARNING_PAGE = (
    (ROOT / "docs" / name).read_text(encoding="utf-8") for name in ("python.md", "learning.md")
)
MOST = 100_000  # [bytes] of a notebook with its outputs


def ran(code: str, folder: Path) -> str:
    """Run a program in a process and a folder of its own; return what it prints."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        env=environment(),
        capture_output=True,
        text=True,
        timeout=600,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.process
def test_the_blocks_of_the_page_run_one_after_the_other(tmp_path: Path) -> None:
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len(blocks) > 8

    told = ran("\n".join(blocks), tmp_path)

    assert "80.0 m" in told
    assert "collapse at 450 m" in told


@pytest.mark.process
def test_the_blocks_of_the_page_for_programs_that_learn_run_too(tmp_path: Path) -> None:
    blocks = re.findall(r"```python\n(.*?)```", LEARNING_PAGE, re.DOTALL)

    told = ran("\n".join(blocks), tmp_path).splitlines()

    assert [line.endswith("marks") for line in told] == [True, False]
    assert float(told[0].split()[0]) > 30.0


def test_every_public_name_is_in_the_reference_as_its_docstring_has_it() -> None:
    page = python_reference.PAGE.read_text(encoding="utf-8")

    assert page == python_reference.reference(), (
        "in the folder of the tests: python -m helpers.python_reference"
    )


QUICK_NOTEBOOKS = [path for path in notebooks.NOTEBOOKS if path.stem == "first-hour"]


@pytest.mark.process
@pytest.mark.parametrize(
    "path", sample_cases(notebooks.NOTEBOOKS, *QUICK_NOTEBOOKS), ids=lambda path: path.stem
)
def test_the_notebook_s_code_prints_what_the_notebook_shows(tmp_path: Path, path: Path) -> None:
    shown = [notebooks.outputs_of(cell) for cell in notebooks.cells(path)]
    assert path.stat().st_size < MOST
    code = (
        f"import json, pathlib, sys; sys.path.insert(0, {str(TESTS)!r})\n"
        "from helpers import notebooks\n"
        f"print(json.dumps(notebooks.run(pathlib.Path({str(path)!r}))))"
    )

    printed = ran(code, tmp_path)

    assert json.loads(printed) == shown, "in the folder of the tests: python -m helpers.notebooks"

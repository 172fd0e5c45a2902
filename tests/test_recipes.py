"""The recipes of the maintainer lead to files, names and commands that there are."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from helpers import document_tables, key_tables
from helpers.places import ROOT, TESTS
from helpers.worked_diff import BLOCK, PAGE, RECIPES, git, worked_diff

TEXT = BLOCK.sub("", PAGE.read_text(encoding="utf-8"))
FILE = r"(?:trainer|tests|configs|docs)/[\w./-]+"
RUN_TESTS = re.findall(r"^python -m pytest (.*)$", TEXT, re.MULTILINE)  # of the worked diffs
LOCAL = (".*", "__pycache__", "node_modules")  # what a checkout has of its own


def test_every_file_of_a_recipe_is_there() -> None:
    named = re.findall(f"`({FILE})`", TEXT.replace("NAME.toml", "bb2.toml"))

    assert len(named) > 40
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_every_name_of_a_recipe_stands_in_its_file() -> None:
    named = re.findall(f"`([A-Za-z_]+)` in `({FILE})`", TEXT)
    faults = [
        f"{name} in {file}"
        for name, file in named
        if not re.search(rf"\b{name}\b", (ROOT / file).read_text(encoding="utf-8"))
    ]

    assert len(named) > 20
    assert not faults


def test_every_command_of_a_recipe_makes_what_it_says() -> None:
    commands = re.findall(r"`python -m helpers\.(\w+)(?: ([\w-]+))?", TEXT)
    tables = {"document_tables": document_tables.MAKERS, "key_tables": key_tables.TABLES}

    assert commands
    assert [name for name, _ in commands if not (TESTS / "helpers" / f"{name}.py").exists()] == []
    assert [table for name, table in commands if table and table not in tables[name]] == []


@pytest.mark.process
@pytest.mark.parametrize("recipe", RECIPES)
def test_a_worked_diff_still_applies(recipe: str) -> None:
    checked = git(ROOT, "apply", "--check", says=worked_diff(recipe))

    renewed = "python -m helpers.worked_diff, in tests/, makes it anew"
    assert checked.returncode == 0, f"{checked.stderr}{renewed}"


@pytest.mark.process
@pytest.mark.slow
@pytest.mark.parametrize(("recipe", "tests"), [*zip(RECIPES, RUN_TESTS, strict=True)])
def test_a_copy_with_a_worked_diff_is_green(recipe: str, tests: str, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(*LOCAL))
    assert git(copy, "apply", says=worked_diff(recipe)).returncode == 0

    done = subprocess.run(
        [sys.executable, "-m", "pytest", *tests.split()],
        cwd=copy,
        env={name: word for name, word in os.environ.items() if not name.startswith("PYTEST")}
        | {"PYTHONPATH": str(copy)},
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 0, done.stdout
    assert " passed" in done.stdout

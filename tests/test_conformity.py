"""What is said of STCW is true as far as a test can tell: each line that says "has" is shown."""

import re

import pytest
from click.testing import CliRunner
from helpers import conformity
from helpers.places import ROOT, TESTS

from trainer.cli.main import cli
from trainer.config.exercise.conformity import (
    CLOSING_DECLARATION,
    load_conformity,
    parse_conformity,
)
from trainer.config.files import ConfigError

LINES = load_conformity()
TEXT = (ROOT / "configs" / "conformity.toml").read_text(encoding="utf-8")


def is_there(test: str) -> bool:
    """Return whether a test of that file and name is there."""
    file, name = test.split("::")
    path = TESTS / file
    return path.is_file() and f"\ndef {name}(" in path.read_text(encoding="utf-8")


def anchors(page: str) -> set[str]:
    """Return where a page of the documents can be linked to."""
    heads = re.findall(
        r"^#+ (.*)$", (ROOT / "docs" / page).read_text(encoding="utf-8"), re.MULTILINE
    )
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def test_every_test_that_is_named_is_there() -> None:
    faults = [
        f"{line.section}: {line.test}" for line in LINES if line.test and not is_there(line.test)
    ]

    assert not faults
    assert not is_there("test_conformity.py::test_that_is_nowhere")
    assert not is_there("test_nowhere.py::test_every_test_that_is_named_is_there")


def test_every_page_that_is_named_is_there_with_its_heading() -> None:
    named = [line.page.partition("#") for line in LINES if line.page]
    assert not [page for page, _, head in named if head and head not in anchors(page)]
    assert not [page for page, _, _ in named if not (ROOT / "docs" / page).is_file()]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (
            r'test = "analysis/test_exercises_flown.*\n',
            "",
            r"line 9: .* names no test that shows it",
        ),
        (r'lacks = "no replica.*\n', "", r"line \d+: \[lines\[1\]\] state = .* what it lacks"),
        (
            'state = "has"',
            'state = "yes"',
            r"line \d+: \[lines\[0\]\] state = \"yes\": must be has",
        ),
        ("asks = ", "ask = ", r"line \d+: .*no such key; nearest is asks"),
    ],
)
def test_a_line_that_claims_without_showing_is_refused(old: str, new: str, told: str) -> None:
    text, count = re.subn(old, new, TEXT, count=1)
    assert count

    with pytest.raises(ConfigError, match=told):
        parse_conformity(text, "conformity.toml")


def test_the_page_is_made_of_the_lines() -> None:
    text = (ROOT / "docs" / "conformity.md").read_text(encoding="utf-8")

    assert text == conformity.page(), "python -m helpers.conformity > ../docs/conformity.md"


def test_the_command_tells_every_line_and_that_nobody_has_certified_it() -> None:
    result = CliRunner().invoke(cli, ["conform"])

    assert result.exit_code == 0
    assert all(line.section in result.stdout for line in LINES)
    assert result.stdout.rstrip().endswith(CLOSING_DECLARATION)
    assert all(len(line) <= 79 for line in result.stdout.splitlines()[:-1])

"""The documents hold together: the index is whole, links lead somewhere, the README is short."""

import hashlib
import json
import re
import tomllib
from pathlib import Path

import pytest
from helpers import exit_codes, help_lines

from trainer.cli.types import HELP_LINES_PATH

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
PAGES = [*sorted(DOCS.glob("*.md")), *sorted(ROOT.glob("*.md"))]
README = (ROOT / "README.md").read_text(encoding="utf-8")
TOPIC = re.compile(r"^#+ (.*)$", re.MULTILINE)
CODE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
PROMISE = re.compile(r"\bAfter this page (you|a script)\b")


def prose(page: Path) -> str:
    """Return a page without its blocks of code."""
    return CODE.sub("", page.read_text(encoding="utf-8"))


def anchors(page: Path) -> set[str]:
    """Return the places of a page that a link can name, as the usual viewers make them."""
    found: set[str] = set()
    for heading in TOPIC.findall(prose(page)):
        words = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).lower()
        name = re.sub(r"[^\w\- ]", "", words).strip().replace(" ", "-")
        found.add(next(each for each in names(name) if each not in found))
    return found


def names(name: str) -> list[str]:
    """Return an anchor, and what it is called where headings repeat."""
    return [name, *(f"{name}-{number}" for number in range(1, 100))]


def is_dead(page: Path, target: str) -> bool:
    """Return whether a link of a page leads nowhere in this repository."""
    if re.match(r"\w+:", target):
        return False
    file, _, anchor = target.partition("#")
    there = (page.parent / file).resolve() if file else page
    return not there.exists() or bool(anchor and anchor not in anchors(there))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_and_anchor_of_a_page_leads_somewhere(page: Path) -> None:
    assert [each for each in LINK.findall(prose(page)) if is_dead(page, each)] == []


def test_every_document_is_in_the_index_once() -> None:
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    listed = re.findall(r"^- \[.*?\]\(([\w.-]+)\): ", index, re.MULTILINE)

    there = {page.name for page in DOCS.iterdir() if page.is_file()} - {"index.md"}
    assert sorted(listed) == sorted(there)


def test_the_readme_is_one_screen_with_a_picture_two_commands_and_three_links() -> None:
    assert len(README.splitlines()) <= 36
    assert re.findall(r"^# (set up .*)\n.* && .*\n```$", README, re.MULTILINE) == [
        "set up and take a submarine to sea",
        "set up and run the tests",
    ]
    assert re.findall(r"[^!]\[[^]]*\]\((.*?)\)", README) == [
        "docs/tutorial.md",
        "docs/index.md",
        "CONTRIBUTING.md",
    ]
    assert "](docs/images/session.png)" in README


def test_the_moving_picture_is_small_and_moves() -> None:
    picture = (DOCS / "images" / "session.png").read_bytes()
    _, animation, rest = picture.partition(b"acTL")
    pictures = int.from_bytes(rest[:4], "big")

    assert animation, "python tests/moving_picture.py draws it"
    assert pictures >= 12
    assert len(picture) <= 400_000


def test_the_index_names_every_extra() -> None:
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    extras = project.partition("[project.optional-dependencies]")[2].partition("\n[")[0]

    named = re.findall(r"^(\w+) = \[", extras, re.MULTILINE)
    assert len(named) > 6
    assert [name for name in named if f"`{name}`" not in index] == []


def test_the_page_of_exit_codes_is_made_of_the_help_of_the_commands() -> None:
    page = (DOCS / "exit-codes.md").read_text(encoding="utf-8")

    assert page == exit_codes.page(), "python -m helpers.exit_codes > ../docs/exit-codes.md"


def test_lists_of_commands_show_what_each_says_of_itself_first() -> None:
    assert HELP_LINES_PATH.read_text(encoding="utf-8") == help_lines.text(), (
        "python -m helpers.help_lines > ../trainer/cli/help-lines.txt"
    )


def test_the_citation_agrees_with_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lines = (ROOT / "CITATION.cff").read_text(encoding="utf-8").splitlines()

    assert f"version: {project['version']}" in lines
    assert f"license: {project['license']}" in lines
    assert f"keywords: [{', '.join(project['keywords'])}]" in lines
    numbers = [line for line in lines if line.strip().startswith("number: ")]
    assert len(numbers) == 2


# pages whose figures were flown with BB2; others take theirs from tests, or name day and machine
FLOWN = (
    *("afloat", "autopilot", "ballast", "engineer", "envelope", "identification"),
    *("reduction", "round-trip", "seas", "sweeps", "waves"),
)


def digest_of_bb2() -> str:
    """Return eight digits that stand for the numbers of BB2's file, whatever its comments."""
    tables = tomllib.loads((ROOT / "configs/vessels/bb2.toml").read_text(encoding="utf-8"))
    numbers = json.dumps(tables, sort_keys=True).encode()
    return hashlib.sha256(numbers).hexdigest()[:8]


@pytest.mark.parametrize("name", FLOWN)
def test_figures_flown_with_bb2_name_the_day_and_the_boat(name: str) -> None:
    page = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    dated = re.search(r"^Figures of \d+ \w+ \d{4}, BB2 `([0-9a-f]{8})`(.*)$", page, re.MULTILINE)

    assert dated, "the page says of which day its figures are, and of which BB2"
    digest, remark = dated.groups()
    assert digest == digest_of_bb2() or "an earlier" in remark, (
        f"BB2 is {digest_of_bb2()} today: fly them again, or say that they are of an earlier file"
    )


def test_a_page_begins_with_what_its_reader_can_do_after_it() -> None:
    pages = [page for page in DOCS.glob("*.md") if page.name != "index.md"]
    silent = [
        page.name
        for page in pages
        if not PROMISE.search(page.read_text(encoding="utf-8").partition("\n## ")[0])
    ]

    assert pages
    assert not silent


def test_a_release_has_forty_lines_of_changelog_at_most() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    releases = text.split("\n## ")[1:]

    assert releases
    assert [each.splitlines()[0] for each in releases if len(each.splitlines()) > 40] == []


def test_each_library_that_is_asked_for_has_its_reason_on_the_page_of_dependencies() -> None:
    page = (DOCS / "dependencies.md").read_text(encoding="utf-8")
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project = table["project"]
    groups = [project["dependencies"], *project["optional-dependencies"].values()]
    groups += table["dependency-groups"].values()
    libraries = {re.match(r"[\w-]+", each)[0] for group in groups for each in group}  # type: ignore[index]

    assert len(libraries) > 30
    assert sorted(each for each in libraries if not re.search(rf"\b{each}\b", page)) == []


def test_the_hosted_workflow_calls_the_gate_and_nothing_else() -> None:
    workflow = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")

    assert re.findall(r"run: (.*)", workflow) == [".ci/run"]


def test_commits_are_linted_by_the_linter_of_the_gate() -> None:
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    (linter,) = (
        each for each in table["project"]["optional-dependencies"]["dev"] if "ruff" in each
    )

    assert re.findall(r'additional_dependencies: \["(.*?)"\]', hooks) == [linter] * 2

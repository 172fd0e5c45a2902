"""A release is refused where something is not in order; else it is set, built and tagged."""

import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from collections.abc import Callable
from datetime import date
from io import BytesIO
from pathlib import Path

import pytest
import release
from helpers.places import ROOT
from release import check_changelog, check_desk, check_version, make_release, run_in

from trainer.config.files import ConfigError

pytestmark = pytest.mark.process  # git
DAY = date(2026, 12, 1)
FEW = (
    *("pyproject.toml", "CITATION.cff", "CHANGELOG.md", "trainer/__init__.py"),
    *("codemeta.json", ".zenodo.json", "deploy/conda/recipe.yaml"),
)
LOCAL = (".*", "__pycache__", "node_modules", "dist", "build")  # what a checkout has of its own
NEWER = "9.0.0"


def under_git(folder: Path) -> Path:
    """Commit all that is in a folder, on main."""
    run_in(folder, "git", "init", "--quiet", "--initial-branch", "main")
    for key, value in (("name", "Tester"), ("email", "tester@example.org")):
        run_in(folder, "git", "config", f"user.{key}", value)
    run_in(folder, "git", "add", "--all")
    run_in(folder, "git", "commit", "--quiet", "--message", "Begin")
    return folder


@pytest.fixture
def desk(tmp_path: Path) -> Path:
    """Return a throwaway repository of the files that a release writes."""
    for name in FEW:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    return under_git(tmp_path)


def change(path: Path, before: str, after: str) -> None:
    """Replace a text that is in the file."""
    text = path.read_text(encoding="utf-8")
    assert before in text
    path.write_text(text.replace(before, after), encoding="utf-8")


def commit(desk: Path) -> None:
    run_in(desk, "git", "commit", "--quiet", "--all", "--message", "Change")


def on_another_branch(desk: Path) -> None:
    run_in(desk, "git", "switch", "--quiet", "--create", "other")


def with_a_change(desk: Path) -> None:
    change(desk / "CITATION.cff", "software", "programs")


def with_a_new_file(desk: Path) -> None:
    (desk / "new.txt").write_text("new", encoding="utf-8")


def with_nothing_unreleased(desk: Path) -> None:
    change(desk / "CHANGELOG.md", "## Unreleased\n", "## Unreleased\n\n## 0.0.1 - 2026-01-01\n")
    commit(desk)


def with_a_tag(desk: Path) -> None:
    run_in(desk, "git", "tag", f"v{NEWER}")


def with_two_versions(desk: Path) -> None:
    change(desk / "CITATION.cff", "\nversion: ", "\nversion: 1")
    commit(desk)


@pytest.mark.parametrize(
    ("spoil", "version", "why"),
    [
        (on_another_branch, NEWER, "this is other; a release is made on main"),
        (with_a_change, NEWER, "1 files are not committed; the first is: M CITATION.cff"),
        (with_a_new_file, NEWER, r"the first is: \?\? new.txt"),
        (with_nothing_unreleased, NEWER, "CHANGELOG.md: nothing stands under '## Unreleased'"),
        (with_a_tag, NEWER, f"there is a tag v{NEWER} already"),
        (with_two_versions, NEWER, "the files disagree"),
        (Path.exists, "0.0.1", "must be newer than"),
        (Path.exists, "9.0", "three numbers"),
    ],
)
def test_a_release_is_refused_and_changes_nothing(
    desk: Path, spoil: Callable[[Path], object], version: str, why: str
) -> None:
    spoil(desk)
    before = run_in(desk, "git", "status", "--porcelain"), run_in(desk, "git", "show-ref")

    with pytest.raises(ConfigError, match=why):
        make_release(desk, version, DAY)

    assert before == (
        run_in(desk, "git", "status", "--porcelain"),
        run_in(desk, "git", "show-ref"),
    )


def test_the_repository_itself_could_be_released(desk: Path) -> None:
    check_desk(desk)
    check_version(desk, NEWER)
    if "\n- " in (desk / "CHANGELOG.md").read_text().partition("## ")[2].partition("\n## ")[0]:
        check_changelog(desk)


def test_a_release_is_set_dated_committed_and_tagged(
    desk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (desk / ".gitignore").write_text("/dist/\n", encoding="utf-8")
    change(desk / "CHANGELOG.md", "## Unreleased\n", "## Unreleased\n\n- A new thing.\n")
    run_in(desk, "git", "add", "--all")
    commit(desk)
    monkeypatch.setattr(release, "build_twice", lambda *_: {"a.whl": b"wheel"})

    make_release(desk, NEWER, DAY)

    assert {release.version_in(desk, file) for file in release.VERSION_LINES} == {NEWER}
    assert {release.day_in(desk, file) for file in release.DAY_LINES} == {"2026-12-01"}
    text = (desk / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"## Unreleased\n\n## {NEWER} - 2026-12-01\n\n- A new thing.\n" in text
    assert run_in(desk, "git", "status", "--porcelain") == ""
    assert run_in(desk, "git", "describe") == f"v{NEWER}"
    assert run_in(desk, "git", "show", "--format=%s", "--name-only").splitlines() == [
        f"Release {NEWER}",
        "",
        *sorted(FEW),
    ]
    assert (desk / "dist" / "a.whl").read_bytes() == b"wheel"


def test_a_build_that_fails_leaves_the_desk_as_it_was(
    desk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    change(desk / "CHANGELOG.md", "## Unreleased\n", "## Unreleased\n\n- A new thing.\n")
    commit(desk)
    begun = run_in(desk, "git", "rev-parse", "HEAD")

    def not_built(root: Path, day: date) -> dict[str, bytes]:
        assert run_in(root, "git", "status", "--porcelain")
        raise ConfigError(f"not built on {day}")

    monkeypatch.setattr(release, "build_twice", not_built)
    with pytest.raises(ConfigError, match="not built on 2026-12-01"):
        make_release(desk, NEWER, DAY)

    assert run_in(desk, "git", "rev-parse", "HEAD") == begun
    assert run_in(desk, "git", "status", "--porcelain") == ""
    assert run_in(desk, "git", "tag") == ""


def test_two_builds_of_other_bytes_are_no_release(
    desk: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bytes_of_builds = iter([b"one", b"two"])
    monkeypatch.setattr(release, "build", lambda *_: {"a.whl": next(bytes_of_builds)})

    with pytest.raises(ConfigError, match=r"other bytes: a\.whl"):
        release.build_twice(desk, DAY)


@pytest.mark.slow
def test_a_clone_is_released_with_the_same_bytes_twice(tmp_path: Path) -> None:
    """By the command itself, with the tools from the package index."""
    clone, tools = tmp_path / "clone", tmp_path / "tools"
    shutil.copytree(ROOT, clone, ignore=shutil.ignore_patterns(*LOCAL))
    for name in (".gitignore", ".zenodo.json"):
        shutil.copy(ROOT / name, clone)
    change(clone / "CHANGELOG.md", "## Unreleased\n", "## Unreleased\n\n- A new thing.\n")
    under_git(clone)
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text())["dependency-groups"]["release"]
    pip = (sys.executable, "-m", "pip", "install", "--quiet", "--target", str(tools))
    run_in(tmp_path, *pip, *wanted)

    done = subprocess.run(
        [sys.executable, "-m", "tests.release", NEWER],
        cwd=clone,
        env=os.environ | {"PYTHONPATH": f"{clone}:{tools}"},
        capture_output=True,
        text=True,
        check=False,
    )

    assert done.returncode == 0, done.stderr
    assert run_in(clone, "git", "describe") == f"v{NEWER}"
    wheel, sdist = (
        (clone / "dist" / f"submarine_trainer-{NEWER}{end}").read_bytes()
        for end in ("-py3-none-any.whl", ".tar.gz")
    )
    with zipfile.ZipFile(BytesIO(wheel)) as files:
        names = files.namelist()
        assert f'__version__ = "{NEWER}"' in files.read("trainer/__init__.py").decode()
    assert "trainer/configs/vessels/bb2.toml" in names
    with tarfile.open(fileobj=BytesIO(sdist)) as packed:
        assert f"submarine_trainer-{NEWER}/tests/release.py" in packed.getnames()

"""``python -m tests.release 0.2.0`` sets a version, builds it twice, commits and tags it.

Nothing leaves this machine. The last lines that it prints say how to publish.
"""

import os
import re
import shlex
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, date, datetime, time
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import Final

import click

sys.path.insert(0, str(Path(__file__).parent))  # packages of tests/ go by their own names

from helpers.places import ROOT

from trainer.cli.main import run_command
from trainer.config.files import ConfigError

BRANCH: Final = "main"
VERSION: Final = re.compile(r"(0|[1-9]\d*)\.(0|[1-9]\d*)\.(0|[1-9]\d*)")
VERSION_LINES: Final = {  # by its file, how the line with the version begins and ends
    "pyproject.toml": ('version = "', '"'),
    "trainer/__init__.py": ('__version__ = "', '"'),
    "CITATION.cff": ("version: ", ""),
    "codemeta.json": ('  "version": "', '",'),
    ".zenodo.json": ('  "version": "', '",'),
    "deploy/conda/recipe.yaml": ('  version: "', '"'),
}
DAY_LINES: Final = {  # by its file, how the line with the day of that version begins and ends
    "CITATION.cff": ("date-released: ", ""),
    "codemeta.json": ('  "datePublished": "', '",'),
    ".zenodo.json": ('  "publication_date": "', '",'),
}
CHANGELOG: Final = "CHANGELOG.md"
HEADING: Final = "## Unreleased\n"
TOOLS: Final = ("build", "twine")


def run_in(folder: Path, *words: str, **more: str) -> str:
    """Return what a program prints; ConfigError with its last words where it fails."""
    done = subprocess.run(
        words, cwd=folder, env=os.environ | more, capture_output=True, text=True, check=False
    )
    if done.returncode:
        last = "\n".join((done.stdout + done.stderr).strip().splitlines()[-12:])
        raise ConfigError(f"{shlex.join(words)}: exit code {done.returncode}\n{last}")
    return done.stdout.strip()


def check_desk(root: Path) -> None:
    """Raise ConfigError on another branch than main, or where something is not committed."""
    branch = run_in(root, "git", "branch", "--show-current") or "no branch"
    if branch != BRANCH:
        raise ConfigError(f"{root}: this is {branch}; a release is made on {BRANCH}")
    changed = run_in(root, "git", "status", "--porcelain").splitlines()
    if changed:
        first = changed[0].strip()
        raise ConfigError(f"{root}: {len(changed)} files are not committed; the first is: {first}")


def version_in(root: Path, file: str) -> str:
    """Return the version that a file says; ConfigError unless it says one, in its own line."""
    begin, end = VERSION_LINES[file]
    found = told_in(root, file, begin, end)
    if not VERSION.fullmatch(found):
        raise ConfigError(f"{file}: has no line {begin}X.Y.Z{end}, but {found!r}")
    return found


def day_in(root: Path, file: str) -> str:
    """Return the day that a file says of its version, as 2026-12-01."""
    return told_in(root, file, *DAY_LINES[file])


def told_in(root: Path, file: str, begin: str, end: str) -> str:
    """Return what stands between two texts in a line; ConfigError unless there is one such line."""
    line = re.compile(f"^{re.escape(begin)}(.*){re.escape(end)}$", re.MULTILINE)
    found = line.findall((root / file).read_text(encoding="utf-8"))
    if len(found) != 1:
        raise ConfigError(f"{file}: has no single line {begin}...{end}, but {found}")
    return str(found[0])


def order_of(version: str) -> tuple[int, ...]:
    """Return what versions are compared by."""
    return tuple(map(int, version.split(".")))


def check_version(root: Path, version: str) -> None:
    """Raise ConfigError for a version that is none, is not newer, or is tagged already."""
    if not VERSION.fullmatch(version):
        raise ConfigError(f"{version!r}: a version is three numbers, such as 0.2.0")
    present = {file: version_in(root, file) for file in VERSION_LINES}
    if len(set(present.values())) > 1:
        said = ", ".join(f"{file} {each}" for file, each in present.items())
        raise ConfigError(f"the files disagree about the present version: {said}")
    last = max(present.values(), key=order_of)
    if order_of(version) <= order_of(last):
        raise ConfigError(f"{version}: must be newer than {last}, which pyproject.toml has")
    if run_in(root, "git", "tag", "--list", f"v{version}"):
        raise ConfigError(f"{version}: there is a tag v{version} already")


def check_changelog(root: Path) -> None:
    """Raise ConfigError where the changelog has nothing under *Unreleased*."""
    text = (root / CHANGELOG).read_text(encoding="utf-8")
    if text.count(HEADING) != 1:
        raise ConfigError(f"{CHANGELOG}: has no single heading {HEADING.strip()!r}")
    if not re.search(r"^- \S", text.partition(HEADING)[2].partition("\n## ")[0], re.MULTILINE):
        raise ConfigError(f"{CHANGELOG}: nothing stands under {HEADING.strip()!r}")


def write_version(root: Path, version: str, day: date) -> None:
    """Write version and day into their files, and both into the changelog."""
    changes = [
        (file, ends, version_in(root, file), version) for file, ends in VERSION_LINES.items()
    ]
    changes += [
        (file, ends, day_in(root, file), day.isoformat()) for file, ends in DAY_LINES.items()
    ]
    for file, (begin, end), old, new in changes:
        text = (root / file).read_text(encoding="utf-8")
        line = re.compile(f"^{re.escape(begin + old + end)}$", re.MULTILINE)
        (root / file).write_text(line.sub(begin + new + end, text), encoding="utf-8")
    text = (root / CHANGELOG).read_text(encoding="utf-8")
    dated = text.replace(HEADING, f"{HEADING}\n## {version} - {day.isoformat()}\n", 1)
    (root / CHANGELOG).write_text(dated, encoding="utf-8")


def build(root: Path, day: date, folder: Path) -> dict[str, bytes]:
    """Return wheel and sdist of the files as they stand, built in an empty folder of theirs.

    Their dates are the midnight of the release, so that anybody can build the same bytes.
    """
    revision = run_in(root, "git", "stash", "create") or "HEAD"
    archive = folder / "source.tar"
    run_in(root, "git", "archive", "-o", str(archive), revision)
    with tarfile.open(archive) as packed:
        packed.extractall(folder / "source", filter="data")
    midnight = datetime.combine(day, time(), UTC)
    epoch = str(int(midnight.timestamp()))
    built = folder / "dist"
    words = (sys.executable, "-m", "build", "--outdir", str(built), ".")
    run_in(folder / "source", *words, SOURCE_DATE_EPOCH=epoch)
    return {path.name: path.read_bytes() for path in sorted(built.iterdir())}


def build_twice(root: Path, day: date) -> dict[str, bytes]:
    """Return wheel and sdist; ConfigError where a second build has other bytes."""
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        files, again = build(root, day, Path(first)), build(root, day, Path(second))
        differing = [name for name in {**files, **again} if files.get(name) != again.get(name)]
        if differing:
            raise ConfigError(f"built twice, these have other bytes: {', '.join(differing)}")
        built = [str(Path(first) / "dist" / name) for name in files]
        run_in(root, sys.executable, "-m", "twine", "check", "--strict", *built)
    return files


@contextmanager
def restored_on_failure(root: Path) -> Iterator[None]:
    """Put the committed files back where the release fails; the desk was clean before."""
    try:
        yield
    except BaseException:
        run_in(root, "git", "restore", "--staged", "--worktree", ".")
        raise


def make_release(root: Path, version: str, day: date) -> dict[str, bytes]:
    """Set, build, commit and tag a version; return its files, which lie in ``dist``."""
    check_desk(root)
    check_version(root, version)
    check_changelog(root)
    with restored_on_failure(root):
        write_version(root, version, day)
        files = build_twice(root, day)
        run_in(root, "git", "commit", "--all", "--message", f"Release {version}")
    run_in(root, "git", "tag", "--annotate", f"v{version}", "--message", f"trainer {version}")
    (root / "dist").mkdir(exist_ok=True)
    for name, content in files.items():
        (root / "dist" / name).write_bytes(content)
    return files


@click.command()
@click.argument("version")
def release(version: str) -> None:
    r"""Set, build, commit and tag a version, on main and with nothing left to commit.

    \b
    Example:  python -m tests.release 0.2.0

    Nothing is published. Exit codes: 0 done, 2 refused, and nothing has changed.
    """
    lacking = [name for name in TOOLS if find_spec(name) is None]
    if lacking:
        raise ConfigError(f"{', '.join(lacking)}: not installed; pip install --group release")
    files = make_release(ROOT, version, datetime.now(UTC).date())
    for name, content in files.items():
        click.echo(f"{sha256(content).hexdigest()}  dist/{name}")
    click.echo(f"v{version} is committed and tagged here. To publish:")
    click.echo(f"  git push origin {BRANCH} v{version}")
    click.echo("which has release.yml build the same bytes; or, without the host's workflows:")
    click.echo(f"  python -m twine upload {' '.join(f'dist/{name}' for name in files)}")


if __name__ == "__main__":
    run_command(release, "python -m tests.release")

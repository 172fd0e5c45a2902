"""``python -m tests.tagged v0.2.0`` builds what a tag says, for release.yml to publish.

The files lie in ``dist``, the changelog's part of that version in ``build/notes.md``.
"""

import re
import sys
from datetime import date
from hashlib import sha256
from pathlib import Path
from typing import Final

import click

sys.path.insert(0, str(Path(__file__).parent))  # packages of tests/ go by their own names

from helpers.address import project_urls
from helpers.places import ROOT
from release import CHANGELOG, DAY_LINES, VERSION_LINES, build_twice, day_in, version_in

from trainer.cli.main import run_command
from trainer.config.files import ConfigError

NOTES: Final = "build/notes.md"


def check_told(root: Path, version: str, day: str) -> None:
    """Raise ConfigError where a file says another version or day."""
    told = {file: version_in(root, file) for file in VERSION_LINES}
    days = {file: day_in(root, file) for file in DAY_LINES}
    faults = [f"{file} says {each}" for file, each in told.items() if each != version]
    faults += [f"{file} says {each}" for file, each in days.items() if each != day]
    if faults:
        raise ConfigError(f"v{version} of {day}: {', '.join(faults)}: set it by tests.release")


def changelog_part(root: Path, version: str) -> tuple[str, str]:
    """Return day and text of a version in the changelog; ConfigError where it has none."""
    text = (root / CHANGELOG).read_text(encoding="utf-8")
    heading = rf"^## {re.escape(version)} - (\d{{4}}-\d\d-\d\d)\n"
    found = re.search(heading + r"(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL)
    if found is None:
        raise ConfigError(f"{CHANGELOG}: has no heading '## {version} - DAY'")
    return found[1], found[2].strip() + "\n"


def check_address(address: str | None) -> None:
    """Raise ConfigError where the project says that it lives elsewhere."""
    said = project_urls()["Source"]
    if address is not None and address != said:
        raise ConfigError(
            f"pyproject.toml, [project.urls] Source: says {said}, and this is {address}: write "
            "that, then type `python -m helpers.address` in tests/"
        )


@click.command()
@click.argument("tag")
@click.option("--address", help="Where the repository is; another than pyproject's is refused.")
def tagged(tag: str, address: str | None) -> None:
    r"""Build wheel and sdist of a tag twice, compare and check them, and cut its notes out.

    \b
    Example:  python -m tests.tagged v0.2.0

    Exit codes: 0 done, 2 refused.
    """
    check_address(address)
    version = tag.removeprefix("v")
    day, notes = changelog_part(ROOT, version)
    check_told(ROOT, version, day)
    files = build_twice(ROOT, date.fromisoformat(day))
    for folder in ("dist", "build"):
        (ROOT / folder).mkdir(exist_ok=True)
    for name, content in files.items():
        (ROOT / "dist" / name).write_bytes(content)
        click.echo(f"{sha256(content).hexdigest()}  dist/{name}")
    (ROOT / NOTES).write_text(notes, encoding="utf-8")
    click.echo(f"{len(notes.splitlines())} lines of notes in {NOTES}")


if __name__ == "__main__":
    run_command(tagged, "python -m tests.tagged")

"""``python -m tests.nightly``: what proves the trainer beyond `.ci/run`, before a release.

Each part is a command of its own, with what it found on its last line. The parts run one after the
other, so that those that look at the clock have the machine.
"""

import os
import subprocess
import sys
import time
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path
from typing import Final

import click

sys.path.insert(0, str(Path(__file__).parent))  # packages of tests/ go by their own names

from helpers.places import CHECKOUT

PYTEST: Final = ("pytest", "-q", "-n", "2")
FUZZING_S: Final = "20"  # [s] for each reader


@dataclass(frozen=True)
class Part:
    """A command, and what it shows."""

    shows: str
    words: tuple[str, ...]  # after `python -m`
    environment: dict[str, str] = field(default_factory=dict)


PARTS: Final = {
    "laws": Part(
        "twenty laws and the standard hour hold without JIT",
        ("pytest", "-q", "-m", "laws"),
        {"NUMBA_DISABLE_JIT": "1"},
    ),
    "bounds": Part(
        "no kernel of the core leaves its arrays",
        (*PYTEST, "-m", "core and not slow"),
        {"NUMBA_BOUNDSCHECK": "1"},
    ),
    "slow": Part(
        "long flights, fits and guides, further sizes and browsers, every command of the documents",
        (*PYTEST, "-m", "slow"),
        {"CI_APT": "1"},
    ),
    "lowest": Part(
        "the lowest version of every library that is allowed will do", ("tests.lowest",)
    ),
    "learners": Part(
        "Stable-Baselines3 finds no fault with the exercises as environments", ("tests.learners",)
    ),
    "site": Part(
        "the documents as a site: every link leads somewhere, nothing comes from another host",
        ("mkdocs", "build", "--strict"),
    ),
    "soak": Part("a day under everything", ("tests.soak",)),
    "soak-by-the-clock": Part(
        "half an hour of it by the clock: no tick missed", ("tests.soak", "--real-time")
    ),
    "faults": Part("kills, full disks, pulled plugs", ("tests.faults",)),
    "simulation": Part(
        "whole sessions by ten thousand seeds",
        ("tests.simulation", "--seeds", "10000", "--jobs", "2", "--reached"),
    ),
    "classes": Part(
        "classes of three sessions in one sea, with kills and replays of each",
        ("tests.simulation", "--class", "--seeds", "2000"),
    ),
    "exploring": Part(
        "sessions that go on from where others came for the first time",
        ("tests.simulation", "--explore", "--seeds", "2000", "--seconds", "10"),
    ),
    "mutation": Part(
        "what finds a hundred faults of one place, on Sundays",
        ("tests.mutation", "--jobs", "2", "--minutes", "300", "--on", "sunday"),
    ),
    "mutants": Part(
        "what finds a dozen faults of one place", ("tests.mutation", "--mutants", "12")
    ),
    "damaged": Part("damaged recordings", ("tests.faults", "--damaged", "2000")),
    "layouts": Part(
        "recordings of any layout: no command ruins one", ("tests.layouts", "--seeds", "500")
    ),
    "fuzz": Part(
        "bad input at every reader", ("tests.fuzz", "--seconds", FUZZING_S, "--jobs", "2")
    ),
}


@click.command()
@click.argument("names", nargs=-1, type=click.Choice(list(PARTS)))
def nightly(names: tuple[str, ...]) -> None:
    r"""Run what is too long for every commit, and print a row of docs/promises.md for each part.

    \b
    Example:  python -m tests.nightly
              python -m tests.nightly laws bounds

    Exit codes: 0 all kept, 1 something is broken.
    """
    verdicts = [run_part(name, PARTS[name]) for name in names or PARTS]
    click.echo("\n| part | shows | last run | found |\n| --- | --- | --- | --- |")
    click.echo("\n".join(row for row, _ in verdicts))
    sys.exit(0 if all(kept for _, kept in verdicts) else 1)


def run_part(name: str, part: Part) -> tuple[str, bool]:
    """Run a part in sight; return its row, and whether it kept what it shows."""
    click.echo(f"\n== {name}: {part.shows}")
    begun, last = time.monotonic(), ""
    environment = os.environ | {"PYTHONPATH": CHECKOUT} | part.environment
    with subprocess.Popen(
        [sys.executable, "-m", *part.words], env=environment, stdout=subprocess.PIPE, text=True
    ) as process:
        for line in process.stdout or ():
            click.echo(line, nl=False)
            last = line.strip(" =\n") or last
    kept = process.returncode == 0
    minutes = (time.monotonic() - begun) / 60.0
    verdict = last if kept else f"BROKEN: {last}"
    today = datetime.now(UTC).date()
    return f"| `{name}` | {part.shows} | {today}, {minutes:.0f} min | {verdict} |", kept


if __name__ == "__main__":
    nightly()

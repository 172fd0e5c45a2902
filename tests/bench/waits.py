"""What users wait for: processor seconds of whole commands, each in a new process.

Processor time is of the command and all that it starts. It is nearly the same at any load, where a
clock on the wall is not. Each command runs once before it counts, so that numba has kept its code.
"""

import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trainer.config.exercise.course import course
from trainer.config.files import ConfigError

Commands = tuple[tuple[str, ...], ...]
MOST_OF_EXERCISE_S: Final = 5.0  # goal of each exercise
MEDIAN_OF_EXERCISES_S: Final = 1.0
COMMANDS: Final[dict[str, Commands]] = {
    "a start, to the end of the first second": (
        ("run", "--headless", "--duration", "1", "--no-record"),
    ),
    "an hour of BB2 to CSV": (
        ("run", "--headless", "--duration", "1h", "--speed", "max", "--csv", "hour.csv"),
    ),
    "a turning circle": (("boat", "manoeuvre", "turning-circle", "bb2"),),
    "the guide of BB2": (("boat", "guide", "bb2", "--html", "guide.html"),),
    "a sweep of 200 turns": (("boat", "sweep", "turn-uncertainty", "--out", "turns"),),
    "a ship identified": (("identify", "--example"),),
}


@dataclass(frozen=True)
class Waits:
    """Processor seconds [s] of commands, and of exercises flown and debriefed."""

    commands: dict[str, float]
    exercises: dict[str, float]


def time_waits() -> Waits:
    """Return what each command takes."""
    flown = {
        each.name: (("run", each.name, "--headless", "--speed", "max", "--debrief", "run.html"),)
        for each in course()
    }
    return Waits(dict(time_each(COMMANDS, processor_s)), dict(time_each(flown, processor_s)))


def time_each(
    commands: Mapping[str, Commands], measure: Callable[[Commands], float]
) -> Iterator[tuple[str, float]]:
    """Yield the time of each; say on stderr which is measured, since all take minutes."""
    for number, (name, words) in enumerate(commands.items(), 1):
        print(f"\r{number} of {len(commands)}: {name:<50}", end="", file=sys.stderr, flush=True)
        measure(words)
        yield name, measure(words)
    print(file=sys.stderr)


def processor_s(commands: Commands) -> float:
    """Return the processor time [s] of commands in a folder of their own; ConfigError.

    Exit code 1 is a boat or an exercise that is lost, since nobody is aboard.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with tempfile.TemporaryDirectory(prefix="trainer-") as folder:
        for words in commands:
            done = subprocess.run(
                [sys.executable, "-m", "trainer", *words],
                cwd=Path(folder),
                check=False,
                stdin=subprocess.DEVNULL,
                capture_output=True,
                text=True,
            )
            if done.returncode not in {0, 1}:
                raise ConfigError(done.stderr.strip())
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def lines(figures: Waits) -> list[str]:
    """Return the figures as lines of a page."""
    median = statistics.median(figures.exercises.values())
    return [
        "",
        "WHAT USERS WAIT FOR (processor seconds of whole commands; goals in brackets)",
        *(f"  {name:<42}{took:7.2f}" for name, took in figures.commands.items()),
        f"  {'exercises flown and debriefed, median':<42}{median:7.2f} ({MEDIAN_OF_EXERCISES_S:g})",
        *(
            f"    {name:<40}{took:7.2f}{f' ({MOST_OF_EXERCISE_S:g})' if number == 0 else ''}"
            for number, (name, took) in enumerate(
                sorted(figures.exercises.items(), key=lambda each: -each[1])
            )
        ),
    ]

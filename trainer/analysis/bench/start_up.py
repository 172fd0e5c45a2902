"""The delay of commands: help, a first start, a later one, the console.

``trainer dev bench --starting`` measures it. Each is a process of its own, timed from its start by
the clock, the least of a few: others can only add to it. It is given beside what importing numba
alone takes then.
"""

import contextlib
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from trainer.analysis.bench.end_to_end import TRAINER_COMMAND, on_terminal

START_COUNT: Final = 3  # starts of each command, of which the fastest counts
RUN_WORDS: Final = ("run", "--headless", "--duration", "0.5", "--no-record", "--speed", "max")
SHOWN_NUMBER: Final = re.compile(rb"[0-9]\.[0-9]")  # a depth or a course on the screen
SCREEN_TIMEOUT_S: Final = 60.0  # [s]


@dataclass(frozen=True)
class StartTimes:
    """Times [s] from the start of a process."""

    python: float  # to nothing
    numba: float  # to numba imported
    help: float  # `trainer --help`, to its end
    first_run: float  # with an empty cache: to its end after one tick
    later_run: float  # the same, as it is here
    console: float | None  # `trainer run` on a terminal, to its first figures; None without one
    console_times_numba: float | None


def time_starts() -> StartTimes:
    """Return how soon commands answer."""
    numba = least(lambda: time_to_end(sys.executable, "-c", "import numba"))
    with empty_cache() as environment:
        first = least(lambda: time_to_end(*TRAINER_COMMAND, *RUN_WORDS, **environment))
    console = least(time_to_screen) if hasattr(os, "openpty") else None
    return StartTimes(
        python=least(lambda: time_to_end(sys.executable, "-c", "pass")),
        numba=numba,
        help=least(lambda: time_to_end(*TRAINER_COMMAND, "--help")),
        first_run=first,
        later_run=least(lambda: time_to_end(*TRAINER_COMMAND, *RUN_WORDS)),
        console=console,
        console_times_numba=console and console / numba,
    )


def least(measure: Callable[[], float]) -> float:
    """Return the least of a few measurements."""
    return min(measure() for _ in range(START_COUNT))


def time_to_end(*command: str, **environment: str) -> float:
    """Return how long [s] a process took from its start to its end."""
    begun = time.perf_counter()
    subprocess.run(  # noqa: S603
        command, env=os.environ | environment, stdin=subprocess.DEVNULL, capture_output=True,
        check=True,
    )  # fmt: skip
    return time.perf_counter() - begun


@contextlib.contextmanager
def empty_cache() -> Iterator[dict[str, str]]:
    """Yield the environment of a machine where nothing is compiled."""
    with tempfile.TemporaryDirectory(prefix="bench-") as name:
        yield {"NUMBA_CACHE_DIR": name}


def time_to_screen() -> float:
    """Return how long [s] the console took to show its first figures."""
    with tempfile.TemporaryDirectory(prefix="bench-") as folder:
        begun = time.perf_counter()
        with on_terminal("run", "--no-record", "--socket", f"{folder}/s") as (screen, process):
            match = screen.find(SHOWN_NUMBER, time.monotonic() + SCREEN_TIMEOUT_S)
            seconds = time.perf_counter() - begun
            process.terminate()
            while process.poll() is None:
                screen.hear(time.monotonic() + 0.1)
    return seconds if match else float("inf")


def lines(figures: StartTimes) -> list[str]:
    """Return the figures as lines of a page."""
    rows = [
        ("python -c pass", figures.python),
        ("import numba", figures.numba),
        ("trainer --help", figures.help),
        ("a run to its first tick, the first ever", figures.first_run),
        ("a run to its first tick, later", figures.later_run),
    ]
    page = ["", "STARTING (from the start of the process, the least of a few)"]
    page += [f"  {name:<44}{1e3 * seconds:8.0f} ms" for name, seconds in rows]
    if figures.console is not None and figures.console_times_numba is not None:
        name, times = "trainer run: figures on the console", figures.console_times_numba
        took = f"{1e3 * figures.console:8.0f} ms, {times:.2f} times import numba"
        page.append(f"  {name:<44}{took}")
    return page

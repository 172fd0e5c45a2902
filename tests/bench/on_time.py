"""The lateness of ticks: bare loops of the clock, and a session in a crowd.

``python -m tests.bench --on-time`` measures it. A loop of 100 Hz is timed in a process of its own:
alone, beside a busy thread of the same process, and beside busy processes, with and without a
real-time priority.

The crowd: processes that do nothing but compute, one for each processor; a console on a terminal; a
file for Rerun, where its library is; a serial line whose other end is not read.
"""

import contextlib
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from helpers.places import tests_environment

from bench.terminal import line, on_terminal
from trainer.analysis.bench.delays import serving
from trainer.analysis.bench.ticks import PacedTicks, read_ticks, row
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.io.paths import LISTENING_TEXT
from trainer.session.time.ledger import Spread

NAME_WIDTH: Final = 26
BUSY_COMMAND: Final = (sys.executable, "-c", "while True: pass")
END_TIMEOUT_S: Final = 60.0  # [s] for a process to end, beyond the time it was given
SUBSCRIBE_LINES: Final = ("subscribe gauges at 50 hz", "subscribe steering at 50 hz")
MISSED_TICK_COUNTS: Final = ("overruns", "slipped", "gaps")  # of a run
LOOP_STEP_S: Final = 0.01  # [s]
METRONOME_COMMAND: Final = (sys.executable, "-m", "bench.metronome")


@dataclass(frozen=True)
class CrowdLateness:
    """The ticks of a session among all that could hold it up."""

    among: tuple[str, ...]
    granted: str
    step_s: float
    ticks: int
    missed: int  # deadlines: overruns, slipped ticks and gaps
    lateness: Spread


@contextlib.contextmanager
def busy_processors(count: int) -> Iterator[None]:
    """Keep ``count`` processors busy inside the block."""
    with contextlib.ExitStack() as stack:
        for _ in range(count):
            process = stack.enter_context(subprocess.Popen(BUSY_COMMAND))
            stack.callback(process.kill)
        yield


def sail_in_crowd(file: VesselFile, seconds: float) -> CrowdLateness:
    """Return the lateness of a session of ``seconds`` [s]; ConfigError if the session failed."""
    rerun = importlib.util.find_spec("rerun") is not None
    count = os.cpu_count() or 1
    with (
        tempfile.TemporaryDirectory(prefix="trainer-") as name,
        line() as hung,
        busy_processors(count),
    ):
        folder = Path(name)
        words = ["--vessel", str(file.path), "--duration", str(seconds)]
        words += ["--line", f"helm={hung.name}", "--listen", "none"]
        words += ["--socket", str(folder / "s"), "--record", str(folder / "run.trainer")]
        words += ["--rrd", str(folder / "run.rrd")] if rerun else []
        for wish in SUBSCRIBE_LINES:
            hung.say(wish)  # and nothing that it brings is ever read
        with serving(LISTENING_TEXT, *words) as (session, _), open_console(folder / "s"):
            summary, complaint = session.communicate(timeout=seconds + END_TIMEOUT_S)
        if session.returncode:
            raise ConfigError(f"the session among the crowd failed: {complaint.strip()}")
        ticks = read_ticks(folder / "run.trainer", summary)
    among = (f"{count} busy processes", "a console", "a hung serial line")
    return CrowdLateness(
        among=(*among, "a Rerun file") if rerun else among,
        granted=ticks.granted,
        step_s=file.run.step_s,
        ticks=ticks.ticks,
        missed=count_missed(ticks),
        lateness=ticks.lateness,
    )


@contextlib.contextmanager
def open_console(socket: Path) -> Iterator[None]:
    """Keep the instructor's screen open on a terminal inside the block."""
    with on_terminal("attach", "--connect", str(socket)) as (screen, process):

        def look() -> None:
            while process.poll() is None:  # what it draws is read until it has ended
                screen.hear(time.monotonic() + 0.2)
                screen.received = b""

        looker = threading.Thread(target=look)
        looker.start()
        try:
            yield
        finally:
            process.kill()
            looker.join()


def count_missed(ticks: PacedTicks) -> int:
    """Return how many deadlines a run missed."""
    return sum(ticks.counts[name] for name in MISSED_TICK_COUNTS)


@dataclass(frozen=True)
class LoopLateness:
    """How late the ticks of a loop began, and which priority the system granted."""

    granted: str
    lateness: Spread


@dataclass(frozen=True)
class TickPunctuality:
    """How late ticks begin, by what else goes on."""

    seconds: float  # of each loop
    busy_processes: int
    alone: LoopLateness
    beside_thread: LoopLateness  # with a real-time priority, where permitted, as a run has it
    beside_processes: LoopLateness
    realtime: LoopLateness  # beside processes too
    crowd: CrowdLateness


def time_ticks(file: VesselFile, seconds: float, minutes: float) -> TickPunctuality:
    """Return the figures of loops of ``seconds`` [s]. A session of ``minutes`` is in a crowd."""
    count = os.cpu_count() or 1
    alone, beside_thread = measure_loop(seconds), measure_loop(seconds, "busy", "realtime")
    with busy_processors(count):
        beside, realtime = measure_loop(seconds), measure_loop(seconds, "realtime")
    return TickPunctuality(
        seconds=seconds,
        busy_processes=count,
        alone=alone,
        beside_thread=beside_thread,
        beside_processes=beside,
        realtime=realtime,
        crowd=sail_in_crowd(file, 60.0 * minutes),
    )


def measure_loop(seconds: float, *words: str) -> LoopLateness:
    """Return the lateness of a loop in a process of its own."""
    command = [*METRONOME_COMMAND, str(seconds), str(LOOP_STEP_S), *words]
    ran = subprocess.run(
        command, env=tests_environment(), capture_output=True, text=True, check=True
    )
    answer: dict[str, Any] = json.loads(ran.stdout)
    return LoopLateness(answer.pop("granted"), Spread(**answer))


def lines(figures: TickPunctuality) -> list[str]:
    """Return the figures as lines of a page."""
    crowd, busy = figures.crowd, f"beside {figures.busy_processes} busy processes"
    rows = [
        row("alone", figures.alone.lateness, NAME_WIDTH),
        row("beside a busy thread", figures.beside_thread.lateness, NAME_WIDTH),
        row(busy, figures.beside_processes.lateness, NAME_WIDTH),
        row(f" {figures.realtime.granted.split(',')[0]}", figures.realtime.lateness, NAME_WIDTH),
    ]
    return [
        "",
        f"ON TIME (late by; a loop of {1.0 / LOOP_STEP_S:.0f} Hz for {figures.seconds:g} s each)",
        *rows,
        f"  a session of {crowd.ticks} ticks, {crowd.step_s:g} s apart, among",
        f"  {', '.join(crowd.among)}:",
        row(f" {crowd.missed} deadlines missed", crowd.lateness, NAME_WIDTH),
        f"    {crowd.granted}",
    ]

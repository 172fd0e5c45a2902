"""The lateness of ticks: bare loops of the clock, and a session in a crowd.

``trainer dev bench --on-time`` measures it. A loop of 100 Hz is timed in a process of its own:
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

from trainer.analysis.bench.end_to_end import begin_session, line, on_terminal
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import ConfigError
from trainer.io.paths import LISTENING_TEXT
from trainer.io.recording.recording import Recording
from trainer.session.time.ledger import Histogram, Spread

BUSY_COMMAND: Final = (sys.executable, "-c", "while True: pass")
END_TIMEOUT_S: Final = 60.0  # [s] for a process to end, beyond the time it was given
SUBSCRIBE_LINES: Final = ("subscribe gauges at 50 hz", "subscribe steering at 50 hz")
MISSED_TICK_COUNTS: Final = ("overruns", "slipped", "gaps")  # in the account of a run
LOOP_STEP_S: Final = 0.01  # [s]
METRONOME_COMMAND: Final = (sys.executable, "-m", "trainer.analysis.bench.metronome")


@dataclass(frozen=True)
class CrowdLateness:
    """The ticks of a session among all that could hold it up."""

    among: tuple[str, ...]
    granted: str
    step_s: float
    ticks: int
    missed: int  # deadlines: overruns, slipped ticks and gaps
    lateness: Spread


def machine_load() -> float | None:
    """Return how many processes wanted a processor in the last minute, None if nobody knows."""
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def load_line(load: float | None) -> str:
    """Return a ``machine_load`` before a bench as a line of its page."""
    told = "unknown" if load is None else f"{load:.2f} processes"
    return f"load of the machine in the minute before: {told}"


@contextlib.contextmanager
def busy_processors(count: int) -> Iterator[None]:
    """Keep ``count`` processors busy inside the block."""
    with contextlib.ExitStack() as stack:
        for _ in range(count):
            process = stack.enter_context(subprocess.Popen(BUSY_COMMAND))  # noqa: S603  our own
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
        with begin_session(words) as session:
            try:
                for written in session.stderr or ():  # until stations can join, or it is over
                    if LISTENING_TEXT in written:
                        break
                with open_console(folder / "s"):
                    account, complaint = session.communicate(timeout=seconds + END_TIMEOUT_S)
            finally:
                session.kill()
        if session.returncode:
            raise ConfigError(f"the session among the crowd failed: {complaint.strip()}")
        lateness, ticks = lateness_of(folder / "run.trainer")
    among = (f"{count} busy processes", "a console", "a hung serial line")
    return CrowdLateness(
        among=(*among, "a Rerun file") if rerun else among,
        granted=account_entry(account, "the clock"),
        step_s=file.run.step_s,
        ticks=ticks,
        missed=count_missed(account_entry(account, "on time")),
        lateness=lateness,
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


def lateness_of(recording: Path) -> tuple[Spread, int]:
    """Return how late the ticks of a recorded run began, and how many there were."""
    histogram, ticks = Histogram(), 0
    with contextlib.closing(Recording.look(recording)) as run:
        for _, lateness, _ in run.ledger(run.branch):
            histogram.add(lateness)
            ticks += 1
    return histogram.spread(), ticks


def account_entry(account: str, name: str) -> str:
    """Return what an account says under a name, "" if it says nothing."""
    entries = [text for text in account.splitlines() if text.startswith(name)]
    return entries[0].removeprefix(name).strip() if entries else ""


def count_missed(entry: str) -> int:
    """Return how many deadlines an account says were missed."""
    parts = (part.split() for part in entry.split(","))
    return sum(int(part[1]) for part in parts if part and part[0] in MISSED_TICK_COUNTS)


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
    ran = subprocess.run(command, capture_output=True, text=True, check=True)  # noqa: S603
    answer: dict[str, Any] = json.loads(ran.stdout)
    return LoopLateness(answer.pop("granted"), Spread(**answer))


def lines(figures: TickPunctuality) -> list[str]:
    """Return the figures as lines of a page."""
    crowd, busy = figures.crowd, f"beside {figures.busy_processes} busy processes"
    rows = [
        row("alone", figures.alone.lateness),
        row("beside a busy thread", figures.beside_thread.lateness),
        row(busy, figures.beside_processes.lateness),
        row(f"  {figures.realtime.granted.split(',')[0]}", figures.realtime.lateness),
    ]
    return [
        "",
        f"ON TIME (a loop of {1.0 / LOOP_STEP_S:.0f} Hz for {figures.seconds:g} s each)",
        head("lateness [us]"),
        *rows,
        f"  a session of {crowd.ticks} ticks, {crowd.step_s:g} s apart, among",
        f"  {', '.join(crowd.among)}:",
        row(f"  {crowd.missed} deadlines missed", crowd.lateness),
        f"    {crowd.granted}",
    ]


def head(name: str, width: int = 34) -> str:
    """Return the heading of rows of percentiles."""
    return f"  {name:<{width}}{'median':>11}{'99 %':>11}{'99.9 %':>11}{'most':>11}"


def row(name: str, spread: Spread, width: int = 34) -> str:
    """Return a row of percentiles [us]."""
    times = (spread.p50_ns, spread.p99_ns, spread.p999_ns, spread.max_ns)
    return f"  {name:<{width}}" + "".join(f"{time / 1e3:11.1f}" for time in times)

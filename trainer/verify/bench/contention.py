"""A real-time session among all that could hold it up, and its missed deadlines.

Processes that do nothing but compute, one for each processor; a console on a terminal; a file for
Rerun, where its library is; a serial line whose other end is not read.
"""

import contextlib
import importlib.util
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from trainer.config.files import ConfigError
from trainer.config.vessel import VesselFile
from trainer.io.recording.recording import Recording
from trainer.session.time.ledger import Histogram, Spread
from trainer.verify.bench.end_to_end import TRAINER, Line, line

BUSY: Final = (sys.executable, "-c", "while True: pass")
ENDED: Final = 60.0  # [s] for a process to end, beyond the time it was given
WISHES: Final = ("subscribe gauges at 50 hz", "subscribe steering at 50 hz")
MISSED: Final = ("overruns", "slipped", "gaps")  # in the account of a run


@dataclass(frozen=True)
class Crowd:
    """The ticks of a session among all that could hold it up."""

    among: tuple[str, ...]
    granted: str
    step_s: float
    ticks: int
    missed: int  # deadlines: overruns, slipped ticks and gaps
    lateness: Spread


@contextlib.contextmanager
def hogs(count: int) -> Iterator[None]:
    """Keep ``count`` processors busy inside the block."""
    with contextlib.ExitStack() as stack:
        for _ in range(count):
            process = stack.enter_context(subprocess.Popen(BUSY))  # noqa: S603  our own
            stack.callback(process.kill)
        yield


def sail_in_crowd(file: VesselFile, seconds: float) -> Crowd:
    """Return what became of the ticks of ``seconds`` [s]; ConfigError if the session failed."""
    rerun = importlib.util.find_spec("rerun") is not None
    count = os.cpu_count() or 1
    with tempfile.TemporaryDirectory(prefix="trainer-") as name, line() as hung, hogs(count):
        folder = Path(name)
        words = ["--vessel", str(file.path), "--duration", str(seconds)]
        words += ["--line", f"helm={hung.name}", "--listen", "none"]
        words += ["--socket", str(folder / "s"), "--record", str(folder / "run.trainer")]
        words += ["--rrd", str(folder / "run.rrd")] if rerun else []
        account = run_attended(words, folder, hung, seconds)
        lateness, ticks = lateness_of(folder / "run.trainer")
    among = (f"{count} busy processes", "a console", "a hung serial line")
    return Crowd(
        among=(*among, "a Rerun file") if rerun else among,
        granted=entry(account, "the clock"),
        step_s=file.run.step_s,
        ticks=ticks,
        missed=count_missed(entry(account, "on time")),
        lateness=lateness,
    )


def run_attended(words: list[str], folder: Path, hung: Line, seconds: float) -> str:
    """Return the account of a session that a console attends, and a line that hangs."""
    for wish in WISHES:
        hung.say(wish)  # and nothing that it brings is ever read
    with subprocess.Popen(  # noqa: S603  our own program
        [*TRAINER, "serve", *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as session:
        try:
            await_listening(session)
            with console(folder / "s"):
                out, complaint = session.communicate(timeout=seconds + ENDED)
        finally:
            session.kill()
    if session.returncode:
        raise ConfigError(f"the session among the crowd failed: {complaint.strip()}")
    return out


def await_listening(session: "subprocess.Popen[str]") -> None:
    """Wait until stations can join a session, or it is over."""
    for text in session.stderr or ():
        if "listening at" in text:
            return


@contextlib.contextmanager
def console(socket: Path) -> Iterator[None]:
    """Keep the instructor's screen open on a terminal inside the block."""
    with line() as screen:
        terminal = os.open(screen.name, os.O_RDWR | os.O_NOCTTY)
        with subprocess.Popen(  # noqa: S603  our own program
            [*TRAINER, "attach", "--connect", str(socket)],
            stdin=terminal,
            stdout=terminal,
            stderr=terminal,
            env=os.environ | {"TERM": "xterm-256color"},
        ) as process:
            os.close(terminal)
            looker = threading.Thread(target=look, args=(screen, process))
            looker.start()
            try:
                yield
            finally:
                process.kill()
                looker.join()


def look(screen: Line, process: "subprocess.Popen[bytes]") -> None:
    """Read what a screen draws until its process has ended."""
    while process.poll() is None:
        screen.hear(time.monotonic() + 0.2)
        screen.said = b""


def lateness_of(recording: Path) -> tuple[Spread, int]:
    """Return how late the ticks of a recorded run began, and how many there were."""
    histogram, ticks = Histogram(), 0
    with contextlib.closing(Recording.look(recording)) as run:
        for _, lateness, _ in run.ledger(run.branch):
            histogram.add(lateness)
            ticks += 1
    return histogram.spread(), ticks


def entry(account: str, name: str) -> str:
    """Return what an account says under a name, "" if it says nothing."""
    found = [text for text in account.splitlines() if text.startswith(name)]
    return found[0].removeprefix(name).strip() if found else ""


def count_missed(entry: str) -> int:
    """Return how many deadlines an account says were missed."""
    parts = (part.split() for part in entry.split(","))
    return sum(int(part[1]) for part in parts if part and part[0] in MISSED)

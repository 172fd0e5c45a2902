"""Processes of this program beside a session, whose memory and answers do not feel them."""

import contextlib
import os
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from trainer.session.exercise import CLOSE_TIMEOUT_S

LOWEST_NICENESS: Final = 19
LOOK_PERIOD_S: Final = 0.2  # [s] between looks whether a process has ended
CLOSE_MARGIN_S: Final = 5.0  # [s] of a session's patience at its end in which a process is ended


def begin_aside(
    words: Sequence[str], *, stdin: int = subprocess.DEVNULL, stderr: int = subprocess.DEVNULL
) -> subprocess.Popen[bytes]:
    """Begin a process of this program that gives way to everything else; OSError.

    It would else inherit a session's real-time priority. It outlives the session if need be.
    """
    process = subprocess.Popen(  # noqa: S603  our own program
        [sys.executable, "-P", *words],
        stdin=stdin,
        stdout=subprocess.PIPE,
        stderr=stderr,
        start_new_session=True,
    )
    with contextlib.suppress(OSError):
        if sys.platform == "linux":
            os.sched_setscheduler(process.pid, os.SCHED_OTHER, os.sched_param(0))
        if hasattr(os, "setpriority"):
            os.setpriority(os.PRIO_PROCESS, process.pid, LOWEST_NICENESS)
    return process


def hear_out(
    process: subprocess.Popen[bytes], closing: threading.Event, patience: float
) -> tuple[bytes, bytes]:
    """Return all that a process says.

    TimeoutExpired where it has not ended within ``patience`` [s] of a session's own end.
    """
    while not closing.is_set():
        with contextlib.suppress(subprocess.TimeoutExpired):
            return process.communicate(timeout=LOOK_PERIOD_S)
    return process.communicate(timeout=patience)


def written_aside(words: Sequence[str], closing: threading.Event) -> Path:
    """Return the file that a process writes and names; RuntimeError with why there is none.

    A session that ends waits for it, though not longer than for what it does itself.
    """
    process = begin_aside(words, stderr=subprocess.PIPE)
    try:
        said, wrong = hear_out(process, closing, CLOSE_TIMEOUT_S - CLOSE_MARGIN_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        raise RuntimeError("the session ended before it was written") from None
    if process.returncode:
        lines = wrong.decode(errors="replace").split("\n")
        why = next(filter(None, reversed(lines)), "")
        raise RuntimeError(why or f"its process has ended with {process.returncode}")
    return Path(said.decode("utf-8", "surrogateescape").rstrip("\r\n"))

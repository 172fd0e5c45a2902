"""Processes of this program beside a session, whose memory and answers do not feel them."""

import contextlib
import os
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
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
    process: subprocess.Popen[bytes],
    closing: threading.Event,
    patience: float,
    heard: Callable[[bytes], object] = lambda _: None,
) -> tuple[bytes, bytes]:
    """Return all that a process says.

    ``heard`` is told, now and then, what it has said so far. TimeoutExpired where it has not ended
    within ``patience`` [s] of a session's own end.
    """
    while not closing.is_set():
        try:
            return process.communicate(timeout=LOOK_PERIOD_S)
        except subprocess.TimeoutExpired as waiting:
            heard(waiting.output or b"")
    return process.communicate(timeout=patience)


def answer_aside(
    words: Sequence[str], closing: threading.Event, share: Callable[[float], object]
) -> str:
    """Return the last line of a process; RuntimeError with why there is none.

    The lines before it are shares of its work, which ``share`` is told. A session that ends waits
    for it, though not longer than for what it does itself.
    """
    told = b""

    def heard(said: bytes) -> None:
        nonlocal told
        last = said.rpartition(b"\n")[0].rpartition(b"\n")[2]
        if last != told:
            told = last
            with contextlib.suppress(ValueError):  # it is the answer already
                share(float(last))

    process = begin_aside(words, stderr=subprocess.PIPE)
    try:
        said, wrong = hear_out(process, closing, CLOSE_TIMEOUT_S - CLOSE_MARGIN_S, heard)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        raise RuntimeError("the session ended before it was written") from None
    if process.returncode:
        lines = wrong.decode(errors="replace").split("\n")
        why = next(filter(None, reversed(lines)), "")
        raise RuntimeError(why or f"its process has ended with {process.returncode}")
    return said.decode().rstrip("\r\n").rpartition("\n")[2]

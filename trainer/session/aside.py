"""Work beside a session, in threads and in processes of this program."""

import contextlib
import os
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Final, TypeVar

CLOSE_TIMEOUT_S: Final = 20.0  # [s] at the end, for marks and pages
LOWEST_NICENESS: Final = 19
LOOK_PERIOD_S: Final = 0.2  # [s] between looks whether a process has ended
CLOSE_MARGIN_S: Final = 5.0  # [s] of a session's patience at its end in which a process is ended
ResultT = TypeVar("ResultT")


@dataclass
class BackgroundTask:
    """Tasks in threads, and the calls that the session's thread makes with their results.

    A tick cannot wait for a task that takes seconds, such as marks. A result is handed over as a
    call, so that only the session's thread ever changes the session.
    """

    wake: Callable[[], object]  # has the session's thread call ``take_results``
    done: deque[Callable[[], None]] = field(default_factory=deque)
    closing: threading.Event = field(default_factory=threading.Event)
    threads: list[threading.Thread] = field(default_factory=list)

    def begin(
        self,
        name: str,
        make: Callable[[], ResultT],
        take: Callable[[ResultT], None],
        fail: Callable[[Exception], None],
    ) -> None:
        """Make something in a thread. The session's thread then takes it, or hears what failed."""

        def run() -> None:
            try:
                made = make()
            except Exception as error:  # noqa: BLE001 whatever it is, the session goes on
                self.post(partial(fail, error))
            else:
                self.post(partial(take, made))

        thread = threading.Thread(target=run, name=name, daemon=True)
        self.threads = [each for each in self.threads if each.is_alive()] + [thread]
        thread.start()

    def post(self, call: Callable[[], None]) -> None:
        """Hand a call to the session's thread. Any thread may do so."""
        self.done.append(call)
        self.wake()

    def take_results(self) -> None:
        """Make the calls of the tasks that are done. Only the session's thread does so."""
        while self.done:
            self.done.popleft()()

    def finish(self) -> None:
        """Tell tasks that wait to give up, wait for the rest, and make their calls."""
        self.closing.set()
        end = time.monotonic() + CLOSE_TIMEOUT_S
        for thread in self.threads:
            thread.join(max(end - time.monotonic(), 0.0))
        self.take_results()


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

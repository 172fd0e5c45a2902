"""A process forked from this one: out of reach of the terminal's keys, its words kept for us.

It begins with all that is imported here, and so a tenth of a second sooner than a new one would.
"""

import os
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from typing import NoReturn

LOOK = 0.004  # [s] between looks at whether it has ended


class Child:
    """A process of our own at some work."""

    def __init__(self, work: Callable[[], NoReturn]) -> None:
        """Begin; in the child this does not return: ``work`` leaves by SystemExit, as programs do.

        To be called before there are threads.
        """
        self._out, self._err = tempfile.TemporaryFile(), tempfile.TemporaryFile()  # noqa: SIM115
        self._code: int | None = None
        self._asking = threading.Lock()
        sys.stdout.flush()
        sys.stderr.flush()
        self._process = os.fork()
        if not self._process:
            self._leave_home()
            work()

    @property
    def out(self) -> str:
        """Return what it has written to its standard output."""
        return _text(self._out.fileno())

    @property
    def err(self) -> str:
        """Return what it has written to its standard error."""
        return _text(self._err.fileno())

    def ended(self) -> int | None:
        """Return its exit code, of a signal negative; None while it is at work."""
        with self._asking:
            if self._code is None:
                process, status = os.waitpid(self._process, os.WNOHANG)
                if process:
                    self._code = os.waitstatus_to_exitcode(status)
        return self._code

    def wait(self, patience: float) -> int | None:
        """Return its exit code once it has ended; None if it has not in ``patience`` [s]."""
        end = time.monotonic() + patience
        while self.ended() is None and time.monotonic() < end:
            time.sleep(LOOK)
        return self._code

    def terminate(self) -> None:
        """Ask it to end."""
        if self.ended() is None:
            os.kill(self._process, signal.SIGTERM)

    def _leave_home(self) -> None:
        """Let go of the terminal."""
        os.setsid()
        nothing = os.open(os.devnull, os.O_RDWR)
        for ours, theirs in enumerate((nothing, self._out.fileno(), self._err.fileno())):
            os.dup2(theirs, ours)
        os.close(nothing)


def _text(descriptor: int) -> str:
    """Return what a file holds; the place where it is written next stays where it is."""
    size = os.fstat(descriptor).st_size
    return os.pread(descriptor, size, 0).decode("utf-8", errors="replace")

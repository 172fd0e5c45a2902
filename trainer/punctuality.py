"""What a system grants a process that has to be on time: asked for, reported, and given back.

All threads are raised, not the one that ticks alone: a raised thread that waits for the interpreter
held by one that is not would wait for whoever keeps that one off the processor. New threads inherit
what the one that starts them has.
"""

import contextlib
import ctypes
import os
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Final

SWITCH: Final = 120e-6  # [s] after which a thread may ask another for the interpreter
FIRST: Final = 20  # real-time priority of the thread that ticks
REST: Final = 10  # and of the others
THREADS: Final = Path("/proc/self/task")
SET_TIMER_SLACK: Final = 29  # of prctl
IN_USE: Final = 1 | 2 | 4  # of mlockall: now and later, but nothing that is merely set aside
REFUSED: Final = "not permitted"
ABSENT: Final = "not on this system"


@dataclass(frozen=True)
class Granted:
    """What came of asking, in words."""

    priority: str = "normal"
    memory: str = "not locked"
    timer: str = "usual"

    def line(self) -> str:
        """Return it in one line."""
        return f"priority {self.priority}, memory {self.memory}, timer slack {self.timer}"


class Unasked:
    """Asks for nothing: for runs that are on time by the way, and for tests."""

    granted: Granted | None = None

    def keep(self) -> None:
        """Do nothing."""

    def relax(self) -> None:
        """Do nothing."""


class Punctuality:
    """What the thread that ticks, and its process, ask for while time is kept."""

    def __init__(self, *, realtime: bool) -> None:
        """``realtime``: also what can slow down others, a real-time priority and locked memory."""
        self.granted: Granted | None = None  # at the last time it was asked for
        self._realtime = realtime
        self._interval = 0.0  # [s] what it was; 0 while nothing has been asked for

    def keep(self) -> None:
        """Ask for everything, unless that has been done; for the calling thread's waits."""
        if self._interval:
            return
        self._interval = sys.getswitchinterval()
        sys.setswitchinterval(SWITCH)
        timer = "1 ns" if _timer_slack(1) else f"usual ({ABSENT})"
        more = self._realtime
        self.granted = Granted(_raise(), _lock(), timer) if more else Granted(timer=timer)

    def relax(self) -> None:
        """Give everything back, if it has been asked for."""
        if not self._interval:
            return
        sys.setswitchinterval(self._interval)
        self._interval = 0.0
        _timer_slack(0)  # what it was
        if self._realtime and sys.platform == "linux":
            with contextlib.suppress(PermissionError):
                _schedule(os.SCHED_OTHER, 0, 0)
            ctypes.CDLL(None).munlockall()


def _raise() -> str:
    """Give every thread a real-time priority; return what came of it."""
    if sys.platform != "linux":
        return f"normal (real-time: {ABSENT})"
    try:
        _schedule(os.SCHED_FIFO, FIRST, REST)
    except PermissionError:
        return f"normal (real-time: {REFUSED})"
    return "real-time"


def _schedule(policy: int, first: int, rest: int) -> None:
    """Put all threads under a policy, the first with its own priority; PermissionError."""
    if sys.platform != "linux":
        return
    for thread in (int(path.name) for path in THREADS.iterdir()):
        level = os.sched_param(first if thread == os.getpid() else rest)
        with contextlib.suppress(ProcessLookupError):  # it has ended meanwhile
            os.sched_setscheduler(thread, policy, level)


def _lock() -> str:
    """Keep the memory of the process from being paged out; return what came of it."""
    if sys.platform != "linux":
        return f"not locked ({ABSENT})"
    done = ctypes.CDLL(None).mlockall(IN_USE)
    return "locked" if done == 0 else f"not locked ({REFUSED})"


def _timer_slack(nanoseconds: int) -> bool:
    """Let the waits of this thread end that late at most, 0 for what is usual; return if it can."""
    if sys.platform != "linux":
        return False
    return bool(ctypes.CDLL(None).prctl(SET_TIMER_SLACK, nanoseconds, 0, 0, 0) == 0)

"""The machine's own time, and waiting for it. Times are integer nanoseconds."""

import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import Final, Protocol

from trainer.ledger import SECOND

# A wait is cut in pieces: some systems deliver Ctrl-C, and notice a suspension, only between two.
LONGEST_NAP: Final = SECOND // 2  # [ns]
# Sleep ends a little before a deadline, and the rest is spun away: long enough to wake up, and to
# get the interpreter from a busy thread (punctuality.SWITCH); short enough to cost nothing.
SPIN: Final = 300_000  # [ns]


class Clock(Protocol):
    """What a pacer needs to know of time."""

    def now(self) -> int:
        """Return a time [ns] that never runs backwards."""
        ...

    def cpu(self) -> int:
        """Return the processor time [ns] used by the calling thread."""
        ...

    def wait_until(self, deadline: int, wake: threading.Event) -> int:
        """Return the time [ns] once ``deadline`` is past, 0 if ``wake`` is set before."""
        ...


class MonotonicClock:
    """The machine's own clock; counts a suspended machine's sleep where the system tells it."""

    now: Callable[[], int]  # [ns]; nothing of Python's is between the system and its caller

    def __init__(self) -> None:
        self.now = time.perf_counter_ns
        if sys.platform == "linux":
            self.now = partial(time.clock_gettime_ns, time.CLOCK_BOOTTIME)

    def cpu(self) -> int:
        """Return the processor time [ns] used by the calling thread."""
        return time.thread_time_ns()

    def wait_until(self, deadline: int, wake: threading.Event) -> int:
        """Return the time [ns] once ``deadline`` is past, 0 if ``wake`` is set before."""
        now, woken = self.now, wake.is_set
        while (left := deadline - SPIN - now()) > 0:
            if wake.wait(min(left, LONGEST_NAP) / SECOND):
                return reached if (reached := now()) >= deadline else 0
        while (reached := now()) < deadline:
            if woken():
                return 0
        return reached

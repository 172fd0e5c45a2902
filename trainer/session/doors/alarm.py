"""A timer that wakes the session's thread before its next tick is due.

Otherwise the thread sleeps until the next tick. In a freeze no tick is due, so whoever has a
deadline of its own sets an alarm: ``attendance`` (a station whose answer is kept back) and
``command`` (an instructor who does not answer).
"""

import math
import threading
import time
from collections.abc import Callable


class Alarm:
    """One call of ``wake``, at the earliest of the times that were set."""

    def __init__(self, wake: Callable[[], object]) -> None:
        self._wake = wake
        self._timer = threading.Timer(0.0, wake)
        self._due = 0.0  # [s] on the machine's clock

    def set(self, after: float) -> None:
        """Wake after a time [s], infinity for never, unless an earlier call is set already.

        An earlier time replaces a later one. Who is woken therefore sets the later one again.
        """
        now = time.monotonic()
        if now < self._due <= now + after or math.isinf(after):
            return
        self._timer.cancel()
        self._due = now + after
        self._timer = threading.Timer(after, self._wake)
        self._timer.daemon = True
        self._timer.start()

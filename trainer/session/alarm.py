"""A call that wakes the session's thread at a time."""

import math
import threading
import time
from collections.abc import Callable


class Alarm:
    """Wakes whoever waits, once, at the earliest of the times asked for."""

    def __init__(self, wake: Callable[[], object]) -> None:
        self._wake = wake
        self._timer = threading.Timer(0.0, wake)
        self._due = 0.0  # [s] on the machine's clock

    def set(self, after: float) -> None:
        """Wake after a time [s], infinity for never, unless that is done before then anyway.

        Whoever wakes asks again, because an earlier time replaces a later one.
        """
        now = time.monotonic()
        if now < self._due <= now + after or math.isinf(after):
            return
        self._timer.cancel()
        self._due = now + after
        self._timer = threading.Timer(after, self._wake)
        self._timer.daemon = True
        self._timer.start()

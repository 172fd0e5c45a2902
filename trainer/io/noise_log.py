"""Logs with a limit, so that nobody can flood them.

Entries beyond a limit are counted, and their count is written as one entry later. ``NoiseLog`` is
for the bad lines of one station and the refusals of the pages' server: 20 entries in 10 s.
``CrowdLog`` is for all strangers together: 20 entries, then counts that come more and more seldom.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

MAX_ENTRIES: Final = 20  # [entries] written of a period, or of a crowd before it rests
ENTRY_PERIOD_S: Final = 10.0  # [s]
ENTRY_RETURN_S: Final = 60.0  # [s] after which a crowd may write one entry more
MAX_SUM_PAUSE_S: Final = 600.0  # [s] between two counts, if the crowd does not rest


class NoiseLog:
    """A log that passes on the first entries of each period and counts the others."""

    def __init__(self, log: Callable[[str, str], None], clock: Callable[[], float]) -> None:
        """Pass on to ``log``; ``clock`` gives the time [s]."""
        self._log = log
        self._clock = clock
        self._since = clock()
        self._passed = 0
        self._held: dict[str, int] = {}  # by kind

    def log(self, kind: str, text: str) -> None:
        """Pass an entry on, or count it."""
        self.settle()
        if self._passed < MAX_ENTRIES:
            self._passed += 1
            self._log(kind, text)
            return
        self._held[kind] = self._held.get(kind, 0) + 1

    def settle(self) -> None:
        """If a period is over, begin the next, and log how many were not written."""
        if self._clock() - self._since >= ENTRY_PERIOD_S:
            self.close()
            self._since = self._clock()
            self._passed = 0

    def close(self) -> None:
        """Log how many entries were not written."""
        for kind, count in self._held.items():
            self._log(kind, sum_up(count))
        self._held.clear()


def sum_up(count: int) -> str:
    """Return the line that stands for entries that are not written."""
    return f"{count} more of the same, not written one by one"


@dataclass
class Tally:
    """The count of one kind: entries that may still be written, and those held back."""

    since: float  # [s] when ``left`` was reckoned
    left: float = MAX_ENTRIES
    held: int = 0
    due: float = math.inf  # [s] when the count of unwritten entries is to be logged
    pause: float = ENTRY_PERIOD_S  # [s] until it is logged
    logged: float = -math.inf  # [s] when it was logged last

    def admit(self, now: float) -> bool:
        """Return whether an entry is written; else it is counted."""
        returned = (now - self.since) / ENTRY_RETURN_S
        self.since, self.left = now, min(self.left + returned, MAX_ENTRIES)
        if self.left >= 1.0:
            self.left -= 1.0
            return True
        if not self.held:
            self.pause = ENTRY_PERIOD_S if now - self.logged > self.pause else self.pause
            self.due = now + self.pause
        self.held += 1
        return False


class CrowdLog:
    """A log of a crowd: its first entries, then sums of the others.

    The sums come more and more seldom. The log does not look at who makes an entry, because a
    thousand clients with one entry each would flood it as one client with a thousand does.
    """

    def __init__(self, log: Callable[[str, str], None], clock: Callable[[], float]) -> None:
        """Pass on to ``log``; ``clock`` gives the time [s]."""
        self._log = log
        self._clock = clock
        self._tallies: dict[str, Tally] = {}  # by kind

    @property
    def wait(self) -> float:
        """Return the time [s] to the next count, infinity without one."""
        due = min((tally.due for tally in self._tallies.values()), default=math.inf)
        return max(due - self._clock(), 0.0)

    def log(self, kind: str, text: str) -> None:
        """Pass an entry on, or count it."""
        self.settle()
        now = self._clock()
        if self._tallies.setdefault(kind, Tally(now)).admit(now):
            self._log(kind, text)

    def settle(self) -> None:
        """Log the counts that are due."""
        self._log_counts(self._clock())

    def close(self) -> None:
        """Log how many entries were not written, of all kinds."""
        self._log_counts(math.inf)

    def _log_counts(self, until: float) -> None:
        """Log the counts that are due by a time [s]."""
        for kind, tally in self._tallies.items():
            if tally.held and tally.due <= until:
                count, tally.held = tally.held, 0
                tally.due, tally.logged = math.inf, self._clock()
                tally.pause = min(2.0 * tally.pause, MAX_SUM_PAUSE_S)
                self._log(kind, sum_up(count))

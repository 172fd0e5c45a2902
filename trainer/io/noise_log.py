"""A log that those who make the noise cannot flood."""

from collections.abc import Callable
from typing import Final

MOST: Final = 20  # entries
WHILE: Final = 10.0  # [s]


class NoiseLog:
    """Pass entries on as long as they are few."""

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
        if self._passed < MOST:
            self._passed += 1
            self._log(kind, text)
            return
        self._held[kind] = self._held.get(kind, 0) + 1

    def settle(self) -> None:
        """Begin afresh if the while is over, with the number of what was held back."""
        if self._clock() - self._since >= WHILE:
            self.close()
            self._since = self._clock()
            self._passed = 0

    def close(self) -> None:
        """Tell the number of what was held back."""
        for kind, count in self._held.items():
            self._log(kind, f"{count} more of the same, not written one by one")
        self._held.clear()

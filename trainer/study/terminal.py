"""A terminal or serial line of the bench's own, with a program at its other end."""

import contextlib
import os
import select
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from re import Match, Pattern
from typing import Final

SIZE: Final = 40, 120  # rows and columns
TRAINER: Final = (sys.executable, "-m", "trainer")


@dataclass
class Line:
    """Our end of a line, and the name of the other."""

    descriptor: int
    name: str
    said: bytes = b""  # what has come and has not been taken

    def say(self, words: str) -> None:
        """Write a line."""
        os.write(self.descriptor, f"{words}\r".encode("ascii"))

    def hear(self, until: float) -> bool:
        """Take what comes by ``until`` [s] of the monotonic clock; return whether anything did."""
        wait = max(until - time.monotonic(), 0.0)
        if not select.select([self.descriptor], [], [], wait)[0]:
            return False
        with contextlib.suppress(OSError):  # the other end has gone
            self.said += os.read(self.descriptor, 65536)
            return True
        return False

    def find(self, pattern: Pattern[bytes], until: float) -> Match[bytes] | None:
        """Return the next match, and take it and what is before it; None if none comes in time."""
        while True:
            found = pattern.search(self.said)
            if found:
                self.said = self.said[found.end() :]
                return found
            if not self.hear(until):
                return None


@contextlib.contextmanager
def line() -> Iterator[Line]:
    """Yield a line whose other end a program can open; the system must have such."""
    import fcntl  # noqa: PLC0415  not everywhere
    import struct  # noqa: PLC0415
    import termios  # noqa: PLC0415

    ours, theirs = os.openpty()
    try:
        fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", *SIZE, 0, 0))
        yield Line(ours, os.ttyname(theirs))
    finally:
        os.close(theirs)
        os.close(ours)

"""Serial lines and terminals, whose other end a program opens."""

import contextlib
import os
import select
import subprocess
import termios
import time
from collections.abc import Iterator
from dataclasses import dataclass
from re import Match, Pattern
from typing import Final

from trainer.analysis.bench.delays import TRAINER_COMMAND

TERMINAL_SIZE: Final = 40, 120  # rows and columns


@dataclass
class TerminalLine:
    """The bench's end of a serial line, and the name of the other end."""

    descriptor: int
    name: str
    received: bytes = b""  # what has come and has not been asked for

    def say(self, words: str) -> None:
        """Write a line."""
        os.write(self.descriptor, f"{words}\r".encode("ascii"))

    def hear(self, until: float) -> bool:
        """Read until ``until`` [s] of the monotonic clock. Return whether anything came."""
        wait = max(until - time.monotonic(), 0.0)
        if not select.select([self.descriptor], [], [], wait)[0]:
            return False
        with contextlib.suppress(OSError):  # the other end has gone
            self.received += os.read(self.descriptor, 65536)
            return True
        return False

    def find(self, pattern: Pattern[bytes], until: float) -> Match[bytes] | None:
        """Return the next match; drop it and all before it. None if none comes in time."""
        while True:
            match = pattern.search(self.received)
            if match:
                self.received = self.received[match.end() :]
                return match
            if not self.hear(until):
                return None


@contextlib.contextmanager
def line() -> Iterator[TerminalLine]:
    """Yield a line whose other end a program can open. The system must have pseudo-terminals."""
    ours, theirs = os.openpty()
    try:
        termios.tcsetwinsize(theirs, TERMINAL_SIZE)
        yield TerminalLine(ours, os.ttyname(theirs))
    finally:
        os.close(theirs)
        os.close(ours)


@contextlib.contextmanager
def on_terminal(*words: str) -> Iterator[tuple[TerminalLine, "subprocess.Popen[bytes]"]]:
    """Run the program on a terminal inside the block. Yield our end of it and the process."""
    with line() as screen:
        terminal = os.open(screen.name, os.O_RDWR | os.O_NOCTTY)
        with subprocess.Popen(
            [*TRAINER_COMMAND, *words],
            stdin=terminal,
            stdout=terminal,
            stderr=terminal,
            env=os.environ | {"TERM": "xterm-256color"},
        ) as process:
            os.close(terminal)
            yield screen, process

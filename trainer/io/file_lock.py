"""A file that one process at a time holds.

Sweeps hold one, because two of them must not write one result. The system releases the lock when
the process ends, even if it is killed. So no lock is left behind.
"""

import contextlib
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Final

NAMING_TIMEOUT_S: Final = 1.0  # [s] for whoever has just taken a file to write its number there
NAMING_POLL_S: Final = 0.01  # [s]


@contextlib.contextmanager
def holding(path: Path) -> Iterator[int]:
    """Hold a file inside the block. Yield 0, or the number of the other process that holds it.

    The file is made, and stays. Where the system has no such locks every process gets 0. OSError
    if it cannot be written.
    """
    with path.open("a+", encoding="ascii") as file:
        if not _take(file):
            yield _holder(file)
            return
        file.truncate(0)  # the number of an earlier holder, which no longer has the lock
        file.write(str(os.getpid()))
        file.flush()
        yield 0


def _take(file: IO[str]) -> bool:
    """Take the lock of a file; return whether nobody else has it."""
    try:
        import fcntl  # noqa: PLC0415  not everywhere
    except ImportError:
        return True
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True


def _holder(file: IO[str]) -> int:
    """Return the process that holds a file, -1 if it does not say so in time."""
    end = time.monotonic() + NAMING_TIMEOUT_S
    while True:
        file.seek(0)
        number = file.read()
        if number.isdigit():
            return int(number)
        if time.monotonic() > end:
            return -1
        time.sleep(NAMING_POLL_S)

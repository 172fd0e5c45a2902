"""A thread of its own brings onto the disk what is committed.

Lost power takes it no more then.

SQLite's commit hands its pages to the operating system: they outlive the program, not the machine.
The system is asked to put them on the disk (fsync) where nobody waits for it, soon after something
that was promised. A disk may take as long as it likes: it is told that it is behind.
"""

import math
import os
import threading
import time
from pathlib import Path
from typing import Final

SYNC_PERIOD_S: Final = 0.2  # between looks at what is due
RETRY_S: Final = 2.0  # until the file is opened that could not be
QUIET_S: Final = 30.0  # without a sync that was late, before the disk keeps up again
CLOSE_TIMEOUT_S: Final = 5.0  # for a disk that is at it when the recording ends

NEVER_DUE: Final = math.inf  # [s] when nothing is due


class Syncer:
    """A thread that asks the disk in time for the pages of a write-ahead log.

    It opens that file itself, which carries no locks of SQLite's (the database does: to close it
    would give them up), and keeps it open: it needs no descriptor when there are none left.
    """

    def __init__(self, path: Path) -> None:
        """Take the path of the database; `start` begins the thread."""
        self._written_ahead = path.with_name(path.name + "-wal")
        self._lock = threading.Lock()  # held for a moment where what is due changes
        self._begin = NEVER_DUE  # [s] of the clock, when the disk is to be asked
        self._due = NEVER_DUE  # [s] when the oldest commit is due that was not yet asked for
        self._asked = NEVER_DUE  # [s] when that is due which the disk is asked for now
        self._quiet = -NEVER_DUE  # [s] from when on nothing late counts any more
        self._descriptor = -1
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="disk", daemon=True)
        self.failure: OSError | None = None  # with which it was refused, until all is home

    def start(self) -> None:
        """Begin the thread. The file is opened now: there may be no descriptors left later."""
        self._opens()
        self._thread.start()

    def close(self) -> None:
        """End the thread; one whose disk hangs is left to itself."""
        self._closing.set()
        if self._thread.ident:
            self._thread.join(CLOSE_TIMEOUT_S)

    @property
    def behind(self) -> bool:
        """Return whether something due is not on the disk, or was late of late."""
        now = time.monotonic()
        return self.failure is not None or now < self._quiet or now > min(self._due, self._asked)

    def expect(self, seconds: float) -> None:
        """Expect a commit to be on the disk within so many seconds.

        The disk is asked after half of them: what else comes until then goes with it.
        """
        now = time.monotonic()
        with self._lock:
            self._begin = min(self._begin, now + seconds / 2.0)
            self._due = min(self._due, now + seconds)

    def forgive(self, failure: OSError | None) -> None:
        """Take note that what was refused is on the disk: it was brought home."""
        if self.failure is failure:  # else there was another one meanwhile
            self.failure = None

    def _run(self) -> None:
        while not self._closing.wait(SYNC_PERIOD_S):
            if time.monotonic() > self._begin:
                self._sync()
        if self._descriptor >= 0:
            os.close(self._descriptor)

    def _sync(self) -> None:
        """Ask the disk for all that is committed, and wait for it.

        What it has refused once it may have dropped, and yet grant the next time: then only a
        checkpoint tells, which writes it all again.
        """
        with self._lock:
            self._asked, self._begin, self._due = self._due, NEVER_DUE, NEVER_DUE
        if self._opens():
            try:
                os.fsync(self._descriptor)
            except OSError as error:
                self.failure = error
        if (now := time.monotonic()) > self._asked:
            self._quiet = now + QUIET_S
        self._asked = NEVER_DUE

    def _opens(self) -> bool:
        """Return whether the file is open; where it cannot be, it is tried again before long."""
        if self._descriptor >= 0:
            return True
        try:
            self._descriptor = _open(self._written_ahead)
        except FileNotFoundError:  # somebody has made it one without: then SQLite waits itself
            return False
        except OSError as error:
            self.failure = error
            self.expect(RETRY_S)
            return False
        self.failure = None  # the disk itself was not asked, and has refused nothing
        return True


def _open(path: Path) -> int:
    """Return a descriptor by which a file can be brought onto the disk."""
    return os.open(path, os.O_RDWR | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0))

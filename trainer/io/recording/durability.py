"""A thread brings committed pages onto the disk, where they outlive lost power.

SQLite's commit hands its pages to the operating system: they outlive the program, not the machine.
The thread asks the system to put them on the disk (fsync) soon after a commit that was promised to
last. Nobody else waits, however long the disk takes; ``behind`` says that it takes too long.
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
CLOSE_TIMEOUT_S: Final = 5.0  # for a sync under way when the recording ends

NEVER_DUE: Final = math.inf  # [s] when nothing is due


class Syncer:
    """A thread that syncs the write-ahead log of a recording in time.

    It opens that log itself. This is safe because SQLite locks the database, not the log; closing
    a second descriptor of the database would give SQLite's locks up. The log stays open, because
    later there may be no descriptors left.
    """

    def __init__(self, path: Path) -> None:
        """Take the path of the database; `start` begins the thread."""
        self._written_ahead = path.with_name(path.name + "-wal")
        self._lock = threading.Lock()  # held for a moment where what is due changes
        self._begin = NEVER_DUE  # [s] of the clock, when the next sync is to begin
        self._due = NEVER_DUE  # [s] by when the oldest unsynced commit has to be on the disk
        self._asked = NEVER_DUE  # [s] by when the sync under way has to be done
        self._quiet = -NEVER_DUE  # [s] until when a late sync counts as the disk being behind
        self._descriptor = -1
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="disk", daemon=True)
        self.failure: OSError | None = None  # of the last sync, until its pages are written

    def start(self) -> None:
        """Begin the thread. The file is opened now: there may be no descriptors left later."""
        self._opens()
        self._thread.start()

    def close(self) -> None:
        """End the thread; do not wait longer than CLOSE_TIMEOUT_S for a disk that hangs."""
        self._closing.set()
        if self._thread.ident:
            self._thread.join(CLOSE_TIMEOUT_S)

    @property
    def behind(self) -> bool:
        """Return whether a commit is late on the disk, or one was within QUIET_S.

        A process that was stopped has asked the disk late: that is no fault of the disk's.
        """
        now = time.monotonic()
        return self.failure is not None or now < self._quiet or now > self._asked

    def expect(self, seconds: float) -> None:
        """Expect a commit to be on the disk within so many seconds.

        The disk is asked after half of them, so that later commits share the same sync.
        """
        now = time.monotonic()
        with self._lock:
            self._begin = min(self._begin, now + seconds / 2.0)
            self._due = min(self._due, now + seconds)

    def forgive(self, failure: OSError | None) -> None:
        """Forget a failed sync, because a checkpoint has written its pages since."""
        if self.failure is failure:  # else there was another one meanwhile
            self.failure = None

    def _run(self) -> None:
        while not self._closing.wait(SYNC_PERIOD_S):
            if (late := time.monotonic() - self._begin) > 0.0:
                self._sync(max(late - SYNC_PERIOD_S, 0.0))
        if self._descriptor >= 0:
            os.close(self._descriptor)

    def _sync(self, late: float) -> None:
        """Ask the disk, ``late`` [s], for all that is committed, and wait for it.

        After a failed fsync the system may have dropped the pages, and yet report the next fsync
        as good. So a failure stands until a checkpoint has written all pages again.
        """
        with self._lock:
            self._asked, self._begin, self._due = self._due + late, NEVER_DUE, NEVER_DUE
        if self._opens():
            try:
                os.fsync(self._descriptor)
            except OSError as error:
                self.failure = error
        if (now := time.monotonic()) > self._asked:
            self._quiet = now + QUIET_S
        self._asked = NEVER_DUE

    def _opens(self) -> bool:
        """Return whether the log is open; if it cannot be, try again after RETRY_S."""
        if self._descriptor >= 0:
            return True
        try:
            self._descriptor = _open(self._written_ahead)
        except FileNotFoundError:  # another program has left WAL mode: then SQLite syncs itself
            return False
        except OSError as error:
            self.failure = error
            self.expect(RETRY_S)
            return False
        self.failure = None  # the disk itself was not asked, and has refused nothing
        return True


def _open(path: Path) -> int:
    """Return a descriptor of a file for fsync, which a child process does not inherit."""
    return os.open(path, os.O_RDWR | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0))

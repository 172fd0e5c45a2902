"""The thread of a recording commits waiting rows, and moves the log into the database.

Such a move (SQLite's checkpoint) waits for the disk; in the thread that ticks it would make ticks
late. But a run without a clock writes without a pause, and no other thread can catch up with it:
the log would grow without end. So that writer waits now and then (``relieve``).
"""

import contextlib
import functools
import sqlite3
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Final

from trainer.io.recording.durability import Syncer
from trainer.io.recording.file import TOUCH_STATEMENT, connect

MIN_CHECKPOINT_BYTES: Final = 4_000_000  # [bytes] in the log before a checkpoint is worthwhile
LOOK_PERIOD_S: Final = 0.8  # [s] between looks at the log and at waiting rows
FINAL_TIMEOUT_S: Final = 20.0  # [s] for a checkpoint under way at the end
# [bytes] in the log before the writer waits. A run in real time needs hours to write as much.
MAX_AHEAD_BYTES: Final = 64_000_000

CHECKPOINT_STATEMENT: Final = "PRAGMA wal_checkpoint(PASSIVE)"


class Checkpointer:
    """A thread that moves the write-ahead log into the database once it is long."""

    disk: Syncer  # its thread brings the log onto the disk before that

    def __init__(self, path: Path) -> None:
        self.disk = Syncer(path)
        self._path = path
        self._written_ahead = path.with_name(path.name + "-wal")
        self._file = _identity(path)
        self._bound = MAX_AHEAD_BYTES  # [bytes] written ahead at which the writer waits
        self._bringing = threading.Lock()  # SQLite refuses two checkpoints at a time
        self._closing = threading.Event()
        self._thread = threading.Thread(name="checkpoints")

    def start(self, tend: Callable[[], None]) -> None:
        """Begin the thread, which also calls `tend` every LOOK_PERIOD_S seconds."""
        run = functools.partial(self._run, tend)
        self._thread = threading.Thread(target=run, name="checkpoints", daemon=True)
        self._thread.start()
        self.disk.start()

    def close(self) -> None:
        """End the thread after its checkpoint; wait at most FINAL_TIMEOUT_S for it."""
        self._closing.set()
        if self._thread.ident:
            self._thread.join(FINAL_TIMEOUT_S)
        self.disk.close()

    @property
    def gone(self) -> bool:
        """Return whether the file was removed, or another stands in its place."""
        return _identity(self._path) != self._file

    def relieve(self, writing: sqlite3.Connection) -> None:
        """Checkpoint by the writer's own connection, between commits, if the log is too long.

        It waits for a checkpoint under way, because the log would grow meanwhile. Pages that a
        reader still looks at must stay in the log. Then the next try comes after MAX_AHEAD_BYTES
        more.
        """
        with contextlib.suppress(OSError, sqlite3.Error):  # nothing is lost: it stays in the log
            ahead = self._written_ahead.stat().st_size
            if ahead < self._bound:
                return
            with self._bringing:
                _, written, brought_home = writing.execute(CHECKPOINT_STATEMENT).fetchone()
            self._bound = MAX_AHEAD_BYTES if written == brought_home else ahead + MAX_AHEAD_BYTES

    def _run(self, tend: Callable[[], None]) -> None:
        connection = None
        with contextlib.suppress(sqlite3.Error):  # else closing the file moves all of it
            connection = connect(self._path, "mode=rw")
            connection.execute("PRAGMA journal_size_limit = 0")
        while not self._closing.wait(LOOK_PERIOD_S):
            tend()
            if connection:
                self._look(connection)
        if connection:
            connection.close()

    def _look(self, connection: sqlite3.Connection) -> None:
        with contextlib.suppress(OSError, sqlite3.Error):  # the next look may do better
            refused = self.disk.failure
            if self._written_ahead.stat().st_size < MIN_CHECKPOINT_BYTES and not refused:
                return
            with self._bringing:
                _, written, brought_home = connection.execute(CHECKPOINT_STATEMENT).fetchone()
            if written == brought_home:
                self.disk.forgive(refused)
                # Whoever writes next begins the file anew and waits for the disk: be that one.
                connection.execute(TOUCH_STATEMENT)


def _identity(path: Path) -> tuple[int, int]:
    """Return device and inode of a file, which no other file has; (0, 0) if there is none."""
    try:
        status = path.stat()
    except OSError:
        return 0, 0
    return status.st_dev, status.st_ino

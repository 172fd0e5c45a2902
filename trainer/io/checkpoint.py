"""Bringing home what SQLite has written ahead, in a thread of its own.

A checkpoint waits for the disk (fsync); in the thread that ticks it would make ticks late.
"""

import contextlib
import sqlite3
import threading
from pathlib import Path
from typing import Final

from trainer.io.recording_file import TOUCH, connect

WORTHWHILE: Final = 4_000_000  # [bytes] written ahead
EVERY: Final = 1.0  # [s] between looks at how much that is


class Checkpointer:
    """A thread that moves what is written ahead into the database once it is worthwhile."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._written_ahead = path.with_name(path.name + "-wal")
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name="checkpoints", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the thread, after the checkpoint it may be in."""
        self._closing.set()
        self._thread.join()

    def _run(self) -> None:
        try:
            connection = connect(self._path, "mode=rw")
        except sqlite3.Error:  # it remains written ahead, and is brought home at the end
            return
        with contextlib.closing(connection):
            connection.execute("PRAGMA journal_size_limit = 0")
            while not self._closing.wait(EVERY):
                self._look(connection)

    def _look(self, connection: sqlite3.Connection) -> None:
        with contextlib.suppress(OSError, sqlite3.Error):  # the next look may do better
            if self._written_ahead.stat().st_size < WORTHWHILE:
                return
            checkpoint = connection.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()
            _, written, brought_home = checkpoint
            if written == brought_home:
                # Whoever writes next begins the file anew and waits for the disk: be that one.
                connection.execute(TOUCH)

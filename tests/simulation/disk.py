"""The disk of the machine, and what befalls the recording on it.

The recording is a real file of SQLite's, which stands for the memory of the system. ``kept`` is
what the disk had of it when it was last asked. A killed process leaves the file, lost power
leaves ``kept``.
"""

import contextlib
import errno
import sqlite3
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Final, NamedTuple

from simulation.machine import Machine
from trainer.io.recording.format_1 import TABLES_1

SYNC_TIMES_S: Final = (0.001, 0.02)  # [s] that the disk takes when it is asked
MOST_SET_S: Final = 30 * 3600.0  # [s] by which the time of day is set, ahead or back
SLOW_SYNC_TIMES_S: Final = (0.001, 0.01, 0.3, 2.5)  # [s] a disk that has other work


BEGIN_AGEING: Final = f"""
BEGIN IMMEDIATE;
ALTER TABLE branches RENAME TO branches_2;
ALTER TABLE orders RENAME TO orders_2;
ALTER TABLE events RENAME TO events_2;
DROP INDEX orders_by_tick;
{TABLES_1}
"""


class Image(NamedTuple):
    """The bytes of a recording: its file, and the log written ahead of it."""

    file: bytes
    log: bytes

    @classmethod
    def of(cls, path: Path) -> "Image":
        """Return what is at ``path``."""
        return cls(*(each.read_bytes() if each.exists() else b"" for each in (path, log_of(path))))

    def write(self, path: Path) -> None:
        """Put it at ``path``."""
        path.write_bytes(self.file)
        log_of(path).write_bytes(self.log)


def log_of(path: Path) -> Path:
    """Return where the log of the recording at ``path`` is."""
    return path.with_name(path.name + "-wal")


class Trouble(Enum):
    """What befalls a recording for a while."""

    LOCKED = "another program writes into it"
    REFUSED = "the disk refuses to sync (EIO)"
    FULL = "the disk is full"
    UNREADABLE = "what is in it cannot be read"
    ASLEEP = "the machine sleeps"
    SET = "the time of day is set by hours"
    RIVAL = "another session begins on it"


@dataclass
class Disk:
    """The disk with the recording at ``path``."""

    machine: Machine
    path: Path = Path()
    slow: bool = False
    kept: Image | None = None
    opened_at: int = 0  # [ns] when the present process began
    woken_at: int = -(2**62)  # [ns] when the machine last woke
    troubles: set[Trouble] = field(default_factory=set)  # that befall it now
    is_amidst: Callable[[], bool] = bool  # whether an order is journalled and not yet answered
    kept_amidst: bool = False  # what it has last kept ends so
    _refuses: bool = False
    _writer: sqlite3.Connection | None = field(default=None, repr=False)
    _reader: sqlite3.Connection | None = field(default=None, repr=False)

    def boot(self, path: Path, *, slow: bool) -> None:
        """Begin with the recording of a process that stands at ``path``."""
        self.path, self.slow, self._refuses = path, slow, False
        self.kept_amidst = False
        self._writer = self._reader = None
        self.troubles.clear()
        self.opened_at = self.machine.now

    def age(self) -> None:
        """Make the recording one of format 1, as an older program leaves it."""
        with contextlib.closing(sqlite3.connect(self.path, isolation_level=None)) as connection:
            connection.executescript(BEGIN_AGEING)
            for table in ("branches", "orders", "events"):
                names = ", ".join(
                    row[1] for row in connection.execute(f"PRAGMA table_info({table})")
                )
                connection.execute(f"INSERT INTO {table} SELECT {names} FROM {table}_2")
                connection.execute(f"DROP TABLE {table}_2")
            connection.execute("PRAGMA user_version = 1")
            connection.execute("COMMIT")
        self.keep()

    def fsync(self, _descriptor: int) -> None:
        """Put on the disk what was written before the call; OSError while it refuses."""
        image, amidst = Image.of(self.path), self.is_amidst()
        self.machine.sleep(
            self.machine.dice.choice(SLOW_SYNC_TIMES_S if self.slow else SYNC_TIMES_S)
        )
        if self._refuses:
            raise OSError(errno.EIO, "Input/output error")
        self.kept, self.kept_amidst = image, amidst

    def keep(self) -> None:
        """Note that SQLite itself has put all on the disk."""
        self.kept = Image.of(self.path)

    def writes_by(self, connection: sqlite3.Connection) -> sqlite3.Connection:
        """Note the connection by which the recording is written; return it."""
        self._writer = connection
        return connection

    def reads_by(self, connection: sqlite3.Connection) -> sqlite3.Connection:
        """Note the connection by which the recording is read; return it."""
        self._reader = connection
        return connection

    def trouble(self, trouble: Trouble, seconds: float) -> None:
        """Have trouble for a time [s]."""
        if trouble is Trouble.ASLEEP:
            self.machine.now += int(seconds * 1e9)
            self.woken_at = self.machine.now
            return
        if trouble is Trouble.SET:
            self.machine.set_ahead += self.machine.dice.uniform(-MOST_SET_S, MOST_SET_S)
            return
        befall = {
            Trouble.LOCKED: self._locked,
            Trouble.REFUSED: self._refused,
            Trouble.FULL: self._full,
            Trouble.UNREADABLE: self._unreadable,
        }
        self.troubles.add(trouble)
        with contextlib.suppress(sqlite3.Error), befall[trouble]():  # closed meanwhile: no trouble
            self.machine.sleep(seconds)
        self.troubles.discard(trouble)

    @contextlib.contextmanager
    def _locked(self) -> Iterator[None]:
        if not self.path.exists():
            return (yield)
        with contextlib.closing(sqlite3.connect(self.path, 0.0, isolation_level=None)) as other:
            other.execute("BEGIN IMMEDIATE")
            try:
                yield
            finally:
                other.execute("ROLLBACK")

    @contextlib.contextmanager
    def _refused(self) -> Iterator[None]:
        self._refuses = True
        yield
        self._refuses = False

    @contextlib.contextmanager
    def _full(self) -> Iterator[None]:
        if self._writer:
            (pages,) = self._writer.execute("PRAGMA page_count").fetchone()
            self._writer.execute(f"PRAGMA max_page_count = {pages}")
        yield
        if self._writer:
            self._writer.execute("PRAGMA max_page_count = 1000000000")

    @contextlib.contextmanager
    def _unreadable(self) -> Iterator[None]:
        if self._reader:
            self._reader.set_authorizer(lambda *_: sqlite3.SQLITE_DENY)
        yield
        if self._reader:
            self._reader.set_authorizer(None)

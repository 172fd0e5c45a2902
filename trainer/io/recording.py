"""A recording: one file of a run, its orders before they act, its states, and what happened.

It knows bytes, text and numbers; what they mean is its caller's affair. Orders, snapshots and
forks are committed when the call returns; the rest is gathered and goes out with them, at the
latest when BATCH rows of a kind or LONGEST seconds have come together. A process that is killed
loses nothing that is committed; one whose machine loses power may lose the last seconds, never
the whole.
"""

import contextlib
import sqlite3
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final

from trainer.io import recording_file
from trainer.io.checkpoint import BRING_HOME, Checkpointer
from trainer.io.recording_file import FORMAT, RecordingError, wall_time
from trainer.io.recording_past import Branch, Flown, Journalled, Moment, Noted, Past

__all__ = [
    "FORMAT",
    "Branch",
    "Flown",
    "Journalled",
    "Moment",
    "Noted",
    "Recording",
    "RecordingError",
]

BATCH: Final = 256  # [rows] of a kind gathered at most
LONGEST: Final = 5.0  # [s] that they wait at most while others follow

Row = tuple[int | str | bytes | None, ...]

BRANCH: Final = (
    "INSERT INTO branches (id, parent, tick, after, place, why, state, wall) "
    "VALUES (?, ?, ?, ?, ?, ?, ?, ?)"
)
ORDER: Final = (
    "INSERT INTO orders (id, branch, tick, who, text, place, wall) VALUES (?, ?, ?, ?, ?, ?, ?)"
)
ANSWER: Final = "UPDATE orders SET answer = ?, accepted = ? WHERE id = ?"
# a tick flown again on its own branch is the same tick
STATE: Final = "INSERT OR IGNORE INTO states (branch, tick, state) VALUES (?, ?, ?)"
TIMING: Final = (
    "INSERT OR IGNORE INTO ledger (branch, tick, lateness_ns, work_ns) VALUES (?, ?, ?, ?)"
)
EVENT: Final = "INSERT INTO events (branch, tick, kind, who, text, wall) VALUES (?, ?, ?, ?, ?, ?)"
SNAPSHOT: Final = (
    "INSERT INTO snapshots (name, branch, tick, state, after, place, wall) "
    "VALUES (?, ?, ?, ?, ?, ?, ?)"
)
STATEMENTS: Final = (BRANCH, ORDER, ANSWER, STATE, TIMING, EVENT, SNAPSHOT)  # in this order


class Recording:
    """A recording being written, or looked at; for one thread only."""

    trouble: str  # why nothing more is written; "" while all is well
    branch: int  # the present one

    def __init__(
        self, connection: sqlite3.Connection, name: str, checkpointer: Checkpointer | None
    ) -> None:
        """Take an open file; `create`, `reopen` and `look` open them."""
        self.trouble = ""
        self._name = name
        self._connection = connection
        self._checkpointer = checkpointer
        self._past = Past(connection, name)
        self.branch = self._branches = self._past.last_branch()
        self._order = self._past.last_order()
        self._tick = self._kept = self._past.last_tick(self.branch)
        self._waiting: dict[str, list[Row]] = {statement: [] for statement in STATEMENTS}
        self._states, self._timings = self._waiting[STATE], self._waiting[TIMING]
        self._flushed = time.monotonic()

    @classmethod
    def create(cls, path: Path | None, header: Mapping[str, str], state: bytes) -> "Recording":
        """Begin a recording at tick 0 with `state`; without a path one that is gone when closed.

        RecordingError if there is such a file already, or it cannot be made.
        """
        if path is None:
            return cls(recording_file.temporary(header, state), "the temporary recording", None)
        return cls._writing(recording_file.create(path, header, state), path)

    @classmethod
    def reopen(cls, path: Path) -> "Recording":
        """Go on with the latest branch of a recording; RecordingError if another program has it."""
        return cls._writing(recording_file.reopen(path), path)

    @classmethod
    def look(cls, path: Path) -> "Recording":
        """Open a recording for reading, while it is written or afterwards."""
        return cls._opened(recording_file.look(path), str(path), None)

    @classmethod
    def _writing(cls, connection: sqlite3.Connection, path: Path) -> "Recording":
        return cls._opened(connection, str(path), Checkpointer(path))

    @classmethod
    def _opened(
        cls, connection: sqlite3.Connection, name: str, checkpointer: Checkpointer | None
    ) -> "Recording":
        """Return the recording; what is open is closed if it turns out to be damaged."""
        with contextlib.ExitStack() as unless_good:
            unless_good.callback(connection.close)
            if checkpointer:
                unless_good.callback(checkpointer.close)
            recording = cls(connection, name, checkpointer)
            unless_good.pop_all()
        return recording

    # Writing

    def order(self, tick: int, who: str, text: str, place: int | None = None) -> int:
        """Write an order that is about to act, at once; return its number."""
        self._order += 1
        self._tick = tick
        self._put(ORDER, (self._order, self.branch, tick, who, text, place, wall_time()))
        self.flush()
        return self._order

    def answered(self, order: int, answer: str, accepted: bool) -> None:  # noqa: FBT001
        """Take what became of an order."""
        self._put(ANSWER, (answer, int(accepted), order))

    def state(self, tick: int, state: bytes) -> None:
        """Take what stands at the end of a tick; of a tick taken already the first stands."""
        self._tick = tick
        self._states.append((self.branch, tick, state))
        if len(self._states) >= BATCH or time.monotonic() > self._flushed + LONGEST:
            self.flush()

    def timing(self, tick: int, lateness: int, work: int) -> None:
        """Take how late [ns] a tick began and how long [ns] it worked."""
        self._timings.append((self.branch, tick, lateness, work))

    def event(self, tick: int, kind: str, who: str, text: str) -> None:
        """Take something that happened; it is given the time of day."""
        self._put(EVENT, (self.branch, tick, kind, who, text, wall_time()))

    def snapshot(self, name: str, moment: Moment) -> None:
        """Write a moment under a name, at once."""
        branch = self._owner(moment)
        kept = (branch, moment.tick, moment.state, moment.after, moment.place)
        self._put(SNAPSHOT, (name, *kept, wall_time()))
        self.flush()

    def fork(self, moment: Moment, why: str) -> int:
        """Begin a new branch at a moment, at once; return its number, from now on the present."""
        parent = self._owner(moment)
        begun = (parent, moment.tick, moment.after, moment.place, why, moment.state)
        self._branches += 1
        self._put(BRANCH, (self._branches, *begun, wall_time()))
        self.flush()
        self.branch, self._tick = self._branches, moment.tick
        return self.branch

    def flush(self) -> None:
        """Write what waits, all or nothing; what cannot be written is told in `trouble`."""
        self._flushed = time.monotonic()
        if any(self._waiting.values()) and not self.trouble:
            self._write()
        for rows in self._waiting.values():
            rows.clear()

    def close(self) -> None:
        """Write what waits, bring all of it into the one file, and close."""
        self.flush()
        if self._checkpointer:
            self._checkpointer.close()
            try:
                self._connection.execute(BRING_HOME)
            except sqlite3.Error as error:
                self._give_up(error)
        self._connection.close()

    # Reading: what waits is written first, so that it is seen

    def header(self) -> dict[str, str]:
        """Return what the recording was begun with."""
        return self._past.header()

    def branches(self) -> list[Branch]:
        """Return all branches, oldest first."""
        return self._seen().branches()

    def state_at(self, branch: int, tick: int) -> bytes | None:
        """Return the state at the end of a tick in a branch or its ancestry."""
        moment = self.moment(branch, tick)
        return None if moment is None else moment.state

    def latest(self) -> Moment:
        """Return the end of the last recorded tick of the latest branch."""
        past = self._seen()
        branch = past.last_branch()
        moment = past.moment(branch, past.last_tick(branch))
        if moment is None:
            raise RecordingError(f"{self._name} cannot be read: its last state is missing")
        return moment

    def moment(self, branch: int, tick: int) -> Moment | None:
        """Return the end of a tick in a branch or its ancestry; None if it is not recorded."""
        return self._seen().moment(branch, tick)

    def orders(self, branch: int, after: int = 0) -> list[Journalled]:
        """Return the orders after number `after` of a branch and its past, in order."""
        return self._seen().orders(branch, after)

    def snapshots(self) -> list[tuple[str, Moment]]:
        """Return the named moments: the latest of each name in the present branch's past.

        What was kept on other branches only is there too, before them.
        """
        return self._seen().snapshots(self.branch)

    def flown(self, branch: int) -> Iterator[Flown]:
        """Yield every tick of a branch and of the ancestry that led to it."""
        return self._seen().flown(branch)

    def states(self, branch: int) -> Iterator[tuple[int, bytes]]:
        """Yield tick and state of the branch alone, the state that it begins with first."""
        return self._seen().states(branch)

    def events(self) -> Iterator[Noted]:
        """Yield what was noted on all branches, in order of time."""
        return self._seen().events()

    def ledger(self, branch: int) -> Iterator[tuple[int, int, int]]:
        """Yield tick, lateness [ns] and work [ns] of the branch alone."""
        return self._seen().ledger(branch)

    def _put(self, statement: str, row: Row) -> None:
        rows = self._waiting[statement]
        rows.append(row)
        if len(rows) >= BATCH or time.monotonic() > self._flushed + LONGEST:
            self.flush()

    def _write(self) -> None:
        try:
            self._connection.execute("BEGIN IMMEDIATE")
            for statement, rows in self._waiting.items():
                if rows:
                    self._connection.executemany(statement, rows)
            self._connection.execute("COMMIT")
        except sqlite3.Error as error:
            self._give_up(error)
            return
        self._kept = self._tick
        if self._checkpointer and self._checkpointer.gone:
            self._give_up("is not there any more: removed, or its disk is; write to another")
        elif self._checkpointer:
            self._checkpointer.relieve(self._connection)

    def _seen(self) -> Past:
        self.flush()
        return self._past

    def _owner(self, moment: Moment) -> int:
        """Return the branch that a moment is of: a replay may stand before its branch's start."""
        if self.trouble:
            return moment.branch
        return self._past.owner(moment.branch, moment.tick, moment.after)

    def _give_up(self, error: sqlite3.Error | str) -> None:
        self.trouble = self.trouble or (
            f"{self._name}: {error}; all up to tick {self._kept} of branch {self.branch} is kept"
        )
        with contextlib.suppress(sqlite3.Error):
            if self._connection.in_transaction:
                self._connection.execute("ROLLBACK")

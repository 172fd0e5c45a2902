"""A recording is one file of a run: its orders, states and events.

``session/past/history`` writes it. It stores bytes, text and numbers; only its caller knows what
they mean. An order is written before it acts, and its answer before it goes out. Orders, answers,
snapshots and forks are committed when the call returns; the rest is gathered, and a thread commits
it within a second. A process that is killed loses nothing that is committed. One whose machine
loses power loses no order, mark, snapshot or fork older than SAFE_WITHIN_S, and no tick older than
FLOWN_WITHIN_S: a thread waits for the disk, never the caller. `behind` says if it takes longer.

A recording may go out of reach: another program has it locked, its disk is full. Then what is
recorded waits, up to MAX_WAITING_BYTES bytes, and the thread tries again. Beyond that it is lost
and counted, all but orders, answers and forks: these wait on, up to as many bytes again. The
recording then goes on in a new branch that begins after the last state of its parent, because the
ticks between the two are lost. The orders given there are the parent's.
"""

# long: what waits, what is lost and what the disk has is one state, and is read at one sitting

import contextlib
import math
import sqlite3
import threading
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Final

from trainer.io.recording import file
from trainer.io.recording.checkpoint import CHECKPOINT_STATEMENT, Checkpointer
from trainer.io.recording.facts import NO_CREW_FACT, BranchCause, CrewFact, Giver
from trainer.io.recording.file import (
    FILE_FORMAT,
    TOUCH_STATEMENT,
    RecordingError,
    TakenError,
    bring_home,
    erase_texts,
    texts_in,
    wall_time,
)
from trainer.io.recording.queries import (
    ORDER_LEEWAY_TICKS,
    Branch,
    ExcessRows,
    Moment,
    Past,
    RecordedEvent,
    RecordedOrder,
    RecordedTick,
)
from trainer.io.recording.queries import Row as Answer

__all__ = [
    "FILE_FORMAT",
    "Branch",
    "ExcessRows",
    "Moment",
    "RecordedEvent",
    "RecordedOrder",
    "RecordedTick",
    "Recording",
    "RecordingError",
    "TakenError",
    "bring_home",
    "erase_texts",
    "texts_in",
]

BATCH_ROWS: Final = 256  # [rows] of a kind gathered at most
CALLER_WAIT_S: Final = 0.2  # [s] that the caller waits for a lock, of a program or the thread
WRITE_TIMEOUT_S: Final = 2.0  # [s] the same, if the caller outruns the thread, and at the end
RETRY_PERIOD_S: Final = 2.0  # [s] between tries to reach it
MAX_WAITING_BYTES: Final = 64_000_000  # [bytes] that wait at most while it is out of reach
ROW_BYTES: Final = 200  # [bytes] of a row beside what is in it
POLL_PERIOD_S: Final = 0.002  # [s] between looks at a recording that another program has locked

SAFE_WITHIN_S: Final = 1.0  # in which orders, marks and snapshots are safe from lost power
# All else is safe in this time, which may be longer: states can be flown again from the orders.
FLOWN_WITHIN_S: Final = 10.0

SHOWN_REASON: Final = "the way was shown"  # why a branch begins where the crew goes on

Row = tuple[int | str | bytes | None, ...]

BRANCH_INSERT: Final = (
    "INSERT INTO branches (id, parent, tick, after, place, why, state, cause, wall) "
    "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)"
)
ORDER_INSERT: Final = (
    "INSERT INTO orders (id, branch, tick, who, giver, role, plan, text, place, wall) "
    "VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)"
)
ANSWER_UPDATE: Final = (
    "UPDATE orders SET answer = ?, accepted = ?, crew_news = ?, crew_order = ? WHERE id = ?"
)
# a tick flown again on its own branch is the same tick
STATE_INSERT: Final = "INSERT OR IGNORE INTO states (branch, tick, state) VALUES (?, ?, ?)"
TIMING_INSERT: Final = (
    "INSERT OR IGNORE INTO ledger (branch, tick, lateness_ns, work_ns) VALUES (?, ?, ?, ?)"
)
EVENT_INSERT: Final = (
    "INSERT INTO events (branch, tick, kind, who, role, text, wall) VALUES (?, ?, ?, ?, ?, ?, ?)"
)
SNAPSHOT_INSERT: Final = (
    "INSERT INTO snapshots (name, branch, tick, state, after, place, wall) "
    "VALUES (?, ?, ?, ?, ?, ?, ?)"
)
# They are written in this order, because a row may refer to one of an earlier kind.
STATEMENTS: Final = (
    BRANCH_INSERT,
    ORDER_INSERT,
    ANSWER_UPDATE,
    STATE_INSERT,
    TIMING_INSERT,
    EVENT_INSERT,
    SNAPSHOT_INSERT,
)
# Rows that wait on where the rest is dropped: by them the ticks that are lost can be flown again
LASTING_STATEMENTS: Final = (BRANCH_INSERT, ORDER_INSERT, ANSWER_UPDATE)
# Rows that are promised to outlive lost power; marks are too, but they are events.
PROMISED_STATEMENTS: Final = (BRANCH_INSERT, ORDER_INSERT, ANSWER_UPDATE, SNAPSHOT_INSERT)
MARK_KIND: Final = "mark"  # the kind of such an event
COUNTED_STATEMENTS: Final = {
    STATE_INSERT: "ticks",
    ORDER_INSERT: "orders",
    EVENT_INSERT: "events",
    SNAPSHOT_INSERT: "snapshots",
}


class Recording(Past):
    """A recording being written or read. One thread may use it, beside its own thread.

    It writes waiting rows before it answers a question, so that the answer has them too.
    """

    trouble: str  # why nothing is written at present; "" while all is well
    branch: int  # the present one
    reachable: bool  # after a gap: ``go_on`` can begin a new branch
    absences: int  # how often it was out of reach
    wake: Callable[[], object]  # called by the thread when trouble begins or ends

    def __init__(
        self,
        writing: sqlite3.Connection,
        reading: sqlite3.Connection,
        name: str,
        checkpointer: Checkpointer | None,
    ) -> None:
        """Take an open file; `create`, `reopen` and `look` open them.

        With a thread of its own the file is open twice, because Python's SQLite waits for a
        connection in use without letting other threads run, even the one that uses it.
        """
        self.trouble = ""
        self.reachable = False
        self.absences = 0
        self._waiting: dict[str, list[Row]] = {statement: [] for statement in STATEMENTS}
        super().__init__(reading, name)
        self._writer = writing
        self._checkpointer = checkpointer
        self.branch = self._branches = self.last_branch()
        self._order = self.last_order()
        self._tick = self._kept = self.last_tick(self.branch)
        self._states, self._timings = self._waiting[STATE_INSERT], self._waiting[TIMING_INSERT]
        self._writing_it = threading.Lock()  # held by who uses the connection to write
        self._shortening = threading.Lock()  # held for a moment where what waits grows shorter
        self._held = 0  # [bytes] that wait while it is out of reach
        self._gap = False  # more than there is room for has come: most of it is only counted
        self._lost = dict.fromkeys(COUNTED_STATEMENTS, 0)  # in this gap
        self._missing = dict.fromkeys(COUNTED_STATEMENTS, 0)  # in all
        self.wake = lambda: None
        self._tried = -math.inf  # [s] when it was last tried: a machine may be just up
        self._plight = ("", False, "")  # as the thread last saw it
        if checkpointer:
            checkpointer.start(self._tend)

    @classmethod
    def create(cls, path: Path | None, header: Mapping[str, str], state: bytes) -> "Recording":
        """Begin a recording at tick 0 with `state`. Without a path one that is gone when closed.

        RecordingError if there is such a file already, or it cannot be made.
        """
        if path is None:
            only = file.temporary(header, state)
            return cls(only, only, "the temporary recording", None)
        return cls._writing(file.create(path, header, state), path)

    @classmethod
    def create_converted(
        cls, path: Path, source: Path, header: Mapping[str, str], convert: Callable[[bytes], bytes]
    ) -> "Recording":
        """Go on with what ``source`` holds in another file, each state converted; RecordingError.

        ``source`` stays as it is.
        """
        return cls._writing(file.create_converted(path, source, header, convert), path)

    @classmethod
    def reopen(cls, path: Path) -> "Recording":
        """Go on with the latest branch of a recording; RecordingError if another program has it."""
        recording = cls._writing(file.reopen(path), path)
        if recording._checkpointer:  # noqa: SLF001  its own
            # a killed program may not have asked the disk for what it had answered
            recording._checkpointer.disk.expect(SAFE_WITHIN_S)  # noqa: SLF001
        return recording

    @classmethod
    def look(cls, path: Path) -> "Recording":
        """Open a recording for reading, while it is written or afterwards."""
        with contextlib.ExitStack() as unless_good:
            only = file.open_for_reading(path)
            unless_good.callback(only.close)
            recording = cls(only, only, str(path), None)
            unless_good.pop_all()
        return recording

    @classmethod
    def _writing(cls, writing: sqlite3.Connection, path: Path) -> "Recording":
        """Return the recording; what is open is closed if it turns out to be damaged."""
        with contextlib.ExitStack() as unless_good:
            unless_good.callback(writing.close)
            reading = file.open_beside_writer(path)
            unless_good.callback(reading.close)
            reading.execute("PRAGMA busy_timeout = 0")  # it is read between ticks
            checkpointer = Checkpointer(path)
            unless_good.callback(checkpointer.close)
            recording = cls(writing, reading, str(path), checkpointer)
            unless_good.pop_all()
        return recording

    # Writing

    def order(self, tick: int, giver: Giver, text: str, entry: int | None = None) -> int:
        """Write an order that is about to act, at once; return its number."""
        self._order += 1
        self._tick = tick
        giver_columns = (giver.words, giver.kind.value, giver.role, giver.plan)
        row = (self._order, self.branch, tick, *giver_columns, text, entry, wall_time())
        if self._gap and tick > self._kept + ORDER_LEEWAY_TICKS:
            self._count_lost(ORDER_INSERT, 1)
        else:
            self._put(ORDER_INSERT, row)
        self.flush()
        return self._order

    def answered(
        self,
        order: int,
        answer: str,
        accepted: bool,  # noqa: FBT001
        crew: CrewFact = NO_CREW_FACT,
    ) -> None:
        """Write the answer to an order and its crew fact, before it goes out."""
        self._put(ANSWER_UPDATE, (answer, int(accepted), crew.news.value, crew.order, order))
        self.flush()

    def state(self, tick: int, state: bytes) -> None:
        """Take the state at the end of a tick. A second state of the same tick is ignored."""
        self._tick = tick
        if self.trouble:
            self._put(STATE_INSERT, (self.branch, tick, state))
            return
        self._states.append((self.branch, tick, state))
        if len(self._states) >= BATCH_ROWS:
            self.flush(WRITE_TIMEOUT_S)

    def timing(self, tick: int, lateness: int, work: int) -> None:
        """Take how late [ns] a tick began and how long [ns] it worked."""
        if not self._gap:
            self._timings.append((self.branch, tick, lateness, work))

    def event(self, tick: int, kind: str, who: str, text: str, role: str = "") -> None:
        """Take an event, with the time of day now. ``role`` is that of ``who``."""
        self._put(EVENT_INSERT, (self.branch, tick, kind, who, role, text, wall_time()))

    def snapshot(self, name: str, moment: Moment) -> None:
        """Write a moment under a name, at once, or where `trouble` says why not, never.

        Only a disk that hangs within that very write may have it later all the same.
        """
        branch = self._owner(moment)
        moment_columns = (branch, moment.tick, moment.state, moment.after, moment.entry)
        row = (name, *moment_columns, wall_time())
        self._put(SNAPSHOT_INSERT, row)
        self.flush()
        if self.trouble and self._writing_it.acquire(blocking=False):
            with contextlib.suppress(ValueError):  # it was dropped, or written meanwhile
                self._waiting[SNAPSHOT_INSERT].remove(row)
            self._writing_it.release()

    def fork(self, moment: Moment, why: str, cause: BranchCause = BranchCause.JUMP) -> int:
        """Begin a new branch at a moment, at once. Return its number, from now on the present.

        RecordingError where nothing can be read, or more waits than there is room for.
        """
        if self._crowded:
            raise RecordingError(f"no room for one more branch: {self.trouble}")
        parent = self._owner(moment)
        self._begin_branch(parent, moment, why, cause)
        self.flush()
        self.branch = self._branches
        self._tick = self._kept = moment.tick
        return self.branch

    def leave_shown(self) -> None:
        """Begin a branch where one began that shows the way and was cut short."""
        here = self._branch(self.branch)
        if here.cause is BranchCause.SHOWN and here.parent is not None:
            begun = Moment(here.parent, here.tick, here.state, here.after, here.entry)
            self.fork(begun, SHOWN_REASON)

    def go_on(self, moment: Moment) -> bool:
        """Go on after a gap in a new branch from a moment. Its cause says what is missing.

        Return whether it goes on. Where it cannot be read yet, the thread tries to reach it again.
        """
        parent = self.branch
        try:
            last = self.last_tick(parent)
        except RecordingError:
            self.reachable = False
            return False
        self._gap = self.reachable = False
        self.trouble = ""
        why = f"not recorded after tick {last}: {_counts(self._lost) or 'nothing'} lost"
        self._lost = dict.fromkeys(COUNTED_STATEMENTS, 0)
        self._begin_branch(parent, moment, why, BranchCause.GAP)
        self.branch, self._tick = self._branches, moment.tick
        self.flush()
        return True

    def _begin_branch(self, parent: int, moment: Moment, why: str, cause: BranchCause) -> None:
        """Put down the next branch, which begins at a moment."""
        self._branches += 1
        begun = (parent, moment.tick, moment.after, moment.entry, why, moment.state, cause.value)
        self._put(BRANCH_INSERT, (self._branches, *begun, wall_time()))

    @property
    def behind(self) -> str:
        """Return why lost power would still take the last orders, "" if not."""
        if not (self._checkpointer and self._checkpointer.disk.behind):
            return ""
        failure = self._checkpointer.disk.failure
        return (failure.strerror or str(failure)) if failure else "it is slow"

    @property
    def missing(self) -> str:
        """Return in words what was lost for good, "" for nothing."""
        return _counts(self._missing) if any(self._missing.values()) else ""

    def flush(self, patience: float = CALLER_WAIT_S) -> None:
        """Write waiting rows, all or none. If that fails, `trouble` says why."""
        if not self.trouble and any(self._waiting.values()):
            self._write(patience)

    def close(self) -> None:
        """Write waiting rows, move the log into the one file, and close it."""
        if self._checkpointer:
            self._checkpointer.close()
        self.flush(WRITE_TIMEOUT_S)
        end = time.monotonic() + WRITE_TIMEOUT_S
        self.reachable = False  # in a gap too orders may wait
        while self.trouble and self._checkpointer and not self.reachable and time.monotonic() < end:
            self._reach()
            time.sleep(CALLER_WAIT_S)
        self._connection.close()
        if self._checkpointer:
            with contextlib.suppress(sqlite3.Error):  # it is all there, if not at home
                self._writer.execute(CHECKPOINT_STATEMENT)
        if self.trouble:
            self._drop()
        self._writer.close()

    def state_at(self, branch: int, tick: int) -> bytes | None:
        """Return the state at the end of a tick in a branch or its ancestry."""
        moment = self.moment(branch, tick)
        return None if moment is None else moment.state

    def latest(self) -> Moment:
        """Return the end of the last recorded tick of the latest branch."""
        branch = self.last_branch()
        moment = self.moment(branch, self.last_tick(branch))
        if moment is None:
            raise RecordingError(f"{self._name} cannot be read: its last state is missing")
        return moment

    def snapshots(self) -> list[tuple[str, Moment]]:
        """Return the named moments: the latest of each name in the present branch's past.

        What was kept on other branches only is there too, before them.
        """
        return self.snapshots_seen_from(self.branch)

    def _rows(self, question: str, *values: int) -> Iterator[Answer]:
        self.flush()
        return super()._rows(question, *values)

    def _put(self, statement: str, row: Row) -> None:
        """Queue a row. Out of reach, drop rows once they take too much memory."""
        if self._gap and (self._crowded or statement not in LASTING_STATEMENTS):
            self._count_lost(statement, 1)
            return
        rows = self._waiting[statement]
        rows.append(row)
        if self.trouble:
            self._held += _size_of(row)
            if self._held > MAX_WAITING_BYTES and not self._gap:
                self._drop(LASTING_STATEMENTS)
        elif len(rows) >= BATCH_ROWS:
            self.flush(WRITE_TIMEOUT_S)

    @property
    def _crowded(self) -> bool:
        """Return whether no row has room, not even one that waits on in a gap."""
        return self._gap and self._held > MAX_WAITING_BYTES

    def _drop(self, spared: Collection[str] = ()) -> None:
        """Drop the waiting rows, and count them as lost; ``spared`` are statements that wait on."""
        with self._shortening:
            self._gap = True
            for statement in {*STATEMENTS}.difference(spared):
                self._count_lost(statement, len(self._waiting[statement]))
                self._waiting[statement].clear()
            self._held = sum(map(_size_of, chain(*self._waiting.values())))

    def _count_lost(self, statement: str, number: int) -> None:
        for counts in (self._lost, self._missing):
            if statement in counts:
                counts[statement] += number

    def _write(self, patience: float) -> None:
        """Write waiting rows. Give up after `patience` [s], out of reach from then on."""
        if self._writing_it.acquire(timeout=patience):
            self._commit_or_lose(patience)
        else:
            self._lose("its disk does not answer")

    def _commit_or_lose(self, patience: float) -> None:
        """Write waiting rows and release the connection, which the caller has acquired."""
        try:
            self._commit(patience)
        except sqlite3.Error as error:
            self._tried = time.monotonic()
            self._lose(error)
        finally:
            self._writing_it.release()

    def _commit(self, patience: float) -> None:
        """Write waiting rows in one transaction; on sqlite3.Error all of them wait on."""
        tick = self._tick
        # a row may rest on one of a kind before its own, which is therefore counted after it
        counts = {each: len(self._waiting[each]) for each in reversed(STATEMENTS)}
        try:
            _begin(self._writer, time.monotonic() + patience)
            for statement in STATEMENTS:
                if counts[statement]:
                    rows = self._waiting[statement][: counts[statement]]
                    self._writer.executemany(statement, rows)
            self._writer.execute("COMMIT")
        except sqlite3.Error:
            with contextlib.suppress(sqlite3.Error):
                if self._writer.in_transaction:
                    self._writer.execute("ROLLBACK")
            raise
        with self._shortening:
            if self._checkpointer:
                promised = self._has_promised(counts)
                self._checkpointer.disk.expect(SAFE_WITHIN_S if promised else FLOWN_WITHIN_S)
            for statement, count in counts.items():
                del self._waiting[statement][:count]
        if not self._gap:
            self._kept = tick
        if self._checkpointer and self._checkpointer.gone:
            self._lose("is not there any more: removed, or its disk is; write to another")
        elif self._checkpointer:
            self._checkpointer.relieve(self._writer)

    def _has_promised(self, counts: Mapping[str, int]) -> bool:
        """Return whether the rows written have an order, mark, snapshot or fork among them.

        The event that tells of a slow disk is not among them. It would be late on that disk too,
        and cause the next such event without end.
        """
        marks = (row[2] == MARK_KIND for row in self._waiting[EVENT_INSERT][: counts[EVENT_INSERT]])
        return any(counts[each] for each in PROMISED_STATEMENTS) or any(marks)

    def _tend(self) -> None:
        """Commit waiting rows, or try to reach the recording again. Its own thread calls this."""
        waits = any(self._waiting.values()) and not self.trouble
        if waits and self._writing_it.acquire(blocking=False):  # else it is being written
            self._commit_or_lose(CALLER_WAIT_S)
        # the disk may have kept this thread so long that the caller gave the recording up
        if self.trouble and not self.reachable and time.monotonic() > self._tried + RETRY_PERIOD_S:
            self._reach()
        if self._plight != (plight := (self.trouble, self.reachable, self.behind)):
            self._plight = plight
            self.wake()  # a frozen session would not look by itself

    def _reach(self) -> None:
        """Try to write again, unless the file is gone or its connection in use."""
        self._tried = time.monotonic()
        if self._checkpointer and self._checkpointer.gone:
            return
        if not self._writing_it.acquire(timeout=CALLER_WAIT_S):
            return
        try:
            self._try()
        except sqlite3.Error:
            return
        finally:
            self._writing_it.release()

    def _try(self) -> None:
        """Write waiting rows, after a gap TOUCH_STATEMENT first as a test; sqlite3.Error."""
        if self._gap:
            _begin(self._writer, 0.0)
            self._writer.execute(TOUCH_STATEMENT)
            self._writer.execute("COMMIT")
        self._commit(0.0)
        with self._shortening:
            self._held = 0
            self.reachable = self._gap
            if not self._gap:
                self.trouble = ""

    def _owner(self, moment: Moment) -> int:
        """Return the branch of a moment. A replay may stand before the start of its branch."""
        if self.trouble:
            return moment.branch
        return self.owner(moment.branch, moment.tick, moment.after)

    def _lose(self, error: sqlite3.Error | str) -> None:
        """Note that the recording is out of reach."""
        if self.trouble:
            return
        self._held = 0
        self.absences += 1
        self.trouble = (
            f"{self._name}: {error}; all up to tick {self._kept} of branch {self.branch} is kept"
        )


def _begin(connection: sqlite3.Connection, end: float) -> None:
    """Begin to write, waiting for another program until `end` [s]; sqlite3.Error beyond it."""
    while True:
        try:
            connection.execute("BEGIN IMMEDIATE")
        except sqlite3.OperationalError as error:
            busy = error.sqlite_errorcode & 0xFF == sqlite3.SQLITE_BUSY
            if not busy or time.monotonic() > end:
                raise
            time.sleep(POLL_PERIOD_S)
        else:
            return


def _size_of(row: Row) -> int:
    """Return how much memory [bytes] a row takes, about."""
    return ROW_BYTES + sum(len(part) for part in row if isinstance(part, str | bytes))


def _counts(lost: Mapping[str, int]) -> str:
    """Return in words how many of each kind were lost."""
    return ", ".join(
        f"{number} {COUNTED_STATEMENTS[each]}" for each, number in lost.items() if number
    )

"""The file of a recording is an SQLite database. One program writes it, and any may read it.

``recording`` and ``queries`` open it here. It appears under its name only when it is whole. While
it is written it is in WAL mode, because then readers see what is committed without holding up the
writer, and the commits of a killed program stay for the next one.
"""

import contextlib
import os
import shutil
import sqlite3
import tempfile
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from typing import Final

from trainer.io.orders.table import REMARK_ORDERS
from trainer.io.outputs import note_input
from trainer.io.recording import format_1
from trainer.io.recording.facts import BranchCause

FILE_FORMAT: Final = 2  # raised when older programs can no longer read what newer ones write
APPLICATION_ID: Final = 0x74726E72  # "trnr": what `file` and SQLite's tools know a recording by
BUSY_TIMEOUT_S: Final = 2.0  # [s] for another program that holds the file for a moment
MAX_NAME_LETTERS: Final = 60  # [characters] that are shown of a file's own
FULL_DISK_BYTES: Final = 65_536  # [bytes] that SQLite wants beside a recording, free at least
# SQLite's own way to the files of a system, without locks
LOCKLESS_SYSTEM: Final = "unix-none" if os.name == "posix" else "win32-none"
UNWRITABLE_CODES: Final = (
    *(sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY),
    *(sqlite3.SQLITE_IOERR, sqlite3.SQLITE_FULL),
)

# Tables that format 1 had with fewer columns
CHANGED_TABLES: Final = """CREATE TABLE branches (
    id INTEGER PRIMARY KEY, parent INTEGER REFERENCES branches, tick INTEGER NOT NULL,
    after INTEGER NOT NULL, place INTEGER NOT NULL, why TEXT NOT NULL, state BLOB NOT NULL,
    wall TEXT NOT NULL, cause TEXT NOT NULL
);
CREATE TABLE orders (
    id INTEGER PRIMARY KEY, branch INTEGER NOT NULL, tick INTEGER NOT NULL, who TEXT NOT NULL,
    text TEXT NOT NULL, place INTEGER, accepted INTEGER, answer TEXT NOT NULL DEFAULT '',
    wall TEXT NOT NULL, giver TEXT NOT NULL, role TEXT NOT NULL, plan INTEGER NOT NULL,
    crew_news TEXT NOT NULL DEFAULT '', crew_order TEXT NOT NULL DEFAULT ''
);
CREATE INDEX orders_by_tick ON orders (branch, tick, place);
CREATE TABLE events (
    id INTEGER PRIMARY KEY, branch INTEGER NOT NULL, tick INTEGER NOT NULL, kind TEXT NOT NULL,
    who TEXT NOT NULL, text TEXT NOT NULL, wall TEXT NOT NULL, role TEXT NOT NULL
);
"""
SCHEMA: Final = f"""
PRAGMA page_size = 8192;
PRAGMA application_id = {APPLICATION_ID};
PRAGMA user_version = {FILE_FORMAT};
BEGIN;
CREATE TABLE header (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
{CHANGED_TABLES}CREATE TABLE states (
    branch INTEGER NOT NULL, tick INTEGER NOT NULL, state BLOB NOT NULL, UNIQUE (branch, tick)
);
CREATE TABLE ledger (
    branch INTEGER NOT NULL, tick INTEGER NOT NULL, lateness_ns INTEGER NOT NULL,
    work_ns INTEGER NOT NULL, PRIMARY KEY (branch, tick)
) WITHOUT ROWID;
CREATE TABLE snapshots (
    id INTEGER PRIMARY KEY, name TEXT NOT NULL, branch INTEGER NOT NULL, tick INTEGER NOT NULL,
    state BLOB NOT NULL, after INTEGER NOT NULL, place INTEGER NOT NULL, wall TEXT NOT NULL
);
COMMIT;
"""
FORMAT_SCHEMAS: Final = {1: SCHEMA.replace(CHANGED_TABLES, format_1.TABLES_1), FILE_FORMAT: SCHEMA}
# A write that changes nothing: it shows whether the file can be written.
TOUCH_STATEMENT: Final = f"PRAGMA user_version = {FILE_FORMAT}"

# A file may come from anybody, and be made to do harm. These bound what SQLite does for it
# (docs/threat-model.md). Names and numbers are SQLite's.
GUARD_STATEMENTS: Final = """
PRAGMA trusted_schema = OFF;
PRAGMA cell_size_check = ON;
PRAGMA mmap_size = 0;
PRAGMA hard_heap_limit = 120000000;
"""
SQLITE_LIMITS: Final = (
    (sqlite3.SQLITE_LIMIT_LENGTH, 16_000_000),  # [bytes] of a value; all texts of a run are one
    (sqlite3.SQLITE_LIMIT_SQL_LENGTH, 5_000),  # [bytes] of a statement, or of a table's own
    (sqlite3.SQLITE_LIMIT_COLUMN, 30),
    (sqlite3.SQLITE_LIMIT_EXPR_DEPTH, 20),
    (sqlite3.SQLITE_LIMIT_ATTACHED, 0),
    (sqlite3.SQLITE_LIMIT_TRIGGER_DEPTH, 0),
)
SIGNAL_STEPS: Final = 100_000  # of SQLite's machine between looks for signals, such as Ctrl-C

WRITTEN_TEXTS: Final = {  # that people have written, or that repeat them, by the table
    "branches": ("why",),
    "orders": ("text", "who", "answer", "crew_order"),
    "events": ("text", "who"),
}


class RecordingError(Exception):
    """A recording that cannot be made, opened or read. The text says why and what to do."""


class TakenError(RecordingError):
    """A recording that cannot be made, because its name is taken."""


@contextlib.contextmanager
def understanding(name: object) -> Iterator[None]:
    """Raise RecordingError where SQLite cannot make sense of a file.

    Other errors pass, because they come from the disk, the system or this program.
    """
    try:
        yield
    except MemoryError:
        raise RecordingError(f"{name} is damaged: it asks for more memory than any can") from None
    except (sqlite3.DatabaseError, UnicodeDecodeError) as error:
        code = getattr(error, "sqlite_errorcode", None)  # a text that is none has no code
        if code == sqlite3.SQLITE_INTERRUPT:  # a signal's exception, lost in C
            raise KeyboardInterrupt from None
        if code is not None and isinstance(error, sqlite3.OperationalError):
            raise
        if code == sqlite3.SQLITE_NOTADB:
            raise RecordingError(f"{name} is not a recording: {error}") from None
        why = error if code is not None else "a text in it is none"
        raise RecordingError(
            f"{name} is damaged: {why}; SQLite's own program may save a part: "
            f'sqlite3 "{name}" .recover'
        ) from None


def wall_time() -> str:
    """Return the time of day, UTC, to the millisecond."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def connect(path: Path, options: str) -> sqlite3.Connection:
    """Return a connection that begins no transaction by itself; `options` of an SQLite URI."""
    name = f"{path.absolute().as_uri()}?{options}"
    threads = {"check_same_thread": False}  # who writes has a lock
    return _guard(sqlite3.connect(name, BUSY_TIMEOUT_S, isolation_level=None, uri=True, **threads))


def _guard(connection: sqlite3.Connection) -> sqlite3.Connection:
    """Return a connection to a file that may be made to do harm, with SQLite's limits set."""
    for limit, most in SQLITE_LIMITS:
        connection.setlimit(limit, most)
    # Python looks for signals in this call. Otherwise Ctrl-C would wait for a long query.
    connection.set_progress_handler(lambda: None, SIGNAL_STEPS)
    connection.executescript(GUARD_STATEMENTS)
    return connection


def temporary(header: Mapping[str, str], state: bytes) -> sqlite3.Connection:
    """Return a recording for this process alone, which is deleted when it is closed."""
    connection = sqlite3.connect("", isolation_level=None)  # "": SQLite's own temporary file
    connection.execute("PRAGMA journal_mode = MEMORY")
    connection.execute("PRAGMA synchronous = OFF")
    _fill(connection, header, state)
    return connection


def create(path: Path, header: Mapping[str, str], state: bytes) -> sqlite3.Connection:
    """Make a recording and return it for writing; RecordingError if the name is taken."""
    return _make(path, lambda made: _write_whole(made, header, state))


def create_converted(
    path: Path, source: Path, header: Mapping[str, str], convert: Callable[[bytes], bytes]
) -> sqlite3.Connection:
    """Make a recording of all that ``source`` holds, each state converted; return it for writing.

    Its header is that of ``source`` with the values of ``header``.
    """
    return _make(path, lambda made: _write_converted(made, source, header, convert))


def _make(path: Path, write: Callable[[Path], None]) -> sqlite3.Connection:
    """Have a recording written, and return it for writing; RecordingError if the name is taken.

    It is made under another name in the same folder, so that nobody finds it half made.
    """
    if os.path.lexists(path):
        raise TakenError(f"{path} exists already; name another file, or remove it")
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=f".{path.name}.") as folder:
            made = Path(folder) / path.name
            write(made)
            _give_name(made, path)
    except OSError as error:
        raise RecordingError(f"{path} cannot be made: {error.strerror}") from None
    except sqlite3.Error as error:
        raise RecordingError(f"{path} cannot be made: {error}") from None
    return reopen(path)


def reopen(path: Path) -> sqlite3.Connection:
    """Return an existing recording for writing, closed to other writers."""
    _find(path)
    with contextlib.ExitStack() as unless_good, understanding(path):
        try:
            connection = connect(path, "mode=rw")
            unless_good.callback(connection.close)
            version = _recognise(connection, path)
            connection.execute("PRAGMA synchronous = NORMAL")
            connection.execute("PRAGMA wal_autocheckpoint = 0")
            connection.execute("PRAGMA journal_size_limit = 0")
            _claim(connection, path, version)
            if version < FILE_FORMAT:
                format_1.upgrade(connection, CHANGED_TABLES)
            connection.execute("PRAGMA busy_timeout = 0")  # who writes waits in its own way
        except sqlite3.OperationalError as error:
            if not hasattr(error, "sqlite_errorcode"):  # a text that is none: the file is damaged
                raise
            raise RecordingError(f"{path} cannot be written: {_why_not(error, path)}") from None
        unless_good.pop_all()
    return connection


def open_beside_writer(path: Path) -> sqlite3.Connection:
    """Return a recording for reading in the program that writes it."""
    try:
        return _readable(connect(path, "mode=rw"), path)
    except sqlite3.OperationalError as error:
        raise RecordingError(f"{path} cannot be read: {_why_not(error, path)}") from None


def open_for_reading(path: Path) -> sqlite3.Connection:
    """Return a recording for reading, even while another program writes it.

    A log that was left behind stays as it is, because SQLite would move it into the file at the end
    (``bring_home``). To read it, SQLite makes a file beside it. Where that cannot be, the disk is
    full or the medium read-only, and nobody writes the recording: it is read without that file.
    """
    _find(path)
    index = path.with_name(f"{path.name}-shm")  # there as long as anybody writes
    try:
        if not _has_log(path):
            return _readable(connect(path, "mode=rw"), path)
        return _readable(connect(path, "mode=ro") if index.exists() else _connect_alone(path), path)
    except sqlite3.OperationalError as error:
        if error.sqlite_errorcode & 0xFF not in UNWRITABLE_CODES:
            raise RecordingError(f"{path} cannot be read: {error}") from None
    try:
        return _readable(_connect_alone(path), path)
    except sqlite3.OperationalError as error:
        raise RecordingError(f"{path} cannot be read: {_why_not(error, path)}") from None


def bring_home(path: Path) -> None:
    """Move a log that was left behind into its recording, if nobody has it open."""
    if _has_log(path):
        with contextlib.suppress(sqlite3.Error):
            own = connect(path, "mode=rw")
            own.execute("PRAGMA user_version").fetchone()  # so that the log is found
            own.close()


def _fill(connection: sqlite3.Connection, header: Mapping[str, str], state: bytes) -> None:
    connection.executescript(SCHEMA)
    connection.execute("BEGIN")
    connection.executemany("INSERT INTO header VALUES (?, ?)", header.items())
    cause = BranchCause.START.value
    first = (1, None, 0, 0, 0, "the start", state, wall_time(), cause)
    connection.execute("INSERT INTO branches VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)", first)
    connection.execute("COMMIT")


def _write_whole(path: Path, header: Mapping[str, str], state: bytes) -> None:
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as connection:
        _fill(connection, header, state)
        _keep_log(connection, path)


def _write_converted(
    path: Path, source: Path, header: Mapping[str, str], convert: Callable[[bytes], bytes]
) -> None:
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as made:
        with contextlib.closing(open_for_reading(source)) as held:
            held.backup(made)
        _keep_log(made, path)
    with contextlib.closing(reopen(path)) as made:  # in today's format
        made.execute("BEGIN IMMEDIATE")
        made.executemany("INSERT OR REPLACE INTO header VALUES (?, ?)", header.items())
        for table in ("branches", "states", "snapshots"):
            state_of = f"SELECT state FROM {table} WHERE rowid = ?"  # noqa: S608 our own names
            update = f"UPDATE {table} SET state = ? WHERE rowid = ?"  # noqa: S608 our own names
            for number in made.execute(f"SELECT rowid FROM {table}").fetchall():  # noqa: S608 our own
                (state,) = made.execute(state_of, number).fetchone()
                made.execute(update, (convert(state), *number))
        made.execute("COMMIT")


def _keep_log(connection: sqlite3.Connection, path: Path) -> None:
    """Put a file into WAL mode; RecordingError if its file system cannot have it."""
    (mode,) = connection.execute("PRAGMA journal_mode = WAL").fetchone()
    if mode != "wal":
        raise RecordingError(
            f"{path.parent.parent} cannot hold a recording: its file system lacks the shared "
            "memory that SQLite needs; record to a local disk"
        )


def _give_name(made: Path, path: Path) -> None:
    """Give a finished file its name, unless another program has taken it meanwhile."""
    try:
        os.link(made, path)
    except FileExistsError:
        raise TakenError(f"{path} has just been made by another program") from None
    except OSError:  # a file system without links
        made.rename(path)


def _find(path: Path) -> None:
    """Raise RecordingError unless there is a file, without opening it.

    To open and close the file here would give up SQLite's own locks on it (POSIX locks).
    """
    try:
        note_input(path)
        size = path.stat().st_size
    except OSError as error:
        raise RecordingError(f"{path} cannot be opened: {error.strerror}") from None
    if path.is_dir():
        raise RecordingError(f"{path} is a folder; name a recording in it")
    if not path.is_file():
        raise RecordingError(f"{path} is not a recording, nor any file")
    if size == 0:
        raise RecordingError(f"{path} is not a recording: it is empty")
    if not os.access(path, os.R_OK):
        raise RecordingError(f"{path} cannot be opened: you have no right to read it")


def _recognise(connection: sqlite3.Connection, path: Path) -> int:
    """Return the format of a recording; RecordingError unless this program knows it."""
    (application,) = connection.execute("PRAGMA application_id").fetchone()
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    if application != APPLICATION_ID:
        raise RecordingError(f"{path} is not a recording: it is another program's database")
    if version not in FORMAT_SCHEMAS:
        raise RecordingError(
            f"{path} is a recording of format {version}, and this trainer knows format "
            f"{FILE_FORMAT}; "
            "use the version of the trainer that made it, or a newer one"
        )
    schema = _schema(connection)
    for kind, name, _, _ in sorted(schema ^ _own_schema(version), key=str)[:1]:
        raise RecordingError(
            f"{path} is damaged, or made to do harm: its {kind} {name[:MAX_NAME_LETTERS]!r} is not "
            "as in a recording; nothing of it is used"
        )
    return int(version)


def _schema(connection: sqlite3.Connection) -> frozenset[tuple[str, str, str, str | None]]:
    """Return all objects of a database: tables, indices, and any others."""
    rows = connection.execute("SELECT type, name, tbl_name, sql FROM sqlite_schema")
    return frozenset((str(kind), str(name), str(of), sql) for kind, name, of, sql in rows)


@cache
def _own_schema(version: int) -> frozenset[tuple[str, str, str, str | None]]:
    """Return the objects that a recording of a format has."""
    with contextlib.closing(sqlite3.connect(":memory:", isolation_level=None)) as empty:
        empty.executescript(FORMAT_SCHEMAS[version])
        return _schema(empty)


def _readable(connection: sqlite3.Connection, path: Path) -> sqlite3.Connection:
    """Return the connection, made unable to change what it reads; closed if it is no recording."""
    with contextlib.ExitStack() as unless_good, understanding(path):
        unless_good.callback(connection.close)
        _recognise(connection, path)
        connection.execute("PRAGMA query_only = ON")
        unless_good.pop_all()
    return connection


def _claim(connection: sqlite3.Connection, path: Path, version: int) -> None:
    """Make sure that nobody else has the file open.

    Every connection holds a shared lock for as long as it is open, even an idle one. So only the
    sole connection can get the exclusive lock, which it then changes to a shared one.
    """
    touch = f"PRAGMA user_version = {version}"
    try:
        connection.execute("PRAGMA locking_mode = EXCLUSIVE")
        connection.execute(touch)
        connection.execute("PRAGMA locking_mode = NORMAL")
        connection.execute(touch)
    except sqlite3.OperationalError as error:
        if error.sqlite_errorcode & 0xFF != sqlite3.SQLITE_BUSY:
            raise
        raise RecordingError(
            f"{path} is in use: a session is writing it or a program reading it; "
            "go on with it when that has ended"
        ) from None


def _connect_alone(path: Path) -> sqlite3.Connection:
    """Return a connection for reading that makes no file, with the log that was left behind."""
    if not _has_log(path):
        return connect(path, "mode=ro&immutable=1")
    connection = connect(path, f"mode=ro&vfs={LOCKLESS_SYSTEM}")
    connection.execute("PRAGMA locking_mode = EXCLUSIVE")  # the index of the log is in memory
    return connection


def _has_log(path: Path) -> bool:
    """Return whether anything is written ahead of a recording."""
    try:
        return path.with_name(f"{path.name}-wal").stat().st_size > 0
    except OSError:
        return False


def _why_not(error: sqlite3.OperationalError, path: Path) -> str:
    """Return why a file cannot be used; SQLite calls a full disk an I/O error as well."""
    code = error.sqlite_errorcode & 0xFF
    full = code == sqlite3.SQLITE_FULL or (
        code == sqlite3.SQLITE_IOERR and shutil.disk_usage(path.parent).free < FULL_DISK_BYTES
    )
    return f"its disk is full ({error}); make room there" if full else str(error)


def texts_in(path: Path) -> Iterator[tuple[str, str]]:
    """Yield all texts of a recording, each with where it stands; RecordingError."""
    with contextlib.closing(open_for_reading(path)) as connection, understanding(path):
        for table in ("header", "snapshots", *WRITTEN_TEXTS):
            for row in connection.execute(f"SELECT * FROM {table}"):  # noqa: S608 our own names
                yield from ((f"{table} {row[0]}", each) for each in row if isinstance(each, str))


def erase_texts(
    path: Path, header: Mapping[str, str | None], without: Callable[[str], str]
) -> None:
    """Give a recording other values in its header, None for none, and other texts.

    The file is made anew, so that nothing is left of what stood there, not even in what it has
    free. RecordingError if it is in use or cannot be written.
    """
    with contextlib.closing(reopen(path)) as connection, understanding(path):
        try:
            connection.setlimit(sqlite3.SQLITE_LIMIT_ATTACHED, 1)  # by which VACUUM works
            connection.execute("PRAGMA secure_delete = ON")
            connection.execute("BEGIN IMMEDIATE")
            for table, columns in WRITTEN_TEXTS.items():
                _change_texts(connection, table, columns, without)
            for key, value in header.items():
                connection.execute("DELETE FROM header WHERE key = ?", (key,))
                if value is not None:
                    connection.execute("INSERT INTO header VALUES (?, ?)", (key, value))
            connection.execute("COMMIT")
            connection.execute("VACUUM")
            connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        except sqlite3.OperationalError as error:
            raise RecordingError(f"{path} cannot be written: {error}") from None


def _change_texts(
    connection: sqlite3.Connection,
    table: str,
    columns: tuple[str, ...],
    without: Callable[[str], str],
) -> None:
    """Change texts of a table; of an order that is no remark its own words stay."""
    asked = f"SELECT id, {', '.join(columns)} FROM {table}"  # noqa: S608 our own names
    changing = f"UPDATE {table} SET {', '.join(f'{each} = ?' for each in columns)} WHERE id = ?"  # noqa: S608 our own names
    for number, *texts in connection.execute(asked).fetchall():
        format_1.check_texts(*texts)
        new = [*map(without, texts)]
        if table == "orders" and texts[0].partition(" ")[0] not in REMARK_ORDERS:
            new[0] = texts[0]
        if new != texts:
            connection.execute(changing, (*new, number))

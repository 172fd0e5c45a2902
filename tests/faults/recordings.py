"""Recordings are damaged on purpose. Whatever opens one says so in a line."""

import contextlib
import json
import random
import sqlite3
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from faults.disk import PAGE
from faults.processes import remove
from faults.rig import Bench, Tried
from trainer.io.recording.recording import Recording, RecordingError

ENOUGH: Final = 60  # [s] of the processor for any command; a whole recording takes less than one
ROOM: Final = 1_500_000_000  # [bytes] of memory; a whole recording takes a fifth
SECONDS: Final = 40.0  # of exercise time
FLOWN: Final = ("depth-changes", "--speed", "100", "--duration", f"{SECONDS:g}")
COMMANDS: Final = (
    ("replay",),
    ("debrief", "--html", "{folder}/page.html"),
    ("recordings",),
    ("export", "--csv", "{folder}/out.csv"),
    ("resume", "--headless", "--speed", "max", "--duration", f"{SECONDS + 5:g}"),
)
TABLES: Final = {
    "header": ("value",),
    "branches": ("id", "parent", "tick", "after", "place", "why", "state"),
    "orders": ("id", "branch", "tick", "who", "text", "place", "accepted", "answer"),
    "states": ("branch", "tick", "state"),
    "ledger": ("lateness_ns", "work_ns"),
    "events": ("id", "branch", "tick", "kind", "text"),
    "snapshots": ("name", "branch", "tick", "state", "after", "place"),
}
VALUES: Final = (
    *("NULL", "-1", "0", "1", "7", "1000000", "1125899906842624", "9223372036854775807"),
    *("-9223372036854775808", "1e308", "''", "x''", "'quit'", "'time max'", "'depth 80'"),
    *("zeroblob(1984)", "randomblob(1984)", "zeroblob(9)", "x'ff00'", "cast(x'fffe' AS TEXT)"),
    *("printf('%.*c', 5000, 'x')", "printf('%.*c', 1000000, '[')", "char(27) || '[2J'"),
)
MANY: Final = "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT i, i FROM n"
SCHEMAS: Final = (
    "CREATE TRIGGER t AFTER INSERT ON orders BEGIN DELETE FROM orders; END",
    "CREATE TRIGGER t AFTER INSERT ON events BEGIN UPDATE states SET state = x''; END",
    f"CREATE VIEW more AS {MANY}",
    "UPDATE sqlite_schema SET type = 'view', rootpage = 0, sql = replace(sql, 'TABLE', 'VIEW')",
    "UPDATE sqlite_schema SET rootpage = 2 WHERE name = 'states'",
    "UPDATE sqlite_schema SET rootpage = 99999",
    "UPDATE sqlite_schema SET sql = 'CREATE TABLE ' || name || ' (a)'",
    "UPDATE sqlite_schema SET sql = NULL",
    "ALTER TABLE orders RENAME TO other",
    "ALTER TABLE states ADD COLUMN more",
    "DROP TABLE snapshots",
    "DROP INDEX orders_by_tick",
    "CREATE INDEX more ON states (abs(tick))",
    "DELETE FROM sqlite_schema",
)
SCHEMA: Final = 200  # of 256, from which on a change is one of these
TEXTS: Final = ("nan", "1e999", "[", '"', "\x1b[31m", "0", "-1", "x" * 200, "\n[boat]\n")

Damage = Callable[[Path, random.Random], None]


def bytes_changed(path: Path, dice: random.Random) -> None:
    """Overwrite some bytes, anywhere or in one page."""
    data = bytearray(path.read_bytes())
    first = dice.choice((0, PAGE * dice.randrange(len(data) // PAGE)))
    last = min(first + PAGE, len(data)) if dice.random() < 0.5 else len(data)
    for _ in range(dice.randrange(1, 40)):
        data[dice.randrange(first, last)] = dice.randrange(256)
    path.write_bytes(data)


def pages_changed(path: Path, dice: random.Random) -> None:
    """Exchange two pages, clear one, or cut the file."""
    data = path.read_bytes()
    pages = [data[i : i + PAGE] for i in range(0, len(data), PAGE)]
    one, other = dice.randrange(len(pages)), dice.randrange(len(pages))
    way = dice.randrange(3)
    if way == 0:
        pages[one], pages[other] = pages[other], pages[one]
    elif way == 1:
        pages[one] = bytes(PAGE)
    path.write_bytes(b"".join(pages[:one] if way == 2 else pages))


def values_changed(path: Path, dice: random.Random) -> None:
    """Give rows values that nobody wrote."""
    alter(path, dice.randrange(SCHEMA), dice.randrange(256), dice.randrange(256))


def schema_changed(path: Path, dice: random.Random) -> None:
    """Fill the file with other things than a recording's tables."""
    alter(path, SCHEMA, 0, dice.randrange(256))


def alter(path: Path, table: int, column: int, value: int) -> None:
    """Change the rows of a recording or, from SCHEMA on, its tables. Any numbers will do."""
    if table >= SCHEMA:
        _by_sql(path, SCHEMAS[value % len(SCHEMAS)])
        return
    name = list(TABLES)[table % len(TABLES)]
    place, some = column % len(TABLES[name]), column // len(TABLES[name]) % 9
    where = f" WHERE rowid % {some} = 0" if some and name not in ("header", "ledger") else ""
    change = f"{TABLES[name][place]} = {VALUES[value % len(VALUES)]}"
    _by_sql(path, f"UPDATE OR REPLACE {name} SET {change}{where}")


def texts_changed(path: Path, dice: random.Random) -> None:
    """Change a line of the files that the header holds, or the header's own words."""
    with contextlib.closing(sqlite3.connect(path)) as connection, connection:
        header = dict(connection.execute("SELECT key, value FROM header"))
        texts = json.loads(header["texts"])
        key = dice.choice(list(texts))
        lines = texts[key].split("\n")
        place = dice.randrange(len(lines))
        name, equals, value = lines[place].partition("=")
        changed = (f"{name}{equals} {dice.choice(TEXTS)}", value, "", f"{name} x = {value}")
        lines[place] = dice.choice(changed)
        texts[key] = "\n".join(lines)
        part = dice.choice(("texts", "texts", "options", "method", "layout"))
        text = json.dumps(texts) if part == "texts" else _spoil(header[part], dice)
        connection.execute("UPDATE header SET value = ? WHERE key = ?", (text, part))


def _spoil(text: str, dice: random.Random) -> str:
    """Return a text with a few characters replaced."""
    place = dice.randrange(len(text))
    return text[:place] + dice.choice(TEXTS) + text[place + dice.randrange(20) :]


def _by_sql(path: Path, statement: str) -> None:
    """Carry out a statement on a file, as far as it can be."""
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as connection:
        connection.execute("PRAGMA writable_schema = ON")
        with contextlib.suppress(sqlite3.Error):
            connection.execute(statement)


DAMAGES: Final[tuple[Damage, ...]] = (
    bytes_changed,
    pages_changed,
    values_changed,
    schema_changed,
    texts_changed,
)


def try_damage(times: int, seed: int) -> Iterator[Tried]:
    """Yield what came of ``times`` damaged recordings, a row for each way of damaging."""
    with tempfile.TemporaryDirectory(prefix="trainer-d-") as folder:
        bench = Bench(Path(folder), random.Random(seed))  # noqa: S311  no secrets
        good = make_recording(bench)
        for number, damage in enumerate(DAMAGES):
            yield open_damaged(bench, good, damage, len(range(number, times, len(DAMAGES))))


def make_recording(bench: Bench) -> bytes:
    """Return a recording with orders, marks, a snapshot and two branches."""
    session = bench.serve(bench.folder / "good.trainer", *FLOWN)
    with session.instructed() as by:
        for words in ("freeze", "rudder left 5", "snapshot here", "step 10", "mark turned"):
            by.ask(words)
        for words in ("backtrack 2", "depth 70", "step 4", "casualty stern-jam", "step 20"):
            by.ask(words)
        by.ask("quit")
    session.process.wait()
    bench.told()
    return session.path.read_bytes()


def open_damaged(bench: Bench, good: bytes, damage: Damage, times: int) -> Tried:
    """Open recordings that are damaged in one way by every command."""
    name = damage.__name__.replace("_", " ")
    tried = Tried(f"recording: {name}", "told in a line, or read as it is")
    path = bench.folder / "damaged.trainer"
    for _ in range(times):
        tried.times += 1
        path.write_bytes(good)
        damage(path, bench.dice)
        before = orders_of(path)
        for command in COMMANDS:
            words = [word.format(folder=bench.folder) for word in command]
            judge(bench, tried, (words[0], str(path), *words[1:]))
        after = orders_of(path)
        tried.must(before <= after, f"orders are lost: {sorted(before - after)[:3]}")
        tried.orders += len(before)
        remove(path)
    return tried


def judge(bench: Bench, tried: Tried, words: tuple[str, ...], seconds: int = ENOUGH) -> None:
    """Open a recording by a command, in so many seconds. Note how it ended."""
    code = bench.run(*words, RLIMIT_CPU=seconds, RLIMIT_DATA=ROOM)
    told = bench.told()
    tried.must(code in (0, 1, 2), f"{words[0]} ended with {code}: {told[-300:]}")
    tried.must("Traceback" not in told, f"{words[0]}: {told[-600:]}")
    tried.must(code != 2 or told.startswith(("trainer: ", "note: ")), f"{words[0]}: {told[:200]}")
    tried.must("\x1b" not in told, f"{words[0]} sends control characters")
    tried.note("told as damaged" if code == 2 else "read, with differences" if code else "read")


def orders_of(path: Path) -> frozenset[str]:
    """Return the orders of a recording, none if it cannot be read."""
    try:
        with contextlib.closing(Recording.look(path)) as recording:
            every = [recording.orders(branch.id) for branch in recording.branches()]
            return frozenset(f"{each.id} {each.text}" for orders in every for each in orders)
    except RecordingError:
        return frozenset()

"""Recordings of format 1, which tell givers, causes and repeats in English words alone.

``file`` and ``queries`` ask it of an older file. Only this module reads those words. To go on with
such a recording its file is changed to today's format; to read one, its file stays as it is.
"""

import itertools
import re
import sqlite3
from collections.abc import Callable
from typing import Any, Final

from trainer.io.recording.facts import (
    GUARD_GIVER,
    NO_CREW_FACT,
    REFERENCE_GIVER,
    SCHEDULE_GIVER,
    BranchCause,
    CrewFact,
    CrewNews,
    Giver,
    GiverKind,
    meeting,
    plan_of,
)

TABLES_1: Final = """CREATE TABLE branches (
    id INTEGER PRIMARY KEY, parent INTEGER REFERENCES branches, tick INTEGER NOT NULL,
    after INTEGER NOT NULL, place INTEGER NOT NULL, why TEXT NOT NULL, state BLOB NOT NULL,
    wall TEXT NOT NULL
);
CREATE TABLE orders (
    id INTEGER PRIMARY KEY, branch INTEGER NOT NULL, tick INTEGER NOT NULL, who TEXT NOT NULL,
    text TEXT NOT NULL, place INTEGER, accepted INTEGER, answer TEXT NOT NULL DEFAULT '',
    wall TEXT NOT NULL
);
CREATE INDEX orders_by_tick ON orders (branch, tick, place);
CREATE TABLE events (
    id INTEGER PRIMARY KEY, branch INTEGER NOT NULL, tick INTEGER NOT NULL, kind TEXT NOT NULL,
    who TEXT NOT NULL, text TEXT NOT NULL, wall TEXT NOT NULL
);
"""
PLANNED_PATTERN: Final = re.compile(r"(instructor) at plan (\d{1,9})")
MEETING_PATTERN: Final = re.compile(r"(\w+) meeting her")
LOST_PREFIX: Final = "not recorded"  # begins why a branch was begun after a gap
ORDERED_PREFIX: Final = "ordered: "
WRONG_REPEAT: Final = re.compile("WRONG REPEAT: .*?; ordered is (.*)", re.DOTALL)
REPEATED_SUFFIX: Final = " aye"
TELL_PREFIX: Final = "tell "
NAMED_GIVERS: Final = {
    str(giver): giver for giver in (SCHEDULE_GIVER, GUARD_GIVER, REFERENCE_GIVER)
}


Row = tuple[Any, ...]


def giver_of(who: str) -> Giver:
    """Return the giver of an order, from the name in the journal."""
    if who in NAMED_GIVERS:
        return NAMED_GIVERS[who]
    if planned := PLANNED_PATTERN.fullmatch(who):
        return plan_of(planned[1], int(planned[2]))
    if met := MEETING_PATTERN.fullmatch(who):
        return meeting(met[1])
    return Giver(GiverKind.STATION, who.partition(" at ")[0], who)


def crew_fact_of(text: str, answer: str, *, accepted: bool | None) -> CrewFact:
    """Return the crew fact of an order, from its words and its answer."""
    name = text.partition(" ")[0]
    if accepted is False:
        return NO_CREW_FACT
    if name == "tell":
        return CrewFact(CrewNews.ORDERED, text.removeprefix(TELL_PREFIX))
    if name == "order":
        ordered = answer.startswith(ORDERED_PREFIX)
        return (
            CrewFact(CrewNews.ORDERED, answer.removeprefix(ORDERED_PREFIX))
            if ordered
            else NO_CREW_FACT
        )
    if text != "aye" and not text.endswith(REPEATED_SUFFIX):
        return NO_CREW_FACT
    if wrong := WRONG_REPEAT.fullmatch(answer):
        return CrewFact(CrewNews.WRONG_REPEAT, wrong[1].removeprefix(TELL_PREFIX))
    return CrewFact(
        CrewNews.REPEATED, answer.removesuffix(REPEATED_SUFFIX).removeprefix(TELL_PREFIX)
    )


def cause_of(parent: int | None, why: str) -> BranchCause:
    """Return the cause of a branch, from the words that say why it was begun."""
    if parent is None:
        return BranchCause.START
    return BranchCause.GAP if why.startswith(LOST_PREFIX) else BranchCause.JUMP


def upgrade(connection: sqlite3.Connection, schema: str) -> None:
    """Bring a file to the format of today, whose tables ``schema`` makes, all or nothing.

    It makes the tables anew, because an added column would stand last, not where new files have it.
    """
    script = f"""
    BEGIN IMMEDIATE;
    ALTER TABLE orders RENAME TO orders_1;
    ALTER TABLE branches RENAME TO branches_1;
    ALTER TABLE events RENAME TO events_1;
    DROP INDEX orders_by_tick;
    {schema}
    """
    try:
        connection.executescript(script)
        _copy(connection, "branches", _branch_added)
        _copy(connection, "orders", _order_added)
        _copy(connection, "events", _event_added)
        for table in ("branches", "orders", "events"):
            connection.execute(f"DROP TABLE {table}_1")
        connection.execute("PRAGMA user_version = 2")
        connection.execute("COMMIT")
    except BaseException:
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        raise


def _copy(connection: sqlite3.Connection, table: str, added: Callable[[Row], Row]) -> None:
    """Copy a table, and add the columns that its words tell."""
    whole = (row + added(row) for row in connection.execute(f"SELECT * FROM {table}_1 ORDER BY id"))  # noqa: S608 our own
    first = next(whole, None)
    if first is None:
        return
    blanks = ", ".join("?" * len(first))
    insert = f"INSERT INTO {table} VALUES ({blanks})"  # noqa: S608 our own
    connection.executemany(insert, itertools.chain([first], whole))


def check_texts(*values: object) -> None:
    """Raise sqlite3.DataError unless all values are texts: SQLite itself takes anything."""
    if not all(isinstance(value, str) for value in values):
        raise sqlite3.DataError("a text is none")  # as ``understanding`` tells it


def _branch_added(row: Row) -> Row:
    parent, why = row[1], row[5]
    check_texts(why)
    return (cause_of(parent, why).value,)


def _order_added(row: Row) -> Row:
    who, text, accepted, answer = row[3], row[4], row[6], row[7]
    check_texts(who, text, answer)
    giver = giver_of(who)
    fact = crew_fact_of(text, answer, accepted=accepted is None or bool(accepted))
    return giver.kind.value, giver.role, giver.plan, fact.news.value, fact.order


def _event_added(row: Row) -> Row:
    check_texts(row[4])
    return (giver_of(row[4]).role,)

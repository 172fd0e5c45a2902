"""A recording answers questions of the past, through the branches that led to a moment.

``Recording`` answers by it, and debriefs and resumed runs ask. When a run is wound back its tick
number goes back too. From there a new branch is flown; its past is that of its parent up to the
moment where it began. State k of a branch stands at the end of tick k, before the orders given at
tick k. Only the first state of a branch may include orders of its own tick, because a run may go
back to a moment after them.
"""

import sqlite3
from collections import deque
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from enum import Enum
from functools import lru_cache
from itertools import chain, islice
from typing import Any, Final, NamedTuple, TypeVar

from trainer.io.orders.grammar import KEPT_ORDERS, name_of
from trainer.io.recording import format_1
from trainer.io.recording.facts import (
    NO_CREW_FACT,
    NOTE_KIND,
    BranchCause,
    CrewFact,
    CrewNews,
    Giver,
    GiverKind,
)
from trainer.io.recording.file import FILE_FORMAT, RecordingError, understanding

NO_END: Final = 2**62  # beyond any tick or order
# [ticks] that an order may lie beyond the last state of its branch: orders are kept at once, states
# within some seconds, and not while a disk is full; none is written beyond this, so it is damage
ORDER_LEEWAY_TICKS: Final = 100_000
MAX_ANSWER_BYTES: Final = 100_000_000  # [bytes] of an answer that is held as a whole
ROW_BYTES: Final = 300  # [bytes] of a row beside its texts
MAX_BRANCHES_READ: Final = 5_000  # of a file: four days of one after the other make 1,100
MAX_EVENTS_READ: Final = 50_000  # of a file that somebody debriefs or exports
MAX_ROWS_COUNTED: Final = 2_000_000  # more left-out rows than this are reported as this many
DAMAGED_TEXT: Final = "a value is of another kind than is written there"
Row = tuple[Any, ...]
E = TypeVar("E", bound=Enum)
BRANCH_COLUMNS: Final = "id, parent, tick, after, place, why, state"
ORDER_COLUMNS: Final = "id, branch, tick, who, text, place AS scheduled, accepted, answer"
LAST_ORDER: Final = (
    "SELECT coalesce(max(number), 0) AS last FROM (SELECT max(id) AS number FROM orders "
    "UNION ALL SELECT max(after) FROM branches UNION ALL SELECT max(after) FROM snapshots)"
)
CREW_COLUMNS: Final = ", giver, role, plan, crew_news, crew_order"
EVENT_COLUMNS: Final = "branch, tick, kind, who, text, wall"


class ColumnKind(NamedTuple):
    """The type of a column in an answer: a number within limits, text or bytes."""

    kind: type
    least: int
    most: int
    perhaps: bool = False  # it may be missing

    def holds(self, value: object) -> bool:
        """Return whether a value is of this type."""
        if value is None:
            return self.perhaps
        if not isinstance(value, self.kind):
            return False
        size = value if isinstance(value, int) else len(value)  # type: ignore[arg-type]
        return self.least <= size <= self.most


# What the columns of an answer hold. SQLite itself takes anything, and a damaged page may be that.
COUNT_KIND: Final = ColumnKind(int, 0, 2**53)
ENTRY_KIND: Final = ColumnKind(int, 0, 2**31)
TIME_KIND: Final = ColumnKind(int, -(2**62), 2**62, perhaps=True)  # [ns]
TEXT_KIND: Final = ColumnKind(str, 0, 10_000)
COLUMN_KINDS: Final[Mapping[str, ColumnKind]] = {
    **dict.fromkeys(("id", "branch", "tick", "after", "last"), COUNT_KIND),
    **dict.fromkeys(("parent", "latest"), COUNT_KIND._replace(perhaps=True)),
    **dict.fromkeys(("key", "name", "who", "text", "answer", "kind", "why", "wall"), TEXT_KIND),
    "quick_check": TEXT_KIND,
    **dict.fromkeys(("cause", "giver", "role", "crew_news", "crew_order"), TEXT_KIND),
    **dict.fromkeys(("scheduled", "done"), ENTRY_KIND._replace(perhaps=True)),
    **dict.fromkeys(("lateness_ns", "work_ns"), TIME_KIND),
    **dict.fromkeys(("place", "plan", "user_version"), ENTRY_KIND),
    "accepted": ColumnKind(int, 0, 1, perhaps=True),
    "value": ColumnKind(str, 0, MAX_ANSWER_BYTES),
    "state": ColumnKind(bytes, 0, 65_536),
}


@dataclass(frozen=True, slots=True)
class Moment:
    """A moment of a run, with all that is needed to go back to it."""

    branch: int
    tick: int
    state: bytes
    after: int  # the last order that the state includes, 0 for none
    entry: int  # the next one of the schedule


@dataclass(frozen=True, slots=True)
class RecordedOrder:
    """An order as it was recorded; it acted after `tick` ticks."""

    id: int
    branch: int
    tick: int
    giver: Giver
    text: str
    entry: int | None  # in the schedule; None when somebody gave it
    accepted: bool | None  # None when the program ended before it was answered
    answer: str
    crew: CrewFact = NO_CREW_FACT

    @property
    def who(self) -> str:
        """Return the name of the giver, as people read it."""
        return self.giver.words

    @property
    def name(self) -> str:
        """Return the name of the order, "" for words that are none of this version."""
        return recorded_name(self.text)


@lru_cache(maxsize=KEPT_ORDERS)
def recorded_name(text: str) -> str:
    """Return the name of an order as it was recorded, without any token.

    A debrief asks for it ten thousand times, of the same few texts.
    """
    return name_of(text)


@dataclass(frozen=True)
class Branch:
    """A stretch flown in one go, from a moment of its parent on."""

    id: int
    parent: int | None
    tick: int
    after: int
    entry: int
    why: str
    state: bytes
    cause: BranchCause = BranchCause.JUMP


@dataclass(frozen=True)
class RecordedEvent:
    """An event of a run, beside orders and states."""

    branch: int
    tick: int
    kind: str
    who: str
    text: str
    wall: str  # time of day, UTC
    role: str = ""  # of the speaker


@dataclass(frozen=True)
class ExcessRows:
    """A kind of rows of which there are too many. Only the first of them are read."""

    what: str
    of: int  # rows in the file; the count stops at MAX_ROWS_COUNTED
    first: int  # those that are read

    def __str__(self) -> str:
        of = f"{self.of} or more" if self.of == MAX_ROWS_COUNTED else f"{self.of}"
        return f"of {of} {self.what} the first {self.first} are read"


@dataclass(frozen=True, slots=True)
class RecordedTick:
    """One tick of a branch; its times [ns] are None where nobody measured them."""

    branch: int
    tick: int
    state: bytes
    lateness: int | None
    work: int | None


class Past:
    """Questions to a recording; RecordingError if it is damaged."""

    def __init__(self, connection: sqlite3.Connection, name: str) -> None:
        self._connection = connection
        self._name = name
        (version,) = connection.execute("PRAGMA user_version").fetchone()
        # An older file lacks these columns; ``format_1`` tells the facts from its words.
        now = int(version) == FILE_FORMAT
        self._branch_columns = BRANCH_COLUMNS + (", cause" if now else "")
        self._order_columns = ORDER_COLUMNS + (CREW_COLUMNS if now else "")
        self._event_columns = EVENT_COLUMNS + (", role" if now else "")

    def header(self) -> dict[str, str]:
        """Return the header, which was written when the recording was made."""
        return dict(self._all("SELECT key, value FROM header"))

    def branches(self) -> list[Branch]:
        """Return all branches, oldest first."""
        query = f"SELECT {self._branch_columns} FROM branches ORDER BY id"  # noqa: S608 our own
        branches = [self._begun(row) for row in self._all(query)]
        if not branches:
            raise self._damaged("it has no branch")
        return branches

    def last_branch(self) -> int:
        """Return the number of the latest branch."""
        return int(self._row("SELECT coalesce(max(id), 0) AS last FROM branches")[0])

    def last_order(self) -> int:
        """Return the number of the latest order that was given, 0 for none.

        It may be lost: a branch after a gap begins after orders that are not there.
        """
        return int(self._row(LAST_ORDER)[0])

    def last_tick(self, branch: int) -> int:
        """Return the tick of the last state of a branch, its start at least."""
        query = "SELECT max(tick) AS latest FROM states WHERE branch = ?"
        (tick,) = self._row(query, branch)
        return max(self._branch(branch).tick, -1 if tick is None else int(tick))

    def owner(self, branch: int, tick: int, after: int) -> int:
        """Return the branch that recorded a moment: the given one or an ancestor."""
        here = self._branch(branch)
        while here.parent is not None and (tick, after) < (here.tick, here.after):
            here = self._branch(here.parent)
        return here.id

    def moment(self, branch: int, tick: int) -> Moment | None:
        """Return the end of a tick in a branch or its ancestry. None if it is not recorded."""
        here = self._find(branch)
        while here and here.parent is not None and tick < here.tick:
            here = self._find(here.parent)
        if here is None:  # the branch could not be written while the file was out of reach
            return None
        if tick == here.tick:
            return Moment(here.id, tick, here.state, here.after, here.entry)
        state = self._row("SELECT state FROM states WHERE branch = ? AND tick = ?", here.id, tick)
        if not state:
            return None
        query = (
            "SELECT max(id) AS latest, max(place) AS done FROM orders WHERE branch = ? AND tick < ?"
        )
        after, done = self._row(query, here.id, tick)
        return Moment(
            here.id,
            tick,
            state[0],
            after=here.after if after is None else after,
            entry=here.entry if done is None else done + 1,
        )

    def orders(self, branch: int, after: int = 0) -> list[RecordedOrder]:
        """Return the orders after number `after` that a branch includes, in order."""
        query = (
            f"SELECT {self._order_columns} FROM orders "  # noqa: S608 our own
            "WHERE branch = ? AND id > ? AND id <= ? ORDER BY id"
        )
        stretches: list[list[RecordedOrder]] = []
        here, last = self._branch(branch), self.last_order()
        while True:
            rows = self._all(query, here.id, after, last)
            stretches.append(self._journalled(here, rows))
            if here.parent is None or here.after <= after:
                break
            here, last = self._branch(here.parent), min(last, here.after)
        return [order for stretch in reversed(stretches) for order in stretch]

    def snapshots_seen_from(self, branch: int) -> list[tuple[str, Moment]]:
        """Return the named moments, the latest of each name.

        Where both the branch's own past and another branch have a name, the past wins.
        """
        query = "SELECT name, branch, tick, state, after, place FROM snapshots ORDER BY id"
        snapshots = [(str(name), Moment(*fields)) for name, *fields in self._all(query)]
        begun = dict(self._ancestry(branch))
        past: dict[str, Moment] = {}
        elsewhere: dict[str, Moment] = {}
        for name, moment in snapshots:
            end = begun.get(moment.branch)
            is_past = end is not None and (moment.tick, moment.after) <= end
            (past if is_past else elsewhere)[name] = moment
        return list((elsewhere | past).items())

    def flown(self, branch: int) -> Iterator[RecordedTick]:
        """Yield every tick from the first of all to the last of a branch."""
        self._branch(branch)  # there is such a one
        ancestry = list(self._ancestry(branch))
        for number, (end, _) in reversed(ancestry):
            begun = self._branch(number)
            if begun.tick < end:
                yield RecordedTick(number, begun.tick, begun.state, None, None)
            query = (
                "SELECT branch, tick, state, lateness_ns, work_ns "
                "FROM states LEFT JOIN ledger USING (branch, tick) "
                "WHERE branch = ? AND tick > ? AND tick < ? ORDER BY tick"
            )
            for tick, row in enumerate(self._rows(query, number, begun.tick, end), begun.tick + 1):
                yield RecordedTick(*self._next(row, number, tick, row[1]))

    def states(self, branch: int) -> Iterator[tuple[int, bytes]]:
        """Yield tick and state of what a branch itself recorded, its start first."""
        begun = self._branch(branch)
        yield begun.tick, begun.state
        query = "SELECT tick, state FROM states WHERE branch = ? AND tick > ? ORDER BY tick"
        for tick, row in enumerate(self._rows(query, branch, begun.tick), begun.tick + 1):
            yield self._next(row, branch, tick, row[0])

    def events(self) -> Iterator[RecordedEvent]:
        """Yield the events in order, without notes that are for programs alone."""
        return self._events("!=")

    def notes(self) -> Iterator[RecordedEvent]:
        """Yield the notes in order: what became of each alert, for programs."""
        return self._events("=")

    def _events(self, are: str) -> Iterator[RecordedEvent]:
        """Yield the events that are notes, or those that are none."""
        query = (
            f"SELECT {self._event_columns} FROM events "  # noqa: S608 our own
            f"WHERE kind {are} '{NOTE_KIND}' ORDER BY id"
        )
        for row in self._rows(query):
            branch, tick, kind, who, text, wall, *roles = row
            role = roles[0] if roles else format_1.giver_of(who).role
            yield RecordedEvent(branch, tick, kind, who, text, wall, role)

    def first_events(self) -> Iterator[RecordedEvent]:
        """Yield the events in order, as many as are read of one file."""
        return islice(self.events(), MAX_EVENTS_READ)

    def excess(self) -> tuple[ExcessRows, ...]:
        """Return the kinds of rows that have more than are read of one file."""
        limits = {"branches": MAX_BRANCHES_READ, "events": MAX_EVENTS_READ}
        return tuple(
            ExcessRows(table, count, most)
            for table, most in limits.items()
            if (count := self._count(table)) > most
        )

    def checked_states(self) -> Iterator[bytes]:
        """Yield every state, also of snapshots; RecordingError where anything is damaged."""
        orders = f"SELECT {self._order_columns} FROM orders WHERE branch = ? ORDER BY id"  # noqa: S608 our own
        for branch in self.branches():
            self._journalled(branch, self._all(orders, branch.id))
            yield from (state for _, state in self.states(branch.id))
        yield from (state for (state,) in self._rows("SELECT state FROM snapshots"))
        deque(chain(self.events(), self.notes()), 0)
        for (found,) in self._rows("PRAGMA quick_check(1)"):
            if found != "ok":
                raise self._damaged(found.splitlines()[-1])

    def refuse_branches(self) -> None:
        """Raise RecordingError if there are more branches than are read of a file.

        They cannot be cut as events can, because the last branch needs all its ancestors.
        """
        for excess in self.excess():
            if excess.what == "branches":
                raise RecordingError(
                    f"{self._name} is too long to be read: {excess.of} branches, and "
                    f"{excess.first} is the most"
                )

    def _count(self, table: str) -> int:
        """Return how many rows a table has, or MAX_ROWS_COUNTED."""
        rows = f"SELECT count(*) AS last FROM (SELECT 1 FROM {table} LIMIT ?)"  # noqa: S608 our own
        return int(self._row(rows, MAX_ROWS_COUNTED)[0])

    def ledger(self, branch: int) -> Iterator[tuple[int, int, int]]:
        """Yield tick, lateness and work [ns] of what a branch itself recorded."""
        query = "SELECT tick, lateness_ns, work_ns FROM ledger WHERE branch = ? ORDER BY tick"
        yield from self._rows(query, branch)

    def _ancestry(self, branch: int) -> Iterator[tuple[int, tuple[int, int]]]:
        """Yield a branch and its ancestors, each with the (tick, order) where the next began."""
        here, end = self._find(branch), (NO_END, NO_END)
        while here:
            yield here.id, end
            end = here.tick, here.after
            here = None if here.parent is None else self._find(here.parent)

    def _branch(self, branch: int) -> Branch:
        record = self._find(branch)
        if record is None:
            raise RecordingError(
                f"{self._name} has no branch {branch}; the latest is {self.last_branch()}"
            )
        return record

    def _find(self, branch: int) -> Branch | None:
        query = f"SELECT {self._branch_columns} FROM branches WHERE id = ?"  # noqa: S608 our own
        row = self._row(query, branch)
        return self._begun(row) if row else None

    def _begun(self, row: Row) -> Branch:
        """Return a branch; RecordingError if its parent is itself or a later branch."""
        number, parent, tick, after, entry, why, state, *causes = row
        read = (self._value_of(BranchCause, value) for value in causes)
        cause = next(read, None) or format_1.cause_of(parent, why)
        branch = Branch(number, parent, tick, after, entry, why, state, cause)
        if branch.parent is not None and branch.parent >= branch.id:
            raise self._damaged(f"branch {branch.id} begins in a later one")
        return branch

    def _row(self, question: str, *values: int) -> Row:
        """Return the first row of the answer, () if there is none."""
        return next(self._rows(question, *values), ())

    def _all(self, question: str, *values: int) -> list[Row]:
        """Return all rows of an answer; RecordingError if they take too much memory."""
        rows, held = [], 0
        for row in self._rows(question, *values):
            held += ROW_BYTES + sum(len(value) for value in row if isinstance(value, str | bytes))
            if held > MAX_ANSWER_BYTES:
                raise self._damaged(
                    f"more is to be read at once than {MAX_ANSWER_BYTES // 10**6} MB"
                )
            rows.append(row)
        return rows

    def _rows(self, question: str, *values: int) -> Iterator[Row]:
        try:
            with (
                understanding(self._name),
                closing(self._connection.execute(question, values)) as answer,
            ):
                kinds = [COLUMN_KINDS[column] for column, *_ in answer.description]
                for row in answer:
                    for value, kind in zip(row, kinds, strict=True):
                        if not kind.holds(value):
                            raise self._damaged(DAMAGED_TEXT)
                    yield row
        except sqlite3.OperationalError as error:
            raise RecordingError(f"{self._name} cannot be read: {error}") from None

    def _next(self, row: Row, branch: int, due: int, tick: int) -> Row:
        """Return the row of a tick if that is the one due: every tick of a branch is recorded."""
        if tick != due:
            raise self._damaged(f"tick {due} of branch {branch} is missing before tick {tick}")
        return row

    def _journalled(self, branch: Branch, rows: list[Row]) -> list[RecordedOrder]:
        """Return orders of a branch; RecordingError for one where nothing was flown."""
        last = self.last_tick(branch.id) + ORDER_LEEWAY_TICKS
        orders = [self._as_journalled(row) for row in rows]
        for order in orders:
            if not branch.tick <= order.tick <= last:
                raise self._damaged(f"order {order.id} was given at tick {order.tick}")
        return orders

    def _damaged(self, why: str) -> RecordingError:
        return RecordingError(f"{self._name} is damaged: {why}")

    def _as_journalled(self, row: Row) -> RecordedOrder:
        """Return an order; RecordingError if its giver is of no known kind."""
        number, branch, tick, who, text, entry, accepted, answer, *facts = row
        known = None if accepted is None else bool(accepted)
        if facts:
            kind, role, plan, news, order = facts
            giver = Giver(self._value_of(GiverKind, kind), role, who, plan)
            crew = CrewFact(self._value_of(CrewNews, news), order)
        else:
            giver = format_1.giver_of(who)
            crew = format_1.crew_fact_of(text, answer, accepted=known)
        return RecordedOrder(number, branch, tick, giver, text, entry, known, answer, crew)

    def _value_of(self, kind: type[E], value: str) -> E:
        """Return the fact of a stored value; RecordingError if there is none."""
        try:
            return kind(value)
        except ValueError:
            raise self._damaged(DAMAGED_TEXT) from None

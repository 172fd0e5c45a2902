"""Recordings over which the machine plays: released ones, of today, of other states, cut short."""

import contextlib
import json
import lzma
import random
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from helpers.places import TESTS

from trainer.debrief.passage.trajectory import NEEDED_COLUMNS
from trainer.io.recording.recording import Recording
from trainer.session.past.layout import LAYOUT

RELEASED: Final = {
    path.name.removesuffix(".trainer.xz"): path
    for path in sorted((TESTS / "data" / "recordings").glob("*.trainer.xz"))
}
TRAINEE: Final = "A. Jones"
STATE_TABLES: Final = ("branches", "states", "snapshots")
PAGE_BYTES: Final = 8192
LEFT_TICKS: Final = 12  # of each branch that a killed session has in its log alone

Numbers = dict[str, float]


class Kind(NamedTuple):
    """What is done to a recording before it is played over."""

    change: Callable[[Path, random.Random], None]
    whole: bool  # all that was in it is still in it


class Told(NamedTuple):
    """What a recording tells: its layout, its branches, and the states and orders of each."""

    layout: tuple[str, ...]
    branches: tuple[tuple[object, ...], ...]
    states: tuple[tuple[bytes, ...], ...]
    orders: tuple[tuple[tuple[int, str], ...], ...]
    snapshots: tuple[bytes, ...]


@contextlib.contextmanager
def opened(path: Path) -> Iterator[sqlite3.Connection]:
    """Yield a recording to be changed by hand."""
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as connection:
        yield connection


def put_released(name: str, path: Path) -> None:
    """Put a released recording there, as one of a trainee."""
    path.write_bytes(lzma.decompress(RELEASED[name].read_bytes()))
    with opened(path) as connection:
        trainees = ("trainees", json.dumps([TRAINEE]))
        connection.execute("INSERT OR REPLACE INTO header VALUES (?, ?)", trainees)


def put_other_state(path: Path, layout: Sequence[str]) -> None:
    """Make it one of a version with these numbers in its state, new ones 7."""
    was = told(path).layout
    with opened(path) as connection:
        connection.execute("UPDATE header SET value = ? WHERE key = 'layout'", [json.dumps(layout)])
        for table in STATE_TABLES:
            for row, state in connection.execute(f"SELECT rowid, state FROM {table}").fetchall():
                numbers = dict(zip(was, np.frombuffer(state), strict=True))
                new = np.array([numbers.get(name, 7.0) for name in layout]).tobytes()
                connection.execute(f"UPDATE {table} SET state = ? WHERE rowid = ?", (new, row))


def as_it_is(path: Path, dice: random.Random) -> None:
    """Change nothing."""


def number_more(path: Path, dice: random.Random) -> None:
    """Give its state a number that this version does not know."""
    layout = [*told(path).layout]
    layout.insert(dice.randrange(len(layout) + 1), "number_to_come")
    put_other_state(path, layout)


def number_less(path: Path, dice: random.Random) -> None:
    """Take a number from its state that no debrief needs."""
    layout = [*told(path).layout]
    spared = {*NEEDED_COLUMNS, "tick"}
    layout.remove(dice.choice([name for name in layout if name not in spared]))
    put_other_state(path, layout)


def other_order(path: Path, dice: random.Random) -> None:
    """Have the same numbers stand in another order, in as many bytes."""
    layout = [*told(path).layout]
    dice.shuffle(layout)
    put_other_state(path, layout)


def killed(path: Path, _dice: random.Random) -> None:
    """Leave the last states in a log beside it, as a killed session does."""
    with opened(path) as connection:
        connection.execute("PRAGMA journal_mode = WAL")
        last = (
            "FROM states WHERE tick > (SELECT max(tick) - ? FROM states AS s "
            "WHERE s.branch = states.branch)"
        )
        rows = connection.execute(f"SELECT * {last}", [LEFT_TICKS]).fetchall()
        connection.execute(f"DELETE {last}", [LEFT_TICKS])
        connection.execute("VACUUM")
        connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        connection.executemany("INSERT INTO states VALUES (?, ?, ?)", rows)
        kept = {end: Path(f"{path}{end}").read_bytes() for end in ("", "-wal", "-shm")}
    for end, data in kept.items():
        Path(f"{path}{end}").write_bytes(data)


def rebooted(path: Path, dice: random.Random) -> None:
    """Leave a log, without the file that a system's memory shares."""
    killed(path, dice)
    Path(f"{path}-shm").unlink()


def cut_short(path: Path, dice: random.Random) -> None:
    """Lose the last pages of the file, while the log beside it stays."""
    killed(path, dice)
    pages = path.stat().st_size // PAGE_BYTES
    with path.open("r+b") as file:
        file.truncate(PAGE_BYTES * dice.randrange(pages // 4, pages))
    if dice.random() < 0.5:
        Path(f"{path}-shm").unlink()


KINDS: Final = {
    "as it is": Kind(as_it_is, whole=True),
    "number more": Kind(number_more, whole=True),
    "number less": Kind(number_less, whole=True),
    "other order": Kind(other_order, whole=True),
    "killed": Kind(killed, whole=True),
    "rebooted": Kind(rebooted, whole=True),
    "cut short": Kind(cut_short, whole=False),
}


def told(path: Path) -> Told:
    """Return what a recording tells; RecordingError if it is damaged."""
    with contextlib.closing(Recording.look(path)) as recording:
        branches = recording.branches()
        return Told(
            tuple(json.loads(recording.header()["layout"])),
            tuple((each.parent, each.tick, each.after, each.cause) for each in branches),
            tuple(tuple(state for _, state in recording.states(each.id)) for each in branches),
            tuple(
                tuple((order.tick, order.text) for order in recording.orders(each.id))
                for each in branches
            ),
            tuple(moment.state for _, moment in recording.snapshots()),
        )


def by_name(layout: Sequence[str], states: Sequence[bytes], names: Sequence[str]) -> list[bytes]:
    """Return the numbers of those names in states of a layout."""
    places = [layout.index(name) for name in names]
    return [np.frombuffer(state)[places].tobytes() for state in states]


def known(layout: Sequence[str]) -> list[str]:
    """Return the names of a layout that this version knows."""
    return [name for name in LAYOUT if name in {*layout}]

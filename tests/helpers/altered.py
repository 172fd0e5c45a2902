"""Recordings altered by another program, or held by one."""

import contextlib
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from trainer.boat.boat import STATE_OFFSETS


def alter(path: Path, statement: str, *values: Any) -> int:
    """Change a recording by SQL; return how many rows that changed."""
    with contextlib.closing(sqlite3.connect(path)) as file, file:
        return file.execute(statement, values).rowcount


def alter_number(path: Path, field: str, change: float, tick: int = 0) -> None:
    """Add to one number of the recorded state of a tick; of the start for tick 0."""
    table, where = ("states", f"WHERE tick = {tick}") if tick else ("branches", "")
    with contextlib.closing(sqlite3.connect(path)) as file:
        (state,) = file.execute(f"SELECT state FROM {table} {where}").fetchone()
    numbers = np.frombuffer(state).copy()
    numbers[STATE_OFFSETS[field]] += change
    alter(path, f"UPDATE {table} SET state = ? {where}", numbers.tobytes())


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """Lock a recording as another program may."""
    with contextlib.closing(sqlite3.connect(path, isolation_level=None)) as other:
        other.execute("BEGIN EXCLUSIVE")
        yield
        other.execute("COMMIT")


def is_whole(path: Path) -> bool:
    """Return whether SQLite finds nothing wrong with a file."""
    with contextlib.closing(sqlite3.connect(path)) as file:
        return file.execute("PRAGMA integrity_check").fetchall() == [("ok",)]

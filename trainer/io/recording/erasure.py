"""Names taken out of a recording that is closed: from its header, and from what was remarked.

Nothing that was flown changes. What is taken out is written over in the file.
"""

import contextlib
import sqlite3
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Final

from trainer.io.recording.checkpoint import BRING_HOME
from trainer.io.recording.file import RecordingError, reopen, understanding

REMARKS: Final = {  # texts that people have written, by the question that finds them
    "events": (
        "SELECT id, text FROM events WHERE kind = 'mark' OR text LIKE '%mark %' "
        "OR text LIKE '%tell %' OR text LIKE '%report%' OR text LIKE '%to the crew: %'"
    ),
    "orders": (
        "SELECT id, text FROM orders "
        "WHERE text LIKE 'mark %' OR text LIKE 'tell %' OR text LIKE 'report %'"
    ),
}
ANSWERS: Final = (
    "SELECT id, answer FROM orders "
    "WHERE text LIKE 'mark %' OR text LIKE 'tell %' OR text LIKE 'report %'"
)


def erase(path: Path, header: Mapping[str, str | None], without: Callable[[str], str]) -> int:
    """Give a recording other values in its header, None for none, and other remarks.

    Return how many remarks were changed. RecordingError if it is in use or cannot be written.
    """
    with contextlib.closing(reopen(path)) as connection, understanding(path):
        try:
            connection.execute("PRAGMA secure_delete = ON")
            connection.execute("BEGIN IMMEDIATE")
            changed = _remarks(connection, without)
            for key, value in header.items():
                connection.execute("DELETE FROM header WHERE key = ?", (key,))
                if value is not None:
                    connection.execute("INSERT INTO header VALUES (?, ?)", (key, value))
            connection.execute("COMMIT")
            connection.execute(BRING_HOME)
        except sqlite3.OperationalError as error:
            raise RecordingError(f"{path} cannot be written: {error}") from None
    return changed


def _remarks(connection: sqlite3.Connection, without: Callable[[str], str]) -> int:
    """Change the remarks, and the answers that repeat them; return how many were changed."""
    changed = 0
    for table, question in REMARKS.items():
        for number, text in connection.execute(question).fetchall():
            if (new := without(text)) != text:
                connection.execute(f"UPDATE {table} SET text = ? WHERE id = ?", (new, number))  # noqa: S608 our own names
                changed += table == "events"
    for number, text in connection.execute(ANSWERS).fetchall():
        connection.execute("UPDATE orders SET answer = ? WHERE id = ?", (without(text), number))
    return changed

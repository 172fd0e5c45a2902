"""The sound rows of an array of tables, even if other rows are wrong.

So one mistake hides no other, and a user sees all faults of the array at once.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from trainer.config.files import ConfigError, Position, collecting
from trainer.config.schema import Rows, read_record

Readers = Mapping[str, Callable[[str, Position], object]]  # of texts by key; ConfigError if wrong


def sound_rows(
    rows: Rows, given: object, position: Position, readers: Readers, problems: list[str]
) -> Iterator[tuple[int, Position, Any]]:
    """Yield number, place and record of each sound row; collect the problems of all others.

    ``position`` is that of the array. The texts of a wrong row are read as well, by ``readers``.
    """
    listed: list[Any] = []
    with collecting(problems):
        listed = rows.listed(position.table, given, Position(position.file, ""))
    for i, row in enumerate(listed):
        inside = Position(position.file, f"{position.table}[{i}]")
        try:
            record = read_record(rows.record, row, inside, rows.documentary)
        except ConfigError as wrong:
            problems.extend(wrong.problems)
            problems.extend(_wrong_texts(row, inside, readers))
        else:
            yield i, inside, record


def _wrong_texts(row: object, position: Position, readers: Readers) -> list[str]:
    """Return what is wrong with the texts of a row."""
    problems: list[str] = []
    table: Mapping[str, object] = row if isinstance(row, Mapping) else {}
    for key, read in readers.items():
        text = table.get(key)
        with collecting(problems):
            if isinstance(text, str):
                read(text, position)
    return problems

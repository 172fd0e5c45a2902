"""Rows of a flight become columns: the same numbers, and little memory for what stands still."""

import tracemalloc

import numpy as np
import pytest

from trainer.debrief.passage.trajectory import BLOCK_ROWS, FlownRows

NAMES = ("still", "moves", "begins to move", "zero of either sign")


def rows_of(count: int, begin: int = 0) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Return rows, with one number more than there are names."""
    tick = np.arange(begin, begin + count, dtype=float)
    still, late = np.full(count, 7.5), np.maximum(tick - 2.0 * BLOCK_ROWS, 0.0)
    return np.column_stack([still, tick, late, np.where(tick % 2, 0.0, -0.0), tick])


@pytest.mark.parametrize("parts", [(1,), (1, 5), (3, BLOCK_ROWS, 2, 3 * BLOCK_ROWS), (BLOCK_ROWS,)])
def test_columns_have_the_bits_of_the_rows(parts: tuple[int, ...]) -> None:
    flown, begin = FlownRows(NAMES), 0
    for count in parts:
        flown.append(rows_of(count, begin))
        begin += count
        assert flown.last.tobytes() == rows_of(1, begin - 1)[0, :4].tobytes()
    columns, whole = flown.columns(), rows_of(sum(parts))
    for i, name in enumerate(NAMES):
        assert columns[name].tobytes() == whole[:, i].tobytes()


def test_what_stands_still_takes_no_memory() -> None:
    flown = FlownRows([str(i) for i in range(50)])
    rows = np.zeros((BLOCK_ROWS, 50))
    tracemalloc.start()
    for _ in range(20):
        flown.append(rows.copy())
    columns = flown.columns()
    kept, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert all(len(each) == 20 * BLOCK_ROWS for each in columns.values())
    assert kept < 1_000_000  # of 128 MB

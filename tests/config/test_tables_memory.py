"""A long table needs little memory: no copy of its text, and one text for cells that are alike."""

import tracemalloc
from pathlib import Path

import numpy as np

from trainer.config.tables import read_table

ROWS = 20_000
MOST_BYTES = 400  # of memory in a row of four columns, at the most that is held at once


def test_a_row_of_four_columns_holds_few_bytes(tmp_path: Path) -> None:
    t = 0.1 * np.arange(ROWS)
    swing = np.sin(0.02 * t)
    rows = np.column_stack([t, 10.0 * swing, 180.0 + 40.0 * swing, 0.8 * swing])
    path = tmp_path / "long.csv"
    np.savetxt(path, rows, "%.2f", delimiter=",", header="t,rudder,heading,rate", comments="")
    tracemalloc.start()
    try:
        table = read_table(path)
        numbers = [table.numbers(index) for index in range(4)]
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert numbers[2][-1] == round(float(rows[-1, 2]), 2)
    assert most < MOST_BYTES * ROWS, most / ROWS

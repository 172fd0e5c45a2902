"""Forward numbers of second order: a value with its derivatives, one in each row of a table.

A row holds the value, eight first derivatives, and the second ones of the first three directions
with all eight. A table of fewer columns carries fewer of them, and the same kernels then do less
work: 1 column is the value alone, 4 the value and its first three derivatives, 9 all first ones.
"""

import math
from typing import Final

from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import lean

STATES: Final = 3  # directions with second derivatives
DIRECTIONS: Final = 8
FIRST: Final = 1 + DIRECTIONS  # columns of a number with first derivatives
SECOND: Final = FIRST + 21  # and with second ones


@lean
def hold(table: Numbers, row: int, value: float) -> None:
    """Write a constant."""
    for i in range(1, table.shape[1]):
        table[row, i] = 0.0
    table[row, 0] = value


@lean
def vary(table: Numbers, row: int, value: float, direction: int) -> None:
    """Write a variable whose own direction is given."""
    hold(table, row, value)
    if 1 + direction < table.shape[1]:
        table[row, 1 + direction] = 1.0


@lean
def multiply(table: Numbers, a: int, b: int, out: int) -> None:
    """Write the product of two rows; ``out`` may be one of them."""
    x, y = table[a, 0], table[b, 0]
    if table.shape[1] > FIRST:
        place = FIRST
        for i in range(1, 1 + STATES):
            for j in range(i, FIRST):
                cross = table[a, i] * table[b, j] + table[a, j] * table[b, i]
                table[out, place] = x * table[b, place] + y * table[a, place] + cross
                place += 1
    for i in range(1, min(table.shape[1], FIRST)):
        table[out, i] = x * table[b, i] + y * table[a, i]
    table[out, 0] = x * y


@lean
def combine(table: Numbers, a: tuple[int, float], b: tuple[int, float], out: int) -> None:
    """Write the sum of two rows, each times its factor."""
    for i in range(table.shape[1]):
        table[out, i] = a[1] * table[a[0], i] + b[1] * table[b[0], i]


@lean
def scale(table: Numbers, a: int, factor: float, constant: float, out: int) -> None:
    """Write ``factor`` times a row, plus a constant."""
    for i in range(table.shape[1]):
        table[out, i] = factor * table[a, i]
    table[out, 0] += constant


@lean
def compose(table: Numbers, a: int, shape: tuple[float, float, float], out: int) -> None:
    """Write f of a row; ``shape`` has f and its two derivatives there."""
    if table.shape[1] > FIRST:
        place = FIRST
        for i in range(1, 1 + STATES):
            for j in range(i, FIRST):
                bend = shape[2] * table[a, i] * table[a, j]
                table[out, place] = shape[1] * table[a, place] + bend
                place += 1
    for i in range(1, min(table.shape[1], FIRST)):
        table[out, i] = shape[1] * table[a, i]
    table[out, 0] = shape[0]


@lean
def root(table: Numbers, a: int, out: int) -> None:
    """Write the square root of a row."""
    value = math.sqrt(table[a, 0])
    slope = 0.5 / value
    compose(table, a, (value, slope, -0.5 * slope / table[a, 0]), out)


@lean
def invert(table: Numbers, a: int, out: int) -> None:
    """Write one over a row."""
    value = 1.0 / table[a, 0]
    compose(table, a, (value, -value * value, 2.0 * value * value * value), out)


@lean
def decay(table: Numbers, a: int, rate: float, out: int) -> None:
    """Write exp(-rate times a row)."""
    value = math.exp(-rate * table[a, 0])
    compose(table, a, (value, -rate * value, rate * rate * value), out)


@lean
def second_place(i: int, j: int) -> int:
    """Return the column of the second derivative by directions ``i`` < 3 and ``j`` >= ``i``."""
    return FIRST + i * DIRECTIONS - i * (i - 1) // 2 + j - i

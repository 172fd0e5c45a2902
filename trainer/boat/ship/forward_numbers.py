"""Forward numbers of second order: each row is a value with derivatives.

A row holds the value, eight first derivatives, and the second ones of the first three directions
with all eight. A table of fewer columns carries fewer of them, and the same steps then do less
work: 1 column is the value alone, 4 the value and its first three derivatives, 9 all first ones.

Equations are written in Python as they stand in their source, by ``Quantity``; that makes a list of
steps, which ``run_steps`` takes for numbers of any order. Compiled one by one the equations took
half a minute to compile, the steps take a second. This is automatic differentiation in forward
mode. ``forces`` writes its equations so, because fits of a ship need the slopes of its forces, and
nobody need derive them.
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers, kernel

STATE_COUNT: Final = 3  # directions with second derivatives
DIRECTION_COUNT: Final = 8
FIRST_COLUMNS: Final = 1 + DIRECTION_COUNT  # columns of a number with first derivatives
SECOND_COLUMNS: Final = FIRST_COLUMNS + 21  # and with second ones
MULTIPLY, SCALE, ADD, SUBTRACT, ROOT, INVERT, EXPONENTIAL = range(7)

VALUE: Final = 0  # column of the value itself
SLOPES: Final = 1  # first column of its first derivatives
KIND, ROW, OTHER_ROW = 0, 1, 2  # columns of the steps

Steps = NDArray[np.int64]


@dataclass(frozen=True)
class Quantity:
    """A row of the table; arithmetic with it adds steps to the list."""

    row: int
    constant: bool
    steps: list[tuple[int, int, int]]  # kind and two rows; each step makes the next row
    first: int  # row of the first step

    def _step(self, kind: int, other: "Quantity") -> "Quantity":
        """Return the row of a new step."""
        self.steps.append((kind, self.row, other.row))
        constant = self.constant and other.constant
        return Quantity(self.first + len(self.steps) - 1, constant, self.steps, self.first)

    def __add__(self, other: "Quantity") -> "Quantity":
        """Return the sum."""
        return self._step(ADD, other)

    def __sub__(self, other: "Quantity") -> "Quantity":
        """Return the difference."""
        return self._step(SUBTRACT, other)

    def __mul__(self, other: "Quantity") -> "Quantity":
        """Return the product."""
        if self.constant:
            return other._step(SCALE, self)
        return self._step(SCALE if other.constant else MULTIPLY, other)

    def __truediv__(self, other: "Quantity") -> "Quantity":
        """Return the quotient."""
        return self * other._step(INVERT, other)

    def root(self) -> "Quantity":
        """Return the square root."""
        return self._step(ROOT, self)

    def exponential(self) -> "Quantity":
        """Return e to this power."""
        return self._step(EXPONENTIAL, self)


def quantities(variables: int, constants: int) -> tuple[Quantity, ...]:
    """Return the first rows of a table: variables, then constants."""
    steps: list[tuple[int, int, int]] = []
    first = variables + constants
    return tuple(Quantity(row, row >= variables, steps, first) for row in range(first))


@kernel
def _multiply(table: Numbers, a: int, b: int, out: int) -> None:
    """Write the product of two rows."""
    x, y = table[a, VALUE], table[b, VALUE]
    table[out, VALUE] = x * y
    for i in range(1, min(table.shape[1], FIRST_COLUMNS)):
        table[out, i] = x * table[b, i] + y * table[a, i]
    if table.shape[1] > FIRST_COLUMNS:
        column = FIRST_COLUMNS
        for i in range(1, 1 + STATE_COUNT):
            for j in range(i, FIRST_COLUMNS):
                cross = table[a, i] * table[b, j] + table[a, j] * table[b, i]
                table[out, column] = x * table[b, column] + y * table[a, column] + cross
                column += 1


@kernel
def _compose(table: Numbers, a: int, shape: tuple[float, float, float], out: int) -> None:
    """Write f of a row; ``shape`` has f and its two derivatives there."""
    value, slope, curve = shape
    table[out, VALUE] = value
    for i in range(1, min(table.shape[1], FIRST_COLUMNS)):
        table[out, i] = slope * table[a, i]
    if table.shape[1] > FIRST_COLUMNS:
        column = FIRST_COLUMNS
        for i in range(1, 1 + STATE_COUNT):
            for j in range(i, FIRST_COLUMNS):
                bend = curve * table[a, i] * table[a, j]
                table[out, column] = slope * table[a, column] + bend
                column += 1


@kernel
def _shape(kind: int, x: float) -> tuple[float, float, float]:
    """Return a function of ``x`` and its two derivatives."""
    if kind == ROOT:
        value = math.sqrt(x)
        return value, 0.5 / value, -0.25 / (value * x)
    if kind == INVERT:
        value = 1.0 / x
        return value, -value * value, 2.0 * value * value * value
    value = math.exp(x)
    return value, value, value


@kernel
def _add(table: Numbers, p: tuple[int, float], q: tuple[int, float], out: int) -> None:
    """Write the sum of two rows, each times its factor."""
    (a, by_a), (b, by_b) = p, q
    for i in range(table.shape[1]):
        table[out, i] = by_a * table[a, i] + by_b * table[b, i]


@kernel
def run_steps(table: Numbers, steps: Steps, first: int) -> None:
    """Write the row of each step (kind, two rows), from row ``first`` on.

    Variables and constants come before. A table of fewer rows ends the steps.
    """
    out = first
    for k in range(min(steps.shape[0], table.shape[0] - first)):
        kind, a, b = steps[k, KIND], steps[k, ROW], steps[k, OTHER_ROW]
        if kind == MULTIPLY:
            _multiply(table, a, b, out)
        elif kind == SCALE:
            _add(table, (a, table[b, VALUE]), (a, 0.0), out)
        elif kind < ROOT:
            _add(table, (a, 1.0), (b, 1.0 if kind == ADD else -1.0), out)
        else:
            _compose(table, a, _shape(kind, table[a, VALUE]), out)
        out += 1


@kernel
def second_column(i: int, j: int) -> int:
    """Return the column of the second derivative by ``i`` < 3 and ``j`` >= ``i``."""
    return FIRST_COLUMNS + i * DIRECTION_COUNT - i * (i - 1) // 2 + j - i

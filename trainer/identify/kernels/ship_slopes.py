"""Derivatives of a ship's forces by its state and its coefficients.

The extended Kalman filter needs both: those by the state for its covariance, those by the
coefficients for the gradient of the likelihood. ``boat/ship/forces`` computes the accelerations as
forward numbers (a value with its derivatives); here they become matrices.
"""

from typing import NamedTuple

from trainer.boat.ship.forces import (
    AXIS_COUNT,
    PART,
    ROLL_RATE_INDEX,
    ROW,
    DrivenStates,
    Terms,
    Units,
    in_units,
    states_of,
)
from trainer.boat.ship.forward_numbers import FIRST_COLUMNS, SLOPES, VALUE, second_column
from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import lean, part


class Accelerations(NamedTuple):
    """The accelerations as forward numbers, and what they are made from."""

    table: Numbers  # of the terms
    rates: Numbers


@lean
def set_jacobian(driven: DrivenStates, rates: Numbers, A: Numbers) -> None:
    """Write df/dx (n, n) from the forward numbers of the accelerations."""
    A[:] = 0.0
    for e in range(len(driven)):
        for i in range(3):
            A[driven[e], i] = rates[e, SLOPES + i]
        for i in range(ROLL_RATE_INDEX, states_of(driven)):
            A[driven[e], i] = rates[AXIS_COUNT * (i - 3) + e, VALUE]
    for i in range(3, states_of(driven), 2):  # heading and roll: each grows by the state before it
        A[i, i - 1] = 1.0


@part
def _factor_slopes(table: Numbers, index: int, row: int, units: Units, out: Numbers) -> None:
    """Write the derivatives of the accelerations by the factor of one term."""
    axis = index if index < 3 else index % AXIS_COUNT
    for i in range(4):
        out[axis, i] = in_units(table[row, i], index, units)
    if index >= AXIS_COUNT:
        by = index // AXIS_COUNT - 1
        out[axis, ROLL_RATE_INDEX + by] = out[axis, VALUE]
        heel = units.roll_rate if by == 0 else units.roll
        for i in range(4):
            out[axis, i] *= heel


@part
def coefficient_slopes(
    accelerations: Accelerations,
    terms: Terms,
    driven: DrivenStates,
    units: Units,
    which: int,
    out: Numbers,
) -> None:
    """Write d/d(coefficient) of the accelerations, and of their derivatives by u, v, r.

    ``out`` is (3, 4) or more; with roll (4, 6), where the last two are by roll rate and roll.
    ``which`` counts the factors of the terms first, then the nonlinear coefficients.
    """
    rates, direction = accelerations.rates, 3 + which - terms.shape[0]
    for e in range(len(driven)):
        for i in range(states_of(driven)):
            out[e, i] = 0.0
    if direction < 3:
        index, row = terms[which, PART], terms[which, ROW]
        _factor_slopes(accelerations.table, index, row, units, out)
        return
    for e in range(len(driven)):
        out[e, VALUE] = rates[e, SLOPES + direction]
        if rates.shape[1] > FIRST_COLUMNS:
            for i in range(3):
                out[e, SLOPES + i] = rates[e, second_column(i, direction)]
        for i in range(ROLL_RATE_INDEX, states_of(driven)):
            out[e, i] = rates[AXIS_COUNT * (i - 3) + e, SLOPES + direction]

"""Derivatives of a ship's forces by its state and its coefficients."""

from trainer.boat.ship.forces import AXES, ROLL_RATE, Driven, Terms, Units, in_units, states_of
from trainer.boat.ship.forward_numbers import FIRST, second_place
from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import lean, part


@lean
def set_jacobian(driven: Driven, rates: Numbers, A: Numbers) -> None:
    """Write df/dx (n, n) from the forward numbers of the accelerations."""
    A[:] = 0.0
    for e in range(len(driven)):
        for i in range(3):
            A[driven[e], i] = rates[e, 1 + i]
        for i in range(ROLL_RATE, states_of(driven)):
            A[driven[e], i] = rates[AXES * (i - 3) + e, 0]
    for i in range(3, states_of(driven), 2):
        A[i, i - 1] = 1.0


@part
def _factor_slopes(table: Numbers, place: int, row: int, units: Units, out: Numbers) -> None:
    """Write what the factor of a term does, as ``coefficient_slopes``."""
    axis = place if place < 3 else place % AXES
    for i in range(4):
        out[axis, i] = in_units(table[row, i], place, units)
    if place >= AXES:
        by = place // AXES - 1
        out[axis, ROLL_RATE + by] = out[axis, 0]
        for i in range(4):
            out[axis, i] *= units[2 + by]


@part
def coefficient_slopes(
    work: tuple[Numbers, Numbers],
    terms: Terms,
    driven: Driven,
    units: Units,
    which: int,
    out: Numbers,
) -> None:
    """Write d/d(coefficient) of the accelerations, and of their derivatives by u, v, r.

    ``out`` is (3, 4) or more; with roll (4, 6), where the last two are by roll rate and roll.
    ``work`` is the table and the accelerations; ``which`` counts the factors of the terms first,
    then the nonlinear coefficients.
    """
    rates, direction = work[1], 3 + which - terms.shape[0]
    for e in range(len(driven)):
        for i in range(states_of(driven)):
            out[e, i] = 0.0
    if direction < 3:
        _factor_slopes(work[0], terms[which, 0], terms[which, 1], units, out)
        return
    for e in range(len(driven)):
        out[e, 0] = rates[e, 1 + direction]
        if rates.shape[1] > FIRST:
            for i in range(3):
                out[e, 1 + i] = rates[e, second_place(i, direction)]
        for i in range(ROLL_RATE, states_of(driven)):
            out[e, i] = rates[AXES * (i - 3) + e, 1 + direction]

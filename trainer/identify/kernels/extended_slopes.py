"""Derivatives of an extended Kalman filter by its parameters, step by step of the filter.

Parameters are the last index of each array, because loops over contiguous numbers are fast. Their
order is: the free coefficients, the logarithms of the disturbances, the logarithms of the errors of
readings, the first state. An index of length 0 means that no derivatives are wanted.
``extended_filter`` calls these kernels, because a search for the best parameters needs the exact
gradient of its likelihood. It needs the derivatives of a ship's forces by the state for its
covariance, those by the coefficients for its gradient.
"""

from typing import Final, NamedTuple

from trainer.boat.ship.forces import (
    AXIS_COUNT,
    PART,
    ROLL_RATE_INDEX,
    ROW,
    DrivenStates,
    System,
    Terms,
    Units,
    in_units,
    states_of,
    units_of,
)
from trainer.boat.ship.forward_numbers import FIRST_COLUMNS, SLOPES, VALUE, second_column
from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import inline_kernel, lean_kernel

FREE: Final = 0  # column of the indices of the free coefficients


class Accelerations(NamedTuple):
    """The accelerations as forward numbers, and what they are made from."""

    table: Numbers  # of the terms
    rates: Numbers


@lean_kernel
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


@inline_kernel
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


@inline_kernel
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


class Innovation(NamedTuple):
    """A reading less its prediction, and the variance of this error."""

    error: float
    variance: float


class Belief(NamedTuple):
    """The state of the filter, and its derivatives by the parameters."""

    x: Numbers
    P: Numbers  # covariance
    S: Numbers  # of x, (n, q)
    dP: Numbers  # of P, (n, n, q)


class ReadingSlopes(NamedTuple):
    """Derivatives of one reading's innovation, and of its column of P."""

    error: Numbers
    variance: Numbers
    column: Numbers  # (n, q)


class MatrixRoom(NamedTuple):
    """The matrices of a step and their derivatives; the last three are scratch."""

    A: Numbers  # Jacobian
    dA: Numbers
    phi: Numbers  # transition
    dphi: Numbers
    half: Numbers
    turned: Numbers  # (n, n, q)
    own: Numbers  # what one coefficient does


@lean_kernel
def count_reading(
    innovation: Innovation, lines: ReadingSlopes, gradient: Numbers, information: Numbers
) -> None:
    """Add what a reading tells of the parameters to gradient and information."""
    error, s = innovation.error, innovation.variance
    de, ds = lines.error, lines.variance
    weight = 0.5 / (s * s)
    for j in range(de.size):
        gradient[j] += 0.5 * ds[j] / s * (1.0 - error * error / s) + error * de[j] / s
        a, b = de[j] / s, weight * ds[j]
        for i in range(j + 1):
            information[j, i] += a * de[i] + b * ds[i]


@lean_kernel
def _take(driven: DrivenStates, m: int, innovation: Innovation, x: Numbers, P: Numbers) -> None:
    """Take one reading into state and covariance.

    The reading's own column of ``P`` changes last, because all other entries are made from it.
    """
    error, s = innovation.error, innovation.variance
    pivot = P[m, m]
    for i in range(states_of(driven)):
        x[i] += P[i, m] / s * error
        for k in range(states_of(driven)):
            if k != m:
                P[i, k] -= P[i, m] * P[k, m] / s
    for i in range(states_of(driven)):
        P[i, m] -= P[i, m] * pivot / s


@lean_kernel
def take_slopes(
    driven: DrivenStates, m: int, innovation: Innovation, estimate: Belief, lines: ReadingSlopes
) -> None:
    """Take one reading into state, covariance and both derivatives.

    ``lines`` has the derivatives of error and variance; its column is scratch. The derivatives are
    taken before state and covariance, because they need those from before the reading.
    """
    error, s = innovation.error, innovation.variance
    P, S, dP = estimate.P, estimate.S, estimate.dP
    column = lines.column
    n = states_of(driven)
    for i in range(n):
        for j in range(S.shape[1]):
            column[i, j] = dP[i, m, j]
    for i in range(n):
        p, gain = P[i, m], P[i, m] / s
        for j in range(S.shape[1]):
            turn = (column[i, j] - gain * lines.variance[j]) / s
            S[i, j] += turn * error + gain * lines.error[j]
        for k in range(n):
            other = P[k, m]
            for j in range(S.shape[1]):
                both = column[i, j] * other + p * column[k, j]
                dP[i, k, j] -= (both - gain * other * lines.variance[j]) / s
    _take(driven, m, innovation, estimate.x, P)


@lean_kernel
def _bend(rates: Numbers, axis: int, i: int, k: int) -> float:
    """Return the second derivative of an acceleration by two states.

    The terms are linear in roll and roll rate: two of these give zero, and one of these with u, v
    or r is found in the rows of the terms that roll multiplies. Heading acts on nothing.
    """
    low, high = min(i, k), max(i, k)
    if high < 3:
        return float(rates[axis, second_column(low, high)])
    if low < 3 and high >= ROLL_RATE_INDEX:
        return float(rates[AXIS_COUNT * (high - 3) + axis, SLOPES + low])
    return 0.0


@lean_kernel
def matrix_slopes(driven: DrivenStates, rates: Numbers, S: Numbers, dA: Numbers) -> None:
    """Write what the state's derivatives ``S`` do to the Jacobian, dA (n, n, q)."""
    dA[:] = 0.0
    for axis in range(len(driven)):
        for i in range(states_of(driven)):
            for k in range(states_of(driven)):
                bend = _bend(rates, axis, i, k)
                for j in range(S.shape[1] if bend != 0.0 else 0):
                    dA[driven[axis], i, j] += bend * S[k, j]


@lean_kernel
def own_slopes(
    system: System, accelerations: Accelerations, x: Numbers, own: Numbers, dA: Numbers
) -> None:
    """Add what the coefficients themselves do to the Jacobian; ``own`` is scratch."""
    free, driven = system.free, system.driven
    units = units_of(system.ship, x)
    for j in range(free.shape[0]):
        coefficient_slopes(accelerations, system.terms, driven, units, free[j, FREE], own)
        for e in range(len(driven)):
            for i in range(3):
                dA[driven[e], i, j] += own[e, SLOPES + i]
            for i in range(ROLL_RATE_INDEX, states_of(driven)):
                dA[driven[e], i, j] += own[e, i]


@lean_kernel
def _horner(driven: DrivenStates, part: float, room: MatrixRoom) -> None:
    """Write I + part A H and its derivatives over H and dH, the transition so far.

    Repeated from the highest order down it is the power series of exp(A T), by Horner's scheme.
    """
    A, dA, H, dH = room.A, room.dA, room.phi, room.dphi
    half, turned = room.half, room.turned
    size = states_of(driven)
    half[:] = 0.0
    turned[:] = 0.0
    for i in range(size):
        for k in range(size):
            for n in range(size):
                half[i, k] += A[i, n] * H[n, k]
                for j in range(dH.shape[2]):
                    turned[i, k, j] += dA[i, n, j] * H[n, k] + A[i, n] * dH[n, k, j]
    for i in range(size):
        for k in range(size):
            H[i, k] = part * half[i, k] + (1.0 if i == k else 0.0)
            for j in range(dH.shape[2]):
                dH[i, k, j] = part * turned[i, k, j]


@lean_kernel
def transition_slopes(driven: DrivenStates, T: float, room: MatrixRoom) -> None:
    """Write the transition and its derivatives over ``T`` [s]."""
    H, dH = room.phi, room.dphi
    dH[:] = 0.0
    for i in range(states_of(driven)):
        for k in range(states_of(driven)):
            H[i, k] = 1.0 if i == k else 0.0
    for order in range(4, 0, -1):  # exp(A T) to the fourth order, as the state's steps are
        _horner(driven, T / order, room)


@lean_kernel
def spread_slopes(driven: DrivenStates, room: MatrixRoom, dP: Numbers) -> None:
    """Advance ``dP`` to dphi G + (dphi G)' + phi dP phi'.

    G is (P + T/2 R1) phi', which ``half`` has; dA is scratch here.
    """
    phi, dphi, G = room.phi, room.dphi, room.half
    turned, half = room.turned, room.dA
    size = states_of(driven)
    for i in range(size):
        for k in range(size):
            for j in range(dP.shape[2]):
                turned[i, k, j] = 0.0
                half[i, k, j] = 0.0
            for n in range(size):
                for j in range(dP.shape[2]):
                    turned[i, k, j] += dphi[i, n, j] * G[n, k]
                    half[i, k, j] += dP[i, n, j] * phi[k, n]
    for i in range(size):
        for k in range(i + 1):
            for j in range(dP.shape[2]):
                total = turned[i, k, j] + turned[k, i, j]
                for n in range(size):
                    total += phi[i, n] * half[n, k, j]
                dP[i, k, j] = total
                dP[k, i, j] = total


@lean_kernel
def noise_slopes(
    driven: DrivenStates, phi: Numbers, noise: Numbers, T: float, first: int, dP: Numbers
) -> None:
    """Add the derivatives by the disturbances' logarithms, ``first`` on, to ``dP``."""
    for g in range(len(driven)):
        weight, s = T * noise[g] * noise[g], driven[g]
        for i in range(states_of(driven)):
            for k in range(states_of(driven)):
                dP[i, k, first + g] += weight * phi[i, s] * phi[k, s]
        dP[s, s, first + g] += weight


@lean_kernel
def rate_slopes(
    system: System, accelerations: Accelerations, x: Numbers, S: Numbers, own: Numbers, out: Numbers
) -> None:
    """Write the derivatives (n, q) of the rates, those of the state ``x`` being ``S``.

    ``own`` is scratch.
    """
    free, driven = system.free, system.driven
    rates, units = accelerations.rates, units_of(system.ship, x)
    for e in range(len(driven)):
        for j in range(S.shape[1]):
            out[driven[e], j] = 0.0
            for i in range(3):
                out[driven[e], j] += rates[e, SLOPES + i] * S[i, j]
            for i in range(ROLL_RATE_INDEX, states_of(driven)):
                out[driven[e], j] += rates[AXIS_COUNT * (i - 3) + e, VALUE] * S[i, j]
    for i in range(3, states_of(driven), 2):  # heading and roll: each grows by the state before it
        for j in range(S.shape[1]):
            out[i, j] = S[i - 1, j]
    for j in range(free.shape[0] if S.shape[1] > 0 else 0):
        coefficient_slopes(accelerations, system.terms, driven, units, free[j, FREE], own)
        for e in range(len(driven)):
            out[driven[e], j] += own[e, VALUE]

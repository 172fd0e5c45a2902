"""Derivatives of an extended Kalman filter by its parameters, step by step of the filter.

Parameters are the last, contiguous index, in this order: the free coefficients, the logarithms of
the disturbances and of the errors of readings, the first state. There may be none of them.
"""

from trainer.core.kernel import Numbers
from trainer.identify.kernels.forward_numbers import second_place
from trainer.identify.kernels.kernel import lean
from trainer.identify.kernels.ship_forces import (
    AXES,
    ROLL_RATE,
    System,
    axes_of,
    coefficient_slopes,
    state_of,
)


@lean
def count_reading(
    moments: tuple[float, float], de: Numbers, ds: Numbers, gradient: Numbers, information: Numbers
) -> None:
    """Add what a reading of error and variance ``moments`` tells of the parameters."""
    error, s = moments
    weight = 0.5 / (s * s)
    for j in range(de.size):
        gradient[j] += 0.5 * ds[j] / s * (1.0 - error * error / s) + error * de[j] / s
        a, b = de[j] / s, weight * ds[j]
        for i in range(j + 1):
            information[j, i] += a * de[i] + b * ds[i]


@lean
def take_slopes(
    m: int,
    moments: tuple[float, float],
    kept: tuple[Numbers, Numbers],
    slopes: tuple[Numbers, Numbers],
    lines: Numbers,
) -> None:
    """Take one reading into state, covariance and both derivatives.

    The first two rows of ``lines`` have the derivatives of error and variance; the others, one
    for each state, are scratch.
    """
    error, s = moments
    x, P = kept
    S, dP = slopes
    n = x.size
    p = (P[0, m], P[1, m], P[2, m], P[3, m], P[n - 2, m], P[n - 1, m])
    for i in range(n):
        for j in range(S.shape[1]):
            lines[2 + i, j] = dP[i, m, j]
    for i in range(n):
        gain = p[i] / s
        for j in range(S.shape[1]):
            turn = (lines[2 + i, j] - gain * lines[1, j]) / s
            S[i, j] += turn * error + gain * lines[0, j]
        for k in range(n):
            for j in range(S.shape[1]):
                both = lines[2 + i, j] * p[k] + p[i] * lines[2 + k, j]
                dP[i, k, j] -= (both - gain * p[k] * lines[1, j]) / s
    for i in range(n):
        x[i] += p[i] / s * error
        for k in range(n):
            P[i, k] -= p[i] * p[k] / s


@lean
def _bend(rates: Numbers, axis: int, i: int, k: int) -> float:
    """Return the second derivative of an acceleration by two states."""
    low, high = min(i, k), max(i, k)
    if high < 3:
        return float(rates[axis, second_place(low, high)])
    if low < 3 and high >= ROLL_RATE:
        return float(rates[AXES * (high - 3) + axis, 1 + low])
    return 0.0


@lean
def matrix_slopes(rates: Numbers, S: Numbers, dA: Numbers) -> None:
    """Write what the state's derivatives ``S`` do to the Jacobian, dA (n, n, q)."""
    dA[:] = 0.0
    for axis in range(axes_of(S.shape[0])):
        for i in range(S.shape[0]):
            for k in range(S.shape[0]):
                bend = _bend(rates, axis, i, k)
                for j in range(S.shape[1] if bend != 0.0 else 0):
                    dA[state_of(axis), i, j] += bend * S[k, j]


@lean
def own_slopes(
    system: System, work: tuple[Numbers, Numbers], x: Numbers, own: Numbers, dA: Numbers
) -> None:
    """Add what the coefficients themselves do to the Jacobian; ``own`` is scratch.

    ``work`` is the table and the accelerations.
    """
    for j in range(system[3].shape[0]):
        coefficient_slopes(work[0], work[1], system, x, system[3][j, 0], own)
        for e in range(axes_of(x.size)):
            for i in range(3):
                dA[state_of(e), i, j] += own[e, 1 + i]
            for i in range(ROLL_RATE, x.size):
                dA[state_of(e), i, j] += own[e, i]


@lean
def _horner(
    A: Numbers,
    dA: Numbers,
    part: float,
    power: tuple[Numbers, Numbers],
    work: tuple[Numbers, Numbers],
) -> None:
    """Write I + part A H and its derivatives over H and dH, which ``power`` has."""
    H, dH = power
    half, turned = work
    half[:] = 0.0
    turned[:] = 0.0
    for i in range(A.shape[0]):
        for k in range(A.shape[0]):
            for n in range(A.shape[0]):
                half[i, k] += A[i, n] * H[n, k]
                for j in range(dH.shape[2]):
                    turned[i, k, j] += dA[i, n, j] * H[n, k] + A[i, n] * dH[n, k, j]
    for i in range(A.shape[0]):
        for k in range(A.shape[0]):
            H[i, k] = part * half[i, k] + (1.0 if i == k else 0.0)
            for j in range(dH.shape[2]):
                dH[i, k, j] = part * turned[i, k, j]


@lean
def transition_slopes(
    A: Numbers,
    dA: Numbers,
    T: float,
    power: tuple[Numbers, Numbers],
    work: tuple[Numbers, Numbers],
) -> None:
    """Write the transition and its derivatives to ``power``; ``work`` is like both."""
    H, dH = power
    dH[:] = 0.0
    for i in range(A.shape[0]):
        for k in range(A.shape[0]):
            H[i, k] = 1.0 if i == k else 0.0
    for order in range(4, 0, -1):
        _horner(A, dA, T / order, power, work)


@lean
def spread_slopes(
    phi: Numbers, dphi: Numbers, G: Numbers, dP: Numbers, work: tuple[Numbers, Numbers]
) -> None:
    """Advance ``dP`` to dphi G + (dphi G)' + phi dP phi'.

    ``G`` is (P + T/2 R1) phi'.
    """
    turned, half = work
    for i in range(phi.shape[0]):
        for k in range(phi.shape[0]):
            for j in range(dP.shape[2]):
                turned[i, k, j] = 0.0
                half[i, k, j] = 0.0
            for n in range(phi.shape[0]):
                for j in range(dP.shape[2]):
                    turned[i, k, j] += dphi[i, n, j] * G[n, k]
                    half[i, k, j] += dP[i, n, j] * phi[k, n]
    for i in range(phi.shape[0]):
        for k in range(i + 1):
            for j in range(dP.shape[2]):
                total = turned[i, k, j] + turned[k, i, j]
                for n in range(phi.shape[0]):
                    total += phi[i, n] * half[n, k, j]
                dP[i, k, j] = total
                dP[k, i, j] = total


@lean
def noise_slopes(phi: Numbers, noise: Numbers, T: float, first: int, dP: Numbers) -> None:
    """Add the derivatives by the disturbances' logarithms, ``first`` on, to ``dP``."""
    for g in range(axes_of(phi.shape[0])):
        weight, s = T * noise[g] * noise[g], state_of(g)
        for i in range(phi.shape[0]):
            for k in range(phi.shape[0]):
                dP[i, k, first + g] += weight * phi[i, s] * phi[k, s]
        dP[s, s, first + g] += weight


@lean
def rate_slopes(
    system: System,
    work: tuple[Numbers, Numbers],
    x: Numbers,
    S: Numbers,
    own: Numbers,
    out: Numbers,
) -> None:
    """Write the derivatives (n, q) of the rates, those of the state ``x`` being ``S``.

    ``work`` is the table and the accelerations; ``own`` is scratch.
    """
    table, rates = work
    for e in range(axes_of(x.size)):
        for j in range(S.shape[1]):
            out[state_of(e), j] = 0.0
            for i in range(3):
                out[state_of(e), j] += rates[e, 1 + i] * S[i, j]
            for i in range(ROLL_RATE, x.size):
                out[state_of(e), j] += rates[AXES * (i - 3) + e, 0] * S[i, j]
    for i in range(3, x.size, 2):
        for j in range(S.shape[1]):
            out[i, j] = S[i - 1, j]
    for j in range(system[3].shape[0] if S.shape[1] > 0 else 0):
        coefficient_slopes(table, rates, system, x, system[3][j, 0], own)
        for e in range(axes_of(x.size)):
            out[state_of(e), j] += own[e, 0]

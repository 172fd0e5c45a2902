"""Derivatives of an extended Kalman filter by its parameters, step by step of the filter.

Parameters are the last, contiguous index, in this order: the free coefficients, the logarithms of
the disturbances and of the errors of readings, the first state. There may be none of them.
"""

from trainer.boat.ship.forces import AXES, ROLL_RATE, Driven, System, states_of, units_of
from trainer.boat.ship.forward_numbers import second_place
from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import lean
from trainer.identify.kernels.ship_slopes import coefficient_slopes


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
def _take(driven: Driven, m: int, moments: tuple[float, float], x: Numbers, P: Numbers) -> None:
    """Take one reading into state and covariance, its own column last."""
    error, s = moments
    own = P[m, m]
    for i in range(states_of(driven)):
        x[i] += P[i, m] / s * error
        for k in range(states_of(driven)):
            if k != m:
                P[i, k] -= P[i, m] * P[k, m] / s
    for i in range(states_of(driven)):
        P[i, m] -= P[i, m] * own / s


@lean
def take_slopes(
    driven: Driven,
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
    P = kept[1]
    S, dP = slopes
    n = states_of(driven)
    for i in range(n):
        for j in range(S.shape[1]):
            lines[2 + i, j] = dP[i, m, j]
    for i in range(n):
        p, gain = P[i, m], P[i, m] / s
        for j in range(S.shape[1]):
            turn = (lines[2 + i, j] - gain * lines[1, j]) / s
            S[i, j] += turn * error + gain * lines[0, j]
        for k in range(n):
            other = P[k, m]
            for j in range(S.shape[1]):
                both = lines[2 + i, j] * other + p * lines[2 + k, j]
                dP[i, k, j] -= (both - gain * other * lines[1, j]) / s
    _take(driven, m, moments, kept[0], P)


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
def matrix_slopes(driven: Driven, rates: Numbers, S: Numbers, dA: Numbers) -> None:
    """Write what the state's derivatives ``S`` do to the Jacobian, dA (n, n, q)."""
    dA[:] = 0.0
    for axis in range(len(driven)):
        for i in range(states_of(driven)):
            for k in range(states_of(driven)):
                bend = _bend(rates, axis, i, k)
                for j in range(S.shape[1] if bend != 0.0 else 0):
                    dA[driven[axis], i, j] += bend * S[k, j]


@lean
def own_slopes(
    system: System, work: tuple[Numbers, Numbers], x: Numbers, own: Numbers, dA: Numbers
) -> None:
    """Add what the coefficients themselves do to the Jacobian; ``own`` is scratch.

    ``work`` is the table and the accelerations.
    """
    ship, terms, _, free, driven = system
    units = units_of(ship, x)
    for j in range(free.shape[0]):
        coefficient_slopes(work, terms, driven, units, free[j, 0], own)
        for e in range(len(driven)):
            for i in range(3):
                dA[driven[e], i, j] += own[e, 1 + i]
            for i in range(ROLL_RATE, states_of(driven)):
                dA[driven[e], i, j] += own[e, i]


@lean
def _horner(
    driven: Driven,
    A: Numbers,
    dA: Numbers,
    part: float,
    power: tuple[Numbers, Numbers],
    work: tuple[Numbers, Numbers],
) -> None:
    """Write I + part A H and its derivatives over H and dH, which ``power`` has."""
    H, dH = power
    half, turned = work
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


@lean
def transition_slopes(
    driven: Driven,
    A: Numbers,
    dA: Numbers,
    T: float,
    power: tuple[Numbers, Numbers],
    work: tuple[Numbers, Numbers],
) -> None:
    """Write the transition and its derivatives to ``power``; ``work`` is like both."""
    H, dH = power
    dH[:] = 0.0
    for i in range(states_of(driven)):
        for k in range(states_of(driven)):
            H[i, k] = 1.0 if i == k else 0.0
    for order in range(4, 0, -1):
        _horner(driven, A, dA, T / order, power, work)


@lean
def spread_slopes(
    driven: Driven,
    phi: tuple[Numbers, Numbers],
    G: Numbers,
    dP: Numbers,
    work: tuple[Numbers, Numbers],
) -> None:
    """Advance ``dP`` to dphi G + (dphi G)' + phi dP phi'.

    ``phi`` is the transition with its derivatives, ``G`` is (P + T/2 R1) phi'.
    """
    (phi_, dphi), (turned, half) = phi, work
    size = states_of(driven)
    for i in range(size):
        for k in range(size):
            for j in range(dP.shape[2]):
                turned[i, k, j] = 0.0
                half[i, k, j] = 0.0
            for n in range(size):
                for j in range(dP.shape[2]):
                    turned[i, k, j] += dphi[i, n, j] * G[n, k]
                    half[i, k, j] += dP[i, n, j] * phi_[k, n]
    for i in range(size):
        for k in range(i + 1):
            for j in range(dP.shape[2]):
                total = turned[i, k, j] + turned[k, i, j]
                for n in range(size):
                    total += phi_[i, n] * half[n, k, j]
                dP[i, k, j] = total
                dP[k, i, j] = total


@lean
def noise_slopes(
    driven: Driven, phi: Numbers, noise: Numbers, T: float, first: int, dP: Numbers
) -> None:
    """Add the derivatives by the disturbances' logarithms, ``first`` on, to ``dP``."""
    for g in range(len(driven)):
        weight, s = T * noise[g] * noise[g], driven[g]
        for i in range(states_of(driven)):
            for k in range(states_of(driven)):
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
    ship, terms, _, free, driven = system
    rates, units = work[1], units_of(ship, x)
    for e in range(len(driven)):
        for j in range(S.shape[1]):
            out[driven[e], j] = 0.0
            for i in range(3):
                out[driven[e], j] += rates[e, 1 + i] * S[i, j]
            for i in range(ROLL_RATE, states_of(driven)):
                out[driven[e], j] += rates[AXES * (i - 3) + e, 0] * S[i, j]
    for i in range(3, states_of(driven), 2):
        for j in range(S.shape[1]):
            out[i, j] = S[i - 1, j]
    for j in range(free.shape[0] if S.shape[1] > 0 else 0):
        coefficient_slopes(work, terms, driven, units, free[j, 0], own)
        for e in range(len(driven)):
            out[driven[e], j] += own[e, 0]

"""Gradient and expected information of a ship's likelihood, by forward sensitivities.

The state's and the covariance's derivatives by every free parameter go forward with the filter.
Arrays are as in ``extended_filter``; parameters are the last, contiguous index, in this order: the
free coefficients, the logarithms of three disturbances and of four errors of readings, the first
state.
"""

import math

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.extended_filter import (
    PARTS,
    SECONDS,
    STAGES,
    WEIGHTS,
    is_ship,
    set_inputs,
    spread,
)
from trainer.identify.kernels.forward_numbers import FIRST, SECOND, second_place
from trainer.identify.kernels.kernel import kernel, lean
from trainer.identify.kernels.ship_forces import (
    NONLINEAR,
    ROWS,
    Terms,
    add_terms,
    coefficient_slopes,
    set_jacobian,
    set_terms,
)

System = tuple[Numbers, Terms, Numbers, Terms]  # ship, terms, values, places of the free ones


@lean
def _count_reading(
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
def _take_slopes(
    m: int,
    moments: tuple[float, float],
    kept: tuple[Numbers, Numbers],
    slopes: tuple[Numbers, Numbers],
    lines: Numbers,
) -> None:
    """Take one reading into state, covariance and both derivatives.

    The first two rows of ``lines`` have the derivatives of error and variance; four more are
    scratch.
    """
    error, s = moments
    x, P = kept
    S, dP = slopes
    p = (P[0, m], P[1, m], P[2, m], P[3, m])
    for i in range(4):
        for j in range(S.shape[1]):
            lines[2 + i, j] = dP[i, m, j]
    for i in range(4):
        gain = p[i] / s
        for j in range(S.shape[1]):
            turn = (lines[2 + i, j] - gain * lines[1, j]) / s
            S[i, j] += turn * error + gain * lines[0, j]
        for k in range(4):
            for j in range(S.shape[1]):
                both = lines[2 + i, j] * p[k] + p[i] * lines[2 + k, j]
                dP[i, k, j] -= (both - gain * p[k] * lines[1, j]) / s
    for i in range(4):
        x[i] += p[i] / s * error
        for k in range(4):
            P[i, k] -= p[i] * p[k] / s


@lean
def _matrix_slopes(rates: Numbers, S: Numbers, dA: Numbers) -> None:
    """Write what the state's derivatives ``S`` do to the Jacobian, dA (4, 4, q)."""
    for e in range(4):
        for i in range(4):
            for j in range(S.shape[1]):
                dA[e, i, j] = 0.0
            for k in range(3 if max(e, i) < 3 else 0):
                bend = rates[e, second_place(min(i, k), max(i, k))]
                for j in range(S.shape[1]):
                    dA[e, i, j] += bend * S[k, j]


@lean
def _own_slopes(system: System, table: Numbers, rates: Numbers, own: Numbers, dA: Numbers) -> None:
    """Add what the coefficients themselves do to the Jacobian; ``own`` (3, 4) is scratch."""
    for j in range(system[3].shape[0]):
        coefficient_slopes(table, rates, system[1], system[0][0], system[3][j, 0], own)
        for e in range(3):
            for i in range(3):
                dA[e, i, j] += own[e, 1 + i]


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
    for i in range(4):
        for k in range(4):
            for n in range(4):
                half[i, k] += A[i, n] * H[n, k]
                for j in range(dH.shape[2]):
                    turned[i, k, j] += dA[i, n, j] * H[n, k] + A[i, n] * dH[n, k, j]
    for i in range(4):
        for k in range(4):
            H[i, k] = part * half[i, k] + (1.0 if i == k else 0.0)
            for j in range(dH.shape[2]):
                dH[i, k, j] = part * turned[i, k, j]


@lean
def _transition_slopes(
    A: Numbers,
    dA: Numbers,
    T: float,
    power: tuple[Numbers, Numbers],
    work: tuple[Numbers, Numbers],
) -> None:
    """Write the transition and its derivatives to ``power``; ``work`` is like both."""
    H, dH = power
    dH[:] = 0.0
    for i in range(4):
        for k in range(4):
            H[i, k] = 1.0 if i == k else 0.0
    for order in range(4, 0, -1):
        _horner(A, dA, T / order, power, work)


@lean
def _spread_slopes(
    phi: Numbers, dphi: Numbers, G: Numbers, dP: Numbers, work: tuple[Numbers, Numbers]
) -> None:
    """Write dphi G + (dphi G)' + phi dP phi' to ``dP``; ``G`` is (P + T/2 R1) phi'."""
    turned, half = work
    for i in range(4):
        for k in range(4):
            for j in range(dP.shape[2]):
                turned[i, k, j] = 0.0
                half[i, k, j] = 0.0
            for n in range(4):
                for j in range(dP.shape[2]):
                    turned[i, k, j] += dphi[i, n, j] * G[n, k]
                    half[i, k, j] += dP[i, n, j] * phi[k, n]
    for i in range(4):
        for k in range(i + 1):
            for j in range(dP.shape[2]):
                total = turned[i, k, j] + turned[k, i, j]
                for n in range(4):
                    total += phi[i, n] * half[n, k, j]
                dP[i, k, j] = total
                dP[k, i, j] = total


@lean
def _noise_slopes(phi: Numbers, noise: Numbers, T: float, first: int, dP: Numbers) -> None:
    """Add what the logarithms of the disturbances do to ``dP``; ``first`` is the place of one."""
    for g in range(3):
        weight = T * noise[g] * noise[g]
        for i in range(4):
            for k in range(4):
                dP[i, k, first + g] += weight * phi[i, g] * phi[k, g]
        dP[g, g, first + g] += weight


@lean
def _rate_slopes(
    system: System, table: Numbers, rates: Numbers, S: Numbers, own: Numbers, out: Numbers
) -> None:
    """Write the derivatives (4, q) of the rates at a stage whose state has derivatives ``S``."""
    for e in range(3):
        for j in range(S.shape[1]):
            out[e, j] = 0.0
            for i in range(3):
                out[e, j] += rates[e, 1 + i] * S[i, j]
    for j in range(S.shape[1]):
        out[3, j] = S[2, j]
    for j in range(system[3].shape[0]):
        coefficient_slopes(table, rates, system[1], system[0][0], system[3][j, 0], own)
        for e in range(3):
            out[e, j] += own[e, 0]


@lean
def _advance_slopes(
    system: System,
    record: Numbers,
    k: int,
    kept: tuple[Numbers, Numbers],
    work: tuple[Numbers, Numbers, Numbers, Numbers, Numbers],
) -> None:
    """Advance the state and its derivatives from row ``k`` to the next by Runge and Kutta.

    ``work`` is a table of first order, its rates, (5, 4), (3, 4) and (3, 4, q).
    """
    x, S = kept
    table, rates, lines, own, many = work
    stage, rate, total, c = lines[0], lines[1], lines[2], lines[3]
    at, turn, sum_ = many[0], many[1], many[2]
    ship, terms, values, _ = system
    parts = int(record[k, PARTS])
    h = record[k, SECONDS] / parts
    for part in range(parts):
        total[:] = 0.0
        rate[:] = 0.0
        sum_[:] = 0.0
        turn[:] = 0.0
        for n in range(4):
            reach = STAGES[n] * h
            for i in range(4):
                stage[i] = x[i] + reach * rate[i]
                for j in range(S.shape[1]):
                    at[i, j] = S[i, j] + reach * turn[i, j]
            set_inputs(record, k, (part + STAGES[n]) / parts, c)
            set_terms(table, ship, stage, c, values[terms.shape[0] : terms.shape[0] + NONLINEAR])
            add_terms(table, terms, values, ship[0], rates)
            _rate_slopes(system, table, rates, at, own, turn)
            for i in range(4):
                rate[i] = rates[i, 0] if i < 3 else stage[2]
                total[i] += WEIGHTS[n] * rate[i]
                for j in range(S.shape[1]):
                    sum_[i, j] += WEIGHTS[n] * turn[i, j]
        for i in range(4):
            x[i] += h / 6.0 * total[i]
            for j in range(S.shape[1]):
                S[i, j] += h / 6.0 * sum_[i, j]


@lean
def _take_row(
    row: Numbers,
    noise: Numbers,
    kept: tuple[Numbers, Numbers],
    slopes: tuple[Numbers, Numbers],
    lines: Numbers,
    sums: tuple[Numbers, Numbers, Numbers],
) -> None:
    """Take the readings of a row and count them in cost, gradient and information."""
    first = lines.shape[1] - 11
    for m in range(4):
        if not math.isnan(row[m]):
            variance = noise[3 + m] * noise[3 + m]
            moments = row[m] - kept[0][m], kept[1][m, m] + variance
            for j in range(lines.shape[1]):
                lines[0, j] = -slopes[0][m, j]
                lines[1, j] = slopes[1][m, m, j]
            lines[1, first + 3 + m] += 2.0 * variance
            square = moments[0] * moments[0] / moments[1]
            sums[0][0] += 0.5 * (math.log(2.0 * math.pi * moments[1]) + square)
            _count_reading(moments, lines[0], lines[1], sums[1], sums[2])
            _take_slopes(m, moments, kept, slopes, lines)


@kernel
def filter_slopes(
    system: System, record: Numbers, cost: Numbers, gradient: Numbers, information: Numbers
) -> None:
    """Add a record's -log L (1,), its gradient (q,) and information (q, q), lower half.

    The cost becomes infinite where the filter loses the ship.
    """
    ship, terms, values, free = system
    count = gradient.size
    first = terms.shape[0] + NONLINEAR
    noise, x, P = values[first : first + 7], values[first + 7 :].copy(), np.zeros((4, 4))
    S, dP = np.zeros((4, count)), np.zeros((4, 4, count))
    for i in range(4):
        S[i, count - 4 + i] = 1.0
    tables = np.empty((ROWS, SECOND)), np.empty((ROWS, FIRST))
    rates, plain, own = np.empty((3, SECOND)), np.empty((3, FIRST)), np.empty((3, 4))
    A, phi, half = np.empty((4, 4)), np.empty((4, 4)), np.empty((4, 4))
    dA, dphi, turned = np.empty((4, 4, count)), np.empty((4, 4, count)), np.empty((4, 4, count))
    lines, short, many = np.empty((6, count)), np.empty((5, 4)), np.empty((3, 4, count))
    for k in range(record.shape[0]):
        _take_row(record[k], noise, (x, P), (S, dP), lines, (cost, gradient, information))
        if not is_ship(x):
            cost[0] = math.inf
            return
        if k + 1 < record.shape[0]:
            T, c = record[k, SECONDS], short[4]
            set_inputs(record, k, 0.5, c)
            set_terms(tables[0], ship, x, c, values[terms.shape[0] : first])
            add_terms(tables[0], terms, values, ship[0], rates)
            set_jacobian(rates, A)
            _matrix_slopes(rates, S, dA)
            _own_slopes(system, tables[0], rates, own, dA)
            _transition_slopes(A, dA, T, (phi, dphi), (half, turned))
            spread(phi, P, noise, T, half)
            _spread_slopes(phi, dphi, half, dP, (turned, dA))
            _noise_slopes(phi, noise, T, free.shape[0], dP)
            _advance_slopes(system, record, k, (x, S), (tables[1], plain, short, own, many))
            if not is_ship(x):
                cost[0] = math.inf
                return

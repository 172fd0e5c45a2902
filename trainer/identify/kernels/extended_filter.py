"""The likelihood of a ship's record by the extended Kalman filter, with its derivatives.

States are u, v [m/s], r [rad/s] and heading [rad], with roll also roll rate [rad/s] and roll [rad];
readings the same. A row of the ``record`` has the first four readings, NaN where there is none,
then rudder, revolutions and wind, then the seconds to the next row and the steps of Runge and Kutta
in them, then the readings of roll. ``values`` are the factors of the terms, the five nonlinear
coefficients, disturbances (of each acceleration) and errors of readings as standard deviations, and
the first state, which is known: its covariance is nothing. Derivatives are as in
``extended_slopes``; where none are asked for, forward numbers carry only what the filter needs.
"""

import math
from typing import Final

import numpy as np

from trainer.boat.ship.forces import (
    NONLINEAR,
    PLACES,
    ROLL,
    ROLL_RATE,
    Driven,
    System,
    rows_of,
    states_of,
)
from trainer.boat.ship.forward_numbers import FIRST, SECOND
from trainer.boat.ship.motion import STAGES, WEIGHTS, is_ship, set_derivative, set_rates
from trainer.core.kernel import Numbers
from trainer.identify.kernels.extended_slopes import (
    count_reading,
    matrix_slopes,
    noise_slopes,
    own_slopes,
    rate_slopes,
    spread_slopes,
    take_slopes,
    transition_slopes,
)
from trainer.identify.kernels.kernel import kernel, lean
from trainer.identify.kernels.ship_slopes import set_jacobian

INPUTS: Final = 4  # the first column of them
SECONDS: Final = 8
PARTS: Final = 9
BESIDE: Final = 6  # columns between the first four readings and those of roll


@lean
def set_inputs(record: Numbers, k: int, part: float, c: Numbers) -> None:
    """Write the inputs ``part`` of the way from row ``k`` to the next."""
    for i in range(4):
        now, then = record[k, INPUTS + i], record[k + 1, INPUTS + i]
        c[i] = now + part * (then - now)


@lean
def _spread(
    driven: Driven, phi: Numbers, P: Numbers, noise: Numbers, T: float, half: Numbers
) -> None:
    """Advance ``P`` by the transition and the disturbances; ``half`` becomes (P + T/2 R1) phi'."""
    n = states_of(driven)
    for g in range(len(driven)):
        P[driven[g], driven[g]] += 0.5 * T * noise[g] * noise[g]
    for i in range(n):
        for j in range(n):
            total = 0.0
            for k in range(n):
                total += P[i, k] * phi[j, k]
            half[i, j] = total
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for k in range(n):
                total += 0.5 * (phi[i, k] * half[k, j] + phi[j, k] * half[k, i])
            P[i, j] = total
            P[j, i] = total
    for g in range(len(driven)):
        P[driven[g], driven[g]] += 0.5 * T * noise[g] * noise[g]


@lean
def _advance(
    system: System,
    record: Numbers,
    k: int,
    kept: tuple[Numbers, Numbers],
    work: tuple[Numbers, Numbers, Numbers, Numbers, Numbers],
) -> None:
    """Advance the state and its derivatives from row ``k`` to the next by Runge and Kutta.

    ``work`` is a table, its rates, (5, n), (n, n) and (3, n, q).
    """
    x, S = kept
    states = states_of(system[4])
    table, rates, lines, own, many = work
    stage, rate, total, c = lines[0], lines[1], lines[2], lines[3]
    at, turn, sum_ = many[0], many[1], many[2]
    parts = int(record[k, PARTS])
    h = record[k, SECONDS] / parts
    for part in range(parts):
        total[:] = 0.0
        rate[:] = 0.0
        sum_[:] = 0.0
        turn[:] = 0.0
        for n in range(4):
            reach = STAGES[n] * h
            for i in range(states):
                stage[i] = x[i] + reach * rate[i]
                for j in range(S.shape[1]):
                    at[i, j] = S[i, j] + reach * turn[i, j]
            set_inputs(record, k, (part + STAGES[n]) / parts, c)
            set_rates(system, stage, c, table, rates)
            rate_slopes(system, (table, rates), stage, at, own, turn)
            set_derivative(system[4], stage, rates, rate)
            for i in range(states):
                total[i] += WEIGHTS[n] * rate[i]
                for j in range(S.shape[1]):
                    sum_[i, j] += WEIGHTS[n] * turn[i, j]
        for i in range(states):
            x[i] += h / 6.0 * total[i]
            for j in range(S.shape[1]):
                S[i, j] += h / 6.0 * sum_[i, j]


@lean
def _take_row(
    system: System,
    row: Numbers,
    kept: tuple[Numbers, Numbers],
    slopes: tuple[Numbers, Numbers],
    lines: Numbers,
    sums: tuple[Numbers, Numbers, Numbers],
) -> float:
    """Return what a row's readings add to -log L, after taking them.

    ``sums`` has innovations with their variances (n, 2), gradient and information.
    """
    values, driven = system[2], system[4]
    states, axes = states_of(driven), len(driven)
    errors = system[1].shape[0] + NONLINEAR + axes
    cost, first = 0.0, lines.shape[1] - axes - 2 * states
    for m in range(states):
        read = row[m if m < ROLL_RATE else m + BESIDE]
        sums[0][m, 0], sums[0][m, 1] = read - kept[0][m], math.nan
        if not math.isnan(read):
            variance = values[errors + m] * values[errors + m]
            moments = read - kept[0][m], kept[1][m, m] + variance
            for j in range(lines.shape[1]):
                lines[0, j] = -slopes[0][m, j]
                lines[1, j] = slopes[1][m, m, j]
            if first >= 0:
                lines[1, first + axes + m] += 2.0 * variance
            square = moments[0] * moments[0] / moments[1]
            cost += 0.5 * (math.log(2.0 * math.pi * moments[1]) + square)
            sums[0][m, 1] = moments[1]
            count_reading(moments, lines[0], lines[1], sums[1], sums[2])
            take_slopes(driven, m, moments, kept, slopes, lines)
    return cost


@lean
def _predict(
    system: System,
    record: Numbers,
    k: int,
    kept: tuple[Numbers, Numbers],
    slopes: tuple[Numbers, Numbers],
    work: tuple[tuple[Numbers, ...], tuple[Numbers, ...], tuple[Numbers, ...]],
) -> None:
    """Advance the covariance and its derivatives from row ``k`` to the next."""
    (table, rates), (A, phi, half, short), (dA, dphi, turned) = work
    terms, values, free, driven = system[1], system[2], system[3], system[4]
    first = terms.shape[0] + NONLINEAR
    noise, T, c = values[first:], record[k, SECONDS], short[4]
    set_inputs(record, k, 0.5, c)
    set_rates(system, kept[0], c, table, rates)
    set_jacobian(driven, rates, A)
    if slopes[0].shape[1] > 0:
        matrix_slopes(driven, rates, slopes[0], dA)
        own_slopes(system, (table, rates), kept[0], short, dA)
    transition_slopes(driven, A, dA, T, (phi, dphi), (half, turned))
    _spread(driven, phi, kept[1], noise, T, half)
    spread_slopes(driven, (phi, dphi), half, slopes[1], (turned, dA))
    if slopes[0].shape[1] > 0:
        noise_slopes(driven, phi, noise, T, free.shape[0], slopes[1])


@kernel
def filter_record(
    system: System, record: Numbers, errors: Numbers, gradient: Numbers, information: Numbers
) -> float:
    """Return -log L of a record, infinite where the filter loses the ship.

    Innovations and their variances go to ``errors`` (rows, n, 2). ``gradient`` (q,) and the lower
    half of ``information`` (q, q) gain theirs; q may be 0.
    """
    count, n = gradient.size, states_of(system[4])
    x = system[2][system[2].size - n :].copy()
    P, S, dP = np.zeros((n, n)), np.zeros((n, count)), np.zeros((n, n, count))
    for i in range(n if count > 0 else 0):
        S[i, count - n + i] = 1.0
    wide, narrow = (SECOND, FIRST) if count > 0 else (4, 1)
    rows, places = rows_of(system[1]), 3 if n <= ROLL else PLACES
    sloped = np.empty((rows, wide)), np.empty((places, wide))
    flat, rates = np.empty((rows, narrow)), np.empty((places, narrow))
    small = np.empty((n, n)), np.empty((n, n)), np.empty((n, n)), np.empty((5, n))
    large = np.empty((n, n, count)), np.empty((n, n, count)), np.empty((n, n, count))
    lines, many, cost = np.empty((2 + n, count)), np.empty((3, n, count)), 0.0
    for k in range(record.shape[0]):
        sums = errors[k], gradient, information
        cost += _take_row(system, record[k], (x, P), (S, dP), lines, sums)
        if not is_ship(x):
            return math.inf
        if k + 1 < record.shape[0]:
            _predict(system, record, k, (x, P), (S, dP), (sloped, small, large))
            _advance(system, record, k, (x, S), (flat, rates, small[3], small[0], many))
            if not is_ship(x):
                return math.inf
    return cost if math.isfinite(cost) else math.inf


@kernel
def sail_record(system: System, record: Numbers, out: Numbers) -> int:
    """Write the states (rows, n) by inputs alone; return for how many rows."""
    n = states_of(system[4])
    x, S = system[2][system[2].size - n :].copy(), np.empty((n, 0))
    many, own = np.empty((3, n, 0)), np.empty((n, n))
    rows, places = rows_of(system[1]), 3 if n <= ROLL else PLACES
    work = np.empty((rows, 1)), np.empty((places, 1)), np.empty((5, n)), own, many
    for k in range(record.shape[0]):
        for i in range(n):
            out[k, i] = x[i]
        if not is_ship(x):
            return k
        if k + 1 < record.shape[0]:
            _advance(system, record, k, (x, S), work)
    return int(record.shape[0])

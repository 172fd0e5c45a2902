"""The likelihood of a ship's record by the extended Kalman filter.

States are u, v [m/s], r [rad/s] and heading [rad], readings the same. A row of the ``record`` has
the readings, NaN where there is none, then rudder, revolutions and wind, then the seconds to the
next row and the steps of Runge and Kutta in them. ``values`` are the factors of the terms, the five
nonlinear coefficients, three disturbances and four errors of readings as standard deviations, and
the first state, which is known: its covariance is nothing.
"""

import math
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import kernel, lean
from trainer.identify.kernels.ship_forces import (
    NONLINEAR,
    ROWS,
    Terms,
    add_terms,
    set_jacobian,
    set_terms,
)

INPUTS: Final = 4  # the first column of them
SECONDS: Final = 8
PARTS: Final = 9
SLOWEST: Final = 0.01  # [m/s] a ship that is slower, faster or turns faster is no ship
FASTEST: Final = 1000.0
TURNING: Final = 10.0  # [rad/s]
STAGES: Final = (0.0, 0.5, 0.5, 1.0)
WEIGHTS: Final = (1.0, 2.0, 2.0, 1.0)


@lean
def is_ship(x: Numbers) -> bool:
    """Return whether a state is that of a ship under way."""
    return (
        x[0] >= SLOWEST and abs(x[0]) <= FASTEST and abs(x[1]) <= FASTEST and abs(x[2]) <= TURNING
    )


@lean
def set_inputs(record: Numbers, k: int, part: float, c: Numbers) -> None:
    """Write the inputs ``part`` of the way from row ``k`` to the next."""
    for i in range(4):
        now, then = record[k, INPUTS + i], record[k + 1, INPUTS + i]
        c[i] = now + part * (then - now)


@lean
def _take(m: int, reading: float, variance: float, x: Numbers, P: Numbers) -> float:
    """Return the innovation's variance after taking one reading into ``x`` and ``P``."""
    error, s = reading - x[m], P[m, m] + variance
    p = (P[0, m], P[1, m], P[2, m], P[3, m])
    for i in range(4):
        x[i] += p[i] / s * error
        for j in range(4):
            P[i, j] -= p[i] * p[j] / s
    return s


@lean
def transition(A: Numbers, T: float, out: Numbers, half: Numbers) -> None:
    """Write I + TA(I + TA/2(I + TA/3(I + TA/4)))."""
    for i in range(4):
        for j in range(4):
            out[i, j] = 1.0 if i == j else 0.0
    for order in range(4, 0, -1):
        for i in range(4):
            for j in range(4):
                total = 0.0
                for k in range(4):
                    total += A[i, k] * out[k, j]
                half[i, j] = total * T / order
        for i in range(4):
            for j in range(4):
                out[i, j] = half[i, j] + (1.0 if i == j else 0.0)


@lean
def spread(phi: Numbers, P: Numbers, noise: Numbers, T: float, half: Numbers) -> None:
    """Advance ``P`` by the transition and the disturbances; ``half`` becomes (P + T/2 R1) phi'."""
    for i in range(4):
        for j in range(4):
            total = 0.0
            for k in range(4):
                own = 0.5 * T * noise[i] * noise[i] if i == k and i < 3 else 0.0
                total += (P[i, k] + own) * phi[j, k]
            half[i, j] = total
    for i in range(4):
        for j in range(i + 1):
            total = 0.0
            for k in range(4):
                total += 0.5 * (phi[i, k] * half[k, j] + phi[j, k] * half[k, i])
            P[i, j] = total
            P[j, i] = total
        if i < 3:
            P[i, i] += 0.5 * T * noise[i] * noise[i]


@lean
def _rate(
    ship: Numbers,
    terms: Terms,
    values: Numbers,
    x: Numbers,
    c: Numbers,
    work: tuple[Numbers, Numbers],
) -> None:
    """Write the accelerations to the second array of ``work``."""
    count = terms.shape[0]
    set_terms(work[0], ship, x, c, values[count : count + NONLINEAR])
    add_terms(work[0], terms, values, ship[0], work[1])


@lean
def _advance(
    system: tuple[Numbers, Terms, Numbers],
    record: Numbers,
    k: int,
    x: Numbers,
    work: tuple[Numbers, Numbers, Numbers],
) -> None:
    """Advance a state to the next row by Runge and Kutta; ``work[2]`` (4, 4) is scratch."""
    parts = int(record[k, PARTS])
    h = record[k, SECONDS] / parts
    stage, rate, total, c = work[2][0], work[2][1], work[2][2], work[2][3]
    for part in range(parts):
        for i in range(4):
            total[i] = 0.0
            rate[i] = 0.0
        for turn in range(4):
            for i in range(4):
                stage[i] = x[i] + STAGES[turn] * h * rate[i]
            set_inputs(record, k, (part + STAGES[turn]) / parts, c)
            _rate(system[0], system[1], system[2], stage, c, (work[0], work[1]))
            for i in range(3):
                rate[i] = work[1][i, 0]
            rate[3] = stage[2]
            for i in range(4):
                total[i] += WEIGHTS[turn] * rate[i]
        for i in range(4):
            x[i] += h / 6.0 * total[i]


@kernel
def filter_record(
    ship: Numbers, terms: Terms, values: Numbers, record: Numbers, errors: Numbers
) -> float:
    """Return -log L of a record. Innovations and their variances go to ``errors`` (n, 4, 2).

    The result is infinite where the filter loses the ship.
    """
    first = terms.shape[0] + NONLINEAR
    noise, x, P = values[first : first + 7], values[first + 7 :].copy(), np.zeros((4, 4))
    flat, sloped = np.empty((ROWS, 1)), np.empty((ROWS, 4))
    plain, rates = np.empty((3, 1)), np.empty((3, 4))
    A, phi, half, scratch = (
        np.empty((4, 4)),
        np.empty((4, 4)),
        np.empty((4, 4)),
        np.empty((4, 4)),
    )
    c = np.empty(4)
    cost = 0.0
    for k in range(record.shape[0]):
        for m in range(4):
            errors[k, m, 0] = record[k, m] - x[m]
            errors[k, m, 1] = math.nan
            if not math.isnan(record[k, m]):
                s = _take(m, record[k, m], noise[3 + m] * noise[3 + m], x, P)
                cost += 0.5 * (math.log(2.0 * math.pi * s) + errors[k, m, 0] * errors[k, m, 0] / s)
                errors[k, m, 1] = s
        if not is_ship(x):
            return math.inf
        if k + 1 < record.shape[0]:
            set_inputs(record, k, 0.5, c)
            _rate(ship, terms, values, x, c, (sloped, rates))
            set_jacobian(rates, A)
            transition(A, record[k, SECONDS], phi, half)
            spread(phi, P, noise, record[k, SECONDS], half)
            _advance((ship, terms, values), record, k, x, (flat, plain, scratch))
            if not is_ship(x):
                return math.inf
    return cost if math.isfinite(cost) else math.inf


@kernel
def sail_record(ship: Numbers, terms: Terms, values: Numbers, record: Numbers, out: Numbers) -> int:
    """Write the states (n, 4) by inputs alone; return for how many rows."""
    x = values[terms.shape[0] + NONLINEAR + 7 :].copy()
    flat, plain, scratch = np.empty((ROWS, 1)), np.empty((3, 1)), np.empty((4, 4))
    for k in range(record.shape[0]):
        for i in range(4):
            out[k, i] = x[i]
        if not is_ship(x):
            return k
        if k + 1 < record.shape[0]:
            _advance((ship, terms, values), record, k, x, (flat, plain, scratch))
    return int(record.shape[0])

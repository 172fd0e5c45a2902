"""The likelihood of a ship's record by the extended Kalman filter, with its derivatives.

The states are u, v [m/s], r [rad/s] and heading [rad]; a ship with roll also has roll rate [rad/s]
and roll [rad]. Each state has one reading. A row of the ``record`` has the first four readings (NaN
is a missing one), then rudder, revolutions and wind (two columns), then the seconds to the next row
and the number of Runge and Kutta's steps in them (below zero where the rudder stands until the next
row), then the readings of roll rate and roll.

``values`` of a system are the factors of the terms, the five nonlinear coefficients, the standard
deviations of the disturbances (one for each acceleration) and of the errors of readings, and the
first state. The first covariance is zero, because the first state is a parameter: a record cannot
tell a free first state and its covariance apart. ``extended_slopes`` defines the derivatives.
``ships/likelihood`` calls ``filter_record`` in a fit and ``sail_record`` to predict. The filter is
the extended one because the forces are not linear in the state: it is linearised about each
estimate.
"""

import math
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.ship.forces import (
    NONLINEAR_COUNT,
    PART_COUNT,
    ROLL_INDEX,
    ROLL_RATE_INDEX,
    DrivenStates,
    System,
    Terms,
    rows_of,
    states_of,
)
from trainer.boat.ship.forward_numbers import FIRST_COLUMNS, SECOND_COLUMNS
from trainer.boat.ship.motion import STAGE_TIMES, STAGE_WEIGHTS, is_ship, set_derivative, set_rates
from trainer.core.kernel import Numbers
from trainer.identify.kernels.extended_slopes import (
    Accelerations,
    Belief,
    Innovation,
    MatrixRoom,
    ReadingSlopes,
    count_reading,
    matrix_slopes,
    noise_slopes,
    own_slopes,
    rate_slopes,
    set_jacobian,
    spread_slopes,
    take_slopes,
    transition_slopes,
)
from trainer.identify.kernels.kernel import kernel, lean_kernel

# columns of a record's row, in the order of the module's docstring
FIRST_INPUT_COLUMN: Final = 4
STEP_COLUMN: Final = 8
PARTS_COLUMN: Final = 9
ROLL_COLUMN_OFFSET: Final = 6  # columns between the first four readings and those of roll
ERROR, VARIANCE = 0, 1  # columns of the innovations


class FilterSums(NamedTuple):
    """What the rows of a record add up to."""

    innovations: Numbers  # of one row, with their variances (n, 2)
    gradient: Numbers
    information: Numbers


class FilterRoom(NamedTuple):
    """Scratch of the filter: forward numbers, matrices, and the stages of Runge and Kutta."""

    sloped: Accelerations  # with second derivatives
    flat: Accelerations  # with those that the state's derivatives need
    matrices: MatrixRoom
    lines: ReadingSlopes
    inputs: Numbers
    stage: Numbers  # the state within a step
    rate: Numbers  # dx/dt there
    total: Numbers  # weighted sum of those rates
    S_stage: Numbers  # the same of the state's derivatives (n, q)
    S_rate: Numbers
    S_total: Numbers


@kernel
def _new_room(terms: Terms, n: int, count: int) -> FilterRoom:
    """Return scratch for ``n`` states and ``count`` parameters."""
    # without parameters the Jacobian needs slopes by u, v, r only (4), and the states values (1)
    wide, narrow = (SECOND_COLUMNS, FIRST_COLUMNS) if count > 0 else (4, 1)
    rows, parts = rows_of(terms), 3 if n <= ROLL_INDEX else PART_COUNT
    return FilterRoom(
        Accelerations(np.empty((rows, wide)), np.empty((parts, wide))),
        Accelerations(np.empty((rows, narrow)), np.empty((parts, narrow))),
        MatrixRoom(
            np.empty((n, n)),
            np.empty((n, n, count)),
            np.empty((n, n)),
            np.empty((n, n, count)),
            np.empty((n, n)),
            np.empty((n, n, count)),
            np.empty((n, n)),
        ),
        ReadingSlopes(np.empty(count), np.empty(count), np.empty((n, count))),
        np.empty(4),
        np.empty(n),
        np.empty(n),
        np.empty(n),
        np.empty((n, count)),
        np.empty((n, count)),
        np.empty((n, count)),
    )


@lean_kernel
def set_inputs(record: Numbers, k: int, part: float, c: Numbers) -> None:
    """Write the inputs ``part`` of the way from row ``k`` to the next."""
    following = k + 1
    for i in range(4):
        now, then = record[k, FIRST_INPUT_COLUMN + i], record[following, FIRST_INPUT_COLUMN + i]
        c[i] = now + part * (then - now)
    if record[k, PARTS_COLUMN] < 0.0:
        c[0] = record[k, FIRST_INPUT_COLUMN]


@lean_kernel
def _spread(
    driven: DrivenStates, phi: Numbers, P: Numbers, noise: Numbers, T: float, half: Numbers
) -> None:
    """Advance ``P`` by the transition and the disturbances; ``half`` becomes (P + T/2 R1) phi'."""
    n = states_of(driven)
    # half the disturbance comes before the transition and half after: the trapezoidal rule
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
            for k in range(n):  # the mean with its transpose keeps P symmetric in spite of rounding
                total += 0.5 * (phi[i, k] * half[k, j] + phi[j, k] * half[k, i])
            P[i, j] = total
            P[j, i] = total
    for g in range(len(driven)):
        P[driven[g], driven[g]] += 0.5 * T * noise[g] * noise[g]


@lean_kernel
def _advance(system: System, record: Numbers, k: int, estimate: Belief, room: FilterRoom) -> None:
    """Advance the state and its derivatives from row ``k`` to the next by Runge and Kutta."""
    x, S = estimate.x, estimate.S
    states = states_of(system.driven)
    stage, rate, total, c = room.stage, room.rate, room.total, room.inputs
    at, turn, sum_ = room.S_stage, room.S_rate, room.S_total
    parts = int(abs(record[k, PARTS_COLUMN]))
    h = record[k, STEP_COLUMN] / parts
    for part in range(parts):
        total[:] = 0.0
        rate[:] = 0.0
        sum_[:] = 0.0
        turn[:] = 0.0
        for n in range(4):
            reach = STAGE_TIMES[n] * h
            for i in range(states):
                stage[i] = x[i] + reach * rate[i]
                for j in range(S.shape[1]):
                    at[i, j] = S[i, j] + reach * turn[i, j]
            set_inputs(record, k, (part + STAGE_TIMES[n]) / parts, c)
            set_rates(system, stage, c, room.flat.table, room.flat.rates)
            rate_slopes(system, room.flat, stage, at, room.matrices.own, turn)
            set_derivative(system.driven, stage, room.flat.rates, rate)
            for i in range(states):
                total[i] += STAGE_WEIGHTS[n] * rate[i]
                for j in range(S.shape[1]):
                    sum_[i, j] += STAGE_WEIGHTS[n] * turn[i, j]
        for i in range(states):
            x[i] += h / 6.0 * total[i]
            for j in range(S.shape[1]):
                S[i, j] += h / 6.0 * sum_[i, j]


@lean_kernel
def _take_row(
    system: System, row: Numbers, estimate: Belief, lines: ReadingSlopes, sums: FilterSums
) -> float:
    """Return what a row's readings add to -log L, after taking them.

    Readings are taken one by one, which is exact because their errors are independent.
    """
    values, driven = system.values, system.driven
    states, axes = states_of(driven), len(driven)
    errors = system.terms.shape[0] + NONLINEAR_COUNT + axes
    cost, first = 0.0, lines.error.size - axes - 2 * states
    for m in range(states):
        read = row[m if m < ROLL_RATE_INDEX else m + ROLL_COLUMN_OFFSET]
        sums.innovations[m, ERROR] = read - estimate.x[m]
        sums.innovations[m, VARIANCE] = math.nan
        if not math.isnan(read):
            variance = values[errors + m] * values[errors + m]
            error, s = read - estimate.x[m], estimate.P[m, m] + variance
            for j in range(lines.error.size):
                lines.error[j] = -estimate.S[m, j]
                lines.variance[j] = estimate.dP[m, m, j]
            if first >= 0:  # there are parameters; d(s^2)/d(log s) = 2 s^2
                lines.variance[first + axes + m] += 2.0 * variance
            square = error * error / s
            cost += 0.5 * (math.log(2.0 * math.pi * s) + square)
            sums.innovations[m, VARIANCE] = s
            count_reading(Innovation(error, s), lines, sums.gradient, sums.information)
            take_slopes(driven, m, Innovation(error, s), estimate, lines)
    return cost


@lean_kernel
def _predict(system: System, record: Numbers, k: int, estimate: Belief, room: FilterRoom) -> None:
    """Advance the covariance and its derivatives from row ``k`` to the next."""
    accelerations, matrices, driven = room.sloped, room.matrices, system.driven
    first = system.terms.shape[0] + NONLINEAR_COUNT
    noise, T, c = system.values[first:], record[k, STEP_COLUMN], room.inputs
    set_inputs(record, k, 0.5, c)  # one Jacobian stands for the whole step: by its mean inputs
    set_rates(system, estimate.x, c, accelerations.table, accelerations.rates)
    set_jacobian(driven, accelerations.rates, matrices.A)
    if estimate.S.shape[1] > 0:
        matrix_slopes(driven, accelerations.rates, estimate.S, matrices.dA)
        own_slopes(system, accelerations, estimate.x, matrices.own, matrices.dA)
    transition_slopes(driven, T, matrices)
    _spread(driven, matrices.phi, estimate.P, noise, T, matrices.half)
    spread_slopes(driven, matrices, estimate.dP)
    if estimate.S.shape[1] > 0:
        noise_slopes(driven, matrices.phi, noise, T, system.free.shape[0], estimate.dP)


@kernel
def filter_record(
    system: System, record: Numbers, errors: Numbers, gradient: Numbers, information: Numbers
) -> float:
    """Return -log L of a record, infinite where the filter loses the ship.

    Writes innovations and their variances to ``errors`` (rows, n, 2). Adds the record's gradient to
    ``gradient`` (q,) and the lower half of its information to ``information`` (q, q). With q = 0
    the filter computes no derivatives.
    """
    count, n = gradient.size, states_of(system.driven)
    x = system.values[system.values.size - n :].copy()
    estimate = Belief(x, np.zeros((n, n)), np.zeros((n, count)), np.zeros((n, n, count)))
    for i in range(n if count > 0 else 0):
        estimate.S[i, count - n + i] = 1.0
    room, cost = _new_room(system.terms, n, count), 0.0
    for k in range(record.shape[0]):
        sums = FilterSums(errors[k], gradient, information)
        cost += _take_row(system, record[k], estimate, room.lines, sums)
        if not is_ship(x):
            return math.inf
        if k + 1 < record.shape[0]:
            # covariance first: its transition is linearised about the state before the step
            _predict(system, record, k, estimate, room)
            _advance(system, record, k, estimate, room)
            if not is_ship(x):
                return math.inf
    return cost if math.isfinite(cost) else math.inf


@kernel
def sail_record(system: System, record: Numbers, out: Numbers) -> int:
    """Write the states (rows, n) by inputs alone.

    Return in how many rows they are those of a ship under way.
    """
    n = states_of(system.driven)
    x = system.values[system.values.size - n :].copy()
    estimate = Belief(x, np.empty((n, n)), np.empty((n, 0)), np.empty((n, n, 0)))
    room = _new_room(system.terms, n, 0)
    for k in range(record.shape[0]):
        for i in range(n):
            out[k, i] = x[i]
        if not is_ship(x):
            return k
        if k + 1 < record.shape[0]:
            _advance(system, record, k, estimate, room)
    return int(record.shape[0])

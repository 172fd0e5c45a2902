"""The likelihood of a whole record, without what only its slopes need.

``fitting/likelihood`` calls it for each value of a search, so that it has to be fast. Arrays are as
in ``covariance_filter``. Readings are taken one by one, the last first, so that no matrix is
inverted. Each reading that is present counts by its error given those already taken, and J becomes
the covariance of the remaining rows given this reading. Only the lower half of J is kept, because J
is symmetric; the row of a reading that was taken stays as it was.

Once the covariance has settled the gain is constant. The filter is then a linear recursion, which
``_run_settled`` computes for many samples at a time.
"""

import math
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.covariance_filter import (
    Indices,
    SampledSystem,
    has_settled,
    predict_sample,
    run_length,
)
from trainer.identify.kernels.kernel import (
    clear_array,
    inline_kernel,
    kernel,
    lean_kernel,
    put_block,
    put_vector,
)

ABREAST_SAMPLES: Final = 64  # samples that a settled filter takes at a time
EIGENVALUE_SLACK: Final = 1e-9  # [-] below zero, that rounding may bring an eigenvalue
LOG_DETERMINANTS, SQUARES, SAMPLES, READINGS = 0, 1, 2, 3  # indices in the sums of a record


class FilterState(NamedTuple):
    """The state and its covariance."""

    z: Numbers
    P: Numbers


class FilterRoom(NamedTuple):
    """Scratch of the filter."""

    J: Numbers
    closed: Numbers  # matrix of the settled filter
    half: Numbers
    v: Numbers
    abreast: Numbers  # samples that a settled filter takes at a time


@inline_kernel
def _joint(mean: Numbers, noise: Numbers, P: Numbers, half: Numbers, J: Numbers) -> None:
    """Write the lower half of J = W_x P W_x' + Q; ``half`` (x,)."""
    for i in range(noise.shape[0]):
        for j in range(P.shape[0]):
            total = 0.0
            for k in range(P.shape[0]):
                total += mean[i, k] * P[k, j]
            half[j] = total
        for j in range(i + 1):
            total = noise[i, j]
            for k in range(P.shape[0]):
                total += half[k] * mean[j, k]
            J[i, j] = total


@inline_kernel
def _take(J: Numbers, index: int, error: float, v: Numbers) -> None:
    """Write ``J`` and ``v`` above the row ``index``, given the reading of that row."""
    inverse = 1.0 / J[index, index]
    for i in range(index):
        gain = J[index, i] * inverse
        v[i] += gain * error
        for j in range(i + 1):
            J[i, j] -= gain * J[index, j]


@inline_kernel
def _take_all(readings: Numbers, J: Numbers, v: Numbers, sums: Numbers) -> float:
    """Return the product of the variances of the readings that are there, after taking them.

    Adds the squares of their standardised errors, and their number, to ``sums``. The result is not
    a number if a variance is not positive.
    """
    product, count = 1.0, 0
    for back in range(readings.size):
        index = J.shape[0] - 1 - back
        error = readings[readings.size - 1 - back] - v[index]
        if not math.isnan(error):
            variance = J[index, index]
            if not variance > 0.0:
                return math.nan
            product *= variance
            sums[SQUARES] += error * error / variance
            count += 1
            _take(J, index, error, v)
    sums[SAMPLES] += count > 0
    sums[READINGS] += count
    return product


@inline_kernel
def _advance(J: Numbers, v: Numbers, z: Numbers, P: Numbers) -> None:
    """Write the next state to ``z`` and its covariance to ``P``."""
    for i in range(P.shape[0]):
        z[i] = v[i]
        for j in range(i + 1):
            P[i, j] = J[i, j]
            P[j, i] = J[i, j]


@inline_kernel
def _closed_filter(mean: Numbers, J: Numbers, states: int, out: Numbers) -> None:
    """Write the matrix of the settled filter.

    Its rows are (next x, error of unit variance), its columns (reading, u_old, u, 1, x). The first
    columns are in the order of the table, so that rows of the table can be multiplied as they are.
    """
    rows, columns = mean.shape
    first = out.shape[1] - states
    for i in range(rows):
        sign = 1.0 if i < states else -1.0
        for j in range(rows - states):
            out[i, j] = 1.0 if i == states + j else 0.0
        for j in range(states, columns):
            out[i, rows - states + j - states] = sign * mean[i, j]
        for j in range(states):
            out[i, first + j] = sign * mean[i, j]
    for back in range(rows - states):
        c = rows - 1 - back
        for i in range(c):
            gain = J[c, i] / J[c, c] if i < states else -J[c, i] / J[c, c]
            for j in range(out.shape[1]):
                out[i, j] += gain * out[c, j]
    for c in range(states, rows):
        width = math.sqrt(J[c, c])
        for j in range(out.shape[1]):
            out[c, j] /= width


@inline_kernel
def _turn_rows(table: Numbers, readings: int, out: Numbers) -> int:
    """Write rows of the table as columns of ``out``, up to the first that lacks a reading.

    Return the number of rows written. As columns, samples lie side by side for the inner loops.
    """
    count = min(table.shape[0], out.shape[1])
    for k in range(count):
        for j in range(table.shape[1]):
            out[j, k] = table[k, j]
        for j in range(readings):
            if math.isnan(table[k, j]):
                return k
    return count


@inline_kernel
def _drive(closed: Numbers, columns: Numbers, count: int, out: Numbers) -> None:
    """Write the part of states and errors that readings and inputs make, for ``count`` samples."""
    width = columns.shape[0]
    for i in range(closed.shape[0]):
        for k in range(count):
            out[i, k] = closed[i, width]
        for j in range(width):
            share = closed[i, j]
            for k in range(count):
                out[i, k] += share * columns[j, k]


@inline_kernel
def _run_states(closed: Numbers, first: int, z: Numbers, count: int, out: Numbers) -> None:
    """Advance the states, one sample after the other, and complete the first sample's errors.

    ``_add_squares`` completes the other errors, by the state before each, which ``out`` then has.
    """
    states = closed.shape[1] - first
    for i in range(states, closed.shape[0]):
        for j in range(states):
            out[i, 0] += closed[i, first + j] * z[j]
    for k in range(count):
        for i in range(states):
            for j in range(states):
                out[i, k] += closed[i, first + j] * z[j]
        for i in range(states):
            z[i] = out[i, k]


@inline_kernel
def _add_squares(
    closed: Numbers, first: int, count: int, out: Numbers, squares: Numbers, sums: Numbers
) -> None:
    """Add the squares of the errors of ``count`` samples to ``sums``."""
    states = closed.shape[1] - first
    for k in range(count):
        squares[k] = 0.0
    for i in range(states, closed.shape[0]):
        for j in range(states):
            share = closed[i, first + j]
            for k in range(1, count):
                out[i, k] += share * out[j, k - 1]
        for k in range(count):
            squares[k] += out[i, k] * out[i, k]
    for k in range(count):
        sums[SQUARES] += squares[k]


@inline_kernel
def _run_settled(
    closed: Numbers, table: Numbers, z: Numbers, abreast: Numbers, sums: Numbers
) -> int:
    """Return how many samples the settled filter takes until a reading is missing.

    Adds the squares of their errors to ``sums``, and advances ``z``. A state needs the one before,
    so states go one by one; all else is computed for ABREAST_SAMPLES at a time, which is faster.
    ``abreast`` is scratch.
    """
    width, rows = table.shape[1], closed.shape[0]
    first = width + 1
    columns, out, squares = abreast[:width], abreast[width : width + rows], abreast[width + rows]
    taken = 0
    while taken < table.shape[0]:
        count = _turn_rows(table[taken:], rows - closed.shape[1] + first, columns)
        if count == 0:
            break
        _drive(closed, columns, count, out)
        _run_states(closed, first, z, count, out)
        _add_squares(closed, first, count, out, squares, sums)
        taken += count
    return taken


@lean_kernel
def _filter(
    system: SampledSystem,
    table: Numbers,
    which: Indices,
    now: FilterState,
    room: FilterRoom,
    sums: Numbers,
) -> None:
    """Add the sums of the record to ``sums``, from the state ``now`` on."""
    mean, noise = system.mean, system.noise
    z, P = now.z, now.P
    J, half, v = room.J, room.half, room.v
    states, readings = half.size, v.size - half.size
    k = 0
    while k < table.shape[0]:
        W, row = mean[which[k]], table[k]
        for j in range(states, z.size - 1):
            z[j] = row[readings + j - states]
        predict_sample(W, z, v)
        _joint(W, noise[which[k]], P, half, J)
        before = sums[READINGS]
        determinant = math.log(_take_all(row[:readings], J, v, sums))
        sums[LOG_DETERMINANTS] += determinant
        if math.isnan(determinant):
            return
        # only with all readings is the covariance, and so the gain, that of the samples to come
        constant = sums[READINGS] - before == readings and has_settled(J, P)
        _advance(J, v, z, P)
        k += 1
        if constant and k < table.shape[0] and which[k] == which[k - 1]:
            _closed_filter(W, J, states, room.closed)
            settled = table[k : run_length(which, k)]
            taken = _run_settled(room.closed, settled, z, room.abreast, sums)
            sums[LOG_DETERMINANTS] += taken * determinant
            sums[SAMPLES] += taken
            sums[READINGS] += taken * readings
            k += taken


@kernel
def likelihood_sums(
    mean: Numbers, noise: Numbers, start: Numbers, table: Numbers, which: Indices, sums: Numbers
) -> None:
    """Write the sums of a record's likelihood to ``sums`` (4,).

    They are sum log det R, sum error' R^-1 error, and the number of samples and of readings. Once P
    has settled, the gain is kept until a reading is missing or the interval changes. The first sum
    is not a number where R is not positive definite.
    """
    states, rows = start.shape[0], noise.shape[1]
    z, P = np.ones(mean.shape[2]), np.empty((states, states))
    put_vector(start[:, 0], 0, z)
    put_block(start[:, 1:], 0, P)
    closed = np.empty((rows, table.shape[1] + 1 + states))
    abreast = np.empty((table.shape[1] + rows + 1, ABREAST_SAMPLES))
    room = FilterRoom(np.empty((rows, rows)), closed, np.empty(states), np.empty(rows), abreast)
    clear_array(sums)
    system = SampledSystem(mean, noise, start)
    _filter(system, table, which, FilterState(z, P), room, sums)


@inline_kernel
def _are_finite(numbers: Numbers) -> bool:
    """Return whether all numbers are finite."""
    total = 0.0  # zero times what is not finite is not zero: a sum without a branch
    for i in range(numbers.size):
        total += 0.0 * numbers.flat[i]
    return total == 0.0


@inline_kernel
def _factor(P: Numbers, factor: Numbers) -> bool:
    """Write the Cholesky factor of ``P`` scaled to a unit diagonal, plus EIGENVALUE_SLACK.

    Return whether the factor exists: then no eigenvalue of scaled ``P`` is below -EIGENVALUE_SLACK.
    """
    for i in range(P.shape[0]):
        for j in range(i + 1):
            width = math.sqrt(max(P[i, i], 1e-300)) * math.sqrt(max(P[j, j], 1e-300))
            total = P[i, j] / width + (EIGENVALUE_SLACK if i == j else 0.0)
            for k in range(j):
                total -= factor[i, k] * factor[j, k]
            if i > j:
                factor[i, j] = total / factor[j, j]
            elif total > 0.0:
                factor[i, i] = math.sqrt(total)
            else:
                return False
    return True


@kernel
def is_possible(mean: Numbers, noise: Numbers, start: Numbers) -> bool:
    """Return whether a system is finite and its first covariance positive semidefinite."""
    states = start.shape[0]
    P, factor = np.empty((states, states)), np.empty((states, states))
    for i in range(states):
        for j in range(states):
            P[i, j] = start[i, 1 + j]
    return _are_finite(mean) and _are_finite(noise) and _are_finite(start) and _factor(P, factor)

"""The likelihood of a whole record, without what only its slopes need.

Arrays are as in ``covariance_filter``. Readings are taken one by one, the last first. Each reading
that is there counts by its error given those before it, and J becomes that of the rest given it.
Only the lower half of J is there; the row of a reading that was taken stays as it was.
"""

import math

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.covariance_filter import Places, has_settled, predict, run_length
from trainer.identify.kernels.kernel import clear, kernel, lean, part, put, put_block


@part
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


@part
def _take(J: Numbers, place: int, error: float, v: Numbers) -> None:
    """Write ``J`` and ``v`` above the row ``place``, given the reading of that row."""
    inverse = 1.0 / J[place, place]
    for i in range(place):
        gain = J[place, i] * inverse
        v[i] += gain * error
        for j in range(i + 1):
            J[i, j] -= gain * J[place, j]


@part
def _take_all(readings: Numbers, J: Numbers, v: Numbers, sums: Numbers) -> float:
    """Return the product of the variances of the readings that are there, after taking them.

    ``sums`` gains their squares and their number. The result is not a number if a variance is not
    positive.
    """
    product, count = 1.0, 0
    for back in range(readings.size):
        place = J.shape[0] - 1 - back
        error = readings[readings.size - 1 - back] - v[place]
        if not math.isnan(error):
            variance = J[place, place]
            if not variance > 0.0:
                return math.nan
            product *= variance
            sums[1] += error * error / variance
            count += 1
            _take(J, place, error, v)
    sums[2] += count > 0
    sums[3] += count
    return product


@part
def _advance(J: Numbers, v: Numbers, z: Numbers, P: Numbers) -> None:
    """Write the next state to ``z`` and its covariance to ``P``."""
    for i in range(P.shape[0]):
        z[i] = v[i]
        for j in range(i + 1):
            P[i, j] = J[i, j]
            P[j, i] = J[i, j]


@part
def _closed_filter(mean: Numbers, J: Numbers, states: int, out: Numbers) -> None:
    """Write the matrix of the settled filter.

    Its rows are (x, error of unit variance), its columns (reading, u_old, u, 1, x); the first of
    them are those of the table.
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


@part
def _run_settled(closed: Numbers, table: Numbers, z: Numbers, v: Numbers, sums: Numbers) -> int:
    """Return how many samples the settled filter takes until a reading is missing.

    ``sums`` gains the squares of their errors, and ``z`` moves on.
    """
    width, rows = table.shape[1], closed.shape[0]
    states = closed.shape[1] - width - 1
    for k in range(table.shape[0]):
        for i in range(rows):
            total = closed[i, width]
            for j in range(width):
                total += closed[i, j] * table[k, j]
            # the state last: the processor does meanwhile what does not wait for it
            for j in range(states):
                total += closed[i, width + 1 + j] * z[j]
            v[i] = total
        square = 0.0
        for i in range(states, rows):
            square += v[i] * v[i]
        if math.isnan(square):
            return k
        sums[1] += square
        for i in range(states):
            z[i] = v[i]
    return int(table.shape[0])


@lean
def _filter(
    system: tuple[Numbers, Numbers],
    table: Numbers,
    which: Places,
    kept: tuple[Numbers, Numbers],
    work: tuple[Numbers, Numbers, Numbers, Numbers],
    sums: Numbers,
) -> None:
    """Add the sums of the record to ``sums``, from the state z and covariance P ``kept`` on."""
    mean, noise = system
    z, P = kept
    J, closed, half, v = work
    states, readings = half.size, v.size - half.size
    k = 0
    while k < table.shape[0]:
        W, row = mean[which[k]], table[k]
        for j in range(states, z.size - 1):
            z[j] = row[readings + j - states]
        predict(W, z, v)
        _joint(W, noise[which[k]], P, half, J)
        before = sums[3]
        determinant = math.log(_take_all(row[:readings], J, v, sums))
        sums[0] += determinant
        if math.isnan(determinant):
            return
        constant = sums[3] - before == readings and has_settled(J, P)
        _advance(J, v, z, P)
        k += 1
        if constant and k < table.shape[0] and which[k] == which[k - 1]:
            _closed_filter(W, J, states, closed)
            taken = _run_settled(closed, table[k : run_length(which, k)], z, v, sums)
            sums[0] += taken * determinant
            sums[2] += taken
            sums[3] += taken * readings
            k += taken


@kernel
def likelihood_sums(
    mean: Numbers, noise: Numbers, start: Numbers, table: Numbers, which: Places, sums: Numbers
) -> None:
    """Write the sums of a record's likelihood to ``sums`` (4,).

    They are sum log det R, sum error' R^-1 error, and the number of samples and of readings. Once P
    has settled, the gain is kept until a reading is missing or the interval changes. The first sum
    is not a number where R is not positive definite.
    """
    states, rows = start.shape[0], noise.shape[1]
    z, P = np.ones(mean.shape[2]), np.empty((states, states))
    put(start[:, 0], 0, z)
    put_block(start[:, 1:], 0, P)
    closed = np.empty((rows, table.shape[1] + 1 + states))
    work = np.empty((rows, rows)), closed, np.empty(states), np.empty(rows)
    clear(sums)
    _filter((mean, noise), table, which, (z, P), work, sums)

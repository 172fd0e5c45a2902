"""The prediction-error filter with covariances (MI 6.1), over a whole record.

States and readings of the next step are jointly Gaussian: v = W (x, u_old, u, 1) with covariance
J = W_x P W_x' + Q. Sweeping the readings that are there out of J leaves the covariance of the next
state, the gain and minus the inverse of R in the same matrix; readings that are not there are
not swept. So missing readings, correlated errors and readings integrated over the interval are
one case.

``mean`` (m, x+y, x+2u+1) and ``noise`` (m, x+y, x+y) are the sampled systems, ``which`` (n,) the
system that leads from each sample to the next, ``start`` (x, 1+x) is [x0 P0] and ``table``
(n, y+2u) has readings, old and new input; NaN is missing.
"""

import math

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.identify.kernels.blocks import Entries, clear, put, put_block
from trainer.identify.kernels.kernel import kernel

Places = NDArray[np.int64]
Mask = NDArray[np.bool_]

SETTLED = 1e-26  # [-] square of the relative change of P, below which it is taken as constant


@kernel
def joint(mean: Entries, noise: Entries, P: Entries, work: Entries, out: Entries) -> None:
    """Write J = W_x P W_x' + Q to ``out``; ``work`` (x+y, x)."""
    rows, states = work.shape
    for i in range(rows):
        for j in range(states):
            total = mean[i, 0] * P[0, j]
            for k in range(1, states):
                total += mean[i, k] * P[k, j]
            work[i, j] = total
    for i in range(rows):
        for j in range(i + 1):
            total = noise[i, j]
            for k in range(states):
                total += work[i, k] * mean[j, k]
            out[i, j] = total
            out[j, i] = total


@kernel
def predict(mean: Entries, z: Entries, out: Entries) -> None:
    """Write v = W z, the next state and the readings of this sample."""
    for i in range(out.size):
        total = mean[i, 0] * z[0]
        for j in range(1, z.size):
            total += mean[i, j] * z[j]
        out[i] = total


@kernel
def sweep(J: Entries, pivot: int) -> float:
    """Return the pivot after sweeping it out of the symmetric ``J``: its conditional variance."""
    d = J[pivot, pivot]
    inverse = 1.0 / d
    for i in range(J.shape[0]):
        if i != pivot:
            factor = J[i, pivot] * inverse
            for j in range(J.shape[0]):
                J[i, j] -= factor * J[pivot, j]
            J[i, pivot] = factor
    for i in range(J.shape[0]):
        J[pivot, i] = J[i, pivot]
    J[pivot, pivot] = -inverse
    return d


@kernel
def condition(J: Entries, error: Entries, there: Mask) -> float:
    """Return log det R [-] after sweeping the readings ``there`` out of ``J``.

    Gain and inverse of the others become zero, as does their ``error``; not a number if R is
    not positive definite.
    """
    first = J.shape[0] - error.size
    product = J[0, 0] * 0.0 + 1.0  # of the kind that J is
    for c in range(error.size):
        if there[c]:
            before = J[first + c, first + c].real
            d = sweep(J, first + c)
            if not d.real > 1e-14 * abs(before):
                return math.nan
            product *= d
    for c in range(error.size):
        if not there[c]:
            error[c] = 0.0
            for i in range(J.shape[0]):
                J[first + c, i] = 0.0
                J[i, first + c] = 0.0
    return np.log(product)


@kernel
def residual(row: Entries, v: Entries, error: Entries, there: Mask) -> int:
    """Return how many readings of ``row`` are there, after writing ``error`` and ``there``."""
    first = v.size - error.size
    count = 0
    for c in range(error.size):
        error[c] = row[c] - v[first + c]
        there[c] = not np.isnan(error[c])
        count += there[c]
    return count


@kernel
def square(J: Entries, error: Entries) -> float:
    """Return error' R^-1 error [-] from the swept ``J``."""
    first = J.shape[0] - error.size
    total = 0.0
    for i in range(error.size):
        for j in range(error.size):
            total -= error[i] * J[first + i, first + j] * error[j]
    return total


@kernel
def advance(J: Entries, v: Entries, error: Entries, z: Entries, P: Entries) -> None:
    """Write the next state to ``z`` and its covariance to ``P`` from the swept ``J``."""
    states = P.shape[0]
    for i in range(states):
        total = v[i]
        for c in range(error.size):
            total += J[i, states + c] * error[c]
        z[i] = total
        for j in range(states):
            P[i, j] = J[i, j]


@kernel
def settled(J: Numbers, P: Numbers) -> bool:
    """Return whether the covariance in the swept ``J`` is that in ``P``."""
    for i in range(P.shape[0]):
        for j in range(i + 1):
            change = J[i, j] - P[i, j]
            if change * change > SETTLED * abs(P[i, i] * P[j, j]):
                return False
    return True


@kernel
def _closed(mean: Numbers, J: Numbers, out: Numbers) -> None:
    """Write the settled filter's matrix: rows (x, error), columns (x, u_old, u, 1, y)."""
    rows, columns = mean.shape
    states = rows - (out.shape[1] - columns)
    for i in range(rows):
        for j in range(columns):
            out[i, j] = mean[i, j] if i < states else -mean[i, j]
            if i < states:
                for c in range(states, rows):
                    out[i, j] -= J[i, c] * mean[c, j]
        for c in range(states, rows):
            direct = 1.0 if i == c else 0.0
            out[i, columns + c - states] = J[i, c] if i < states else direct


@kernel
def _run_settled(closed: Numbers, table: Numbers, z: Numbers, errors: Numbers) -> int:
    """Return how many samples the settled filter takes until a reading is missing.

    ``errors`` (y, y) gains the lower half of their sum of error error', ``z`` moves on.
    """
    rows, readings = closed.shape[0], errors.shape[0]
    states, last = rows - readings, z.size - 1
    out, w = np.empty(rows), np.empty(closed.shape[1])
    put(z, 0, w)
    for k in range(table.shape[0]):
        for j in range(readings):
            w[last + 1 + j] = table[k, j]
        for j in range(last - states):
            w[states + j] = table[k, readings + j]
        predict(closed, w, out)
        missing = 0.0
        for i in range(states, rows):
            missing += out[i]
        if math.isnan(missing):
            return k
        for i in range(states):
            w[i] = z[i] = out[i]
        for i in range(readings):
            for j in range(i + 1):
                errors[i, j] += out[states + i] * out[states + j]
    return int(table.shape[0])


@kernel
def run_length(which: Places, first: int) -> int:
    """Return the end of the samples from ``first`` on that lead on by the same system."""
    k = first
    while k < which.size and which[k] == which[first]:
        k += 1
    return k


@kernel
def likelihood_sums(
    mean: Numbers, noise: Numbers, start: Numbers, table: Numbers, which: Places, sums: Numbers
) -> None:
    """Write sum log det R, sum error' R^-1 error, samples and readings counted to ``sums`` (4,).

    Once P has settled the gain is kept until a reading is missing or the interval changes.
    The first sum is not a number where R is not positive definite.
    """
    states, rows, columns = start.shape[0], noise.shape[1], mean.shape[2]
    readings = rows - states
    J, work = np.empty((rows, rows)), np.empty((rows, states))
    z, v, error = np.ones(columns), np.empty(rows), np.empty(readings)
    there, errors = np.empty(readings, np.bool_), np.empty((readings, readings))
    closed = np.empty((rows, columns + readings))
    P = np.empty((states, states))
    put_block(start[:, 1:], 0, P)
    put(start[:, 0], 0, z)
    clear(sums)
    k = 0
    while k < table.shape[0]:
        W = mean[which[k]]
        put(table[k, readings:], states, z)
        predict(W, z, v)
        joint(W, noise[which[k]], P, work, J)
        count = residual(table[k], v, error, there)
        determinant = condition(J, error, there)
        if math.isnan(determinant):
            sums[0] = math.nan
            return
        sums[0] += determinant
        sums[1] += square(J, error)
        sums[2] += count > 0
        sums[3] += count
        constant = count == readings and settled(J, P)
        advance(J, v, error, z, P)
        k += 1
        if constant and k < table.shape[0] and which[k] == which[k - 1]:
            _closed(W, J, closed)
            clear(errors)
            taken = _run_settled(closed, table[k : run_length(which, k)], z, errors)
            for i in range(readings):
                for j in range(i + 1):
                    twice = 1.0 if i == j else 2.0
                    sums[1] -= twice * errors[i, j] * J[states + i, states + j]
            sums[0] += taken * determinant
            sums[2] += taken
            sums[3] += taken * readings
            k += taken

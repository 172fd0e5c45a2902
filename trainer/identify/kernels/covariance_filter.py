"""The prediction-error filter with covariances (MI 6.1), over a whole record.

States and readings of the next step are jointly Gaussian: v = W (x, u_old, u, 1) with covariance J
= W_x P W_x' + Q. Sweeping the readings that are there out of J leaves the covariance of the next
state, the gain and minus the inverse of R in the same matrix. Missing readings are not swept. So
missing readings, correlated errors and readings integrated over the interval are one case.

``mean`` (m, x+y, x+2u+1) and ``noise`` (m, x+y, x+y) are the sampled systems. ``which`` (n,) is the
system that leads from each sample to the next. ``start`` (x, 1+x) is [x0 P0], and ``table`` (n,
y+2u) has readings, old and new input; NaN is missing.
"""

import math

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import Entries, part

Places = NDArray[np.int64]
Mask = NDArray[np.bool_]

SETTLED = 1e-26  # [-] square of the relative change of P, below which P is taken as constant


@part
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


@part
def predict(mean: Entries, z: Entries, out: Entries) -> None:
    """Write v = W z, the next state and the readings of this sample."""
    for i in range(out.size):
        total = mean[i, 0] * z[0]
        for j in range(1, z.size):
            total += mean[i, j] * z[j]
        out[i] = total


@part
def sweep(J: Entries, pivot: int) -> float:
    """Return the conditional variance of a pivot, after sweeping it out of symmetric ``J``."""
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


@part
def condition(J: Entries, error: Entries, there: Mask) -> float:
    """Return log det R [-] after sweeping the readings ``there`` out of ``J``.

    Gain and inverse of the others become zero, as does their ``error``. The result is not a number
    if R is not positive definite.
    """
    first = J.shape[0] - error.size
    product = J[0, 0] * 0.0 + 1.0  # of the same type as J
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


@part
def residual(row: Entries, v: Entries, error: Entries, there: Mask) -> int:
    """Return how many readings of ``row`` are there, after writing ``error`` and ``there``."""
    first = v.size - error.size
    count = 0
    for c in range(error.size):
        error[c] = row[c] - v[first + c]
        there[c] = not np.isnan(error[c])
        count += there[c]
    return count


@part
def square(J: Entries, error: Entries) -> float:
    """Return error' R^-1 error [-] from the swept ``J``."""
    first = J.shape[0] - error.size
    total = 0.0
    for i in range(error.size):
        for j in range(error.size):
            total -= error[i] * J[first + i, first + j] * error[j]
    return total


@part
def move(J: Entries, v: Entries, error: Entries, z: Entries) -> None:
    """Write the next state to ``z`` by the gain in the swept ``J``."""
    states = J.shape[0] - error.size
    for i in range(states):
        total = v[i]
        for c in range(error.size):
            total += J[i, states + c] * error[c]
        z[i] = total


@part
def advance(J: Entries, v: Entries, error: Entries, z: Entries, P: Entries) -> None:
    """Write the next state to ``z`` and its covariance to ``P`` from the swept ``J``."""
    move(J, v, error, z)
    for i in range(P.shape[0]):
        for j in range(P.shape[0]):
            P[i, j] = J[i, j]


@part
def all_there(there: Mask) -> bool:
    """Return whether no reading is missing."""
    missing = 0
    for c in range(there.size):
        missing += not there[c]
    return missing == 0


@part
def has_settled(J: Numbers, P: Numbers) -> bool:
    """Return whether the covariance in the swept ``J`` is that in ``P``."""
    for i in range(P.shape[0]):
        for j in range(i + 1):
            change = J[i, j] - P[i, j]
            if change * change > SETTLED * abs(P[i, i] * P[j, j]):
                return False
    return True


@part
def run_length(which: Places, first: int) -> int:
    """Return the end of the samples from ``first`` on with the same system.

    That system leads from each of them to the next.
    """
    k = first
    while k < which.size and which[k] == which[first]:
        k += 1
    return k

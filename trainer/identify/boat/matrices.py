"""Roots and inverses of covariances, with the same bits at any number of threads.

Those of LAPACK depend on how many threads its library takes. [Hig] Higham, Accuracy and Stability
of Numerical Algorithms (2002), ch. 10: Cholesky's method, with pivots for a singular matrix.
"""

import math
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import kernel

MIN_PIVOT: Final = 1e-9  # [-] of the largest diagonal entry: less is what rounding leaves


@kernel
def root_of_covariance(matrix: Numbers) -> Numbers:
    """Return R with R R' = ``matrix`` (n, n), which may be singular."""
    n = matrix.shape[0]
    rest, root = matrix.copy(), np.zeros((n, n))
    least = 0.0
    for column in range(n):
        pivot = 0
        for i in range(n):
            if rest[i, i] > rest[pivot, pivot]:
                pivot = i
        least = MIN_PIVOT * rest[pivot, pivot] if column == 0 else least
        if not rest[pivot, pivot] > least:
            break
        scale = math.sqrt(rest[pivot, pivot])
        for i in range(n):
            root[i, column] = rest[i, pivot] / scale
        for i in range(n):
            for j in range(n):
                rest[i, j] -= root[i, column] * root[j, column]
    return root


@kernel
def invert_positive(matrix: Numbers) -> Numbers:
    """Return the inverse of a positive matrix (n, n)."""
    n = matrix.shape[0]
    root, inverse, whole = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    for j in range(n):  # the lower root
        for i in range(j, n):
            total = matrix[i, j]
            for k in range(j):
                total -= root[i, k] * root[j, k]
            root[i, j] = math.sqrt(total) if i == j else total / root[j, j]
    for j in range(n):  # its inverse
        inverse[j, j] = 1.0 / root[j, j]
        for i in range(j + 1, n):
            total = 0.0
            for k in range(j, i):
                total -= root[i, k] * inverse[k, j]
            inverse[i, j] = total / root[i, i]
    for i in range(n):
        for j in range(i + 1):
            total = 0.0
            for k in range(i, n):
                total += inverse[k, i] * inverse[k, j]
            whole[i, j] = total
            whole[j, i] = total
    return whole

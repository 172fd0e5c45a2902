"""Predictors with a given gain, the gain of a settled filter, and longer predictions.

Model document, 6.2 and 6.4. Arrays are complex: an imaginary step of 1e-100 in one parameter
carries its exact derivative into errors and losses.
"""

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.covariance_filter import (
    Places,
    advance,
    condition,
    joint,
    predict,
    residual,
    square,
)
from trainer.identify.kernels.kernel import kernel
from trainer.identify.kernels.sampling import Complexes


@kernel
def run_with_gain(
    mean: Complexes,
    gain: Complexes,
    first: Complexes,
    table: Numbers,
    which: Places,
    errors: Complexes,
) -> None:
    """Write the errors (n, y) of a predictor with a given gain.

    It is x <- A x + B u + K error; the error of a missing reading is not a number. ``mean`` (m,
    x+y, columns), ``gain`` (x, y), ``first`` (x,).
    """
    states, readings = gain.shape
    columns = mean.shape[2]
    z, v = np.ones(columns, np.complex128), np.empty(states + readings, np.complex128)
    z[:states] = first
    for k in range(table.shape[0]):
        for j in range(states, columns - 1):
            z[j] = table[k, readings + j - states]
        predict(mean[which[k]], z, v)
        for c in range(readings):
            errors[k, c] = table[k, c] - v[states + c]
        for i in range(states):
            z[i] = v[i]
            for c in range(readings):
                if not np.isnan(errors[k, c]):
                    z[i] += gain[i, c] * errors[k, c]


@kernel
def _change(J: Complexes, P: Complexes) -> float:
    """Return the relative change of P: ||new P - P|| / ||new P|| [-], Frobenius.

    Imaginary parts are compared with their own size.
    """
    moved, size, moved_aside, aside = 0.0, 0.0, 0.0, 0.0
    for i in range(P.shape[0]):
        for j in range(P.shape[0]):
            d = J[i, j] - P[i, j]
            moved += d.real * d.real
            size += J[i, j].real * J[i, j].real
            # derivatives times 1e-100, so scaled before they are squared
            moved_aside += (d.imag * 1e100) * (d.imag * 1e100)
            aside += (J[i, j].imag * 1e100) * (J[i, j].imag * 1e100)
    worst = moved / size if size > 0.0 else 0.0
    if aside > 0.0:
        worst = max(worst, moved_aside / aside)
    return float(np.sqrt(worst))


@kernel
def settle(
    mean: Complexes, noise: Complexes, P: Complexes, tolerance: float, most: int, gain: Complexes
) -> int:
    """Return how many steps the filter took to settle.

    0 if it did not settle within ``most`` steps, -1 if R is not positive definite. The last
    ``gain`` (x, y) and its ``P`` are written.
    """
    rows, states = mean.shape[0], P.shape[0]
    readings = rows - states
    J = np.empty((rows, rows), np.complex128)
    work = np.empty((rows, states), np.complex128)
    error, there = np.zeros(readings, np.complex128), np.ones(readings, np.bool_)
    for step in range(1, most + 1):
        joint(mean, noise, P, work, J)
        determinant = condition(J, error, there)
        if np.isnan(determinant):
            return -1
        change = _change(J, P)
        for i in range(states):
            for c in range(readings):
                gain[i, c] = J[i, states + c]
            for j in range(states):
                P[i, j] = J[i, j]
        if change <= tolerance:
            return step
    return 0


@kernel
def _look_ahead(
    system: tuple[Complexes, Complexes],
    table: Numbers,
    which: Places,
    steps: tuple[int, int],
    begin: tuple[Complexes, Complexes],
    sums: Complexes,
) -> int:
    """Return how many predictions were added to ``sums`` from ``begin``, -1 on failure.

    ``begin`` is z and P before the first row of ``table``; neither is changed. The first of the
    ``steps`` counted is steps[0], the last steps[1].
    """
    mean, noise = system
    z, P = begin[0].copy(), begin[1].copy()
    rows, states = mean.shape[1], P.shape[0]
    readings = rows - states
    J = np.empty((rows, rows), np.complex128)
    work, v = np.empty((rows, states), np.complex128), np.empty(rows, np.complex128)
    error, there = np.empty(readings, np.complex128), np.empty(readings, np.bool_)
    added = 0
    for ahead in range(1, min(steps[1], table.shape[0]) + 1):
        k = ahead - 1
        for j in range(states, z.size - 1):
            z[j] = table[k, readings + j - states]
        predict(mean[which[k]], z, v)
        joint(mean[which[k]], noise[which[k]], P, work, J)
        for i in range(states):
            z[i] = v[i]
            for j in range(states):
                P[i, j] = J[i, j]
        count = residual(table[k], v, error, there)
        if ahead < steps[0] or count == 0:
            continue
        determinant = condition(J, error, there)
        if np.isnan(determinant):
            return -1
        sums[0] += determinant + square(J, error)
        sums[1] += count
        added += 1
    return added


@kernel
def multi_step(
    system: tuple[Complexes, Complexes],
    start: Complexes,
    table: Numbers,
    which: Places,
    steps: tuple[int, int],
    sums: Complexes,
) -> int:
    """Return how many predictions of ``steps`` samples count, -1 on failure (MI 6.4).

    ``system`` is mean and noise. ``sums`` (2,) gets log det R + error' R^-1 error, and readings.
    """
    mean, noise = system
    rows, columns, states = mean.shape[1], mean.shape[2], start.shape[0]
    readings = rows - states
    J = np.empty((rows, rows), np.complex128)
    work, v = np.empty((rows, states), np.complex128), np.empty(rows, np.complex128)
    error, there = np.empty(readings, np.complex128), np.empty(readings, np.bool_)
    z, P = np.ones(columns, np.complex128), start[:, 1:].copy()
    z[:states] = start[:, 0]
    sums[:] = 0.0
    total = 0
    for k in range(table.shape[0]):
        added = _look_ahead(system, table[k:], which[k:], steps, (z, P), sums)
        if added < 0:
            return -1
        total += added
        for j in range(states, columns - 1):
            z[j] = table[k, readings + j - states]
        predict(mean[which[k]], z, v)
        joint(mean[which[k]], noise[which[k]], P, work, J)
        residual(table[k], v, error, there)
        condition(J, error, there)
        advance(J, v, error, z, P)
    return total

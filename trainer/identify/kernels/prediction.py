"""Filters and predictors shown sample by sample; the gain of a settled filter.

Model document, 6.2, 6.4 and 6.5. Arrays may be complex: an imaginary step of 1e-100 in one
parameter carries its exact derivative into all that is shown.
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
from trainer.identify.kernels.kernel import Entries, kernel, put
from trainer.identify.kernels.sampling import Complexes

COUNTED, MISSING, REJECTED, SINGULAR = 0.0, 1.0, 2.0, 3.0


@kernel
def show(
    system: tuple[Entries, Entries, Entries],
    table: Numbers,
    which: Places,
    limits: Numbers,
    shown: tuple[Entries, Entries, Entries],
) -> None:
    """Write to each row of ``shown`` state, prediction, error, error' R^-1 error, flag.

    ``system`` is mean, noise and start. A sample is rejected if its error' R^-1 error is beyond
    ``limits`` (y+1,) for its number of readings: it neither moves the filter nor counts. The
    other arrays ``shown`` get P (n, x, x) of the state, and R (n, y, y), of missing readings too.
    """
    mean, noise, start = system
    told, covariances, spreads = shown
    rows, columns, states = mean.shape[1], mean.shape[2], start.shape[0]
    readings = rows - states
    J, kept = np.empty((rows, rows), mean.dtype), np.empty((rows, rows), mean.dtype)
    work, v = np.empty((rows, states), mean.dtype), np.empty(rows, mean.dtype)
    error, there = np.empty(readings, mean.dtype), np.empty(readings, np.bool_)
    z, P = np.ones(columns, mean.dtype), start[:, 1:].copy()
    z[:states] = start[:, 0]
    for k in range(table.shape[0]):
        put(table[k, readings:], states, z)
        predict(mean[which[k]], z, v)
        joint(mean[which[k]], noise[which[k]], P, work, J)
        kept[:] = J
        count = residual(table[k], v, error, there)
        told[k, :states] = z[:states]
        told[k, states:rows] = v[states:]
        told[k, rows : rows + readings] = error
        covariances[k] = P
        spreads[k] = J[states:, states:]
        flag = COUNTED if count > 0 else MISSING
        told[k, rows + readings] = 0.0
        if np.isnan(condition(J, error, there)):
            flag = SINGULAR
        else:
            size = square(J, error)
            told[k, rows + readings] = size
            if size.real > limits[count]:
                flag = REJECTED
        if flag > MISSING:
            J[:] = kept
            there[:] = False
            condition(J, error, there)
        advance(J, v, error, z, P)
        told[k, rows + readings + 1] = flag


@kernel
def run_predictor(
    system: tuple[Entries, Entries, Entries],
    table: Numbers,
    which: Places,
    driven: Numbers,
    out: Entries,
) -> None:
    """Write states and predictions (n, x+y) of a predictor with a given gain to ``out``.

    It is x <- A x + B u + K error + w; a missing reading moves nothing. ``system`` is mean, gain
    (x, y) and first state (x,), and ``driven`` (n, x) is w.
    """
    mean, gain, first = system
    states, readings = gain.shape
    z, v = np.ones(mean.shape[2], mean.dtype), np.empty(states + readings, mean.dtype)
    put(first, 0, z)
    for k in range(table.shape[0]):
        put(table[k, readings:], states, z)
        predict(mean[which[k]], z, v)
        put(z[:states], 0, out[k])
        put(v[states:], states, out[k])
        for i in range(states):
            z[i] = v[i] + driven[k, i]
            for c in range(readings):
                if not np.isnan(table[k, c]):
                    z[i] += gain[i, c] * (table[k, c] - v[states + c])


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

"""The filter shown sample by sample, outliers kept out (MI 6.5), and the model alone."""

import math

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
from trainer.identify.kernels.kernel import kernel, put

COUNTED, MISSING, REJECTED, SINGULAR = 0.0, 1.0, 2.0, 3.0


@kernel
def show(
    system: tuple[Numbers, Numbers, Numbers],
    table: Numbers,
    which: Places,
    limits: Numbers,
    shown: Numbers,
    spreads: Numbers,
) -> None:
    """Write to each row of ``shown`` state, prediction, error, error' R^-1 error, flag.

    ``system`` is mean, noise and start. A sample is rejected if its error' R^-1 error is beyond
    ``limits`` (y+1,) for its number of readings: it neither moves the filter nor counts.
    ``spreads`` (n, y, y) is R, of missing readings too.
    """
    mean, noise, start = system
    rows, columns, states = mean.shape[1], mean.shape[2], start.shape[0]
    readings = rows - states
    J, kept = np.empty((rows, rows)), np.empty((rows, rows))
    work, v, error = np.empty((rows, states)), np.empty(rows), np.empty(readings)
    there = np.empty(readings, np.bool_)
    z, P = np.ones(columns), start[:, 1:].copy()
    z[:states] = start[:, 0]
    for k in range(table.shape[0]):
        z[states : columns - 1] = table[k, readings:]
        predict(mean[which[k]], z, v)
        joint(mean[which[k]], noise[which[k]], P, work, J)
        kept[:] = J
        count = residual(table[k], v, error, there)
        shown[k, :states] = z[:states]
        shown[k, states:rows] = v[states:]
        shown[k, rows : rows + readings] = error
        spreads[k] = J[states:, states:]
        flag = COUNTED if count > 0 else MISSING
        size = 0.0
        if math.isnan(condition(J, error, there)):
            flag = SINGULAR
        else:
            size = square(J, error)
            if size > limits[count]:
                flag = REJECTED
        if flag > MISSING:
            J[:] = kept
            there[:] = False
            condition(J, error, there)
        advance(J, v, error, z, P)
        shown[k, rows + readings] = size
        shown[k, rows + readings + 1] = flag


@kernel
def simulate(
    mean: Numbers, first: Numbers, inputs: Numbers, which: Places, noise: Numbers, out: Numbers
) -> None:
    """Write states and readings (n, x+y) to ``out``.

    ``first`` (x,), ``inputs`` (n, 2u) old and new, ``noise`` (n, x+y) of the next state and of the
    reading. The state in ``out`` is that at the sample.
    """
    rows, columns = mean.shape[1:]
    states = first.size
    z, v = np.ones(columns), np.empty(rows)
    put(first, 0, z)
    for k in range(which.size):
        put(inputs[k], states, z)
        predict(mean[which[k]], z, v)
        for i in range(states):
            out[k, i] = z[i]
            z[i] = v[i] + noise[k, i]
        for i in range(states, rows):
            out[k, i] = v[i] + noise[k, i]

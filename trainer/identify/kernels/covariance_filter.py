"""The prediction-error filter with covariances (MI 6.1), over a whole record.

The next state and this sample's readings are jointly Gaussian: v = W (x, u_old, u, 1), with the
covariance J = W_x P W_x' + Q. The sweep operator (Gauss and Jordan's elimination in place) on the
rows of the readings leaves in J the covariance of the next state, the gain, and minus the inverse
of R. A missing reading is not swept. So missing readings, correlated errors and readings integrated
over the interval need no code of their own.

``mean`` (m, x+y, x+2u+1) and ``noise`` (m, x+y, x+y) are the sampled systems. ``which`` (n,) is the
system that leads from each sample to the next. ``start`` (x, 1+x) is [x0 P0], and ``table`` (n,
y+2u) has readings, old and new input; NaN is missing. All may be complex, because an imaginary step
of 1e-100 in one parameter carries its exact derivative into the results.

Here are the parts of a step, the filter and other predictors sample by sample (MI 6.2, 6.4, 6.5).
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import Entries, inline_kernel, kernel, put_vector

Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

FLAG_COUNTED, FLAG_MISSING, FLAG_REJECTED, FLAG_SINGULAR = 0.0, 1.0, 2.0, 3.0  # flags of samples
COVARIANCE_TOLERANCE = (
    1e-26  # [-] square of the relative change of P, below which P is taken as constant
)


class SampledSystem(NamedTuple):
    """Systems from sample to sample, and their start; or the slopes of these.

    The module's docstring has the shapes.
    """

    mean: Entries
    noise: Entries
    start: Entries


class FixedGain(NamedTuple):
    """A predictor whose gain is given."""

    mean: Entries
    gain: Entries  # (x, y)
    first: Entries  # state (x,)


class FilterRun(NamedTuple):
    """The results of a filter, sample by sample."""

    rows: Entries  # state, prediction, error, error' R^-1 error, flag
    covariances: Entries  # P (n, x, x)
    spreads: Entries  # R (n, y, y)


@inline_kernel
def write_joint(mean: Entries, noise: Entries, P: Entries, work: Entries, out: Entries) -> None:
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


@inline_kernel
def predict_sample(mean: Entries, z: Entries, out: Entries) -> None:
    """Write v = W z, the next state and the readings of this sample."""
    for i in range(out.size):
        total = mean[i, 0] * z[0]
        for j in range(1, z.size):
            total += mean[i, j] * z[j]
        out[i] = total


@inline_kernel
def sweep_pivot(J: Entries, pivot: int) -> float:
    """Return the conditional variance of a pivot, after sweeping it out of symmetric ``J``.

    What is left of J is the covariance of the other rows, given that one.
    """
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


@inline_kernel
def condition_on_readings(J: Entries, error: Entries, there: Mask) -> float:
    """Return log det R [-] after sweeping the readings ``there`` out of ``J``.

    For missing readings gain, inverse and ``error`` become zero, so that sums may run over all
    readings. The result is not a number if R is not positive definite.
    """
    first = J.shape[0] - error.size
    product = J[0, 0] * 0.0 + 1.0  # of the same type as J
    for c in range(error.size):
        if there[c]:
            before = J[first + c, first + c].real
            d = sweep_pivot(J, first + c)
            if not d.real > 1e-14 * abs(before):  # what is left of the variance is rounding
                return math.nan
            product *= d
    for c in range(error.size):
        if not there[c]:
            error[c] = 0.0
            for i in range(J.shape[0]):
                J[first + c, i] = 0.0
                J[i, first + c] = 0.0
    return np.log(product)


@inline_kernel
def write_residual(row: Entries, v: Entries, error: Entries, there: Mask) -> int:
    """Return how many readings of ``row`` are there, after writing ``error`` and ``there``."""
    first = v.size - error.size
    count = 0
    for c in range(error.size):
        error[c] = row[c] - v[first + c]
        there[c] = not np.isnan(error[c])
        count += there[c]
    return count


@inline_kernel
def error_square(J: Entries, error: Entries) -> float:
    """Return error' R^-1 error [-] from the swept ``J``."""
    first = J.shape[0] - error.size
    total = 0.0
    for i in range(error.size):
        for j in range(error.size):
            total -= error[i] * J[first + i, first + j] * error[j]
    return total


@inline_kernel
def move_state(J: Entries, v: Entries, error: Entries, z: Entries) -> None:
    """Write the next state to ``z`` by the gain in the swept ``J``."""
    states = J.shape[0] - error.size
    for i in range(states):
        total = v[i]
        for c in range(error.size):
            total += J[i, states + c] * error[c]
        z[i] = total


@inline_kernel
def advance_state(J: Entries, v: Entries, error: Entries, z: Entries, P: Entries) -> None:
    """Write the next state to ``z`` and its covariance to ``P`` from the swept ``J``."""
    states = P.shape[0]
    for i in range(states):
        total = v[i]
        for c in range(error.size):
            total += J[i, states + c] * error[c]
        z[i] = total
        for j in range(states):
            P[i, j] = J[i, j]


@inline_kernel
def all_there(there: Mask) -> bool:
    """Return whether no reading is missing."""
    missing = 0
    for c in range(there.size):
        missing += not there[c]
    return missing == 0


@inline_kernel
def has_settled(J: Numbers, P: Numbers) -> bool:
    """Return whether the covariance in the swept ``J`` is that in ``P``."""
    for i in range(P.shape[0]):
        for j in range(i + 1):
            change = J[i, j] - P[i, j]
            if change * change > COVARIANCE_TOLERANCE * abs(P[i, i] * P[j, j]):
                return False
    return True


@kernel
def show_filter(
    system: SampledSystem, table: Numbers, which: Indices, limits: Numbers, shown: FilterRun
) -> None:
    """Write to each row of ``shown`` state, prediction, error, error' R^-1 error, flag.

    A sample is rejected if its error' R^-1 error is beyond ``limits`` (y+1,) for its number of
    readings; it then neither moves the filter nor counts. R is written for missing readings too.
    """
    mean, noise, start = system.mean, system.noise, system.start
    filter_rows = shown.rows
    rows, columns, states = mean.shape[1], mean.shape[2], start.shape[0]
    readings = rows - states
    square_column = rows + readings
    flag_column = square_column + 1
    J, joint_copy = np.empty((rows, rows), mean.dtype), np.empty((rows, rows), mean.dtype)
    work, v = np.empty((rows, states), mean.dtype), np.empty(rows, mean.dtype)
    error, present = np.empty(readings, mean.dtype), np.empty(readings, np.bool_)
    z, P = np.ones(columns, mean.dtype), start[:, 1:].copy()
    z[:states] = start[:, 0]
    for k in range(table.shape[0]):
        put_vector(table[k, readings:], states, z)
        predict_sample(mean[which[k]], z, v)
        write_joint(mean[which[k]], noise[which[k]], P, work, J)
        joint_copy[:] = J
        count = write_residual(table[k], v, error, present)
        filter_rows[k, :states] = z[:states]
        filter_rows[k, states:rows] = v[states:]
        filter_rows[k, rows:square_column] = error
        shown.covariances[k] = P
        shown.spreads[k] = J[states:, states:]
        flag = FLAG_COUNTED if count > 0 else FLAG_MISSING
        filter_rows[k, square_column] = 0.0
        if np.isnan(condition_on_readings(J, error, present)):
            flag = FLAG_SINGULAR
        else:
            size = error_square(J, error)
            filter_rows[k, square_column] = size
            if size.real > limits[count]:
                flag = FLAG_REJECTED
        if flag > FLAG_MISSING:  # rejected or singular: the step again, as without any reading
            J[:] = joint_copy
            present[:] = False
            condition_on_readings(J, error, present)
        advance_state(J, v, error, z, P)
        filter_rows[k, flag_column] = flag


@kernel
def run_predictor(
    system: FixedGain, table: Numbers, which: Indices, driven: Numbers, out: Entries
) -> None:
    """Write states and predictions (n, x+y) of a predictor with a given gain to ``out``.

    The predictor is x <- A x + B u + K error + w, with w in ``driven`` (n, x). A missing reading
    has no error and moves nothing.
    """
    mean, gain = system.mean, system.gain
    states, readings = gain.shape
    z, v = np.ones(mean.shape[2], mean.dtype), np.empty(states + readings, mean.dtype)
    put_vector(system.first, 0, z)
    for k in range(table.shape[0]):
        put_vector(table[k, readings:], states, z)
        predict_sample(mean[which[k]], z, v)
        put_vector(z[:states], 0, out[k])
        put_vector(v[states:], states, out[k])
        for i in range(states):
            z[i] = v[i] + driven[k, i]
            for c in range(readings):
                if not np.isnan(table[k, c]):
                    z[i] += gain[i, c] * (table[k, c] - v[states + c])

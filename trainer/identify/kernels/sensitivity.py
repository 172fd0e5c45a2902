"""The slopes of the filter's errors and covariances by the parameters: gradient and information.

MI 8.1. Parameters are the last index of each array, because loops over contiguous numbers are fast.
Each sample gives rows: the standardised derivatives of the error and of its covariance. The inner
products of these rows, summed, are the expected information; the rows with the error and its square
make the gradient of -log L. The rows of covariance are the same for all samples of a stage: the
samples in which the gain is constant. ``fitting/likelihood`` calls ``score_rows`` for each point of
a search, with no parameters where it wants the value alone.
"""

import math
from typing import NamedTuple

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.covariance_filter import (
    Indices,
    Mask,
    SampledSystem,
    advance_state,
    all_there,
    condition_on_readings,
    has_settled,
    move_state,
    predict_sample,
    write_joint,
    write_residual,
)
from trainer.identify.kernels.kernel import (
    clear_array,
    inline_kernel,
    kernel,
    lean_kernel,
    put_block,
    put_vector,
)

# [-] square of the relative change of a derivative of P, below which it is taken as constant
SLOPE_TOLERANCE = 1e-20


class SlopedState(NamedTuple):
    """The state, its covariance and their slopes."""

    z: Numbers
    P: Numbers
    dx: Numbers  # (x, p)
    dP: Numbers  # (x, x, p)


class SampleRows(NamedTuple):
    """The rows of a record, and the system that leads from each to the next."""

    table: Numbers
    which: Indices


class ScoreRows(NamedTuple):
    """What is written: standardised slopes of errors and covariances, and the gradient."""

    errors: Numbers  # (n, y, p)
    covariances: Numbers  # (n, y*y, p), by stage
    gradient: Numbers  # (p,)


class ScoreRoom(NamedTuple):
    """Scratch of a record's rows."""

    J: Numbers
    dJ: Numbers
    half: Numbers  # of J
    d_half: Numbers
    v: Numbers  # next state and readings
    dv: Numbers
    error: Numbers
    U: Numbers  # root of R^-1
    standard: Numbers  # U error
    products: Numbers  # its product with itself, summed over the samples of a stage
    line: Numbers  # (y, p)
    value: Numbers  # (p,)
    change: Numbers
    total: Numbers
    there: Mask  # readings that are
    used: Mask  # entries of the systems' matrices that any parameter changes


@inline_kernel
def _root(J: Numbers, readings: int, out: Numbers) -> None:
    """Write the upper U with U' U = R^-1 from the swept ``J``; missing readings are zero."""
    first = J.shape[0] - readings
    for i in range(readings):
        for j in range(i, readings):
            total = -J[first + i, first + j]
            for k in range(i):
                total -= out[k, i] * out[k, j]
            if i == j:
                out[i, i] = math.sqrt(max(total, 0.0))
            else:
                out[i, j] = total / out[i, i] if out[i, i] > 0.0 else 0.0
                out[j, i] = 0.0


@inline_kernel
def _half_slopes(mean: Numbers, slopes: Numbers, P: Numbers, dP: Numbers, half: Numbers) -> None:
    """Write dW P + W dP / 2 to ``half`` (x+y, x, p): times W', plus its transpose, it is dJ."""
    rows, states, count = half.shape
    for i in range(rows):
        for j in range(states):
            for q in range(count):
                half[i, j, q] = 0.0
            for k in range(states):
                for q in range(count):
                    half[i, j, q] += slopes[i, k, q] * P[k, j] + 0.5 * mean[i, k] * dP[k, j, q]


@inline_kernel
def _joint_slopes(mean: Numbers, half: Numbers, out: Numbers) -> None:
    """Add dJ = dW P W' + W P dW' + W dP W' to ``out`` (x+y, x+y, p). ``out`` has dQ already."""
    rows, states, count = half.shape
    for i in range(rows):
        for j in range(i + 1):
            for k in range(states):
                for q in range(count):
                    out[i, j, q] += half[i, k, q] * mean[j, k] + half[j, k, q] * mean[i, k]
            for q in range(count):
                out[j, i, q] = out[i, j, q]


@inline_kernel
def _entry(J: Numbers, dJ: Numbers, states: int, index: tuple[int, int], value: Numbers) -> None:
    """Write the derivatives (p,) of one entry of the next covariance P.

    They are dJ - dN K' - K dN' + K dR K', where K is the gain.
    """
    i, j = index
    for q in range(value.size):
        value[q] = dJ[i, j, q]
    for c in range(states, J.shape[0]):
        for q in range(value.size):
            value[q] -= dJ[i, c, q] * J[j, c] + J[i, c] * dJ[j, c, q]
        for d in range(states, J.shape[0]):
            both = J[i, c] * J[j, d]
            for q in range(value.size):
                value[q] += both * dJ[c, d, q]


@inline_kernel
def _condition(room: ScoreRoom, dP: Numbers) -> float:
    """Advance ``dP`` past the readings; return the square of its largest relative change [-]."""
    states, count = dP.shape[0], dP.shape[2]
    J, dJ = room.J, room.dJ
    value, change, total = room.value, room.change, room.total
    for q in range(count):
        change[q] = 0.0
        total[q] = 0.0
    for i in range(states):
        for j in range(i + 1):
            _entry(J, dJ, states, (i, j), value)
            # entries are compared by their own variances, because their units differ
            weight = 1.0 / max(abs(J[i, i] * J[j, j]), 1e-300)
            for q in range(count):
                moved = value[q] - dP[i, j, q]
                change[q] += moved * moved * weight
                total[q] += value[q] * value[q] * weight
                dP[i, j, q] = value[q]
                dP[j, i, q] = value[q]
    worst = 0.0
    for q in range(count):
        if change[q] > 0.0:
            worst = max(worst, change[q] / max(total[q], 1e-300))
    return worst


@inline_kernel
def _gain_slopes(J: Numbers, dJ: Numbers, states: int, line: Numbers) -> None:
    """Write dK = (dN - K dR) R^-1 over dN, the mixed block of ``dJ``; ``line`` is scratch."""
    rows, count = J.shape[0], dJ.shape[2]
    for i in range(states):
        for c in range(states, rows):
            for q in range(count):
                line[c - states, q] = dJ[i, c, q]
            for d in range(states, rows):
                for q in range(count):
                    line[c - states, q] -= J[i, d] * dJ[d, c, q]
        for c in range(states, rows):
            for q in range(count):
                dJ[i, c, q] = 0.0
            for d in range(states, rows):
                for q in range(count):
                    dJ[i, c, q] -= line[d - states, q] * J[d, c]


@inline_kernel
def _find_used(slopes: Numbers, used: Mask) -> None:
    """Write which entries of the systems' matrices (m, x+y, x+2u+1) any parameter changes.

    Most entries have no slope at all, and ``_mean_slopes`` saves time by leaving these out.
    """
    for m in range(used.shape[0]):
        for i in range(used.shape[1]):
            for j in range(used.shape[2]):
                used[m, i, j] = False
                for q in range(slopes.shape[3]):
                    if slopes[m, i, j, q] != 0.0:
                        used[m, i, j] = True


@inline_kernel
def _mean_slopes(
    mean: Numbers, dW: Numbers, used: Mask, z: Numbers, dx: Numbers, out: Numbers
) -> None:
    """Write dv = dW z + W_x dx to ``out`` (x+y, p); ``used`` says which of dW are not zero."""
    rows, count = out.shape
    for i in range(rows):
        for q in range(count):
            out[i, q] = mean[i, 0] * dx[0, q]
        for j in range(1, dx.shape[0]):
            for q in range(count):
                out[i, q] += mean[i, j] * dx[j, q]
        for j in range(z.size):
            if used[i, j]:
                for q in range(count):
                    out[i, q] += dW[i, j, q] * z[j]


@inline_kernel
def _standardise(room: ScoreRoom, out: Numbers) -> float:
    """Return error' R^-1 error, after writing U error, and U d(error) to ``out`` (y, p).

    The error is reading less prediction.
    """
    readings, count = out.shape
    U, error, dv, standard = room.U, room.error, room.dv, room.standard
    states, size = dv.shape[0] - readings, 0.0
    for i in range(readings):
        standard[i] = 0.0
        for q in range(count):
            out[i, q] = 0.0
        for j in range(i, readings):
            standard[i] += U[i, j] * error[j]
            for q in range(count):
                out[i, q] -= U[i, j] * dv[states + j, q]
        size += standard[i] * standard[i]
    for i in range(readings):
        for j in range(readings):
            room.products[i, j] += standard[i] * standard[j]
    return size


@inline_kernel
def _add_slope(rows: Numbers, weights: Numbers, slope: Numbers) -> None:
    """Add the sum of ``rows`` (y, p), each by its weight, to ``slope``."""
    for i in range(rows.shape[0]):
        for q in range(rows.shape[1]):
            slope[q] += weights[i] * rows[i, q]


@inline_kernel
def _next_slopes(J: Numbers, dJ: Numbers, error: Numbers, dv: Numbers, dx: Numbers) -> None:
    """Write dx of the next state: dv + dK error + K d(error)."""
    states, count = dx.shape
    for i in range(states):
        for q in range(count):
            dx[i, q] = dv[i, q]
        for c in range(error.size):
            gain = J[i, states + c]
            for q in range(count):
                dx[i, q] += dJ[i, states + c, q] * error[c] - gain * dv[states + c, q]


@inline_kernel
def _close_stage(room: ScoreRoom, counted: int, rows: Numbers, slope: Numbers) -> None:
    """Write U dR U' sqrt(samples/2) of a stage to ``rows`` (y*y, p), its part to ``slope``.

    Clears the sum of U error error' U' over the stage's samples, because the next stage begins.
    """
    U, dJ, products = room.U, room.dJ, room.products
    readings, count = U.shape[0], dJ.shape[2]
    states = dJ.shape[0] - readings
    weight = math.sqrt(0.5 * counted)
    for i in range(readings):
        for j in range(readings):
            index = i * readings + j
            for q in range(count):
                rows[index, q] = 0.0
            for k in range(i, readings):
                for m in range(j, readings):
                    factor = weight * U[i, k] * U[j, m]
                    for q in range(count):
                        rows[index, q] += factor * dJ[states + k, states + m, q]
            remainder = (counted if i == j else 0.0) - products[i, j]
            remainder *= 0.5 / weight
            for q in range(count):
                slope[q] += remainder * rows[index, q]
            products[i, j] = 0.0


@lean_kernel
def _rows(
    system: SampledSystem,
    slopes: SampledSystem,
    samples: SampleRows,
    now: SlopedState,
    room: ScoreRoom,
    out: ScoreRows,
) -> tuple[int, float]:
    """Return and write as ``score_rows`` does, from the state ``now`` on."""
    table, which = samples.table, samples.which
    z, P, dx, dP = now.z, now.P, now.dx, now.dP
    J, dJ, v, dv = room.J, room.dJ, room.v, room.dv
    error, present = room.error, room.there
    rows, states, readings = v.size, P.shape[0], error.size
    stages, counted, constant, cost, determinant = 0, 0, False, 0.0, 0.0
    for k in range(table.shape[0]):
        W, dW = system.mean[which[k]], slopes.mean[which[k]]
        put_vector(table[k, readings:], states, z)
        predict_sample(W, z, v)
        _mean_slopes(W, dW, room.used[which[k]], z, dx, dv)
        write_residual(table[k], v, error, present)
        constant = constant and all_there(present) and which[k] == which[k - 1]
        if not constant:
            if stages > 0:
                _close_stage(room, counted, out.covariances[stages - 1], out.gradient)
            stages, counted = stages + 1, 0
            write_joint(W, system.noise[which[k]], P, room.half, J)
            for i in range(rows):
                put_block(slopes.noise[which[k], i], 0, dJ[i])
            _half_slopes(W, dW, P, dP, room.d_half)
            _joint_slopes(W, room.d_half, dJ)
            determinant = condition_on_readings(J, error, present)
            if math.isnan(determinant):
                return 0, determinant
            _root(J, readings, room.U)
            moved = _condition(room, dP)
            constant = all_there(present) and has_settled(J, P) and moved < SLOPE_TOLERANCE
            _gain_slopes(J, dJ, states, room.line)
        cost += determinant + _standardise(room, out.errors[k])
        _add_slope(out.errors[k], room.standard, out.gradient)
        _next_slopes(J, dJ, error, dv, dx)
        if constant:
            move_state(J, v, error, z)
        else:
            advance_state(J, v, error, z, P)
        counted += 1
    _close_stage(room, counted, out.covariances[stages - 1], out.gradient)
    return stages, 0.5 * cost


@kernel
def score_rows(
    system: SampledSystem, slopes: SampledSystem, table: Numbers, which: Indices, out: ScoreRows
) -> tuple[int, float]:
    """Return the number of stages and -log L less its constant; write rows and gradient.

    The number is 0 if R is not positive definite. ``slopes`` are those of the ``system``,
    parameters last.
    """
    rows, columns = system.mean.shape[1:]
    states = system.start.shape[0]
    readings, count = out.errors.shape[1:]
    z, P = np.ones(columns), np.empty((states, states))
    put_vector(system.start[:, 0], 0, z)
    put_block(system.start[:, 1:], 0, P)
    dx, dP = np.empty((states, count)), np.empty((states, states, count))
    put_block(slopes.start[:, 0], 0, dx)
    for i in range(states):
        put_block(slopes.start[i, 1:], 0, dP[i])
    used = np.empty((system.mean.shape[0], rows, columns), np.bool_)
    _find_used(slopes.mean, used)
    room = ScoreRoom(
        np.empty((rows, rows)),
        np.empty((rows, rows, count)),
        np.empty((rows, states)),
        np.empty((rows, states, count)),
        np.empty(rows),
        np.empty((rows, count)),
        np.empty(readings),
        np.zeros((readings, readings)),
        np.zeros(readings),
        np.zeros((readings, readings)),
        np.empty((readings, count)),
        np.empty(count),
        np.empty(count),
        np.empty(count),
        np.empty(readings, np.bool_),
        used,
    )
    clear_array(out.gradient)
    return _rows(system, slopes, SampleRows(table, which), SlopedState(z, P, dx, dP), room, out)

"""The slopes of the filter's errors and covariances by the parameters: gradient and information.

MI 8.1. Parameters are the last, contiguous index. Each sample gives rows: the standardised
derivatives of the error, and of its covariance. The sum of their inner products is the expected
information; with the error and its square they make the gradient of -log L.
"""

import math

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.covariance_filter import (
    Mask,
    Places,
    advance,
    all_there,
    condition,
    has_settled,
    joint,
    move,
    predict,
    residual,
)
from trainer.identify.kernels.kernel import clear, kernel, lean, part, put, put_block

SETTLED = 1e-20  # [-] square of the relative change of a derivative of P


@part
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


@part
def _half_slopes(mean: Numbers, slopes: Numbers, P: Numbers, dP: Numbers, half: Numbers) -> None:
    """Write dW P + W dP / 2 to ``half`` (x+y, x, p)."""
    rows, states, count = half.shape
    for i in range(rows):
        for j in range(states):
            for q in range(count):
                half[i, j, q] = 0.0
            for k in range(states):
                for q in range(count):
                    half[i, j, q] += slopes[i, k, q] * P[k, j] + 0.5 * mean[i, k] * dP[k, j, q]


@part
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


@part
def _entry(J: Numbers, dJ: Numbers, states: int, place: tuple[int, int], value: Numbers) -> None:
    """Write the derivatives (p,) of an entry of the next P: dJ - dN K' - K dN' + K dR K'."""
    i, j = place
    for q in range(value.size):
        value[q] = dJ[i, j, q]
    for c in range(states, J.shape[0]):
        for q in range(value.size):
            value[q] -= dJ[i, c, q] * J[j, c] + J[i, c] * dJ[j, c, q]
        for d in range(states, J.shape[0]):
            both = J[i, c] * J[j, d]
            for q in range(value.size):
                value[q] += both * dJ[c, d, q]


@part
def _condition(J: Numbers, dJ: Numbers, lines: Numbers, dP: Numbers) -> float:
    """Return the square of the change [-] of ``dP``, as it becomes that after the readings.

    ``lines`` (3 or more, p) is scratch.
    """
    states, count = dP.shape[0], dP.shape[2]
    value, change, total = lines[0], lines[1], lines[2]
    for q in range(count):
        change[q] = 0.0
        total[q] = 0.0
    for i in range(states):
        for j in range(i + 1):
            _entry(J, dJ, states, (i, j), value)
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


@part
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


@part
def _find_used(slopes: Numbers, used: Mask) -> None:
    """Write which entries of the systems' matrices (m, x+y, x+2u+1) any parameter changes."""
    for m in range(used.shape[0]):
        for i in range(used.shape[1]):
            for j in range(used.shape[2]):
                used[m, i, j] = False
                for q in range(slopes.shape[3]):
                    if slopes[m, i, j, q] != 0.0:
                        used[m, i, j] = True


@part
def _mean_slopes(
    mean: Numbers, slopes: tuple[Numbers, Mask], z: Numbers, dx: Numbers, out: Numbers
) -> None:
    """Write dv = dW z + W_x dx to ``out`` (x+y, p). ``slopes`` says which of its rows are used."""
    rows, count = out.shape
    dW, used = slopes
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


@part
def _standardise(U: Numbers, error: Numbers, dv: Numbers, out: Numbers, squares: Numbers) -> float:
    """Return error' R^-1 error, after writing U d(error) to ``out`` (y, p).

    The error is reading less prediction. ``squares`` (y, 1+y) has U error first, and then gains
    its product with itself.
    """
    readings, count = out.shape
    states, size = dv.shape[0] - readings, 0.0
    for i in range(readings):
        squares[i, 0] = 0.0
        for q in range(count):
            out[i, q] = 0.0
        for j in range(i, readings):
            squares[i, 0] += U[i, j] * error[j]
            for q in range(count):
                out[i, q] -= U[i, j] * dv[states + j, q]
        size += squares[i, 0] * squares[i, 0]
    for i in range(readings):
        for j in range(readings):
            squares[i, 1 + j] += squares[i, 0] * squares[j, 0]
    return size


@part
def _add_slope(rows: Numbers, weights: Numbers, slope: Numbers) -> None:
    """Add the sum of ``rows`` (y, p), each by its weight in the first column, to ``slope``."""
    for i in range(rows.shape[0]):
        for q in range(rows.shape[1]):
            slope[q] += weights[i, 0] * rows[i, q]


@part
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


@part
def _close_stage(
    U: Numbers, dJ: Numbers, counted: int, squares: Numbers, rows: Numbers, slope: Numbers
) -> None:
    """Write U dR U' sqrt(samples/2) of a stage to ``rows`` (y*y, p), its part to ``slope``.

    ``squares`` has the sum of U error error' U' over its samples, and is cleared.
    """
    readings, count = U.shape[0], dJ.shape[2]
    states = dJ.shape[0] - readings
    weight = math.sqrt(0.5 * counted)
    for i in range(readings):
        for j in range(readings):
            place = i * readings + j
            for q in range(count):
                rows[place, q] = 0.0
            for k in range(i, readings):
                for m in range(j, readings):
                    factor = weight * U[i, k] * U[j, m]
                    for q in range(count):
                        rows[place, q] += factor * dJ[states + k, states + m, q]
            left = (counted if i == j else 0.0) - squares[i, 1 + j]
            left *= 0.5 / weight
            for q in range(count):
                slope[q] += left * rows[place, q]
            squares[i, 1 + j] = 0.0


@lean
def _rows(
    system: tuple[Numbers, Numbers, Numbers, Numbers],
    samples: tuple[Numbers, Places],
    now: tuple[Numbers, Numbers, Numbers, Numbers],
    work: tuple[tuple[Numbers, ...], tuple[Numbers, ...], tuple[Mask, Mask]],
    out: tuple[Numbers, Numbers, Numbers],
) -> tuple[int, float]:
    """Return and write as ``score_rows`` does.

    ``now`` has state, covariance and their slopes at the start.
    """
    mean, noise, d_mean, d_noise = system
    table, which = samples
    z, P, dx, dP = now
    (half, v, error, U, J, squares), (dJ, d_half, dv, lines), (there, used) = work
    errors, covariances, slope = out
    rows, states, readings = v.size, P.shape[0], error.size
    stages, counted, constant, cost, determinant = 0, 0, False, 0.0, 0.0
    for k in range(table.shape[0]):
        W, dW = mean[which[k]], d_mean[which[k]]
        put(table[k, readings:], states, z)
        predict(W, z, v)
        _mean_slopes(W, (dW, used[which[k]]), z, dx, dv)
        residual(table[k], v, error, there)
        constant = constant and all_there(there) and which[k] == which[k - 1]
        if not constant:
            if stages > 0:
                _close_stage(U, dJ, counted, squares, covariances[stages - 1], slope)
            stages, counted = stages + 1, 0
            joint(W, noise[which[k]], P, half, J)
            for i in range(rows):
                put_block(d_noise[which[k], i], 0, dJ[i])
            _half_slopes(W, dW, P, dP, d_half)
            _joint_slopes(W, d_half, dJ)
            determinant = condition(J, error, there)
            if math.isnan(determinant):
                return 0, determinant
            _root(J, readings, U)
            moved = _condition(J, dJ, lines, dP)
            constant = all_there(there) and has_settled(J, P) and moved < SETTLED
            _gain_slopes(J, dJ, states, lines)
        cost += determinant + _standardise(U, error, dv, errors[k], squares)
        _add_slope(errors[k], squares, slope)
        _next_slopes(J, dJ, error, dv, dx)
        if constant:
            move(J, v, error, z)
        else:
            advance(J, v, error, z, P)
        counted += 1
    _close_stage(U, dJ, counted, squares, covariances[stages - 1], slope)
    return stages, 0.5 * cost


@kernel
def score_rows(
    system: tuple[Numbers, Numbers, Numbers],
    slopes: tuple[Numbers, Numbers, Numbers],
    table: Numbers,
    which: Places,
    out: tuple[Numbers, Numbers, Numbers],
) -> tuple[int, float]:
    """Return the number of stages and -log L less its constant; write rows and gradient.

    0 if R is not positive definite. ``system`` is mean, noise and start; ``slopes`` are those of
    the same, parameters last. Of ``out`` errors (n, y, p) gets the standardised derivatives of each
    error, covariances (n, y*y, p) those of each stage, and the last (p,) the gradient.
    """
    mean, noise, start = system
    d_mean, d_noise, d_start = slopes
    rows, columns = mean.shape[1:]
    states, readings, count = start.shape[0], out[0].shape[1], out[0].shape[2]
    z, P = np.ones(columns), np.empty((states, states))
    put(start[:, 0], 0, z)
    put_block(start[:, 1:], 0, P)
    dx, dP = np.empty((states, count)), np.empty((states, states, count))
    put_block(d_start[:, 0], 0, dx)
    for i in range(states):
        put_block(d_start[i, 1:], 0, dP[i])
    half, v, error = np.empty((rows, states)), np.empty(rows), np.empty(readings)
    U, squares = np.zeros((readings, readings)), np.zeros((readings, 1 + readings))
    plain = half, v, error, U, np.empty((rows, rows)), squares
    d_half, lines = np.empty((rows, states, count)), np.empty((max(3, readings), count))
    sloped = np.empty((rows, rows, count)), d_half, np.empty((rows, count)), lines
    used = np.empty((mean.shape[0], rows, columns), np.bool_)
    _find_used(d_mean, used)
    work = plain, sloped, (np.empty(readings, np.bool_), used)
    clear(out[2])
    return _rows((mean, noise, d_mean, d_noise), (table, which), (z, P, dx, dP), work, out)

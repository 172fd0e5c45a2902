"""The exact gradient of the log-likelihood by one run forward and one back (MI 8.1).

With J = W_x P W_x' + Q of ``covariance_filter`` and the adjoints x~, P~ of the next state and its
covariance, the readings' part of step k has (s = R^-1 error, K the gain, t = K' x~)

    a = (x~, -s - t)     H = [P~, B; B', R~],  B = x~ s'/2 - P~ K
    R~ = (R^-1 - s s' - t s' - s t')/2 + K' P~ K

and then dF/dW += a z' + 2 H W_x P, dF/dQ += H, x~ = W_x' a, P~ = W_x' H W_x. That is the
document's adjoint, for errors that may be correlated with the noise and readings that may be
missing. Where the filter has settled, the sums of H are carried through W_x P once.
"""

import math

import numpy as np

from trainer.core.kernel import Numbers, kernel
from trainer.identify.kernels.covariance_filter import (
    Mask,
    Places,
    advance,
    condition,
    joint,
    predict,
    residual,
    settled,
)


@kernel
def steady_step(J: Numbers, v: Numbers, error: Numbers, z: Numbers) -> None:
    """Write the next state to ``z`` by the gain in the swept ``J``, covariance unchanged."""
    states = J.shape[0] - error.size
    for i in range(states):
        total = v[i]
        for c in range(error.size):
            total += J[i, states + c] * error[c]
        z[i] = total


@kernel
def all_there(there: Mask) -> bool:
    """Return whether no reading is missing."""
    for c in range(there.size):
        if not there[c]:
            return False
    return True


@kernel
def trail(
    mean: Numbers, noise: Numbers, table: Numbers, which: Places, path: Numbers, joints: Numbers
) -> int:
    """Return how many stages the filter has, 0 if R is not positive definite; write its trail.

    ``path`` (n, columns + y + 1): z, R^-1 error, and the stage whose gain the sample has.
    ``joints`` (n, x+y, x+y + x): of each stage the swept J and the P before it; the first P and
    the first state are there already.
    """
    rows, columns = mean.shape[1:]
    readings = path.shape[1] - columns - 1
    states = rows - readings
    work, v, error = np.empty((rows, states)), np.empty(rows), np.empty(readings)
    there = np.empty(readings, np.bool_)
    z, P, J = path[0, :columns].copy(), joints[0, :states, rows:].copy(), np.empty((rows, rows))
    stage, constant = -1, False
    for k in range(table.shape[0]):
        z[states : columns - 1] = table[k, readings:]
        predict(mean[which[k]], z, v)
        residual(table[k], v, error, there)
        constant = constant and all_there(there) and which[k] == which[k - 1]
        if not constant:
            stage += 1
            joint(mean[which[k]], noise[which[k]], P, work, J)
            if math.isnan(condition(J, error, there)):
                return 0
            joints[stage, :, :rows] = J
            joints[stage, :states, rows:] = P
            constant = all_there(there) and settled(J, P)
        path[k, :columns] = z
        for i in range(readings):
            path[k, columns + i] = 0.0
            for j in range(readings):
                path[k, columns + i] -= J[states + i, states + j] * error[j]
        path[k, columns + readings] = stage
        if constant:
            steady_step(J, v, error, z)
        else:
            advance(J, v, error, z, P)
    return stage + 1


@kernel
def _readings_part(J: Numbers, s: Numbers, x: Numbers, H: Numbers, a: Numbers) -> None:
    """Write ``a`` and complete ``H``, whose state block is P~; ``x`` is x~, ``J`` swept."""
    states, readings = x.size, s.size
    t = np.empty(readings)
    for c in range(readings):
        total = 0.0
        for i in range(states):
            total += J[i, states + c] * x[i]
        t[c] = total
        a[states + c] = -s[c] - total
    for i in range(states):
        a[i] = x[i]
        for c in range(readings):
            total = 0.0
            for j in range(states):
                total += H[i, j] * J[j, states + c]
            H[states + c, i] = total
            H[i, states + c] = total
    for c in range(readings):
        for d in range(c + 1):
            total = 0.5 * (-J[states + c, states + d] - s[c] * s[d] - t[c] * s[d] - s[c] * t[d])
            for i in range(states):
                total += J[i, states + c] * H[i, states + d]
            H[states + c, states + d] = total
            H[states + d, states + c] = total
    for i in range(states):
        for c in range(readings):
            H[i, states + c] = 0.5 * x[i] * s[c] - H[i, states + c]
            H[states + c, i] = H[i, states + c]


@kernel
def _through_states(mean: Numbers, H: Numbers, work: Numbers, out: Numbers) -> None:
    """Write W_x' H W_x to the state block of ``out``; ``work`` (x+y, x)."""
    rows, states = work.shape
    for i in range(rows):
        for j in range(states):
            total = 0.0
            for k in range(rows):
                total += H[i, k] * mean[k, j]
            work[i, j] = total
    for i in range(states):
        for j in range(i + 1):
            total = 0.0
            for k in range(rows):
                total += mean[k, i] * work[k, j]
            out[i, j] = total
            out[j, i] = total


@kernel
def _close_stage(mean: Numbers, P: Numbers, out: Numbers, total: Numbers) -> None:
    """Write what a stage's sum of H, ``total``, adds to ``out``: dF/dW and after it dF/dQ.

    ``total`` is zero afterwards.
    """
    rows, states = total.shape[0], P.shape[0]
    columns = mean.shape[1]
    for i in range(rows):
        for j in range(rows):
            weight = total[i, j]
            out[i, columns + j] += weight
            total[i, j] = 0.0
            for k in range(states):
                product = 0.0
                for m in range(states):
                    product += mean[j, m] * P[m, k]
                out[i, k] += 2.0 * weight * product


@kernel
def likelihood_slope(
    mean: Numbers, which: Places, path: Numbers, joints: Numbers, out: Numbers, start: Numbers
) -> None:
    """Write dF/dW and dF/dQ to ``out`` (m, x+y, columns + x+y), dF/dx0 and dF/dP0 to ``start``.

    F is minus the log-likelihood; ``path`` and ``joints`` are those of ``trail``.
    """
    rows, columns = mean.shape[1:]
    states = start.shape[0]
    readings = rows - states
    x, a = np.zeros(states), np.empty(rows)
    H, work, total = np.zeros((rows, rows)), np.empty((rows, states)), np.zeros((rows, rows))
    out[:] = 0.0
    for k in range(which.size - 1, -1, -1):
        W, into = mean[which[k]], out[which[k]]
        stage = int(path[k, columns + readings])
        J = joints[stage, :, :rows]
        s = path[k, columns : columns + readings]
        _readings_part(J, s, x, H, a)
        for i in range(rows):
            for j in range(columns):
                into[i, j] += a[i] * path[k, j]
            for j in range(rows):
                total[i, j] += H[i, j]
        if k == 0 or int(path[k - 1, columns + readings]) != stage:
            _close_stage(W, joints[stage, :states, rows:], into, total)
        for i in range(states):
            value = 0.0
            for j in range(rows):
                value += W[j, i] * a[j]
            x[i] = value
        _through_states(W, H, work, H)
    start[:, 0] = x
    start[:, 1:] = H[:states, :states]

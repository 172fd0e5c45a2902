"""The exact gradient of the log-likelihood by one run forward and one back (MI 8.1).

With v = W z, J = W_x P W_x' + Q of ``covariance_filter``, s = R^-1 error, K the gain, F = A - K C
and x~, P~ the adjoints of the next state and its covariance, one step back is

    dF/dW += (x~, -s - K' x~) z' + 2 H W_x P,   dF/dQ += H = [P~, B; B', S]
    B = x~ s'/2 - P~ K,   S = (R^-1 - s s' - K' x~ s' - s x~' K)/2 + K' P~ K
    P~ <- F' P~ F + (f w' + w f' - w w' + C' R^-1 C)/2,   x~ <- f - w,   f = F' x~, w = C' s

which is the document's adjoint, for errors that may be correlated with the noise and readings that
may be missing. All but P~ is linear in sums over the samples that have one gain, a stage.
"""

import math

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.blocks import clear, put, put_block
from trainer.identify.kernels.covariance_filter import (
    Mask,
    Places,
    advance,
    condition,
    joint,
    predict,
    residual,
    settled,
    square,
)
from trainer.identify.kernels.kernel import kernel


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
    missing = 0
    for c in range(there.size):
        missing += not there[c]
    return missing == 0


@kernel
def trail(
    mean: Numbers, noise: Numbers, table: Numbers, which: Places, path: Numbers, joints: Numbers
) -> int:
    """Return how many stages the filter has, 0 if R is not positive definite; write its trail.

    ``path`` (n, columns + y + 2): z, R^-1 error, the sample's part of -2 log L less its constant,
    and the stage whose gain it has.
    ``joints`` (n, x+y, x+y + x): of each stage the swept J and the P before it; the first P and
    the first state are there already.
    """
    rows, columns = mean.shape[1:]
    readings = path.shape[1] - columns - 2
    states = rows - readings
    work, v, error = np.empty((rows, states)), np.empty(rows), np.empty(readings)
    there = np.empty(readings, np.bool_)
    z, P, J = np.empty(columns), np.empty((states, states)), np.empty((rows, rows))
    put(path[0, :columns], 0, z)
    put_block(joints[0, :states, rows:], 0, P)
    stage, constant, determinant = -1, False, 0.0
    for k in range(table.shape[0]):
        put(table[k, readings:], states, z)
        predict(mean[which[k]], z, v)
        residual(table[k], v, error, there)
        constant = constant and all_there(there) and which[k] == which[k - 1]
        if not constant:
            stage += 1
            joint(mean[which[k]], noise[which[k]], P, work, J)
            determinant = condition(J, error, there)
            if math.isnan(determinant):
                return 0
            put_block(J, 0, joints[stage])
            put_block(P, rows, joints[stage])
            constant = all_there(there) and settled(J, P)
        put(z, 0, path[k])
        for i in range(readings):
            path[k, columns + i] = 0.0
            for j in range(readings):
                path[k, columns + i] -= J[states + i, states + j] * error[j]
        path[k, columns + readings] = determinant + square(J, error)
        path[k, columns + readings + 1] = stage
        if constant:
            steady_step(J, v, error, z)
        else:
            advance(J, v, error, z, P)
    return stage + 1


@kernel
def _stage(mean: Numbers, J: Numbers, F: Numbers, half: Numbers) -> None:
    """Write F = A - K C and C' R^-1 C / 2 of a stage from its swept ``J``."""
    states, rows = F.shape[0], mean.shape[0]
    for i in range(states):
        for j in range(states):
            F[i, j] = mean[i, j]
            half[i, j] = 0.0
            for c in range(states, rows):
                F[i, j] -= J[i, c] * mean[c, j]
                for d in range(states, rows):
                    half[i, j] -= 0.5 * mean[c, i] * J[c, d] * mean[d, j]


@kernel
def _step_back(F: Numbers, half: Numbers, w: Numbers, x: Numbers, P: Numbers) -> None:
    """Write x~ and P~ of the sample to ``x`` and ``P``, which have those of the next."""
    states = x.size
    f, product = np.empty(states), np.empty((states, states))
    for i in range(states):
        f[i] = 0.0
        for j in range(states):
            f[i] += F[j, i] * x[j]
            product[i, j] = 0.0
            for k in range(states):
                product[i, j] += P[i, k] * F[k, j]
    for i in range(states):
        x[i] = f[i] - w[i]
        for j in range(i + 1):
            total = half[i, j] + 0.5 * (f[i] * w[j] + w[i] * f[j] - w[i] * w[j])
            for k in range(states):
                total += F[k, i] * product[k, j]
            P[i, j] = total
            P[j, i] = total


@kernel
def _sum_of_h(J: Numbers, sums: Numbers, adjoint: Numbers, samples: float, H: Numbers) -> None:
    """Write the sum of H over a stage of so many ``samples``.

    ``sums`` (x+y, y) is that of (x~, s) s', ``adjoint`` (x, x) that of P~.
    """
    states, rows = adjoint.shape[0], J.shape[0]
    for i in range(states):
        for j in range(states):
            H[i, j] = adjoint[i, j]
        for c in range(states, rows):
            total = 0.0
            for j in range(states):
                total += adjoint[i, j] * J[j, c]
            H[i, c] = 0.5 * sums[i, c - states] - total
            H[c, i] = total  # P~ K for now
    for c in range(states, rows):
        for d in range(states, c + 1):
            total = -0.5 * (samples * J[c, d] + sums[c, d - states])
            for i in range(states):
                total -= 0.5 * (J[i, c] * sums[i, d - states] + J[i, d] * sums[i, c - states])
                total += J[i, c] * H[d, i]
            H[c, d] = total
            H[d, c] = total
    for i in range(states):
        for c in range(states, rows):
            H[c, i] = H[i, c]


@kernel
def _close_stage(mean: Numbers, joints: Numbers, sums: Numbers, H: Numbers, out: Numbers) -> None:
    """Add what a stage's sums and its sum of H give to ``out``: dF/dW and after it dF/dQ."""
    rows, columns = mean.shape
    states = joints.shape[1] - rows
    for i in range(rows):
        for j in range(columns):
            total = sums[i, j]
            if i >= states:
                total = -total
                for k in range(states):
                    total -= joints[k, i] * sums[k, j]
            out[i, j] += total
        for j in range(rows):
            out[i, columns + j] += H[i, j]
            for k in range(states):
                for m in range(states):
                    out[i, k] += 2.0 * H[i, j] * mean[j, m] * joints[m, rows + k]


@kernel
def likelihood_slope(
    mean: Numbers, which: Places, path: Numbers, joints: Numbers, out: Numbers, start: Numbers
) -> None:
    """Write dF/dW and dF/dQ to ``out`` (m, x+y, columns + x+y), dF/dx0 and dF/dP0 to ``start``.

    F is minus the log-likelihood; ``path`` and ``joints`` are those of ``trail``.
    """
    rows, columns = mean.shape[1:]
    states, wide = start.shape[0], path.shape[1] - 2
    F, half, w = np.empty((states, states)), np.empty((states, states)), np.empty(states)
    x, P, H = np.zeros(states), np.zeros((states, states)), np.empty((rows, rows))
    sums, adjoint, samples = np.zeros((rows, wide)), np.zeros((states, states)), 0.0
    clear(out)
    for k in range(which.size - 1, -1, -1):
        W, line = mean[which[k]], path[k]
        stage = int(line[wide + 1])
        if samples == 0.0:
            _stage(W, joints[stage], F, half)
        samples += 1.0
        for i in range(states):
            w[i] = 0.0
            for c in range(states, rows):
                w[i] += W[c, i] * line[columns + c - states]
            for j in range(wide):
                sums[i, j] += x[i] * line[j]
            for j in range(states):
                adjoint[i, j] += P[i, j]
        for c in range(states, rows):
            for j in range(wide):
                sums[c, j] += line[columns + c - states] * line[j]
        _step_back(F, half, w, x, P)
        if k == 0 or int(path[k - 1, wide + 1]) != stage:
            _sum_of_h(joints[stage], sums[:, columns:], adjoint, samples, H)
            _close_stage(W, joints[stage], sums, H, out[which[k]])
            clear(sums)
            clear(adjoint)
            samples = 0.0
    put(x, 0, start[:, 0])
    put_block(P, 1, start)

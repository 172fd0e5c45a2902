"""The exact gradient of the log-likelihood by one run forward and one back (MI 8.1).

With v = W z, J = W_x P W_x' + Q of ``covariance_filter``, s = R^-1 error, K the gain, F = A - K C
and x~, P~ the adjoints of the next state and its covariance, one step back is

    dF/dW += (x~, -s - K' x~) z' + 2 H W_x P,   dF/dQ += H = [P~, B; B', S]
    B = x~ s'/2 - P~ K,   S = (R^-1 - s s' - K' x~ s' - s x~' K)/2 + K' P~ K
    P~ <- F' P~ F + (f w' + w f' - w w' + C' R^-1 C)/2,   x~ <- f - w,   f = F' x~, w = C' s

This is the document's adjoint, for errors that may be correlated with the noise and readings that
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
    has_settled,
    joint,
    predict,
    residual,
)
from trainer.identify.kernels.kernel import kernel, lean, part


@part
def steady_step(J: Numbers, v: Numbers, error: Numbers, z: Numbers) -> None:
    """Write the next state to ``z`` by the gain in the swept ``J``, covariance unchanged."""
    states = J.shape[0] - error.size
    for i in range(states):
        total = v[i]
        for c in range(error.size):
            total += J[i, states + c] * error[c]
        z[i] = total


@part
def all_there(there: Mask) -> bool:
    """Return whether no reading is missing."""
    missing = 0
    for c in range(there.size):
        missing += not there[c]
    return missing == 0


@lean
def _follow(
    system: tuple[Numbers, Numbers],
    samples: tuple[Numbers, Places],
    now: tuple[Numbers, Numbers],
    work: tuple[Numbers, Numbers, Numbers, Numbers, Mask],
    path: Numbers,
    joints: Numbers,
) -> int:
    """Return and write as ``trail`` does, from the state z and covariance P in ``now``."""
    mean, noise = system
    table, which = samples
    z, P = now
    J, half, v, error, there = work
    states, readings, columns = P.shape[0], error.size, z.size
    stage, constant, determinant = -1, False, 0.0
    for k in range(table.shape[0]):
        W, line = mean[which[k]], path[k]
        put(table[k, readings:], states, z)
        predict(W, z, v)
        residual(table[k], v, error, there)
        constant = constant and all_there(there) and which[k] == which[k - 1]
        if not constant:
            stage += 1
            joint(W, noise[which[k]], P, half, J)
            determinant = condition(J, error, there)
            if math.isnan(determinant):
                return 0
            put_block(J, 0, joints[stage])
            put_block(P, J.shape[0], joints[stage])
            constant = all_there(there) and has_settled(J, P)
        put(z, 0, line)
        size = 0.0
        for i in range(readings):
            total = 0.0
            for j in range(readings):
                total -= J[states + i, states + j] * error[j]
            line[columns + i] = total
            size += total * error[i]
        line[columns + readings] = determinant + size
        line[columns + readings + 1] = stage
        if constant:
            steady_step(J, v, error, z)
        else:
            advance(J, v, error, z, P)
    return stage + 1


@kernel
def trail(
    mean: Numbers, noise: Numbers, table: Numbers, which: Places, path: Numbers, joints: Numbers
) -> int:
    """Return how many stages the filter has, and write its trail.

    0 if R is not positive definite. ``path`` (n, columns + y + 2): z, R^-1 error, the sample's part
    of -2 log L less its constant, and the stage whose gain it has. ``joints`` (n, x+y, x+y + x):
    the swept J of each stage and the P before it; the first P and the first state are there
    already.
    """
    rows, columns = mean.shape[1:]
    readings = path.shape[1] - columns - 2
    states = rows - readings
    z, P = np.empty(columns), np.empty((states, states))
    put(path[0, :columns], 0, z)
    put_block(joints[0, :states, rows:], 0, P)
    J, half, v = np.empty((rows, rows)), np.empty((rows, states)), np.empty(rows)
    work = J, half, v, np.empty(readings), np.empty(readings, np.bool_)
    return _follow((mean, noise), (table, which), (z, P), work, path, joints)


@part
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


@part
def _collect(W: Numbers, line: Numbers, x: Numbers, w: Numbers, sums: Numbers) -> None:
    """Write w = C' s of a sample, and add its (x~, s) (z, s)' to ``sums``."""
    states, columns = x.size, W.shape[1]
    for i in range(states):
        total = 0.0
        for c in range(W.shape[0] - states):
            total += W[states + c, i] * line[columns + c]
        w[i] = total
    for i in range(W.shape[0]):
        factor = x[i] if i < states else line[columns + i - states]
        for j in range(sums.shape[1]):
            sums[i, j] += factor * line[j]


@part
def _step_back(
    F: Numbers, half: Numbers, w: Numbers, work: Numbers, x: Numbers, P: Numbers
) -> None:
    """Write x~ and P~ of the sample to ``x`` and ``P``, which have those of the next one.

    ``work`` (1+x, x).
    """
    states = x.size
    f = work[states]
    for i in range(states):
        total = 0.0
        for j in range(states):
            total += F[j, i] * x[j]
        f[i] = total
        for j in range(states):
            total = 0.0
            for k in range(states):
                total += P[i, k] * F[k, j]
            work[i, j] = total
    for i in range(states):
        x[i] = f[i] - w[i]
        for j in range(i + 1):
            total = half[i, j] + 0.5 * (f[i] * w[j] + w[i] * f[j] - w[i] * w[j])
            for k in range(states):
                total += F[k, i] * work[k, j]
            P[i, j] = total
            P[j, i] = total


@part
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


@part
def _close_stage(
    mean: Numbers, joints: Numbers, sums: Numbers, H: Numbers, product: Numbers, out: Numbers
) -> None:
    """Add the part of a stage to ``out``: dF/dW and after it dF/dQ.

    It follows from the stage's sums and its sum of H. ``product`` (x+y, x) becomes 2 W_x P.
    """
    rows, columns = mean.shape
    states = joints.shape[1] - rows
    for i in range(rows):
        for k in range(states):
            total = 0.0
            for m in range(states):
                total += mean[i, m] * joints[m, rows + k]
            product[i, k] = 2.0 * total
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
                out[i, k] += H[i, j] * product[j, k]


@lean
def _back(
    mean: Numbers,
    which: Places,
    trail: tuple[Numbers, Numbers],
    stage: tuple[Numbers, ...],
    adjoint: tuple[Numbers, Numbers],
    out: Numbers,
) -> None:
    """Write as ``likelihood_slope`` does.

    ``adjoint`` (x~ and P~) goes from last to first.
    """
    path, joints = trail
    F, half, w, work, sums, sum_of_P, H, product = stage
    x, P = adjoint
    states, wide, samples = x.size, path.shape[1] - 2, 0.0
    for back in range(which.size):
        k = which.size - 1 - back
        W, line = mean[which[k]], path[k]
        place = int(line[wide + 1])
        if samples == 0.0:
            _stage(W, joints[place], F, half)
        samples += 1.0
        _collect(W, line, x, w, sums)
        for i in range(states):
            for j in range(states):
                sum_of_P[i, j] += P[i, j]
        _step_back(F, half, w, work, x, P)
        if k == 0 or int(path[k - 1, wide + 1]) != place:
            _sum_of_h(joints[place], sums[:, mean.shape[2] :], sum_of_P, samples, H)
            _close_stage(W, joints[place], sums, H, product, out[which[k]])
            clear(sums)
            clear(sum_of_P)
            samples = 0.0


@kernel
def likelihood_slope(
    mean: Numbers, which: Places, path: Numbers, joints: Numbers, out: Numbers, start: Numbers
) -> None:
    """Write the gradient of F, which is minus the log-likelihood.

    ``out`` (m, x+y, columns + x+y) has dF/dW and dF/dQ, ``start`` has dF/dx0 and dF/dP0. ``path``
    and ``joints`` are those of ``trail``.
    """
    rows, states, wide = mean.shape[1], start.shape[0], path.shape[1] - 2
    square, oblong = (states, states), (rows, states)
    x, P = np.zeros(states), np.zeros(square)
    scratch = np.empty(square), np.empty(square), np.empty(states), np.empty((1 + states, states))
    sums = np.zeros((rows, wide)), np.zeros(square), np.empty((rows, rows)), np.empty(oblong)
    clear(out)
    _back(mean, which, (path, joints), (*scratch, *sums), (x, P), out)
    put(x, 0, start[:, 0])
    put_block(P, 1, start)

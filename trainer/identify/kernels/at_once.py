"""What the loops of parts do, by whole arrays: few steps for the interpreter instead of many.

Each function is named after the part that it stands in for (``kernel.part_or``), takes what that
takes and writes the same, to rounding. Compiled, the loops are quicker.
"""

import math

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.kernels.entries import Entries


def put(source: Entries, at: int, out: Entries) -> None:
    """Write what ``blocks.put`` does."""
    out[at : at + source.size] = source


def put_block(source: Entries, at: int, out: Entries) -> None:
    """Write what ``blocks.put_block`` does."""
    out[: source.shape[0], at : at + source.shape[1]] = source


def clear(out: Entries) -> None:
    """Write what ``blocks.clear`` does."""
    out[...] = 0.0


def mean_series(drift: Entries, h: complex, room: Entries, mean: Entries) -> None:
    """Write what ``sampling.mean_series`` does."""
    del room
    rows = len(drift)
    term = drift * h
    mean[:] = term
    mean[:, :rows] += np.eye(rows)
    for order in range(2, 17):
        term = drift[:, :rows] @ term * (h / order)
        mean += term


def noise_series(
    drift: Entries, noise: Entries, h: complex, room: Entries, covariance: Entries
) -> None:
    """Write what ``sampling.noise_series`` does."""
    del room
    term = noise * h
    covariance[:] = term
    for order in range(2, 20):
        product = drift[:, : len(noise)] @ term
        term = (product + product.T) * (h / order)
        covariance += term


def carry(mean: Entries, covariance: Entries, product: Entries, later: Entries) -> None:
    """Write what ``sampling.carry`` does."""
    del product
    phi = mean[:, : len(covariance)]
    later += phi @ covariance @ phi.T


def times(left: Entries, right: Entries, out: Entries) -> None:
    """Write what ``sampling.times`` does."""
    out[:] = left[:, : len(out)] @ right[:, : out.shape[1]]


def joint(mean: Entries, noise: Entries, P: Entries, work: Entries, out: Entries) -> None:
    """Write what ``covariance_filter.joint`` does."""
    del work
    W = mean[:, : len(P)]
    both = W @ P @ W.T + noise
    out[:] = 0.5 * (both + both.T)


def predict(mean: Entries, z: Entries, out: Entries) -> None:
    """Write what ``covariance_filter.predict`` does."""
    out[:] = mean @ z


def sweep(J: Entries, pivot: int) -> float:
    """Return and write what ``covariance_filter.sweep`` does."""
    d = J[pivot, pivot]
    gain = J[:, pivot] / d
    J -= gain[:, None] * J[pivot]
    J[:, pivot] = J[pivot] = gain
    J[pivot, pivot] = -1.0 / d
    return d


def take(J: Numbers, place: int, error: float, v: Numbers) -> None:
    """Write what ``likelihood.take`` does."""
    gain = J[place, :place] / J[place, place]
    v[:place] += gain * error
    J[:place, :place] -= gain[:, None] * J[place, :place]


def stage(mean: Numbers, J: Numbers, F: Numbers, half: Numbers) -> None:
    """Write what ``adjoint.stage`` does."""
    x, rows = len(F), len(mean)
    C = mean[x:, :x]
    F[:] = mean[:x, :x] - J[:x, x:rows] @ C
    half[:] = -0.5 * (C.T @ J[x:, x:rows] @ C)


def collect(W: Numbers, line: Numbers, x: Numbers, w: Numbers, sums: Numbers) -> None:
    """Write what ``adjoint.collect`` does."""
    states, wide = len(x), sums.shape[1]
    s = line[W.shape[1] : wide]
    w[:] = s @ W[states:, :states]
    sums[:states] += x[:, None] * line[:wide]
    sums[states:] += s[:, None] * line[:wide]


def step_back(F: Numbers, half: Numbers, w: Numbers, work: Numbers, x: Numbers, P: Numbers) -> None:
    """Write what ``adjoint.step_back`` does."""
    del work
    f = F.T @ x
    mixed = f[:, None] * w
    P[:] = half + 0.5 * (mixed + mixed.T - w[:, None] * w) + F.T @ P @ F
    x[:] = f - w


def sum_of_h(J: Numbers, sums: Numbers, adjoint: Numbers, samples: float, H: Numbers) -> None:
    """Write what ``adjoint.sum_of_h`` does."""
    x, rows = len(adjoint), len(J)
    K = J[:x, x:rows]
    carried, mixed = adjoint @ K, K.T @ sums[:x]
    H[:x, :x] = adjoint
    H[:x, x:] = 0.5 * sums[:x] - carried
    H[x:, :x] = H[:x, x:].T
    H[x:, x:] = K.T @ carried - 0.5 * (samples * J[x:, x:rows] + sums[x:] + mixed + mixed.T)


def close_stage(
    mean: Numbers, joints: Numbers, sums: Numbers, H: Numbers, product: Numbers, out: Numbers
) -> None:
    """Write what ``adjoint.close_stage`` does."""
    rows, columns = mean.shape
    x = joints.shape[1] - rows
    product[:] = 2.0 * (mean[:, :x] @ joints[:x, rows:])
    out[:x, :columns] += sums[:x, :columns]
    out[x:, :columns] -= sums[x:, :columns] + joints[:x, x:rows].T @ sums[:x, :columns]
    out[:, columns:] += H
    out[:, :x] += H @ product


def half_slopes(mean: Numbers, slopes: Numbers, P: Numbers, dP: Numbers, half: Numbers) -> None:
    """Write what ``sensitivity.half_slopes`` does."""
    x = len(P)
    moved = mean[:, :x] @ dP.reshape(x, -1)
    half[:] = P.T @ slopes[:, :x] + 0.5 * moved.reshape(half.shape)


def joint_slopes(mean: Numbers, half: Numbers, out: Numbers) -> None:
    """Write what ``sensitivity.joint_slopes`` does."""
    both = mean[:, : half.shape[1]] @ half
    out += both + both.swapaxes(0, 1)


def conditioned(J: Numbers, dJ: Numbers, lines: Numbers, dP: Numbers) -> float:
    """Return and write what ``sensitivity.conditioned`` does."""
    del lines
    x = len(dP)
    K, mixed = J[:x, x:], J[:x, x:] @ dJ[:x, x:]
    inner = K @ dJ[x:, x:]
    outer = (K @ inner.reshape(len(inner), -1)).reshape(dP.shape)
    value = dJ[:x, :x] - mixed - mixed.swapaxes(0, 1) + outer
    width = np.diag(J)[:x]
    weight = np.tril(1.0 / np.maximum(np.abs(width[:, None] * width), 1e-300)).ravel()
    change = weight @ np.square(value - dP).reshape(x * x, -1)
    total = weight @ np.square(value).reshape(x * x, -1)
    dP[:] = value
    moved = change > 0.0
    return float(np.max(change[moved] / np.maximum(total[moved], 1e-300), initial=0.0))


def gain_slopes(J: Numbers, dJ: Numbers, states: int, line: Numbers) -> None:
    """Write what ``sensitivity.gain_slopes`` does."""
    del line
    K, R = J[:states, states:], J[states:, states:]
    lines = dJ[:states, states:] - (K @ dJ[states:, states:]).swapaxes(0, 1)
    dJ[:states, states:] = -(R @ lines)


def mean_slopes(mean: Numbers, slopes: Numbers, z: Numbers, dx: Numbers, out: Numbers) -> None:
    """Write what ``sensitivity.mean_slopes`` does."""
    out[:] = z @ slopes + mean[:, : len(dx)] @ dx


def standardised(U: Numbers, dv: Numbers, states: int, out: Numbers) -> None:
    """Write what ``sensitivity.standardised`` does."""
    out[:] = -(U @ dv[states:])


def next_slopes(J: Numbers, dJ: Numbers, error: Numbers, dv: Numbers, dx: Numbers) -> None:
    """Write what ``sensitivity.next_slopes`` does."""
    x = len(dx)
    dx[:] = dv[:x] + error @ dJ[:x, x:] - J[:x, x:] @ dv[x:]


def covariance_rows(U: Numbers, dJ: Numbers, samples: float, out: Numbers) -> None:
    """Write what ``sensitivity.covariance_rows`` does."""
    states = len(dJ) - len(U)
    both = U @ (U @ dJ[states:, states:]).reshape(len(U), -1)
    out[:] = math.sqrt(0.5 * samples) * both.reshape(out.shape)

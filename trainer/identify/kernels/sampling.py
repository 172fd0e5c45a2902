"""A continuous linear system over one sampling interval, exactly.

Equation numbers are those of the model document (MI): 7.1 matrices, 7.2 time lag, 7.3 noise,
7.4 integrating measurements. Everything is complex, so that an imaginary step of 1e-100 in one
parameter carries its exact derivative through.

A system with states x, inputs u and outputs y is one block matrix ``drift``, rows (x, y), columns
(x, u, 1): [A B f; C D d]. Sampled it is ``mean``, columns (x, u of the last sample, u of this
one, 1). ``noise`` and ``covariance`` are the covariances of the same rows.
"""

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.identify.kernels.blocks import clear
from trainer.identify.kernels.kernel import kernel

Complexes = NDArray[np.complex128]


@kernel
def size(matrix: Complexes) -> float:
    """Return the largest row sum of magnitudes of the real parts of a square block [-]."""
    largest = 0.0
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[0]):
            total += abs(matrix[i, j].real)
        largest = max(largest, total)
    return largest


@kernel
def _times(left: Complexes, right: Complexes, out: Complexes) -> None:
    """Write the leading square of ``left`` times ``right`` to ``out``."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            total = 0j
            for k in range(out.shape[0]):
                total += left[i, k] * right[k, j]
            out[i, j] = total


@kernel
def _mean_series(drift: Complexes, h: complex, mean: Complexes) -> None:
    """Write [Phi Gamma] over a short ``h`` [s]: the power series of exp([A B; 0 0] h)."""
    rows, columns = drift.shape
    term = np.empty((rows, columns), np.complex128)
    product = np.empty((rows, columns), np.complex128)
    for i in range(rows):
        for j in range(columns):
            term[i, j] = drift[i, j] * h
            mean[i, j] = term[i, j]
        mean[i, i] += 1.0
    for order in range(2, 17):
        _times(drift, term, product)
        factor = h / order
        for i in range(rows):
            for j in range(columns):
                term[i, j] = product[i, j] * factor
                mean[i, j] += term[i, j]


@kernel
def _noise_series(drift: Complexes, noise: Complexes, h: complex, covariance: Complexes) -> None:
    """Write the integral of exp(A s) R exp(A' s) over a short ``h`` [s] as its power series."""
    rows = noise.shape[0]
    term = np.empty((rows, rows), np.complex128)
    product = np.empty((rows, rows), np.complex128)
    for i in range(rows):
        for j in range(rows):
            term[i, j] = noise[i, j] * h
            covariance[i, j] = term[i, j]
    for order in range(2, 20):
        _times(drift, term, product)
        factor = h / order
        for i in range(rows):
            for j in range(rows):
                term[i, j] = (product[i, j] + product[j, i]) * factor
                covariance[i, j] += term[i, j]


@kernel
def _carry(mean: Complexes, covariance: Complexes, later: Complexes) -> None:
    """Write ``later`` plus Phi ``covariance`` Phi' to ``later``."""
    rows = covariance.shape[0]
    product = np.empty((rows, rows), np.complex128)
    _times(mean, covariance, product)
    for i in range(rows):
        for j in range(rows):
            total = later[i, j]
            for k in range(rows):
                total += product[i, k] * mean[j, k]
            later[i, j] = total


@kernel
def _double(mean: Complexes, covariance: Complexes) -> None:
    """Write the mean and covariance of two equal intervals over those of one."""
    rows, columns = mean.shape
    once = mean.copy()
    _carry(once, covariance.copy(), covariance)
    _times(once, once, mean)
    for i in range(rows):
        for j in range(rows, columns):
            mean[i, j] += once[i, j]


@kernel
def propagate(
    drift: Complexes, noise: Complexes, h: complex, mean: Complexes, covariance: Complexes
) -> None:
    """Write [Phi Gamma] and the accumulated noise over ``h`` [s] (MI 7.1, 7.3).

    Series over h / 2^n, doubled n times: nothing decays backwards, so no interval is too long.
    """
    doublings = 0
    largest = size(drift) * abs(h.real)
    while largest > 0.5 and doublings < 60:
        largest *= 0.5
        doublings += 1
    short = h * 0.5**doublings
    _mean_series(drift, short, mean)
    _noise_series(drift, noise, short, covariance)
    for _ in range(doublings):
        _double(mean, covariance)


@kernel
def _bounded(lag: complex, interval: float) -> complex:
    """Return ``lag`` [s] within 0 and ``interval`` [s]."""
    if lag.real <= 0.0:
        return 0j
    return lag if lag.real < interval else interval + 0j


@kernel
def _over(
    drift: Complexes, noise: Complexes, ends: Complexes, mean: Complexes, covariance: Complexes
) -> None:
    """Write one interval whose inputs switch inside it (MI 7.2).

    ``ends`` [s]: how long the old input acts, then how long the new one does.
    """
    rows, columns = drift.shape
    inputs = columns - rows - 1
    before = np.empty((rows, columns), np.complex128)
    after = np.empty((rows, columns), np.complex128)
    early = np.empty((rows, rows), np.complex128)
    propagate(drift, noise, ends[0], before, early)
    propagate(drift, noise, ends[1], after, covariance)
    _carry(after, early, covariance)
    for i in range(rows):
        for j in range(columns):
            total = 0j
            for k in range(rows):
                total += after[i, k] * before[k, j]
            mean[i, j if j < columns - 1 else columns - 1 + inputs] = total
        for j in range(inputs):
            mean[i, columns - 1 + j] = after[i, rows + j]
        mean[i, columns - 1 + inputs] += after[i, columns - 1]


@kernel
def sample_instants(
    drift: Complexes,
    noise: Complexes,
    lag: Complexes,
    intervals: Numbers,
    mean: Complexes,
    covariance: Complexes,
) -> None:
    """Write the sampled systems with readings taken at the instants (MEAS 0, MI 4 and 7).

    ``drift`` (b, x+y, x+u+1), ``noise`` (b, x+y, x+y), ``lag`` (b,) [s], ``intervals`` (m,) [s];
    ``mean`` (b, m, x+y, x+2u+1), ``covariance`` (b, m, x+y, x+y). A reading sees the input of
    its own instant.
    """
    batch, rows, columns = drift.shape
    inputs = mean.shape[3] - columns
    states = columns - inputs - 1
    ends = np.empty(2, np.complex128)
    clear(mean)
    clear(covariance)
    for b in range(batch):
        for m in range(intervals.size):
            ends[0] = _bounded(lag[b], intervals[m])
            ends[1] = intervals[m] - ends[0]
            _over(
                drift[b, :states],
                noise[b, :states, :states],
                ends,
                mean[b, m, :states],
                covariance[b, m, :states, :states],
            )
            for i in range(states, rows):
                for j in range(columns):
                    mean[b, m, i, j if j < states else j + inputs] = drift[b, i, j]
                for j in range(states, rows):
                    covariance[b, m, i, j] = noise[b, i, j]


@kernel
def sample_integrals(
    drift: Complexes,
    noise: Complexes,
    lag: Complexes,
    intervals: Numbers,
    mean: Complexes,
    covariance: Complexes,
) -> None:
    """Write the sampled systems with readings summed over the interval (MEAS 1, MI 7.4).

    Shapes as in ``sample_instants``; the readings' rows of ``drift`` and ``noise`` are rates.
    """
    batch, rows, columns = drift.shape
    inputs = mean.shape[3] - columns
    states = columns - inputs - 1
    ends = np.empty(2, np.complex128)
    stacked = np.zeros((rows, rows + inputs + 1), np.complex128)
    whole = np.empty((rows, rows + 2 * inputs + 1), np.complex128)
    for b in range(batch):
        for i in range(rows):
            for j in range(columns):
                stacked[i, j if j < states else j + rows - states] = drift[b, i, j]
        for m in range(intervals.size):
            ends[0] = _bounded(lag[b], intervals[m])
            ends[1] = intervals[m] - ends[0]
            _over(stacked, noise[b], ends, whole, covariance[b, m])
            for i in range(rows):
                for j in range(mean.shape[3]):
                    mean[b, m, i, j] = whole[i, j if j < states else j + rows - states]

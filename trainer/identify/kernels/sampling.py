"""A continuous linear system over one sampling interval, exactly.

Equation numbers are those of the model document (MI): 7.1 matrices, 7.2 time lag, 7.3 noise, 7.4
integrating measurements. Everything may be complex, because an imaginary step of 1e-100 in one
parameter carries its exact derivative through. For real arrays the same source is compiled for real
numbers, which are faster.

A system with states x, inputs u and outputs y is one block matrix ``drift``: its rows are (x, y),
its columns (x, u, 1): [A B f; C D d]. The sampled system is ``mean``; its columns are (x, u of the
last sample, u of this one, 1). ``noise`` and ``covariance`` are the covariances of the same rows.
``model/sampled`` calls ``sample_blocks``, because readings come at moments and motion is
continuous.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.identify.kernels.kernel import Entries, inline_kernel, kernel, lean_kernel, put_block

Complexes = NDArray[np.complex128]
OLD, NEW = 0, 1  # indices in the time that each of two inputs acts


class Room(NamedTuple):
    """Scratch: the first four have the shape of [A B f], the others are square."""

    term: Entries
    product: Entries
    before: Entries
    after: Entries
    square_term: Entries
    square_product: Entries
    early: Entries


class ContinuousBlocks(NamedTuple):
    """Continuous systems."""

    drift: Entries  # (b, x+y, x+u+1)
    noise: Entries  # (b, x+y, x+y)
    lag: Entries  # (b,) [s]


class SampledBlocks(NamedTuple):
    """Systems from sample to sample: for each parameter vector and each interval."""

    mean: Entries  # (b, m, x+y, x+2u+1)
    covariance: Entries  # (b, m, x+y, x+y)


@inline_kernel
def block_size(matrix: Entries) -> float:
    """Return the largest row sum of a square block [-].

    It sums the magnitudes of the real parts.
    """
    largest = 0.0
    for i in range(matrix.shape[0]):
        total = 0.0
        for j in range(matrix.shape[0]):
            total += abs(matrix[i, j].real)
        largest = max(largest, total)
    return largest


@inline_kernel
def _times(left: Entries, right: Entries, out: Entries) -> None:
    """Write the leading square of ``left`` times ``right`` to ``out``."""
    for i in range(out.shape[0]):
        for j in range(out.shape[1]):
            total = left[i, 0] * right[0, j]
            for k in range(1, out.shape[0]):
                total += left[i, k] * right[k, j]
            out[i, j] = total


@inline_kernel
def _mean_series(drift: Entries, h: complex, room: Room, mean: Entries) -> None:
    """Write [Phi Gamma] over a short ``h`` [s]: the power series of exp([A B; 0 0] h)."""
    rows, columns = drift.shape
    term, product = room.term, room.product
    for i in range(rows):
        for j in range(columns):
            term[i, j] = drift[i, j] * h
            mean[i, j] = term[i, j]
        mean[i, i] += 1.0
    for order in range(2, 17):  # |A| h is at most 0.5: what is left is below 0.5^17/17! = 2e-20
        _times(drift, term, product)
        factor = h / order
        for i in range(rows):
            for j in range(columns):
                term[i, j] = product[i, j] * factor
                mean[i, j] += term[i, j]


@inline_kernel
def _noise_series(
    drift: Entries, noise: Entries, h: complex, room: Room, covariance: Entries
) -> None:
    """Write the integral of exp(A s) R exp(A' s) over a short ``h`` [s] as its power series."""
    rows = noise.shape[0]
    term, product = room.square_term, room.square_product
    for i in range(rows):
        for j in range(rows):
            term[i, j] = noise[i, j] * h
            covariance[i, j] = term[i, j]
    for order in range(2, 20):  # each order has A from left and right: below 1/20! = 4e-19
        _times(drift, term, product)
        factor = h / order
        for i in range(rows):
            for j in range(rows):
                term[i, j] = (product[i, j] + product[j, i]) * factor
                covariance[i, j] += term[i, j]


@inline_kernel
def _carry(mean: Entries, covariance: Entries, product: Entries, later: Entries) -> None:
    """Write ``later`` plus Phi ``covariance`` Phi' to ``later``; ``product`` is scratch."""
    rows = covariance.shape[0]
    _times(mean, covariance, product)
    for i in range(rows):
        for j in range(rows):
            total = later[i, j]
            for k in range(rows):
                total += product[i, k] * mean[j, k]
            later[i, j] = total


@inline_kernel
def _double(room: Room, mean: Entries, covariance: Entries) -> None:
    """Write the mean and covariance of two equal intervals over those of one."""
    rows, columns = mean.shape
    once, early = room.term, room.square_term
    put_block(mean, 0, once)
    put_block(covariance, 0, early)
    _carry(once, early, room.square_product, covariance)
    _times(once, once, mean)
    for i in range(rows):
        for j in range(rows, columns):
            mean[i, j] += once[i, j]


@lean_kernel
def propagate_block(
    drift: Entries, noise: Entries, h: complex, room: Room, mean: Entries, covariance: Entries
) -> None:
    """Write [Phi Gamma] and the accumulated noise over ``h`` [s] (MI 7.1, 7.3).

    A power series over the short time h / 2^n, doubled n times. The exponential of MI 7.3 has -A in
    it, which grows without bound over a long interval; a doubling only goes forward in time.
    """
    doublings = 0
    # up to 0.5 the series are exact to rounding; 60 doublings bound the loop
    largest = block_size(drift) * abs(h.real)
    while largest > 0.5 and doublings < 60:
        largest *= 0.5
        doublings += 1
    short = h * 0.5**doublings
    _mean_series(drift, short, room, mean)
    _noise_series(drift, noise, short, room, covariance)
    for _ in range(doublings):
        _double(room, mean, covariance)


@inline_kernel
def _bound_lag(lag: complex, interval: float) -> complex:
    """Return ``lag`` [s] within 0 and ``interval`` [s], without a derivative at these limits."""
    if lag.real <= 0.0:
        return 0.0 * lag
    return lag if lag.real < interval else interval + 0.0 * lag


@inline_kernel
def _over(
    drift: Entries, noise: Entries, ends: Entries, room: Room, mean: Entries, covariance: Entries
) -> None:
    """Write the system over one interval, in which the new input takes over after the lag (MI 7.2).

    ``ends`` [s]: how long the old input acts, then how long the new one does.
    """
    rows, columns = drift.shape
    inputs = columns - rows - 1
    constant = columns - 1
    before, after, early = room.before, room.after, room.early
    propagate_block(drift, noise, ends[OLD], room, before, early)
    propagate_block(drift, noise, ends[NEW], room, after, covariance)
    _carry(after, early, room.square_term, covariance)
    for i in range(rows):
        for j in range(columns):
            total = after[i, 0] * before[0, j]
            for k in range(1, rows):
                total += after[i, k] * before[k, j]
            mean[i, j if j < constant else constant + inputs] = total
        for j in range(inputs):
            mean[i, constant + j] = after[i, rows + j]
        mean[i, constant + inputs] += after[i, constant]


@inline_kernel
def _part_columns(source: Entries, states: int, by: int, out: Entries) -> None:
    """Write ``source`` to ``out``, with the columns behind the states moved on by ``by``."""
    for i in range(source.shape[0]):
        for j in range(source.shape[1]):
            out[i, j if j < states else j + by] = source[i, j]


@kernel
def sample_blocks(
    blocks: ContinuousBlocks, intervals: Numbers, moving: int, out: SampledBlocks
) -> None:
    """Write the sampled systems, of which the first ``moving`` rows run over the interval.

    ``intervals`` (m,) [s]; ``out`` must have zeros before. If only the states move (MEAS 0, MI 4),
    a reading sees the input of its own instant. If the readings move too (MEAS 1, MI 7.4), their
    rows of ``drift`` are rates, which are summed from zero over the interval.
    """
    drift, noise, lag = blocks.drift, blocks.noise, blocks.lag
    mean, covariance = out.mean, out.covariance
    batch, rows, columns = drift.shape
    inputs = mean.shape[3] - columns
    states = columns - inputs - 1
    ends = np.empty(2, drift.dtype)
    stacked = np.zeros((moving, moving + inputs + 1), drift.dtype)
    width, kind = moving + inputs + 1, drift.dtype
    room = Room(
        np.empty((moving, width), kind),
        np.empty((moving, width), kind),
        np.empty((moving, width), kind),
        np.empty((moving, width), kind),
        np.empty((moving, moving), kind),
        np.empty((moving, moving), kind),
        np.empty((moving, moving), kind),
    )
    whole = np.empty((moving, moving + 2 * inputs + 1), drift.dtype)
    for b in range(batch):
        _part_columns(drift[b, :moving], states, moving - states, stacked)
        for m in range(intervals.size):
            ends[OLD] = _bound_lag(lag[b], intervals[m])
            ends[NEW] = intervals[m] - ends[OLD]
            around = covariance[b, m, :moving, :moving]
            _over(stacked, noise[b, :moving, :moving], ends, room, whole, around)
            for i in range(moving):
                for j in range(mean.shape[3]):
                    mean[b, m, i, j] = whole[i, j if j < states else j + moving - states]
            for i in range(moving, rows):
                for j in range(states, rows):
                    covariance[b, m, i, j] = noise[b, i, j]
            _part_columns(drift[b, moving:], states, inputs, mean[b, m, moving:])

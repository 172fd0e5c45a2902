"""Continuous systems sampled exactly (model document 7), and derivatives by an imaginary step.

Filters and costs take their matrices from here; MI is the model document. f(x + i h) = f(x) + i h
f'(x) + O(h^2): with h = 1e-100 the imaginary part is the derivative to the last bit, because
nothing is subtracted. So every cost has an exact gradient, without formulas of its own for each
model.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.kernels.covariance_filter import SampledSystem
from trainer.identify.kernels.kernel import Complexes, Entries
from trainer.identify.kernels.sampling import propagate_blocks
from trainer.identify.model.models import Blocks

COMPLEX_STEP: Final = 1e-100  # imaginary part that carries a derivative without rounding
VECTOR_LANES: Final = 4  # numbers that a processor takes at a time


def step_aside(theta: Numbers, free: Sequence[int] | None = None) -> Complexes:
    """Return ``theta`` (n,), then rows with an imaginary step at one (free) index each."""
    indices = np.arange(len(theta)) if free is None else np.array(free, int)
    rows = np.tile(theta.astype(complex), (1 + len(indices), 1))
    rows[np.arange(1, 1 + len(indices)), indices] += 1j * COMPLEX_STEP
    return rows


@dataclass(frozen=True)
class SampledSystems:
    """Systems from sample to sample and their start, for each of a batch of parameters.

    Rows are (next state, reading), columns (state, old input, input, 1), or of inputs that go
    straight (state, input, slope before, slope, 1). Imaginary parts, where there are any, are
    derivatives times COMPLEX_STEP.
    """

    mean: Entries  # (b, m, x+y, x+2u+1) or (b, m, x+y, x+3u+1)
    noise: Entries  # (b, m, x+y, x+y)
    start: Entries  # (b, x, 1+x)
    gain: Entries | None = None  # (b, x, y) of a predictor, where the model gives it

    def at(self, row: int) -> SampledSystem:
        """Return mean, noise and start of one row, real."""
        parts = (self.mean[row], self.noise[row], self.start[row])
        mean, noise, start = (np.ascontiguousarray(part.real) for part in parts)
        return SampledSystem(mean, noise, start)

    def as_complex(self) -> "SampledSystems":
        """Return the same numbers as complex ones.

        Kernels of predictors are compiled for these alone.
        """
        parts = (self.mean, self.noise, self.start, self.gain)
        return SampledSystems(
            *(None if x is None else x.astype(complex, copy=False) for x in parts)  # type: ignore[arg-type]
        )

    def slopes(self) -> SampledSystem:
        """Return the derivatives of mean, noise and start, parameters last, from rows 1 on.

        Zeros fill them up to a whole number of VECTOR_LANES, so that a processor's loops over
        parameters leave no remainder, which would be slow.
        """
        parts = (self.mean[1:], self.noise[1:], self.start[1:])
        mean, noise, start = (
            _filled(np.moveaxis(part.imag, 0, -1) / COMPLEX_STEP) for part in parts
        )
        return SampledSystem(mean, noise, start)


def _filled(slopes: Numbers) -> Numbers:
    """Return ``slopes`` with zeros after them, up to a whole number of VECTOR_LANES."""
    count = slopes.shape[-1]
    whole = np.zeros((*slopes.shape[:-1], count + -count % VECTOR_LANES))
    whole[..., :count] = slopes
    return whole


def sample_systems(
    blocks: Blocks, intervals: Numbers, sampling: str, between_readings: str = "step"
) -> SampledSystems:
    """Return ``blocks`` sampled at ``intervals`` (m,) [s].

    ``sampling`` is "instantaneous" or "integrating" of continuous systems, whose readings are taken
    at the instant or summed over the interval that follows, or "discrete" of matrices of one step.
    ``between_readings`` is that of ``Samples``; discrete matrices know steps alone.
    """
    if between_readings == "straight":
        return _sample_ramps(blocks, intervals, sampling)
    if not np.all(intervals > 0.0):
        raise ConfigError("times: each must be later than the one before")
    states, rows = blocks.start.shape[1], blocks.drift.shape[1]
    moving = {"discrete": 0, "instantaneous": states, "integrating": rows}[sampling]
    return _sample_steps(blocks, intervals, moving)


def _sample_steps(blocks: Blocks, intervals: Numbers, moving: int) -> SampledSystems:
    """Return ``blocks`` of which the first ``moving`` rows run over the interval (MI 7.2, 7.4).

    The old input acts until the lag, then the new one. If only the states move (MEAS 0, MI 4), a
    reading sees the input of its own instant. If the readings move too (MEAS 1), their rows of
    ``drift`` are rates, which are summed from zero over the interval.
    """
    drift, states = blocks.drift, blocks.start.shape[1]
    batch, rows, columns = drift.shape
    inputs = columns - states - 1
    acts, now = moving + inputs, states + inputs  # columns: behind both, and of the new input
    mean = np.zeros((batch, intervals.size, rows, columns + inputs), drift.dtype)
    noise = np.zeros((batch, intervals.size, rows, rows), drift.dtype)
    mean[..., moving:, :states] = drift[:, None, moving:, :states]
    mean[..., moving:, now:] = drift[:, None, moving:, states:]
    noise[..., moving:, moving:] = blocks.noise[:, None, moving:, moving:]
    if moving:
        stacked = np.zeros((batch, moving, acts + 1), drift.dtype)
        stacked[..., :states] = drift[:, :moving, :states]
        stacked[..., moving:] = drift[:, :moving, states:]
        disturbed, lag = blocks.noise[:, :moving, :moving].copy(), _lag_within(blocks, intervals)
        before, early = _propagate(stacked, disturbed, lag)
        after, later = _propagate(stacked, disturbed, intervals - lag)
        Phi = after[..., :moving]
        whole = Phi @ before
        mean[..., :moving, :states] = whole[..., :states]
        mean[..., :moving, states:now] = whole[..., moving:acts]
        mean[..., :moving, now:] = after[..., moving:]
        mean[..., :moving, -1] += whole[..., -1]
        noise[..., :moving, :moving] = later + Phi @ early @ Phi.swapaxes(2, 3)
    return SampledSystems(mean, noise, blocks.start, blocks.gain)


def _propagate(drift: Entries, noise: Entries, h: Entries) -> tuple[Entries, Entries]:
    """Return [Phi Gamma] and the noise over times ``h`` (b, m) [s]."""
    size = drift.shape[1]
    mean = np.empty((*h.shape, *drift.shape[1:]), drift.dtype)
    covariance = np.empty((*h.shape, size, size), drift.dtype)
    propagate_blocks(drift, noise, h, mean, covariance)
    return mean, covariance


def _lag_within(blocks: Blocks, intervals: Numbers) -> Entries:
    """Return the lag (b, m) [s] within each interval, without a derivative at its ends."""
    lag = blocks.lag[:, None]
    inside = (lag.real > 0.0) & (lag.real < intervals)
    return np.asarray(np.where(inside, lag, np.clip(lag.real, 0.0, intervals)))


def _sample_ramps(blocks: Blocks, intervals: Numbers, sampling: str) -> SampledSystems:
    """Return ``blocks`` sampled under inputs that rise evenly from reading to reading.

    Exactly: an input becomes a state of which the slope is the input (a first-order hold by the
    matrix exponential of the augmented system; C. F. Van Loan, IEEE Transactions on Automatic
    Control 23 (1978), 395-404). During the lag the slope before the reading acts.
    """
    batch, rows, columns = blocks.drift.shape
    states = blocks.start.shape[1]
    inputs, acts = columns - states - 1, states + (columns - states - 1)
    drift = np.zeros((batch, rows + inputs, columns + inputs), blocks.drift.dtype)
    kept = [*range(states), *range(acts, rows + inputs)]  # rows that are no inputs
    drift[:, kept, :acts] = blocks.drift[..., :acts]
    drift[:, kept, -1] = blocks.drift[..., -1]
    drift[:, range(states, acts), range(acts, acts + inputs)] = 1.0
    noise = np.zeros((batch, rows + inputs, rows + inputs), blocks.noise.dtype)
    noise[np.ix_(range(batch), kept, kept)] = blocks.noise
    start = np.zeros((batch, acts, 1 + acts), blocks.start.dtype)
    ramps = Blocks(drift, noise, start, blocks.lag)
    whole = sample_systems(ramps, intervals, sampling)
    mean = whole.mean[:, :, kept].copy()
    # what acts at a reading is the input of a lag before; readings of the instant have no lag
    late = _lag_within(blocks, intervals)
    moving = slice(None) if sampling == "integrating" else slice(states)
    early = late[..., None, None] * mean[:, :, moving, states:acts]
    mean[:, :, moving, acts : acts + inputs] -= early
    noise_kept = np.ascontiguousarray(whole.noise[:, :, kept][..., kept])
    return SampledSystems(mean, noise_kept, blocks.start, blocks.gain)

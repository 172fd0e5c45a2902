"""Records that a model would give: what Monte-Carlo studies are made of (MI 8.5)."""

from dataclasses import replace

import numpy as np

from trainer.config import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.kernels.simulation import simulate
from trainer.identify.likelihood import possible
from trainer.identify.problem import Problem
from trainer.identify.samples import Samples


def root(covariance: Numbers) -> Numbers:
    """Return C with C C' = ``covariance`` (..., n, n), which may be singular.

    Rounding counts as nothing: units differ by many powers of ten, so each is taken by its own.
    """
    width = np.sqrt(np.maximum(np.einsum("...ii->...i", covariance), 0.0))
    unit = np.where(width > 0.0, width, 1.0)
    sizes, vectors = np.linalg.eigh(covariance / (unit[..., None] * unit[..., None, :]))
    return np.asarray(
        width[..., None] * vectors * np.sqrt(np.maximum(sizes, 0.0))[..., None, :], float
    )


def deterministic(problem: Problem, theta: Numbers) -> Numbers:
    """Return states and outputs (n, x+y) of the model left alone from its start: no noise at all.

    The states are SI, the outputs in knots and degrees.
    """
    mean, _, start = problem.sampled(theta).at(0)
    samples = problem.samples
    out = np.empty((len(samples.t), mean.shape[1]))
    still = np.zeros_like(out)
    inputs = samples.table[:, samples.outputs.shape[1] :]
    simulate(mean, start[:, 0], np.ascontiguousarray(inputs), samples.steps[1], still, out)
    return out


def drawn(problem: Problem, theta: Numbers, stream: np.random.Generator) -> Samples:
    """Return the samples with outputs drawn from the model; missing readings stay missing."""
    sampled = problem.sampled(theta)
    if not possible(sampled):
        raise ConfigError("these parameters are no model: a covariance is not positive")
    mean, noise, start = sampled.at(0)
    samples = problem.samples
    states, rows = len(start), mean.shape[1]
    _, which = samples.steps
    white = stream.standard_normal((len(which), rows))
    disturbed = np.einsum("kij,kj->ki", root(noise)[which], white)
    first = start[:, 0] + root(start[:, 1:]) @ stream.standard_normal(states)
    out = np.empty((len(which), rows))
    inputs = np.ascontiguousarray(samples.table[:, samples.outputs.shape[1] :])
    simulate(mean, first, inputs, which, disturbed, out)
    readings = np.where(np.isnan(samples.outputs), np.nan, out[:, states:])
    return replace(samples, outputs=readings)

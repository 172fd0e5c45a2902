"""Estimation: which minimiser, from how many starts, and what it found."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.config import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.minimise import Cost, Found, Search, bfgs, scoring, stretched
from trainer.identify.powell import powell

Minimiser = Callable[[Cost, Numbers, Search], Found]


def scoring_then_bfgs(cost: Cost, theta: Numbers, search: Search) -> Found:
    """Return what scoring finds, or from there BFGS where scoring does not get to the end."""
    found = scoring(cost, theta, search)
    if found.converged or not np.isfinite(found.cost):
        return found
    further = bfgs(cost, found.theta, replace(search, most=5 * search.most))
    return replace(further, steps=found.steps + further.steps)


MINIMISERS: Final[dict[str, Minimiser]] = {
    "auto": scoring_then_bfgs,
    "scoring": scoring,
    "bfgs": bfgs,
    "powell": powell,
}


WIDEST: Final = 1.0  # [-] spread of a parameter with bounds, in its own coordinate


@dataclass(frozen=True)
class Starts:
    """Where else to start: ``restarts`` times, ``width`` standard deviations about the start."""

    restarts: int = 0
    width: float = 3.0
    seed: int = 1


def estimate(
    cost: Cost, theta: Numbers, method: str, search: Search, starts: Starts | None = None
) -> Found:
    """Return the best minimum of ``cost`` from ``theta`` (f,) and from other ``starts``.

    Of numbers that mean the same model it has the first, see Problem.folded.
    ConfigError for an unknown method, or where the cost at ``theta`` is not finite.
    """
    if method not in MINIMISERS:
        raise ConfigError(f"minimiser {method!r}: must be one of {', '.join(MINIMISERS)}")
    stretched(cost, theta)  # refuses a variance of nothing
    if not np.isfinite(cost.value(theta)):
        raise ConfigError(
            "the start values are no model: a covariance is not positive, or the prediction "
            "is not finite; start with other values"
        )
    found = MINIMISERS[method](cost, theta, search)
    for begin in _others(cost, theta, starts or Starts()):
        other = MINIMISERS[method](cost, begin, search)
        # a minimum no deeper is the same one
        found = other if other.cost < found.cost - 1e-6 else found
    return replace(found, theta=cost.problem.folded(found.theta))


def _others(cost: Cost, theta: Numbers, starts: Starts) -> list[Numbers]:
    """Return other starts where the cost is finite, spread by the information at ``theta``."""
    if starts.restarts == 0:
        return []
    problem = stretched(cost, theta)
    size = np.diag(problem.information(np.zeros(len(theta))))
    told = np.isfinite(size) & (size > 0.0)
    width = np.where(told, starts.width / np.sqrt(np.where(told, size, 1.0)), 0.0)
    # of parameters with bounds, nothing wider means more
    bounded = np.where(told, np.minimum(width, WIDEST), WIDEST)
    width = np.where(problem.bounded, bounded, width)
    stream = np.random.Generator(np.random.PCG64(starts.seed))
    spread = stream.standard_normal((starts.restarts, len(theta))) * width
    drawn = [problem.theta(eta) for eta in spread]
    return [begin for begin in drawn if np.isfinite(cost.value(begin))]

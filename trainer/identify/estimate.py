"""Estimation: which minimiser, from how many starts, what it found, and its file of progress."""

import json
import math
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.extras import require_library
from trainer.config.files import ConfigError, quote
from trainer.core.kernel import Numbers
from trainer.identify.minimise import Cost, Found, Search, bfgs, scoring, stretch
from trainer.identify.problem import Problem


def powell(cost: Cost, theta: Numbers, search: Search) -> Found:
    """Return the minimum by Powell's directions, no gradient used; needs scipy.

    Each coordinate is measured by its own standard deviation at the start where that is known.
    """
    require_library("scipy", "powell")
    from scipy.optimize import minimize  # noqa: PLC0415 - an extra, imported on use

    problem = stretch(cost, theta)
    diagonal = np.diag(problem.information(np.zeros(len(theta))))
    known = np.isfinite(diagonal) & (diagonal > 0.0)
    width = np.where(known, 1.0 / np.sqrt(np.where(known, diagonal, 1.0)), 1.0)

    def value(x: Numbers) -> float:
        return min(cost.value(problem.theta(x * width)), 1e300)

    def told(x: Numbers) -> None:
        search.progress(Found(problem.theta(x * width), value(x), 0, converged=False))

    options = {"maxiter": search.most, "xtol": 1e-4, "ftol": 1e-12}
    result: Any = minimize(
        value, np.zeros(len(theta)), method="Powell", callback=told, options=options
    )
    eta = np.atleast_1d(result.x) * width
    return Found(problem.theta(eta), float(result.fun), int(result.nit), bool(result.success))


Minimiser = Callable[[Cost, Numbers, Search], Found]


def scoring_then_bfgs(cost: Cost, theta: Numbers, search: Search) -> Found:
    """Return the result of scoring. BFGS goes on from there where scoring does not end."""
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
    stretch(cost, theta)  # refuses a variance of nothing
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
    problem = stretch(cost, theta)
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


def keep(path: Path, problem: Problem) -> Callable[[Found], None]:
    """Return what writes each step of a search to ``path``, whole or not at all."""

    def write(found: Found) -> None:
        theta = problem.folded(found.theta) * problem.scale
        told = {
            "model": problem.plant.model.name,
            "cost": found.cost,
            "parameters": dict(zip(problem.names, map(float, theta), strict=True)),
        }
        part = path.with_name(path.name + ".part")
        part.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")
        os.replace(part, path)  # noqa: PTH105 - one call that is atomic on every system

    return write


def resume(path: Path, problem: Problem) -> Numbers:
    """Return where to start (f,), from a file that ``keep`` wrote.

    ConfigError if it is of another model or lacks a free parameter.
    """
    try:
        told = json.loads(path.read_text(encoding="utf-8"), parse_int=float)
        model, parameters = told["model"], dict(told["parameters"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise ConfigError(f"{path.name}: is no checkpoint of a search ({error})") from None
    if model != problem.plant.model.name:
        raise ConfigError(f"{path.name}: is of model {model}, not {problem.plant.model.name}")
    lacking = [name for name in problem.names if name not in parameters]
    if lacking:
        raise ConfigError(f"{path.name}: lacks {', '.join(lacking)}, which are free here")
    for name in problem.names:
        value = parameters[name]
        if isinstance(value, bool) or not isinstance(value, float) or not math.isfinite(value):
            raise ConfigError(f"{path.name}: {name} = {quote(value)}: must be a number")
    return np.array([parameters[name] for name in problem.names]) / problem.scale

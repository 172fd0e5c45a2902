"""A minimiser that uses no gradients: Powell's directions, by scipy."""

from typing import Any

import numpy as np

from trainer.config import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.minimise import Cost, Found, Search, stretched


def powell(cost: Cost, theta: Numbers, search: Search) -> Found:
    """Return the minimum by Powell's directions, no gradient used; needs scipy.

    Each coordinate is measured by its own standard deviation at the start where that is known.
    """
    try:
        from scipy.optimize import minimize  # noqa: PLC0415 - an extra, imported on use
    except ImportError:
        raise ConfigError("powell needs scipy: pip install 'submarine-trainer[identify]'") from None
    problem = stretched(cost, theta)
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

"""Gradient and second derivatives of any function by central differences (MI 8.2).

For costs that have no exact derivatives, and to check those that have.
"""

from collections.abc import Callable

import numpy as np

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers

Function = Callable[[Numbers], float]


def relative_steps(theta: Numbers, share: float = 0.01) -> Numbers:
    """Return steps (f,) that are a ``share`` of each parameter; ConfigError where one is zero."""
    if (theta == 0.0).any():
        place = int(np.argmax(theta == 0.0))
        raise ConfigError(f"parameter {place + 1} is 0: a share of it is no step; give the steps")
    return np.abs(theta) * share


def gradient_and_hessian(
    function: Function, theta: Numbers, steps: Numbers
) -> tuple[Numbers, Numbers]:
    """Return gradient (f,) and second derivatives (f, f) with an error of order step^2."""
    n = len(theta)
    moves = np.diag(steps)
    middle = function(theta)
    plus = np.array([function(theta + move) for move in moves])
    minus = np.array([function(theta - move) for move in moves])
    gradient = (plus - minus) / (2.0 * steps)
    hessian = np.diag((plus - 2.0 * middle + minus) / steps**2)
    for i in range(n):
        for j in range(i):
            both, apart = moves[i] + moves[j], moves[i] - moves[j]
            crossed = (
                function(theta + both)
                - function(theta + apart)
                - function(theta - apart)
                + function(theta - both)
            )
            hessian[i, j] = hessian[j, i] = crossed / (4.0 * steps[i] * steps[j])
    return gradient, hessian


def refined(function: Function, theta: Numbers, steps: Numbers) -> tuple[Numbers, Numbers]:
    """Return gradient and second derivatives with an error of order step^4 (Richardson)."""
    whole = gradient_and_hessian(function, theta, steps)
    half = gradient_and_hessian(function, theta, 0.5 * steps)
    gradient, hessian = ((4.0 * h - w) / 3.0 for h, w in zip(half, whole, strict=True))
    return gradient, hessian

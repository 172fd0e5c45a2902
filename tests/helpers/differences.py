"""The gradient of any function by differences, to check one that is said to be exact."""

from collections.abc import Callable

import numpy as np

from trainer.core.kernel import Numbers


def fourth_order(function: Callable[[Numbers], float], theta: Numbers, steps: Numbers) -> Numbers:
    """Return the gradient (f,) with an error of order step^4."""
    found = []
    for move, step in zip(np.diag(steps), steps, strict=True):
        near = function(theta + move) - function(theta - move)
        far = function(theta + 2.0 * move) - function(theta - 2.0 * move)
        found.append((8.0 * near - far) / (12.0 * step))
    return np.array(found)

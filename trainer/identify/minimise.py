"""Minimisers of a cost: scoring, and quasi-Newton with the exact gradient.

They move in coordinates without bounds, where the ends of variances, correlations and lags are far
away and flat; everything else moves as it is.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.problem import Problem

CLOSE: Final = 1e-8  # [-] of cost: what a quadratic model may still promise at the minimum
LONGEST: Final = 2.0  # [-] step of a parameter with bounds
FAR: Final = 300.0  # [-] from the origin, beyond which nothing changes
NEAREST: Final = 0.999  # [-] correlation, or share of the interval, from which a search may start
STIFFEST: Final = 1e12  # damping beyond which no step gets smaller


class Cost(Protocol):
    """The quantity to minimise: minus a log-likelihood of a problem."""

    @property
    def problem(self) -> Problem:
        """Return whose parameters these are."""

    def value(self, theta: Numbers) -> float:
        """Return the cost [-], infinite where the model is impossible."""

    def slope(self, theta: Numbers) -> tuple[float, Numbers]:
        """Return the cost [-] and its gradient (f,)."""

    def information(self, theta: Numbers) -> Numbers:
        """Return the expected second derivatives (f, f)."""


@dataclass(frozen=True)
class Found:
    """Where a minimiser got to; ``converged`` if no model of the cost promises more."""

    theta: Numbers
    cost: float
    steps: int
    converged: bool


Progress = Callable[[Found], None]


def unheard(found: Found) -> None:
    """Take the news and do nothing."""
    del found


@dataclass(frozen=True)
class Search:
    """How long to search, and who is told of each step."""

    most: int = 100  # steps
    progress: Progress = field(default=unheard)


@dataclass(frozen=True, eq=False)
class Stretched:
    """A cost in coordinates eta that are 0 at ``origin`` and have no bounds.

    A variance is measured by its logarithm, a correlation by its inverse hyperbolic tangent, a lag
    as a share of the interval by its logit: their ends are far away and flat.
    """

    cost: Cost
    origin: Numbers  # (f,)

    @cached_property
    def bounded(self) -> NDArray[np.bool_]:
        """Return which parameters have bounds (f,)."""
        return np.array([kind != "free" for kind in self.cost.problem.kinds], bool)

    @cached_property
    def _kinds(self) -> NDArray[np.str_]:
        return np.array(self.cost.problem.kinds, str)

    @cached_property
    def _positive(self) -> NDArray[np.bool_]:
        return np.isin(self._kinds, ("variance", "error"))

    def theta(self, eta: Numbers) -> Numbers:
        """Return the parameters at ``eta``."""
        scale, far = self.cost.problem.scale, np.clip(eta, -FAR, FAR)
        floors = self.cost.problem.floors
        positive = floors + (self.origin - floors) * np.exp(far)
        found = np.where(self._positive, positive, self.origin + eta)
        inside = np.clip(np.sin(self.origin * scale), -NEAREST, NEAREST)
        angle = np.arcsin(np.tanh(np.arctanh(inside) + far)) / scale
        found = np.where(self._kinds == "angle", angle, found)
        lag = np.arcsin(self._share(far)) / scale
        return np.where(self._kinds == "lag", lag, found)

    def _share(self, far: Numbers) -> Numbers:
        """Return lags as shares of the interval (f,)."""
        sines = np.abs(np.sin(self.origin * self.cost.problem.scale))
        inside = np.clip(sines, 1.0 - NEAREST, NEAREST)
        return np.asarray(1.0 / (1.0 + np.exp(-(np.log(inside / (1.0 - inside)) + far))))

    def rates(self, eta: Numbers) -> Numbers:
        """Return d theta/d eta (f,)."""
        scale, theta = self.cost.problem.scale, self.theta(eta)
        found = np.where(self._positive, theta - self.cost.problem.floors, 1.0)
        found = np.where(self._kinds == "angle", np.cos(theta * scale) / scale, found)
        share = self._share(np.clip(eta, -FAR, FAR))
        lag = share * np.sqrt((1.0 - share) / (1.0 + share)) / scale
        return np.where(self._kinds == "lag", lag, found)

    def slope(self, eta: Numbers) -> tuple[float, Numbers]:
        """Return cost and gradient by eta."""
        cost, gradient = self.cost.slope(self.theta(eta))
        return cost, gradient * self.rates(eta)

    def information(self, eta: Numbers) -> Numbers:
        """Return the information by eta."""
        rates = self.rates(eta)
        return self.cost.information(self.theta(eta)) * np.outer(rates, rates)

    def clipped(self, step: Numbers) -> Numbers:
        """Return ``step`` with no bounded parameter going further than it may at once."""
        return np.where(self.bounded, np.clip(step, -LONGEST, LONGEST), step)

    def shortened(self, step: Numbers) -> Numbers:
        """Return ``step`` along its own direction, no bounded parameter going too far."""
        longest = float(np.max(np.abs(step[self.bounded]), initial=0.0))
        return step * min(1.0, LONGEST / longest) if longest > 0.0 else step

    def newton(self, matrix: Numbers, damping: float, gradient: Numbers) -> Numbers:
        """Return the step to a quadratic's minimum, bounded ones going no further than they may.

        Where one would, it goes that far and the others to their minimum beside it: a variance on
        its way to nothing holds nobody up.
        """
        step = np.zeros(len(gradient))
        held = np.zeros(len(gradient), bool)
        for _ in range(len(gradient)):
            free = ~held
            slope = gradient[free] + matrix[np.ix_(free, held)] @ step[held]
            step[free] = _solve_damped(matrix[np.ix_(free, free)], damping, slope)
            beyond = free & (self.clipped(step) != step)
            if not beyond.any():
                break
            held |= beyond
            step = np.where(held, self.clipped(step), step)
        return step


def stretch(cost: Cost, theta: Numbers) -> Stretched:
    """Return ``cost`` about ``theta``; ConfigError for a free variance that starts at zero."""
    problem = cost.problem
    for name, kind, value in zip(problem.names, problem.kinds, theta, strict=True):
        if kind in ("variance", "error") and value == 0.0:
            raise ConfigError(f"{name}: a free variance cannot start at 0; give its usual size")
    return Stretched(cost, np.where(problem.floors > 0.0, _above(problem, theta), theta))


def _above(problem: Problem, theta: Numbers) -> Numbers:
    """Return ``theta`` by magnitude, and at least a little above its floors."""
    return np.maximum(np.abs(theta), 1.01 * problem.floors)


def _solve_damped(matrix: Numbers, damping: float, gradient: Numbers) -> Numbers:
    """Return -(matrix + damping diag)^-1 gradient, scaled by the diagonal; zero where that is."""
    width = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    width[width == 0.0] = np.inf
    scaled = matrix / np.outer(width, width) + damping * np.eye(len(width))
    scaled[np.isinf(width), np.isinf(width)] = 1.0
    step = np.linalg.lstsq(scaled, -gradient / width, rcond=1e-13)[0]
    return np.asarray(step / width)


def scoring(cost: Cost, theta: Numbers, search: Search) -> Found:
    """Return the minimum by damped Gauss-Newton steps with the expected information."""
    problem = stretch(cost, theta)
    eta, damping = np.zeros(len(theta)), 1e-3
    value, gradient = problem.slope(eta)
    found = Found(theta, value, 0, converged=False)
    if not np.isfinite(value):
        return found
    information = problem.information(eta)
    for step in range(1, search.most + 1):
        if not np.isfinite(information).all():
            return found
        if -0.5 * float(gradient @ problem.newton(information, 1e-9, gradient)) < CLOSE:
            return replace(found, converged=True)
        moved, damping = _damp_step(problem, eta, (value, gradient, information), damping)
        if moved is None:
            return found
        eta = moved
        value, gradient = problem.slope(eta)
        information = problem.information(eta)
        found = Found(problem.theta(eta), value, step, converged=False)
        search.progress(found)
    return found


def _damp_step(
    problem: Stretched, eta: Numbers, quadratic: tuple[float, Numbers, Numbers], damping: float
) -> tuple[Numbers | None, float]:
    """Return the next eta and damping, more damping until the cost falls; None if it never does."""
    value, gradient, information = quadratic
    while damping < STIFFEST:
        step = problem.newton(information, damping, gradient)
        promised = -float(gradient @ step + 0.5 * step @ information @ step)
        gained = value - problem.cost.value(problem.theta(eta + step))
        if promised > 0.0 and gained > 1e-4 * promised:
            return eta + step, damping * (0.1 if gained > 0.5 * promised else 1.0)
        damping = max(10.0 * damping, 1e-6)
    return None, damping


def bfgs(cost: Cost, theta: Numbers, search: Search) -> Found:
    """Return the minimum by quasi-Newton steps (BFGS), begun with the information there."""
    problem = stretch(cost, theta)
    eta = np.zeros(len(theta))
    value, gradient = problem.slope(eta)
    found = Found(theta, value, 0, converged=False)
    if not np.isfinite(value):
        return found
    inverse, fresh = _metric(problem, eta), True
    for step in range(1, search.most + 1):
        direction = -inverse @ gradient
        promised = -0.5 * float(gradient @ problem.clipped(direction))
        direction = problem.shortened(direction)
        length, after, slope = _line(problem, eta, (value, gradient), direction)
        moved = length * direction
        gained = value - after
        if length == 0.0 or gained < CLOSE > promised:
            if fresh:
                return replace(found, converged=promised < np.sqrt(CLOSE))
            inverse, fresh = _metric(problem, eta), True
            continue
        inverse, fresh = _update_inverse(inverse, moved, slope - gradient), False
        eta, value, gradient = eta + moved, after, slope
        found = Found(problem.theta(eta), value, step, converged=False)
        search.progress(found)
    return found


def _metric(problem: Stretched, eta: Numbers) -> Numbers:
    """Return an inverse of the information, or of its diagonal where that fails."""
    information = problem.information(eta)
    if not np.isfinite(information).all():
        return np.eye(len(eta))
    columns = [-_solve_damped(information, 1e-6, unit) for unit in np.eye(len(eta))]
    inverse = np.column_stack(columns)
    return 0.5 * (inverse + inverse.T)


def _line(
    problem: Stretched, eta: Numbers, here: tuple[float, Numbers], direction: Numbers
) -> tuple[float, float, Numbers]:
    """Return how far to go along ``direction`` [-], cost and gradient there (Wolfe's conditions).

    0 if no length lowers the cost.
    """
    value, gradient = here
    downhill = float(gradient @ direction)
    low, high, length = 0.0, np.inf, 1.0
    best = 0.0, value, gradient
    for _ in range(30):
        after, slope = problem.slope(eta + length * direction)
        if not after <= value + 1e-4 * length * downhill:
            high = length
        else:
            best = length, after, slope
            if float(slope @ direction) >= 0.9 * downhill:
                break
            low = length
        length = 2.0 * length if np.isinf(high) else 0.5 * (low + high)
    return best


def _update_inverse(inverse: Numbers, s: Numbers, y: Numbers) -> Numbers:
    """Return the BFGS update of an inverse for a step ``s`` that changed the gradient by ``y``."""
    curvature = float(s @ y)
    if curvature <= 1e-12 * float(np.linalg.norm(s) * np.linalg.norm(y)):
        return inverse
    left = np.eye(len(s)) - np.outer(s, y) / curvature
    return np.asarray(left @ inverse @ left.T + np.outer(s, s) / curvature)

"""Minimisers of a cost: scoring with the information, then scipy's with the exact gradient.

``estimate`` takes the best of several searches. They move in coordinates without bounds: variances,
correlations and lags are transformed, and all other parameters are not. In these coordinates the
cost becomes flat towards the ends of a range. A search may therefore stop on a slope that only
looks flat, and so each end is judged apart: it must be a minimum, and a variance that went to zero
is lifted again where the cost would fall.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from trainer.config.extras import require_library
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers

# Costs are minus a log-likelihood: 0.5 is one standard deviation of one parameter. Scoring goes on
# while a step promises 1e-8; judged apart, 1e-3 counts as settled (docs/identification.md).
NEWTON_COST_TOLERANCE: Final = 1e-8  # [-] that a quadratic model may still promise at the minimum
SETTLED_COST_TOLERANCE: Final = 1e-3  # [-] that it may promise where a search has settled
MAX_STEP: Final = 2.0  # [-] step of a parameter with bounds
MAX_DISTANCE: Final = 30.0  # [-] from the origin: a factor of e^30 = 1e13, then nothing changes
MAX_START_SHARE: Final = 0.999  # [-] of correlation or interval, to start from: 1 is infinitely far
MAX_DAMPING: Final = 1e12  # damping beyond which no step gets smaller
MIN_CURVATURE: Final = 1e-9  # [-] least eigenvalue of the scaled second derivatives at a minimum
END_MARGIN: Final = 1e-3  # [-] to an end of a lag or correlation
MIN_BOUNDED_INFORMATION: Final = 1e-6  # [-] of a bounded coordinate: with less it is at an end
POLISH_ROUNDS: Final = 12  # of polishing, each judged
POLISHERS: Final = ("BFGS", "trust-exact")  # scipy's, in turn
# parts of a step, tried in turn; both ways, because a direction of curvature has no sign
STEP_LENGTHS: Final = (1.0, -1.0, 0.3, -0.3, 0.1, -0.1, 0.01, -0.01)
MIN_COST_GAIN: Final = 1e-4  # [-] of cost that such a step must gain
IMPOSSIBLE_NEIGHBOUR: Final = "the model is impossible beside it"
UPHILL_COST: Final = 10.0  # [-] times 1 + |best cost|: that of an impossible model, above the best


class SearchedProblem(Protocol):
    """What a search must know of the parameters (f,) that it moves.

    A kind is free, or one that keeps a range: variance, error, angle, lag. A logarithm has no end,
    but may become so small that nothing depends on it.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names; free ones at the end may have none."""

    @property
    def kinds(self) -> tuple[str, ...]:
        """Return how each is bounded."""

    @property
    def scale(self) -> Numbers:
        """Return by what each is multiplied to be an angle or a lag [rad]."""

    @property
    def floors(self) -> Numbers:
        """Return the least that each variance may be."""


class Cost(Protocol):
    """The quantity to minimise: minus a log-likelihood of a problem."""

    @property
    def problem(self) -> SearchedProblem:
        """Return whose parameters these are."""

    def value(self, theta: Numbers) -> float:
        """Return the cost [-], infinite where the model is impossible."""

    def slope(self, theta: Numbers) -> tuple[float, Numbers]:
        """Return the cost [-] and its gradient (f,)."""

    def information(self, theta: Numbers) -> Numbers:
        """Return the expected second derivatives (f, f)."""


@dataclass(frozen=True)
class SearchResult:
    """The end of a search. ``converged`` if it is a minimum, else ``doubt`` says why not."""

    theta: Numbers
    cost: float
    steps: int
    converged: bool
    doubt: str = ""


Progress = Callable[[SearchResult], None]


def ignore_news(found: SearchResult) -> None:
    """Ignore a step of a search: where nobody wants to hear of it."""
    del found


@dataclass(frozen=True)
class SearchOptions:
    """How long to search, and who is told of each step."""

    most: int = 100  # steps
    progress: Progress = field(default=ignore_news)


@dataclass(frozen=True, eq=False)
class StretchedCost:
    """A cost in coordinates eta that are 0 at ``origin`` and have no bounds.

    A variance is measured by its logarithm, a correlation by its inverse hyperbolic tangent, a lag
    as a share of the interval by its logit, because a search then needs no bounds: the ends of
    these ranges are far away, and the cost is flat there.
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
        scale, far = self.cost.problem.scale, np.clip(eta, -MAX_DISTANCE, MAX_DISTANCE)
        floors = self.cost.problem.floors
        positive = floors + (self.origin - floors) * np.exp(far)
        values = np.where(self._positive, positive, self.origin + eta)
        inside = np.clip(np.sin(self.origin * scale), -MAX_START_SHARE, MAX_START_SHARE)
        angle = np.arcsin(np.tanh(np.arctanh(inside) + far)) / scale
        values = np.where(self._kinds == "angle", angle, values)
        lag = np.arcsin(self._share(far)) / scale
        return np.where(self._kinds == "lag", lag, values)

    def _share(self, far: Numbers) -> Numbers:
        """Return lags as shares of the interval (f,)."""
        sines = np.abs(np.sin(self.origin * self.cost.problem.scale))
        inside = np.clip(sines, 1.0 - MAX_START_SHARE, MAX_START_SHARE)
        return np.asarray(1.0 / (1.0 + np.exp(-(np.log(inside / (1.0 - inside)) + far))))

    def rates(self, eta: Numbers) -> Numbers:
        """Return d theta/d eta (f,)."""
        scale, theta = self.cost.problem.scale, self.theta(eta)
        slopes = np.where(self._positive, theta - self.cost.problem.floors, 1.0)
        slopes = np.where(self._kinds == "angle", np.cos(theta * scale) / scale, slopes)
        share = self._share(np.clip(eta, -MAX_DISTANCE, MAX_DISTANCE))
        lag = share * np.sqrt((1.0 - share) / (1.0 + share)) / scale
        return np.where(self._kinds == "lag", lag, slopes)

    def slope(self, eta: Numbers) -> tuple[float, Numbers]:
        """Return cost and gradient by eta."""
        cost, gradient = self.cost.slope(self.theta(eta))
        return cost, gradient * self.rates(eta)

    def information(self, eta: Numbers) -> Numbers:
        """Return the information by eta."""
        rates = self.rates(eta)
        return self.cost.information(self.theta(eta)) * np.outer(rates, rates)

    def clipped(self, step: Numbers, most: float = MAX_STEP) -> Numbers:
        """Return ``step`` with no bounded parameter going further than ``most``.

        That is MAX_STEP for one step of a search, MAX_DISTANCE for a point.
        """
        return np.where(self.bounded, np.clip(step, -most, most), step)

    def at_end(self, eta: Numbers) -> NDArray[np.bool_]:
        """Return which numbers are at an end of their range (f,).

        Every variance and logarithm counts, because it may always grow.
        """
        sine = np.abs(np.sin(self.theta(eta) * self.cost.problem.scale))
        lag = (self._kinds == "lag") & (np.abs(sine - 0.5) > 0.5 - END_MARGIN)
        angle = (self._kinds == "angle") & (sine > 1.0 - END_MARGIN)
        return np.asarray(self._positive | (self._kinds == "logarithm") | lag | angle)

    def newton(self, matrix: Numbers, damping: float, gradient: Numbers) -> Numbers:
        """Return the step to a quadratic's minimum, bounded ones going no further than they may.

        A parameter whose step is too long goes as far as it may and is held; the others then step
        to the minimum for that point. So a variance on its way to zero does not shorten all other
        steps.
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


def stretch_cost(cost: Cost, theta: Numbers) -> StretchedCost:
    """Return ``cost`` about ``theta``; ConfigError for a free variance that starts at zero."""
    problem = cost.problem
    for name, kind, value in zip(problem.names, problem.kinds, theta, strict=False):
        if kind in ("variance", "error") and value == 0.0:
            raise ConfigError(f"{name}: a free variance cannot start at 0; give its usual size")
    # a little above the floor, because at the floor itself the logarithm has no slope
    above = np.maximum(np.abs(theta), 1.01 * problem.floors)
    return StretchedCost(cost, np.where(problem.floors > 0.0, above, theta))


def _solve_damped(matrix: Numbers, damping: float, gradient: Numbers) -> Numbers:
    """Return -(matrix + damping diag)^-1 gradient, scaled by the diagonal; zero where that is.

    Scaled, because the parameters' units differ by many powers of ten. Least squares, because the
    matrix may be singular: it then moves only what the record determines.
    """
    width = np.sqrt(np.maximum(np.diag(matrix), 0.0))
    width[width == 0.0] = np.inf
    scaled = matrix / np.outer(width, width) + damping * np.eye(len(width))
    scaled[np.isinf(width), np.isinf(width)] = 1.0
    step = np.linalg.lstsq(scaled, -gradient / width, rcond=1e-13)[0]  # 1e-13: rounding
    return np.asarray(step / width)


class SearchPoint(NamedTuple):
    """A point of a search, and the cost's shape there."""

    eta: Numbers
    value: float
    gradient: Numbers
    information: Numbers


class MinimumVerdict(NamedTuple):
    """The doubt about a point, empty if it is a minimum.

    ``better`` is a lower point, if one was found.
    """

    doubt: str
    better: Numbers | None = None


def search_by_scoring(
    problem: StretchedCost, eta: Numbers, search: SearchOptions
) -> tuple[Numbers, int]:
    """Return where damped Gauss-Newton steps with the expected information lead, and their number.

    They end where the quadratic model promises no further fall, or where no damping lowers the
    cost.
    """
    damping = 1e-3
    here = SearchPoint(eta, *problem.slope(eta), problem.information(eta))
    for step in range(search.most):
        if not np.isfinite(here.information).all():
            return here.eta, step
        # the promise is that of the step without damping: damped steps promise less than there is
        newton = problem.newton(here.information, 1e-9, here.gradient)
        if 0.0 <= -0.5 * float(here.gradient @ newton) < NEWTON_COST_TOLERANCE:
            return here.eta, step
        moved, damping = _damp_step(problem, here, damping)
        if moved is None:
            return here.eta, step
        here = SearchPoint(moved, *problem.slope(moved), problem.information(moved))
        search.progress(SearchResult(problem.theta(moved), here.value, step + 1, converged=False))
    return here.eta, search.most


def approach_minimum(cost: Cost, theta: Numbers, search: SearchOptions) -> SearchResult:
    """Return where scoring leads from ``theta``, not judged."""
    problem = stretch_cost(cost, theta)
    eta, steps = search_by_scoring(problem, np.zeros(len(theta)), search)
    end = problem.theta(eta)
    return SearchResult(end, cost.value(end), steps, converged=False)


def _damp_step(
    problem: StretchedCost, here: SearchPoint, damping: float
) -> tuple[Numbers | None, float]:
    """Return the next eta and damping, more damping until the cost falls; None if it never does."""
    gradient, information = here.gradient, here.information
    while damping < MAX_DAMPING:
        step = problem.newton(information, damping, gradient)
        promised = -float(gradient @ step + 0.5 * step @ information @ step)
        gained = here.value - problem.cost.value(problem.theta(here.eta + step))
        if promised > 0.0 and gained > 1e-4 * promised:
            moved = problem.clipped(here.eta + step, MAX_DISTANCE)
            return moved, damping * (0.1 if gained > 0.5 * promised else 1.0)
        damping = max(10.0 * damping, 1e-6)
    return None, damping


def judge_minimum(problem: StretchedCost, eta: Numbers) -> MinimumVerdict:
    """Return whether ``eta`` is a minimum, or why not.

    At a minimum there is no slope, the cost curves upwards, and no number at an end of its range
    would lower the cost by leaving it (docs/identification.md).
    """
    gradient = problem.slope(eta)[1]
    size = np.diag(problem.information(eta))
    if not (np.isfinite(gradient).all() and np.isfinite(size).all()):
        return MinimumVerdict(IMPOSSIBLE_NEIGHBOUR)
    gone = problem.bounded & (size < MIN_BOUNDED_INFORMATION)
    for index in np.flatnonzero(gone & problem.at_end(eta)):
        lifted = _lift(problem, eta, int(index), (gradient[index], size[index]))
        if lifted is not None:
            return MinimumVerdict(f"{problem.cost.problem.names[index]} wants off its end", lifted)
    return _judge_shape(problem, eta, gradient, np.where(gone, 0.0, size))


def _judge_shape(
    problem: StretchedCost, eta: Numbers, gradient: Numbers, size: Numbers
) -> MinimumVerdict:
    """Return whether ``eta`` is a minimum in the coordinates whose ``size`` is not zero.

    If it is none, the verdict has a lower point: along the direction that curves downwards, or by
    Newton's step.
    """
    curvature = second_derivatives(problem, eta, size)
    free = (size > 0.0) & (np.diag(curvature) != 0.0)
    curvature = curvature[np.ix_(free, free)]
    if not np.isfinite(curvature).all():
        return MinimumVerdict(IMPOSSIBLE_NEIGHBOUR)
    width = np.sqrt(np.abs(np.diag(curvature)))
    sizes, directions = np.linalg.eigh(curvature / np.outer(width, width))
    along = directions.T @ (gradient[free] / width)
    promised = 0.5 * float(np.sum(along**2 / np.maximum(np.abs(sizes), MIN_CURVATURE)))
    step = np.zeros_like(eta)
    if len(sizes) and sizes[0] < MIN_CURVATURE:
        step[free], doubt = directions[:, 0] / width, "the second derivatives are not all positive"
    elif promised > SETTLED_COST_TOLERANCE:
        step[free] = -directions @ (along / sizes) / width
        doubt = f"a step promises {promised:.2g} more"
    else:
        return MinimumVerdict("")
    return MinimumVerdict(doubt, _along(problem, eta, problem.clipped(step)))


def _lift(
    problem: StretchedCost, eta: Numbers, index: int, here: tuple[float, float]
) -> Numbers | None:
    """Return a lower point, one number taken off its end; None if there is none.

    Near zero the cost is nearly linear in a variance itself, but has almost no slope by the
    variance's logarithm. So the step is that to the minimum of a quadratic in the variance itself.
    """
    slope, size = here
    if not size > 0.0 or slope * slope < 2.0 * SETTLED_COST_TOLERANCE * size:
        return None
    unit = np.zeros_like(eta)
    unit[index] = -math.copysign(math.log1p(abs(slope) / size), slope)
    return _along(problem, eta, unit)


def _along(problem: StretchedCost, eta: Numbers, direction: Numbers) -> Numbers | None:
    """Return a point on a line, lower by MIN_COST_GAIN; None if none was found."""
    value = problem.cost.value(problem.theta(eta))
    for length in STEP_LENGTHS:
        tried = problem.clipped(eta + length * direction, MAX_DISTANCE)
        if problem.cost.value(problem.theta(tried)) < value - MIN_COST_GAIN:
            return tried
    return None


def second_derivatives(problem: StretchedCost, eta: Numbers, size: Numbers) -> Numbers:
    """Return the second derivatives by eta (f, f): differences of the exact gradient.

    A step is 1/1000 of what the coordinate alone is known to, by ``size`` (f,), the diagonal of the
    information.
    """
    known = size > np.finfo(float).tiny
    steps = np.where(known, 1e-3 / np.sqrt(np.where(known, size, 1.0)), 1e-6)
    steps = np.where(problem.bounded, np.minimum(steps, 1e-2), steps)
    return curvature(lambda at: problem.slope(at)[1], eta, steps, np.ones_like(steps))


def curvature(
    slope: Callable[[Numbers], Numbers], at: Numbers, steps: Numbers, back: Numbers
) -> Numbers:
    """Return second derivatives (f, f) by differences of a gradient at two points.

    The first point is ``steps`` (f,) ahead, the second ``back`` (f,) times that step behind: 1 is
    central, 0 one-sided.
    """
    columns = [
        (slope(at + aside) - slope(at - one * aside)) / ((1.0 + one) * step)
        for aside, step, one in zip(np.diag(steps), steps, back, strict=True)
    ]
    matrix = np.column_stack(columns)
    return np.asarray(0.5 * (matrix + matrix.T))


def scipy_search(
    problem: StretchedCost, eta: Numbers, method: str, search: SearchOptions
) -> tuple[Numbers, int]:
    """Return where scipy's ``method`` leads, BFGS or trust-exact, and the number of its steps.

    Coordinates are measured by what each alone is known to at ``eta``.
    """
    require_library("scipy", "identify")
    from scipy.optimize import minimize  # noqa: PLC0415 - an extra, imported on use

    size = np.diag(problem.information(eta))
    width = 1.0 / np.sqrt(np.where(np.isfinite(size) & (size > 0.0), size, 1.0))
    width = np.where(problem.bounded, np.minimum(width, 1.0), width)
    best: tuple[float, Numbers] = (problem.cost.value(problem.theta(eta)), eta)

    def slope(x: Numbers) -> tuple[float, Numbers]:
        nonlocal best
        value, gradient = problem.slope(eta + x * width)
        if not (np.isfinite(value) and np.isfinite(gradient).all()):
            # scipy cannot take an infinite cost: a finite one far uphill makes it shorten its step
            return best[0] + UPHILL_COST * (1.0 + abs(best[0])), np.zeros_like(x)
        if value < best[0]:
            best = value, eta + x * width
        return value, gradient * width

    def curvature(x: Numbers) -> Numbers:
        hessian = problem.information(eta + x * width) * np.outer(width, width)
        return hessian if np.isfinite(hessian).all() else np.eye(len(x))

    def tell(x: Numbers) -> None:
        search.progress(SearchResult(problem.theta(eta + x * width), best[0], 0, converged=False))

    more: dict[str, Any] = {"hess": curvature} if method == "trust-exact" else {}
    with np.errstate(all="ignore"):
        result: Any = minimize(
            slope,
            np.zeros_like(eta),
            jac=True,
            method=method,
            callback=tell,
            options={"maxiter": search.most},
            **more,
        )
    # the best point of all that were tried, because scipy may end at another one
    return problem.clipped(best[1], MAX_DISTANCE), int(result.nit)


def settle_minimum(
    problem: StretchedCost, eta: Numbers, search: SearchOptions, steps: int = 0
) -> SearchResult:
    """Return the minimum beside ``eta``: judged, and searched on while there is a doubt."""
    verdict = judge_minimum(problem, eta)
    for turn in range(POLISH_ROUNDS):
        if not verdict.doubt:
            break
        if verdict.better is not None:
            eta, more = search_by_scoring(problem, verdict.better, search)
        else:
            eta, more = scipy_search(problem, eta, POLISHERS[turn % len(POLISHERS)], search)
        steps += more
        verdict = judge_minimum(problem, eta)
    return judge_point(problem, eta, steps, verdict)


def judge_point(
    problem: StretchedCost, eta: Numbers, steps: int, verdict: MinimumVerdict | None = None
) -> SearchResult:
    """Return the point ``eta`` as a result, with the given verdict or one made now."""
    verdict, theta = verdict or judge_minimum(problem, eta), problem.theta(eta)
    return SearchResult(theta, problem.cost.value(theta), steps, not verdict.doubt, verdict.doubt)

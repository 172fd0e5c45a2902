"""The search for the best fit: a minimiser is started from several points.

A cost with many parameters has more than one minimum, and a search ends in the nearest. So further
starts are drawn about the first until several in a row are no better, and the best end is taken.
``judge/fitted`` calls it for a study, ``monte_carlo`` for simulated records. The steps themselves
are in ``minimise``.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, Final

import numpy as np

from trainer.config.extras import require_library
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.fitting.minimise import (
    NEWTON_COST_TOLERANCE,
    Cost,
    SearchOptions,
    SearchResult,
    judge_point,
    scipy_search,
    search_by_scoring,
    settle_minimum,
    stretch_cost,
)
from trainer.identify.fitting.problem import Problem, RecordCost

MAX_BOUNDED_SPREAD: Final = 3.0  # [-] spread of a parameter with bounds, in its own coordinate
MIN_TIME_CONSTANT: Final = 0.5  # [intervals] of a time constant that two readings still show
MAX_TIME_CONSTANT: Final = 100.0  # [records' lengths] of a time constant that a record tells
RESTART_DEVIATIONS: Final = 10.0  # [standard deviations] about the first start, or a part of it
RESTART_SEED: Final = 1  # fixed: the same record gives the same fit
MAX_RESTART_FACTOR: Final = 4  # times the restarts wanted, in all: the search must end
APPROACH_STEPS: Final = 60  # steps from another start
NEAR_COST_MARGIN: Final = 10.0  # [-] of cost above the best, from where a search is carried on
NARROW_WIDTH: Final = 0.3  # [-] of the width, of every other start
MIN_COST_GAIN: Final = 0.01  # [-] of cost: what another start must gain
Minimiser = Callable[[Cost, Numbers, SearchOptions], SearchResult]


def powell(cost: Cost, theta: Numbers, search: SearchOptions) -> SearchResult:
    """Return the minimum by Powell's directions, no gradient used; needs scipy.

    ``--method direct`` takes it, because the report of 1974 had a minimiser without gradient too.
    Each coordinate is measured by its own standard deviation at the start where that is known.
    """
    require_library("scipy", "identify")
    from scipy.optimize import minimize  # noqa: PLC0415 - an extra, imported on use

    problem = stretch_cost(cost, theta)
    diagonal = np.diag(problem.information(np.zeros(len(theta))))
    known = np.isfinite(diagonal) & (diagonal > 0.0)
    width = np.where(known, 1.0 / np.sqrt(np.where(known, diagonal, 1.0)), 1.0)

    def value(x: Numbers) -> float:
        return min(cost.value(problem.theta(x * width)), 1e300)

    def tell(x: Numbers) -> None:
        search.progress(SearchResult(problem.theta(x * width), value(x), 0, converged=False))

    options = {"maxiter": search.most, "xtol": 1e-4, "ftol": 1e-12}
    result: Any = minimize(
        value, np.zeros(len(theta)), method="Powell", callback=tell, options=options
    )
    return judge_point(problem, np.atleast_1d(result.x) * width, int(result.nit))


def by_scoring(cost: Cost, theta: Numbers, search: SearchOptions) -> SearchResult:
    """Return the minimum by scoring, then by scipy's minimisers if scoring ends at none."""
    problem = stretch_cost(cost, theta)
    eta, steps = search_by_scoring(problem, np.zeros(len(theta)), search)
    return settle_minimum(problem, eta, search, steps)


def bfgs(cost: Cost, theta: Numbers, search: SearchOptions) -> SearchResult:
    """Return the minimum by scipy's quasi-Newton steps (BFGS), polished if they end at none."""
    problem = stretch_cost(cost, theta)
    eta, steps = scipy_search(problem, np.zeros(len(theta)), "BFGS", search)
    return settle_minimum(problem, eta, search, steps)


MINIMISER_BY_NAME: Final[dict[str, Minimiser]] = {
    "scoring": by_scoring,
    "bfgs": bfgs,
    "direct": powell,
}


def find_best_minimum(
    cost: RecordCost,
    theta: Numbers,
    method: str,
    search: SearchOptions,
    restarts: int = 0,
) -> SearchResult:
    """Return the best minimum of ``cost`` from ``theta`` (f,) and from other starts.

    Others are tried until ``restarts`` in a row find nothing better. Several numbers may mean the
    same model, as a variance and its negative do; Problem.folded then chooses. ConfigError where
    the cost at ``theta`` is not finite.
    """
    stretch_cost(cost, theta)  # refuses a variance of nothing
    if not np.isfinite(cost.value(theta)):
        raise ConfigError(
            "the start values are no model: a covariance is not positive, or the prediction "
            "is not finite; start with other values"
        )
    minimum = MINIMISER_BY_NAME[method](cost, theta, search)
    if restarts:
        minimum = _doubt_speed(cost.problem, _best(cost, theta, minimum, restarts))
    return replace(minimum, theta=cost.problem.folded(minimum.theta))


def _best(cost: RecordCost, theta: Numbers, found: SearchResult, restarts: int) -> SearchResult:
    """Return the best minimum, once so many others in a row were no better.

    Any other minimum is preferred to one with a mode faster than the readings, whatever its
    likelihood, because such a mode fits errors and not motion (docs/identification.md).
    """
    unbeaten = 0
    for begin in _others(cost, theta, restarts):
        other = _approach(cost, begin, found)
        faster, fast = (is_too_fast(cost.problem, one.theta) for one in (other, found))
        better = fast if faster != fast else other.cost < found.cost
        same = faster == fast and other.cost > found.cost - MIN_COST_GAIN
        unbeaten = unbeaten + 1 if same or not better else 0
        found = other if better else found
        if unbeaten == restarts:
            return found
    return replace(found, converged=False, doubt=found.doubt or "other starts keep finding better")


def _approach(cost: RecordCost, begin: Numbers, best: SearchResult) -> SearchResult:
    """Return where another start leads: by scoring, and settled only where it comes near.

    An end with the cost already known is the same minimum, so it is not settled again.
    """
    problem = stretch_cost(cost, begin)
    eta, steps = search_by_scoring(problem, np.zeros(len(begin)), SearchOptions(APPROACH_STEPS))
    theta = problem.theta(eta)
    value = cost.value(theta)
    speeds = {is_too_fast(cost.problem, one) for one in (theta, best.theta)}
    if best.converged and abs(value - best.cost) < NEWTON_COST_TOLERANCE and len(speeds) == 1:
        return best
    if value < best.cost + NEAR_COST_MARGIN:
        return settle_minimum(problem, eta, SearchOptions(APPROACH_STEPS), steps)
    return SearchResult(theta, value, steps, converged=False)


def is_too_fast(problem: Problem, theta: Numbers) -> bool:
    """Return whether a time constant is so short that the readings cannot show it.

    One reading alone cannot tell a motion inside the interval from its own error.
    """
    least = MIN_TIME_CONSTANT if len(problem.plant.outputs) > 1 else 1.0
    return problem.fastest(theta) < least * problem.plant.period


def _doubt_speed(problem: Problem, found: SearchResult) -> SearchResult:
    """Return ``found``, not settled if a mode is faster than the readings or beyond the record."""
    seconds, slow = float(np.ptp(problem.samples.t)), problem.slowest(found.theta)
    if slow > MAX_TIME_CONSTANT * seconds:
        doubt = (
            f"a time constant of {slow:.2g} s is beyond a record of {seconds:g} s: it tells none"
        )
        return replace(found, converged=False, doubt=doubt)
    if not is_too_fast(problem, found.theta):
        return found
    doubt = (
        f"a time constant of {problem.fastest(found.theta):.2g} s is beyond readings every "
        f"{problem.plant.period:g} s: errors stand for motion, or the model has one too many"
    )
    return replace(found, converged=False, doubt=doubt)


def _others(cost: RecordCost, theta: Numbers, restarts: int) -> Iterator[Numbers]:
    """Yield other starts with a finite cost, drawn about ``theta`` in three widths.

    A width comes from what each number is known to, or from its size. A number with bounds is drawn
    in its own coordinate, and no wider than MAX_BOUNDED_SPREAD, because further out all values mean
    the same: an end.
    """
    problem = stretch_cost(cost, theta)
    size = np.diag(problem.information(np.zeros(len(theta))))
    informed = np.isfinite(size) & (size > 0.0)
    known = np.where(informed, RESTART_DEVIATIONS / np.sqrt(np.where(informed, size, 1.0)), 0.0)
    bounded = np.where(informed, np.minimum(known, MAX_BOUNDED_SPREAD), MAX_BOUNDED_SPREAD)
    # three widths in turn, because minima lie at a distance that nobody knows before
    free = np.minimum(3.0 * known, 2.0 * np.abs(theta)), NARROW_WIDTH * known, known
    widths = [np.where(problem.bounded, bounded, one) for one in free]
    widths[1] = np.where(problem.bounded, NARROW_WIDTH * bounded, widths[1])
    stream = np.random.Generator(np.random.PCG64(RESTART_SEED))
    for turn in range(restarts * MAX_RESTART_FACTOR):
        width = widths[turn % len(widths)]
        begin = problem.theta(stream.standard_normal(len(theta)) * width)
        if np.isfinite(cost.value(begin)):
            yield begin

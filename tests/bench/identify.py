"""How fast a ship is identified, beside statsmodels: ``python -m tests.bench --identify``.

Everything is the tanker of the rehearsals: Model 1, 19 free parameters, three outputs. Ratios are
medians over short batches in turn. Times are the processor's, which others hardly lengthen.

The likelihood of a problem by statsmodels, and what a fit by its minimiser asks for.
"""

import statistics
import textwrap
import time
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np
from cases.reference_ships import TANKER, TANKER_RUDDER

from trainer.core.kernel import Numbers
from trainer.identify.fitting.estimate import find_best_minimum
from trainer.identify.fitting.likelihood import Likelihood
from trainer.identify.fitting.minimise import SearchOptions, stretch_cost
from trainer.identify.fitting.problem import Problem
from trainer.identify.judge.validation import draw_outputs, simulate_deterministic
from trainer.identify.monte_carlo import one_run

ROUNDS: Final = 25
BATCH_S: Final = 4e-3  # [s] a batch takes at least

Work = Callable[[], object]


@dataclass(frozen=True)
class Paces:
    """Times [s] of one call of each work, by this thread's clock, in rounds."""

    rounds: tuple[tuple[float, ...], ...]

    def median(self, work: int) -> float:
        """Return the time [s] of a call."""
        return statistics.median(times[work] for times in self.rounds)

    def ratio(self, work: int, other: int) -> float:
        """Return the median over rounds of a work's time by another's [-]."""
        return statistics.median(times[work] / times[other] for times in self.rounds)


def time_in_turn(works: Sequence[Work]) -> Paces:
    """Return what each of ``works`` takes, in short batches that take turns."""
    counts = [_enough(work) for work in works]
    return Paces(
        tuple(
            tuple(_seconds(work, count) for work, count in zip(works, counts, strict=True))
            for _ in range(ROUNDS)
        )
    )


def _enough(work: Work) -> int:
    """Return how many calls make a batch."""
    work()  # compiles
    count = 1
    while count * _seconds(work, count) < BATCH_S:
        count *= 2
    return count


def _seconds(work: Work, count: int) -> float:
    """Return the thread's time [s] of one of ``count`` calls."""
    begun = time.thread_time()
    for _ in range(count):
        work()
    return (time.thread_time() - begun) / count


Value = Callable[[], float]

MOST: Final = 200  # steps of its minimiser


def filters() -> Any:
    """Return statsmodels' module of Kalman filters; ImportError where it is not installed."""
    from statsmodels.tsa.statespace import kalman_filter  # noqa: PLC0415  slow, and optional

    return kalman_filter


def by_statsmodels(kalman: Any, problem: Problem, theta: Numbers) -> Value:
    """Return minus the log-likelihood as ``kalman``, statsmodels' filter, has it, one interval.

    It is asked in the way that it is quickest in: what the rudder and the start do is taken off
    before, so that its system does not change from sample to sample and its gain may settle.
    """
    outputs = problem.samples.outputs
    states, readings = problem.plant.model.states, outputs.shape[1]
    model = kalman.KalmanFilter(k_endog=readings, k_states=states, k_posdef=states)
    model["selection"] = np.eye(states)
    unmoved = np.zeros(states)

    def value() -> float:
        mean, noise, start = problem.sampled(theta).at(0)
        model["transition"], model["design"] = mean[0, :states, :states], mean[0, states:, :states]
        model["state_cov"] = noise[0, :states, :states]
        model["obs_cov"] = noise[0, states:, states:]
        left = outputs - simulate_deterministic(problem, theta)[:, states:]
        model.bind(np.ascontiguousarray(left))
        model.initialize_known(unmoved, start[:, 1:])
        return -float(model.loglike())

    return value


def likelihoods_of_a_fit(cost: Likelihood, theta: Numbers) -> int:
    """Return how many likelihoods statsmodels' minimiser, scipy's BFGS by differences, asks for.

    It is given parameters without bounds, as statsmodels' own models give it; ours are counted,
    which have the same values.
    """
    from scipy.optimize import minimize  # noqa: PLC0415  optional

    problem = stretch_cost(cost, theta)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # differences between impossible models
        found = minimize(
            lambda eta: cost.value(problem.theta(eta)),
            np.zeros(len(theta)),
            method="BFGS",
            options={"maxiter": MOST},
        )
    return int(found.nfev)


Maker = Callable[[Problem, Numbers], Callable[[], float]]

MISSING: Final = 0.1  # [-] share of readings
FITS: Final = 50


@dataclass(frozen=True)
class Row:
    """One figure and the most it is wanted to be. None where it cannot be had here, and why."""

    name: str
    figure: float | None
    at_most: float
    note: str = ""

    @property
    def word(self) -> str:
        """Return how the figure stands to what is wanted."""
        if self.figure is None:
            return "left out"
        return "holds" if self.figure <= self.at_most else "MISSED"


@dataclass(frozen=True)
class Speed:
    """The figures that were measured."""

    samples: int
    parameters: int
    likelihood_us: float  # at one interval, nothing missing
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class Other:
    """Another way to the same likelihood. ``make`` is None where it is not here, and why."""

    name: str
    make: Maker | None
    why: str = ""


def in_statsmodels() -> Other:
    """Return the likelihood by statsmodels."""
    try:
        kalman = filters()
    except ImportError:
        return Other("statsmodels", None, "statsmodels is not installed")
    return Other("statsmodels", partial(by_statsmodels, kalman))


def draw_record(problem: Problem) -> Problem:
    """Return the problem with a record drawn from it."""
    return problem.on(draw_outputs(problem, problem.start, np.random.default_rng(1)))


def beside(record: str, problem: Problem, other: Other, at_most: float) -> Row:
    """Return the likelihood's time by that of another, with the limit of it."""
    name, theta = f"likelihood, {record}, of {other.name}", problem.start
    if other.make is None:
        return Row(name, None, at_most, other.why)
    paces = time_in_turn([partial(Likelihood(problem).value, theta), other.make(problem, theta)])
    return Row(name, paces.ratio(0, 1), at_most)


def slopes(problem: Problem) -> tuple[float, list[Row]]:
    """Return the likelihood's time [s], and in likelihoods that of its slopes."""
    theta = problem.start
    paces = time_in_turn(
        [
            partial(Likelihood(problem).value, theta),
            lambda: Likelihood(problem).information(theta),  # anew: a place is kept once known
        ]
    )
    name = "gradient and information, likelihoods"
    return paces.median(0), [Row(name, paces.ratio(1, 0), 40.0)]


def fit(problem: Problem, other: Other) -> list[Row]:
    """Return the time [s] of a fit, and by that of statsmodels' BFGS. An analyst's start begins it.

    The latter's is the likelihoods that its minimiser asks for, at what one takes it.
    """
    cost, begin = Likelihood(problem), TANKER.start()
    works: list[Callable[[], object]] = [
        lambda: find_best_minimum(cost, begin, "scoring", SearchOptions())
    ]
    asked, name = 0, "fit, of statsmodels' BFGS"
    if other.make:
        works.append(other.make(problem, begin))
        asked = likelihoods_of_a_fit(cost, begin)
    paces = time_in_turn(works)
    ratio = paces.ratio(0, 1) / asked if asked else None
    note = f"which asks for {asked} likelihoods" if asked else other.why
    return [Row("fit, s", paces.median(0), 0.3), Row(name, ratio, 1.0 / 50.0, note)]


def many_fits(problem: Problem) -> Row:
    """Return the processor's time [s] of records simulated, fitted, and given intervals."""
    begin = replace(problem, values=problem.whole(TANKER.start()))
    begun = time.process_time()
    for seed in range(FITS):
        one_run(begin, problem.start, seed)
    spent = time.process_time() - begun
    return Row(f"{FITS} ships drawn, fitted, with intervals, s", spent, 5.0)


def identify_speed(samples: int) -> Speed:
    """Return how fast a ship is identified from records of so many samples."""
    rudder = TANKER_RUDDER[:samples]
    whole, missing = (draw_record(TANKER.problem(rudder, share)) for share in (0.0, MISSING))
    statsmodels = in_statsmodels()
    alone, gradients = slopes(whole)
    rows = [
        beside("one interval", whole, statsmodels, 1.0 / 20.0),
        beside("readings missing", missing, statsmodels, 1.0 / 6.0),
        *gradients,
        *fit(whole, statsmodels),
        many_fits(whole),
    ]
    return Speed(samples, len(whole.free), 1e6 * alone, tuple(rows))


def lines(figures: Speed) -> list[str]:
    """Return the figures as lines of a page."""
    page = [
        "",
        f"IDENTIFICATION (Model 1, {figures.parameters} parameters, {figures.samples} samples)",
        f"  one likelihood, one interval {figures.likelihood_us:.0f} us",
        f"  {'':<44}{'figure':>10}{'at most':>10}",
    ]
    for row in figures.rows:
        figure = "-" if row.figure is None else format_figure(row.figure, row.at_most)
        limit = format_figure(row.at_most, row.at_most)
        page.append(f"  {row.name:<44}{figure:>10}{limit:>10}  {row.word}")
        page += textwrap.wrap(row.note, 75, initial_indent="    ", subsequent_indent="    ")
    return page


def format_figure(figure: float, at_most: float) -> str:
    """Return a figure as it is wanted: as a fraction where that is one."""
    return f"1/{1.0 / figure:.3g}" if 0.0 < at_most < 0.2 else f"{figure:.3g}"

"""How fast a ship is identified, beside statsmodels and plain C: ``trainer bench --identify``.

Everything is the tanker of the rehearsals: Model 1, 19 free parameters, three outputs. Ratios are
medians over short batches in turn. Times are the processor's, which others hardly lengthen.
"""

import textwrap
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.exported.linking import NoCompilerError
from trainer.identify.against_c.filter import likelihood_in_c
from trainer.identify.alternating import timed
from trainer.identify.beside_statsmodels import by_statsmodels, filters, likelihoods_of_a_fit
from trainer.identify.coverage import one_run
from trainer.identify.estimate import estimate
from trainer.identify.likelihood import Likelihood
from trainer.identify.minimise import Search
from trainer.identify.problem import Problem
from trainer.identify.rehearsal import TANKER, TANKER_RUDDER
from trainer.identify.samples import Samples
from trainer.identify.simulate import drawn

Maker = Callable[[Problem, Numbers], Callable[[], float]]

MISSING: Final = 0.1  # [-] share of readings
FITS: Final = 50


@dataclass(frozen=True)
class Row:
    """One figure and the most it is wanted to be; None where it cannot be had here, and why."""

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
    """What was measured."""

    samples: int
    parameters: int
    likelihood_us: float  # at one interval, nothing missing
    rows: tuple[Row, ...]


@dataclass(frozen=True)
class Other:
    """Another way to the same likelihood; ``make`` is None where it is not here, and why."""

    name: str
    make: Maker | None
    why: str = ""


def in_c() -> Other:
    """Return the likelihood in plain C."""
    try:
        return Other("C", likelihood_in_c())
    except NoCompilerError as error:
        return Other("C", None, str(error))


def in_statsmodels() -> Other:
    """Return the likelihood by statsmodels."""
    try:
        kalman = filters()
    except ImportError:
        return Other("statsmodels", None, "statsmodels is not installed")
    return Other("statsmodels", partial(by_statsmodels, kalman))


def recorded(problem: Problem) -> Problem:
    """Return the problem with a record drawn from it."""
    return problem.on(drawn(problem, problem.start, np.random.default_rng(1)))


def varied(problem: Problem) -> Problem:
    """Return the problem with no two intervals alike."""
    samples, period = problem.samples, problem.plant.period
    steps = np.random.default_rng(2).uniform(0.5, 1.5, len(samples.t))
    return problem.on(Samples(np.cumsum(steps) * period, samples.outputs, samples.inputs))


def beside(record: str, problem: Problem, wanted: Sequence[tuple[Other, float]]) -> list[Row]:
    """Return the likelihood's time by that of each other, with the most that is wanted of it."""
    theta = problem.start
    here = [other.make(problem, theta) for other, _ in wanted if other.make]
    paces = timed([partial(Likelihood(problem).value, theta), *here])
    rows, place = [], 0
    for other, at_most in wanted:
        name = f"likelihood, {record}, of {other.name}"
        place += other.make is not None
        figure = paces.ratio(0, place) if other.make else None
        rows.append(Row(name, figure, at_most, other.why))
    return rows


def slopes(problem: Problem) -> tuple[float, list[Row]]:
    """Return the likelihood's time [s], and in likelihoods that of gradient and information."""
    cost = Likelihood(problem)
    works = [partial(work, problem.start) for work in (cost.value, cost.slope, cost.information)]
    paces = timed(works)
    gradient, information = paces.ratio(1, 0), paces.ratio(2, 0)
    return paces.median(0), [
        Row("gradient, likelihoods", gradient, 10.0),
        Row("gradient and information, likelihoods", gradient + information, 40.0),
    ]


def fit(problem: Problem, other: Other) -> list[Row]:
    """Return the time [s] of a fit from where an analyst starts, and by that of statsmodels' BFGS.

    The latter's is the likelihoods that its minimiser asks for, at what one takes it.
    """
    cost, begin = Likelihood(problem), TANKER.start()
    works: list[Callable[[], object]] = [lambda: estimate(cost, begin, "auto", Search())]
    asked, name = 0, "fit, of statsmodels' BFGS"
    if other.make:
        works.append(other.make(problem, begin))
        asked = likelihoods_of_a_fit(cost, begin)
    paces = timed(works)
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
    whole, missing = (recorded(TANKER.problem(rudder, share)) for share in (0.0, MISSING))
    changing = recorded(varied(TANKER.problem(rudder)))
    c, statsmodels = in_c(), in_statsmodels()
    alone, gradients = slopes(whole)
    rows = [
        *beside("one interval", whole, [(statsmodels, 1.0 / 20.0), (c, 1.5)]),
        *beside("readings missing", missing, [(statsmodels, 1.0 / 6.0), (c, 1.5)]),
        *beside("intervals differ", changing, [(c, 1.5)]),
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
        figure = "-" if row.figure is None else told(row.figure, row.at_most)
        limit = told(row.at_most, row.at_most)
        page.append(f"  {row.name:<44}{figure:>10}{limit:>10}  {row.word}")
        page += textwrap.wrap(row.note, 75, initial_indent="    ", subsequent_indent="    ")
    return page


def told(figure: float, at_most: float) -> str:
    """Return a figure as it is wanted: as a fraction where that is one."""
    return f"1/{1.0 / figure:.3g}" if 0.0 < at_most < 0.2 else f"{figure:.3g}"

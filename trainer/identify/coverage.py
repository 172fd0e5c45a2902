"""Whether the intervals are honest: simulate, estimate, and count how often the truth is inside."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.estimate import estimate
from trainer.identify.likelihood import Likelihood
from trainer.identify.minimise import Search
from trainer.identify.problem import Problem
from trainer.identify.simulate import drawn
from trainer.identify.uncertainty import uncertainty

WIDTH: Final = 1.959963984540054  # [standard deviations] of half a 95 % interval


@dataclass(frozen=True)
class Run:
    """One simulated record and what was found from it."""

    seed: int
    theta: Numbers  # (f,)
    deviations: Numbers  # (f,) NaN where the information was singular
    cost: float
    cost_at_truth: float
    converged: bool


@dataclass(frozen=True)
class Coverage:
    """Many runs and the truth behind them."""

    names: tuple[str, ...]
    truth: Numbers  # (f,)
    runs: tuple[Run, ...]

    @property
    def estimates(self) -> Numbers:
        """Return the estimates (runs, f)."""
        return np.array([run.theta for run in self.runs])

    @property
    def deviations(self) -> Numbers:
        """Return their standard deviations (runs, f)."""
        return np.array([run.deviations for run in self.runs])

    @property
    def inside(self) -> Numbers:
        """Return of each parameter the share of 95 % intervals that hold the truth (f,)."""
        away = np.abs(self.estimates - self.truth) <= WIDTH * self.deviations
        return np.asarray(away.mean(axis=0))

    @property
    def pooled(self) -> float:
        """Return the share of all intervals that hold the truth."""
        return float(self.inside.mean())

    @property
    def converged(self) -> float:
        """Return the share of runs whose minimiser came to its end."""
        return float(np.mean([run.converged for run in self.runs]))


def one_run(problem: Problem, truth: Numbers, seed: int) -> Run:
    """Return what is found from the record of ``seed``, estimated from the problem's values."""
    stream = np.random.Generator(np.random.PCG64(seed))
    cost = Likelihood(problem.on(drawn(problem, truth, stream)))
    found = estimate(cost, problem.start, "auto", Search())
    known = uncertainty(problem.names, cost.information(found.theta))
    return Run(
        seed,
        found.theta,
        known.deviations,
        found.cost,
        cost.value(truth),
        converged=found.converged,
    )


def study(
    problem: Problem, truth: Numbers, seeds: range, each: Callable[[Iterator[Run]], Iterator[Run]]
) -> Coverage:
    """Return the runs of ``seeds``; ``each`` passes them on and may show how far it is."""
    runs = each(one_run(problem, truth, seed) for seed in seeds)
    return Coverage(problem.names, truth, tuple(runs))

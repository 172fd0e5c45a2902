"""A study carried out: the record read, the model fitted, and what is known afterwards.

``trainer identify`` and ``trainer.identify.fit`` call ``fit_study``. The steps of a long search can
be saved to a file (``--checkpoint``), from which another run goes on.
"""

import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np

from trainer.config.files import ConfigError, quote, raise_problems
from trainer.core.kernel import Numbers
from trainer.identify.fitting.estimate import find_best_minimum
from trainer.identify.fitting.likelihood import (
    FLAG_REASONS,
    MultiStep,
    chi_square_limits,
    run_filter,
)
from trainer.identify.fitting.minimise import (
    Progress,
    SearchOptions,
    SearchResult,
    ignore_news,
)
from trainer.identify.fitting.problem import Problem, RecordCost
from trainer.identify.fitting.study_problem import cost_of, dropped_names, pose_problem, table_of
from trainer.identify.judge.uncertainty import (
    BOUNDED_PREFIXES,
    JointSpread,
    Uncertainty,
    beside_bounds,
    hessian,
    inseparable,
    propagate_covariance,
    uncertainty,
)
from trainer.identify.model.derived import quantities, quantity_units
from trainer.identify.model.nomoto import SteeringModel
from trainer.identify.record.measurements import Record
from trainer.identify.record.study import Study
from trainer.io.outputs import write_whole

MAX_STEPS: Final = 200  # steps, beyond which a search has not settled
MIN_RESTARTS: Final = 2  # whatever a study says
NO_MODEL: Final = "these values are no model: a covariance is not positive, or it does not end"
SCREENING_ROUNDS: Final = 4  # rounds of fitting and rejecting


@dataclass(frozen=True, eq=False)
class ModelFit:
    """A model fitted to a record."""

    study: Study
    record: Record
    others: tuple[Record, ...]  # further runs
    ship: SteeringModel | None  # of the vessel file, if there is one
    cost: RecordCost
    found: SearchResult
    known: Uncertainty
    rejected: tuple[tuple[int, int], ...]  # run and sample screened out
    simulated: bool = False  # nothing was estimated

    @property
    def problem(self) -> Problem:
        """Return what was estimated from what."""
        return self.cost.problem

    @cached_property
    def quantity_names(self) -> tuple[str, ...]:
        """Return the names of the numbers that follow from the parameters."""
        return tuple(quantity_units(self.problem.plant.model))

    @cached_property
    def quantity_spread(self) -> JointSpread:
        """Return the numbers that follow from the parameters, with their covariance.

        The covariance is NaN where that of the parameters is not known.
        """
        problem, covariance = self.problem, self.known.covariance
        spread = propagate_covariance(
            lambda free: quantities(problem.plant, problem.whole(free)),
            self.found.theta,
            np.nan_to_num(covariance, nan=0.0),
        )
        ship = [i for i, name in enumerate(problem.names) if not name.startswith(BOUNDED_PREFIXES)]
        if np.isnan(np.diag(covariance)[ship]).any():
            return JointSpread(spread.values, np.full_like(spread.covariance, math.nan))
        return spread

    @property
    def values(self) -> Numbers:
        """Return all parameters (n,)."""
        return self.problem.whole(self.found.theta)

    @property
    def log_likelihood(self) -> float:
        """Return log L [-]."""
        return -self.found.cost


def _check_separable(study: Study, problem: Problem) -> None:
    """Check that the record tells the parameters apart; ConfigError naming those that it does not.

    Nothing is checked where the noise model leaves parameters out.
    """
    if dropped_names(study, problem.plant):
        return
    problems = [
        f'cannot separate {" with ".join(group)}: fix one of them, free = "no"'
        if len(group) > 1
        else f'tells nothing of {group[0]}: fix it, free = "no"'
        for group in inseparable(problem)
    ]
    raise_problems([f"{study.path.name}: this record {text}" for text in problems])


def fit_study(
    study: Study,
    record: Record,
    heard: Callable[[SearchResult], None],
    kept: Path | None = None,
    others: Sequence[Record] = (),
) -> ModelFit:
    """Return the model of a study fitted to its record.

    Each step of the search is given to ``heard``. The search is saved to the file ``kept``, and
    goes on from there if the file exists. ``others`` are the records of the study's further runs.
    ConfigError if the study lacks something, or its start is no model.
    """
    problem, vessel_steering = pose_problem(study, record, others)
    _check_separable(study, problem)
    start, search = problem.start, SearchOptions(MAX_STEPS, heard)
    if kept is not None:
        start = resume_search(kept, problem) if kept.exists() else start
        search = SearchOptions(MAX_STEPS, save_steps(kept, problem, heard))
    table = table_of(study)
    cost, method = cost_of(problem, table), table.method
    restarts = max(MIN_RESTARTS, int(table.restarts))
    minimum = find_best_minimum(cost, start, method, search, restarts)
    rejected: list[tuple[int, int]] = []
    # an outlier bends the fit by which others are judged: fit and reject until none is found
    for _ in range(SCREENING_ROUNDS if table.reject else 0):
        problem, more = screen_samples(problem, minimum.theta, table.reject or 0.0)
        rejected += more
        if not more:
            break
        cost = cost_of(problem, table)
        minimum = find_best_minimum(cost, minimum.theta, method, search)
    known = _estimate_uncertainty(cost, minimum.theta)
    outliers = tuple(sorted(rejected))
    return ModelFit(study, record, tuple(others), vessel_steering, cost, minimum, known, outliers)


def simulate_study(study: Study, record: Record, others: Sequence[Record] = ()) -> ModelFit:
    """Return the model of a study as it starts, nothing estimated (LOOP 0, ISYS 4).

    Outliers are left out if the study says so.
    """
    problem, vessel_steering = pose_problem(study, record, others, fixed=False)
    table = table_of(study)
    rejected: list[tuple[int, int]] = []
    if table.reject:
        problem, rejected = screen_samples(problem, problem.start, table.reject)
    cost = cost_of(problem, table)
    value = cost.value(problem.start)
    if not math.isfinite(value):
        raise ConfigError(f"{study.path.name}: {NO_MODEL}")
    start_result = SearchResult(problem.start, value, 0, converged=True)
    shape = uncertainty(problem.names, cost.information(problem.start))
    known = replace(shape, covariance=np.full_like(shape.curvature, math.nan))
    outliers = tuple(sorted(rejected))
    return ModelFit(
        study,
        record,
        tuple(others),
        vessel_steering,
        cost,
        start_result,
        known,
        outliers,
        simulated=True,
    )


def screen_samples(
    problem: Problem, theta: Numbers, probability: float
) -> tuple[Problem, list[tuple[int, int]]]:
    """Return the problem without improbable samples, and the run and index of each of these."""
    kept_samples, outliers = [], []
    limits = chi_square_limits(probability, problem.samples.outputs.shape[1])
    for number, (run, at) in enumerate(problem.runs):
        flags = run_filter(run, theta[at], limits).flags
        rejected = flags == FLAG_REASONS.index("rejected")
        kept_samples.append(run.samples.without(rejected))
        outliers += [(number, int(index)) for index in np.flatnonzero(rejected)]
    further = zip(problem.others, kept_samples[1:], strict=True)
    others = tuple(replace(run, samples=samples) for run, samples in further)
    return replace(problem, samples=kept_samples[0], others=others), outliers


def _estimate_uncertainty(cost: RecordCost, theta: Numbers) -> Uncertainty:
    """Return what is known of the parameters: by the Hessian, else by the information.

    The information serves where a variance has gone to zero, because the Hessian is indefinite
    there. Where neither is finite nothing is known. A cost of several steps ahead has no
    deviations, because its errors are not independent.
    """
    names = cost.problem.names
    if isinstance(cost, MultiStep):
        shape = uncertainty(names, cost.information(theta))
        return replace(shape, covariance=np.full_like(shape.covariance, math.nan))
    curvature = hessian(cost, theta)
    if np.isfinite(curvature).all():
        by_hessian = uncertainty(names, curvature)
        if not np.isnan(by_hessian.covariance).any():
            return by_hessian
    known = beside_bounds(uncertainty(names, cost.information(theta)))
    if np.isnan(known.directions).any():
        return replace(known, directions=np.eye(len(names)))
    return known


def save_steps(path: Path, problem: Problem, heard: Progress = ignore_news) -> Progress:
    """Return a function that saves each step of a search whole, and passes it on."""

    def write(found: SearchResult) -> None:
        theta = problem.folded(found.theta) * problem.scale
        state = {
            "model": problem.plant.model.name,
            "cost": found.cost,
            "parameters": dict(zip(problem.names, map(float, theta), strict=True)),
        }
        write_whole(path, json.dumps(state, indent=1) + "\n")
        heard(found)

    return write


def resume_search(path: Path, problem: Problem) -> Numbers:
    """Return where to start (f,), from a file that ``save_steps`` wrote.

    ConfigError if it is of another model or lacks a free parameter.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"), parse_int=float)
        model, parameters = content["model"], dict(content["parameters"])
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

"""A study carried out: the record read, the model fitted, and what is known afterwards."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.config.vessel import load_vessel
from trainer.core.kernel import Numbers
from trainer.identify.derived import quantities, quantity_names
from trainer.identify.estimate import Starts, estimate, keep, resume
from trainer.identify.innovations import REASONS, chi_square_limits, run_filter
from trainer.identify.likelihood import Likelihood
from trainer.identify.measurements import Record, check_count, samples_of
from trainer.identify.minimise import Cost, Found, Search
from trainer.identify.models import MODELS, Plant, Ship
from trainer.identify.prediction_error import Innovations, MultiStep, no_gain, settled_gain
from trainer.identify.problem import Problem, problem_of
from trainer.identify.start_values import free_names, start_values
from trainer.identify.steering import Steering, steering
from trainer.identify.study import Study, speed_of
from trainer.identify.study_records import ModelTable
from trainer.identify.uncertainty import (
    BOUNDED,
    Spread,
    Uncertainty,
    beside_bounds,
    hessian,
    inseparable,
    propagate,
    uncertainty,
)

METHODS: Final = {"scoring": "auto", "bfgs": "bfgs", "direct": "powell"}
STEPS: Final = 200
RESTARTS: Final = 12  # in a row that must not find better, before a fit counts as settled
FEWEST: Final = 2  # of them, whatever a study says
SCREENINGS: Final = 4  # rounds of fitting and rejecting
UNMODELLED: Final = {  # noise models do not have these: the errors' covariance is concentrated out
    "output-error": ("R1", "R2"),
    "innovations": ("R2_psi", "R2_v1", "R2_v"),
}


@dataclass(frozen=True, eq=False)
class Fitted:
    """A model fitted to a record."""

    study: Study
    record: Record
    ship: Steering | None  # of the vessel file, if there is one
    problem: Problem
    cost: Cost
    found: Found
    known: Uncertainty
    told: Spread  # of the quantities
    quantity_names: tuple[str, ...]
    rejected: int  # samples screened out

    @property
    def values(self) -> Numbers:
        """Return all parameters (n,)."""
        return self.problem.whole(self.found.theta)

    @property
    def log_likelihood(self) -> float:
        """Return log L [-]."""
        return -self.found.cost


def pose_problem(study: Study, record: Record) -> tuple[Problem, Steering | None]:
    """Return the problem of a study, and the ship of its vessel file.

    ConfigError for what it lacks, and naming the parameters that the record cannot separate.
    """
    table = table_of(study)
    if study.ship is None:
        raise ConfigError(f"{study.path.name}: lacks [ship]: say --length or --vessel")
    speed = speed_of(study, record)
    ship = Ship(
        study.ship.length_m, speed, study.ship.bow_log_m or 0.0, study.ship.stern_log_m or 0.0
    )
    plant = Plant(MODELS[table.kind], ship, table.outputs, record.interval)
    vessel = study.ship.vessel
    own = steering(load_vessel(vessel), speed) if vessel else None
    values = start_values(plant, record, own.prime if own else {}, study.parameters)
    dropped = UNMODELLED.get(table.noise or "", ())
    asked = {row.name for row in study.parameters if row.free == "yes"}
    free = [
        name
        for name in free_names(plant, study.parameters)
        if name in asked or not name.startswith(dropped) or not dropped
    ]
    if not free:
        raise ConfigError(
            f'{study.path.name}: every parameter is fixed, free = "no": nothing is left to estimate'
        )
    sampling = table.measurement or "instantaneous"
    samples = samples_of(record, table.outputs)
    problem = problem_of(plant, samples, values, free)
    check_count(record, samples.counted, len(free))
    scale = [_scale(study, plant, place) for place in problem.free]
    problem = Problem(plant, samples, values, problem.free, np.array(scale), sampling)
    groups = inseparable(problem) if not dropped else ()
    if groups:
        raise ConfigError(*(f"{study.path.name}: {_inseparable(group)}" for group in groups))
    return problem, own


def _inseparable(group: tuple[str, ...]) -> str:
    """Return what is wrong with a group of parameters that the record does not tell apart."""
    if len(group) == 1:
        return f'this record tells nothing of {group[0]}: fix it, free = "no"'
    return f'this record cannot separate {" with ".join(group)}: fix one of them, free = "no"'


def table_of(study: Study) -> ModelTable:
    """Return the model of a study; ConfigError if it has none."""
    if study.model is None:
        raise ConfigError(f"{study.path.name}: lacks [model]: say --model")
    return study.model


def _scale(study: Study, plant: Plant, place: int) -> float:
    """Return the scale of a parameter."""
    for row in study.parameters:
        if row.scale is not None and place in plant.model.places((row.name,)):
            return row.scale
    return 1.0


def cost_of(problem: Problem, table: ModelTable) -> Cost:
    """Return what the study wants minimised; ConfigError for what does not go together."""
    noise = table.noise or "covariance"
    steps = int(table.predict_from or 1), int(table.predict_to or 1)
    if noise != "covariance":
        if steps != (1, 1):
            raise ConfigError(f"predict_to goes with noise covariance, not with {noise}")
        return Innovations(problem, no_gain if noise == "output-error" else settled_gain)
    if steps[1] < steps[0]:
        raise ConfigError(f"predict_to = {steps[1]}: must be at least predict_from = {steps[0]}")
    return Likelihood(problem) if steps == (1, 1) else MultiStep(problem, *steps)


def fit(
    study: Study, record: Record, heard: Callable[[Found], None], kept: Path | None = None
) -> Fitted:
    """Return the model of a study fitted to its record. Each step is told to ``heard``.

    A search is kept in the file ``kept``, and goes on from there if there is one. ConfigError if
    it cannot be posed, or the start is no model.
    """
    problem, own = pose_problem(study, record)
    start, search = problem.start, Search(STEPS, heard)
    if kept is not None:
        start = resume(kept, problem) if kept.exists() else start
        search = Search(STEPS, _both(heard, keep(kept, problem)))
    table = table_of(study)
    restarts = RESTARTS if table.restarts is None else max(FEWEST, int(table.restarts))
    cost, method = cost_of(problem, table), METHODS[table.method or "scoring"]
    found = estimate(cost, start, method, search, Starts(restarts))
    rejected = 0
    for _ in range(SCREENINGS if table.reject else 0):
        problem, more = screen(problem, found.theta, table.reject or 0.0)
        rejected += more
        if not more:
            break
        cost = cost_of(problem, table)
        found = estimate(cost, found.theta, method, search)
    known = _estimate_uncertainty(cost, found.theta)
    return Fitted(
        study=study,
        record=record,
        ship=own,
        problem=problem,
        cost=cost,
        found=found,
        known=known,
        told=_derive(problem, found.theta, known.covariance),
        quantity_names=quantity_names(problem.plant.model),
        rejected=rejected,
    )


def _derive(problem: Problem, theta: Numbers, covariance: Numbers) -> Spread:
    """Return what follows of the parameters, and how well; not a number where these are not."""
    plant = problem.plant
    told = propagate(
        lambda free: quantities(plant.model, problem.whole(free), plant.ship),
        theta,
        np.nan_to_num(covariance, nan=0.0),
    )
    ship = [i for i, name in enumerate(problem.names) if not name.startswith(BOUNDED)]
    if np.isnan(np.diag(covariance)[ship]).any():
        return Spread(told.values, np.full_like(told.covariance, math.nan))
    return told


def _both(
    first: Callable[[Found], None], second: Callable[[Found], None]
) -> Callable[[Found], None]:
    """Return what tells two listeners."""

    def tell(found: Found) -> None:
        first(found)
        second(found)

    return tell


def screen(problem: Problem, theta: Numbers, probability: float) -> tuple[Problem, int]:
    """Return the problem without the samples that are improbable, and how many these are."""
    samples = problem.samples
    run = run_filter(problem, theta, chi_square_limits(probability, samples.outputs.shape[1]))
    rejected = run.flags == REASONS.index("rejected")
    return problem.on(samples.without(rejected)), int(np.count_nonzero(rejected))


def _estimate_uncertainty(cost: Cost, theta: Numbers) -> Uncertainty:
    """Return what is known of the parameters: by the Hessian, or where that fails by information.

    A variance at nothing makes the Hessian indefinite. Where neither is finite nothing is known.
    Errors of several steps are not independent: their second derivatives tell no deviations.
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
    information = cost.information(theta)
    if np.isfinite(information).all():
        return beside_bounds(uncertainty(names, information))
    n = len(names)
    unknown = np.full((n, n), math.nan)
    return Uncertainty(names, unknown, unknown, unknown[0], np.eye(n), ())


def settings(table: ModelTable) -> dict[str, Any]:
    """Return what was asked of the model, defaults filled in."""
    return {
        "noise": table.noise or "covariance",
        "measurement": table.measurement or "instantaneous",
        "method": table.method or "scoring",
        "system": table.system or "prime",
    }

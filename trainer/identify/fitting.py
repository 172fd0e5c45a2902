"""A study carried out: the record read, the model fitted, and what is known afterwards."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.config.vessel import load_vessel
from trainer.core.kernel import Numbers
from trainer.identify.derived import quantities, quantity_units
from trainer.identify.estimate import Starts, estimate, keep, resume
from trainer.identify.likelihood import Likelihood
from trainer.identify.measurements import Record, check_count, samples_of
from trainer.identify.minimise import Cost, Found, Search
from trainer.identify.models import MODELS, Model, Plant, Ship
from trainer.identify.own_systems import NOISE, System, model_of
from trainer.identify.prediction_error import (
    REASONS,
    Innovations,
    MultiStep,
    chi_square_limits,
    no_gain,
    own_gain,
    run_filter,
    settled_gain,
)
from trainer.identify.problem import Problem, Run, problem_of
from trainer.identify.start_values import free_names, start_values
from trainer.identify.steering import Steering, steering
from trainer.identify.study import Study, speed_of, studies_of
from trainer.identify.study_records import ModelTable, ParameterRow
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

STEPS: Final = 200
RESTARTS: Final = 12  # in a row that must not find better, before a fit counts as settled
FEWEST: Final = 2  # of them, whatever a study says
NO_SHIP: Final = Ship(1.0, 1.0)  # of a user's own system, which has its own units
NO_MODEL: Final = "these values are no model: a covariance is not positive, or it does not end"
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
    others: tuple[Record, ...]  # further runs
    ship: Steering | None  # of the vessel file, if there is one
    cost: Cost
    found: Found
    known: Uncertainty
    rejected: tuple[tuple[int, int], ...]  # run and sample screened out
    simulated: bool = False  # nothing was estimated

    @property
    def problem(self) -> Problem:
        """Return what was estimated from what."""
        return self.cost.problem

    @cached_property
    def quantity_names(self) -> tuple[str, ...]:
        """Return the names of what follows of the parameters."""
        return tuple(quantity_units(self.problem.plant.model))

    @cached_property
    def told(self) -> Spread:
        """Return what follows of the parameters, and how well; NaN where these are not known."""
        problem, covariance = self.problem, self.known.covariance
        told = propagate(
            lambda free: quantities(problem.plant, problem.whole(free)),
            self.found.theta,
            np.nan_to_num(covariance, nan=0.0),
        )
        ship = [i for i, name in enumerate(problem.names) if not name.startswith(BOUNDED)]
        if np.isnan(np.diag(covariance)[ship]).any():
            return Spread(told.values, np.full_like(told.covariance, math.nan))
        return told

    @property
    def values(self) -> Numbers:
        """Return all parameters (n,)."""
        return self.problem.whole(self.found.theta)

    @property
    def log_likelihood(self) -> float:
        """Return log L [-]."""
        return -self.found.cost


def pose_problem(
    study: Study, record: Record, others: Sequence[Record] = (), *, fixed: bool = True
) -> tuple[Problem, Steering | None]:
    """Return the problem of a study, and the ship of its vessel file.

    ConfigError for what it lacks, and naming the parameters that the record cannot separate. What
    is held counts as free unless ``fixed``, and nothing is checked.
    """
    table, studies = table_of(study), studies_of(study)
    plant, own = _plant_of(study, record)
    known = own.prime if own else {}
    rows = study.parameters if fixed else tuple(replace(x, free=None) for x in study.parameters)
    free = _estimated(study, plant, rows)
    if not free:
        raise ConfigError(
            f'{study.path.name}: every parameter is fixed, free = "no": nothing is left to estimate'
        )
    inputs = ("rudder",) if study.system is None else study.system.inputs
    runs = []
    for one, seen in zip(studies, (record, *others), strict=True):
        at = replace(plant, ship=replace(plant.ship, speed=_speed(one, seen)))
        values = _start(one, at, seen, known)
        runs.append(Run(at, samples_of(seen, plant.outputs, inputs), values))
    samples, values = runs[0].samples, runs[0].values
    problem = problem_of(plant, samples, values, free)
    scale = [_scale(study, plant, place) for place in problem.free]
    sampling = table.measurement or "instantaneous"
    if study.system is not None and study.system.discrete:
        sampling = "discrete"
        _check_interval(study, runs)
    places = _of_each_run(plant.model, rows, problem.free) if others else ()
    scale += [scale[problem.free.index(place)] for place in places] * len(others)
    problem = replace(
        problem,
        scale=np.array(scale),
        sampling=sampling,
        others=tuple(runs[1:]),
        own=places,
    )
    if fixed:
        check_count(record, problem.counted, len(problem.names))
    groups = inseparable(problem) if fixed and not _dropped(study, plant) else ()
    if groups:
        raise ConfigError(*(f"{study.path.name}: {_inseparable(group)}" for group in groups))
    return problem, own


def _plant_of(study: Study, record: Record) -> tuple[Plant, Steering | None]:
    """Return the model of a study's ship, and the ship of its vessel file; ConfigError."""
    table = table_of(study)
    if study.system is not None:
        return Plant(model_of(study.system), NO_SHIP, table.outputs, record.interval), None
    if study.ship is None:
        raise ConfigError(f"{study.path.name}: lacks [ship]: say --length or --vessel")
    speed, ship = speed_of(study, record), study.ship
    scales = Ship(ship.length_m, speed, ship.bow_log_m or 0.0, ship.stern_log_m or 0.0)
    own = steering(load_vessel(ship.vessel), speed) if ship.vessel else None
    return Plant(MODELS[table.kind], scales, table.outputs, record.interval), own


def _speed(study: Study, record: Record) -> float:
    """Return the speed of a run [m/s]; ConfigError if it is not known."""
    return NO_SHIP.speed if study.system is not None else speed_of(study, record)


def _start(study: Study, plant: Plant, record: Record, ship: Mapping[str, float]) -> Numbers:
    """Return all parameters (n,) that a run starts from."""
    if study.system is None:
        return start_values(plant, record, ship, study.parameters)
    values = study.system.starts.copy()
    for row in study.parameters:
        place = plant.model.place(row.name)
        values[place] = values[place] if row.start is None else row.start
    return values


def _estimated(study: Study, plant: Plant, rows: Sequence[ParameterRow]) -> list[str]:
    """Return the names of the parameters to estimate."""
    dropped, asked = _dropped(study, plant), {row.name for row in rows if row.free == "yes"}
    names = free_names(plant, rows) if study.system is None else _own_free(study.system, rows)
    return [name for name in names if name in asked or name not in dropped]


def _own_free(system: System, rows: Sequence[ParameterRow]) -> list[str]:
    """Return the free parameters of a user's own system."""
    said = {row.name: row.free for row in rows if row.free is not None}
    names = (one.name for one in system.parameters)
    return [x for x in names if said.get(x, "no" if x in system.held else "yes") == "yes"]


def _dropped(study: Study, plant: Plant) -> tuple[str, ...]:
    """Return the parameters that the noise model does not have."""
    noise = table_of(study).noise or ""
    if study.system is None:
        return tuple(x for x in plant.model.names if x.startswith(UNMODELLED.get(noise, ("?",))))
    if noise == "innovations" and not study.system.has_gain:
        return study.system.only_in({"R2"})[:1]
    return study.system.only_in(NOISE) if noise in UNMODELLED else ()


def _of_each_run(
    model: Model, rows: Sequence[ParameterRow], free: Sequence[int]
) -> tuple[int, ...]:
    """Return the places of the free parameters that each run has for itself."""
    own = set(model.of_each_run)
    for row in rows:
        if row.per_run is not None:
            (own.add if row.per_run == "yes" else own.discard)(model.names[model.place(row.name)])
    return tuple(place for place in free if model.names[place] in own)


def _check_interval(study: Study, runs: Sequence[Run]) -> None:
    """Check that all samples are one interval apart; ConfigError."""
    steps = {round(float(step), 6) for run in runs for step in run.samples.steps[0]}
    if len(steps) > 1:
        raise ConfigError(
            f"{study.path.name}: matrices of one step need one interval; there are {len(steps)}: "
            "fill the gaps with rows without readings, or write a continuous system"
        )


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
    noise, own = table.noise or "covariance", problem.plant.model.system
    steps = int(table.predict_from or 1), int(table.predict_to or 1)
    if noise != "covariance":
        if steps != (1, 1):
            raise ConfigError(f"predict_to goes with noise covariance, not with {noise}")
        gains = no_gain if noise == "output-error" else settled_gain
        gave = own is not None and problem.sampled(problem.start).gain is not None
        return Innovations(problem, own_gain if gave and gains is settled_gain else gains)
    if steps[1] < steps[0]:
        raise ConfigError(f"predict_to = {steps[1]}: must be at least predict_from = {steps[0]}")
    return Likelihood(problem) if steps == (1, 1) else MultiStep(problem, *steps)


def fit(
    study: Study,
    record: Record,
    heard: Callable[[Found], None],
    kept: Path | None = None,
    others: Sequence[Record] = (),
) -> Fitted:
    """Return the model of a study fitted to its record. Each step is told to ``heard``.

    A search is kept in the file ``kept``, and goes on from there if there is one. ``others`` are
    the records of the study's further runs. ConfigError if it cannot be posed, or the start is no
    model.
    """
    problem, own = pose_problem(study, record, others)
    start, search = problem.start, Search(STEPS, heard)
    if kept is not None:
        start = resume(kept, problem) if kept.exists() else start
        search = Search(STEPS, keep(kept, problem, heard))
    table = table_of(study)
    restarts = RESTARTS if table.restarts is None else max(FEWEST, int(table.restarts))
    cost, method = cost_of(problem, table), table.method or "scoring"
    found = estimate(cost, start, method, search, Starts(restarts))
    rejected: list[tuple[int, int]] = []
    for _ in range(SCREENINGS if table.reject else 0):
        problem, more = screen(problem, found.theta, table.reject or 0.0)
        rejected += more
        if not more:
            break
        cost = cost_of(problem, table)
        found = estimate(cost, found.theta, method, search)
    known = _estimate_uncertainty(cost, found.theta)
    outliers = tuple(sorted(rejected))
    return Fitted(study, record, tuple(others), own, cost, found, known, outliers)


def simulate(study: Study, record: Record, others: Sequence[Record] = ()) -> Fitted:
    """Return the model of a study as it starts, nothing estimated (LOOP 0, ISYS 4).

    Outliers are screened if the study says so.
    """
    problem, own = pose_problem(study, record, others, fixed=False)
    table = table_of(study)
    rejected: list[tuple[int, int]] = []
    if table.reject:
        problem, rejected = screen(problem, problem.start, table.reject)
    cost = cost_of(problem, table)
    value = cost.value(problem.start)
    if not math.isfinite(value):
        raise ConfigError(f"{study.path.name}: {NO_MODEL}")
    found = Found(problem.start, value, 0, converged=True)
    shape = uncertainty(problem.names, cost.information(problem.start))
    known = replace(shape, covariance=np.full_like(shape.curvature, math.nan))
    outliers = tuple(sorted(rejected))
    return Fitted(study, record, tuple(others), own, cost, found, known, outliers, simulated=True)


def screen(
    problem: Problem, theta: Numbers, probability: float
) -> tuple[Problem, list[tuple[int, int]]]:
    """Return the problem without the samples that are improbable, and their runs and places."""
    kept, found = [], []
    limits = chi_square_limits(probability, problem.samples.outputs.shape[1])
    for number, (run, at) in enumerate(problem.runs):
        flags = run_filter(run, theta[at], limits).flags
        rejected = flags == REASONS.index("rejected")
        kept.append(run.samples.without(rejected))
        found += [(number, int(place)) for place in np.flatnonzero(rejected)]
    further = zip(problem.others, kept[1:], strict=True)
    others = tuple(replace(run, samples=samples) for run, samples in further)
    return replace(problem, samples=kept[0], others=others), found


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

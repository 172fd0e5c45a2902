"""The problem that a study file poses: model, ship, runs, free parameters, cost.

``judge/fitted`` calls it before a fit. The cost follows from the study's ``noise``: the likelihood,
or a prediction error (output error, innovations, several steps ahead).
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.config.vessel import load_vessel
from trainer.core.kernel import Numbers
from trainer.identify.fitting.likelihood import Likelihood
from trainer.identify.fitting.minimise import Cost
from trainer.identify.fitting.prediction_error import (
    Innovations,
    MultiStep,
    no_gain,
    own_gain,
    settled_gain,
)
from trainer.identify.fitting.problem import FurtherRun, Problem, problem_of
from trainer.identify.fitting.start_values import free_names, start_values
from trainer.identify.model.models import MODELS, Model, Plant, Ship
from trainer.identify.model.own_systems import NOISE_MATRICES, model_of
from trainer.identify.model.steering import SteeringModel, find_steering
from trainer.identify.record.measurements import Record, check_count, samples_of
from trainer.identify.record.study import Study, speed_of, studies_of
from trainer.identify.record.study_records import ModelTable, ParameterRow

NO_SHIP: Final = Ship(1.0, 1.0)  # of a user's own system, which has its own units
# noise models do not have these: the errors' covariance is concentrated out
UNMODELLED_NOISE: Final = {
    "output-error": ("R1", "R2"),
    "innovations": ("R2_psi", "R2_v1", "R2_v"),
}


def pose_problem(
    study: Study, record: Record, others: Sequence[Record] = (), *, fixed: bool = True
) -> tuple[Problem, SteeringModel | None]:
    """Return the problem of a study, and the ship of its vessel file.

    ConfigError for what the study lacks. With ``fixed`` false nothing will be estimated: parameters
    that the study holds are free too, and the number of samples is not checked.
    """
    table, studies = table_of(study), studies_of(study)
    plant, vessel_steering = _plant_of(study, record)
    known = vessel_steering.prime if vessel_steering else {}
    rows = study.parameters if fixed else tuple(replace(x, free=None) for x in study.parameters)
    free = _estimated(study, plant, rows)
    if not free:
        raise ConfigError(
            f'{study.path.name}: every parameter is fixed, free = "no": nothing is left to estimate'
        )
    inputs = ("rudder",) if study.system is None else study.system.inputs
    runs = []
    for one, seen in zip(studies, (record, *others), strict=True):
        speed = NO_SHIP.speed if one.system is not None else speed_of(one, seen)
        at = replace(plant, ship=replace(plant.ship, speed=speed))
        values = _start(one, at, seen, known)
        runs.append(FurtherRun(at, samples_of(seen, plant.outputs, inputs), values))
    samples, values = runs[0].samples, runs[0].values
    problem = problem_of(plant, samples, values, free)
    indices = plant.model.indices
    row_scales = [
        (indices((row.name,)), row.scale) for row in study.parameters if row.scale is not None
    ]
    scales = {index: size for inside, size in reversed(row_scales) for index in inside}
    scale = [scales.get(index, 1.0) for index in problem.free]
    sampling = table.measurement
    if study.system is not None and study.system.discrete:
        sampling = "discrete"
        _check_interval(study, runs)
    run_parameters = _of_each_run(plant.model, rows, problem.free) if others else ()
    scale += [scale[problem.free.index(index)] for index in run_parameters] * len(others)
    further: dict[str, Any] = {"others": tuple(runs[1:]), "own": run_parameters}
    problem = replace(problem, scale=np.array(scale), sampling=sampling, **further)
    if fixed:
        check_count(record, problem.counted, len(problem.names))
    return problem, vessel_steering


def _plant_of(study: Study, record: Record) -> tuple[Plant, SteeringModel | None]:
    """Return the model of a study's ship, and the ship of its vessel file; ConfigError."""
    table = table_of(study)
    if study.system is not None:
        return Plant(model_of(study.system), NO_SHIP, table.outputs, record.interval), None
    if study.ship is None:
        raise ConfigError(f"{study.path.name}: lacks [ship]: say --length or --vessel")
    speed, ship = speed_of(study, record), study.ship
    scales = Ship(ship.length_m, speed, ship.bow_log_m or 0.0, ship.stern_log_m or 0.0)
    vessel_steering = find_steering(load_vessel(ship.vessel), speed) if ship.vessel else None
    return Plant(MODELS[table.kind], scales, table.outputs, record.interval), vessel_steering


def _start(study: Study, plant: Plant, record: Record, ship: Mapping[str, float]) -> Numbers:
    """Return all parameters (n,) that a run starts from."""
    if study.system is None:
        return start_values(plant, record, ship, study.parameters)
    values = study.system.starts.copy()
    for row in study.parameters:
        index = plant.model.index(row.name)
        values[index] = values[index] if row.start is None else row.start
    return values


def _estimated(study: Study, plant: Plant, rows: Sequence[ParameterRow]) -> list[str]:
    """Return the names of the parameters to estimate."""
    dropped, wanted = dropped_names(study, plant), {row.name for row in rows if row.free == "yes"}
    if study.system is None:
        names: Sequence[str] = free_names(plant, rows)
    else:
        estimated = dict.fromkeys(study.system.held, "no")
        estimated |= {row.name: row.free for row in rows if row.free is not None}
        names = [x.name for x in study.system.parameters if estimated.get(x.name, "yes") == "yes"]
    return [name for name in names if name in wanted or name not in dropped]


def dropped_names(study: Study, plant: Plant) -> tuple[str, ...]:
    """Return the parameters that the noise model does not have."""
    noise = table_of(study).noise
    if study.system is None:
        return tuple(
            x for x in plant.model.names if x.startswith(UNMODELLED_NOISE.get(noise, ("?",)))
        )
    system = study.system
    if noise == "innovations" and "K" not in system.matrices(system.starts[None]):
        return system.only_in({"R2"})[:1]  # it has no gain of its own
    return system.only_in(NOISE_MATRICES) if noise in UNMODELLED_NOISE else ()


def _of_each_run(
    model: Model, rows: Sequence[ParameterRow], free: Sequence[int]
) -> tuple[int, ...]:
    """Return the indices of the free parameters that differ from run to run."""
    run_names = set(model.of_each_run)
    for row in rows:
        if row.per_run is not None:
            (run_names.add if row.per_run == "yes" else run_names.discard)(
                model.names[model.index(row.name)]
            )
    return tuple(index for index in free if model.names[index] in run_names)


def _check_interval(study: Study, runs: Sequence[FurtherRun]) -> None:
    """Check that all samples are one interval apart; ConfigError."""
    steps = {round(float(step), 6) for run in runs for step in run.samples.steps[0]}
    if len(steps) > 1:
        raise ConfigError(
            f"{study.path.name}: matrices of one step need one interval; there are {len(steps)}: "
            "fill the gaps with rows without readings, or write a continuous system"
        )


def table_of(study: Study) -> ModelTable:
    """Return the model of a study; ConfigError if it has none."""
    if study.model is None:
        raise ConfigError(f"{study.path.name}: lacks [model]: say --model")
    return study.model


def cost_of(problem: Problem, table: ModelTable) -> Cost:
    """Return what the study wants minimised; ConfigError for what does not go together."""
    noise, system = table.noise, problem.plant.model.system
    steps = int(table.predict_from), int(table.predict_to)
    if noise != "covariance":
        if steps != (1, 1):
            raise ConfigError(f"predict_to goes with noise covariance, not with {noise}")
        gains = no_gain if noise == "output-error" else settled_gain
        gave = system is not None and problem.sampled(problem.start).gain is not None
        return Innovations(problem, own_gain if gave and gains is settled_gain else gains)
    if steps[1] < steps[0]:
        raise ConfigError(f"predict_to = {steps[1]}: must be at least predict_from = {steps[0]}")
    return Likelihood(problem) if steps == (1, 1) else MultiStep(problem, *steps)

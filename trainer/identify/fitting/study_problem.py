"""The problem that a study file poses: model, ship, runs, free parameters, their start, cost.

``judge/fitted`` calls it before a fit. The cost follows from the study's ``noise``: the likelihood,
or a prediction error (output error, innovations, several steps ahead). Model 1's ship comes from a
vessel file or the study, that of the other models from a regression on the record. Errors of
readings start as the scatter of neighbouring samples, disturbances as those that would make a tenth
of the motion.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, Final

import numpy as np

from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.fitting.likelihood import (
    Innovations,
    Likelihood,
    MultiStep,
    no_gain,
    own_gain,
    settled_gain,
)
from trainer.identify.fitting.problem import FurtherRun, Problem, RecordCost, problem_of
from trainer.identify.model.models import MODELS, OUTPUT_UNITS, Model, Plant, Ship
from trainer.identify.model.nomoto import SteeringModel, find_steering, rate_coefficients
from trainer.identify.model.own_systems import NOISE_MATRICES, model_of
from trainer.identify.record.measurements import Record, check_count, samples_of
from trainer.identify.record.readings import at_readings
from trainer.identify.record.study import Study, speed_of, studies_of
from trainer.identify.record.study_records import ModelTable, ParameterRow

DISTURBANCE_SHARE: Final = 0.1  # [-] of the yaw rate (sway with Model 2) that disturbances make
MIN_ERRORS: Final = {"sway": 1e-3, "yaw_rate": 1e-3, "heading": 1e-3}  # errors [kn], [deg/s], [deg]
ACCELERATION_NAMES: Final = ("m11", "m12", "m21", "m22")
DERIVATIVE_NAMES: Final = ("Y_v", "Y_r", "N_v", "N_r", "Y_delta", "l_delta")
FREE_NAMES: Final[Mapping[str, tuple[str, ...]]] = {  # beside errors and the initial state
    "1": (*DERIVATIVE_NAMES, "Y_0", "N_0", "R1_Y", "R1_N"),
    "2": ("a1", "a2", "c1", "c2", "f2", "R1_1", "R1_2"),
    "3": ("a1", "a2", "b1", "b2", "f1", "R1_1", "R1_2"),
    "nomoto1": ("K", "T", "delta_0", "R1_r"),
    "nomoto2": ("a1", "a2", "b1", "b2", "delta_0", "R1_1", "R1_2"),
}
TURNING_ERRORS: Final = {"yaw_rate": "R2_r", "heading": "R2_psi"}
ERROR_NAMES: Final[Mapping[str, Mapping[str, str]]] = {  # of what is read
    "1": {"sway": "R2_v1", "bow_sway": "R2_v1", "stern_sway": "R2_v2", **TURNING_ERRORS},
    "2": {"sway": "R2_v"},
    **dict.fromkeys(("3", "nomoto1", "nomoto2"), TURNING_ERRORS),
}
INITIAL_STATE_NAMES: Final[
    Mapping[str, tuple[tuple[str, str], ...]]
] = {  # initial state: what reads it
    "1": (("x1_0", "sway"), ("x2_0", "yaw_rate"), ("x3_0", "heading")),
    "2": (("x1_0", "sway"), ("x2_0", "")),
    "3": (("x1_0", ""), ("x2_0", "yaw_rate"), ("x3_0", "heading")),
    "nomoto1": (("x1_0", "yaw_rate"), ("x2_0", "heading")),
    "nomoto2": (("x1_0", ""), ("x2_0", "yaw_rate"), ("x3_0", "heading")),
}
DISTURBANCE_NAMES: Final = ("R1_Y", "R1_N", "R1_1", "R1_2", "R1_r")
NO_SHIP: Final = Ship(1.0, 1.0)  # of a user's own system, which has its own units
# noise models do not have these: the errors' covariance is concentrated out
UNMODELLED_NOISE: Final = {
    "output-error": ("R1", "R2"),
    "innovations": ("R2_psi", "R2_v1", "R2_v"),
}


def free_names(plant: Plant, rows: Sequence[ParameterRow]) -> tuple[str, ...]:
    """Return the parameters to estimate: the model's usual ones, as ``rows`` have it otherwise.

    The initial heading is held if no heading is read, because no other reading depends on it.
    """
    model = plant.model
    names = list(FREE_NAMES[model.name])
    names += dict.fromkeys(ERROR_NAMES[model.name][output] for output in plant.outputs)
    heading = "heading" in plant.outputs
    names += [
        name for name, channel in INITIAL_STATE_NAMES[model.name] if channel != "heading" or heading
    ]
    chosen = set(model.indices(names))
    for word, change in (("yes", chosen.update), ("no", chosen.difference_update)):
        change(model.indices(row.name for row in rows if row.free == word))
    return tuple(name for index, name in enumerate(model.names) if index in chosen)


def start_values(
    plant: Plant, record: Record, ship: Mapping[str, float], rows: Sequence[ParameterRow]
) -> Numbers:
    """Return all parameters (n,) to start from; ``ship`` has those known of the ship.

    ConfigError that names the parameters of Model 1 which neither ``ship`` nor ``rows`` give.
    """
    model = plant.model
    known_values = dict(ship) if model.name == "1" else {}
    stated_starts = {row.name: row.start for row in rows if row.start is not None}
    shown = _regress(plant, record) | _read(plant, record)
    values = model.vector(
        **shown | {name: stated_starts[name] for name in model.given if name in stated_starts}
    )
    for name in stated_starts.keys() - set(model.given):
        known_values[model.names[model.index(name)]] = stated_starts[name]
    for name, value in known_values.items():
        values[model.index(name)] = value
    if model.name == "1":
        lacking = [
            name for name in (*ACCELERATION_NAMES, *DERIVATIVE_NAMES) if name not in known_values
        ]
        if lacking:
            raise ConfigError(
                f"model 1 lacks a start for {', '.join(lacking)}: give a vessel, or "
                "[[parameters]]; m11 to m22 cannot be estimated, the others start from a similar "
                "ship"
            )
    _disturb(plant, record, values, known_values)
    return values


def _read(plant: Plant, record: Record) -> dict[str, float]:
    """Return initial state and variances of errors as the record shows them."""
    kind = plant.model.name
    starts = {}
    for output in plant.outputs:
        values = record.column(output) * OUTPUT_UNITS[output][1]
        known = values[~np.isnan(values)]
        least = MIN_ERRORS.get(output, MIN_ERRORS["sway"])
        rough = np.diff(known, 3) / math.sqrt(20.0)  # white noise of unit variance has 20
        starts[ERROR_NAMES[kind][output]] = max(float(np.var(rough)), least**2)
    for name, channel in INITIAL_STATE_NAMES[kind]:
        if channel and channel in record.channels:
            values = record.column(channel) * OUTPUT_UNITS[channel][1]
            starts[name] = float(values[~np.isnan(values)][0])
    return starts


def _regress(plant: Plant, record: Record) -> dict[str, float]:
    """Return the ship of yaw or sway alone by regression on the record; () for Model 1."""
    kind = plant.model.name
    if kind == "1":
        return {}
    k = plant.ship.speed / plant.ship.length
    gain, T = first_order(record, "sway" if kind == "2" else "yaw_rate")
    T2, T3 = T / 8.0, T / 4.0  # an estimate from many ships: a start need not be near
    T1 = T + T3 - T2
    if kind == "nomoto1":
        return {"K": gain, "T": T}
    if kind == "nomoto2":
        return {"K": gain, "T1": T1, "T2": T2, "T3": T3}
    a1, a2, b1, b2 = rate_coefficients(gain, T1, T2, T3)
    values = {"a1": a1 / k, "a2": a2 / k**2}
    if kind == "3":
        return values | {"b1": b1 / k**2, "b2": b2 / k**3}
    V = plant.ship.speed
    return values | {"c1": b1 / (k * V), "c2": b2 / (k**2 * V)}


def first_order(record: Record, channel: str) -> tuple[float, float]:
    """Return gain and time constant [s] of rudder to a channel by least squares, SI.

    A yaw rate that was not read is derived from the heading.
    """
    read = at_readings(record)
    values = read.column("turning" if channel == "yaw_rate" else channel)
    rudder, step = read.mean_ahead(read.column("rudder")), read.interval
    usual = np.abs(np.diff(read.t) - step) < (0.01 if read is record else 0.5) * step
    good = usual & ~np.isnan(values[1:]) & ~np.isnan(values[:-1])
    if np.count_nonzero(good) < 4:
        raise ConfigError(f"{record.source}: {channel} has too few neighbouring values to start")
    regressors = np.column_stack([values[:-1], rudder[:-1], np.ones(len(rudder) - 1)])[good]
    p, b, _ = np.linalg.lstsq(regressors, values[1:][good], rcond=None)[0]
    # noise may put the pole outside 0 to 1, where no ship has one: a start need not be exact
    p = min(max(float(p), 0.2), 0.99)
    return float(b) / (1.0 - p), -step / math.log(p)


def _disturb(plant: Plant, record: Record, values: Numbers, known: Mapping[str, float]) -> None:
    """Write the densities of disturbance that make a tenth of the motion, unless given."""
    model = plant.model
    names = [name for name in DISTURBANCE_NAMES if name in model.names and name not in known]
    if not names:
        return
    indices = [model.index(name) for name in names]
    values[indices] = 1.0
    noise = plant.blocks(values[None]).noise[0]
    index = 0 if model.name in ("nomoto1", "2") else 1
    seen = record.sway if model.name == "2" else record.yaw_rate
    seen = at_readings(record).column("turning")[:-1] if seen is None else seen
    motion = float(np.nanstd(seen)) or 1e-6  # the usual size of it, SI
    variance = (DISTURBANCE_SHARE * motion) ** 2
    values[indices] = variance / max(noise[index, index], 1e-300) / (5.0 * record.interval)


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


def cost_of(problem: Problem, table: ModelTable) -> RecordCost:
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

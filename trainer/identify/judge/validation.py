"""A fitted model beside simpler ones, and run by the rudder on other records.

Numbers in brackets are equations of the model document (MI). A model that follows its own record
need not follow another, so ``--check`` predicts a record that was not fitted. ``bend_of`` takes the
curve of steady turns from a record of large manoeuvres. ``--against`` and ``--without`` ask whether
a simpler model would do: twice the difference of the log-likelihoods is compared with chi-square of
the parameters that are fewer (8.3).
"""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.fitting.likelihood import Innovations, possible
from trainer.identify.fitting.minimise import ignore_news
from trainer.identify.fitting.nonlinear import (
    CURVE_NAMES,
    LINEAR_NAMES,
    BendEstimate,
    BentShip,
    bend_from_records,
    curve_from_turns,
)
from trainer.identify.fitting.problem import Problem
from trainer.identify.fitting.study_problem import INITIAL_STATE_NAMES, table_of
from trainer.identify.judge.fitted import ModelFit, fit_study
from trainer.identify.judge.residuals import aic_of_likelihood, ratio_test
from trainer.identify.judge.uncertainty import covariance_root
from trainer.identify.kernels.covariance_filter import FixedGain, run_predictor
from trainer.identify.model.derived import nomoto_of
from trainer.identify.model.models import MODELS
from trainer.identify.record.measurements import Record, Samples, samples_of
from trainer.identify.record.study import Study, load_study, observe_record
from trainer.identify.record.study_records import ParameterRow

ZERO_PARAMETERS: Final = {"T3": "b1"}  # what is nothing where a number that follows from it is


def simulate_deterministic(problem: Problem, theta: Numbers) -> Numbers:
    """Return states and outputs (n, x+y) of the model alone, without any noise.

    The states are SI, the outputs in knots and degrees.
    """
    mean, _, start = problem.sampled(theta).at(0)
    return _driven(
        problem.samples, mean, start[:, 0], np.zeros((len(problem.samples.t), len(start)))
    )


def _driven(samples: Samples, mean: Numbers, first: Numbers, driven: Numbers) -> Numbers:
    """Return states and outputs (n, x+y) from the state ``first`` on.

    ``driven`` (n, x) is added to the state at each step.
    """
    readings = samples.outputs.shape[1]
    out = np.empty((len(samples.t), len(first) + readings))
    system = FixedGain(mean, np.zeros((len(first), readings)), np.ascontiguousarray(first))
    run_predictor(system, samples.table, samples.steps[1], np.ascontiguousarray(driven), out)
    return out


def draw_outputs(problem: Problem, theta: Numbers, stream: np.random.Generator) -> Samples:
    """Return the samples with outputs drawn from the model; missing readings stay missing.

    ``monte_carlo`` makes its records so. ConfigError if the parameters are no model.
    """
    sampled = problem.sampled(theta)
    if not possible(sampled):
        raise ConfigError("these parameters are no model: a covariance is not positive")
    mean, noise, start = sampled.at(0)
    samples = problem.samples
    states, rows = len(start), mean.shape[1]
    white = stream.standard_normal((len(samples.t), rows))
    disturbed = np.einsum("kij,kj->ki", covariance_root(noise)[samples.steps[1]], white)
    first = start[:, 0] + covariance_root(start[:, 1:]) @ stream.standard_normal(states)
    out = _driven(samples, mean, first, disturbed[:, :states]) + disturbed
    readings = np.where(np.isnan(samples.outputs), np.nan, out[:, states:])
    return replace(samples, outputs=readings)


@dataclass(frozen=True)
class ValidationCheck:
    """How well a record is predicted by rudder alone, from the best initial state."""

    source: str
    outputs: tuple[str, ...]
    rms: tuple[float, ...]  # of the model's error [kn, deg/s, deg]
    share: tuple[float, ...]  # [-] of the output's own rms about its mean
    own: tuple[float, ...]  # [-] the same for the record fitted
    explained: tuple[float, ...]  # [-] of the output's variance, 1 - share^2


def predict_alone(problem: Problem, theta: Numbers) -> Numbers:
    """Return the outputs (n, y) of the model by rudder alone, from its initial state."""
    return simulate_deterministic(problem, theta)[:, problem.plant.model.states :]


def check_of(fitted: ModelFit, path: Path) -> ValidationCheck:
    """Return how well another record of the same columns is predicted; ConfigError if it cannot."""
    problem = other_problem(fitted, other_record(fitted, path))
    other_errors, own_errors = (_errors(one) for one in (problem, _first_run(fitted)))
    share = other_errors / _spread(problem)
    return ValidationCheck(
        source=str(path),
        outputs=problem.plant.outputs,
        rms=tuple(map(float, other_errors)),
        share=tuple(map(float, share)),
        own=tuple(map(float, own_errors / _spread(fitted.problem))),
        explained=tuple(map(float, 1.0 - share**2)),
    )


def other_record(fitted: ModelFit, path: Path) -> Record:
    """Return the record of another study, or of a file with the same columns."""
    if path.suffix == ".toml":
        system = fitted.study.system
        study = load_study(path)
        study = (
            study if system is None else replace(study, columns=fitted.study.columns, system=system)
        )
        return observe_record(study)
    heading = replace(fitted.study.heading, data=path.name, from_s=None, to_s=None)
    beside = path.parent / fitted.study.path.name  # a study's record lies in the study's folder
    return observe_record(replace(fitted.study, path=beside, heading=heading))


def bend_of(fitted: ModelFit, path: Path, kind: str, *, joint: bool) -> tuple[BendEstimate, Record]:
    """Return what steady turns or a large manoeuvre tell of the fitted ship (12).

    Returns their record too. ``kind`` is "kappa", "bech" for H(r) of a record, or "spiral" for H(r)
    of steady turns, whose times are not read. With ``joint`` the linear constants are estimated
    too, from both records. ConfigError if the model has no yaw, or a pair of complex roots.
    """
    plant = fitted.problem.plant
    form = nomoto_of(plant.model, fitted.values, plant.ship)
    if not form.K or form.T1.imag or not form.T2.real:
        raise ConfigError(f"{kind} goes with K, T1, T2 and T3: fit model 1, 3 or nomoto2")
    ship = BentShip(form.K, form.T1.real, form.T2.real, form.T3)
    if kind == "spiral":
        study = load_study(path) if path.suffix == ".toml" else fitted.study
        columns = {
            name: study.columns[name] for name in ("rudder", "yaw_rate") if name in study.columns
        }
        data = study.heading.data if path.suffix == ".toml" else path.name
        heading = replace(study.heading, data=data, from_s=None, to_s=None, every=1.0)
        beside = path.parent / study.path.name  # as in other_record
        record = observe_record(
            replace(study, path=beside, heading=heading, columns=columns, sensors=None)
        )
        rudder, rate = record.column("rudder"), record.column("yaw_rate")
        return curve_from_turns(ship, record.source, rudder, rate), record
    record = other_record(fitted, path)
    # the search begins at a bend that halves the gain at the fastest turn (an estimate)
    fastest = float(np.nanmax(np.abs(record.column("yaw_rate"))))
    ship = replace(ship, kappa=1.0 / (abs(form.K) * fastest))
    fitted_record = fitted.record
    # one record given twice must not count twice: its errors would seem smaller than they are
    same = len(fitted_record.t) == len(record.t) and bool(np.allclose(fitted_record.t, record.t))
    same = same and np.array_equal(fitted_record.column("rudder"), record.column("rudder"))
    records = [fitted_record, record] if joint and not same else [record]
    free = ("kappa",) if kind == "kappa" else CURVE_NAMES
    return bend_from_records(ship, records, (*LINEAR_NAMES, *free) if joint else free), record


def other_problem(fitted: ModelFit, record: Record) -> Problem:
    """Return the fitted model on another record, from the initial state that fits it best.

    By rudder alone the outputs are linear in that state, so that least squares finds it. Each
    output is weighed by its own errors; else a fit of the heading's hundredths of a degree would be
    paid for with whole degrees a second of yaw rate. Outputs that were not recorded are NaN; if
    none was recorded, the ship begins at rest.
    """
    plant = fitted.problem.plant
    system, known = plant.model.system, {}
    if system is None:
        unknown = {name: np.full(len(record.t), np.nan) for name in plant.outputs}
        known = {name: getattr(record, name) for name in plant.outputs if name in record.channels}
        samples = samples_of(replace(record, **{**unknown, **known}), plant.outputs)
    else:
        samples = samples_of(record, plant.outputs, system.inputs)
    problem = replace(_first_run(fitted), samples=samples)
    # states that may differ at the start: all of them in a user's own system
    states = len(INITIAL_STATE_NAMES.get(plant.model.name, range(plant.model.states)))
    first = problem.sampled(problem.start).start[0, :, 0].real
    first[:states] = 0.0
    problem = replace(problem, first=first)
    if not known and system is None:
        return problem
    # the outputs are linear in the first state: those from rest, and their change by each unit
    still = predict_alone(problem, problem.start)
    units = [replace(problem, first=first + one) for one in np.eye(len(first))[:states]]
    noise = np.diag(plant.blocks(fitted.values[None]).noise[0])
    spread = np.sqrt(noise[plant.model.states :])
    if isinstance(fitted.cost, Innovations):  # it has no errors of readings, so by their scatter
        spread = _errors(_first_run(fitted))
    present, weight = ~np.isnan(samples.outputs), 1.0 / np.maximum(spread, 1e-12)
    changes = [predict_alone(unit, unit.start) - still for unit in units]
    free = np.column_stack([(change * weight)[present] for change in changes])
    width = np.maximum(np.linalg.norm(free, axis=0), 1e-300)
    residuals = ((samples.outputs - still) * weight)[present]
    best = np.linalg.lstsq(free / width, residuals, rcond=None)[0] / width
    return replace(problem, first=np.concatenate([best, first[states:]]))


def _first_run(fitted: ModelFit) -> Problem:
    """Return the problem of the first run alone, with the estimated values."""
    problem, _ = fitted.problem.runs[0]
    return replace(problem, values=fitted.values)


def _errors(problem: Problem) -> Numbers:
    """Return the rms of the errors by rudder alone (y,)."""
    residuals = problem.samples.outputs - predict_alone(problem, problem.start)
    return np.asarray(np.sqrt(np.nanmean(residuals**2, axis=0)))


def _spread(problem: Problem) -> Numbers:
    """Return the standard deviations of the outputs (y,), above zero for a division."""
    return np.asarray(np.maximum(np.nanstd(problem.samples.outputs, axis=0), 1e-300))


@dataclass(frozen=True)
class RivalModel:
    """A simpler model, and the likelihood-ratio test of the larger one against it."""

    name: str
    parameters: int
    log_likelihood: float
    aic: float
    ratio: float  # 2 (log L of the larger - log L)
    freedom: int
    probability: float  # [-] of so large a ratio by chance: small, and the larger is worth it


def compare_without(fitted: ModelFit, names: tuple[str, ...]) -> RivalModel:
    """Return the test against the same model with the parameters ``names`` at zero.

    ConfigError if one of them was not estimated.
    """
    model, study = fitted.problem.plant.model, fitted.study
    wanted = [model.names[model.index(ZERO_PARAMETERS.get(name, name))] for name in names]
    shown_names = [
        name if name in ZERO_PARAMETERS else one for name, one in zip(names, wanted, strict=True)
    ]
    held = [name for name in wanted if name not in fitted.problem.names]
    if held:
        raise ConfigError(f"--without {held[0]}: it was not estimated, so there is nothing to test")
    rows = tuple(
        row
        for row in study.parameters
        if row.name in model.given or model.names[model.index(row.name)] not in wanted
    )
    nothing = tuple(ParameterRow(name=name, start=0.0, free="no") for name in wanted)
    smaller = replace(study, parameters=(*rows, *nothing))
    return _test_smaller(fitted, smaller, "without " + ", ".join(shown_names))


def compare_models(fitted: ModelFit, kind: str) -> RivalModel:
    """Return the test against another model of the same outputs; ConfigError if it lacks one."""
    table = table_of(fitted.study)
    lacking = [name for name in table.outputs if name not in MODELS[kind].outputs]
    if lacking:
        raise ConfigError(f"--against {kind}: it has no {lacking[0]}, which this fit has")
    smaller = replace(fitted.study, model=replace(table, kind=kind), parameters=())
    return _test_smaller(fitted, smaller, f"model {kind}")


def _test_smaller(fitted: ModelFit, smaller: Study, name: str) -> RivalModel:
    """Return the fit of a smaller study, and the test against it."""
    table = table_of(smaller)
    if (table.predict_from, table.predict_to) != (1.0, 1.0):
        raise ConfigError("order tests need the likelihood: predict one step, not more")
    other = fit_study(smaller, fitted.record, ignore_news, others=fitted.others)
    count, full_count = len(other.problem.names), len(fitted.problem.names)
    test = ratio_test((other.log_likelihood, count), (fitted.log_likelihood, full_count))
    return RivalModel(
        name=name,
        parameters=count,
        log_likelihood=other.log_likelihood,
        aic=aic_of_likelihood(other.log_likelihood, count),
        ratio=test.statistic,
        freedom=test.freedom,
        probability=test.probability,
    )

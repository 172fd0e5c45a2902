"""What a fit amounts to, for page, JSON and plot: parameters, ship, losses, residuals."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config import ConfigError
from trainer.fitout import KNOT
from trainer.identify.filtered import COUNTED, Filtered, run_filter
from trainer.identify.findings import examine, unwrapped
from trainer.identify.fitting import Fitted, fit, settings
from trainer.identify.nomoto import froude, scale
from trainer.identify.predictor import Innovations
from trainer.identify.residuals import Residuals, examine_residuals, verdicts
from trainer.identify.samples import samples_of
from trainer.identify.simulate import deterministic
from trainer.identify.sources import load_record, own_columns
from trainer.identify.study_file import Study, observe
from trainer.identify.tests_of_order import aic_of_likelihood
from trainer.identify.told import DERIVATIVES, QUANTITIES

LAGS: Final = 10


@dataclass(frozen=True)
class Estimate:
    """One number and its standard deviation, None where the record does not tell."""

    name: str
    unit: str
    value: float
    deviation: float | None


@dataclass(frozen=True)
class Derivative:
    """A derivative in the study's system, and in the other one where the mass is known."""

    name: str
    prime: float | None
    bis: float | None
    deviation: float | None  # in the study's system


@dataclass(frozen=True)
class Check:
    """How well a record is predicted by rudder alone, from its first sample."""

    source: str
    outputs: tuple[str, ...]
    rms: tuple[float, ...]  # of the model's error [kn, deg]
    share: tuple[float, ...]  # [-] of the output's own rms about its mean
    own: tuple[float, ...]  # [-] the same for the record fitted


@dataclass(frozen=True)
class Report:
    """All that ``trainer identify`` says about a model."""

    study: str
    source: str
    model: str
    settings: dict[str, Any]
    length_m: float
    speed_kn: float
    outputs: tuple[str, ...]
    samples: int
    interval_s: float
    findings: tuple[str, ...]
    converged: bool
    steps: int
    log_likelihood: float
    aic: float
    loss_1: float  # V1 of the one-step errors
    loss_1_alone: float  # V1 of the model by rudder alone
    screened: int
    parameters: tuple[Estimate, ...]
    ship: tuple[Estimate, ...]
    derivatives: tuple[Derivative, ...]
    stability: str
    eigenvalue: float  # smallest of the scaled information
    weakest: tuple[str, ...]  # parameters of that direction
    residuals: tuple[Residuals, ...]
    verdicts: tuple[str, ...]
    check: Check | None


def carried_out(
    study: Study, check: Path | None, heard: Callable[[int, float], None]
) -> tuple[Fitted, Report]:
    """Return the fit of a study and its report; ConfigError for what cannot be."""
    observed = observe(study)
    fitted = fit(study, observed.record, lambda found: heard(found.steps, found.cost))
    findings = tuple(map(str, observed.findings))
    return fitted, report_of(fitted, findings, check)


def report_of(fitted: Fitted, findings: tuple[str, ...], check: Path | None) -> Report:
    """Return what a fit amounts to, checked on another record where there is one."""
    problem, study, plant = fitted.problem, fitted.study, fitted.problem.plant
    filtered = errors_of(fitted)
    table = study.model
    if table is None:
        raise ConfigError(f"{study.path.name}: lacks [model]")
    residuals = _residuals(fitted, filtered)
    return Report(
        study=study.heading.name,
        source=fitted.record.source,
        model=plant.model.name,
        settings=settings(table),
        length_m=plant.ship.length,
        speed_kn=plant.ship.speed / KNOT,
        outputs=plant.outputs,
        samples=problem.samples.counted,
        interval_s=plant.period,
        findings=findings,
        converged=fitted.found.converged,
        steps=fitted.found.steps,
        log_likelihood=fitted.log_likelihood,
        aic=aic_of_likelihood(fitted.log_likelihood, len(problem.free)),
        loss_1=filtered.loss_1(),
        loss_1_alone=_alone(fitted),
        screened=len(fitted.record.t) - fitted.record_counted - problem.samples.counted,
        parameters=_parameters(fitted),
        ship=_ship(fitted),
        derivatives=_derivatives(fitted),
        stability=_stability(fitted),
        eigenvalue=float(fitted.known.eigenvalues[0]),
        weakest=_weakest(fitted),
        residuals=residuals,
        verdicts=tuple(text for one in residuals for text in verdicts(one)),
        check=None if check is None else check_of(fitted, check),
    )


def errors_of(fitted: Fitted) -> Filtered:
    """Return the one-step errors of a fit, by the predictor that was fitted."""
    cost, theta = fitted.cost, fitted.found.theta
    if not isinstance(cost, Innovations):
        return run_filter(fitted.problem, theta, {})
    errors = cost.errors(theta)
    whole = errors[~np.isnan(errors).any(axis=1)]
    factor = np.linalg.cholesky(whole.T @ whole / len(whole))
    standard = np.linalg.solve(factor, errors.T).T
    return Filtered(
        errors=errors,
        standardised=standard,
        predicted=fitted.problem.samples.outputs - errors,
        squares=np.sum(standard**2, axis=1),
        status=np.full(len(errors), COUNTED),
    )


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _parameters(fitted: Fitted) -> tuple[Estimate, ...]:
    """Return the estimated parameters, unscaled."""
    parameters, problem = fitted.problem.plant.model.parameters, fitted.problem
    numbers = zip(
        problem.free, fitted.found.theta, fitted.known.deviations, problem.scale, strict=True
    )
    return tuple(
        Estimate(parameters[i].name, parameters[i].unit, float(x * by), _finite(s * by))
        for i, x, s, by in numbers
    )


def _ship(fitted: Fitted) -> tuple[Estimate, ...]:
    """Return gains and time constants that the model has, SI."""
    told = zip(fitted.quantity_names, fitted.told.values, fitted.told.deviations, strict=True)
    return tuple(
        Estimate(name, QUANTITIES[name], float(x), _finite(s))
        for name, x, s in told
        if name in QUANTITIES and x != 0.0 and math.isfinite(x)
    )


def _derivatives(fitted: Fitted) -> tuple[Derivative, ...]:
    """Return the derivatives of Model 1 in both systems, theta'' = theta'/m' (3.6)."""
    table, ship = fitted.study.model, fitted.study.ship
    bis = table is not None and table.system == "bis"
    mass = None
    if ship is not None and ship.displacement_m3 is not None:
        mass = 2.0 * ship.displacement_m3 / ship.length_m**3
    told = zip(fitted.quantity_names, fitted.told.values, fitted.told.deviations, strict=True)
    found = []
    for name, value, deviation in told:
        if name not in DERIVATIVES:
            continue
        own = float(value)
        other = None if mass is None else own * mass if bis else own / mass
        pair = (other, own) if bis else (own, other)
        found.append(Derivative(name, *pair, _finite(deviation)))
    return tuple(found)


def _stability(fitted: Fitted) -> str:
    """Return in words whether she keeps a straight course, and how surely."""
    told = dict(zip(fitted.quantity_names, fitted.told.values, strict=True))
    known = dict(zip(fitted.quantity_names, fitted.told.deviations, strict=True))
    value, deviation = float(told["1/T1"]), float(known["1/T1"])
    word = "stable" if value > 0.0 else "unstable"
    if not math.isfinite(deviation) or deviation == 0.0:
        return f"{word}: 1/T1 = {value:.4g} 1/s"
    sure = abs(value) / deviation
    doubt = "" if sure > 2.0 else ", which this record does not settle"
    return f"{word}: 1/T1 = {value:.4g} +- {deviation:.2g} 1/s, {sure:.1f} deviations from 0{doubt}"


def _weakest(fitted: Fitted) -> tuple[str, ...]:
    """Return the parameters of the direction that the record tells least of."""
    direction = np.abs(fitted.known.directions[:, 0])
    names = fitted.known.names
    return tuple(
        name for name, part in zip(names, direction, strict=True) if part > 0.3 * direction.max()
    )


def _residuals(fitted: Fitted, filtered: Filtered) -> tuple[Residuals, ...]:
    """Return the examination of each output's residuals, as far as there are enough."""
    rudder = fitted.problem.samples.inputs[:, 0]
    lags = min(LAGS, (filtered.counted - 2) // 2)
    if lags < 1:
        return ()
    outputs = enumerate(fitted.problem.plant.outputs)
    return tuple(
        examine_residuals(name, filtered.standardised[:, i], rudder, lags)
        for i, name in outputs
        if np.count_nonzero(~np.isnan(filtered.standardised[:, i])) >= 2 * lags + 2
    )


def alone(fitted: Fitted) -> Any:
    """Return the outputs (n, y) of the model by rudder alone, from its initial state."""
    states = fitted.problem.plant.model.states
    return deterministic(fitted.problem, fitted.found.theta)[:, states:]


def _alone(fitted: Fitted) -> float:
    left = fitted.problem.samples.outputs - alone(fitted)
    whole = left[~np.isnan(left).any(axis=1)]
    return float(np.linalg.slogdet(whole.T @ whole)[1]) / len(whole)


def check_of(fitted: Fitted, path: Path) -> Check:
    """Return how well another record of the same columns is predicted; ConfigError if it cannot.

    The model starts from that record's own first readings.
    """
    study, plant = fitted.study, fitted.problem.plant
    record = load_record(path, study.columns or own_columns())
    if study.heading.positive_rudder == "starboard" and record.rudder is not None:
        record = record.turned()
    examine(record)
    record = unwrapped(record).every(int(study.heading.every or 1))
    samples = samples_of(record, plant.outputs)
    values = fitted.values
    model, first = plant.model, dict(zip(plant.outputs, samples.outputs[0], strict=True))
    starts = {"sway": 0, "yaw_rate": 1, "heading": 2} if model.name == "1" else {}
    for channel, place in starts.items():
        if channel in first:
            values[model.start + place] = first[channel]
    problem = fitted.problem.on(samples)
    problem = problem.holding(values) if hasattr(problem, "holding") else problem
    there = deterministic(problem, values[list(problem.free)] / problem.scale)
    left = samples.outputs - there[:, model.states :]
    rms = np.sqrt(np.nanmean(left**2, axis=0))
    share = rms / np.maximum(np.nanstd(samples.outputs, axis=0), 1e-300)
    own = fitted.problem.samples.outputs
    fitted_rms = np.sqrt(np.nanmean((own - alone(fitted)) ** 2, axis=0))
    return Check(
        source=str(path),
        outputs=plant.outputs,
        rms=tuple(map(float, rms)),
        share=tuple(map(float, share)),
        own=tuple(map(float, fitted_rms / np.maximum(np.nanstd(own, axis=0), 1e-300))),
    )


def in_systems(fitted: Fitted) -> dict[str, dict[str, float]]:
    """Return K, T1 ... in prime and bis units, by system (3.6)."""
    ship = fitted.problem.plant.ship
    told = dict(zip(fitted.quantity_names, map(float, fitted.told.values), strict=True))
    found = {}
    for system in ("prime", "bis"):
        unit = scale(system, ship.length, ship.speed)
        powers = {"1/s": unit.time, "s": 1.0 / unit.time, "m/s": 1.0 / unit.speed}
        found[system] = {name: told[name] * powers[QUANTITIES[name]] for name in QUANTITIES}
    return found | {"Froude": {"F_nL": froude(ship.length, ship.speed)}}

"""What a fit amounts to, for page, JSON and plot: parameters, ship, losses, residuals."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from trainer.fitout import KNOT
from trainer.identify.fitting import Fitted, fit, settings, table_of
from trainer.identify.nonlinear import Bend
from trainer.identify.prediction import Check, bend_of, check_of, loss_alone
from trainer.identify.predictor import Innovations
from trainer.identify.residuals import Residuals, examine_residuals, verdicts
from trainer.identify.shown import Shown, losses, shown, unlimited
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
    check: Check | None = None
    bend: Bend | None = None


def carried_out(
    study: Study, options: dict[str, Any], heard: Callable[[int, float], None]
) -> tuple[Fitted, Report]:
    """Return the fit of a study and its report; ConfigError for what cannot be.

    ``options`` has other records to check it on and to find kappa from, and a checkpoint.
    """
    observed = observe(study)
    fitted = fit(
        study,
        observed.record,
        lambda found: heard(found.steps, found.cost),
        options["checkpoint"],
    )
    report = report_of(fitted, tuple(map(str, observed.findings)))
    if options["check"] is not None:
        report = replace(report, check=check_of(fitted, options["check"]))
    if options["kappa"] is not None:
        report = replace(report, bend=bend_of(fitted, options["kappa"]))
    return fitted, report


def report_of(fitted: Fitted, findings: tuple[str, ...]) -> Report:
    """Return what a fit amounts to."""
    problem, study, plant = fitted.problem, fitted.study, fitted.problem.plant
    run = errors_of(fitted)
    residuals = _residuals(fitted, run)
    return Report(
        study=study.heading.name,
        source=fitted.record.source,
        model=plant.model.name,
        settings=settings(table_of(study)),
        length_m=plant.ship.length,
        speed_kn=plant.ship.speed / KNOT,
        outputs=plant.outputs,
        samples=problem.samples.counted,
        interval_s=plant.period,
        findings=findings,
        converged=bool(fitted.found.converged),
        steps=fitted.found.steps,
        log_likelihood=fitted.log_likelihood,
        aic=aic_of_likelihood(fitted.log_likelihood, len(problem.free)),
        loss_1=losses(run).V1,
        loss_1_alone=loss_alone(fitted),
        screened=fitted.rejected,
        parameters=_parameters(fitted),
        ship=_ship(fitted),
        derivatives=_derivatives(fitted),
        stability=_stability(fitted),
        eigenvalue=float(fitted.known.eigenvalues[0]),
        weakest=_weakest(fitted),
        residuals=residuals,
        verdicts=tuple(text for one in residuals for text in verdicts(one)),
    )


def errors_of(fitted: Fitted) -> Shown:
    """Return the one-step errors of a fit, by the predictor that was fitted."""
    cost, theta = fitted.cost, fitted.found.theta
    run = shown(fitted.problem, theta, unlimited(len(fitted.problem.plant.outputs)))
    if not isinstance(cost, Innovations):
        return run
    errors = cost.errors(theta)
    whole = errors[~np.isnan(errors).any(axis=1)]
    R = whole.T @ whole / len(whole)
    return replace(
        run,
        predictions=fitted.problem.samples.outputs - errors,
        errors=errors,
        spreads=np.tile(R, (len(errors), 1, 1)),
        squares=np.einsum("ki,ij,kj->k", errors, np.linalg.inv(R), errors),
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
        prime, both = (other, own) if bis else (own, other)
        found.append(Derivative(name, prime, both, _finite(deviation)))
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


def _residuals(fitted: Fitted, run: Shown) -> tuple[Residuals, ...]:
    """Return the examination of each output's residuals, as far as there are enough."""
    rudder = fitted.problem.samples.inputs[:, 0]
    lags = min(LAGS, (int(run.counted.sum()) - 2) // 2)
    if lags < 1:
        return ()
    outputs, standard = enumerate(fitted.problem.plant.outputs), run.standardised
    return tuple(
        examine_residuals(name, standard[:, i], rudder, lags)
        for i, name in outputs
        if np.count_nonzero(~np.isnan(standard[:, i])) >= 2 * lags + 2
    )

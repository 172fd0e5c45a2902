"""A study carried out, and its results as records for text, JSON and HTML.

``carry_out`` is the work of ``trainer identify`` for a linear model: read, fit, judge, compare.
Every field of ``IdentifyReport`` is a key of ``--json``.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.fitting.likelihood import MultiStep, PredictionRun, loss_1
from trainer.identify.fitting.nonlinear import BendEstimate
from trainer.identify.fitting.problem import Problem
from trainer.identify.fitting.study_problem import table_of
from trainer.identify.judge.allowed import MIN_COMPLEX_SHARE, AllowedShips, draw_allowed
from trainer.identify.judge.fitted import ModelFit, fit_study, simulate_study
from trainer.identify.judge.residuals import (
    Residuals,
    aic_of_likelihood,
    describe_tests,
    examine_residuals,
)
from trainer.identify.judge.uncertainty import intervals
from trainer.identify.judge.validation import (
    RivalModel,
    ValidationCheck,
    bend_of,
    check_of,
    compare_models,
    compare_without,
    predict_alone,
)
from trainer.identify.model.derived import DERIVATIVE_NAMES, quantity_units
from trainer.identify.options import IdentifyOptions
from trainer.identify.pages.series import (
    Matrices,
    Series,
    TermSize,
    bent_terms,
    errors_of,
    matrices_of,
    sizes_of,
    terms_of,
)
from trainer.identify.record.measurements import Record
from trainer.identify.record.study import Study, observe_record, studies_of
from trainer.units import KNOT

# of the model, as used: with them a fit can be repeated
SETTING_NAMES: Final = ("noise", "measurement", "method", "system")
SHOWN_LAGS: Final = 10  # [samples] over which residuals are tested and drawn


@dataclass(frozen=True)
class FitNumber:
    """One number, its standard deviation and its 95 % interval.

    They are None where the record does not determine the number. Where the two disagree the
    interval is right: see judge.uncertainty.intervals.
    """

    name: str
    unit: str
    value: float
    deviation: float | None
    low: float | None
    high: float | None


class ShipNumber(FitNumber):
    """A gain or time constant, with an interval by draws.

    The deviation is by derivatives; the number is not linear in the parameters, and draws are right
    then too.
    """


@dataclass(frozen=True)
class MonteCarlo:
    """Ships drawn from the uncertainty that the record leaves (8.5)."""

    draws: int
    paired: float  # [-] share whose T1 and T2 are a complex pair


@dataclass(frozen=True)
class Derivative:
    """A derivative in the study's system, and in the other if mass is known."""

    name: str
    prime: float | None
    bis: float | None
    deviation: float | None  # in the study's system


@dataclass(frozen=True)
class Direction:
    """An eigenvalue of the scaled second derivatives, and the parameters of its direction."""

    eigenvalue: float
    parts: dict[str, float]  # [-] of the unit vector, those above a tenth of the largest


@dataclass(frozen=True)
class Outlier:
    """A sample that was rejected."""

    run: int  # from 1 on
    row: int
    t_s: float


@dataclass(frozen=True)
class RunNumbers:
    """How well the model follows one of several runs."""

    source: str
    speed_kn: float | None
    samples: int
    rms: tuple[float, ...]  # of each output's error one step ahead
    alone: tuple[float, ...]  # by the inputs alone
    explained: tuple[float, ...]  # [-] of the output's variance, by the inputs alone


@dataclass(frozen=True)
class IdentifyReport:
    """All that ``trainer identify`` says about a model."""

    study: str
    source: str
    model: str
    settings: dict[str, Any]
    length_m: float | None
    speed_kn: float | None
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    samples: int
    interval_s: float
    between_readings: str  # one of fit_options.INPUT_PATHS, of the inputs
    findings: tuple[str, ...]
    converged: bool
    doubt: str  # why it did not settle
    steps: int
    log_likelihood: float
    aic: float
    loss_1: float  # V1 of the one-step errors
    loss_1_alone: float  # V1 of the model by rudder alone
    simulated: bool  # nothing was estimated
    screened: tuple[Outlier, ...]
    parameters: tuple[FitNumber, ...]
    ship: tuple[ShipNumber, ...]
    monte_carlo: MonteCarlo
    derivatives: tuple[Derivative, ...]
    stability: str
    eigenvalue: float  # smallest of the scaled information
    weakest: tuple[str, ...]  # parameters of that direction
    eigenvalues: tuple[Direction, ...]  # all, smallest first
    collapsed: tuple[str, ...]  # errors of readings that went to their floor
    residuals: tuple[Residuals, ...]
    verdicts: tuple[str, ...]
    rivals: tuple[RivalModel, ...] = ()
    check: ValidationCheck | None = None
    bend: BendEstimate | None = None
    terms: tuple[TermSize, ...] = ()
    runs: tuple[RunNumbers, ...] = ()
    matrices: tuple[Matrices, ...] = ()


@dataclass(frozen=True, eq=False)
class Identification:
    """A study carried out: the fit, its results, and the ships that the record allows.

    Pages, ``--csv`` and ``trainer.identify.fit`` all take it. ``run`` is the predictor's run over
    the record and ``terms`` the terms of the equations by sample. ``turned`` is the record or the
    turns from which kappa or H(r) was found.
    """

    fitted: ModelFit
    report: IdentifyReport
    others: AllowedShips
    run: PredictionRun
    terms: Series
    turned: Record | None = None


def carry_out(
    study: Study, options: IdentifyOptions, heard: Callable[[int, float], None]
) -> Identification:
    """Return the fit of a study and its report; ConfigError if it cannot be fitted."""
    curves = {"kappa": options.kappa, "bech": options.bech, "spiral": options.spiral}
    bends = [(kind, path) for kind, path in curves.items() if path is not None]
    if len(bends) > 1:
        (first, _), (second, _), *_ = bends
        raise ConfigError(f"--{first} and --{second}: one curve of steady turns, not two")
    if options.joint and [kind for kind, _ in bends] not in (["kappa"], ["bech"]):
        raise ConfigError("--joint goes with --kappa or --bech and its record")
    records = [observe_record(one) for one in studies_of(study)]
    try:
        if options.simulate:
            fitted = simulate_study(study, records[0], records[1:])
        else:
            fitted = fit_study(
                study,
                records[0],
                lambda one: heard(one.steps, one.cost),
                options.checkpoint,
                records[1:],
            )
    except ConfigError as error:  # what is odd about the record may be why
        raise ConfigError(*error.problems, *_findings_by_file(records)) from None
    result = describe_fit(fitted)
    rivals = [compare_without(fitted, options.without)] if options.without else []
    if options.against is not None:
        rivals.append(compare_models(fitted, options.against))
    more: dict[str, Any] = {"rivals": tuple(rivals)}
    if options.check is not None:
        more["check"] = check_of(fitted, options.check)
    if options.matrices:
        more["matrices"] = matrices_of(fitted)
    for kind, path in bends:  # one at most
        more["bend"], turned = bend_of(fitted, path, kind, joint=options.joint)
        terms = result.terms | bent_terms(more["bend"], turned)
        more["terms"], result = sizes_of(terms), replace(result, terms=terms, turned=turned)
    return replace(result, report=replace(result.report, **more))


def _findings_by_file(records: Sequence[Record]) -> list[str]:
    """Return what was found in records, each after its file."""
    return [
        f"{one.source}: {str(finding).removeprefix(f'{Path(one.source).name}: ')}"
        for one in records
        for finding in one.findings
    ]


def describe_fit(fitted: ModelFit) -> Identification:
    """Return a fit with its report, and the ships that the record allows beside it."""
    others, run = draw_allowed(fitted), errors_of(fitted)
    terms = terms_of(fitted, run.states)
    problem, study, plant = fitted.problem, fitted.study, fitted.problem.plant
    records = (fitted.record, *fitted.others)
    residuals, system = _residuals(fitted, run), plant.model.system
    samples, weakest = problem.samples, np.abs(fitted.known.directions[:, 0])
    findings = _findings_by_file(records) if fitted.others else map(str, fitted.record.findings)
    report = IdentifyReport(
        study=study.heading.name,
        source=fitted.record.source,
        model=plant.model.name,
        settings={name: getattr(table_of(study), name) for name in SETTING_NAMES},
        length_m=None if system else plant.ship.length,
        speed_kn=None if system else plant.ship.speed / KNOT,
        inputs=system.inputs if system else ("rudder",),
        outputs=plant.outputs,
        units=tuple(map(plant.model.unit, plant.outputs)),
        samples=problem.counted,
        interval_s=plant.period,
        between_readings=samples.between_readings,
        findings=tuple(findings),
        converged=bool(fitted.found.converged),
        doubt=fitted.found.doubt,
        steps=fitted.found.steps,
        log_likelihood=fitted.log_likelihood,
        aic=aic_of_likelihood(fitted.log_likelihood, len(problem.names)),
        loss_1=loss_1(run.errors[run.counted]),
        loss_1_alone=loss_1(samples.outputs - predict_alone(problem, fitted.found.theta)),
        simulated=fitted.simulated,
        screened=tuple(
            Outlier(number + 1, records[number].row(index), float(records[number].t[index]))
            for number, index in fitted.rejected
        ),
        parameters=_parameters(fitted),
        ship=_ship(fitted, others),
        monte_carlo=MonteCarlo(len(others.draws), others.paired),
        derivatives=_derivatives(fitted),
        stability=_stability(fitted),
        eigenvalue=float(fitted.known.eigenvalues[0]),
        weakest=tuple(
            name
            for name, part in zip(fitted.known.names, weakest, strict=True)
            if part > 0.3 * weakest.max()
        ),
        eigenvalues=_directions(fitted),
        collapsed=problem.collapsed(fitted.found.theta),
        terms=sizes_of(terms),
        runs=_runs(fitted) if fitted.others else (),
        residuals=residuals,
        verdicts=(
            *_doubts(fitted, others),
            *(text for one in residuals for text in describe_tests(one)),
        ),
    )
    return Identification(fitted, report, others, run, terms)


def _runs(fitted: ModelFit) -> tuple[RunNumbers, ...]:
    """Return how well the model follows each of several runs."""
    runs = []
    for number, (problem, at) in enumerate(fitted.problem.runs):
        samples, plant = problem.samples, problem.plant
        residuals = samples.outputs - predict_alone(problem, fitted.found.theta[at])
        errors, spread = errors_of(fitted, number).errors, np.nanstd(samples.outputs, axis=0)
        rms = [np.sqrt(np.nanmean(one**2, axis=0)) for one in (errors, residuals)]
        explained = 1.0 - (rms[1] / np.maximum(spread, 1e-300)) ** 2
        numbers = (tuple(map(float, one)) for one in (*rms, explained))
        speed = None if plant.model.system else plant.ship.speed / KNOT
        record = (fitted.record, *fitted.others)[number]
        runs.append(RunNumbers(record.source, speed, samples.counted, *numbers))
    return tuple(runs)


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _parameters(fitted: ModelFit) -> tuple[FitNumber, ...]:
    """Return the estimated parameters, unscaled."""
    problem, theta, known = fitted.problem, fitted.found.theta, fitted.known.deviations
    every = np.column_stack([theta, known, intervals(problem, theta, known)])
    rows = zip(problem.estimated, problem.names, every * problem.scale[:, None], strict=True)
    parameters = problem.plant.model.parameters
    return tuple(
        FitNumber(name, parameters[index].unit, float(value), *map(_finite, rest))
        for (_, index), name, (value, *rest) in rows
    )


def _ship(fitted: ModelFit, others: AllowedShips) -> tuple[ShipNumber, ...]:
    """Return gains and time constants that the model has, SI."""
    names, spread = fitted.quantity_names, fitted.quantity_spread
    rows = zip(names, spread.values, spread.deviations, *others.spans, strict=True)
    units = quantity_units(fitted.problem.plant.model)
    return tuple(
        ShipNumber(name, units[name], float(x), *map(_finite, (s, low, high)))
        for name, x, s, low, high in rows
        if name not in DERIVATIVE_NAMES and x != 0.0 and math.isfinite(x)
    )


def _derivatives(fitted: ModelFit) -> tuple[Derivative, ...]:
    """Return the derivatives of Model 1 in both systems, theta'' = theta'/m' (3.6)."""
    table, ship, mass = fitted.study.model, fitted.study.ship, None
    bis = table is not None and table.system == "bis"
    if ship is not None and ship.displacement_m3 is not None:  # m' = 2 volume/L^3 [-]
        mass = 2.0 * ship.displacement_m3 / ship.length_m**3
    elif ship is not None and ship.vessel is not None:
        file = load_vessel(ship.vessel)
        mass = 2.0 * file.hull.mass / (file.fluid.rho * ship.length_m**3)
    spread = fitted.quantity_spread
    rows = zip(fitted.quantity_names, spread.values, spread.deviations, strict=True)
    derivatives = []
    for name, value, deviation in rows:
        if name not in DERIVATIVE_NAMES:
            continue
        own_value = float(value)
        other = None if mass is None else own_value * mass if bis else own_value / mass
        prime, both = (other, own_value) if bis else (own_value, other)
        derivatives.append(Derivative(name, prime, both, _finite(deviation)))
    return tuple(derivatives)


def _doubts(fitted: ModelFit, others: AllowedShips) -> list[str]:
    """Return warnings: results that must not be trusted as they stand."""
    doubts = []
    if isinstance(fitted.cost, MultiStep):
        doubts.append(
            "no standard deviations: errors of predictions over several steps are not independent, "
            "and what they promise would be too small; predict_from = predict_to = 1 has them"
        )
    if others.paired > MIN_COMPLEX_SHARE:
        doubts.append(
            f"T1 and T2: {others.paired:.0%} of the ships that this record allows have a complex "
            "pair; they cannot be told apart: trust T1 + T2, T1 T2, and the intervals"
        )
    doubts += [
        f"{name}: the error went to its floor; another reading or the initial state stands for "
        "this one: drop one of them, or fix it"
        for name in fitted.problem.collapsed(fitted.found.theta)
    ]
    return doubts


def _stability(fitted: ModelFit) -> str:
    """Return in words whether the ship keeps a straight course, and how surely."""
    index, spread = fitted.quantity_names.index("1/T1"), fitted.quantity_spread
    value, deviation = float(spread.values[index]), float(spread.deviations[index])
    word = "stable" if value > 0.0 else "unstable"
    if not math.isfinite(deviation) or deviation == 0.0:
        return f"{word}: 1/T1 = {value:.4g} 1/s"
    sure = abs(value) / deviation
    doubt = "" if sure > 2.0 else ", which this record does not settle"
    return f"{word}: 1/T1 = {value:.4g} +- {deviation:.2g} 1/s, {sure:.1f} deviations from 0{doubt}"


def _directions(fitted: ModelFit) -> tuple[Direction, ...]:
    """Return the eigenvalues of the scaled second derivatives, with each direction's parameters."""
    known = fitted.known
    directions = []
    for value, direction in zip(known.eigenvalues, known.directions.T, strict=True):
        least = 0.1 * np.max(np.abs(direction))
        named = zip(known.names, map(float, direction), strict=True)
        parts = {name: part for name, part in named if abs(part) >= least}
        directions.append(Direction(float(value), parts))
    return tuple(directions)


def _residuals(fitted: ModelFit, run: PredictionRun) -> tuple[Residuals, ...]:
    """Return the examination of each output's residuals, if there are enough.

    Those of several runs follow each other, with a gap as long as the lags, so that no pair has
    samples of two runs.
    """
    standard, acting = [run.standardised], [_first_input(fitted.problem)]
    for number, (problem, _) in list(enumerate(fitted.problem.runs))[1:]:
        standard += [np.full((SHOWN_LAGS, run.errors.shape[1]), np.nan)]
        standard += [errors_of(fitted, number).standardised]
        acting += [np.full(SHOWN_LAGS, acting[0].mean()), _first_input(problem)]
    whole, rudder = np.concatenate(standard), np.concatenate(acting)
    lags = min(SHOWN_LAGS, (int((~np.isnan(whole)).all(axis=1).sum()) - 2) // 2)
    if lags < 1:
        return ()
    return tuple(
        examine_residuals(name, whole[:, i], rudder, lags)
        for i, name in enumerate(fitted.problem.plant.outputs)
        if np.count_nonzero(~np.isnan(whole[:, i])) >= 2 * lags + 2
    )


def _first_input(problem: Problem) -> Numbers:
    """Return the first input (n,), or zeros if there is none."""
    inputs = problem.samples.inputs
    return inputs[:, 0] if inputs.shape[1] else np.zeros(len(inputs))

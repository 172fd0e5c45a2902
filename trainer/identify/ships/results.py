"""The report of a fitted ship: what records determine, and what the prior does.

``cli/workshop/ships`` calls ``read_trials`` and ``fit_trials`` for a ship that is not linear;
``fit`` searches, and ``page`` prints what is found here. The prior is what books say of such a
ship: a user must see which numbers are the record's own and which are the books'.
"""

# long: one report, part by part
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import compress
from pathlib import Path
from typing import Final

import numpy as np

from trainer.boat.ship.models import AXIS_LETTERS, FIXED_VALUES, NONLINEAR_NAMES, model_for
from trainer.config.files import ConfigError, offer_known
from trainer.config.ship.ship import FitResult, ShipFile, load_ship
from trainer.core.kernel import Numbers
from trainer.identify.fitting.estimate import by_scoring
from trainer.identify.fitting.minimise import approach_minimum
from trainer.identify.judge.residuals import DEFAULT_LAGS, correlation, portmanteau, ratio_test
from trainer.identify.options import IdentifyOptions
from trainer.identify.record.measurements import Record
from trainer.identify.ships.fit import (
    USUAL_SEARCH,
    ShipFit,
    describe_roll,
    fit_ship,
    pose_problem,
    smooth_trial,
    terms_of,
)
from trainer.identify.ships.likelihood import ShipProblem, prior_of
from trainer.identify.ships.records import (
    inputs_of,
    load_trial,
    notes_of,
    readings_of,
    turned_ranges,
    with_path,
)
from trainer.units import KNOT

INTERVAL_DEVIATIONS: Final = 1.96  # [standard deviations] of a 95 % interval
BOOK_PRIOR_SHARE: Final = 0.9  # [-] share of the prior above which a coefficient is the book's
FAINT_EIGENVALUE: Final = 1e-3  # [-] of the records' scaled information: below it tells nothing
MIN_NAMED_PART: Final = 0.3  # [-] of a unit vector: what is smaller is not named
MAX_DIRECTIONS: Final = 6  # combinations shown at most
SUSPECT_PROBABILITY: Final = 0.01  # [-] of a test of innovations: below it they are not white
OUTPUT_NAMES: Final = ("surge", "sway", "yaw rate", "heading", "roll rate", "roll")
OUTPUT_UNITS: Final = ("m/s", "m/s", "deg/s", "deg", "deg/s", "deg")
OUTPUT_SCALES: Final = np.array([1.0, 1.0, *[180.0 / math.pi] * 4])
TURNING_CAUSES: Final = ("v'", "r'", "rudder")
MIN_PATTERN_SHARE: Final = 0.2  # [-] of residual accelerations, from which a pattern is told
# [-] of a record's yaw acceleration that common coefficients leave beyond its own: the first is
# told, the second refused as another ship. Mirrored trials of one ship leave 0.015.
DOUBTED_SHARE: Final = 0.05
OTHER_SHIP_SHARE: Final = 0.3


@dataclass(frozen=True)
class FittedCoefficient:
    """One coefficient or noise, its interval, and the prior's share of its precision."""

    name: str
    value: float
    deviation: float
    low: float
    high: float
    prior_share: float


@dataclass(frozen=True)
class UnknownDirection:
    """A combination that records do not determine: parts of a scaled unit vector."""

    eigenvalue: float
    parts: dict[str, float]


@dataclass(frozen=True)
class Whiteness:
    """The innovations of one reading: a portmanteau test, and a factor for the intervals.

    Intervals are too narrow by this factor where innovations are not white.
    """

    output: str
    deviation: float  # [-] 1 for what the filter expects
    probability: float
    next_one: float  # [-] correlation with the following innovation
    factor: float  # [-] that standard deviations would take


@dataclass(frozen=True)
class Prediction:
    """How well a record is predicted by its inputs alone, from its first readings."""

    source: str
    kind: str  # "fitted", "held back in turn", "held back"
    explained: tuple[float | None, ...]  # [%] of the variance
    rms: tuple[float | None, ...]  # [m/s, m/s, deg/s, deg, deg/s, deg]


@dataclass(frozen=True)
class OrderTest:
    """The model against one with some coefficients at zero."""

    without: tuple[str, ...]
    statistic: float
    freedom: int
    probability: float


@dataclass(frozen=True)
class ShipFitReport:
    """All that ``trainer identify`` says about a ship that is not linear."""

    ship: str
    model: str
    sources: tuple[str, ...]
    samples: tuple[int, ...]
    interval_s: float
    length_m: float
    prior: str
    prior_strength: float
    findings: tuple[str, ...]
    settled: bool
    doubt: str  # why it did not settle, "" if it did
    steps: int
    promise: float
    cost: float  # -log L with the prior
    other_starts: tuple[float, ...]
    at_floor: tuple[str, ...]  # errors of readings that went to their smallest
    coefficients: tuple[FittedCoefficient, ...]
    noises: tuple[FittedCoefficient, ...]
    from_book: tuple[str, ...]
    untold: tuple[UnknownDirection, ...]
    whiteness: tuple[Whiteness, ...]
    predictions: tuple[Prediction, ...]
    patterns: tuple[str, ...]  # residual accelerations that follow v', r' or the rudder
    ranges: dict[str, tuple[float, float]]
    tests: tuple[OrderTest, ...]
    covariance_names: tuple[str, ...]
    covariance: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, eq=False)
class ShipIdentification:
    """A fitted ship and its report."""

    ship: ShipFile
    fit: ShipFit
    report: ShipFitReport
    held: tuple[Record, ...]


def read_trials(
    files: Sequence[Path], options: IdentifyOptions
) -> tuple[ShipFile, tuple[Record, ...], tuple[Record, ...]]:
    """Return a ship, its records, and those to predict. ConfigError for what cannot be."""
    if options.ship is None:
        raise ConfigError(
            f"--model {options.model} needs --ship FILE, a file of the ship's dimensions: "
            f"trainer identify new {files[0]} --ship ship.toml begins one"
        )
    ship = with_path(load_ship(options.ship), options.between_readings, anyway=options.anyway)
    every = options.every or 1
    trials = tuple(load_trial(path, ship, every) for path in files)
    return ship, trials, tuple(load_trial(path, ship, every) for path in options.predict)


def fit_trials(
    ship: ShipFile,
    trials: tuple[Record, ...],
    held: tuple[Record, ...],
    options: IdentifyOptions,
    heard: Callable[[int, float], None],
) -> ShipIdentification:
    """Return a ship fitted to trials, with what it predicts of those ``held`` back. ConfigError."""
    trials = tuple(_between(trial, options.begin, options.end) for trial in trials)
    model = model_for(
        ship, options.model or "", wind=any(inputs_of(trial)[:, 2:].any() for trial in trials)
    )
    prior, source = prior_of(model, ship)
    strength = options.prior_strength
    problem, begin = pose_problem(model, np.array(ship.constants), trials, prior, strength)
    doubts = tuple(_find_other_ships(problem, begin))
    search = replace(USUAL_SEARCH, progress=lambda one: heard(one.steps, one.cost))
    fitted = fit_ship(problem, begin, search)
    prior_source = source if strength > 0.0 else "none"
    report = _report(ship, fitted, (prior_source, strength), held)
    report = replace(report, findings=(*report.findings, *doubts))
    if options.without:
        report = replace(report, tests=(_test_without(fitted, options.without),))
    return ShipIdentification(_result(ship, fitted, report), fitted, report, held)


def _between(trial: Record, begin: float | None, end: float | None) -> Record:
    """Return the part of a record from ``begin`` to ``end`` [s]."""
    low = -math.inf if begin is None else begin
    high = math.inf if end is None else end
    return trial.between(low, high, DEFAULT_LAGS + 2)


def _find_other_ships(problem: ShipProblem, begin: Numbers) -> Iterator[str]:
    """Yield which record may be of another ship; ConfigError if it surely is.

    The regression leaves yaw accelerations. With common coefficients it leaves more than with
    coefficients of each record, and much more if the ships differ.
    """
    if len(problem.trials) < 2:
        return
    for trial in problem.trials:
        own_problem, start = pose_problem(problem.model, problem.constants, [trial], {}, 0.0)
        _, rates = smooth_trial(trial, problem.constants[0])
        more = _left_in_yaw(problem, begin, trial) - _left_in_yaw(own_problem, start, trial)
        share = more / max(float(np.var(rates[:, 2])), 1e-300)
        message = (
            f"{trial.source}: row 1 on: coefficients in common with the other records leave "
            f"{share:.0%} more of its yaw acceleration than its own: is it of another ship, "
            "loading, sign or unit? Fit ships one by one, each with its own file"
        )
        if share > OTHER_SHIP_SHARE:
            raise ConfigError(message)
        if share > DOUBTED_SHARE:
            yield message


def _left_in_yaw(problem: ShipProblem, a: Numbers, trial: Record) -> float:
    """Return the mean square of the yaw accelerations that coefficients leave."""
    return float(np.mean(residual_accelerations(problem, a, trial)[1][:, 2] ** 2))


def residual_accelerations(
    problem: ShipProblem, a: Numbers, trial: Record
) -> tuple[Numbers, Numbers]:
    """Return smoothed u, v, r (n, 3), and accelerations (n, 3) that the model leaves."""
    states, rates = smooth_trial(trial, problem.constants[0])
    whole = problem.model.whole(problem.coefficients(a))
    terms = terms_of(problem, states, inputs_of(trial), whole[-len(NONLINEAR_NAMES) :])
    made = np.zeros_like(rates)
    for (index, _), factor, term in zip(problem.model.terms, whole, terms.T, strict=False):
        made[:, index % len(AXIS_LETTERS)] += factor * term
    made[:, 2:] /= problem.constants[0]
    return states, rates - made


def explain_variance(y: Numbers, predicted: Numbers) -> tuple[Numbers, Numbers]:
    """Return the share of variance explained [%] and the rms error of each channel."""
    with np.errstate(all="ignore"):
        error = y - predicted
        known = np.isfinite(y).any(axis=0)
        square = np.where(known, np.nanmean(np.where(known, error, 0.0) ** 2, axis=0), math.nan)
        spread = np.where(known, np.nanvar(np.where(known, y, 0.0), axis=0), math.nan)
    share = 100.0 * (1.0 - square / np.maximum(spread, 1e-300))
    rms = np.sqrt(square) * OUTPUT_SCALES[: y.shape[1]]
    return np.full_like(share, math.nan) if np.isnan(predicted).any() else share, rms


def predict_record(problem: ShipProblem, a: Numbers, trial: Record, kind: str) -> Prediction:
    """Return how well inputs alone predict a record; None where there is no number."""
    share, rms = (
        tuple(float(x) if math.isfinite(x) else None for x in values)
        for values in explain_variance(readings_of(trial), problem.sail(a, trial))
    )
    return Prediction(trial.source, kind, share, rms)


def _predictions(fitted: ShipFit, held: tuple[Record, ...]) -> tuple[Prediction, ...]:
    """Return the predictions of all records.

    They are the records that were fitted, the same each held back in turn, and the others.
    """
    problem, trials = fitted.problem, fitted.problem.trials
    predictions = [predict_record(problem, fitted.found.theta, trial, "fitted") for trial in trials]
    if len(trials) > 1:
        for i, trial in enumerate(trials):
            indices = [index for index in range(len(trials)) if index != i]
            rest = replace(problem, trials=tuple(trials[index] for index in indices))
            firsts = [fitted.found.theta[problem.first_indices(index)] for index in indices]
            begin = np.concatenate([fitted.found.theta[: problem.common], *firsts])
            end = approach_minimum(rest, begin, USUAL_SEARCH)  # from the fit with all: it is near
            predictions.append(predict_record(rest, end.theta, trial, "held back in turn"))
    return (
        *predictions,
        *(predict_record(problem, fitted.found.theta, trial, "held back") for trial in held),
    )


def coefficients_of(fitted: ShipFit) -> tuple[FittedCoefficient, ...]:
    """Return the common parameters; noises by their size, not its logarithm."""
    coefficients, problem = [], fitted.problem
    values = np.append(fitted.a[: len(problem.model.free)], np.log(problem.noise(fitted.a)))
    deviations = fitted.deviations * problem.own_share(fitted.a)
    for j, name in enumerate(problem.names):
        value, deviation = float(values[j]), float(deviations[j])
        low, high = value - INTERVAL_DEVIATIONS * deviation, value + INTERVAL_DEVIATIONS * deviation
        if name in problem.model.noises:
            # 700: e^710 is more than a number can be
            value, low, high = (math.exp(min(x, 700.0)) for x in (value, low, high))
            deviation *= value
        share = float(fitted.prior_share[j])
        coefficients.append(FittedCoefficient(name, value, deviation, low, high, share))
    return tuple(coefficients)


def find_unknown(fitted: ShipFit) -> tuple[UnknownDirection, ...]:
    """Return the combinations of coefficients that the records determine least.

    First states are free in them and not shown.
    """
    problem = fitted.problem
    p = len(problem.model.free)
    if not np.isfinite(fitted.information).all():
        return ()
    known = fitted.information
    B, D = known[:p, p:], known[p:, p:]
    width = 1.0 / np.sqrt(np.maximum(np.diag(D), 1e-300))
    scaled = width[:, None] * np.linalg.pinv(D * np.outer(width, width), rcond=1e-12) * width
    H = known[:p, :p] - B @ scaled @ B.T  # the first states being unknown
    unit = 1.0 / np.sqrt(np.maximum(np.diag(H), 1e-300))
    sizes, vectors = np.linalg.eigh(H * np.outer(unit, unit))
    directions = []
    for size, vector in zip(sizes[:MAX_DIRECTIONS], vectors.T, strict=False):
        if size < FAINT_EIGENVALUE:
            turned = vector * np.sign(vector[int(np.argmax(np.abs(vector)))])
            named = zip(problem.model.free, map(float, turned), strict=True)
            parts = {name: x for name, x in named if abs(x) > MIN_NAMED_PART}
            directions.append(UnknownDirection(float(max(size, 0.0)), parts))
    return tuple(directions)


def _whiteness(fitted: ShipFit) -> tuple[Whiteness, ...]:
    """Return the tests of the innovations of all records, those of one after another's."""
    problem = fitted.problem
    rows = [problem.innovations(fitted.found.theta, i) for i in range(len(problem.trials))]
    # a gap as long as the lags, so that no pair has innovations of two records
    gap = np.full((DEFAULT_LAGS, rows[0].shape[1]), math.nan)
    joined = np.vstack([part for each in rows for part in (each, gap)])
    tests = []
    for values, output in zip(joined.T, OUTPUT_NAMES, strict=False):
        count = int(np.count_nonzero(np.isfinite(values)))
        if count < 2 * DEFAULT_LAGS:
            continue
        autocorrelation = correlation(values - np.nanmean(values), DEFAULT_LAGS)
        test = portmanteau(autocorrelation, count, DEFAULT_LAGS)
        # errors that follow one another are worth fewer readings, by the sum of correlations
        longer = (
            1.0 + 2.0 * float(np.sum(autocorrelation[1:]))
            if test.probability < SUSPECT_PROBABILITY
            else 1.0
        )
        deviation = float(np.sqrt(np.nanmean(values**2)))
        factor = max(deviation * math.sqrt(max(longer, 1.0)), 1.0)
        tests.append(
            Whiteness(output, deviation, test.probability, float(autocorrelation[1]), factor)
        )
    return tuple(tests)


def causes_of(trial: Record, states: Numbers, length: float) -> dict[str, Numbers]:
    """Return v', r' and the rudder [rad] of a record with smoothed ``states``, by cause."""
    size = np.hypot(states[:, 0], states[:, 1])
    causes = states[:, 1] / size, states[:, 2] * length / size, inputs_of(trial)[:, 0]
    return dict(zip(TURNING_CAUSES, causes, strict=True))


def _patterns(fitted: ShipFit) -> Iterator[str]:
    """Yield in words where residual accelerations follow v', r' or the rudder."""
    problem, length = fitted.problem, float(fitted.problem.constants[0])
    rows = [residual_accelerations(problem, fitted.found.theta, trial) for trial in problem.trials]
    residuals = np.vstack([one for _, one in rows])
    causes = [
        causes_of(trial, states, length)
        for trial, (states, _) in zip(problem.trials, rows, strict=True)
    ]
    for i, state in enumerate(problem.model.driven):
        for name in TURNING_CAUSES:
            share = _explained_by(np.concatenate([one[name] for one in causes]), residuals[:, i])
            if share > MIN_PATTERN_SHARE:
                yield (
                    f"{OUTPUT_NAMES[state]}: {share:.0%} of the acceleration left over "
                    f"follows {name} "
                    "(a cubic): a term may be missing"
                )


def _explained_by(cause: Numbers, values: Numbers) -> float:
    """Return the share of the variance of values that a cubic of their cause explains [-]."""
    unit = cause / max(float(np.max(np.abs(cause))), 1e-300)
    powers = np.column_stack([unit**n for n in range(4)])
    solution, *_ = np.linalg.lstsq(powers, values, rcond=None)
    return 1.0 - float(np.var(values - powers @ solution) / max(float(np.var(values)), 1e-300))


def _test_without(fitted: ShipFit, names: tuple[str, ...]) -> OrderTest:
    """Return the test of the model against one with coefficients at zero. ConfigError."""
    problem = fitted.problem
    for name in names:
        if name not in problem.model.free:
            known = offer_known(name, problem.model.free)
            raise ConfigError(f"--without {name}: no such coefficient{known}")
        if name in FIXED_VALUES and FIXED_VALUES[name] != 0.0:
            raise ConfigError(
                f"--without {name}: it cannot be nothing; it is {FIXED_VALUES[name]:g} in books"
            )
    kept_indices = np.array([name not in names for name in problem.names])
    small = replace(
        problem,
        model=problem.model.without(names),
        mean=problem.mean[kept_indices],
        width=problem.width[kept_indices],
    )
    firsts = fitted.found.theta[problem.common :]
    begin = np.concatenate([fitted.found.theta[: problem.common][kept_indices], firsts])
    end = by_scoring(small, begin, USUAL_SEARCH)
    # both costs are with the prior, where there is one
    test = ratio_test((-end.cost, small.size), (-fitted.found.cost, problem.size))
    return OrderTest(names, test.statistic, test.freedom, test.probability)


def _report(
    ship: ShipFile, fitted: ShipFit, prior: tuple[str, float], held: tuple[Record, ...]
) -> ShipFitReport:
    """Return the report of a fit."""
    problem, trials = fitted.problem, fitted.problem.trials
    coefficients = coefficients_of(fitted)
    p, common = len(problem.model.free), problem.common
    steps = np.concatenate([np.diff(trial.t) for trial in trials])
    share = problem.own_share(fitted.a)
    covariance = (fitted.covariance * np.outer(share, share))[:common, :common]
    length = float(problem.constants[0])
    held_at = ", ".join(f"{name} {value:.4g}" for name, value in problem.model.held.items())
    return ShipFitReport(
        ship=ship.name,
        model=problem.model.name,
        sources=tuple(trial.source for trial in trials),
        samples=tuple(len(trial.t) for trial in trials),
        interval_s=float(np.median(steps)),
        length_m=length,
        prior=prior[0],
        prior_strength=prior[1],
        findings=(
            *notes_of(trials),
            *([f"held, by the ship's file: {held_at}"] if held_at else []),
            *describe_roll(fitted),
        ),
        settled=fitted.found.converged,
        doubt=fitted.found.doubt,
        steps=fitted.found.steps,
        promise=fitted.promise,
        cost=fitted.found.cost,
        other_starts=fitted.others[1:],
        at_floor=tuple(compress(problem.names, problem.at_least(fitted.a))),
        coefficients=coefficients[:p],
        noises=coefficients[p:],
        from_book=tuple(one.name for one in coefficients[:p] if one.prior_share > BOOK_PRIOR_SHARE),
        untold=find_unknown(fitted),
        whiteness=_whiteness(fitted),
        predictions=_predictions(fitted, held),
        patterns=tuple(_patterns(fitted)),
        ranges=turned_ranges(trials, length),
        tests=(),
        covariance_names=problem.names,
        covariance=tuple(map(tuple, covariance.tolist())),
    )


def _result(ship: ShipFile, fitted: ShipFit, report: ShipFitReport) -> ShipFile:
    """Return the ship's file with the result, which sails."""
    problem = fitted.problem
    whole = map(float, problem.model.whole(problem.coefficients(fitted.a)))
    rows, inputs = (np.vstack([*map(of, problem.trials)]) for of in (readings_of, inputs_of))
    p = len(problem.model.free)
    result = FitResult(
        model=problem.model.name,
        speed_kn=round(float(np.nanmax(rows[:, 0])) / KNOT, 4),
        revolutions_per_s=float(np.median(inputs[:, 1])),
    )
    return replace(
        ship,
        sensors=None,
        result=result,
        coefficients=dict(zip(problem.model.names, whole, strict=True)),
        covariance=tuple(map(tuple, fitted.covariance[:p, :p].tolist())),
        uncertain=problem.model.free,
        ranges=report.ranges,
    )

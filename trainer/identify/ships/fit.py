"""A ship that is not linear, fitted: start, search, standard deviations.

``results.fit_trials`` calls it for ``trainer identify --model mmg`` and its like. The start is a
linear regression of smoothed accelerations; ``fitting`` searches and judges the minimum of the
likelihood with the prior; each equation's disturbance is then widened for the coefficients
fitted in it, because maximum likelihood takes them for known. docs/nonlinear-ships.md has the
figures that the constants and intervals were judged by.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from trainer.boat.ship.forces import ROLL_RATE_INDEX, ROW_COUNT, STIFFNESS_INDEX, set_terms
from trainer.boat.ship.models import AXIS_LETTERS, NONLINEAR_NAMES, ShipModel
from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.fitting.estimate import by_scoring
from trainer.identify.fitting.minimise import SearchOptions, SearchResult, approach_minimum
from trainer.identify.record.measurements import Record
from trainer.identify.ships.likelihood import Prior, ShipProblem, first_state, least_errors
from trainer.identify.ships.records import inputs_of, readings_of

# The start is that of the prototype on MARIN's zig-zags of KVLCC2: by itself, without a likelihood,
# it explains 91.7 to 99.8 % of the yaw rates.
RUDDER_GUESS: Final = np.array([0.4, -0.7, 0.5, 0.4, 0.0])  # gamma, l, kappa, c_w, gamma_a
SMOOTHING_WINDOW: Final = 0.3  # [L/U] of the smoothing polynomial
SMOOTHING_ORDER: Final = 3  # of the polynomials of Savitzky and Golay
RESIDUAL_SHARE: Final = 0.05  # [-] of the acceleration's variance that the regression leaves
START_NOISE_SHARES: Final = (0.03, 0.05)  # [-] of spread: disturbance in ten samples, and error
# [-] of a disturbance's logarithm about its start: a factor of two. Without this prior the
# disturbance of sway went to zero in half of 200 made records, and sway's deviations with it.
LOG_NOISE_WIDTH: Final = 0.7
UNREAD_NOISE_WIDTH: Final = 1.0  # the same of the error of a channel that was not read
MIN_EIGENVALUE: Final = 1e-12  # eigenvalue of the scaled information that counts
USUAL_SEARCH: Final = SearchOptions(200)  # steps, beyond which a search has not settled
OTHER_STARTS: Final = 2  # starts beside the regression: a search that settles knows one hill only


@dataclass(frozen=True, eq=False)
class ShipFit:
    """A fitted ship: parameters, their covariance, and how much of it is the prior's."""

    problem: ShipProblem
    found: SearchResult
    a: Numbers  # with disturbances freed of what fitting took
    covariance: Numbers
    information: Numbers  # of the records alone
    promise: float = 0.0  # by how much a full step would lower the cost
    others: tuple[float, ...] = ()  # -log L where the other starts ended

    @property
    def deviations(self) -> Numbers:
        """Return the standard deviations."""
        return np.sqrt(np.maximum(np.diag(self.covariance), 0.0))

    @property
    def prior_share(self) -> Numbers:
        """Return how much of each common parameter's precision is the prior's."""
        common = self.problem.common
        return np.asarray(np.diag(self.covariance)[:common] / self.problem.width**2)


def pose_problem(
    model: ShipModel, constants: Numbers, trials: Sequence[Record], prior: Prior, strength: float
) -> tuple[ShipProblem, Numbers]:
    """Return the problem of fitting a model to records, and where its search begins."""
    problem = problem_of(model, constants, trials, prior, strength)
    noise, firsts = problem.mean[len(model.free) :], map(first_state, problem.trials)
    return problem, np.concatenate([_regression(problem), noise, *firsts])


def problem_of(
    model: ShipModel, constants: Numbers, trials: Sequence[Record], prior: Prior, strength: float
) -> ShipProblem:
    """Return the problem of fitting a model to records, with what books say."""
    trials = tuple(trials)
    p = len(model.free)
    count, axes = p + len(model.noises), len(model.driven)
    mean, width = np.zeros(count), np.full(count, math.inf)
    for j, name in enumerate(model.free):
        if name in prior and strength > 0.0:
            mean[j], width[j] = prior[name][0], prior[name][1] * strength
    rows = np.vstack([*map(readings_of, trials)])
    seen = np.atleast_1d(np.isfinite(rows).any(axis=0))
    spread = np.array([np.nanstd(rows[:, i]) if seen[i] else 1e-2 for i in range(len(seen))])
    spread = np.maximum(spread, 1e-9)
    step = float(np.median(np.concatenate([np.diff(trial.t) for trial in trials])))
    moving = spread[[*model.driven]]
    if len(seen) > ROLL_RATE_INDEX and not seen[ROLL_RATE_INDEX]:
        moving[-1] = max(np.std(np.concatenate([_roll_rate(trial) for trial in trials])), 1e-9)
    mean[p:] = np.log(
        [
            *(START_NOISE_SHARES[0] * moving / math.sqrt(10.0 * step)),
            *(START_NOISE_SHARES[1] * spread),
        ]
    )
    width[p : p + axes] = LOG_NOISE_WIDTH
    width[p + axes :][~seen] = UNREAD_NOISE_WIDTH
    return ShipProblem(model, constants, trials, mean, width, least_errors(trials))


def _roll_rate(trial: Record) -> Numbers:
    """Return the roll rate [rad/s] of the rolls that were read."""
    return np.asarray(np.gradient(_filled(trial.t, trial.column("roll")), trial.t))


def smooth_trial(trial: Record, length: float) -> tuple[Numbers, Numbers]:
    """Return u, v, r and their derivatives (n, 3) by Savitzky and Golay's cubic.

    With roll the first array has u, v, r, p and phi, the second the derivatives of u, v, r and p:
    that of phi is p itself.
    """
    from scipy.signal import savgol_filter  # noqa: PLC0415

    rows = readings_of(trial)
    channels = rows.shape[1]
    if np.isnan(rows[:, 2]).all():
        rows[:, 2] = np.gradient(_filled(trial.t, rows[:, 3]), trial.t)
    indices = [0, 1, 2]
    if rows.shape[1] > ROLL_RATE_INDEX:
        indices += [ROLL_RATE_INDEX, ROLL_RATE_INDEX + 1]
        if np.isnan(rows[:, ROLL_RATE_INDEX]).all():
            rows[:, ROLL_RATE_INDEX] = _roll_rate(trial)
    rows = np.column_stack([_filled(trial.t, rows[:, i]) for i in indices])
    step = float(np.median(np.diff(trial.t)))
    wanted = SMOOTHING_WINDOW * length / float(np.mean(rows[:, 0])) / step
    window = min(max(2 * int(wanted / 2.0) + 1, SMOOTHING_ORDER + 2), (len(rows) - 1) // 2 * 2 + 1)
    smoothed = savgol_filter(rows, window, SMOOTHING_ORDER, axis=0)
    slopes = savgol_filter(rows, window, SMOOTHING_ORDER, deriv=1, delta=step, axis=0)
    return smoothed, slopes[:, : channels // 2 + 1]


def _filled(t: Numbers, values: Numbers) -> Numbers:
    """Return a channel with its gaps filled linearly."""
    known = np.isfinite(values)
    return np.asarray(np.interp(t, t[known], values[known]))


def tabulate_terms(
    constants: Numbers, states: Numbers, inputs: Numbers, rudder: Numbers
) -> Numbers:
    """Return all rows of the terms' table at each sample (n, rows)."""
    table, out = np.empty((ROW_COUNT, 1)), np.empty((len(states), ROW_COUNT))
    for k, (state, sample_inputs) in enumerate(zip(states, inputs, strict=True)):
        set_terms(table, constants, state, np.ascontiguousarray(sample_inputs), rudder)
        out[k] = table[:, 0]
    return out


def terms_of(problem: ShipProblem, states: Numbers, inputs: Numbers, rudder: Numbers) -> Numbers:
    """Return what multiplies each factor (n, factors); terms of yaw and roll are times L."""
    L, stiffness = problem.constants[0], problem.constants[STIFFNESS_INDEX]
    rows, terms = tabulate_terms(problem.constants, states, inputs, rudder), []
    for index, row in problem.model.terms:
        axis, by = index % len(AXIS_LETTERS), index // len(AXIS_LETTERS)
        term = rows[:, row] * states[:, 2 + by] if by else rows[:, row]
        terms.append(term * L * stiffness ** (0.5 * by) if by and axis == 3 else term)
    return np.column_stack(terms)


def _regression(problem: ShipProblem) -> Numbers:
    """Return the coefficients by least squares of the smoothed accelerations, with the prior.

    The nonlinear coefficients of the rudder are held at RUDDER_GUESS, because the terms are then
    linear in all others.
    """
    length = problem.constants[0]
    rudder = (
        RUDDER_GUESS if "c_w" in problem.model.free else RUDDER_GUESS * (1.0, 1.0, 1.0, 0.0, 1.0)
    )
    smoothed = [smooth_trial(trial, length) for trial in problem.trials]
    terms = np.vstack(
        [
            terms_of(problem, states, inputs_of(trial), rudder)
            for (states, _), trial in zip(smoothed, problem.trials, strict=True)
        ]
    )
    model = problem.model
    scale = (1.0, 1.0, length, length)[: len(model.driven)]
    target = np.vstack([rates for _, rates in smoothed]) * scale
    held = model.whole(dict.fromkeys(model.free, 0.0))
    for j, (index, _) in enumerate(model.terms):
        target[:, index % len(AXIS_LETTERS)] -= held[j] * terms[:, j]
    values = {name: float(x) for name, x in zip(NONLINEAR_NAMES, rudder, strict=True)}
    for axis, letter in enumerate(AXIS_LETTERS[: len(model.driven)]):
        values |= _solve_axis(problem, letter, terms, target[:, axis])
    return np.array([values[name] for name in model.free])


def _solve_axis(
    problem: ShipProblem, letter: str, terms: Numbers, target: Numbers
) -> dict[str, float]:
    """Return the coefficients of one equation."""
    model = problem.model
    names = [name for name in model.free if name[:2] == f"{letter}_"]
    indices = [model.free.index(name) for name in names]
    weight = 1.0 / max(RESIDUAL_SHARE * float(np.var(target)), 1e-30)
    A, known = terms[:, [model.names.index(name) for name in names]], problem.width[indices] ** -2.0
    normal = weight * A.T @ A + np.diag(known)
    right = weight * A.T @ target + known * problem.mean[indices]
    unit = 1.0 / np.sqrt(np.maximum(np.diag(normal), 1e-300))
    solved = unit * np.linalg.lstsq(normal * np.outer(unit, unit), unit * right, rcond=1e-12)[0]
    return dict(zip(names, map(float, solved), strict=True))


def fit_ship(
    problem: ShipProblem, begin: Numbers, search: SearchOptions = USUAL_SEARCH, seed: int = 1
) -> ShipFit:
    """Return the best of searches from the regression and from draws of the prior, judged."""
    stream = np.random.default_rng(seed)
    starts = [begin, *(_draw(problem, begin, stream) for _ in range(OTHER_STARTS))]
    ends = [
        approach_minimum(problem, start, search)
        for start in starts
        if math.isfinite(problem.value(start))
    ]
    if not ends:
        raise ConfigError(
            f"{problem.trials[0].source}: no starting point fits this record: check units and "
            "signs of the columns, and at the dimensions"
        )
    best = min(ends, key=lambda end: end.cost)
    judged = by_scoring(problem, best.theta, search)
    found = replace(judged, steps=best.steps + judged.steps)
    return _with_intervals(problem, found, tuple(end.cost for end in ends))


def _draw(problem: ShipProblem, begin: Numbers, stream: np.random.Generator) -> Numbers:
    """Return another start: coefficients from twice the prior's width, noise up to e^2 off.

    A coefficient without a prior has no width, so it stays as the regression has it.
    """
    a, p = begin.copy(), len(problem.model.free)
    known = np.isfinite(problem.width[:p])
    drawn = problem.mean[:p] + 2.0 * problem.width[:p] * stream.standard_normal(p)
    a[:p][known] = drawn[known]
    a[p : problem.common] += stream.uniform(-2.0, 2.0, problem.common - p)
    return a


def _inverse(H: Numbers) -> Numbers:
    """Return the inverse of an information, whose scales differ by many powers of ten."""
    unit = 1.0 / np.sqrt(np.maximum(np.diag(H), 1e-300))
    sizes, vectors = np.linalg.eigh(H * np.outer(unit, unit))
    scaled = (vectors / np.maximum(sizes, MIN_EIGENVALUE)) @ vectors.T
    return np.asarray(np.outer(unit, unit) * scaled)


def _held_information(problem: ShipProblem, a: Numbers) -> Numbers:
    """Return the information, that of an error of readings at its least taken for one."""
    H, held = problem.information(a).copy(), problem.at_least(a)
    H[held], H[:, held] = 0.0, 0.0
    H[held, held] = 1.0
    return H


def _with_intervals(
    problem: ShipProblem, found: SearchResult, others: tuple[float, ...]
) -> ShipFit:
    """Return the fit with its covariance, at disturbances that are widened first.

    A likelihood with many coefficients makes the disturbances too small, and intervals with them.
    So each equation's disturbance is widened, by the number of coefficients that the record
    determined in it.
    """
    a = found.theta.copy()
    H, g = _held_information(problem, a), problem.slope(a)[1]
    if not (np.isfinite(g).all() and np.isfinite(H).all()):
        empty = np.full((problem.size, problem.size), math.nan)
        return ShipFit(problem, found, a, empty, empty, math.nan, others)
    C, p = _inverse(H), len(problem.model.free)
    share = np.diag(C)[: problem.common] / problem.width**2
    for axis, letters in enumerate(("X", "Y", "Nglkc", "K")[: len(problem.model.driven)]):
        taken = sum(
            1.0 - share[j] for j, name in enumerate(problem.model.free) if name[0] in letters
        )
        index = p + axis
        # the record's precision of log(sigma) is twice the number of errors that it is made from
        freedom = 0.5 * (1.0 / C[index, index] - 1.0 / problem.width[index] ** 2)
        a[index] += 0.5 * math.log1p(max(taken, 0.0) / max(freedom, 1.0))
    return replace(_known_at(problem, a, found), promise=0.5 * float(g @ C @ g), others=others)


def _known_at(problem: ShipProblem, a: Numbers, found: SearchResult) -> ShipFit:
    """Return the fit with the covariance that the information at ``a`` gives.

    The prior's part is taken off the records' information, to tell one from the other.
    """
    H = _held_information(problem, a)
    records_information = H.copy()
    records_information[np.diag_indices(problem.common)] -= problem.width**-2.0
    return ShipFit(problem, found, a, _inverse(H), records_information)


def expect_fit(problem: ShipProblem, a: Numbers) -> ShipFit:
    """Return what fitting is expected to give of a ship whose parameters are known.

    The records must be without errors, because the information is then the expected one.
    """
    return _known_at(problem, a, SearchResult(a, problem.value(a), 0, converged=True))


def describe_roll(fitted: ShipFit) -> Iterator[str]:
    """Yield the period of roll and its damping, if the ship has roll."""
    a, stiffness = fitted.problem.coefficients(fitted.a), fitted.problem.constants[STIFFNESS_INDEX]
    square = -a.get("K_phi", 0.0) * float(stiffness)
    if square > 0.0:
        root = math.sqrt(square)
        share = -a.get("K_p", 0.0) * math.sqrt(stiffness) / (2.0 * root)
        yield f"roll: period {2.0 * math.pi / root:.3g} s, {share:.1%} of critical damping"
    elif stiffness > 0.0:
        yield "roll: K_phi does not right the ship: is gm_m right, is roll positive to starboard?"

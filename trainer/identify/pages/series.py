"""A fit sample by sample: readings, predictions, terms and matrices (MI 13).

``--csv``, ``--matrices`` and the plots show them. They are what the program of the report of 1974
printed by its options NPRI 1 to 3. MI is the model document.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.fitting.likelihood import (
    Innovations,
    PredictionRun,
    no_limits,
    run_filter,
)
from trainer.identify.fitting.nonlinear import BendEstimate, predict_turning
from trainer.identify.fitting.problem import Problem
from trainer.identify.judge.fitted import ModelFit
from trainer.identify.judge.validation import predict_alone
from trainer.identify.model.models import OUTPUT_UNITS
from trainer.identify.record.measurements import Record
from trainer.identify.record.sources import write_columns
from trainer.units import DEGREE

STATE_NAMES: Final = {  # of the models, SI; those of other systems are x1, x2, ...
    "1": ("v", "r", "psi"),
    "2": ("v", "x2", "x3"),
    "3": ("x1", "r", "psi"),
    "nomoto1": ("r", "psi"),
    "nomoto2": ("x1", "r", "psi"),
}
EQUATION_NAMES: Final = {"v": "sway acceleration", "r": "yaw acceleration"}  # and their units in SI
ACCELERATION_UNITS: Final = {"v": "m/s^2", "r": "rad/s^2"}
ACTING_NAMES: Final = {"step": ("0", ""), "straight": ("", "0s", "s")}  # after G and D
LARGE_MANOEUVRE: Final = "large manoeuvre"
FORCE_NAMES: Final = {"v": "sway force", "r": "yaw moment"}  # of Model 1 [-] in the study's system
Series = dict[tuple[str, str, str], Numbers]  # by equation, term and unit


def states_of(problem: Problem) -> tuple[str, ...]:
    """Return the names of the states."""
    model = problem.plant.model
    return STATE_NAMES.get(model.name, tuple(f"x{i + 1}" for i in range(model.states)))


def errors_of(fitted: ModelFit, number: int = 0) -> PredictionRun:
    """Return the one-step errors of a run, by the predictor that was fitted."""
    problem, at = fitted.problem.runs[number]
    cost, theta = fitted.cost, fitted.found.theta[at]
    run = run_filter(problem, theta, no_limits(len(problem.plant.outputs)))
    if not isinstance(cost, Innovations):
        return run
    states, errors = cost.shown(fitted.found.theta, number)
    whole = errors[~np.isnan(errors).any(axis=1)]
    R = whole.T @ whole / len(whole)
    return replace(
        run,
        states=states,
        predictions=problem.samples.outputs - errors,
        errors=errors,
        spreads=np.tile(R, (len(errors), 1, 1)),
        squares=np.einsum("ki,ij,kj->k", errors, np.linalg.inv(R), errors),
    )


@dataclass(frozen=True)
class TermSize:
    """One term of an equation of motion over a record, on the right-hand side."""

    equation: str
    name: str
    unit: str
    rms: float
    largest: float  # by magnitude
    share: float  # [-] of the sum of the equation's rms


def terms_of(fitted: ModelFit, states: Numbers) -> Series:
    """Return the terms of sway and yaw (n,) from the filter's ``states`` (n, x).

    Those of Model 1 are forces and moments in its system, by derivative. Those of other models are
    accelerations, SI.
    """
    problem, model = fitted.problem, fitted.problem.plant.model
    if model.system is not None:
        return {}
    drift = problem.plant.blocks(fitted.values[None]).drift[0]
    names, count = states_of(problem), model.states
    rows = drift[:count].copy()
    if model.name == "1":
        L, V = problem.plant.ship.length, problem.plant.ship.speed
        m11, m12, m21, m22 = fitted.values[:4]
        rows[:2] = np.array([[m11, L * m12], [m21, L * m22]]) * L / V**2 @ rows[:2]
    by = np.column_stack([states, problem.samples.inputs, np.ones(len(states))])
    terms: Series = {}
    for state in (name for name in names if name in EQUATION_NAMES):
        row = names.index(state)
        for j, name in enumerate((*names, "delta", "0")):
            if not rows[row, j]:
                continue
            term = ("bias" if name == "0" else name), ACCELERATION_UNITS[state]
            equation = EQUATION_NAMES[state]
            if model.name == "1":
                side = "Y" if state == "v" else "N"
                term = f"{side}_{name}" + (f" {name}" if name != "0" else ""), "-"
                equation = FORCE_NAMES[state]
            terms[equation, *term] = rows[row, j] * by[:, j]
    return terms


def bent_terms(bend: BendEstimate, record: Record) -> Series:
    """Return the terms of the steady turn (12.3) over a large manoeuvre (n,), deg/s.

    K delta turns the ship, the other terms resist or help. A spiral has no terms, because its turns
    are not samples in time.
    """
    if bend.rate_0 is None:
        return {}
    ship, rudder = bend.ship, record.column("rudder")
    r = predict_turning(ship, record, np.array([bend.rate_0, 0.0]))[:, 0]
    H1, H2, H3 = (-ship.K * x / DEGREE for x in ship.curve)
    parts = {"K delta": ship.K * (rudder - ship.delta_0) / DEGREE}
    if ship.H:
        parts |= {"-K H1 r": H1 * r, "-K H2 |r| r": H2 * np.abs(r) * r, "-K H3 r^3": H3 * r**3}
    else:
        parts |= {"-r": H1 * r, "kappa K |r| r": H2 * np.abs(r) * r}
    return {(LARGE_MANOEUVRE, name, "deg/s"): part for name, part in parts.items()}


def sizes_of(series: Series) -> tuple[TermSize, ...]:
    """Return how large the terms are."""
    rms = {key: float(np.sqrt(np.mean(part**2))) for key, part in series.items()}
    sums = {key: sum(x for other, x in rms.items() if other[0] == key[0]) for key in rms}
    return tuple(
        TermSize(*key, rms[key], float(np.max(np.abs(part))), rms[key] / (sums[key] or 1.0))
        for key, part in series.items()
    )


def series_of(fitted: ModelFit, number: int = 0) -> dict[str, Numbers]:
    """Return the columns of a run, a number for each sample or NaN.

    First time [s] and rudder [deg]. Then of each output: the reading, the model by rudder alone,
    its error, the prediction one step ahead and the residual, in the model's units. Then the
    predicted states, SI, and the terms. Last the reason why a sample does not count, a place in
    REASONS.
    """
    (problem, at), run = fitted.problem.runs[number], errors_of(fitted, number)
    samples, model = problem.samples, predict_alone(problem, fitted.found.theta[at])
    system = problem.plant.model.system
    inputs = zip(system.inputs if system else ("rudder_deg",), samples.inputs.T, strict=True)
    series = {"t_s": samples.t, **dict(inputs)}
    for i, output in enumerate(problem.plant.outputs):
        reading = samples.outputs[:, i]
        columns = {"measured": reading, "model": model[:, i], "error": reading - model[:, i]}
        columns |= {"predicted": run.predictions[:, i], "residual": run.errors[:, i]}
        unit = "" if system else "_" + OUTPUT_UNITS[output][0].replace("/", "_")
        series |= {f"{output}_{name}{unit}": column for name, column in columns.items()}
    names = states_of(problem)
    series |= {f"state_{name}": run.states[:, i] for i, name in enumerate(names)}
    terms = {} if number else terms_of(fitted, run.states)  # of the first run
    for (equation, term, _), part in terms.items():
        series[f"{equation} {term}".replace(" ", "_")] = part
    return series | {"flag": run.flags.astype(float)}


def write_series(fitted: ModelFit, path: Path) -> None:
    """Write the columns of a fit as CSV; ConfigError if it cannot be."""
    runs = [series_of(fitted, number) for number in range(len(fitted.problem.runs))]
    sizes = [len(columns["t_s"]) for columns in runs]
    series = {"run": np.repeat(np.arange(1.0, 1 + len(runs)), sizes)} if fitted.others else {}
    for name in runs[0]:
        parts = zip(runs, sizes, strict=True)
        whole = [columns.get(name, np.full(size, math.nan)) for columns, size in parts]
        series[name] = np.concatenate(whole)
    write_columns(path, series, ".10g")


@dataclass(frozen=True)
class Matrices:
    """The matrices of a fit (MI 4, 6.1): continuous, and sampled at the usual interval.

    Their names are those of the model document. ``b`` and ``d`` belong to the input that is always
    1, ``G0`` to the rudder of the sample before, which acts during the lag. Of a rudder that goes
    straight ``G`` belongs to the rudder at the sample, ``G0s`` and ``Gs`` to its slope before and
    after.
    """

    of: str  # "start values" or "estimate"
    states: tuple[str, ...]
    outputs: tuple[str, ...]
    continuous: dict[str, Any]
    sampled: dict[str, Any]
    initial: dict[str, Any]  # state and its covariance at the first sample
    final: dict[str, Any]  # gain, covariance of errors and of the state at the last


def matrices_of(fitted: ModelFit) -> tuple[Matrices, ...]:
    """Return the matrices at the start values and at the estimate."""
    starts = _matrices(fitted, "start values", fitted.problem.start)
    return starts, _matrices(fitted, "estimate", fitted.found.theta)


def _matrices(fitted: ModelFit, name: str, theta: Numbers) -> Matrices:
    """Return the matrices at a vector of free parameters."""
    problem = fitted.problem
    states, outputs = states_of(problem), problem.plant.outputs
    n, blocks = len(states), problem.plant.blocks(problem.whole(theta)[None])
    system, noise = blocks.drift[0], blocks.noise[0]
    inputs = system.shape[1] - n - 1
    continuous = _parts(system, n, {"A": n, "B": inputs, "b": 1}, {"C": n, "D": inputs, "d": 1})
    mean, spread, start = problem.sampled(theta).at(0)
    steps, which = problem.samples.steps
    usual = int(np.bincount(which).argmax())  # of several intervals the most frequent one
    acts = ACTING_NAMES[problem.samples.between_readings]
    heads = ({f"{side}{name}": inputs for name in acts} for side in "GD")
    above, below = heads
    sampled = _parts(mean[usual], n, {"Phi": n, **above, "g": 1}, {"C": n, **below, "d": 1})
    # "" is R12', which is not shown again; -1 is all the rest
    sampled |= _parts(spread[usual], n, {"R1": n, "R12": len(outputs)}, {"": n, "R2": -1})
    return Matrices(
        of=name,
        states=states,
        outputs=outputs,
        continuous={
            **continuous,
            "R1": noise[:n, :n].tolist(),
            "R2": noise[n:, n:].tolist(),
            "lag_s": float(blocks.lag[0]),
        },
        sampled={"interval_s": float(steps[usual]), **sampled},
        initial={"x": start[:, 0].tolist(), "P": start[:, 1:].tolist()},
        final=_final(fitted, theta),
    )


def _parts(
    matrix: Numbers, split: int, above: dict[str, int], below: dict[str, int]
) -> dict[str, Any]:
    """Return named parts of a matrix, by their widths, above the row ``split`` and below it."""
    parts = {}
    for rows, widths in ((matrix[:split], above), (matrix[split:], below)):
        at = 0
        for name, width in widths.items():
            end = rows.shape[1] if width < 0 else at + width
            if name:
                parts[name] = rows[:, at:end].tolist()
            at = end
    return parts


def _final(fitted: ModelFit, theta: Numbers) -> dict[str, Any]:
    """Return gain K, covariance R of the errors and P of the state after the last reading."""
    cost, problem = fitted.cost, fitted.problem
    if isinstance(cost, Innovations):
        gains = cost.gains(problem, problem.sampled(theta).as_complex())
        return {} if gains is None else {"K": gains[0].real.tolist()}
    mean, noise, start = problem.sampled(theta).at(0)
    run = run_filter(problem, theta, no_limits(len(problem.plant.outputs)))
    which = problem.samples.steps[1][-1]
    n, W = len(start), mean[which][:, : len(start)]
    J = W @ run.covariances[-1] @ W.T + noise[which]
    present = n + np.flatnonzero(~np.isnan(problem.samples.outputs[-1]))
    K = np.zeros((n, len(J) - n))
    K[:, present - n] = np.linalg.solve(J[np.ix_(present, present)], J[present, :n]).T
    P = J[:n, :n] - K @ J[n:, :n]
    return {"K": K.tolist(), "R": run.spreads[-1].tolist(), "P": P.tolist()}

"""Monte-Carlo studies of identification: simulate, estimate, count how often truth is inside.

``trainer boat sweep`` runs them for a study file with a table [identification]. Each member is one
simulated record of a known ship; the estimates of all members show whether the stated 95 %
intervals hold the truth in 95 % of the cases.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Final

import numpy as np

from trainer.analysis.sweep.job import COVERED_COLUMN, DEVIATION_COLUMN, Batch, Output, fly_each
from trainer.analysis.sweep.records import PARAMETER_ROWS, IdentificationTable, SweptParameter
from trainer.analysis.sweep.study import Study
from trainer.config.files import ConfigError, Position, nearest, offer_known, quote, raise_problems
from trainer.config.schema import read_record
from trainer.core.kernel import Numbers
from trainer.identify.experiment import hold_bits, prbs
from trainer.identify.fitting.estimate import find_best_minimum
from trainer.identify.fitting.likelihood import Likelihood
from trainer.identify.fitting.minimise import SearchOptions
from trainer.identify.fitting.problem import Problem, problem_of
from trainer.identify.judge.uncertainty import intervals, uncertainty
from trainer.identify.judge.validation import draw_outputs
from trainer.identify.model.models import MODELS, Plant, Ship
from trainer.identify.record.measurements import Samples
from trainer.units import KNOT

CHUNK_RUNS: Final = 25  # runs made by a process before they are kept
CONVERGED_OUTPUT, GAIN_OUTPUT = "converged", "likelihood gained"


@dataclass(frozen=True)
class SimulatedRun:
    """One simulated record and what was found from it."""

    seed: int
    theta: Numbers  # (f,)
    deviations: Numbers  # (f,) NaN where the information was singular
    intervals: Numbers  # (f, 2) of 95 %
    cost: float
    cost_at_truth: float
    converged: bool


@dataclass(frozen=True)
class KnownShip:
    """A ship, its instruments, its true values, and an analyst's start.

    A trial is rehearsed with it before anybody sails. ``begin`` has the free parameters that do not
    start at the truth.
    """

    kind: str
    ship: Ship
    outputs: tuple[str, ...]
    period: float  # [s]
    truth: Mapping[str, float]
    free: tuple[str, ...]
    begin: Mapping[str, float]

    def problem(self, rudder: Numbers, missing: float = 0.0) -> Problem:
        """Return the problem at its truth, ``rudder`` (n,) [deg]; a share of readings missing."""
        count = len(rudder)
        outputs = np.zeros((count, len(self.outputs)))
        outputs[np.random.default_rng(5).random(outputs.shape) < missing] = np.nan
        t = np.arange(count, dtype=float) * self.period
        samples = Samples(t, outputs, rudder[:, None])
        model = MODELS[self.kind]
        plant = Plant(model, self.ship, self.outputs, self.period)
        return problem_of(plant, samples, model.vector(**self.truth), self.free)

    def start(self) -> Numbers:
        """Return where the free parameters start (f,)."""
        model = MODELS[self.kind]
        return model.vector(**{**self.truth, **self.begin})[list(model.indices(self.free))]

    def freed(self, *names: str, **truth: float) -> "KnownShip":
        """Return the rehearsal with more free parameters, at values ``truth``."""
        return replace(self, free=(*self.free, *names), truth={**self.truth, **truth})


def one_run(problem: Problem, truth: Numbers, seed: int) -> SimulatedRun:
    """Return what is found from the record of ``seed``, estimated from the problem's values."""
    stream = np.random.Generator(np.random.PCG64(seed))
    cost = Likelihood(problem.on(draw_outputs(problem, truth, stream)))
    minimum = find_best_minimum(cost, problem.start, "scoring", SearchOptions())
    known = uncertainty(problem.names, cost.information(minimum.theta))
    return SimulatedRun(
        seed,
        minimum.theta,
        known.deviations,
        intervals(problem, minimum.theta, known.deviations),
        minimum.cost,
        cost.value(truth),
        converged=minimum.converged,
    )


def rehearsal_of(study: Study, drawn: Mapping[str, Any]) -> tuple[KnownShip, IdentificationTable]:
    """Return ship, experiment and start of the search; ConfigError if the model has none."""
    tables = study.varied(drawn)
    position = Position(study.path.name, "identification")
    table = read_record(IdentificationTable, tables["identification"], position, ("note",))
    rows = PARAMETER_ROWS.read("parameters", tables["parameters"], Position(study.path.name, ""))
    _check(rows, table, study.path.name)
    logs = table.bow_log_m or 0.0, table.stern_log_m or 0.0
    ship = Ship(table.length_m, table.speed_kn * KNOT, *logs)
    free = tuple(row.name for row in rows if row.free is not False)
    truth = {row.name: row.truth for row in rows}
    begin = {row.name: row.start for row in rows if row.start is not None}
    rehearsal = KnownShip(table.model, ship, table.outputs, table.interval_s, truth, free, begin)
    return rehearsal, table


def _check(rows: tuple[SweptParameter, ...], table: IdentificationTable, file: str) -> None:
    """Check names against the model; ConfigError with all faults."""
    model, problems = MODELS[table.model], []
    names = [row.name for row in rows]
    for i, name in enumerate(names):
        position = Position(file, f"parameters[{i}]")
        if name not in (*model.names, *model.given):
            text = f"model {table.model} has no such parameter{nearest(name, model.names)}"
            problems.append(position.wrong("name", name, text))
        if name in names[:i]:
            problems.append(position.wrong("name", name, "is given twice"))
    for channel in table.outputs:
        if channel not in model.outputs:
            text = f"model {table.model} has {', '.join(model.outputs)}"
            problems.append(Position(file, "identification").wrong("outputs", channel, text))
    if all(row.free is False for row in rows):
        problems.append(Position(file, "").problem("[[parameters]] has none that is free"))
    raise_problems(problems)


def pose_experiment(rehearsal: KnownShip, table: IdentificationTable) -> tuple[Problem, Numbers]:
    """Return the problem at its search's start, and the true values (f,) of free parameters."""
    bit = max(1, round(table.bit_s / table.interval_s))
    sequence = hold_bits(prbs(table.register_bits), table.amplitude_deg, bit)
    problem = rehearsal.problem(np.resize(sequence, table.samples))
    return replace(problem, values=problem.whole(rehearsal.start())), problem.start


class IdentificationSubject:
    """What a sweep varies here: each member is one simulated experiment."""

    chunk = CHUNK_RUNS

    def __init__(self, study: Study) -> None:
        """Take the study; ConfigError if its middle member is no experiment."""
        self.study = study
        self.middle = pose_experiment(*rehearsal_of(study, study.draws.middle()))

    @cached_property
    def outputs(self) -> tuple[Output, ...]:
        """Return the names of what is kept: estimates, deviations and whether they cover the truth.

        ConfigError if the study asks for an output that does not exist.
        """
        model = self.middle[0].plant.model
        units = {one.name: one.unit for one in model.parameters}
        offered = []
        for name in self.middle[0].names:
            offered += [
                Output(name, units[name]),
                Output(DEVIATION_COLUMN.format(name), units[name]),
            ]
            offered.append(Output(COVERED_COLUMN.format(name), "-"))
        every = (*offered, Output(CONVERGED_OUTPUT, "-"), Output(GAIN_OUTPUT, "-"))
        measures, known = self.study.heading.measures, {one.name: one for one in every}
        for name in measures or ():
            if name not in known:
                text = f"no measure {quote(name)}{offer_known(name, known)}"
                raise ConfigError(f"{self.study.path.name}: {text}")
        return every if measures is None else tuple(known[name] for name in measures)

    def batch(self, first: int, count: int) -> Batch:
        """Return the results of ``count`` members from ``first`` on."""
        return fly_each(self.study.draws, first, count, len(self.outputs), self._numbers)

    def _numbers(self, drawn: Mapping[str, Any], seed: int) -> list[float]:
        """Return the outputs of one experiment; ConfigError if it cannot be made."""
        same = not self.study.variables
        problem, truth = self.middle if same else pose_experiment(*rehearsal_of(self.study, drawn))
        run = one_run(problem, truth, seed)
        numbers = {
            CONVERGED_OUTPUT: float(run.converged),
            GAIN_OUTPUT: run.cost_at_truth - run.cost,
        }
        parameters = zip(
            problem.names, truth, run.theta, run.deviations, run.intervals, strict=True
        )
        for name, true, value, deviation, (low, high) in parameters:
            numbers[name], numbers[DEVIATION_COLUMN.format(name)] = float(value), float(deviation)
            numbers[COVERED_COLUMN.format(name)] = float(low <= true <= high)
        return [numbers.get(output.name, math.nan) for output in self.outputs]

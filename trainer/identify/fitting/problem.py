"""The problem of estimation: which parameters of a model are sought, from which samples.

A ``Problem`` joins a plant (model, ship, outputs), samples of one or several runs, and start
values. All costs, minimisers and judges take one. ``theta`` (f,) has the free parameters alone,
each divided by its ``scale``, because a search moves best where all numbers are of one size.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from trainer.core.kernel import Numbers
from trainer.identify.fitting.minimise import Cost
from trainer.identify.kernels.kernel import Entries
from trainer.identify.model.models import Plant
from trainer.identify.model.sampled import SampledSystems, sample_systems, step_aside
from trainer.identify.record.measurements import Samples

ROUNDING_SHARE: Final = 1e-14  # [-] of the largest eigenvalue: one below it is zero
MIN_VARIANCE_SHARE: Final = 1e-4  # [-] of its start, below which no error's variance is estimated


@dataclass(frozen=True, eq=False)
class FurtherRun:
    """Another record of the same ship: at which speed, and where its own parameters start."""

    plant: Plant
    samples: Samples
    values: Numbers  # (n,)


@dataclass(frozen=True, eq=False)
class Problem:
    """Estimate the parameters at the indices ``free``; the others stay as in ``values``.

    ``scale`` (f,): a parameter is its scale times the number that a minimiser moves. ``sampling``
    is that of sampled.sample_systems. ``first`` (x,), if given, is the initial state, whatever the
    parameters say.

    ``others`` are further runs of the same ship. The parameters at the indices ``own`` (initial
    states, steady forces) differ from run to run, all others are common. A vector of free
    parameters has those of the first run (f,), then the ``own`` ones of each further run.
    """

    plant: Plant
    samples: Samples
    values: Numbers  # (n,)
    free: tuple[int, ...]
    scale: Numbers  # (f,)
    sampling: str = "instantaneous"
    first: Numbers | None = None
    others: tuple[FurtherRun, ...] = ()
    own: tuple[int, ...] = ()

    @cached_property
    def estimated(self) -> tuple[tuple[int, int], ...]:
        """Return run (from 0) and index of each number that is estimated."""
        further = ((i, index) for i in range(1, 1 + len(self.others)) for index in self.own)
        return (*((0, index) for index in self.free), *further)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Return the names of what is estimated."""
        names = self.plant.model.names
        return tuple(
            names[index] + (f" of run {run + 1}" if run else "") for run, index in self.estimated
        )

    @cached_property
    def kinds(self) -> tuple[str, ...]:
        """Return how each of them is bounded."""
        parameters = self.plant.model.parameters
        return tuple(parameters[index].kind for _, index in self.estimated)

    @property
    def start(self) -> Numbers:
        """Return what is estimated as it stands in ``values``, scaled."""
        values = [self.values, *(run.values for run in self.others)]
        return np.array([values[run][index] for run, index in self.estimated]) / self.scale

    @cached_property
    def runs(self) -> tuple[tuple["Problem", NDArray[np.int64]], ...]:
        """Return the problem of each run alone, and the indices of its numbers among all."""
        count, size = len(self.free), len(self.own)
        problems = []
        for i, run in enumerate((FurtherRun(self.plant, self.samples, self.values), *self.others)):
            at = np.arange(count)
            if i:
                at[[self.free.index(index) for index in self.own]] = (
                    count + (i - 1) * size + np.arange(size)
                )
            values = self.values.copy()
            values[list(self.own)] = run.values[list(self.own)]
            alone = replace(
                self,
                plant=run.plant,
                samples=run.samples,
                values=values,
                scale=self.scale[at],
                others=(),
            )
            problems.append((alone, at))
        return tuple(problems)

    @property
    def counted(self) -> int:
        """Return how many samples of all runs have a reading."""
        return sum(run.samples.counted for run, _ in self.runs)

    @cached_property
    def floors(self) -> Numbers:
        """Return the least a search takes each parameter for (f,), zero where there is none.

        The variances of readings' errors have a floor, a share of their start. Without it a search
        could believe one reading exactly, if another one can take its place or its state is free,
        and the likelihood would grow without end.
        """
        errors = np.array([kind == "error" for kind in self.kinds], bool)
        return np.where(errors, MIN_VARIANCE_SHARE * np.abs(self.start), 0.0)

    def collapsed(self, theta: Numbers) -> tuple[str, ...]:
        """Return the names of the errors that are at their floor in ``theta`` (f,)."""
        low = (self.floors > 0.0) & (np.abs(theta) < 2.0 * self.floors)
        return tuple(name for name, is_low in zip(self.names, low, strict=True) if is_low)

    def whole(self, theta: Numbers) -> Numbers:
        """Return all parameters (n,) of the first run, the free ones from ``theta``."""
        values, count = self.values.copy(), len(self.free)
        values[list(self.free)] = (theta * self.scale)[:count]
        return values

    def folded(self, theta: Numbers) -> Numbers:
        """Return ``theta`` (f,) with each number at the first point that means the same model.

        Variances and lags become positive, angles lie between -pi/2 and pi/2.
        """
        values = theta * self.scale
        angles = np.arcsin(np.sin(values))
        kinds = np.array(self.kinds)
        values = np.where(kinds == "angle", angles, values)
        values = np.where(kinds == "lag", np.abs(angles), values)
        return np.where(np.isin(kinds, ("variance", "error")), np.abs(values), values) / self.scale

    def sampled(self, theta: Numbers) -> SampledSystems:
        """Return the sampled systems of ``theta`` (f,): one row."""
        return self._sample(self.whole(theta)[None])

    def sloped(self, theta: Numbers) -> SampledSystems:
        """Return the sampled systems of ``theta`` and, in rows 1 on, their slopes by each."""
        return self._sample(step_aside(self.whole(theta), self.free))

    def _sample(self, rows: Entries) -> SampledSystems:
        blocks = self.plant.blocks(rows)
        if self.first is not None:
            blocks.start[:, :, 0] = self.first
        intervals, between = self.samples.steps[0], self.samples.between_readings
        return sample_systems(blocks, intervals, self.sampling, between)

    def fastest(self, theta: Numbers) -> float:
        """Return the shortest time constant [s] of the model, infinite if nothing moves.

        It is infinite too for discrete matrices, which have no time constant of their own.
        """
        return float(min(self._time_constants(theta), default=math.inf))

    def slowest(self, theta: Numbers) -> float:
        """Return the longest time constant [s] of a ship's model, but for what only sums."""
        known = () if self.plant.model.system is not None else self._time_constants(theta)
        return float(max(known, default=0.0))

    def _time_constants(self, theta: Numbers) -> Numbers:
        """Return the time constants [s] of what does not only sum."""
        states = self.plant.model.states
        drift = self.plant.blocks(self.whole(theta)[None]).drift[0, :states, :states]
        if self.sampling == "discrete":
            return np.empty(0)
        if not np.isfinite(drift).all():
            return np.zeros(1)
        rates = np.abs(np.linalg.eigvals(drift))
        return np.asarray(1.0 / rates[rates > ROUNDING_SHARE * np.max(rates)])

    def on(self, samples: Samples) -> "Problem":
        """Return the same problem on other samples."""
        return replace(self, samples=samples)


class RecordCost(Cost, Protocol):
    """The cost of a linear model's records."""

    @property
    def problem(self) -> Problem:
        """Return whose parameters these are."""


def problem_of(
    plant: Plant, samples: Samples, values: Numbers, free: Sequence[str | int]
) -> Problem:
    """Return the problem of estimating ``free``, by name or index, unscaled."""
    model = plant.model
    names = (model.names[one] if isinstance(one, int) else one for one in free)
    indices = model.indices(names)
    return Problem(plant, samples, values, indices, np.ones(len(indices)))

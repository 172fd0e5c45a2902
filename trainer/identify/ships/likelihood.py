"""The likelihood of a ship's records with what books say: value, gradient and information.

``fit`` searches its minimum. A parameter vector has the free coefficients, the logarithms of the
disturbances of u, v and r and of the errors of u, v, r and heading, then a first state for each
record; with roll there are a disturbance, two errors and two states more. Coefficients and noise
are common to all records.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from trainer.boat.ship.forces import System, Terms
from trainer.boat.ship.models import ShipModel
from trainer.core.kernel import Numbers
from trainer.identify.kernels.extended_filter import filter_record, sail_record
from trainer.identify.ships.records import Trial

NO_SLOPES: Final = np.empty(0), np.empty((0, 0))
MIN_ERROR_SHARE: Final = 1e-4  # [-] of a channel's own spread: no error of readings is smaller
FIRST_STATE_ROWS: Final = 11  # rows that the quadratic of the first state goes through


@dataclass(frozen=True, eq=False)
class ShipProblem:
    """Records, a model and the prior; a parameter without a prior has an infinite width."""

    model: ShipModel
    constants: Numbers  # of the ship, as the kernels take them
    trials: tuple[Trial, ...]
    mean: Numbers  # of the common parameters
    width: Numbers
    floors: Numbers  # of the errors of readings

    @property
    def names(self) -> tuple[str, ...]:
        """Return the names of the common parameters."""
        return (*self.model.free, *self.model.noises)

    @property
    def common(self) -> int:
        """Return how many parameters are common to all records."""
        return len(self.model.free) + len(self.model.noises)

    @property
    def size(self) -> int:
        """Return how many parameters there are."""
        return self.common + self.model.states * len(self.trials)

    @cached_property
    def _terms(self) -> Terms:
        """Return the model's terms."""
        return self.model.terms

    @cached_property
    def _indices(self) -> Terms:
        """Return the indices of the free coefficients."""
        return self.model.indices

    def coefficients(self, a: Numbers) -> dict[str, float]:
        """Return the free coefficients by name."""
        return dict(zip(self.model.free, map(float, a), strict=False))

    def noise(self, a: Numbers) -> Numbers:
        """Return the standard deviations of disturbances and errors."""
        return np.exp(a[len(self.model.free) : self.common])

    def first_indices(self, record: int) -> slice:
        """Return the indices of the first state of a record."""
        first = self.common + self.model.states * record
        return slice(first, first + self.model.states)

    def system(self, a: Numbers, first: Numbers) -> System:
        """Return what the kernels take as a system that begins with the state ``first``."""
        values = np.concatenate([self.model.whole(self.coefficients(a)), self.noise(a), first])
        return System(self.constants, self._terms, values, self._indices, self.model.driven)

    def penalty(self, a: Numbers) -> float:
        """Return what the prior adds to -log L.

        It grows as coefficients leave the books' values.
        """
        away = (a[: self.common] - self.mean) / self.width
        return 0.5 * float(away @ away)

    def cost(self, a: Numbers) -> float:
        """Return -log L with the prior; infinite where the state is no longer a ship's."""
        if not np.isfinite(a).all():
            return math.inf
        total = self.penalty(a)
        for i in range(len(self.trials)):
            total += self._filter(a, i, *NO_SLOPES)[0]
        return total

    def slopes(self, a: Numbers) -> tuple[float, Numbers, Numbers]:
        """Return -log L, its gradient and the information, each with the prior."""
        total, gradient = self.penalty(a), np.zeros(self.size)
        information = np.zeros((self.size, self.size))
        gradient[: self.common] = (a[: self.common] - self.mean) / self.width**2
        np.fill_diagonal(information[: self.common, : self.common], self.width**-2.0)
        count = self.common + self.model.states
        for i in range(len(self.trials)):
            own_slopes, known = np.zeros(count), np.zeros((count, count))
            total += self._filter(a, i, own_slopes, known)[0]
            indices = np.r_[: self.common, self.first_indices(i)]
            gradient[indices] += own_slopes
            information[np.ix_(indices, indices)] += np.tril(known) + np.tril(known, -1).T
        return total, gradient, information

    def _filter(self, a: Numbers, record: int, *slopes: Numbers) -> tuple[float, Numbers]:
        """Return -log L and errors with their variances (n, states, 2) of one record.

        ``slopes`` are where gradient and information (its lower half) are written.
        """
        table = self.trials[record].table
        errors = np.empty((len(table), self.model.states, 2))
        system = self.system(a, a[self.first_indices(record)])
        return float(filter_record(system, table, errors, *slopes)), errors

    def innovations(self, a: Numbers, record: int) -> Numbers:
        """Return the standardised innovations of a record, NaN where none was read."""
        _, errors = self._filter(a, record, *NO_SLOPES)
        return np.asarray(errors[:, :, 0] / np.sqrt(errors[:, :, 1]))

    def sail(self, a: Numbers, trial: Trial) -> Numbers:
        """Return the states (rows, n) by inputs alone.

        They are NaN from the row on in which they are no longer those of a ship.
        """
        states = self.model.states
        out = np.full((len(trial.table), states), math.nan)
        last = sail_record(self.system(a, first_state(trial)), trial.table, out)
        out[last:] = math.nan
        return out

    @cached_property
    def lowest(self) -> Numbers:
        """Return the lower limits of the parameters; only errors of readings have one."""
        limits = np.full(self.size, -math.inf)
        with np.errstate(divide="ignore"):
            limits[self.common - self.model.states : self.common] = np.log(self.floors)
        return limits


def first_state(trial: Trial) -> Numbers:
    """Return the first state, by a quadratic through the first readings of each channel."""
    t, rows = trial.t[:FIRST_STATE_ROWS] - trial.t[0], trial.readings[:FIRST_STATE_ROWS]
    state = np.zeros(rows.shape[1])
    for i in range(len(state)):
        known = np.isfinite(rows[:, i])
        if np.count_nonzero(known) > 2:
            state[i] = np.polyfit(t[known], rows[known, i], 2)[-1]
        else:
            seen = trial.readings[np.isfinite(trial.readings[:, i]), i]
            state[i] = seen[0] if len(seen) else 0.0
    return state


def floors_of(trials: tuple[Trial, ...]) -> Numbers:
    """Return the smallest errors of readings that a fit believes: a share of their spread.

    Published readings may be smoothed, and their errors would then go to zero.
    """
    rows = np.vstack([trial.readings for trial in trials])
    seen = np.atleast_1d(np.isfinite(rows).any(axis=0))
    spread = np.array([np.nanstd(rows[:, i]) if seen[i] else 1.0 for i in range(len(seen))])
    return np.asarray(MIN_ERROR_SHARE * np.maximum(spread, 1e-12))

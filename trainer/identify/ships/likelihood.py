"""The likelihood of a ship's records with what books say: value, gradient and information.

``ShipProblem`` is a cost that ``fitting/minimise`` searches and judges. A parameter vector has the
free coefficients, the logarithms of the disturbances of u, v and r and of the errors of u, v, r and
heading, then a first state for each record; with roll there are a disturbance, two errors and two
states more. Coefficients and noise are common to all records.

A record of a few manoeuvres does not determine all coefficients of such a model. The prior holds
those that it leaves open near what ships of such dimensions have; ``--prior-strength`` widens it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from trainer.boat.ship.forces import System, Terms
from trainer.boat.ship.models import ShipModel
from trainer.config.ship.ship import Dimensions, ShipFile
from trainer.core.kernel import Numbers
from trainer.identify.kernels.extended_filter import filter_record, sail_record
from trainer.identify.record.measurements import Record
from trainer.identify.ships.records import filter_table, readings_of

Prior = Mapping[str, tuple[float, float]]  # mean and standard deviation before the strength

# Full tankers, L/B 5.5, C_B 0.81 (model-tests of KVLCC2): the default where a ship file has no form
TANKER_PRIOR: Final[Prior] = {
    "X_T": (38.0, 2.0),
    "X_F": (0.09, 0.05),
    "X_vv": (0.0, 3.0),
    "X_vr": (1.6, 1.0),
    "X_rr": (0.0, 0.3),
    "X_w": (-0.001, 0.002),
    "Y_0": (0.0, 0.04),
    "Y_v": (-0.6, 0.3),
    "Y_r": (-0.43, 0.15),
    "Y_vvv": (-3.0, 3.0),
    "Y_vvr": (-0.4, 1.0),
    "Y_vrr": (-0.8, 1.0),
    "Y_rrr": (0.0, 0.5),
    "Y_F": (-0.2, 0.1),
    "Y_w": (-0.002, 0.003),
    "N_0": (0.0, 0.04),
    "N_v": (-4.4, 1.5),
    "N_r": (-1.8, 0.8),
    "N_vvv": (0.0, 3.0),
    "N_vvr": (-4.6, 4.0),
    "N_vrr": (0.8, 2.0),
    "N_rrr": (-0.44, 0.6),
    "N_F": (1.2, 0.4),
    "N_w": (0.0, 0.004),
    "N_ww": (0.0, 0.01),
    "gamma": (0.5, 0.15),
    "l": (-0.71, 0.02),
    "kappa": (0.5, 0.02),
    "c_w": (0.4, 0.2),
}
# Of the order of a container ship of small GM (Son and Nomoto 1981), from memory: as wide as known
HEEL_PRIOR: Final[Prior] = {
    "K_0": (0.0, 1.0),
    "K_v": (8.0, 16.0),
    "K_r": (-2.0, 8.0),
    "K_F": (3.0, 6.0),
    "K_w": (0.0, 0.02),
    "K_phi": (-1.0, 0.4),
    "K_p": (-0.1, 0.2),
    "Y_phi": (0.0, 0.1),
    "N_phi": (-0.2, 0.5),
}
HULL_DERIVATIVES: Final = tuple(f"{axis}_{term}" for axis in "YN" for term in ("v", "r"))
FORMULA_DEVIATION_SHARE: Final = 0.45  # [-] of a mean by formula that is its standard deviation
YAW_GYRATION_LENGTHS: Final = 0.25  # [L] radius of a ship
NET_THRUST_SHARE: Final = 0.78  # [-] 1-t, of a full ship
SURGE_ADDED_MASS_SHARE: Final = 0.075  # [-] of the mass: water that moves ahead with it
HULL_RUDDER: Final = 0.31, 0.46  # a_H and -x_H/L, of a full ship
RUDDER_ARM_LENGTHS: Final = 0.5  # [L] of the rudder aft of midship

NO_SLOPES: Final = np.empty(0), np.empty((0, 0))
AT_LEAST_SHARE: Final = 0.25  # [-] of an error's square that is its own: below it is at its least
MIN_ERROR_SHARE: Final = 1e-4  # [-] of a channel's own spread: no error of readings is smaller
FIRST_STATE_ROWS: Final = 11  # rows that the quadratic of the first state goes through


def prior_of(model: ShipModel, ship: ShipFile) -> tuple[Prior, str]:
    """Return what books say of the free coefficients, and which book says it.

    Models without cubic terms take no book's hull derivatives: their slopes are those of the range
    that they are fitted in, and a book's are slopes at zero.
    """
    form = kijima(ship.dimensions)
    whole = {**TANKER_PRIOR, **HEEL_PRIOR, **form}
    if model.name in ("linear", "mavmm"):
        whole = {name: one for name, one in whole.items() if name not in HULL_DERIVATIVES}
    known = {name: whole[name] for name in model.free if name in whole}
    source = "formulas of Kijima and others 1990, by the ship's form" if form else "full tankers"
    return known, source + (", in roll a container ship" if "K_v" in known else "")


def kijima(hull: Dimensions) -> Prior:
    """Return the coefficients that length, beam, draught and block say; empty without these.

    Kijima, Katsuno, Nakiri and Furukawa 1990 (J Soc Nav Arch Japan 168), even keel, over 1/2 rho L
    d U^2; N_vrr as published there, with C_B d/B. Masses: 2 C_B B/L, the water's pi d/L in sway (a
    plate of the draught) and a twelfth of it in yaw: estimates, which only set a weak prior.
    """
    B, d, C_B = hull.beam_m, hull.draught_m, hull.block_coefficient
    if B is None or d is None or C_B is None:
        return {}
    L = hull.length_m
    k, a, e = 2.0 * d / L, C_B * B / L, d * (1.0 - C_B) / B
    own_mass, water = 2.0 * a, math.pi * d / L
    sway = own_mass + water
    yaw = own_mass * YAW_GYRATION_LENGTHS**2 + water / 12.0
    means = {
        "X_T": NET_THRUST_SHARE / (own_mass * d / L * (1.0 + SURGE_ADDED_MASS_SHARE)),
        "Y_v": -(0.5 * math.pi * k + 1.4 * a) / sway,
        "Y_r": -1.5 * a / sway,
        "Y_vrr": -5.95 * e / sway,
        "Y_vvr": (1.5 * d * C_B / B - 0.65) / sway,
        "N_v": -k / yaw,
        "N_r": (-0.54 * k + k * k) / yaw,
        "N_rrr": (0.5 * a - 0.09) / yaw,
        "N_vrr": (0.5 * d * C_B / B - 0.05) / yaw,
        "N_vvr": -(57.5 * a * a - 18.4 * a + 1.6) / yaw,
    }
    means |= _rudder(hull, sway * L * d, yaw * L * d)
    # cubics no narrower than the tankers', because the formulas were written from memory
    least = {name: TANKER_PRIOR[name][1] for name in ("Y_vvr", "Y_vrr", "N_rrr", "N_vrr", "N_vvr")}
    spread = {
        name: max(FORMULA_DEVIATION_SHARE * abs(mean), least.get(name, 0.0))
        for name, mean in means.items()
    }
    spread["X_T"] = 0.1 * means["X_T"]
    return {name: (mean, spread[name]) for name, mean in means.items()}


def _rudder(hull: Dimensions, sway: float, yaw: float) -> dict[str, float]:
    """Return the gains of a rudder of known area and height, by Fujii's slope of lift."""
    if hull.rudder_area_m2 is None or hull.rudder_height_m is None:
        return {}
    ratio = hull.rudder_height_m**2 / hull.rudder_area_m2
    lift = hull.rudder_area_m2 * 6.13 * ratio / (ratio + 2.25)
    a_H, x_H = HULL_RUDDER
    return {"Y_F": -(1.0 + a_H) * lift / sway, "N_F": (RUDDER_ARM_LENGTHS + a_H * x_H) * lift / yaw}


@dataclass(frozen=True, eq=False)
class ShipProblem:
    """Records, a model and the prior; a parameter without a prior has an infinite width."""

    model: ShipModel
    constants: Numbers  # of the ship, as the kernels take them
    trials: tuple[Record, ...]
    mean: Numbers  # of the common parameters
    width: Numbers
    least: Numbers  # errors of readings, to which each is added
    _last: dict[str, Any] = field(default_factory=dict, init=False, repr=False)

    @property
    def problem(self) -> "ShipProblem":
        """Return whose parameters a search moves."""
        return self

    @cached_property
    def kinds(self) -> tuple[str, ...]:
        """Return how each parameter is bounded: a logarithm may become too small to be seen."""
        noises = range(len(self.model.free), self.common)
        return tuple("logarithm" if i in noises else "free" for i in range(self.size))

    @cached_property
    def scale(self) -> Numbers:
        """Return the size of each parameter that a search moves: its own."""
        return np.ones(self.size)

    @cached_property
    def floors(self) -> Numbers:
        """Return no floors, because ``least`` is within the likelihood."""
        return np.zeros(self.size)

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
    def tables(self) -> tuple[Numbers, ...]:
        """Return the records as the filter takes them."""
        return tuple(filter_table(trial, self.constants) for trial in self.trials)

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
        """Return the standard deviations of disturbances and errors.

        An error of readings has its ``least`` part beside its own: published readings may be
        smoothed, and their errors would then go to zero.
        """
        noise = np.exp(a[len(self.model.free) : self.common])
        noise[-self.model.states :] = np.hypot(noise[-self.model.states :], self.least)
        return noise

    def at_least(self, a: Numbers) -> NDArray[np.bool_]:
        """Return which parameters (f,) are errors of readings that are as small as may be."""
        return self.own_share(a) < AT_LEAST_SHARE

    def own_share(self, a: Numbers) -> Numbers:
        """Return the share of each parameter (f,) in its effect, of small errors below 1."""
        share, errors = np.ones(len(a)), slice(self.common - self.model.states, self.common)
        share[errors] = (np.exp(a[errors]) / self.noise(a)[-self.model.states :]) ** 2
        return share

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

    def value(self, a: Numbers) -> float:
        """Return -log L with the prior; infinite where the state is no longer a ship's."""
        if not np.isfinite(a).all():
            return math.inf
        total = self.penalty(a)
        for i in range(len(self.trials)):
            total += self._filter(a, i, *NO_SLOPES)[0]
        return total

    def slope(self, a: Numbers) -> tuple[float, Numbers]:
        """Return -log L and its gradient, with the prior."""
        return self._slopes(a)[:2]

    def information(self, a: Numbers) -> Numbers:
        """Return the expected information, with the prior's."""
        return self._slopes(a)[2]

    def _slopes(self, a: Numbers) -> tuple[float, Numbers, Numbers]:
        """Return value, gradient and information, from memory if ``a`` is the last point."""
        key = a.tobytes()
        if self._last.get("key") != key:
            self._last.update(key=key, slopes=self._compute_slopes(a))
        slopes: tuple[float, Numbers, Numbers] = self._last["slopes"]
        return slopes

    def _compute_slopes(self, a: Numbers) -> tuple[float, Numbers, Numbers]:
        total, gradient = 0.0, np.zeros(self.size)
        information = np.zeros((self.size, self.size))
        count = self.common + self.model.states
        for i in range(len(self.trials)):
            own_slopes, known = np.zeros(count), np.zeros((count, count))
            total += self._filter(a, i, own_slopes, known)[0]
            indices = np.r_[: self.common, self.first_indices(i)]
            gradient[indices] += own_slopes
            information[np.ix_(indices, indices)] += np.tril(known) + np.tril(known, -1).T
        share = self.own_share(a)
        gradient, information = gradient * share, information * np.outer(share, share)
        gradient[: self.common] += (a[: self.common] - self.mean) / self.width**2
        information[np.diag_indices(self.common)] += self.width**-2.0
        return total + self.penalty(a), gradient, information

    def _filter(self, a: Numbers, record: int, *slopes: Numbers) -> tuple[float, Numbers]:
        """Return -log L and errors with their variances (n, states, 2) of one record.

        ``slopes`` are where gradient and information (its lower half) are written.
        """
        table = self.tables[record]
        errors = np.empty((len(table), self.model.states, 2))
        system = self.system(a, a[self.first_indices(record)])
        return float(filter_record(system, table, errors, *slopes)), errors

    def innovations(self, a: Numbers, record: int) -> Numbers:
        """Return the standardised innovations of a record, NaN where none was read."""
        _, errors = self._filter(a, record, *NO_SLOPES)
        return np.asarray(errors[:, :, 0] / np.sqrt(errors[:, :, 1]))

    def sail(self, a: Numbers, trial: Record) -> Numbers:
        """Return the states (rows, n) by inputs alone.

        They are NaN from the row on in which they are no longer those of a ship.
        """
        table = filter_table(trial, self.constants)
        out = np.full((len(table), self.model.states), math.nan)
        last = sail_record(self.system(a, first_state(trial)), table, out)
        out[last:] = math.nan
        return out


def first_state(trial: Record) -> Numbers:
    """Return the first state, by a quadratic through the first readings of each channel."""
    readings, t = readings_of(trial), trial.t[:FIRST_STATE_ROWS] - trial.t[0]
    rows, state = readings[:FIRST_STATE_ROWS], np.zeros(readings.shape[1])
    for i in range(len(state)):
        known = np.isfinite(rows[:, i])
        if np.count_nonzero(known) > 2:
            state[i] = np.polyfit(t[known], rows[known, i], 2)[-1]
        else:
            seen = readings[np.isfinite(readings[:, i]), i]
            state[i] = seen[0] if len(seen) else 0.0
    return state


def least_errors(trials: tuple[Record, ...]) -> Numbers:
    """Return the smallest errors of readings that a fit believes: a share of their spread."""
    rows = np.vstack([*map(readings_of, trials)])
    seen = np.atleast_1d(np.isfinite(rows).any(axis=0))
    spread = np.array([np.nanstd(rows[:, i]) if seen[i] else 1.0 for i in range(len(seen))])
    return np.asarray(MIN_ERROR_SHARE * np.maximum(spread, 1e-12))

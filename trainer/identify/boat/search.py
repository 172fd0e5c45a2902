"""The search for the likeliest boat, and how sure it is.

Gauss-Newton on the innovations, with the prior as the unit matrix ([Lju] ch. 10); beside each of
its steps a step of scoring of the noise. Sums are made in one order by one thread, so a machine
gives the same bits at any number of processors.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from trainer.config.files import ConfigError
from trainer.core.kernel import Numbers
from trainer.identify.boat.filter import CHANNEL_NAMES, DRIVEN_COUNT, FilterResult, filter_record
from trainer.identify.boat.matrices import invert_positive, root_of_covariance
from trainer.identify.boat.noise import Noise, noise_deviations, start_of, usual_noise
from trainer.identify.boat.prior import Knowledge, Prior
from trainer.identify.boat.trial import Trial
from trainer.identify.boat.vessel import FittedVessel
from trainer.identify.fitting.minimise import (
    Progress,
    SearchOptions,
    SearchResult,
    ignore_news,
)
from trainer.units import DEGREE

MOST_STEPS: Final = 60
USUAL_SEARCH: Final = SearchOptions(MOST_STEPS)
MAX_MOVE: Final = 2.0  # [-] of any z in one step
MAX_RISE: Final = 1e-3  # [-] of the value, by which a step may be worse
# the same near the end: the equations that are solved are unbiased, and their root is not quite
# where the value is least, because the gain is held in the slopes
SMALL_RISE: Final = 1.0
SWINGING_RATIO: Final = 0.7  # [-] of a move over the one before it, near the end
MAX_DAMPINGS: Final = 8  # tried, before a step is given up
SETTLED_MOVE: Final = 0.05  # [-] posterior standard deviations
SETTLED_PROMISE: Final = 0.1  # [-] of the noise's step: below, it is left alone
NOISE_NUDGE: Final = 0.05  # of a logarithm
NOISE_STEPS, NOISE_PROMISE = 10, 1.0  # at most and at least, where the noise alone is sought
FREQUENT_STEPS: Final = 4  # after these the noise moves every second step ...
STOPPED_TEXT: Final = "stopped; the best so far"
UNGATED_STEPS: Final = 3  # before a boat follows its records, no reading can be told wild
WILD_DEVIATIONS: Final = 5.0  # standard deviations of an innovation
MAX_DELAYS: Final = 4  # [readings] by which surfaces are tried late or early
CLEAR_FALL: Final = 10.0  # [-] of the value, to tell that they are
OTHER_READINGS: Final = (  # that only a fit tells
    *((names, -1.0) for names in (("roll",), ("roll", "roll_rate"), ("roll_rate",))),
    *((names, -1.0) for names in (("bow",), ("pitch_rate",))),
    *((names, 1.0 / DEGREE) for names in (("stern",), ("bow",), ("stern", "bow"))),
)
OTHER_STEPS: Final = 10  # of a fit with these
SMALL_MOVE: Final = 0.5  # [-] posterior standard deviations: near the end, and it moves each step
UNSETTLED_FACTOR: Final = 2.0  # of the bands of a search that did not settle


@dataclass(frozen=True, eq=False)
class SearchEnd:
    """The end of a fit: parameters, how sure they are, and the noise."""

    prior: Prior
    trials: tuple[Trial, ...]
    found: SearchResult  # theta is z
    posterior: Knowledge
    covariance: Numbers  # of z
    noise: Noise
    passes: tuple[FilterResult, ...]  # by record, at the end
    delay: float = 0.0  # [s] by which surfaces seem to be logged late
    turned: str = ""  # which signs or units the records contradict, and the option that mends it

    @property
    def learned(self) -> Numbers:
        """Return the share (m,) of each prior deviation left; 1 of none."""
        before = self.prior.sd
        return np.divide(self.posterior.sd, before, out=np.ones_like(before), where=before > 0.0)

    @property
    def conflict(self) -> float:
        """Return z'z over what it should be of a boat of the prior [-]."""
        z, wide = self.found.theta, 1.0 if self.found.converged else UNSETTLED_FACTOR**2
        return float(z @ z / max(len(z) - np.trace(self.covariance) / wide, 1e-9))


def run_pass(
    vessel: FittedVessel, values: Numbers, trial: Trial, noise: Noise, count: int
) -> FilterResult:
    """Return a pass over one record with slopes by ``count`` parameters, all or none."""
    boat, start = vessel.numbers(values), start_of(trial, vessel, noise)
    found: FilterResult = filter_record(boat, trial.numbers, start, count)
    return found


@dataclass
class _Search:
    """A search under way: its best point so far."""

    prior: Prior
    trials: Sequence[Trial]
    options: SearchOptions
    z: Numbers = field(init=False)
    noise: Noise = field(init=False)
    cost: float = math.inf
    steps: int = 0
    damping: float = 0.0
    promise: float = math.inf
    moved: float = math.inf
    share: float = 1.0  # of a step, that is taken
    doubt: str = ""
    covariance: Numbers = field(init=False)

    def __post_init__(self) -> None:
        size = self.prior.root.shape[1]
        self.z, self.covariance = np.zeros(size), np.eye(size)
        self.start = self.noise = usual_noise(self.prior.vessel)
        used = [any(trial.has(name) for trial in self.trials) for name in CHANNEL_NAMES]
        self.used = np.flatnonzero([*[True] * DRIVEN_COUNT, *used])

    def values(self, z: Numbers) -> Numbers:
        """Return the parameters at ``z``."""
        return np.asarray(self.prior.values + np.einsum("ij,j", self.prior.root, z))

    def passes(self, z: Numbers, noise: Noise, count: int = 0) -> list[FilterResult]:
        """Return the passes over all records."""
        values = self.values(z)
        return [run_pass(self.prior.vessel, values, one, noise, count) for one in self.trials]

    def value(self, z: Numbers, noise: Noise) -> float:
        """Return what is minimised: minus the logarithm of likelihood and prior.

        It is infinite of a boat that lacks inertia, which a bad record may ask for.
        """
        if not self.prior.vessel.has_inertia(self.values(z)):
            return math.inf
        cost = sum(one.cost for one in self.passes(z, noise))
        return cost + 0.5 * float(z @ z) + self.noise_cost(noise)

    def noise_cost(self, noise: Noise) -> float:
        """Return the prior's part of a noise."""
        off = (noise.logarithms - self.start.logarithms) / noise_deviations()
        return 0.5 * float(off @ off)

    def move(self) -> bool:
        """Take a step of Gauss-Newton; return whether the search is at its end."""
        found = self.passes(self.z, self.noise, len(self.prior.values))
        cost = sum(one.cost for one in found)
        here = cost + 0.5 * float(self.z @ self.z) + self.noise_cost(self.noise)
        self.cost = here
        R = self.prior.root
        gradient = sum(one.gradient for one in found)
        information = sum(one.information for one in found)
        H = np.einsum("ji,jk->ik", R, np.einsum("ij,jk->ik", information, R))
        H = 0.5 * (H + H.T) + np.eye(len(self.z))
        slope = np.einsum("ji,j", R, gradient) + self.z
        self.covariance = invert_positive(H)
        sd = np.sqrt(np.diag(self.covariance))
        whole, before = -np.einsum("ij,j", self.covariance, slope), self.moved
        self.moved = float((np.abs(whole) / sd).max())
        if self.moved < SETTLED_MOVE and self.promise < SETTLED_PROMISE:
            return True
        small = self.moved < SMALL_MOVE
        if small and self.moved > SWINGING_RATIO * before:
            self.share = 0.5  # it goes to and fro: halfway is nearer
        allowed, self.damping = (SMALL_RISE, 0.0) if small else (MAX_RISE, self.damping)
        for _ in range(MAX_DAMPINGS):
            inverse = invert_positive(H + self.damping * np.diag(np.diag(H)))
            step = -np.einsum("ij,j", inverse, slope)
            step *= min(self.share, MAX_MOVE / float(np.abs(step).max()))
            value = self.value(self.z + step, self.noise)
            if value - here < allowed:
                self.z, self.cost, self.damping = self.z + step, value, self.damping / 5.0
                return False
            self.damping = max(5.0 * self.damping, 0.01)
        # where the noise is far off the slope is not that of the value: let the noise go first
        self.damping = 0.01
        return False

    def move_noise(self) -> None:
        """Take a step of scoring of the noise, by differences of innovations and variances."""
        e, s = _joined(self.passes(self.z, self.noise))
        slopes = []
        for index in self.used:
            nudged = self.noise.moved(self.used[self.used == index], NOISE_NUDGE)
            there = self.passes(self.z, nudged)
            if not all(math.isfinite(one.cost) for one in there):
                return  # the boat is lost beside it: the coefficients go first
            e_there, s_there = _joined(there)
            slopes.append(((e_there - e) / NOISE_NUDGE, (s_there - s) / NOISE_NUDGE))
        de, ds = (np.array([pair[i] for pair in slopes]) for i in (0, 1))
        known = np.isfinite(e) & np.isfinite(de).all(axis=0)  # neither missing nor wild
        e, s, de, ds = e[known], s[known], de[:, known], ds[:, known]
        deviation = noise_deviations()[self.used]
        off = (self.noise.logarithms - self.start.logarithms)[self.used]
        share = ds / s
        gradient = np.sum(0.5 * share * (1.0 - e * e / s) + e * de / s, axis=1)
        gradient += off / deviation**2
        information = np.einsum("ik,jk->ij", de / s, de)
        information += 0.5 * np.einsum("ik,jk->ij", share, share)
        information += np.diag(1.0 / deviation**2)
        step = -np.einsum("ij,j", invert_positive(information), gradient)
        self.promise = -0.5 * float(gradient @ step)
        if self.promise < SETTLED_PROMISE:
            return
        step *= min(1.0, 1.0 / float(np.abs(step).max()))
        for _ in range(4):
            tried = self.noise.moved(self.used, step)
            value = self.value(self.z, tried)
            if value < self.cost:
                self.noise, self.cost = tried, value
                return
            step = 0.5 * step

    def run(self) -> bool:
        """Search on to the end; return whether it settled."""
        for step in range(1, self.options.most + 1):
            self.steps = step
            if step > UNGATED_STEPS:
                self.noise = replace(self.noise, gate=WILD_DEVIATIONS)
            if self.move() and step > UNGATED_STEPS:
                return True
            often = self.steps <= FREQUENT_STEPS or self.moved < SMALL_MOVE
            if often or self.steps % 2 == 0:
                self.move_noise()
            told = SearchResult(self.z, self.cost, self.steps, converged=False)
            self.options.progress(told)
        self.doubt = f"not settled in {self.options.most} steps"
        return False


def _joined(passes: Sequence[FilterResult]) -> tuple[Numbers, Numbers]:
    """Return innovations and variances of all readings, one after the other; NaN of none."""
    e = np.concatenate([one.innovations.ravel() for one in passes])
    s = np.concatenate([one.variances.ravel() for one in passes])
    return e, s


def _lost_text(prior: Prior, trial: Trial) -> str:
    """Return that a boat does not fly a record at all."""
    return (
        f"{trial.source}: the boat of {prior.vessel.file.path.name} does not fly this record: are "
        "its units right, and is it of this boat?"
    )


def fit_trials(
    prior: Prior, trials: Sequence[Trial], options: SearchOptions = USUAL_SEARCH
) -> SearchEnd:
    """Return the likeliest boat of records, with its deviations.

    A KeyboardInterrupt ends the search; what was found by then is the result. ConfigError if the
    prior's boat cannot fly a record at all.
    """
    search = _Search(prior, trials, options)
    for trial, first in zip(trials, search.passes(search.z, search.noise), strict=True):
        if not math.isfinite(first.cost):
            raise ConfigError(_lost_text(prior, trial))
    try:
        settled = search.run()
    except KeyboardInterrupt:
        settled, search.doubt = False, STOPPED_TEXT
    V = search.covariance * (1.0 if settled else UNSETTLED_FACTOR**2)
    values = search.values(search.z)
    root = np.einsum("ij,jk->ik", prior.root, root_of_covariance(V))
    found = SearchResult(search.z, search.cost, search.steps, settled, search.doubt)
    ends = tuple(search.passes(search.z, search.noise))
    return SearchEnd(prior, tuple(trials), found, Knowledge(values, root), V, search.noise, ends)


def find_noise(prior: Prior, trial: Trial, start: Noise) -> Noise:
    """Return the likeliest noise of a record of the prior's boat, from ``start`` on.

    No reading is wild before the noise of all is found: in a sea nearly all would be.
    """
    search = _Search(prior, [trial], USUAL_SEARCH)
    start = replace(start, gate=math.inf)
    search.start = search.noise = start
    if not math.isfinite(search.value(search.z, start)):
        raise ConfigError(_lost_text(prior, trial))
    for gate in (math.inf, WILD_DEVIATIONS):
        search.noise = replace(search.noise, gate=gate)
        search.cost = search.value(search.z, search.noise)
        for _ in range(NOISE_STEPS):
            search.move_noise()
            if search.promise < NOISE_PROMISE:
                break
    return search.noise


def find_flaws(fit: SearchEnd, progress: Progress = ignore_news) -> SearchEnd:
    """Return a fit with what its records read otherwise, or late."""
    return replace(fit, turned=find_turned(fit, progress), delay=find_delay(fit, progress))


def find_delay(fit: SearchEnd, progress: Progress = ignore_news) -> float:
    """Return how late [s] surfaces are logged; below 0 early, 0 if neither.

    The boat is fitted on with its controls moved by a reading or more. Innovations of a late log
    are white, and only the value tells.
    """
    step = max(one.interval for one in fit.trials)
    best = fit.found.cost if fit.found.converged else _cost_with(fit, 0.0, progress)
    for way in (step, -step):
        found = 0
        while found < MAX_DELAYS:
            cost = _cost_with(fit, (found + 1) * way, progress)
            if not cost < best - CLEAR_FALL:
                break
            best, found = cost, found + 1
        if found:
            return found * way
    return 0.0


def find_turned(fit: SearchEnd, progress: Progress = ignore_news) -> str:
    """Return which signs or radians of OTHER_READINGS records contradict; "" for none.

    A boat is fitted to the records read so, from the prior on. No single channel tells how she
    heels in turns, or her bow planes pitch her: all together do.
    """
    found = {}
    for names, factor in OTHER_READINGS:
        told = [one for one in fit.trials if {(name, factor) for name in names} <= {*one.cures}]
        # a search that was caught is worse than many: of a sign it says nothing
        if told and (fit.found.converged or factor > 0.0):
            trials = [one.scaled(names, factor) if one in told else one for one in fit.trials]
            cures = " and ".join(told[0].cures[name, factor] for name in names)
            found[_cost_anew(fit, trials, progress)] = f"{told[0].source}: {cures}"
    least, best = min(found, default=math.inf), fit.found.cost - CLEAR_FALL
    # the records as they are have the same second try
    if not least < best or not least < _cost_anew(fit, fit.trials, progress) - CLEAR_FALL:
        return ""
    return f"{found[least]}: so a boat is likelier"


def _cost_anew(fit: SearchEnd, trials: Sequence[Trial], progress: Progress) -> float:
    """Return the value of records after a few steps from the prior on, with the noise found."""
    search = _Search(fit.prior, trials, SearchOptions(OTHER_STEPS, progress))
    search.noise = fit.noise
    if math.isfinite(search.value(search.z, search.noise)):
        search.run()
    return search.cost


def _cost_with(fit: SearchEnd, delay: float, progress: Progress) -> float:
    """Return the value after a few further steps, inputs moved by a ``delay`` [s]."""
    moved = [one.hastened(delay) for one in fit.trials]
    search = _Search(fit.prior, moved, SearchOptions(UNGATED_STEPS, progress))
    search.z, search.noise = fit.found.theta, fit.noise
    search.run()
    return search.cost

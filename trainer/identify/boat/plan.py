"""What to sail next: the trial that narrows chosen figures most.

Expected information needs no readings: the slopes of the innovations along a simulated run give it
(``filter``), and the slopes of a figure turn it into a deviation. Information of legs is summed to
rank all their choices; the best that keep the waters are then sailed and passed whole. [GP]
Goodwin and Payne, Dynamic System Identification (1977), ch. 6: experiments by their information.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import combinations_with_replacement
from typing import Final, NamedTuple

import numpy as np

from trainer.config.files import ConfigError, nearest
from trainer.core.kernel import Numbers
from trainer.identify.boat.figures import figures_of
from trainer.identify.boat.filter import CHANNEL_NAMES, DRIVEN_COUNT
from trainer.identify.boat.matrices import invert_positive
from trainer.identify.boat.noise import Noise, usual_noise
from trainer.identify.boat.prior import Prior, read_prior
from trainer.identify.boat.search import run_pass
from trainer.identify.boat.trial import without_unflown
from trainer.identify.boat.trial_legs import (
    PLAIN_LEG,
    SailedTrial,
    TrialLeg,
    Waters,
    able_legs,
    limits_broken,
    sail_legs,
    waters_of,
)

# prior standard deviations either way, for a figure's slope: an overshoot depends on the tick at
# which a rudder goes over, and jumps where less is changed
SLOPE_DEVIATIONS: Final = 1.0
EXPECTED_SHARE: Final = 0.5  # [-] of usual disturbances, which are on the generous side
LEG_COUNTS: Final = (3, 4, 6, 2, 1)  # in a trial: more where three find no room, fewer if short
MIN_LEG_LENGTHS: Final = 15.0  # [L/U] of a leg: shorter, it hardly begins
MAX_SAILED: Final = 60  # choices of legs sailed for one count, the best first
MAX_PASSED: Final = 4  # of them passed whole


@dataclass(frozen=True, eq=False)
class TrialQuestion:
    """What trial is asked for: of which boat, of how many ``seconds`` [s], and where."""

    prior: Prior
    seconds: float
    waters: Waters


@dataclass(frozen=True, eq=False)
class FigureSlopes:
    """Figures of a boat, and their slopes by its parameters."""

    names: tuple[tuple[str, str], ...]  # figure, unit
    values: Numbers  # (f,)
    slopes: Numbers  # (f, m)

    def chosen(self, words: Sequence[str]) -> "FigureSlopes":
        """Return those whose name has one of the words; all without any. ConfigError."""
        names = [name for name, _ in self.names]
        for word in words:
            if not any(word.casefold() in name for name in names):
                nearby = nearest(word, {part.strip(":") for name in names for part in name.split()})
                known = "; ".join(names)
                raise ConfigError(f"--figure {word}: no such figure{nearby}; there are {known}")
        kept = [
            i
            for i, name in enumerate(names)
            if not words or any(word.casefold() in name for word in words)
        ]
        return FigureSlopes(
            tuple(self.names[i] for i in kept), self.values[kept], self.slopes[kept]
        )


class PlannedFigure(NamedTuple):
    """A figure with its deviations: before, after a plain zig-zag, after the plan [SI, rad]."""

    name: str
    unit: str
    value: float
    before: float
    plain: float
    planned: float


@dataclass(frozen=True, eq=False)
class TrialPlan:
    """What to sail next."""

    prior: Prior
    waters: Waters
    sailed: SailedTrial
    figures: tuple[PlannedFigure, ...]


def open_question(
    name_or_path: str, minutes: float, room: str | None, depth: str | None
) -> TrialQuestion:
    """Return the question that words such as ``2000m`` and ``40:120`` ask; ConfigError."""
    prior, seconds = read_prior(name_or_path), 60.0 * minutes
    vessel = prior.vessel
    least = MIN_LEG_LENGTHS * vessel.length / vessel.speed
    if seconds < least:
        raise ConfigError(
            f"--minutes {minutes:.3g}: needs {least / 60.0:.2g} or more, in which this boat goes "
            f"{MIN_LEG_LENGTHS:g} of its lengths; three times that is better"
        )
    return TrialQuestion(prior, seconds, waters_of(vessel, room, depth))


def slopes_count(prior: Prior) -> int:
    """Return how many boats are sailed for the slopes of figures."""
    return 1 + 2 * int(np.count_nonzero(prior.sd > 0.0))


def figure_slopes(prior: Prior, heard: Callable[[int], object]) -> FigureSlopes:
    """Return the figures of a prior's boat with their slopes; ``heard`` counts boats sailed."""
    vessel = prior.vessel
    own = {key: one for key, one in figures_of(vessel.file).items() if one is not None}
    heard(1)
    slopes = np.zeros((len(own), len(prior.values)))
    for j in np.flatnonzero(prior.sd > 0.0):
        ends = []
        for way in (-SLOPE_DEVIATIONS, SLOPE_DEVIATIONS):
            moved = prior.values.copy()
            moved[j] += way * prior.sd[j]
            there = figures_of(vessel.with_values(moved))
            found = [there[key] for key in own]
            if None not in found:  # else a figure is lost there, and the slope is of one side
                ends.append((way, np.array(found, float)))
            heard(1)
        if len(ends) == 1:
            ends.append((0.0, np.array([*own.values()])))
        if ends:
            (low, below), (high, above) = ends
            slopes[:, j] = (above - below) / ((high - low) * prior.sd[j])
    return FigureSlopes(tuple(own), np.array([*own.values()]), slopes)


def expected_noise(prior: Prior) -> Noise:
    """Return the noise of an earlier fit, or half the usual disturbances."""
    usual, found = usual_noise(prior.vessel), prior.tables.get("fit")
    if found is None:
        return usual.moved(np.arange(DRIVEN_COUNT), math.log(EXPECTED_SHARE))
    errors = dict(zip(CHANNEL_NAMES, usual.errors, strict=True)) | dict(found["errors"])
    return Noise(np.log([*found["disturbance"], *(errors[name] for name in CHANNEL_NAMES)]))


def information_of(prior: Prior, sailed: SailedTrial, noise: Noise) -> Numbers:
    """Return what a trial should tell of the parameters (m, m), besides the prior."""
    trial = without_unflown(sailed.trial)
    found = run_pass(prior.vessel, prior.values, trial, noise, len(prior.values))
    return found.information


def deviations_of(prior: Prior, figures: FigureSlopes, information: Numbers) -> Numbers:
    """Return the standard deviations (f,) of figures after records of that information."""
    R = prior.root
    H = np.einsum("ji,jk->ik", R, np.einsum("ij,jk->ik", information, R))
    V = invert_positive(0.5 * (H + H.T) + np.eye(R.shape[1]))
    slopes = np.einsum("fj,jk->fk", figures.slopes, R)
    return np.asarray(np.sqrt(np.einsum("fi,ij,fj->f", slopes, V, slopes)))


@dataclass(frozen=True, eq=False)
class _Planning:
    """A question, and what its trials are judged by."""

    prior: Prior
    seconds: float
    waters: Waters
    figures: FigureSlopes
    noise: Noise
    heard: Callable[[str], object]
    broken: dict[str, str] = field(default_factory=dict)  # what is not kept, by trial

    def sail(self, legs: tuple[TrialLeg, ...], seconds: float) -> SailedTrial | None:
        """Return a trial of legs, each of ``seconds`` [s]; None beyond the waters."""
        sailed = sail_legs(self.prior.vessel, self.prior.values, legs, seconds, self.waters)
        words = limits_broken(sailed, self.waters)
        if words:
            self.broken[sailed.trial.source] = words
        return None if words else sailed

    def left(self, information: Numbers) -> float:
        """Return what is to be least: the mean of the logarithms of the deviations."""
        return float(np.mean(np.log(deviations_of(self.prior, self.figures, information))))

    def ranked(self, count: int) -> list[tuple[TrialLeg, ...]]:
        """Return choices of ``count`` legs, the best first by the sum of their information."""
        told = dict[TrialLeg, Numbers]()
        for leg in able_legs(self.prior.vessel.file.surfaces):
            self.heard(f"sailing {leg.name}")
            sailed = self.sail((leg,), self.seconds / count)
            if sailed is not None:
                told[leg] = information_of(self.prior, sailed, self.noise)
        choices = [*combinations_with_replacement(told, count)]
        sums = (sum((told[leg] for leg in legs[1:]), told[legs[0]]) for legs in choices)
        scores = np.array([*map(self.left, sums)])
        return [choices[i] for i in np.argsort(scores, kind="stable")[:MAX_SAILED]]

    def best(self, count: int) -> SailedTrial | None:
        """Return the best trial of ``count`` legs; None if none keeps the waters."""
        passed = list[tuple[float, SailedTrial]]()
        for legs in self.ranked(count):
            sailed = self.sail(legs, self.seconds / count)
            if sailed is not None:
                self.heard(f"judging {sailed.trial.source}")
                passed.append((self.left(information_of(self.prior, sailed, self.noise)), sailed))
            if len(passed) == MAX_PASSED:
                break
        return min(passed, key=lambda one: one[0])[1] if passed else None

    def judge(self, best: SailedTrial) -> TrialPlan:
        """Return the plan, with what a plain zig-zag of the same length gives."""
        prior, surfaces = self.prior, self.prior.vessel.file.surfaces
        leg = PLAIN_LEG._replace(angle=min(PLAIN_LEG.angle, surfaces.rudder_limit_deg))
        anywhere = self.waters._replace(room=math.inf)
        plain = sail_legs(prior.vessel, prior.values, (leg,), self.seconds, anywhere)
        told = (information_of(prior, one, self.noise) for one in (plain, best))
        nothing = np.zeros((len(prior.values),) * 2)
        columns = [deviations_of(prior, self.figures, one) for one in (nothing, *told)]
        rows = zip(self.figures.names, self.figures.values, *columns, strict=True)
        shown = (PlannedFigure(*name, *map(float, numbers)) for name, *numbers in rows)
        return TrialPlan(prior, self.waters, best, tuple(shown))


def find_plan(
    asked: TrialQuestion, figures: FigureSlopes, heard: Callable[[str], object] = lambda _: None
) -> TrialPlan:
    """Return the trial that narrows figures most; ``heard`` has news.

    ConfigError where no trial keeps the waters.
    """
    prior, seconds = asked.prior, asked.seconds
    planning = _Planning(prior, seconds, asked.waters, figures, expected_noise(prior), heard)
    least = MIN_LEG_LENGTHS * prior.vessel.length / prior.vessel.speed
    for count in LEG_COUNTS:
        best = planning.best(count) if seconds >= count * least else None
        if best is not None:
            return planning.judge(best)
    raise ConfigError(
        f"no trial of {seconds:.0f} s keeps these waters: "
        + "; ".join(f"{name} {words}" for name, words in [*planning.broken.items()][:4])
        + ": give more --room or --depth, or fewer --minutes"
    )

"""What a fit of a boat says: coefficients, figures, records held out, warnings.

``page`` shows it, ``fitted_file`` writes it into the boat's file. Clean innovations do not prove
the bands: only a held-out trial of another kind does, and it is therefore asked for.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.boat.figures import (
    BAND_DRAWS,
    FigureBand,
    figure_bands,
    flown_outside,
    ranges_of,
)
from trainer.identify.boat.filter import CHANNEL_NAMES, FilterResult, sail_controls
from trainer.identify.boat.motion import MOTION_COUNT, STATE, STATE_NAMES
from trainer.identify.boat.noise import SLOW_KINDS, slow_deviations
from trainer.identify.boat.regressors import PARAMETER_NAMES
from trainer.identify.boat.search import SearchEnd, run_pass
from trainer.identify.boat.trial import USUAL_ERRORS, Trial
from trainer.identify.record.motion_laws import FLOWN_PLANES_RAD
from trainer.units import DEGREE

LEARNED_SHARES: Final = (0.5, 0.9)  # of the prior deviation that is left: learned, partly
VERDICT_WORDS: Final = ("from the record", "partly", "not learned")
CHI_RANGE: Final = (0.9, 1.1)  # of the mean of squared innovations over their variance
MAX_NOISELESS_CHI: Final = 0.3  # [-] median of a record whose readings have no errors
MAX_LAG: Final = 0.15  # [-] correlation of an innovation with the one before
MAX_ERROR_RATIO: Final = 2.0  # [-] of an error of readings over what it usually is
MAX_SLOW_DEVIATIONS: Final = 2.5
MAX_WILD_SHARE: Final = 0.005  # [-] of a record's rows
# the inertia of the water that goes with the hull, which none has against its own (Imlay 1961)
ADDED_MASSES: Final = ("X_udot", "Y_vdot", "Z_wdot", "K_pdot", "M_qdot", "N_rdot")
# of every boat; which way bow planes pitch her depends on their place
CONTROL_SIGNS: Final = {"Y_dr": 1.0, "N_dr": -1.0, "Z_ds": -1.0, "M_ds": -1.0, "Z_db": -1.0}
MAX_CONFLICT: Final = 1.6  # [-] of z'z over what it should be
LEAD_IN_S: Final = 10.0  # [s] of a held-out record, from whose end it is simulated
FORETOLD_CHANNELS: Final = {  # what is foretold: unit, the state, and the channel that must be read
    "yaw rate": ("rad/s", STATE.R, "heading"),
    "pitch": ("rad", STATE.THETA, "pitch"),
    "roll": ("rad", STATE.PHI, "roll"),
    "speed": ("m/s", STATE.U, "speed"),
    "depth": ("m", STATE.Z, "depth"),
}


@dataclass(frozen=True)
class ParameterChange:
    """A parameter before and after a fit."""

    name: str
    prior: float
    prior_sd: float
    value: float
    sd: float
    learned: float  # [-] share of the prior deviation that is left
    verdict: str


@dataclass(frozen=True)
class ChannelFit:
    """How a channel's innovations lie: ``chi`` should be 1, ``lag`` 0."""

    channel: str
    readings: int
    chi: float
    lag: float
    wild: int  # readings that are too far off, and move nothing


@dataclass(frozen=True)
class SlowState:
    """Something that a record told and that is no part of the boat's file."""

    name: str
    unit: str
    value: float
    sd: float
    prior_sd: float


@dataclass(frozen=True)
class RecordFit:
    """How a record was followed. Of a record held out also how much of it was foretold."""

    source: str
    digest: str
    rows: int
    interval_s: float
    columns: tuple[str, ...]
    told: tuple[str, ...]
    channels: tuple[ChannelFit, ...]
    slow: tuple[SlowState, ...]
    seen: Mapping[str, tuple[float, float]]  # least and greatest, of u [m/s], v/u, angles [rad]
    explained: Mapping[str, tuple[float, float]]  # [%] by the fit and by the prior; held out


@dataclass(frozen=True)
class BoatFit:
    """All that ``trainer boat fit`` says."""

    vessel: str
    prior: str
    settled: bool
    doubt: str
    steps: int
    cost: float  # minus the logarithm of the likelihood and the priors
    conflict: float  # [-] z'z over what it should be
    records: tuple[RecordFit, ...]
    held_out: tuple[RecordFit, ...]
    coefficients: tuple[ParameterChange, ...]
    disturbance: tuple[float, ...]  # [m/s2, rad/s2 per root of Hz]
    errors: Mapping[str, float]  # [SI] by channel
    before: tuple[FigureBand, ...]
    after: tuple[FigureBand, ...]
    warnings: tuple[str, ...]


def report_fit(
    fit: SearchEnd,
    held_out: Sequence[Trial],
    draws: int = BAND_DRAWS,
    heard: Callable[[int], object] = lambda _: None,
) -> BoatFit:
    """Return what a fit says; ``heard`` is told of boats sailed for the bands."""
    prior, vessel, trials = fit.prior, fit.prior.vessel, fit.trials
    whole = tuple(
        _record_fit(fit, one, found, {}) for one, found in zip(trials, fit.passes, strict=True)
    )
    aside = tuple(_held_out(fit, one) for one in held_out)
    used = [name for name in CHANNEL_NAMES if any(one.has(name) for one in trials)]
    errors = dict(zip(CHANNEL_NAMES, map(float, fit.noise.errors), strict=True))
    before = figure_bands(vessel, prior, draws, heard)
    after = figure_bands(vessel, fit.posterior, draws, heard)
    return BoatFit(
        vessel=vessel.file.name,
        prior=vessel.file.path.name,
        settled=fit.found.converged,
        doubt=fit.found.doubt,
        steps=fit.found.steps,
        cost=fit.found.cost,
        conflict=fit.conflict,
        records=whole,
        held_out=aside,
        coefficients=tuple(_coefficients(fit)),
        disturbance=tuple(map(float, fit.noise.disturbance)),
        errors={name: errors[name] for name in used},
        before=before,
        after=after,
        warnings=tuple(_warnings(fit, whole, {name: errors[name] for name in used})),
    )


def figures_count(draws: int = BAND_DRAWS) -> int:
    """Return how many boats a report sails."""
    return 2 * (draws + 1)


def _coefficients(fit: SearchEnd) -> Iterator[ParameterChange]:
    """Yield every parameter with what the records told of it."""
    prior, posterior = fit.prior, fit.posterior
    for i, name in enumerate(PARAMETER_NAMES):
        learned = float(fit.learned[i])
        verdict = VERDICT_WORDS[int(np.searchsorted(LEARNED_SHARES, learned, side="right"))]
        yield ParameterChange(
            name,
            float(prior.values[i]),
            float(prior.sd[i]),
            float(posterior.values[i]),
            float(posterior.sd[i]),
            learned,
            verdict,
        )


def _record_fit(
    fit: SearchEnd, trial: Trial, found: FilterResult, explained: Mapping[str, tuple[float, float]]
) -> RecordFit:
    """Return how a pass followed a record."""
    vessel, channels, slow = fit.prior.vessel, [], []
    for i, name in enumerate(CHANNEL_NAMES):
        if trial.has(name):
            wild = np.isfinite(trial.readings[:, i]) & np.isnan(found.innovations[:, i])
            scaled = found.innovations[:, i] / np.sqrt(found.variances[:, i])
            channels.append(_channel(name, scaled, int(wild.sum())))
    before = slow_deviations(vessel, trial)
    sd = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    for i, name in enumerate(STATE_NAMES[MOTION_COUNT:]):
        at = MOTION_COUNT + i
        if before[i] > 0.0:
            value = float(found.states[-1, at])
            slow.append(
                SlowState(name, SLOW_KINDS[name].unit, value, float(sd[at]), float(before[i]))
            )
    motion = (found.states[:, at] for at in (STATE.U, STATE.V, STATE.W, STATE.R))
    moved = {
        name: (float(one.min()), float(one.max()))
        for name, one in zip(("rudder", "stern", "bow"), trial.inputs.T, strict=False)
    }
    return RecordFit(
        source=trial.source,
        digest=trial.digest,
        rows=len(trial.readings),
        interval_s=trial.interval,
        columns=trial.columns,
        told=trial.told,
        channels=tuple(channels),
        slow=tuple(slow),
        seen={**ranges_of(motion, vessel.length), **moved},
        explained=explained,
    )


def _channel(name: str, scaled: Numbers, wild: int) -> ChannelFit:
    """Return how the innovations of a channel lie, in their deviations."""
    known = scaled[np.isfinite(scaled)]
    pairs = scaled[1:] * scaled[:-1]
    pairs = pairs[np.isfinite(pairs)]
    chi = float(np.mean(known**2))
    lag = float(np.mean(pairs)) / chi if pairs.size else 0.0
    return ChannelFit(name, len(known), chi, lag, wild)


class Foretold(NamedTuple):
    """States (n, 17) of a held-out record from LEAD_IN_S on; NaN once lost."""

    t: Numbers  # (n,) [s] of the record
    followed: Numbers  # with its readings
    fit: Numbers  # by its controls alone
    prior: Numbers  # likewise, of the boat before the fit


def foretell(fit: SearchEnd, trial: Trial) -> Foretold:
    """Return what a record's controls alone lead to.

    Weight and trim are those that the filter found in this record: they are of the day, not of the
    boat.
    """
    vessel, sailed = fit.prior.vessel, []
    begin = min(round(LEAD_IN_S / trial.interval), len(trial.readings) - 2)
    rest = trial.numbers._replace(inputs=trial.inputs[begin:])
    for values in (fit.prior.values, fit.posterior.values):
        own = run_pass(vessel, values, trial, fit.noise, 0)
        state = own.states[begin].copy()
        state[MOTION_COUNT:] = own.states[-1, MOTION_COUNT:]
        sailed.append(sail_controls(vessel.numbers(values), rest, state))
    t = np.arange(begin, len(trial.readings), dtype=float) * trial.interval
    return Foretold(t, own.states[begin:], sailed[1], sailed[0])


def _held_out(fit: SearchEnd, trial: Trial) -> RecordFit:
    """Return how a record is followed that had no part in the fit, and how far foretold."""
    one, explained = foretell(fit, trial), {}
    for name, (_, at, channel) in FORETOLD_CHANNELS.items():
        if trial.has(channel):
            shares = [_explained(one.followed[:, at], by[:, at]) for by in (one.fit, one.prior)]
            explained[name] = (shares[0], shares[1])
    found = run_pass(fit.prior.vessel, fit.posterior.values, trial, fit.noise, 0)
    return _record_fit(fit, trial, found, explained)


def _explained(truth: Numbers, foretold: Numbers) -> float:
    """Return the share [%] of a variance that is foretold; below 0 a constant is better."""
    spread = float(np.sum((truth - truth.mean()) ** 2))
    left = float(np.sum((truth - foretold) ** 2))
    return 100.0 * (1.0 - left / spread) if spread > 0.0 and math.isfinite(left) else math.nan


def _warnings(
    fit: SearchEnd, records: Sequence[RecordFit], errors: Mapping[str, float]
) -> Iterator[str]:
    """Yield what should make one doubt, each with what to do."""
    if not fit.found.converged:
        yield (
            f"the search did not settle ({fit.found.doubt}): all bands are doubled; fit fewer "
            "records, or give a longer one"
        )
    if turned := fit.turned or turned_controls(fit):
        yield turned
    if fit.conflict > MAX_CONFLICT:
        yield (
            f"the coefficients lie {fit.conflict:.2g} times as far from the prior as they should: "
            "the boat is not like those of which the method was made, or a log is late, has a "
            "wrong sign or is biased: hold out a trial of another kind"
        )
    wrong = [
        f"{name} {value:+.2g}"
        for name in ADDED_MASSES
        if (value := fit.posterior.values[PARAMETER_NAMES.index(name)]) > 0.0
    ]
    if wrong:
        yield (
            f"{', '.join(wrong)}: added mass of the wrong sign: the records tell too little of "
            "that acceleration; write the prior's value there, or fit a record that has more of it"
        )
    if fit.delay:
        way = "late" if fit.delay > 0.0 else "early"
        yield (
            f"surfaces are logged {abs(fit.delay):.3g} s {way}, as the motion tells, and this fit "
            f"takes them as logged: fit again with --late {fit.delay:.3g}"
        )
    if all(np.std(one.inputs[:, 1:3], axis=0).max() < FLOWN_PLANES_RAD for one in fit.trials):
        yield (
            "no record flies the planes, they only keep the depth: figures of diving may be off by "
            "more than their bands; sail and fit a vertical zig-zag"
        )
    yield from record_warnings(records)
    for name, error in errors.items():
        if error > MAX_ERROR_RATIO * USUAL_ERRORS[name]:
            yield (
                f"{name} is read {error / USUAL_ERRORS[name]:.1f} times worse than usual: look for "
                "wild readings, or for waves"
            )
    further = "; ".join(
        flown_outside(
            fit.prior.vessel.with_values(fit.posterior.values), [one.seen for one in records]
        )
    )
    if further:
        yield (
            f"figures beyond what the records saw: {further}: they rest on the prior there; sail "
            "and fit such a trial"
        )


def turned_controls(fit: SearchEnd) -> str:
    """Return which control coefficients have a sign that no boat has, "" if none."""
    values = dict(zip(PARAMETER_NAMES, fit.posterior.values.tolist(), strict=True))
    turned = [
        f"{name} {values[name]:+.2g}"
        for name, sign in CONTROL_SIGNS.items()
        if sign * values[name] < 0.0
    ]
    if not turned:
        return ""
    return (
        f"{', '.join(turned)}: of the other sign than every boat has: a surface, heading or pitch "
        "has the wrong sign or unit, or another surface moved and is not in the record"
    )


def record_warnings(records: Sequence[RecordFit]) -> Iterator[str]:
    """Yield what is odd about how records were followed, a sentence a kind.

    A record without noise, as a simulator writes it, is told as that, and its innovations say
    no more.
    """
    exact = [one for one in records if _is_noiseless(one)]
    if exact:
        yield (
            f"without noise, as a simulator writes it: {', '.join(one.source for one in exact)}: "
            "a fit expects errors, so bands and wild readings of it say little; fit the recording "
            "(.trainer), to which errors of usual gauges are added, or add them to the columns"
        )
    noisy = [one for one in records if one not in exact]
    read = [(one, channel) for one in noisy for channel in one.channels]
    sizes = [
        f"{channel.channel} {channel.chi:.2f} ({one.source})"
        for one, channel in read
        if not CHI_RANGE[0] <= channel.chi <= CHI_RANGE[1]
    ]
    if sizes:
        yield (
            f"chi is not 0.9 to 1.1 of {', '.join(sizes)}: errors there differ from those of "
            "other records: fit such a record alone, or leave the column out"
        )
    lags = [
        f"{channel.channel} {channel.lag:+.2f} ({one.source})"
        for one, channel in read
        if abs(channel.lag) > MAX_LAG
    ]
    if lags:
        yield (
            f"errors follow each other, {', '.join(lags)}: readings are too rare, or a gauge is "
            "slow: record more often"
        )
    for one in noisy:
        wild = [f"{each.wild} of {each.channel}" for each in one.channels if each.wild]
        if sum(each.wild for each in one.channels) > MAX_WILD_SHARE * one.rows:
            yield (
                f"{one.source}: wild readings are left out, {', '.join(wild)}: look at these "
                "gauges, and leave cells empty where they do not work"
            )
    slow = [
        words
        for one in records
        for state in one.slow
        if abs(state.value) > MAX_SLOW_DEVIATIONS * state.prior_sd
        for words in [_slow_words(one.source, state)]
    ]
    if slow:
        yield (
            f"unusual of its day: {'; '.join(slow)}: look at ballast and gauges; if it is so, fit "
            "with the --bias that stands there"
        )


def _is_noiseless(one: RecordFit) -> bool:
    """Return whether most channels of a record lie closer than errors of their size ever do."""
    sizes = [each.chi for each in one.channels if each.readings]
    return bool(sizes) and float(np.median(sizes)) < MAX_NOISELESS_CHI


def _slow_words(source: str, slow: SlowState) -> str:
    """Return what a slow state is, what is usual, and the option that allows for it."""
    factor, unit = (1.0 / DEGREE, "deg") if slow.unit == "rad" else (1.0, slow.unit)
    name, size = slow.name.removesuffix("_error"), abs(factor * slow.value)
    return (
        f"{slow.name.replace('_', ' ')} {factor * slow.value:.3g} {unit.strip('-')}".rstrip()
        + f", usual {factor * slow.prior_sd:.2g} ({source}; --bias {name}={size:.1g})"
    )

"""The faults of a record before any fit, by column and row.

A gap in time, a stuck reading, an outlier or a rudder of the wrong sign spoils a fit unseen.
``record/study`` examines every record: one that cannot be used is refused with a ConfigError, and
what may mislead is reported as a finding.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from trainer.config.files import ConfigError, raise_problems
from trainer.config.ship.fit_options import INPUT_PATHS, MOTION_CHANNELS
from trainer.config.tables import EVEN_STEP_TOLERANCE
from trainer.core.kernel import Numbers
from trainer.identify.record.measurements import (
    POSITION_CHANNELS,
    Finding,
    Record,
    unwrap_angle,
)
from trainer.identify.record.readings import (
    ANGLE_CHANNELS,
    GAP_READINGS,
    RARE_ROWS,
    at_readings,
    fill_inputs,
    find_gaps,
    jumps_at_readings,
    rows_between,
)
from trainer.identify.record.sources import MAX_INTERVAL_S
from trainer.identify.record.study_records import Ship
from trainer.units import KNOT

FROZEN_S, FROZEN_ROWS = 55.0, 5  # a heading that stands so long under helm is told
STILL_RUDDER_RAD: Final = math.radians(0.01)  # [rad] deviation of a rudder that does not move
SURE_STANDARD_ERRORS: Final = 4.0  # standard errors
FEEDBACK_SHARE: Final = 0.98  # [-] of the rudder explained by the motion: beyond, it only follows
SPEED_MISTAKES: Final = (  # what a speed is then of what it must be [-]
    (KNOT, "is it in m/s?"),
    (1.0 / KNOT, "is it in kn?"),
    (-1.0, "is it positive to port?"),
)
HALF_TURN: Final = math.pi
MIN_SAMPLES: Final = 20  # samples, to judge signs and loops
PIVOT_LENGTHS: Final = 0.1, 0.75  # [ship lengths] how far ahead a ship's turning point lies
ORDERED_NAME: Final = re.compile(  # of an ordered angle, which is a step
    r"(?:^|[\W_])(?:order|orders|ordered|command|commanded|cmd|c|demand|demanded|desired|set|"
    r"setpoint|target|soll)(?:$|[\W_])"
)
PATH_TEXTS: Final = {  # of INPUT_PATHS
    "straight": "straight from reading to reading",
    "step": "held until the next reading",
}
SURE_EVIDENCE: Final = 4.6  # [-] of log-likelihood, a hundred to one
SPIKE_SCATTERS: Final = 10.0  # [-] usual scatters, by which an outlier leaves its neighbours


def examine_record(record: Record, ship: Ship | None = None) -> list[Finding]:
    """Return what may mislead in a record; ConfigError with all that forbids its use.

    If the ``ship`` is known, sizes are judged by its length and speed.
    """
    read = at_readings(record)
    problems = [*_time_problems(record), *_rudder_problems(record)]
    raise_problems([f"{record.source}: {problem}" for problem in problems])
    findings = [*record.findings, *(_intervals(record) if read is record else ())]
    findings += [*_missing_outputs(record), *_jumps(read)]
    findings += [*_find_feedback(read), *_constant_outputs(record), *_frozen(read)]
    return [*findings, *_spikes(record), *(_sizes(read, ship) if ship else ())]


def choose_path(record: Record, inputs: Sequence[str], said: str | None) -> tuple[str, str]:
    """Return how inputs go from reading to reading, one of INPUT_PATHS, and why.

    It is what a file has ``said``, else what names and numbers tell.
    """
    if said is not None:
        return said, "the study says so"
    path, why = _guess_path(record, inputs)
    other = next(one for one in INPUT_PATHS if one != path)
    return path, f'{why}; else say between_readings = "{other}" in a study'


def _guess_path(record: Record, inputs: Sequence[str]) -> tuple[str, str]:
    """Return the likelier of INPUT_PATHS, and why.

    An ordered angle is a step. A measured one is a straight line, because it takes time to move;
    unless no reading shows it under way, and the ship's motion does not say otherwise.
    """
    names = [record.name(name) for name in inputs]
    if all(ORDERED_NAME.search(name.casefold()) for name in names):
        return "step", "its name is that of an order"
    if any(jumps_at_readings(record.column(name)) for name in inputs):
        if _evidence_of_steps(record, inputs) > -SURE_EVIDENCE:
            return "step", "no reading shows it under way"
        return "straight", "the motion follows that best"
    return "straight", "as a measured angle goes"


def _evidence_of_steps(record: Record, inputs: Sequence[str]) -> float:
    """Return log-likelihood of steps less that of straight lines [-], by two regressions.

    The next motion by the last two and by what acted in both intervals, channel by channel.
    """
    motions = [record.plain[name] for name in record.plain if name not in inputs]
    motions += [one for one in (record.yaw_rate, record.sway) if one is not None]
    if record.heading is not None:
        motions.append(np.diff(unwrap_angle(record.heading), prepend=math.nan))
    wholes = {path: fill_inputs(record, inputs, path) for path in INPUT_PATHS}
    evidence = 0.0
    for motion in motions:
        squares, count = {}, 0
        for path in INPUT_PATHS:
            along = replace(wholes[path], between_readings=path)
            acting = np.column_stack([along.mean_ahead(along.column(name)) for name in inputs])
            rows = np.column_stack([motion[1:-1], motion[:-2], acting[1:-1], acting[:-2]])
            rows = np.column_stack([rows, np.ones(len(rows)), motion[2:]])
            rows = rows[np.isfinite(rows).all(axis=1)]
            count = len(rows)
            if count >= MIN_SAMPLES:
                solution = np.linalg.lstsq(rows[:, :-1], rows[:, -1], rcond=None)[0]
                squares[path] = float(np.sum((rows[:, -1] - rows[:, :-1] @ solution) ** 2))
        if squares and min(squares.values()) > 0.0:
            evidence += 0.5 * count * math.log(squares["straight"] / squares["step"])
    return evidence


def examine_columns(record: Record) -> list[Finding]:
    """Return what may mislead in the columns of a user's own system; ConfigError if unusable."""
    problems, findings = [], [*record.findings, *_intervals(record)]
    for name, values in record.plain.items():
        missing = _missing(record, name, values)
        if missing and np.isnan(values).all():
            problems.append(f"{record.source}: {replace(missing, text='has no value')}")
        elif missing:
            findings.append(missing)
        elif np.ptp(values) == 0.0:
            findings.append(record.finding(name, f"is {values[0]:g} in all rows"))
    raise_problems(problems)
    return findings


def _missing(record: Record, name: str, values: Numbers) -> Finding | None:
    """Return how many values of a column are missing; None if none is.

    A cell of each second row or a rarer one is as often as it was read: then its gaps are told.
    """
    missing = np.isnan(values)
    if rows_between(values) >= RARE_ROWS and (known := np.flatnonzero(~missing)).size:
        return next(find_gaps(record, name, known), None)
    text = f"{np.count_nonzero(missing)} of {len(values)} values are missing, the first here"
    return record.finding(name, text, np.argmax(missing)) if missing.any() else None


def unwrap_heading(record: Record) -> Record:
    """Return the record with a heading that does not jump by whole turns."""
    if record.heading is None:
        return record
    return replace(record, heading=unwrap_angle(record.heading))


def _time_problems(record: Record) -> Iterator[Finding]:
    """Yield that samples are so far apart that the times are in another unit."""
    if record.interval > MAX_INTERVAL_S:
        text = f"{record.interval:g} s from row to row, and no trial is read so rarely: "
        yield record.finding("t", text + 'are these ms or us? say unit = "us"', 1)


def _rudder_problems(record: Record) -> Iterator[Finding]:
    """Yield why the rudder cannot be an input."""
    rudder = record.column("rudder")
    if float(np.std(rudder)) < STILL_RUDDER_RAD:
        held = math.degrees(float(np.mean(rudder)))
        text = f"stands at {held:g} deg in all rows: nothing is learnt from a rudder at rest"
        yield record.finding("rudder", text)


def find_strange_rate(record: Record) -> Iterator[Finding]:
    """Yield that a yaw rate, summed, is not the heading."""
    record = at_readings(record)
    if record.heading is None or record.yaw_rate is None:
        return
    rate, heading = record.yaw_rate, unwrap_angle(record.heading)
    steps = np.diff(record.t, append=record.t[-1])
    known = np.isfinite(rate) & np.isfinite(heading)
    third = np.diff(rate, 3)
    if min(np.count_nonzero(known), np.count_nonzero(np.isfinite(third))) < MIN_SAMPLES:
        return
    summed = np.cumsum(np.nan_to_num(rate) * steps)
    apart = record.t - record.t[0]
    both = (np.polyval(np.polyfit(apart[known], one[known], 1), apart) for one in (summed, heading))
    by_rate, turned = (one - line for one, line in zip((summed, heading), both, strict=True))
    # what white errors of the rate, as their third differences show them, add up to
    rough = float(np.nanstd(third)) / math.sqrt(20.0)
    wander = rough * record.interval * math.sqrt(len(rate))
    if float(np.std(turned[known])) < SURE_STANDARD_ERRORS * wander:
        return
    together = float(np.corrcoef(by_rate[known], turned[known])[0, 1])
    share = together * float(np.std(by_rate[known]) / np.std(turned[known]))
    if together > math.sqrt(0.5) and 0.5 < share < 2.0:
        return
    text = f"summed it is {share:.2g} of the change of {record.name('heading')}: "
    yield record.finding("yaw_rate", text + "it is the rate of another axis, such as roll")


def _gain(y: Numbers, x: Numbers) -> float | None:
    """Return the factor between two series; None if they have less than half in common."""
    good = ~np.isnan(y) & ~np.isnan(x)
    if np.count_nonzero(good) < MIN_SAMPLES:
        return None
    y, x = y[good] - y[good].mean(), x[good] - x[good].mean()
    size = math.sqrt(float(x @ x) * float(y @ y))
    if (float(x @ y) / size if size > 0.0 else 0.0) ** 2 < 0.5:
        return None
    # both are noisy: the geometric mean of the two regressions favours neither
    return math.copysign(float(np.std(y) / np.std(x)), float(x @ y))


def _intervals(record: Record) -> Iterator[Finding]:
    """Yield the gaps in time, and that the interval varies."""
    step, usual = np.diff(record.t), record.interval
    gaps = np.flatnonzero(step > GAP_READINGS * usual)
    if gaps.size:
        first = int(gaps[0])
        more = f"; {gaps.size - 1} more such gaps" if gaps.size > 1 else ""
        text = f"{step[first]:g} s have passed, the interval is {usual:g} s{more}"
        text += "; where the clock jumped, fit one side of it: from_s, to_s"
        yield record.finding("t", text, first + 1)
    others = np.abs(step / usual - np.maximum(np.round(step / usual), 1.0)) > EVEN_STEP_TOLERANCE
    if others.any():
        index = int(np.argmax(others))
        share = f"{np.count_nonzero(others)} of {step.size}"
        text = f"{step[index]:g} s have passed, not {usual:g} s: the interval varies ({share})"
        yield record.finding("t", text, index + 1)


def _missing_outputs(record: Record) -> Iterator[Finding]:
    """Yield which outputs have missing values."""
    for channel in MOTION_CHANNELS:
        values = getattr(record, channel)
        if values is None or (finding := _missing(record, channel, values)) is None:
            continue
        if np.isnan(values).all():
            raise ConfigError(f"{record.source}: {record.name(channel)}: has no value at all")
        yield finding


def _jumps(record: Record) -> Iterator[Finding]:
    """Yield where the heading jumps by a turn: the source keeps it within one turn."""
    if record.heading is None:
        return
    jumps = np.abs(np.diff(record.heading)) > HALF_TURN
    if jumps.any():
        text = f"jumps by more than half a turn ({np.count_nonzero(jumps)} times): unwrapped"
        yield record.finding("heading", text, np.argmax(jumps) + 1)
    largest = float(np.nanmax(np.abs(record.heading)))
    if largest > 100.0 * math.tau:
        text = f"{largest:g} rad is {largest / math.tau:.0f} turns: are these degrees?"
        yield record.finding("heading", text, np.nanargmax(np.abs(record.heading)))


def follows_motion(record: Record) -> float | None:
    """Return the share of the rudder that heading and yaw rate explain [-]. None if unknown.

    A helmsman or autopilot without an experiment of its own leaves it near 1.
    """
    rate = record.turning
    if rate is None:
        return None
    rate, rudder = np.nan_to_num(rate), record.column("rudder")
    turned = np.concatenate([[0.0], np.cumsum(rate[:-1] * np.diff(record.t))])
    heading = turned if record.heading is None else np.unwrap(np.nan_to_num(record.heading))
    since = record.t - record.t[0]
    # an autopilot steers by rate, heading and its integral, less the course ordered, whose parts
    # the constant and the time are
    wound = np.concatenate([[0.0], np.cumsum(heading[:-1] * np.diff(record.t))])
    regressors = np.column_stack([np.ones_like(since), since, rate, heading, wound])
    regressors /= np.maximum(np.abs(regressors).max(axis=0), 1e-300)
    solution, *_ = np.linalg.lstsq(regressors, rudder, rcond=None)
    return 1.0 - float(np.var(rudder - regressors @ solution) / np.var(rudder))


def _find_feedback(record: Record) -> Iterator[Finding]:
    """Yield that the rudder does nothing but follow the motion."""
    share = follows_motion(record) if len(record.t) >= MIN_SAMPLES else None
    if share is not None and share > FEEDBACK_SHARE:
        text = f"{share:.1%} of it follows from heading and yaw rate: a closed loop without an "
        doubt = "experiment; what is fitted may be the helmsman's law, not the ship"
        yield record.finding("rudder", text + doubt)


def _constant_outputs(record: Record) -> Iterator[Finding]:
    """Yield outputs that never change."""
    for channel in MOTION_CHANNELS:
        values = getattr(record, channel)
        if values is not None and channel != "speed" and _is_constant(values):
            yield record.finding(channel, "is the same in all rows: is it recorded?")


def _frozen(record: Record) -> Iterator[Finding]:
    """Yield where the heading stands still for long while the rudder is over."""
    if record.heading is None or _is_constant(record.heading):
        return
    rudder, heading = record.column("rudder"), record.heading
    usual, spread = float(rudder.mean()), float(np.std(rudder))
    ends = np.flatnonzero(np.diff(heading, append=np.inf) != 0.0)
    for first, last in zip(np.append(0, ends[:-1] + 1), ends, strict=True):
        seconds, helm = record.t[last] - record.t[first], rudder[first : last + 1]
        works = float(np.mean(np.abs(helm - usual))) > 0.5 * spread
        if seconds >= FROZEN_S and last - first >= FROZEN_ROWS and works:
            text = f"stands still for {seconds:g} s, to row {record.row(int(last))}, while "
            remedy = f"{record.name('rudder')} works: frozen? leave these readings empty"
            yield record.finding("heading", text + remedy, first)


def _is_constant(values: Numbers) -> bool:
    """Return whether all values that there are are one and the same."""
    return bool(np.nanmax(values) == np.nanmin(values))


def _spikes(record: Record) -> Iterator[Finding]:
    """Yield readings that stand out from both neighbours: outliers."""
    for channel in (*MOTION_CHANNELS, *POSITION_CHANNELS):
        values = getattr(record, channel)
        if values is None:
            continue
        own = record
        if rows_between(values) >= RARE_ROWS:
            own = record.part(np.isfinite(values))
            values = own.values[channel]
        values = unwrap_angle(values) if channel in ANGLE_CHANNELS else values
        steps = np.abs(np.diff(values))
        off = values[1:-1] - 0.5 * (values[2:] + values[:-2])
        if np.count_nonzero(np.isfinite(off)) < MIN_SAMPLES:  # too few with both neighbours
            continue
        least = np.nanmin(steps, where=steps > 0.0, initial=np.inf)  # of a rounded reading
        limit = SPIKE_SCATTERS * max(1.5 * float(np.nanmedian(np.abs(off))), float(least))
        # a lone reading takes half of its error to either side, a ship that turns does not
        beside = -0.25 * np.abs(off[1:-1]) > np.sign(off[1:-1]) * np.stack([off[2:], off[:-2]])
        rows = np.flatnonzero((np.abs(off[1:-1]) > limit) & beside.all(axis=0)) + 2
        if rows.size:
            times = SPIKE_SCATTERS * abs(off[rows[0] - 1]) / limit
            more = f"; {rows.size - 1} more" if rows.size > 1 else ""
            text = f"stands out from its neighbours by {times:.0f} times the usual scatter{more}: "
            remedy = "an outlier? [model] reject = 1e-6 leaves such out"
            yield own.finding(channel, text + remedy, rows[0])


def _sizes(record: Record, ship: Ship) -> Iterator[Finding]:
    """Yield sizes that no ship of that length and speed has."""
    rate, sway = record.turning, record.sway
    if rate is None:
        return
    if sway is not None and (gain := _gain(sway, rate)) is not None:
        ahead = -gain / ship.length_m
        if not PIVOT_LENGTHS[0] < ahead < PIVOT_LENGTHS[1]:
            unit = SPEED_MISTAKES[2 if ahead < 0.0 else 0 if ahead < PIVOT_LENGTHS[0] else 1][1]
            text = f"would turn the ship about a point {ahead:.2g} lengths ahead of the middle"
            yield record.finding("sway", f"{text}: {unit}")
    bow, stern, apart = record.bow_sway, record.stern_sway, ship.bow_log_m
    if bow is not None and stern is not None and apart and ship.stern_log_m:
        gain = _gain(bow - stern, rate)
        share = gain and gain / (apart + ship.stern_log_m)
        yield from _mistaken(record, "bow_sway", share, "stern_sway")


def _mistaken(
    record: Record, channel: str, share: float | None, other: str = ""
) -> Iterator[Finding]:
    """Yield the mistake that makes a speed ``share`` times what it must be."""
    for factor, text in SPEED_MISTAKES if share else ():
        if share and 0.75 < share / factor < 1.33:
            names = " and ".join(record.name(one) for one in (channel, other) if one)
            yield Finding(names, 0, f"{share:.2g} of what the ship's numbers say: {text}")

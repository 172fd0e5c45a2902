"""What the channels of a record say of each other's signs.

Turning against rudder, pitching against planes, climb against pitch, a yaw rate against the
heading. Each is regressed on first differences or means over a share of the time in which the boat
goes her own length: second differences of readings are noise. Each channel has its own readings.
How far she turns tells a rudder in radians. Signs of roll, bow planes and rates of roll and pitch
no such test tells of all boats: the fit itself does (``boat/search``).
"""

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers

SURE_ERRORS: Final = 3.0  # standard errors of a sign
SURE_CORRELATION: Final = 0.9  # [-]
SURE_CLIMB: Final = 5.0  # standard errors of the climb by pitch
STEERED_SHARE: Final = 0.06  # [-] of its limit: a rudder that moves less follows the heading
FLOWN_PLANES_RAD: Final = math.radians(1.5)  # [rad] rms: less only keeps a depth, likewise
TURNING_WINDOWS: Final = (0.15, 0.3, 0.6)  # [L/U] half of a mean; wider ones turn signs
PITCHING_WINDOWS: Final = (0.1, 0.2, 0.4)  # [L/U] likewise
TURN_LENGTHS, CLIMB_LENGTHS = 6.0, 2.0  # [L/U] of a steady turn, and of a climb
MAX_GAIN: Final = 8.0  # [U2/L2] of turning by rudder: drawn boats have 0.1 to 5
MIN_TURN_RAD: Final = math.radians(6.0)  # [rad] that heading and rate are compared over
MIN_STEADY_RAD: Final = math.radians(2.0)  # [rad] by which a rudder's mean moves
MAX_PITCH_RAD: Final = 1.5  # [rad]
MIN_READINGS: Final = 40
ABOVE_WATER_M: Final = -1.0  # [m] of depth
SIGNED_CHANNELS: Final = ("rudder", "heading", "yaw_rate", "stern", "pitch", "depth")


class Channel(NamedTuple):
    """The readings of one instrument, at its own times."""

    t: Numbers  # [s]
    values: Numbers  # SI


class SignTest(NamedTuple):
    """What was found of channels' signs: ``found`` is above 0 if they agree."""

    fault: str  # in words, where they do not
    channels: tuple[str, ...]  # turning one of them turns it
    found: float
    unit: str = "standard errors"
    gain: float = 0.0  # [U2/L2] of turning by rudder

    @property
    def evidence(self) -> str:
        """Return the fault with how much speaks for it."""
        return f"{self.fault} ({abs(self.found):.2g} {self.unit})"


class Course(NamedTuple):
    """What a boat is, to judge her by."""

    length: float  # [m]
    speed: float  # [m/s]
    rudder_limit: float  # [rad]


def judge_signs(channels: Mapping[str, Channel], boat: Course) -> Iterator[SignTest]:
    """Yield the tests of signs that the channels allow, each of them sure."""
    ahead = next((channels[one] for one in ("speed", "command_speed") if one in channels), None)
    pace = boat.speed if ahead is None else max(float(np.median(np.abs(ahead.values))), 0.05)
    span = boat.length / pace
    have = channels.keys()
    if {"heading", "rudder"} <= have and any(told := _turning(channels, boat, span)):
        unit = "standard errors" if abs(told[0]) > 1.0 else "correlation"
        fault = "positive rudder turns her to starboard"
        yield SignTest(fault, ("rudder", "heading"), told[0], unit, told[1])
    if {"heading", "yaw_rate"} <= have and (found := _rate_by_heading(channels)):
        fault = "the yaw rate goes against the heading"
        yield SignTest(fault, ("yaw_rate", "heading"), found, "correlation")
    if {"depth", "pitch"} <= have and ahead is not None:
        if found := _climb(channels, ahead, span):
            yield SignTest("she climbs with her bow down", ("pitch", "depth"), found)
        if "stern" in have and (found := _pitching(channels, ahead, span)):
            yield SignTest("positive stern planes raise her bow", ("stern", "pitch"), found)
    if "depth" in have and (middle := float(np.median(channels["depth"].values))) < ABOVE_WATER_M:
        yield SignTest("she sails above the water", ("depth",), middle, "m")


def explain_signs(tests: Sequence[SignTest]) -> list[tuple[str, ...]]:
    """Return the fewest channels to turn, so that all tests agree: each choice of them."""
    names = [one for one in SIGNED_CHANNELS if any(one in test.channels for test in tests)]
    for count in range(len(names) + 1):
        found = [
            turned
            for turned in itertools.combinations(names, count)
            if all(
                test.found * (-1) ** len({*turned}.intersection(test.channels)) > 0.0
                for test in tests
            )
        ]
        if found:
            return found
    return []


def _laid(*channels: Channel) -> tuple[Numbers, list[Numbers]]:
    """Return even times [s], at the interval of the rarest channel, and the channels there."""
    step = max(float(np.median(np.diff(one.t))) for one in channels)
    t = np.arange(max(one.t[0] for one in channels), min(one.t[-1] for one in channels), step)
    return t, [np.interp(t, *one) for one in channels]


def _integral(t: Numbers, values: Numbers) -> Numbers:
    steps = 0.5 * (values[1:] + values[:-1]) * np.diff(t)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _mean(values: Numbers, half: int) -> Numbers:
    """Return means over ``half`` rows to either side."""
    return np.convolve(values, np.full(2 * half + 1, 1.0 / (2 * half + 1)), "valid")


def _errors(columns: Sequence[Numbers], values: Numbers, index: int) -> tuple[float, float, float]:
    """Return a regression's coefficient in standard errors, 0 of none, as it is, its correlation.

    Errors go together: by their correlation with the one before they count as fewer.
    """
    regressors = np.column_stack(columns)
    sizes = np.maximum(np.abs(regressors).max(axis=0), 1e-300)
    regressors = regressors / sizes
    solution, *_ = np.linalg.lstsq(regressors, values, rcond=None)
    left = values - regressors @ solution
    spread = float(left[1:].std() * left[:-1].std())
    pairs = float(np.mean((left[1:] - left[1:].mean()) * (left[:-1] - left[:-1].mean())))
    lag = min(max(pairs / spread, 0.0), 0.99) if spread > 0.0 else 0.0
    free = max(len(values) * (1.0 - lag) / (1.0 + lag) - regressors.shape[1], 1.0)
    square = float(left @ left * np.linalg.pinv(regressors.T @ regressors)[index, index])
    variance, together = square / free, math.hypot(solution[index], math.sqrt(square))
    sure = float(solution[index]) / math.sqrt(variance) if variance > 0.0 else 0.0
    return sure, float(solution[index] / sizes[index]), abs(solution[index]) / (together or 1.0)


def _turning(channels: Mapping[str, Channel], boat: Course, span: float) -> tuple[float, float]:
    """Return how surely a positive rudder turns to port, and how much [U2/L2]; 0 where unsure.

    r = G (integral of rudder) - heading / T + drift, all as means; else by a steady turn.
    """
    t, (heading, rudder) = _laid(channels["heading"], channels["rudder"])
    most = float(np.quantile(np.abs(channels["rudder"].values), 0.995))
    if len(t) < MIN_READINGS or most < 1e-9:
        return 0.0, 0.0
    flown = most >= STEERED_SHARE * boat.rudder_limit
    step, run = t[1] - t[0], _integral(t, rudder - rudder.mean())
    found, gain = _power(t, heading, [run, heading - heading[0]], TURNING_WINDOWS, span)
    if found and (flown or gain > MAX_GAIN):
        return -found, gain
    lag, run = max(2, round(TURN_LENGTHS * span / step)), _integral(t, rudder)
    if not flown or len(t) <= 6 * lag or np.std(rudder) <= MIN_STEADY_RAD:
        return 0.0, 0.0
    together = float(np.corrcoef(heading[lag:] - heading[:-lag], run[lag:] - run[:-lag])[0, 1])
    return (-together if abs(together) > SURE_CORRELATION else 0.0), 0.0


def _power(
    t: Numbers, angle: Numbers, columns: Sequence[Numbers], shares: Sequence[float], span: float
) -> tuple[float, float]:
    """Return how surely an angle's rate rises with the first column [standard errors]; 0: unsure.

    And how much [U2/L2], where hardly anything else moves her; else 0. All are
    means over the same rows, so that these leave no lag; the surest means count.
    """
    step, found = t[1] - t[0], [(0.0, 0.0, 0.0)]
    for half in sorted({max(1, round(share * span / step)) for share in shares}):
        if len(t) >= 12 * half + MIN_READINGS:
            rate = (angle[2 * half :] - angle[: -2 * half]) / (2 * half * step)
            means = [_mean(one, half) for one in columns if np.ptp(one) > 0.0]
            found.append(_errors([*means, t[half:-half] - t[0], np.ones(len(rate))], rate, 0))
    sure, power, together = max(found, key=lambda one: abs(one[0]))
    gain = abs(power) * span**2 if together > SURE_CORRELATION else 0.0
    return sure if abs(sure) > SURE_ERRORS else 0.0, gain


def _rate_by_heading(channels: Mapping[str, Channel]) -> float:
    """Return how surely a yaw rate is that of the heading [-] a correlation; 0: nothing tells."""
    t, (heading, rate) = _laid(channels["heading"], channels["yaw_rate"])
    if {"roll", "pitch", "pitch_rate"} <= channels.keys():  # the rate is about the boat's own axis
        roll, pitch, q = (np.interp(t, *channels[one]) for one in ("roll", "pitch", "pitch_rate"))
        rate = (q * np.sin(roll) + rate * np.cos(roll)) / np.cos(np.clip(pitch, -1.4, 1.4))
    turned = _integral(t, rate)
    if len(t) < MIN_READINGS or max(np.ptp(heading), np.ptp(turned)) < MIN_TURN_RAD:
        return 0.0

    def of_lag(lag: int) -> float:
        one, other = heading[lag:] - heading[:-lag], turned[lag:] - turned[:-lag]
        moved = np.ptp(one) > 0.0 and np.ptp(other) > 0.0
        return float(np.corrcoef(one, other)[0, 1]) if moved else 0.0

    best = max((of_lag(max(1, len(t) // part)) for part in (80, 40, 20, 10, 5)), key=abs)
    return best if abs(best) > SURE_CORRELATION else 0.0


def _climb(channels: Mapping[str, Channel], ahead: Channel, span: float) -> float:
    """Return how surely depth falls with the bow up, its planes and turns beside it; 0: unsure.

    A boat heaves by her planes, by pitching and in turns: without these beside it, depth by pitch
    tells the wrong sign of a boat that keeps her depth by two pairs of planes.
    """
    surfaces = [channels[one] for one in ("stern", "bow") if one in channels]
    t, (depth, pitch, *planes) = _laid(channels["depth"], channels["pitch"], *surfaces)
    if len(t) < MIN_READINGS:
        return 0.0
    speed, step = np.interp(t, *ahead), t[1] - t[0]
    dived = -speed * np.sin(np.clip(pitch, -MAX_PITCH_RAD, MAX_PITCH_RAD))
    columns = [_integral(t, dived), pitch, t - t[0]]
    columns += [_integral(t, speed * (one - np.median(one))) for one in planes]
    if "heading" in channels:
        columns.append(_integral(t, _turn_squares(channels, t, span)))
    columns = [one for one in columns if np.ptp(one) > 0.0]
    lag = min(max(2, round(CLIMB_LENGTHS * span / step)), len(t) // 6)
    found, *_ = _errors([one[lag:] - one[:-lag] for one in columns], depth[lag:] - depth[:-lag], 0)
    return found if abs(found) > SURE_CLIMB else 0.0


def _turn_squares(channels: Mapping[str, Channel], t: Numbers, span: float) -> Numbers:
    """Return the square of the yaw rate at times, smoothed."""
    heading = np.interp(t, *channels["heading"])
    half = min(max(1, round(0.5 * span / (t[1] - t[0]))), len(t) // 10)
    rate = np.zeros(len(t))
    rate[half:-half] = (heading[2 * half :] - heading[: -2 * half]) / (t[2 * half] - t[0])
    return rate * rate


def _pitching(channels: Mapping[str, Channel], ahead: Channel, span: float) -> float:
    """Return how surely positive stern planes put the bow down; 0 where nothing tells."""
    bow = [channels["bow"]] if "bow" in channels else []
    t, (pitch, depth, stern, *others) = _laid(
        channels["pitch"], channels["depth"], channels["stern"], *bow
    )
    if len(t) < MIN_READINGS or np.std(stern) < FLOWN_PLANES_RAD:
        return 0.0
    dived = np.interp(t, *ahead) * np.sin(np.clip(pitch, -MAX_PITCH_RAD, MAX_PITCH_RAD))
    columns = [_integral(t, one - one.mean()) for one in (stern, *others, pitch)]
    columns += [pitch, depth - depth[0] + _integral(t, dived)]
    if "heading" in channels:
        columns.append(_integral(t, _turn_squares(channels, t, span)))
    return -_power(t, pitch, columns, PITCHING_WINDOWS, span)[0]

"""How one channel of a record follows from others: turning, pitching and climbing.

Each is regressed on first differences, or means, over a share of the time in which she goes her own
length; second differences of readings are noise. Each channel has its own readings.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Final, NamedTuple

import numpy as np

from trainer.core.kernel import Numbers

SURE_ERRORS: Final = 3.0  # standard errors of a sign
SURE_CLIMB: Final = 5.0  # standard errors of the climb by pitch
FLOWN_PLANES_RAD: Final = math.radians(1.5)  # [rad] rms: less only keeps a depth, likewise
CLIMB_LENGTHS: Final = 2.0  # [L/U] of a climb
PITCHING_WINDOWS: Final = (0.1, 0.2, 0.4)  # [L/U] likewise
MAX_PITCH_RAD: Final = 1.5  # [rad]
MIN_READINGS: Final = 40


class Signal(NamedTuple):
    """The readings of one instrument, at its own times."""

    t: Numbers  # [s]
    values: Numbers  # SI


def lay_together(*channels: Signal) -> tuple[Numbers, list[Numbers]]:
    """Return even times [s], at the interval of the rarest channel, and the channels there."""
    step = max(float(np.median(np.diff(one.t))) for one in channels)
    t = np.arange(max(one.t[0] for one in channels), min(one.t[-1] for one in channels), step)
    return t, [np.interp(t, *one) for one in channels]


def integrate(t: Numbers, values: Numbers) -> Numbers:
    """Return the integral over time by trapezoids, from 0 (n,)."""
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


def turning_power(
    t: Numbers,
    angle: Numbers,
    columns: Sequence[Numbers],
    shares: Sequence[float],
    span: float | None,
) -> tuple[float, float, float]:
    """Return how surely an angle's rate rises with the first column [standard errors]; 0: unsure.

    How much [U2/L2], or as it is without a ``span`` [s] of one length; and how far nothing else
    moves her, a correlation. All are means over the same rows, so that these leave no lag; the
    surest means count.
    """
    step, found = t[1] - t[0], [(0.0, 0.0, 0.0)]
    halves = [share * span / step for share in shares] if span else (1, 2, 4, 8, len(t) / 200)
    for half in sorted({max(1, round(one)) for one in halves}):
        if len(t) >= 12 * half + MIN_READINGS:
            rate = (angle[2 * half :] - angle[: -2 * half]) / (2 * half * step)
            means = [_mean(one, half) for one in columns if np.ptp(one) > 0.0]
            found.append(_errors([*means, t[half:-half] - t[0], np.ones(len(rate))], rate, 0))
    sure, power, together = max(found, key=lambda one: abs(one[0]))
    sized = abs(power) * (span or 1.0) ** 2
    return (sure if abs(sure) > SURE_ERRORS else 0.0), sized, together


def climb_by_pitch(
    channels: Mapping[str, Signal], ahead: Signal, span: float
) -> tuple[float, float]:
    """Return how surely depth falls with the bow up, 0: unsure, and by what factor.

    A boat heaves by her planes, by pitching and in turns: without these beside it, depth by pitch
    tells the wrong sign of a boat that keeps her depth by two pairs of planes.
    """
    surfaces = [channels[one] for one in ("stern", "bow") if one in channels]
    t, (depth, pitch, *planes) = lay_together(channels["depth"], channels["pitch"], *surfaces)
    if len(t) < MIN_READINGS:
        return 0.0, 0.0
    speed, step = np.interp(t, *ahead), t[1] - t[0]
    dived = -speed * np.sin(np.clip(pitch, -MAX_PITCH_RAD, MAX_PITCH_RAD))
    columns = [integrate(t, dived), pitch, t - t[0]]
    columns += [integrate(t, speed * (one - np.median(one))) for one in planes]
    if "heading" in channels:
        columns.append(integrate(t, _turn_squares(channels, t, span)))
    columns = [one for one in columns if np.ptp(one) > 0.0]
    lag = min(max(2, round(CLIMB_LENGTHS * span / step)), len(t) // 6)
    differences = [one[lag:] - one[:-lag] for one in columns]
    sure, factor, _ = _errors(differences, depth[lag:] - depth[:-lag], 0)
    return (sure if abs(sure) > SURE_CLIMB else 0.0), factor


def _turn_squares(channels: Mapping[str, Signal], t: Numbers, span: float) -> Numbers:
    """Return the square of the yaw rate at times, smoothed."""
    heading = np.interp(t, *channels["heading"])
    half = min(max(1, round(0.5 * span / (t[1] - t[0]))), len(t) // 10)
    rate = np.zeros(len(t))
    rate[half:-half] = (heading[2 * half :] - heading[: -2 * half]) / (t[2 * half] - t[0])
    return rate * rate


def pitch_by_planes(channels: Mapping[str, Signal], ahead: Signal, span: float) -> float:
    """Return how surely positive stern planes put the bow down; 0 where nothing tells."""
    bow = [channels["bow"]] if "bow" in channels else []
    t, (pitch, depth, stern, *others) = lay_together(
        channels["pitch"], channels["depth"], channels["stern"], *bow
    )
    if len(t) < MIN_READINGS or np.std(stern) < FLOWN_PLANES_RAD:
        return 0.0
    dived = np.interp(t, *ahead) * np.sin(np.clip(pitch, -MAX_PITCH_RAD, MAX_PITCH_RAD))
    columns = [integrate(t, one - one.mean()) for one in (stern, *others, pitch)]
    columns += [pitch, depth - depth[0] + integrate(t, dived)]
    if "heading" in channels:
        columns.append(integrate(t, _turn_squares(channels, t, span)))
    return -turning_power(t, pitch, columns, PITCHING_WINDOWS, span)[0]

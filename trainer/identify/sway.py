"""Sway velocity from a track over the ground and the heading, section 11."""

import math
from typing import Final

import numpy as np

from trainer.config import ConfigError
from trainer.core.kernel import Numbers

SPENCER: Final = np.array([-3, -6, -5, 3, 21, 46, 67, 74, 67, 46, 21, 3, -5, -6, -3]) / 320.0
EVEN: Final = 1e-3  # [-] of the interval, that sampling may vary


def derivative(series: Numbers, interval: float) -> Numbers:
    """Return the rate of change by five points, NaN at the two samples of each end.

    f' = [f(-2h) - 8 f(-h) + 8 f(h) - f(2h)]/(12 h).
    """
    rate = np.full_like(series, np.nan)
    rate[2:-2] = (series[:-4] - 8.0 * series[1:-3] + 8.0 * series[3:-1] - series[4:]) / (
        12.0 * interval
    )
    return rate


def smoothed(series: Numbers) -> Numbers:
    """Return the series by Spencer's 15 points, exact for cubics, NaN at seven of each end."""
    found = np.full_like(series, np.nan)
    if len(series) >= len(SPENCER):
        found[7:-7] = np.convolve(series, SPENCER, mode="valid")
    return found


def along(east: Numbers, north: Numbers, course: float) -> tuple[Numbers, Numbers]:
    """Return x0 along a course [rad] and y0 to starboard of it, of a track east and north."""
    s, c = math.sin(course), math.cos(course)
    return north * c + east * s, east * c - north * s


def sway_of_track(x0: Numbers, y0: Numbers, turned: Numbers, interval: float) -> Numbers:
    """Return v = y0' cos - x0' sin of the angle ``turned`` [rad] from the axis x0, over ground."""
    x_rate, y_rate = derivative(x0, interval), derivative(y0, interval)
    return np.asarray(y_rate * np.cos(turned) - x_rate * np.sin(turned))


def even_interval(t: Numbers, source: str) -> float:
    """Return the interval [s] of even samples; ConfigError naming the row where they are not."""
    steps = np.diff(t)
    usual = float(np.median(steps))
    uneven = np.abs(steps - usual) > EVEN * usual
    if uneven.any():
        row = int(np.argmax(uneven)) + 1
        raise ConfigError(
            f"{source}: sample {row + 1}: {steps[row - 1]:g} s after the one before, the interval "
            f"is {usual:g} s: a derivative needs an even interval"
        )
    return usual

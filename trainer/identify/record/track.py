"""Sway velocity from a track over the ground and the heading.

``study`` and ``decca`` make a record's sway by it. A track in a plane grid, or of latitudes and
longitudes on the ellipsoid of WGS 84. There the velocity north is M dphi/dt, east N cos(phi)
dlambda/dt, with the radii of curvature M in the meridian and N across it: J. P. Snyder, Map
Projections - A Working Manual, U.S. Geological Survey Professional Paper 1395 (1987), pages 24-25;
the ellipsoid's numbers are of NIMA TR8350.2.
"""

from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.config.files import ConfigError
from trainer.config.tables import EVEN_STEP_TOLERANCE
from trainer.core.kernel import Numbers
from trainer.identify.record.measurements import (
    POSITION_CHANNELS,
    Finding,
    Record,
    unwrap_angle,
)
from trainer.identify.record.readings import at_readings

EQUATOR_RADIUS_M: Final = 6_378_137.0  # [m] of WGS 84
EARTH_FLATTENING: Final = 1.0 / 298.257223563  # [-] likewise
SPENCER_WEIGHTS: Final = (
    np.array([-3, -6, -5, 3, 21, 46, 67, 74, 67, 46, 21, 3, -5, -6, -3]) / 320.0
)


def derivative(series: Numbers, interval: float) -> Numbers:
    """Return the rate of change by five points. Two samples at each end are NaN.

    f' = [f(-2h) - 8 f(-h) + 8 f(h) - f(2h)]/(12 h).
    """
    rate = np.full_like(series, np.nan)
    rate[2:-2] = (series[:-4] - 8.0 * series[1:-3] + 8.0 * series[3:-1] - series[4:]) / (
        12.0 * interval
    )
    return rate


def smooth_spencer(series: Numbers) -> Numbers:
    """Return the series by Spencer's 15 points, exact for cubics. Seven at each end are NaN.

    ``trainer ship decca --smooth`` takes the jitter of lanes out so.
    """
    smoothed = np.full_like(series, np.nan)
    if len(series) >= len(SPENCER_WEIGHTS):
        smoothed[7:-7] = np.convolve(series, SPENCER_WEIGHTS, mode="valid")
    return smoothed


def resolve_along(
    east: Numbers | float, north: Numbers | float, course: Numbers | float
) -> tuple[Numbers, Numbers]:
    """Return the parts of (east, north) along a course [rad] and to starboard of it.

    A velocity so becomes speed ahead and sway.
    """
    s, c = np.sin(course), np.cos(course)
    return np.asarray(north * c + east * s), np.asarray(east * c - north * s)


def even_interval(t: Numbers, source: str) -> float:
    """Return the interval [s] of even samples; ConfigError naming the row where they are not."""
    steps = np.diff(t)
    usual = float(np.median(steps))
    uneven = np.abs(steps - usual) > EVEN_STEP_TOLERANCE * usual
    if uneven.any():
        row = int(np.argmax(uneven)) + 1
        raise ConfigError(
            f"{source}: sample {row + 1}: {steps[row - 1]:g} s after the one before, the interval "
            f"is {usual:g} s: a derivative needs an even interval"
        )
    return usual


class Drift(NamedTuple):
    """The current [m/s] and the antenna's lever [m] between a track and the ship."""

    east: float
    north: float
    antenna: float  # forward of the point wanted


def through_water(
    east: Numbers, north: Numbers, heading: Numbers, rate: Numbers, drift: Drift
) -> tuple[Numbers, Numbers]:
    """Return velocity ahead and to starboard [m/s] from that of the antenna over the ground."""
    ahead, aside = resolve_along(east - drift.east, north - drift.north, heading)
    return ahead, aside - rate * drift.antenna


def ground_velocity(
    latitude: Numbers, longitude: Numbers, interval: float
) -> tuple[Numbers, Numbers]:
    """Return the velocity east and north [m/s] of a track of latitude and longitude [rad]."""
    squared = EARTH_FLATTENING * (2.0 - EARTH_FLATTENING)  # of the eccentricity
    inside = 1.0 - squared * np.sin(latitude) ** 2
    meridian = EQUATOR_RADIUS_M * (1.0 - squared) / inside**1.5
    across = EQUATOR_RADIUS_M / np.sqrt(inside)
    east = across * np.cos(latitude) * derivative(unwrap_angle(longitude), interval)
    return east, meridian * derivative(latitude, interval)


def _in_rows(record: Record, rows: NDArray[np.int64], values: Numbers) -> Numbers:
    """Return a column of the record that has values in some rows."""
    column = np.full(len(record.t), np.nan)
    column[rows] = values
    return column


def no_sway(record: Record, why: ConfigError) -> Finding:
    """Return that no sway is made of a record's track, and why."""
    text = str(why).removeprefix(f"{record.source}: ")
    return record.finding("latitude", f"no sway is made of this track: {text}")


def with_sway(record: Record, drift: Drift) -> Record:
    """Return a record with the sway of its track, and a yaw rate.

    A record without a track is returned unchanged, and a yaw rate that was recorded is kept.
    ConfigError if the record has no heading, uneven times, or a recorded sway beside the track.
    """
    if record.latitude is None or record.longitude is None:
        return record
    if record.sway is not None:
        raise ConfigError(f"{record.source}: has both {record.name('sway')} and a track: take one")
    record.column("heading")
    fixes = at_readings(record, POSITION_CHANNELS)
    interval = even_interval(fixes.t, record.source)
    heading = unwrap_angle(fixes.column("heading"))
    latitude, longitude = map(fixes.column, POSITION_CHANNELS)
    east, north = ground_velocity(latitude, longitude, interval)
    rate = derivative(heading, interval) if fixes.yaw_rate is None else fixes.yaw_rate
    _, sway = through_water(east, north, heading, rate, drift)
    if len(sway) < len(record.t):
        at = np.searchsorted(record.t, fixes.t)
        sway, rate = (_in_rows(record, at, values) for values in (sway, rate))
    yaw_rate = record.yaw_rate
    track = f"{record.name('latitude')} and {record.name('longitude')}"
    over = "" if drift.east or drift.north else ", over the ground"
    finding = Finding(track, 0, f"sway is that of this track{over}")
    names = {**record.names, "sway": f"sway of {track}"}
    if yaw_rate is None:
        names["yaw_rate"] = f"yaw rate of {record.name('heading')}"
    return replace(
        record,
        sway=sway,
        yaw_rate=rate if yaw_rate is None else yaw_rate,
        names=names,
        findings=(*record.findings, finding),
    )

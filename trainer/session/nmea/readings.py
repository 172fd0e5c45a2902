"""The fields of NMEA 0183 sentences at one tick, as text in their units.

``sentences`` has a table of them. Depth, heading and speed through the water are read off the
gauges, and are as wrong as these are. Position, track and speed over the ground are the navigation
system's. That has no casualty, nor have rate of turn, attitude, surfaces and turns: they are true.
"""

import math
from collections.abc import Callable, Mapping
from datetime import UTC, datetime, timedelta
from typing import Final, NamedTuple

from trainer.boat.world.bottom import keel_of
from trainer.core.ballast.tanks import BANKS, TANKS
from trainer.core.casualties import SOUNDER_RANGE
from trainer.core.surfaces import SURFACES
from trainer.io.chart import Chart
from trainer.io.nmea import date, latitude, longitude, number, time_of_day
from trainer.session.nmea.orders import BELL_POSITIONS
from trainer.session.stations.panels import (
    MEGAPASCAL,
    PERCENT,
    bell,
    course,
    reading,
    rpm,
)
from trainer.session.stations.view import Frame
from trainer.units import DEGREE, FOOT, KNOT

BALLAST_TANKS: Final = TANKS[:8]  # those that are not compartments
FATHOM_M: Final = 6.0 * FOOT  # [m]
KNOT_KM_H: Final = 1.852  # [km/h] in a knot
BELL_READINGS: Final = {
    bell.replace(" ", "-"): position for bell, position in BELL_POSITIONS.items()
}
# readers take no position without satellites: they are not of this trainer's world
CONSTANT_READINGS: Final = {
    "satellites": "08",
    "dilution": "1.0",
    "range": number(SOUNDER_RANGE, 1),
}
FARTHEST_M: Final = -9_999_999.9  # [m] from the origin


class NmeaReading(NamedTuple):
    """One number of a tick."""

    read: Callable[[Frame], object]  # no number: the boat lacks it, or nothing is ordered
    decimals: int
    widest: float  # as wide as the field can be: what a line has to have room for


def over_ground(frame: Frame) -> tuple[float, float]:
    """Return the speeds ahead and across over the ground [kn], to starboard positive."""
    north, east = frame.read("north_rate") or 0.0, frame.read("east_rate") or 0.0
    cosine, sine = math.cos(frame["psi"]), math.sin(frame["psi"])
    return (north * cosine + east * sine) / KNOT, (east * cosine - north * sine) / KNOT


def depth_shown(frame: Frame) -> float:
    """Return the depth [m] by the gauge, 0 above the water."""
    return max(frame.readings.depth, 0.0)


def shown(name: str, decimals: int, widest: float, size: float = 1.0) -> NmeaReading:
    """Return a reading of the boat, in a unit of that size [SI]."""
    return NmeaReading(reading(name, "", decimals, size).read, decimals, widest)


def towards(name: str, rounded: int, decimals: int, widest: float) -> NmeaReading:
    """Return a reading that is a direction, rounded before it is written."""
    return NmeaReading(course(name, rounded).read, decimals, widest)


# Angles are in degrees, speeds in knots, unless said otherwise.
READINGS: Final[Mapping[str, NmeaReading]] = {
    "north": NmeaReading(lambda f: f["x"], 1, FARTHEST_M),  # [m] of the origin
    "east": NmeaReading(lambda f: f["y"], 1, FARTHEST_M),  # [m]
    "track": towards("track", 2, 2, 359.99),  # over the ground
    "over_ground": shown("way", 2, 99.99, KNOT),
    "over_ground_kmh": shown("way", 2, 99.99 * KNOT_KM_H, KNOT / KNOT_KM_H),
    "across": NmeaReading(lambda f: f["v"] / KNOT, 2, -99.99),  # through the water
    "ahead_over_ground": NmeaReading(lambda f: over_ground(f)[0], 2, -99.99),
    "across_over_ground": NmeaReading(lambda f: over_ground(f)[1], 2, -99.99),
    "current": towards("set", 1, 1, 359.9),  # none where water stands still
    "drift": shown("drift", 2, 99.99, KNOT),
    "depth": shown("depth", 2, 9999.99),  # [m] by the gauge
    "altitude": shown("depth", 2, -9999.99, -1.0),  # [m]
    "depth_shown": NmeaReading(depth_shown, 2, 9999.99),
    "depth_feet": NmeaReading(lambda f: depth_shown(f) / FOOT, 1, 9999.99 / FOOT),
    "depth_fathoms": NmeaReading(lambda f: depth_shown(f) / FATHOM_M, 1, 9999.99 / FATHOM_M),
    "heading": towards("heading", 2, 2, 359.99),  # by the compass
    "speed": shown("speed", 2, -99.99, KNOT),  # by the log
    "speed_kmh": shown("speed", 2, -99.99 * KNOT_KM_H, KNOT / KNOT_KM_H),
    # the ground's depth below the transducer, which is at that of the body's origin
    "sounding": shown("sounding", 2, 9999.99),
    "sounding_feet": shown("sounding", 1, 9999.99 / FOOT, FOOT),
    "sounding_fathoms": shown("sounding", 1, 9999.99 / FATHOM_M, FATHOM_M),
    # [m] above the transducer, so that it is negative; none where there is no ground
    "keel": NmeaReading(lambda f: -keel_of(f.boat.vessel) if f["bottom"] else None, 1, -99.9),
    "pitch": NmeaReading(lambda f: math.degrees(f["theta"]), 2, -99.99),  # bow up positive
    "heel": NmeaReading(lambda f: math.degrees(f["phi"]), 2, -179.99),  # to starboard positive
    "turn": shown("turn_rate", 1, -9999.9, DEGREE / 60.0),  # to starboard positive
    "turn_per_second": shown("turn_rate", 3, -9999.9 / 60.0, DEGREE),
    "rpm": NmeaReading(lambda f: rpm(f, f["u_c"]), 1, -9999.9),
    "ordered_rpm": NmeaReading(lambda f: rpm(f, f.read("ordered_turns")), 1, -9999.9),
    "ordered_course": towards("ordered_course", 1, 2, 359.99),
    "ordered_depth": shown("ordered_depth", 2, 9999.99),  # [m]
    "ordered_speed": shown("ordered_speed", 2, -99.99, KNOT),
    **{  # right and rising positive
        name: shown(name, 2, -99.99, DEGREE)
        for surface in SURFACES
        for name in (surface, f"ordered_{surface}")
    },
    **{f"full_{tank}": shown(f"{tank}_full", 1, 100.0, PERCENT) for tank in BALLAST_TANKS},  # [%]
    **{f"air_{bank}": shown(bank, 2, 99.99, MEGAPASCAL) for bank in BANKS},  # [MPa]
}


def read_fields(frame: Frame, chart: Chart, start: datetime) -> dict[str, str]:
    """Return each field at a tick by its name.

    The session began at ``start``, UTC.
    """
    values = {name: each.read(frame) for name, each in READINGS.items()}
    position = chart.position(frame["x"], frame["y"])
    at = start + timedelta(seconds=frame.seconds)
    return describe_fields(values, frame.tick, at, position, str(bell(frame) or ""))


def describe_fields(
    values: Mapping[str, object], tick: int, at: datetime, position: tuple[float, float], rung: str
) -> dict[str, str]:
    """Return each field as text by its name; ``at`` is UTC, ``position`` in degrees."""
    texts = {
        name: number(float(value) if isinstance(value, float | int) else None, reading.decimals)
        for (name, reading), value in zip(READINGS.items(), values.values(), strict=True)
    }
    clock = time_of_day(at)
    texts |= {"tick": f"{tick}", "time": clock, "time_to_ms": f"{clock}0", "date": date(at)}
    texts["latitude"], texts["north_or_south"] = latitude(position[0])
    texts["longitude"], texts["east_or_west"] = longitude(position[1])
    texts["bell"] = BELL_READINGS.get(rung, "")
    texts |= CONSTANT_READINGS
    return texts | {
        f"{name}_status": "A" if texts[name] else "V" for name in ("rudder", "ordered_rudder")
    }


WIDEST_READINGS: Final = describe_fields(
    {name: reading.widest for name, reading in READINGS.items()},
    99_999_999,
    datetime(2099, 12, 31, 23, 59, 59, tzinfo=UTC),
    (-89.99, -179.99),
    "ahead-flank",
)

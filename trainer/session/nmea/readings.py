"""The fields of NMEA 0183 sentences at one tick, as text in their units.

``sentences`` has a table of them. Depth, heading and speed through the water are read off the
gauges, and are as wrong as these are. Position, track and speed over the ground are the navigation
system's. That has no casualty, nor have rate of turn, attitude, surfaces and turns: they are true.
"""

import math
from collections.abc import Callable, Mapping
from datetime import UTC, datetime, timedelta
from typing import Final, NamedTuple

from trainer.core.ballast.tanks import BANKS, TANKS
from trainer.core.casualties import SOUNDER_RANGE
from trainer.core.surfaces import SURFACES
from trainer.io.chart import Chart
from trainer.io.nmea import date, latitude, longitude, number, time_of_day
from trainer.session.nmea.orders import BELL_POSITIONS
from trainer.session.stations.channels import set_and_drift, way_made
from trainer.session.stations.panels import (
    bank_fields,
    bell,
    compass,
    ordered_course,
    ordered_depth,
    ordered_speed,
    ordered_turns,
    rpm,
    surface_fields,
    tank_fields,
)
from trainer.session.stations.view import Frame
from trainer.units import FOOT, KNOT

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


def over_water_and_ground(frame: Frame) -> tuple[float, float, float]:
    """Return speed across through the water, ahead and across over the ground [kn].

    To starboard is positive.
    """
    north, east = frame.rates.north, frame.rates.east
    cosine, sine = math.cos(frame["psi"]), math.sin(frame["psi"])
    ahead, across = north * cosine + east * sine, east * cosine - north * sine
    return frame["v"] / KNOT, ahead / KNOT, across / KNOT


def depth_shown(frame: Frame) -> float:
    """Return the depth [m] by the gauge, 0 above the water."""
    return max(frame.readings.depth, 0.0)


def sounding(frame: Frame, unit: float = 1.0) -> float | None:
    """Return the ground's depth below the transducer, in a unit of that size [m].

    The transducer is at the depth of the body's origin. None: there is no echo.
    """
    return frame.readings.sounding / unit if frame.readings.sounding else None


def turn_rate(frame: Frame) -> float:
    """Return the rate of turn [deg/min], to starboard positive."""
    return math.degrees(frame.rates.heading) * 60.0


# Angles are in degrees, speeds in knots, unless said otherwise.
READINGS: Final[Mapping[str, NmeaReading]] = {
    "north": NmeaReading(lambda f: f["x"], 1, FARTHEST_M),  # [m] of the origin
    "east": NmeaReading(lambda f: f["y"], 1, FARTHEST_M),  # [m]
    "track": NmeaReading(lambda f: way_made(f)[0], 2, 359.99),  # over the ground
    "over_ground": NmeaReading(lambda f: way_made(f)[1], 2, 99.99),
    "over_ground_kmh": NmeaReading(lambda f: way_made(f)[1] * KNOT_KM_H, 2, 99.99 * KNOT_KM_H),
    "across": NmeaReading(lambda f: over_water_and_ground(f)[0], 2, -99.99),  # through the water
    "ahead_over_ground": NmeaReading(lambda f: over_water_and_ground(f)[1], 2, -99.99),
    "across_over_ground": NmeaReading(lambda f: over_water_and_ground(f)[2], 2, -99.99),
    "current": NmeaReading(
        lambda f: set_and_drift(f)[0], 1, 359.9
    ),  # none where water stands still
    "drift": NmeaReading(lambda f: set_and_drift(f)[1], 2, 99.99),
    "depth": NmeaReading(lambda f: f.readings.depth, 2, 9999.99),  # [m] by the gauge
    "altitude": NmeaReading(lambda f: -f.readings.depth, 2, -9999.99),  # [m]
    "depth_shown": NmeaReading(depth_shown, 2, 9999.99),
    "depth_feet": NmeaReading(lambda f: depth_shown(f) / FOOT, 1, 9999.99 / FOOT),
    "depth_fathoms": NmeaReading(lambda f: depth_shown(f) / FATHOM_M, 1, 9999.99 / FATHOM_M),
    "heading": NmeaReading(lambda f: compass(f.readings.heading, 2), 2, 359.99),  # by the compass
    "speed": NmeaReading(lambda f: f.readings.speed / KNOT, 2, -99.99),  # by the log
    "speed_kmh": NmeaReading(lambda f: f.readings.speed / KNOT * KNOT_KM_H, 2, -99.99 * KNOT_KM_H),
    "sounding": NmeaReading(sounding, 2, 9999.99),
    "sounding_feet": NmeaReading(lambda f: sounding(f, FOOT), 1, 9999.99 / FOOT),
    "sounding_fathoms": NmeaReading(lambda f: sounding(f, FATHOM_M), 1, 9999.99 / FATHOM_M),
    # [m] above the transducer, so that it is negative; none where there is no ground
    "keel": NmeaReading(lambda f: -f.fittings.keel if f["bottom"] else None, 1, -99.9),
    "pitch": NmeaReading(lambda f: math.degrees(f["theta"]), 2, -99.99),  # bow up positive
    "heel": NmeaReading(lambda f: math.degrees(f["phi"]), 2, -179.99),  # to starboard positive
    "turn": NmeaReading(turn_rate, 1, -9999.9),
    "turn_per_second": NmeaReading(lambda f: turn_rate(f) / 60.0, 3, -9999.9 / 60.0),
    "rpm": NmeaReading(lambda f: rpm(f, f["u_c"]), 1, -9999.9),
    "ordered_rpm": NmeaReading(lambda f: rpm(f, ordered_turns(f)), 1, -9999.9),
    "ordered_course": NmeaReading(ordered_course, 2, 359.99),
    "ordered_depth": NmeaReading(ordered_depth, 2, 9999.99),  # [m]
    "ordered_speed": NmeaReading(ordered_speed, 2, -99.99),
    **{  # right and rising positive
        name: NmeaReading(field.read, 2, -99.99)
        for surface in SURFACES
        for name, field in zip(
            (surface, f"ordered_{surface}"), surface_fields(surface)[:2], strict=True
        )
    },
    **{  # [%]
        f"full_{tank}": NmeaReading(tank_fields(index, tank)[1].read, 1, 100.0)
        for index, tank in enumerate(BALLAST_TANKS)
    },
    **{  # [MPa]
        f"air_{bank}": NmeaReading(bank_fields(index, bank)[0].read, 2, 99.99)
        for index, bank in enumerate(BANKS)
    },
}


def read_fields(frame: Frame, chart: Chart, start: datetime) -> dict[str, str]:
    """Return each field at a tick by its name.

    The session began at ``start``, UTC.
    """
    values = {name: reading.read(frame) for name, reading in READINGS.items()}
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

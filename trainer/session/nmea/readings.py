"""The fields of NMEA 0183 sentences at one tick, as text in their units.

Depth, heading and speed through the water are read off the gauges, as wrong as these are. Position,
track and speed over the ground are the navigation system's, which has no casualty; nor have rate
of turn, attitude, surfaces and turns.
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
from trainer.session.nmea.orders import POSITIONS
from trainer.session.stations.channels import set_and_drift, way_made, way_over_ground
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

BALLAST: Final = TANKS[:8]  # those that are not compartments
FATHOM: Final = 6.0 * FOOT  # [m]
KILOMETRES: Final = 1.852  # [km/h] in a knot
BELLS: Final = {bell.replace(" ", "-"): position for bell, position in POSITIONS.items()}
# readers take no position without satellites: they are not of this trainer's world
CONSTANTS: Final = {"satellites": "08", "dilution": "1.0", "range": number(SOUNDER_RANGE, 1)}
FAR: Final = -9_999_999.9  # [m] from the origin


class Reading(NamedTuple):
    """One number of a tick."""

    read: Callable[[Frame], object]  # no number: the boat lacks it, or nothing is ordered
    decimals: int
    widest: float  # as wide as the field can be: what a line has to have room for


def over_water_and_ground(frame: Frame) -> tuple[float, float, float]:
    """Return speed across through the water, ahead and across over the ground [kn].

    To starboard is positive.
    """
    north, east = way_over_ground(frame)
    cosine, sine = math.cos(frame["psi"]), math.sin(frame["psi"])
    ahead, across = north * cosine + east * sine, east * cosine - north * sine
    return frame["v"] / KNOT, ahead / KNOT, across / KNOT


def depth_shown(frame: Frame) -> float:
    """Return the depth [m] by the gauge, 0 above the water."""
    return max(frame.readings.depth, 0.0)


def sounding(frame: Frame, unit: float = 1.0) -> float | None:
    """Return the ground's depth below the transducer, in a unit of that size [m].

    The transducer is as deep as the origin. None: no echo.
    """
    return frame.readings.sounding / unit if frame.readings.sounding else None


def turn(frame: Frame) -> float:
    """Return the rate of turn [deg/min], to starboard positive."""
    return math.degrees(frame["psidot"]) * 60.0


# Angles are in degrees, speeds in knots, unless said otherwise.
READINGS: Final[Mapping[str, Reading]] = {
    "north": Reading(lambda f: f["x"], 1, FAR),  # [m] of the origin
    "east": Reading(lambda f: f["y"], 1, FAR),  # [m]
    "track": Reading(lambda f: way_made(f)[0], 2, 359.99),  # over the ground
    "over_ground": Reading(lambda f: way_made(f)[1], 2, 99.99),
    "over_ground_kmh": Reading(lambda f: way_made(f)[1] * KILOMETRES, 2, 99.99 * KILOMETRES),
    "across": Reading(lambda f: over_water_and_ground(f)[0], 2, -99.99),  # through the water
    "ahead_over_ground": Reading(lambda f: over_water_and_ground(f)[1], 2, -99.99),
    "across_over_ground": Reading(lambda f: over_water_and_ground(f)[2], 2, -99.99),
    "current": Reading(lambda f: set_and_drift(f)[0], 1, 359.9),  # none where water stands still
    "drift": Reading(lambda f: set_and_drift(f)[1], 2, 99.99),
    "depth": Reading(lambda f: f.readings.depth, 2, 9999.99),  # [m] by the gauge
    "altitude": Reading(lambda f: -f.readings.depth, 2, -9999.99),  # [m]
    "depth_shown": Reading(depth_shown, 2, 9999.99),
    "depth_feet": Reading(lambda f: depth_shown(f) / FOOT, 1, 9999.99 / FOOT),
    "depth_fathoms": Reading(lambda f: depth_shown(f) / FATHOM, 1, 9999.99 / FATHOM),
    "heading": Reading(lambda f: compass(f.readings.heading, 2), 2, 359.99),  # by the compass
    "speed": Reading(lambda f: f.readings.speed / KNOT, 2, -99.99),  # by the log
    "speed_kmh": Reading(lambda f: f.readings.speed / KNOT * KILOMETRES, 2, -99.99 * KILOMETRES),
    "sounding": Reading(sounding, 2, 9999.99),
    "sounding_feet": Reading(lambda f: sounding(f, FOOT), 1, 9999.99 / FOOT),
    "sounding_fathoms": Reading(lambda f: sounding(f, FATHOM), 1, 9999.99 / FATHOM),
    # [m] above the transducer, so that it is negative; none where there is no ground
    "keel": Reading(lambda f: -f.fittings.keel if f["bottom"] else None, 1, -99.9),
    "pitch": Reading(lambda f: math.degrees(f["theta"]), 2, -99.99),  # bow up positive
    "heel": Reading(lambda f: math.degrees(f["phi"]), 2, -179.99),  # to starboard positive
    "turn": Reading(turn, 1, -9999.9),
    "turn_per_second": Reading(lambda f: turn(f) / 60.0, 3, -9999.9 / 60.0),
    "rpm": Reading(lambda f: rpm(f, f["u_c"]), 1, -9999.9),
    "ordered_rpm": Reading(lambda f: rpm(f, ordered_turns(f)), 1, -9999.9),
    "ordered_course": Reading(ordered_course, 2, 359.99),
    "ordered_depth": Reading(ordered_depth, 2, 9999.99),  # [m]
    "ordered_speed": Reading(ordered_speed, 2, -99.99),
    **{  # right and rising positive
        name: Reading(field.read, 2, -99.99)
        for surface in SURFACES
        for name, field in zip(
            (surface, f"ordered_{surface}"), surface_fields(surface)[:2], strict=True
        )
    },
    **{  # [%]
        f"full_{tank}": Reading(tank_fields(place, tank)[1].read, 1, 100.0)
        for place, tank in enumerate(BALLAST)
    },
    **{  # [MPa]
        f"air_{bank}": Reading(bank_fields(place, bank)[0].read, 2, 99.99)
        for place, bank in enumerate(BANKS)
    },
}


def sight(frame: Frame, chart: Chart, start: datetime) -> dict[str, str]:
    """Return each field at a tick of a session that began at ``start``, by its name."""
    values = {name: reading.read(frame) for name, reading in READINGS.items()}
    position = chart.position(frame["x"], frame["y"])
    at = start + timedelta(seconds=frame.seconds)
    return describe(values, frame.tick, at, position, str(bell(frame) or ""))


def describe(
    values: Mapping[str, object],
    tick: int,
    at: datetime,
    position: tuple[float, float],
    rung: str,
) -> dict[str, str]:
    """Return each field as text by its name: readings, a tick, UTC, a position [deg], a bell."""
    texts = {
        name: number(float(value) if isinstance(value, float | int) else None, reading.decimals)
        for (name, reading), value in zip(READINGS.items(), values.values(), strict=True)
    }
    clock = time_of_day(at)
    texts |= {"tick": f"{tick}", "time": clock, "time_to_ms": f"{clock}0", "date": date(at)}
    texts["latitude"], texts["north_or_south"] = latitude(position[0])
    texts["longitude"], texts["east_or_west"] = longitude(position[1])
    texts["bell"] = BELLS.get(rung, "")
    texts |= CONSTANTS
    return texts | {
        f"{name}_status": "A" if texts[name] else "V" for name in ("rudder", "ordered_rudder")
    }


WIDEST: Final = describe(
    {name: reading.widest for name, reading in READINGS.items()},
    99_999_999,
    datetime(2099, 12, 31, 23, 59, 59, tzinfo=UTC),
    (-89.99, -179.99),
    "ahead-flank",
)

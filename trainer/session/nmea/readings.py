"""The values of NMEA 0183 sentences at one tick, in the sentences' own units.

Depth, heading and speed through the water are read off the gauges, as wrong as these are. Position,
track and speed over the ground are the navigation system's, which has no casualty; nor have rate
of turn, attitude, surfaces and turns.
"""

import math
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Final, NamedTuple

from trainer.core.ballast.tanks import BANKS, TANKS
from trainer.core.surfaces import SURFACES
from trainer.io.chart import Chart
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
from trainer.units import KNOT

BALLAST: Final = TANKS[:8]  # those that are not compartments

Number = float | None  # None: the boat lacks it, or nothing is ordered


class Surface(NamedTuple):
    """A control surface [deg], right and rising positive."""

    angle: Number
    ordered: Number


class Readings(NamedTuple):
    """One tick; angles in degrees, speeds in knots, unless said otherwise."""

    tick: int
    at: datetime  # UTC
    north: float  # [m] of the origin
    east: float  # [m]
    latitude: float
    longitude: float
    track: float  # over the ground
    over_ground: float
    across: float  # through the water, to starboard positive
    ahead_over_ground: float
    across_over_ground: float
    current: Number  # where it goes to; None: nowhere
    drift: float
    depth: float  # [m] by the gauge
    heading: float  # by the compass
    speed: float  # by the log
    sounding: Number  # [m] below the transducer, which is as deep as the origin; None: no echo
    keel: Number  # [m] below the transducer; None: there is no ground
    pitch: float  # bow up positive
    heel: float  # to starboard positive
    turn: float  # [deg/min] to starboard positive
    rudder: Surface
    stern: Surface
    bow: Surface
    rpm: float  # [1/min]
    ordered_rpm: float
    bell: str  # "" when none is rung
    ordered_course: Number
    ordered_depth: Number  # [m]
    ordered_speed: Number
    full: tuple[Number, ...]  # [%] of each tank of BALLAST
    air: tuple[Number, ...]  # [MPa] of each bank


def reading(read: Callable[[Frame], object], frame: Frame) -> Number:
    """Return a field of a panel that is a number."""
    value = read(frame)
    return float(value) if isinstance(value, float | int) else None


SURFACE_FIELDS: Final = {name: surface_fields(name)[:2] for name in SURFACES}
TANK_FIELDS: Final = tuple(tank_fields(place, name)[1] for place, name in enumerate(BALLAST))
BANK_FIELDS: Final = tuple(bank_fields(place, name)[0] for place, name in enumerate(BANKS))


def sight(frame: Frame, chart: Chart, start: datetime) -> Readings:
    """Return what is seen at a tick of a session that began at ``start``."""
    north, east = frame["x"], frame["y"]
    latitude, longitude = chart.position(north, east)
    track, over_ground = way_made(frame)
    across, *over = over_water_and_ground(frame)
    current, drift = set_and_drift(frame)
    return Readings(
        tick=frame.tick,
        at=start + timedelta(seconds=frame.seconds),
        north=north,
        east=east,
        latitude=latitude,
        longitude=longitude,
        track=track,
        over_ground=over_ground,
        across=across,
        ahead_over_ground=over[0],
        across_over_ground=over[1],
        current=current,
        drift=drift,
        depth=frame.readings.depth,
        heading=compass(frame.readings.heading, 2),
        speed=frame.readings.speed / KNOT,
        sounding=frame.readings.sounding or None,
        keel=frame.fittings.keel if frame["bottom"] else None,
        pitch=math.degrees(frame["theta"]),
        heel=math.degrees(frame["phi"]),
        turn=math.degrees(frame["psidot"]) * 60.0,
        rudder=surface("rudder", frame),
        stern=surface("stern", frame),
        bow=surface("bow", frame),
        rpm=rpm(frame, frame["u_c"]),
        ordered_rpm=rpm(frame, ordered_turns(frame)),
        bell=str(bell(frame) or ""),
        ordered_course=reading(ordered_course, frame),
        ordered_depth=reading(ordered_depth, frame),
        ordered_speed=reading(ordered_speed, frame),
        full=tuple(reading(field.read, frame) for field in TANK_FIELDS),
        air=tuple(reading(field.read, frame) for field in BANK_FIELDS),
    )


def surface(name: str, frame: Frame) -> Surface:
    """Return a control surface as it is and as it is ordered."""
    angle, ordered = SURFACE_FIELDS[name]
    return Surface(reading(angle.read, frame), reading(ordered.read, frame))


def over_water_and_ground(frame: Frame) -> tuple[float, float, float]:
    """Return speed across through the water, ahead and across over the ground [kn].

    To starboard is positive.
    """
    north, east = way_over_ground(frame)
    cosine, sine = math.cos(frame["psi"]), math.sin(frame["psi"])
    ahead, across = north * cosine + east * sine, east * cosine - north * sine
    return frame["v"] / KNOT, ahead / KNOT, across / KNOT


_FAR: Final = -9_999_999.9
_ANGLE: Final = Surface(-99.99, -99.99)
# As wide as every field can be: what a line has to have room for.
WIDEST: Final = Readings(
    tick=99_999_999,
    at=datetime(2099, 12, 31, 23, 59, 59, tzinfo=UTC),
    north=_FAR,
    east=_FAR,
    latitude=-89.99,
    longitude=-179.99,
    track=359.99,
    over_ground=99.99,
    across=-99.99,
    ahead_over_ground=-99.99,
    across_over_ground=-99.99,
    current=359.9,
    drift=99.99,
    depth=9999.99,
    heading=359.99,
    speed=-99.99,
    sounding=9999.99,
    keel=99.9,
    pitch=-99.99,
    heel=-179.99,
    turn=-9999.9,
    rudder=_ANGLE,
    stern=_ANGLE,
    bow=_ANGLE,
    rpm=-9999.9,
    ordered_rpm=-9999.9,
    bell="ahead-flank",
    ordered_course=359.99,
    ordered_depth=9999.99,
    ordered_speed=-99.99,
    full=(100.0,) * len(BALLAST),
    air=(99.99,) * len(BANKS),
)

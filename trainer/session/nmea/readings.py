"""The values and fields of NMEA 0183 sentences at one tick, in their units.

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


# The contents of the fields of each NMEA 0183 sentence, at one tick.


FATHOM: Final = 6.0 * FOOT  # [m]
KILOMETRES: Final = 1.852  # [km/h] in a knot
SATELLITES, DILUTION = "08", "1.0"  # readers take no position without: not of this trainer's world
BELLS: Final = {bell.replace(" ", "-"): position for bell, position in POSITIONS.items()}


def rmc_fields(s: Readings) -> tuple[str, ...]:
    """Return the fields of RMC."""
    way = number(s.over_ground, 2), number(s.track, 2), date(s.at)
    return (
        time_of_day(s.at),
        "A",
        *latitude(s.latitude),
        *longitude(s.longitude),
        *way,
        "",
        "",
        "E",
    )


def fix(s: Readings) -> tuple[str, ...]:
    """Return the fields of GGA."""
    where = *latitude(s.latitude), *longitude(s.longitude)
    altitude = number(-s.depth, 2), "M", "0.0", "M", "", ""
    return (time_of_day(s.at), *where, "6", SATELLITES, DILUTION, *altitude)


def way(s: Readings) -> tuple[str, ...]:
    """Return the fields of VTG."""
    speed = number(s.over_ground, 2), "N", number(s.over_ground * KILOMETRES, 2), "K"
    return (number(s.track, 2), "T", "", "M", *speed, "E")


def depth(metres: float | None) -> tuple[str, ...]:
    """Return the fields of DBT; without an echo they are empty."""
    return (
        *(number(None if metres is None else metres / FOOT, 1), "f"),
        *(number(metres, 2), "M"),
        *(number(None if metres is None else metres / FATHOM, 1), "F"),
    )


def water_speed(s: Readings) -> tuple[str, ...]:
    """Return the fields of VHW."""
    speed = number(s.speed, 2), "N", number(s.speed * KILOMETRES, 2), "K"
    return (number(s.heading, 2), "T", "", "M", *speed)


def current(s: Readings) -> tuple[str, ...]:
    """Return the fields of VDR; water that stands still goes nowhere."""
    return (number(s.current, 1), "T", "", "M", number(s.drift, 2), "N")


def ways(s: Readings) -> tuple[str, ...]:
    """Return the fields of VBW, without those of the stern."""
    water = number(s.speed, 2), number(s.across, 2), "A"
    ground = number(s.ahead_over_ground, 2), number(s.across_over_ground, 2), "A"
    return (*water, *ground, "", "V", "", "V")


def attitude(s: Readings) -> tuple[str, ...]:
    """Return the fields of PASHR."""
    angles = number(s.heading, 2), "T", number(s.heel, 2), number(s.pitch, 2)
    return (f"{time_of_day(s.at)}0", *angles, "", "", "", "", "0", "0")


def ror_fields(s: Readings) -> tuple[str, ...]:
    """Return the fields of ROR."""
    return (*starboard(s.rudder.ordered), "B")


def starboard(angle: float | None) -> tuple[str, ...]:
    """Return a single rudder's angle and status.

    Those of the port rudder, which it lacks, follow.
    """
    return (number(angle, 2), "V" if angle is None else "A", "", "V")


def telegraph(s: Readings) -> tuple[str, ...]:
    """Return the fields of ETL; the position is empty when no bell is rung."""
    return (time_of_day(s.at), "O", BELLS.get(s.bell, ""), "", "B", "0")


def angles(**measured: float | None) -> tuple[str, ...]:
    """Return the fields of XDR for angles by their names."""
    return tuple(
        field
        for name, angle in measured.items()
        for field in ("A", number(angle, 2), "D", name.upper())
    )


def exactly(page: str, s: Readings, *values: tuple[float | None, int]) -> tuple[str, ...]:
    """Return the fields of one of this trainer's own sentences: numbers with their decimals."""
    return (page, f"{s.tick}", *(number(value, decimals) for value, decimals in values))


def motion(s: Readings) -> tuple[str, ...]:
    """Return the fields of PXSC,M."""
    shown = (s.depth, 2), (s.heading, 2), (s.speed, 2), (s.pitch, 2), (s.heel, 2)
    return exactly("M", s, *shown, (s.turn / 60.0, 3))


def place(s: Readings) -> tuple[str, ...]:
    """Return the fields of PXSC,P."""
    return exactly("P", s, (s.north, 1), (s.east, 1), (s.track, 2), (s.over_ground, 2))


def controls(s: Readings) -> tuple[str, ...]:
    """Return the fields of PXSC,C."""
    return exactly("C", s, *((angle, 2) for each in (s.rudder, s.stern, s.bow) for angle in each))


def engine(s: Readings) -> tuple[str, ...]:
    """Return the fields of PXSC,E."""
    turns = (s.rpm, 1), (s.ordered_rpm, 1)
    return exactly(
        "E", s, *turns, (s.ordered_depth, 2), (s.ordered_course, 2), (s.ordered_speed, 2)
    )


def ballast(s: Readings) -> tuple[str, ...]:
    """Return the fields of PXSC,B."""
    return exactly("B", s, *((full, 1) for full in s.full))


def air(s: Readings) -> tuple[str, ...]:
    """Return the fields of PXSC,A."""
    return exactly("A", s, *((pressure, 2) for pressure in s.air))

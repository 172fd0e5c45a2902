"""The contents of the fields of each NMEA 0183 sentence, at one tick."""

from typing import Final

from trainer.io.nmea import date, latitude, longitude, number, time_of_day
from trainer.session.nmea.orders import POSITIONS
from trainer.session.nmea.readings import Readings
from trainer.units import FOOT

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

"""The numbers of an order line: their meaning, their units and the grammar's limits.

``grammar`` reads a number by its kind in ``NUMBER_KINDS``, and help, pages and exported cores tell
the same limits. They are wide, because they stop slips of typing only; the boat's own limits are
narrower and come later.
"""

from dataclasses import dataclass
from decimal import Decimal

from trainer.units import DEGREE, FOOT, KNOT

MINUTE_S = 60.0  # [s]


class RefusedError(Exception):
    """A line that is no order; its text says why. ``grammar`` turns it into a BadOrder."""


@dataclass(frozen=True)
class Unit:
    """A unit: its written form, its spellings, its size in SI."""

    text: str  # "" for a unit that answers leave out, such as degrees
    names: tuple[str, ...]
    factor: float


@dataclass(frozen=True)
class Number:
    """A kind of number. The limits are in its first unit, the one understood when none is given."""

    says: str
    units: tuple[Unit, ...]
    low: float
    high: float
    decimals: int = 9
    prefix: str = ""  # may be stuck before the digits

    @property
    def limits(self) -> str:
        """Return the limits in words, with their unit."""
        return f"{self.low:g} to {self.high:g} {''.join(self.units[0].names[:1])}".rstrip()


DEGREES = Unit("", ("deg", "degrees", "degree"), DEGREE)
METRES = Unit("m", ("m", "metres", "metre", "meters", "meter"), 1.0)
FEET = Unit("ft", ("ft", "feet", "foot"), FOOT)
KNOTS = Unit("kn", ("kn", "knots", "knot", "kts", "kt"), KNOT)
METRES_PER_SECOND = Unit("m/s", ("m/s", "mps"), 1.0)
PER_MINUTE = Unit("", ("rpm",), 1.0 / MINUTE_S)
TONNES = Unit("t", ("t", "tonnes", "tonne", "tons", "ton"), 1000.0)
SECONDS = Unit("s", ("s", "seconds", "second", "sec"), 1.0)
MINUTES = Unit("min", ("min", "minutes", "minute", "mins"), MINUTE_S)
HERTZ = Unit("hz", ("hz",), 1.0)
PLAIN_UNIT = Unit("", (), 1.0)
LOCATION_RANGE = (Unit("", METRES.names, 1.0),), -200_000.0, 200_000.0  # [m] from the origin

NUMBER_KINDS = {
    "DEPTH": Number("a depth", (METRES, FEET), 0.0, 2000.0),
    "COURSE": Number("a course", (DEGREES,), 0.0, 360.0),
    "CHANGE": Number("a change of course", (DEGREES,), 0.0, 360.0),
    "ANGLE": Number("an angle", (DEGREES,), 0.0, 90.0),
    "SPEED": Number("a speed", (KNOTS, METRES_PER_SECOND), 0.0, 60.0),
    "TURNS": Number("a speed, negative astern", (KNOTS, METRES_PER_SECOND), -60.0, 60.0),
    "RPM": Number("a rate of revolutions, negative astern", (PER_MINUTE,), -2000.0, 2000.0),
    "FACTOR": Number("a time speed", (Unit("", ("x",), 1.0),), 0.1, 100.0, prefix="x"),
    "COUNT": Number("a number of ticks", (PLAIN_UNIT,), 1.0, 1000.0, decimals=0),
    "BRANCH": Number("the number of a branch", (PLAIN_UNIT,), 1.0, 1e6, decimals=0),
    "ALERT": Number("the number of an alert", (PLAIN_UNIT,), 1.0, 999999.0, decimals=0),
    "DEGREE": Number("a sea state", (PLAIN_UNIT,), 0.0, 8.0, decimals=0),
    "WIND": Number("a wind", (KNOTS, METRES_PER_SECOND), 0.0, 100.0),
    "DRIFT": Number("a drift", (KNOTS, METRES_PER_SECOND), 0.0, 10.0),
    "HEIGHT": Number("a significant height", (METRES, FEET), 0.0, 25.0),
    "TRAIN": Number("an angle off the bow", (DEGREES,), 0.0, 360.0),
    "MAST": Number("the height of a masthead", (METRES, FEET), 1.0, 150.0),
    "NORTH": Number("metres north of the origin, south negative", *LOCATION_RANGE, decimals=1),
    "EAST": Number("metres east of the origin, west negative", *LOCATION_RANGE, decimals=1),
    "BOAT": Number("the number of a boat", (PLAIN_UNIT,), 1.0, 24.0, decimals=0),
    "AMOUNT": Number("an amount of water", (TONNES,), 0.0, 1000.0),
    "SEVERITY": Number("a severity after a name like stern-stuck", (PLAIN_UNIT,), -1000.0, 1000.0),
    "SECONDS": Number("a time", (SECONDS,), 0.0, 3600.0),
    "PLAN": Number("the number of a plan", (PLAIN_UNIT,), 1.0, 999999.0, decimals=0),
    "LENGTH": Number("a time to be shown", (SECONDS, MINUTES), 1.0, 3600.0),
    "REACH": Number("a time ahead", (SECONDS, MINUTES), 10.0, 120.0),
    "LAPSE": Number("a time back", (SECONDS, MINUTES), 0.1, 86400.0),
    "TIME": Number("a time", (SECONDS, MINUTES), 0.0, 86400.0),
    "RATE": Number("a rate", (HERTZ,), 0.1, 50.0),
}


def quantity(number: Number, digits: str, unit: Unit) -> tuple[float, str]:
    """Return the number [SI, rad] and its wording; refuses what is beyond its limits."""
    if digits[0] in "+-" and number.low >= 0.0:
        raise RefusedError(f'"{digits}": {number.says} takes no sign')
    if len(digits.partition(".")[2]) > number.decimals:
        most = f"at most {number.decimals}" if number.decimals else "no"
        raise RefusedError(f'"{digits}": {number.says} has {most} decimals')
    value = float(digits) * unit.factor
    size = number.units[0].factor
    if not number.low * size <= value <= number.high * size:
        wording = f"{digits} {unit.text}".rstrip()
        raise RefusedError(f"{wording}: {number.says} is {number.limits}")
    # Decimal keeps the digits as typed, without zeros at the end; + 0 makes -0 a plain 0.
    plain = f"{Decimal(digits).normalize() + 0:f}"
    if number is NUMBER_KINDS["COURSE"]:
        # 360 is read back as 000, as helmsmen say it in three digits.
        plain = "0" if plain == "360" else plain
        whole, point, rest = plain.partition(".")
        return float(plain) * unit.factor, f"{whole:0>3}{point}{rest}"
    return value, f"{plain} {unit.text}".rstrip()

"""Decca lanes to positions: program DECCON, section 11 with equations 5.7-5.9 re-derived.

The master station is at the origin, slaves at (u, v) [m] in a plane grid. A lane is counted from
the master: L = (MS + MP - SP)/d, MS the base line, P the ship, d the lane's width on it.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final, NamedTuple

from trainer.config.files import ConfigError, quote

LETTERS: Final = "ABCDEFGHIJ"


class Zone(NamedTuple):
    """The names of a colour's lanes: their number to a zone, the first number."""

    lanes: int
    first: int

    @property
    def cycle(self) -> int:
        """Return after how many lanes the names come again."""
        return self.lanes * len(LETTERS)


ZONES: Final[Mapping[str, Zone]] = {
    "red": Zone(24, 0),
    "green": Zone(18, 30),
    "purple": Zone(30, 50),
}


class Point(NamedTuple):
    """A place in the grid [m]: x east, y north, or the chain's own axes."""

    x: float
    y: float


class Slave(NamedTuple):
    """A slave station: its place, and its lanes' width on the base line [m]."""

    place: Point
    width: float

    @property
    def base(self) -> float:
        """Return the length of the base line [m]."""
        return math.hypot(*self.place)


Chain = Mapping[str, Slave]  # by colour


def lane_number(colour: str, text: str) -> float:
    """Return the lane of a reading such as D12.34, in lanes from zone A.

    ConfigError if it is none, or the zone of that colour has no such lane.
    """
    found = re.fullmatch(r"\s*([A-Ja-j])\s*(\d+(?:\.\d*)?)\s*", text)
    if found is None:
        raise ConfigError(f"{colour} lane {quote(text)}: must be a zone A to J and a lane: D12.34")
    zone, number = ZONES[colour], float(found[2])
    if not zone.first <= number < zone.first + zone.lanes:
        raise ConfigError(
            f"{colour} lane {quote(text)}: zones of {colour} have lanes {zone.first} to "
            f"{zone.first + zone.lanes - 1}"
        )
    return LETTERS.index(found[1].upper()) * zone.lanes + number - zone.first


def resolve_lane(colour: str, lane: float, expected: float) -> float:
    """Return the lane of that name which is nearest to the ``expected`` one.

    The names come again after ten zones.
    """
    cycle = ZONES[colour].cycle
    return lane + cycle * round((expected - lane) / cycle)


def lane_at(slave: Slave, ship: Point) -> float:
    """Return the lane [lanes] that a receiver at ``ship`` shows (5.1)."""
    to_master = math.hypot(*ship)
    to_slave = math.hypot(ship.x - slave.place.x, ship.y - slave.place.y)
    return (slave.base + to_master - to_slave) / slave.width


def fixes(first: Slave, second: Slave, lanes: tuple[float, float]) -> tuple[Point, ...]:
    """Return the places, none to two, that have these lanes of two colours (5.7-5.9).

    ConfigError if master and both slaves are in one line.
    """
    (u1, v1), (u2, v2) = first.place, second.place
    delta = u1 * v2 - u2 * v1
    if abs(delta) <= 1e-9 * first.base * second.base:
        raise ConfigError("master and both slaves are in one line: no fix from these two colours")
    P1 = lanes[0] * first.width - first.base
    P2 = lanes[1] * second.width - second.base
    q1, q2 = 0.5 * (first.base**2 - P1**2), 0.5 * (second.base**2 - P2**2)
    bx, gx = (P1 * v2 - P2 * v1) / delta, (q1 * v2 - q2 * v1) / delta
    by, gy = (u1 * P2 - u2 * P1) / delta, (u1 * q2 - u2 * q1) / delta
    ranges = _real_roots(bx * bx + by * by - 1.0, 2.0 * (bx * gx + by * gy), gx * gx + gy * gy)
    slack = -1e-6 * max(first.base, second.base)
    return tuple(
        Point(bx * h + gx, by * h + gy)
        for h in ranges
        if h >= slack and h - P1 >= slack and h - P2 >= slack
    )


def _real_roots(a: float, b: float, c: float) -> tuple[float, ...]:
    """Return the real roots of a x^2 + b x + c, without cancellation."""
    inside = b * b - 4.0 * a * c
    if inside < 0.0:
        return ()
    half = -0.5 * (b + math.copysign(math.sqrt(inside), b))
    roots = [c / half] if half else [0.0]
    if abs(a) > 1e-14 and half:
        roots.append(half / a)
    return tuple(dict.fromkeys(roots))


def sharpness(first: Slave, second: Slave, ship: Point) -> float:
    """Return how well two colours cross at a place [-], 0 to 4. It is the area of their gradients.

    The sine of the angle at which the lanes cross, times how narrow the lanes are there.
    """
    one, two = _gradient(first, ship), _gradient(second, ship)
    return abs(one.x * two.y - one.y * two.x)


def _gradient(slave: Slave, ship: Point) -> Point:
    """Return the gradient of h0 - hi [-] at a place."""
    own = math.hypot(*ship) or 1.0
    aside = Point(ship.x - slave.place.x, ship.y - slave.place.y)
    other = math.hypot(*aside) or 1.0
    return Point(ship.x / own - aside.x / other, ship.y / own - aside.y / other)


@dataclass(frozen=True)
class Fix:
    """A place found, and by which colours."""

    place: Point
    colours: tuple[str, str]


def track(chain: Chain, readings: Sequence[Mapping[str, float]], start: Point) -> list[Fix | None]:
    """Return a fix for each set of lanes by colour, None where they give none.

    Lanes are resolved by the place before, ``start`` at first; the two colours that cross best
    there are taken, and of two places the nearer one.
    """
    found: list[Fix | None] = []
    last = start
    for reading in readings:
        fix = _fix(chain, reading, last)
        found.append(fix)
        last = fix.place if fix else last
    return found


def _fix(chain: Chain, reading: Mapping[str, float], last: Point) -> Fix | None:
    """Return the fix nearest to the place before; None if two colours lack or do not meet."""
    known = [colour for colour in chain if not math.isnan(reading.get(colour, math.nan))]
    lanes = {c: resolve_lane(c, reading[c], lane_at(chain[c], last)) for c in known}
    pairs = sorted(
        combinations(known, 2),
        key=lambda pair: -sharpness(chain[pair[0]], chain[pair[1]], last),
    )
    for one, two in pairs:
        places = fixes(chain[one], chain[two], (lanes[one], lanes[two]))
        if places:
            nearest = min(places, key=lambda at: math.dist(at, last))
            return Fix(nearest, (one, two))
    return None

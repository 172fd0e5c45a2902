"""The lights of ships by night, by rules 20 to 30 of the collision regulations.

``contacts`` shows them to the periscope. What is here is what can be seen from outside: colour,
sector, position on the ship and range.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import Final, NamedTuple

from trainer.config.world.contacts import ShipType

LARGE_LENGTH_M, MEDIUM_LENGTH_M = 50.0, 12.0  # [m] lengths at which the rules change
SIDELIGHT_SECTOR: Final = math.radians(112.5)  # [rad] from ahead to the end of a sidelight's sector
LIGHT_SPACING_M: Final = 2.0  # [m] between two lights over each other
KNOWN_SHIPS: Final = 64  # types with a status whose lights are kept; a boat has one by its depth
MASTHEAD_SPACING_M: Final = 4.5  # [m] of the two white lights of a large ship: annex I, 2 (a), (k)


class Light(NamedTuple):
    """A light. Its sector goes from one angle [rad] off the bow, clockwise, to the other."""

    colour: str
    begins: float
    ends: float
    ahead: float  # [m] of the ship's middle
    starboard: float  # [m] of it
    height: float  # [m] over the water
    range_nm: float


def _range(ship: ShipType, large: float, medium: float, small: float) -> float:
    """Return the range [nm] that the rules ask of a ship of that length."""
    if ship.length >= LARGE_LENGTH_M:
        return large
    return medium if ship.length >= MEDIUM_LENGTH_M else small


def _sides_and_stern(ship: ShipType) -> Iterator[Light]:
    """Yield the sidelights and the sternlight of a ship that makes way."""
    nm = _range(ship, 3.0, 2.0, 1.0)
    height, out, aft = 0.5 * ship.height, 0.5 * ship.beam, -0.5 * ship.length
    yield Light("green", 0.0, SIDELIGHT_SECTOR, 0.0, out, height, nm)
    yield Light("red", -SIDELIGHT_SECTOR, 0.0, 0.0, -out, height, nm)
    stern = _range(ship, 3.0, 2.0, 2.0)
    yield Light(
        "white", SIDELIGHT_SECTOR, math.tau - SIDELIGHT_SECTOR, aft, 0.0, 0.5 * height, stern
    )


def _all_round(ship: ShipType, colour: str, below: float, ahead: float = 0.0) -> Light:
    """Return a light that is seen from everywhere, ``below`` [m] the masthead."""
    nm = _range(ship, 3.0, 2.0, 2.0)
    return Light(colour, 0.0, math.tau, ahead, 0.0, ship.mast - below, nm)


def _under_way(ship: ShipType) -> Iterator[Light]:
    # yield one white light ahead, and from 50 m on a second, higher one aft of it
    nm = _range(ship, 6.0, 5.0 if ship.length >= 20.0 else 3.0, 2.0)
    large = ship.length >= LARGE_LENGTH_M
    forward = ship.mast - MASTHEAD_SPACING_M if large else ship.mast
    yield Light("white", -SIDELIGHT_SECTOR, SIDELIGHT_SECTOR, 0.25 * ship.length, 0.0, forward, nm)
    if large:
        yield Light(
            "white", -SIDELIGHT_SECTOR, SIDELIGHT_SECTOR, -0.25 * ship.length, 0.0, ship.mast, nm
        )
    yield from _sides_and_stern(ship)


def _anchored(ship: ShipType) -> Iterator[Light]:
    """Yield a white light forward, and from 50 m on a lower one aft."""
    yield _all_round(ship, "white", 0.0, 0.4 * ship.length)
    if ship.length >= LARGE_LENGTH_M:
        yield _all_round(ship, "white", MASTHEAD_SPACING_M, -0.4 * ship.length)


def _two(upper: str, lower: str) -> Callable[[ShipType], Iterator[Light]]:
    """Return the lights of two colours over each other, with those of a ship making way."""

    def lights(ship: ShipType) -> Iterator[Light]:
        yield _all_round(ship, upper, 0.0)
        yield _all_round(ship, lower, LIGHT_SPACING_M)
        yield from _sides_and_stern(ship)

    return lights


def _adrift(ship: ShipType) -> Iterator[Light]:
    """Yield the lights of a ship not under command: two red ones."""
    yield _all_round(ship, "red", 0.0)
    yield _all_round(ship, "red", LIGHT_SPACING_M)


LIGHTS_BY_STATUS: Final[Mapping[str, Callable[[ShipType], Iterator[Light]]]] = {
    "under way": _under_way,
    "at anchor": _anchored,
    "fishing": _two("red", "white"),
    "trawling": _two("green", "white"),
    "sailing": _sides_and_stern,
    "adrift": _adrift,
}


@lru_cache(maxsize=KNOWN_SHIPS)
def lights_of(ship: ShipType, status: str) -> tuple[Light, ...]:
    """Return the lights that a ship of a type carries, by what it is doing."""
    return tuple(LIGHTS_BY_STATUS[status](ship))

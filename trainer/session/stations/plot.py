"""The channels of the ships near: the instructor's plot, and the periscope's view.

``channels`` lists them. A trainee's page gets only angles, and nothing that the horizon hides,
because it must not give away more than the periscope shows.
"""

import math
from collections.abc import Callable
from functools import lru_cache, partial
from operator import attrgetter
from typing import Final, NamedTuple

from trainer.boat.world.approach import OwnMotion, plot_ship
from trainer.boat.world.contacts import contacts_in
from trainer.boat.world.scope import (
    OPTICS_SHOWING_M,
    VIEW_WIDTHS,
    Mast,
    Periscope,
    Sight,
    periscope_of,
)
from trainer.boat.world.swell import Swell, swell_round
from trainer.session.stations.panels import Channel, Field, Value, compass, word
from trainer.session.stations.view import Frame
from trainer.units import KNOT

MAX_PLOTTED_SHIPS: Final = 8  # ships plotted; there may be more
MAX_SIGHTED_SHIPS: Final = 10  # ships in sight, the nearest
RADIAN_MINUTES: Final = 60.0 * math.degrees(1.0)  # of arc in a radian


class PlottedShip(NamedTuple):
    """One ship as it bears from the boat [SI]. Times may be NaN."""

    name: str
    type: str
    bearing: float
    range: float
    course: float
    speed: float
    closest: float
    until: float


@lru_cache(maxsize=4)
def plotted_ships(frame: Frame) -> tuple[int, tuple[PlottedShip, ...]]:
    """Return how many ships there are, and the nearest at a tick."""
    contacts = contacts_in(frame.boat)
    if contacts is None or not contacts.fleet(frame.tick).order:
        return 0, ()
    ships, now = contacts.fleet(frame.tick), contacts.at(frame.tick)
    own, limit = OwnMotion.of(frame), contacts.encounters.cpa_m
    over_ground = zip(*(each.tolist() for each in now.over_ground()), strict=True)
    plotted = []
    for ship, motion, way in zip(ships.order, ships.motions(frame.tick), over_ground, strict=True):
        seen = plot_ship(own, motion, limit)
        told = seen.bearing, seen.range, *way, seen.closest, seen.until
        plotted.append(PlottedShip(ship.name, ship.kind, *told))
    nearest = sorted(plotted, key=attrgetter("range"))[:MAX_PLOTTED_SHIPS]
    return len(plotted), tuple(nearest)


def _of(index: int, read: Callable[[PlottedShip], Value]) -> Callable[[Frame], Value]:
    """Return a reader of something of the ship at an index, None without such a ship."""

    def value(frame: Frame) -> Value:
        _, ships = plotted_ships(frame)
        return read(ships[index]) if index < len(ships) else None

    return value


def ship_fields(index: int) -> tuple[Field, ...]:
    """Return the plot's fields of the ship at an index."""
    name = f"contact_{index + 1}"
    numbers: tuple[tuple[str, str, int, Callable[[PlottedShip], Value]], ...] = (
        ("bearing", "deg", 1, lambda ship: compass(ship.bearing)),
        ("range", "m", 0, lambda ship: ship.range),
        ("course", "deg", 1, lambda ship: compass(ship.course)),
        ("speed", "kn", 1, lambda ship: ship.speed / KNOT),
        ("cpa", "m", 0, lambda ship: ship.closest),
        ("tcpa", "s", 0, lambda ship: None if math.isnan(ship.until) else ship.until),
    )
    return (
        word(name, _of(index, lambda ship: ship.name)),
        word(f"{name}_type", _of(index, lambda ship: ship.type)),
        *(
            Field(f"{name}_{key}", unit, digits, _of(index, read))
            for key, unit, digits, read in numbers
        ),
    )


CONTACTS_CHANNEL: Final = Channel(
    "contacts",
    f"the nearest {MAX_PLOTTED_SHIPS} ships, by range: true bearing, closest approach and the "
    "time until then, "
    "below zero where it is past",
    (
        Field("ships", "-", 0, lambda frame: float(plotted_ships(frame)[0]) or None),
        *(field for index in range(MAX_PLOTTED_SHIPS) for field in ship_fields(index)),
    ),
)


def periscope(frame: Frame) -> Periscope | None:
    """Return the boat's periscope, None where it has none."""
    return periscope_of(frame.boat)


def mast(frame: Frame) -> Mast | None:
    """Return the state of the mast, None for a boat without."""
    scope = periscope(frame)
    return scope.at(frame.tick) if scope else None


def eye(frame: Frame) -> float | None:
    """Return the height [m] of the head over the waves."""
    scope, stands = periscope(frame), mast(frame)
    return frame.height(*scope.head(stands)) if scope and stands else None


def sights(frame: Frame) -> list[Sight]:
    """Return the ships in sight, the nearest first. A frame computes them once."""
    scope, stands = periscope(frame), mast(frame)
    if scope is None or stands is None:
        return []
    if "sights" not in frame.kept:
        head = scope.eye(frame, stands, frame.height(*scope.head(stands)))
        frame.kept["sights"] = scope.sights(head, stands)
    in_sight: list[Sight] = frame.kept["sights"]
    return in_sight


def of_mast(read: Callable[[Mast, Frame], Value]) -> Callable[[Frame], Value]:
    """Return a reader of something of the mast. It reads None for a boat without."""

    def value(frame: Frame) -> Value:
        stands = mast(frame)
        return None if stands is None else read(stands, frame)

    return value


def mast_motion(stands: Mast, frame: Frame) -> Value:
    """Return how the mast moves or stands."""
    scope = periscope(frame)
    most = scope.fitted.extension_m if scope and scope.fitted else 0.0
    if stands.up:
        return "up" if stands.out >= most else "raising"
    return "lowering" if stands.out > 0.0 else "down"


def view(stands: Mast, frame: Frame) -> Value:
    """Return what blocks the view, `clear` for nothing."""
    scope, height = periscope(frame), eye(frame)
    if stands.out < OPTICS_SHOWING_M or scope is None or height is None:
        return "down"
    if height <= 0.0:
        return "washed"
    return "shakes" if scope.shakes(frame["u"], stands) else "clear"


def sighted_ships(frame: Frame) -> Value:
    """Return the ships in the view with their bearings by the gyro, in words."""
    stands = mast(frame)
    half = 0.5 * VIEW_WIDTHS[stands.power] if stands else 0.0
    train = stands.train if stands else 0.0
    texts = (
        f"{sight.type} {compass(frame.readings.heading + sight.train, 0):03.0f}"
        for sight in sights(frame)[:MAX_SIGHTED_SHIPS]
        if abs(math.remainder(sight.train - train, math.tau)) <= half
    )
    return "; ".join(texts) or None


def lamps(sight: Sight) -> str:
    """Return colour, angle beside the ship's middle and elevation of its lights."""
    return " ".join(
        f"{lamp.colour}:{RADIAN_MINUTES * lamp.beside:.1f}:{RADIAN_MINUTES * lamp.elevation:.1f}"
        for lamp in sight.lamps
    )


def of_sight(index: int, read: Callable[[Sight], Value], frame: Frame) -> Value:
    """Return a reader of something of a ship in sight, None without such a ship."""
    in_sight = sights(frame)
    return read(in_sight[index]) if index < len(in_sight) else None


def sight_fields(index: int) -> tuple[Field, ...]:
    """Return the fields of one ship in sight."""
    name = f"ship_{index + 1}"
    parts: tuple[tuple[str, str, int, Callable[[Sight], Value]], ...] = (
        (name, "", 0, lambda sight: sight.type),
        (f"{name}_train", "deg", 3, lambda sight: math.degrees(sight.train)),
        (f"{name}_bottom", "min", 2, lambda sight: RADIAN_MINUTES * sight.bottom),
        (f"{name}_top", "min", 2, lambda sight: RADIAN_MINUTES * sight.top),
        (f"{name}_aspect", "deg", 0, lambda sight: math.degrees(sight.aspect)),
        (f"{name}_span", "min", 1, lambda sight: RADIAN_MINUTES * sight.span),
        (f"{name}_lights", "", 0, lamps),
    )
    return tuple(
        Field(field, unit, decimals, partial(of_sight, index, read), packed=True)
        for field, unit, decimals, read in parts
    )


def optics_are_out(frame: Frame) -> bool:
    """Return whether the optics are out of their well."""
    stands = mast(frame)
    return stands is not None and stands.out >= OPTICS_SHOWING_M


def head(frame: Frame) -> Value:
    """Return the height [m] of the head over the mean water. None: nobody looks."""
    over = eye(frame) if optics_are_out(frame) else None
    return None if over is None else over + frame["eta_wave"]


def of_swell(read: Callable[[Swell], Value]) -> Callable[[Frame], Value]:
    """Return a reader of something of the waves. It reads None in a calm, or if nobody looks."""

    def value(frame: Frame) -> Value:
        if not frame["sea_height"] or not optics_are_out(frame):
            return None
        if "swell" not in frame.kept:
            frame.kept["swell"] = swell_round(frame.numbers, float(frame.boat.vessel.g))
        return read(frame.kept["swell"])

    return value


def exposure_time(frame: Frame, *, raised: bool) -> Value:
    """Return how long [s] the head has shown, in all or since it was raised."""
    scope = periscope(frame)
    return scope.exposed(frame.tick, raised=raised) if scope else None


SCOPE_CHANNEL: Final = Channel(
    "scope",
    "what is seen through the periscope: angles alone, off the bow, over the horizontal",
    (
        Field(
            "bearing",
            "deg",
            1,
            of_mast(lambda stands, frame: compass(frame.readings.heading + stands.train)),
        ),
        Field("train", "deg", 1, of_mast(lambda stands, _: math.degrees(stands.train))),
        Field("power", "x", 1, of_mast(lambda stands, _: stands.power)),
        Field("mast", "m", 2, of_mast(lambda stands, _: stands.out)),
        word("going", of_mast(mast_motion)),
        word("view", of_mast(view)),
        word("sighted", sighted_ships),
        *(field for index in range(MAX_SIGHTED_SHIPS) for field in sight_fields(index)),
    ),
    fastest=10.0,
)
SWELL_CHANNEL: Final = Channel(
    "swell",
    "the waves round the boat, packed for the picture, and the head over their mean",
    (
        Field("head", "m", 3, head, packed=True),
        Field("pitch", "deg", 2, lambda frame: math.degrees(frame["theta"]), packed=True),
        Field("heel", "deg", 2, lambda frame: math.degrees(frame["phi"]), packed=True),
        Field("height", "m", 3, of_swell(lambda swell: swell.height), packed=True),
        Field("number", "1/m", 6, of_swell(lambda swell: swell.number), packed=True),
        Field("rate", "rad/s", 5, of_swell(lambda swell: swell.omega), packed=True),
        Field(
            "towards", "deg", 2, of_swell(lambda swell: math.degrees(swell.towards)), packed=True
        ),
        Field("ahead", "m/s", 2, of_swell(lambda swell: swell.ahead), packed=True),
        Field("right", "m/s", 2, of_swell(lambda swell: swell.right), packed=True),
        Field("clock", "-", 4, of_swell(lambda swell: swell.clock), packed=True),
        Field("drift", "rad", 4, of_swell(lambda swell: swell.drift), packed=True),
        Field("groups", "", 0, of_swell(Swell.packed_groups), packed=True),
        Field("waves", "", 0, of_swell(Swell.packed_waves), packed=True),
    ),
)
LOOKOUT_CHANNEL: Final = Channel(
    "lookout",
    "the truth of the periscope: its head over the waves, what it sees, and how long it showed",
    (
        Field("eye", "m", 1, eye),
        Field("mast", "m", 1, of_mast(lambda stands, _: stands.out)),
        Field("ships", "-", 0, lambda frame: float(len(sights(frame)))),
        Field("nearest", "m", 0, lambda frame: of_sight(0, lambda each: each.distance, frame)),
        Field("exposed_raise", "s", 1, partial(exposure_time, raised=True)),
        Field("exposed", "s", 1, partial(exposure_time, raised=False)),
    ),
)
PERISCOPE_CHANNELS: Final = (SCOPE_CHANNEL, SWELL_CHANNEL, LOOKOUT_CHANNEL)

"""The ships near as the instructor has them plotted: the nearest few, by range."""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np

from trainer.boat.world.contacts import contacts_in
from trainer.boat.world.encounters import Own, plot
from trainer.session.stations.panels import Channel, Field, Value, compass, word
from trainer.session.stations.view import Frame
from trainer.units import KNOT

MOST: Final = 8  # ships plotted; there may be more


class Plotted(NamedTuple):
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
def plotted(frame: Frame) -> tuple[int, tuple[Plotted, ...]]:
    """Return how many ships there are, and the nearest at a tick."""
    contacts = contacts_in(frame.boat)
    if contacts is None or not contacts.fleet(frame.tick).order:
        return 0, ()
    ships, there = contacts.fleet(frame.tick).order, contacts.at(frame.tick)
    seen = plot(Own.of(frame), there, contacts.encounters.cpa_m)
    nearest = np.argsort(seen.range, kind="stable")[:MOST].tolist()
    rows = (
        (
            *(ships[i].name, ships[i].kind, seen.bearing[i], seen.range[i]),
            *(there.course[i], there.speed[i], seen.closest[i], seen.until[i]),
        )
        for i in nearest
    )
    return len(ships), tuple(Plotted(name, kind, *map(float, row)) for name, kind, *row in rows)


def _of(place: int, read: Callable[[Plotted], Value]) -> Callable[[Frame], Value]:
    """Return how something of the ship at a place is read; none where there is no such ship."""

    def value(frame: Frame) -> Value:
        _, ships = plotted(frame)
        return read(ships[place]) if place < len(ships) else None

    return value


def ship_fields(place: int) -> tuple[Field, ...]:
    """Return what is told of the ship at a place."""
    name = f"contact_{place + 1}"
    numbers: tuple[tuple[str, str, int, Callable[[Plotted], Value]], ...] = (
        ("bearing", "deg", 1, lambda ship: compass(ship.bearing)),
        ("range", "m", 0, lambda ship: ship.range),
        ("course", "deg", 1, lambda ship: compass(ship.course)),
        ("speed", "kn", 1, lambda ship: ship.speed / KNOT),
        ("cpa", "m", 0, lambda ship: ship.closest),
        ("tcpa", "s", 0, lambda ship: None if math.isnan(ship.until) else ship.until),
    )
    return (
        word(name, _of(place, lambda ship: ship.name)),
        word(f"{name}_type", _of(place, lambda ship: ship.type)),
        *(
            Field(f"{name}_{key}", unit, digits, _of(place, read))
            for key, unit, digits, read in numbers
        ),
    )


CONTACTS: Final = Channel(
    "contacts",
    f"the nearest {MOST} ships, by range: true bearing, closest approach and the time until then, "
    "below zero where it is past",
    (
        Field("ships", "-", 0, lambda frame: float(plotted(frame)[0]) or None),
        *(field for place in range(MOST) for field in ship_fields(place)),
    ),
)

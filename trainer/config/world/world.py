"""The world around the boat in an exercise: current, ground and other ships.

Each of its tables has its own reader; here they are read together, for ``boat/world``. They are
checked together, because a ship's way must have water under it.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.files import Position, collecting, raise_problems
from trainer.config.schema import describe_kind, record_schema
from trainer.config.world.bottom import Bottom, BottomTable, depths_at, is_charted, read_bottom
from trainer.config.world.contacts import (
    CONTACT_ROWS,
    Contact,
    Encounters,
    read_contacts,
    read_encounters,
)
from trainer.config.world.current import current_schema, read_current
from trainer.io.orders.grammar import Refused

# By the name of the table: a function of its content, its place and the exercise's path.
WORLD_READERS: Final[Mapping[str, Callable[[object, Position, Path], Any]]] = {
    "bottom": read_bottom,
    "contact": read_contacts,
    "contacts": read_encounters,
    "current": read_current,
}

WORLD_SCHEMAS: Final[Mapping[str, Callable[[], dict[str, Any]]]] = {
    "contact": lambda: describe_kind(CONTACT_ROWS),
    "contacts": lambda: record_schema(Encounters, ("note",)),
    "current": current_schema,
    "bottom": lambda: record_schema(BottomTable, ("note",)),
}
MIN_WATER_DRAUGHTS: Final = 1.2  # [-] depth on a ship's way over its draught (docs/world.md)
SOUNDING_SPACING_M: Final = 20.0  # [m] between the points of a way that are sounded
WorldTables = Mapping[str, Any]  # records, by the names of their tables


def read_world(table: Mapping[str, Any], path: Path) -> WorldTables:
    """Return the world's tables of an exercise; ConfigError with all that is wrong."""
    problems: list[str] = []
    tables = {}
    for name, read in WORLD_READERS.items():
        with collecting(problems):
            if name in table:
                tables[name] = read(table[name], Position(path.name, name), path)
    if "bottom" in tables:
        refusals = (_aground(tables["bottom"], ship) for ship in tables.get("contact", ()))
        problems += [refused.reason for refused in refusals if refused]
    raise_problems(problems)
    return tables


def _aground(bottom: Bottom, ship: Contact) -> Refused | None:
    """Return a problem at the first location with too little water for a ship, None without.

    Locations beyond the chart are not judged, because their depth is only that of its edge.
    """
    least = MIN_WATER_DRAUGHTS * ship.type.draught
    for north, east in _sample_way(ship):
        depth = float(depths_at(bottom, np.array([north]), np.array([east]))[0])
        if depth < least and is_charted(bottom, north, east):
            message = f"{depth:.1f} m of water at [{north:.0f}, {east:.0f}]"
            draws = f"a {ship.row.type} draws {ship.type.draught:g} m"
            problem = f"points: {message}: {draws}, so {least:.1f} m at least"
            return Refused(ship.position.problem(problem))
    return None


def _sample_way(ship: Contact) -> Iterator[tuple[float, float]]:
    """Yield the locations [m] from way point to way point, one every SOUNDING_SPACING_M."""
    points = ship.row.points
    for (north, east), (north_then, east_then) in pairwise(points):
        count = math.ceil(math.hypot(north_then - north, east_then - east) / SOUNDING_SPACING_M)
        for i in range(count):
            share = i / count
            yield north + share * (north_then - north), east + share * (east_then - east)
    yield points[-1]

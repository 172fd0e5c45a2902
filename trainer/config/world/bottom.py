"""The ground of an exercise, table [bottom]: flat, a slope or a grid.

``boat/world/bottom`` takes its depth and slope under the boat. ``soundings`` reads the grids. A
slope becomes a grid of one cell, so that all who ask for a depth have one form to read.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.files import ConfigError, Position, raise_problems
from trainer.config.schema import (
    Choice,
    Flag,
    Quantities,
    Quantity,
    Text,
    above,
    optional,
    read_record,
    with_default,
    within,
)
from trainer.config.world.soundings import Grid, Numbers, interpolate, on_the_plane, read_grid
from trainer.core.current import north_and_east
from trainer.io.chart import Chart

FRICTION_BY_KIND: Final = {"mud": 0.3, "sand": 0.4, "rock": 0.6}  # [-] project's own estimates
GROUNDING_ACTIONS: Final = ("free", "freeze", "end")
LAND_DEPTH_M: Final = -10.0  # [m] depth where a grid has no value: a coast that nothing sails over
START_RADIUS_M: Final = 2000.0  # [m] of the start, within which no land may lie (docs/world.md)


@dataclass(frozen=True, kw_only=True)
class BottomTable:
    """The table [bottom] as it stands in the file."""

    depth_m: float | None = optional(
        "m", above(0, 12000), "of the water over a plane, at the exercise's origin"
    )
    slope_percent: float | None = optional("%", within(0, 100), "of that plane; else 0")
    deepens_deg: float | None = optional(
        "deg", within(0, 360), "direction in which it falls away, clockwise from north"
    )
    grid: str | None = optional(
        Text(200, "path of an ESRI ASCII grid or GeoTIFF, instead of depth_m")
    )
    values: str | None = optional(
        Choice(("depth", "height"), "what the grid's numbers are, downward or upward positive")
    )
    origin_deg: tuple[float, ...] | None = optional(
        Quantities(
            Quantity("deg", within(-180, 180), "latitude and longitude of the origin, grid in deg"),
            2,
            2,
        )
    )
    tide_m: float = with_default(0.0, "m", within(-20, 20), "water over the depths charted")
    kind: str = with_default(
        "sand", Choice(tuple(FRICTION_BY_KIND), "friction 0.3, 0.4 or 0.6; else sand")
    )
    grounding: str = with_default(
        "free",
        Choice(GROUNDING_ACTIONS, "what it does: nothing more, freeze time, end the exercise"),
    )
    bottoming: bool | None = optional(Flag("the boat is to be laid down on it; else false"))
    breakout_t: float = with_default(
        0.0, "t", within(0, 1000), "lift that mud holds a boat with; else 0"
    )


@dataclass(frozen=True, kw_only=True, eq=False)
class Bottom:
    """The ground: a grid of depths [m], two by two for a plane."""

    depth: Grid  # [m] positive down, on the exercise's plane; land where the file has no value
    known: Grid | None  # the same with NaN there; None: a plane, which has no end
    friction: float  # [-]
    breakout: float  # [N/g: kg]
    kind: str
    grounding: str
    bottoming: bool


def read_bottom(value: object, position: Position, path: Path) -> Bottom:
    """Return the ground of a table of the exercise in ``path``; ConfigError with all faults."""
    table = read_record(BottomTable, value, position, ("note",))
    problems = _misfits(table, position)
    raise_problems(problems)
    known = None
    if table.grid is None:
        depth = _plane(table)
    else:
        known = _charted(table, position, path)
        depth = replace(known, values=np.where(np.isnan(known.values), LAND_DEPTH_M, known.values))
    return Bottom(
        depth=depth,
        known=known,
        friction=FRICTION_BY_KIND[table.kind],
        breakout=1000.0 * table.breakout_t,
        kind=table.kind,
        grounding=table.grounding,
        bottoming=bool(table.bottoming),
    )


def _misfits(table: BottomTable, position: Position) -> list[str]:
    """Return what is wrong with keys that do not go together."""
    problems = []
    if (table.depth_m is None) == (table.grid is None):
        problems.append(position.problem("give depth_m, or grid with values"))
    if (table.slope_percent is None) != (table.deepens_deg is None):
        problems.append(position.problem("give slope_percent and deepens_deg, or neither"))
    if table.grid is not None and table.values is None:
        problems.append(
            position.problem('lacks values: "depth" or "height" of the grid\'s numbers')
        )
    foreign_keys = ("slope_percent", "deepens_deg") if table.grid else ("values", "origin_deg")
    other = "a grid" if table.grid else "depth_m"
    problems += [
        position.wrong(key, getattr(table, key), f"does not go with {other}")
        for key in foreign_keys
        if getattr(table, key) is not None
    ]
    if table.breakout_t and table.kind != "mud":
        problems.append(
            position.wrong("breakout_t", table.breakout_t, 'only kind = "mud" holds a boat')
        )
    return problems


def _plane(table: BottomTable) -> Grid:
    """Return a plane as a grid of one cell of a metre, which fixes depth and slopes."""
    depth = (table.depth_m or 0.0) + table.tide_m
    slope = (table.slope_percent or 0.0) / 100.0
    fall = math.radians(table.deepens_deg or 0.0)
    north, east = (slope * share for share in north_and_east(fall))
    values = np.array([[depth, depth + east], [depth + north, depth + north + east]])
    return Grid(values, 0.0, 0.0, (1.0, 1.0), degrees=False)


def _charted(table: BottomTable, position: Position, path: Path) -> Grid:
    """Return the depths of a grid on the exercise's plane, the tide added."""
    name = table.grid or ""
    try:
        grid = read_grid(path.parent / name)
        if table.origin_deg is not None:
            grid = on_the_plane(grid, Chart(*table.origin_deg).position)
    except ConfigError as wrong:
        raise ConfigError(
            *(position.wrong("grid", name, each) for each in wrong.problems)
        ) from None
    if grid.degrees:
        message = "is in degrees: give origin_deg = [LAT, LON], where the exercise's origin lies"
        raise ConfigError(position.wrong("grid", name, message))
    sense = 1.0 if table.values == "depth" else -1.0
    return replace(grid, values=sense * grid.values + table.tide_m)


def land_near(bottom: Bottom, north: float, east: float) -> float:
    """Return the distance [m] to the nearest land, infinity beyond START_RADIUS_M.

    Land is where the grid has no value.
    """
    if bottom.known is None:
        return math.inf
    grid = bottom.known
    i, j = np.nonzero(np.isnan(grid.values))
    away = np.hypot(grid.south + i * grid.cell[0] - north, grid.west + j * grid.cell[1] - east)
    nearest = float(away.min()) if away.size else math.inf
    return nearest if nearest <= START_RADIUS_M else math.inf


def is_charted(bottom: Bottom, north: float, east: float) -> bool:
    """Return whether a location is on the grid. A plane has no end, so every one is."""
    return bool(charted_at(bottom, north, east))


def charted_at(bottom: Bottom, north: Any, east: Any) -> Any:
    """Return whether locations [m], numbers or arrays, are on the grid."""
    grid = bottom.known
    if grid is None:
        return north == north  # noqa: PLR0124  each is
    rows, columns = grid.values.shape
    i, j = (north - grid.south) / grid.cell[0], (east - grid.west) / grid.cell[1]
    return (i >= 0.0) & (i <= rows - 1) & (j >= 0.0) & (j <= columns - 1)


def depths_at(bottom: Bottom, north: Numbers, east: Numbers) -> Numbers:
    """Return the depths [m] at locations [m]. Beyond a grid's edge they are as at the edge."""
    grid = bottom.depth
    i, j = (north - grid.south) / grid.cell[0], (east - grid.west) / grid.cell[1]
    if bottom.known is None:
        # Computed beyond its one cell, since a plane has no edge to keep to.
        (here, right), (up, _) = grid.values.tolist()
        plane: Numbers = here + i * (up - here) + j * (right - here)
        return plane
    rows, columns = grid.values.shape
    return interpolate(grid.values, np.clip(i, 0.0, rows - 1.0), np.clip(j, 0.0, columns - 1.0))

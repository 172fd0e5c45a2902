"""A Decca study from its file, and program DECCON carried out over it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Final

import numpy as np

from trainer.config.files import ConfigError, Place, collecting, parse_toml, read_text
from trainer.config.schema import (
    Choice,
    Quantity,
    Rows,
    Text,
    above,
    of,
    optional,
    tables_of,
    within,
)
from trainer.config.tables import Table, read_table
from trainer.core.kernel import Numbers
from trainer.identify.record.decca import LETTERS, ZONES, Point, Slave, lane_number, track
from trainer.identify.record.sources import write_columns
from trainer.identify.record.study import read_parts
from trainer.identify.record.study_records import TURNING
from trainer.identify.record.track import (
    derivative,
    drift_of,
    even_interval,
    smooth_spencer,
    through_water,
)

METRES: Final = within(-1e7, 1e7)
TABLES: Final = ("slaves", "columns", "ship")
NOWHERE: Final = Point(math.nan, math.nan)
PROPAGATION: Final = 299_700.0  # [km/s] usual of long waves over sea


@dataclass(frozen=True, kw_only=True)
class Heading:
    """The run of a ship, and the lie of the grid."""

    schema: str = of(Choice(("decca/1",), "form of the file"))
    name: str = of(Text(79, "what was sailed"))
    data: str = of(Text(200, "CSV file of lanes and heading, from this file's folder"))
    start_east_m: float = of(Quantity("m", METRES, "place at the first row, from the master"))
    start_north_m: float = of(Quantity("m", METRES, "likewise"))
    convergence_deg: float | None = optional(
        Quantity("deg", within(-180, 180), "true less grid heading; else 0")
    )
    grid_scale: float | None = optional(
        Quantity("-", within(0.5, 2), "grid distance over true distance; else 1")
    )
    current_east_kn: float | None = optional(Quantity("kn", within(-20, 20), "taken off; else 0"))
    current_north_kn: float | None = optional(Quantity("kn", within(-20, 20), "likewise"))
    positive_rudder: str | None = optional(TURNING)


@dataclass(frozen=True, kw_only=True)
class SlaveRow:
    """One slave station."""

    colour: str = of(Choice(tuple(ZONES), "of its lanes"))
    east_m: float = of(Quantity("m", METRES, "place from the master, in the grid"))
    north_m: float = of(Quantity("m", METRES, "likewise"))
    lane_m: float | None = optional(Quantity("m", above(0, 1e5), "a lane on the base line"))
    frequency_khz: float | None = optional(
        Quantity("kHz", above(0, 1e4), "comparison frequency, instead of lane_m")
    )
    propagation_km_s: float | None = optional(
        Quantity("km/s", within(2.9e5, 3e5), f"of the waves; else {PROPAGATION:g}")
    )


@dataclass(frozen=True, kw_only=True)
class ColumnNames:
    """Headings of the CSV file."""

    t_s: str | None = optional(Text(80, "times [s]; else t"))
    heading_deg: str | None = optional(Text(80, "true heading [deg]; else heading"))
    yaw_rate_deg_s: str | None = optional(Text(80, "yaw rate; else from the heading"))
    rudder_deg: str | None = optional(Text(80, "rudder, for the record written; else none"))
    red: str | None = optional(Text(80, "red lanes, D12.34 or numbers; else red"))
    green: str | None = optional(Text(80, "green lanes; else green"))
    purple: str | None = optional(Text(80, "purple lanes; else purple"))


@dataclass(frozen=True, kw_only=True)
class ShipTable:
    """Where the antenna is."""

    antenna_m: float = of(Quantity("m", within(-600, 600), "forward of the point wanted"))


SLAVES: Final = Rows(SlaveRow, ("note",), 2, 3, "slave stations, below")
KNOWN: Final = (*(item.name for item in fields(Heading)), "note", *TABLES)
RECORDS: Final = {
    "": Heading,
    "[slaves]": SlaveRow,
    "columns": ColumnNames,
    "ship": ShipTable,
}


@dataclass(frozen=True, kw_only=True)
class DeccaFile:
    """Everything a Decca study says."""

    path: Path
    heading: Heading
    chain: Mapping[str, Slave]
    columns: ColumnNames
    antenna: float  # [m] forward of the point wanted

    @property
    def start(self) -> Point:
        """Return where the ship is at the first row [m]."""
        return Point(self.heading.start_east_m, self.heading.start_north_m)


def load_decca(path: Path) -> DeccaFile:
    """Return the study in a TOML file; ConfigError with all that is wrong."""
    place = Place(path.name, "")
    table = parse_toml(read_text(path), path.name)
    records = {"columns": ColumnNames, "ship": ShipTable}
    parts, problems = read_parts(table, place, (Heading, KNOWN), records)
    ship, columns = parts.pop("ship"), parts.pop("columns") or ColumnNames()
    with collecting(problems):
        rows = SLAVES.read("slaves", table.get("slaves", []), place)
        parts["chain"] = _chain(rows, place)
    if problems:
        raise ConfigError(*problems)
    antenna = ship.antenna_m if ship else 0.0
    return DeccaFile(path=path, columns=columns, antenna=antenna, **parts)


def _chain(rows: tuple[SlaveRow, ...], place: Place) -> dict[str, Slave]:
    """Return the stations by colour; ConfigError with all that is wrong."""
    problems: list[str] = []
    found = {}
    for i, row in enumerate(rows):
        inside = place.inside(f"slaves[{i}]")
        if row.colour in found:
            problems.append(inside.wrong("colour", row.colour, "is given twice"))
        if (row.lane_m is None) == (row.frequency_khz is None):
            problems.append(inside.problem("give one of lane_m, frequency_khz"))
        width = row.lane_m or (row.propagation_km_s or PROPAGATION) / (row.frequency_khz or 1.0)
        found[row.colour] = Slave(Point(row.east_m, row.north_m), width)
    if problems:
        raise ConfigError(*problems)
    return found


@dataclass(frozen=True)
class Readings:
    """Columns of the CSV file: times [s], heading, yaw rate, rudder [rad, rad/s], lanes."""

    t: Numbers
    heading: Numbers
    yaw_rate: Numbers | None
    rudder: Numbers | None
    lanes: list[dict[str, float]]


def load_readings(file: DeccaFile) -> Readings:
    """Return the readings of a study; ConfigError naming row and column of what is wrong."""
    table, columns = read_table(file.path.parent / file.heading.data), file.columns
    t = table.known(table.place(columns.t_s or "t"))
    heading = table.known(table.place(columns.heading_deg or "heading"))
    lanes = {colour: _lanes(table, colour, columns) for colour in file.chain}
    rate, rudder = columns.yaw_rate_deg_s, columns.rudder_deg
    sign = -1.0 if file.heading.positive_rudder == "starboard" else 1.0
    return Readings(
        t=t,
        heading=np.radians(heading),
        yaw_rate=np.radians(table.known(table.place(rate))) if rate else None,
        rudder=sign * np.radians(table.known(table.place(rudder))) if rudder else None,
        lanes=[dict(zip(lanes, row, strict=True)) for row in zip(*lanes.values(), strict=True)],
    )


def _lanes(table: Table, colour: str, columns: ColumnNames) -> list[float]:
    """Return the lanes of a colour, NaN where a cell is empty; ConfigError naming the row."""
    place = table.place(getattr(columns, colour) or colour)
    return [_lane(table, row, place, colour) for row in range(len(table.cells))]


def _lane(table: Table, row: int, place: int, colour: str) -> float:
    """Return the lane that a cell names or counts; ConfigError naming the row."""
    text = table.cells[row][place]
    if text[:1].upper() not in tuple(LETTERS):
        return table.number(row, place, text)
    try:
        return lane_number(colour, text)
    except ConfigError as wrong:
        raise ConfigError(f"{table.path}: row {table.lines[row]}: {wrong}") from None


def key_tables() -> str:
    """Return the Markdown tables of every key, as docs/identification.md shows them."""
    return tables_of(RECORDS)


@dataclass(frozen=True)
class Sailed:
    """The track and what was read off it, SI and radians. NaN where lanes or neighbours lack."""

    source: str
    t: Numbers
    east: Numbers  # [m] of the antenna, in the grid
    north: Numbers
    heading: Numbers  # grid
    yaw_rate: Numbers
    sway: Numbers  # [m/s] through the water at the point wanted
    ahead: Numbers  # [m/s] likewise
    rudder: Numbers | None  # as read
    colours: tuple[str, ...]  # that each fix is by, "" for none

    @property
    def fixed(self) -> int:
        """Return how many rows have a fix."""
        return sum(1 for colours in self.colours if colours)


def sail(file: DeccaFile, readings: Readings, *, smooth: bool) -> Sailed:
    """Return the track and sway velocity of a study.

    ConfigError if too few rows have a fix, or times are not even.
    """
    t = readings.t
    interval = even_interval(t, str(file.path.parent / file.heading.data))
    fixes = track(file.chain, readings.lanes, file.start)
    if sum(fix is not None for fix in fixes) < 5:
        raise ConfigError(f"{file.path.name}: fewer than 5 rows give a fix; is the start right?")
    east, north = np.array([fix.place if fix else NOWHERE for fix in fixes]).T
    heading = np.unwrap(readings.heading) - math.radians(file.heading.convergence_deg or 0.0)
    rate = derivative(heading, interval) if readings.yaw_rate is None else readings.yaw_rate
    scale = file.heading.grid_scale or 1.0
    x, y = (smooth_spencer(one) if smooth else one for one in (east / scale, north / scale))
    ground = derivative(x, interval), derivative(y, interval)
    current = file.heading.current_east_kn, file.heading.current_north_kn
    drift = drift_of(current, file.antenna)
    ahead, sway = through_water(*ground, heading, rate, drift)
    return Sailed(
        source=file.heading.name,
        t=t,
        east=east,
        north=north,
        heading=heading,
        yaw_rate=rate,
        sway=sway,
        ahead=ahead,
        rudder=readings.rudder,
        colours=tuple("+".join(fix.colours) if fix else "" for fix in fixes),
    )


def write_track(sailed: Sailed, path: Path) -> None:
    """Write the track as CSV, SI and radians, a missing value empty. ConfigError if it cannot."""
    columns = {"t": sailed.t, "east": sailed.east, "north": sailed.north}
    columns |= {"psi": sailed.heading, "r": sailed.yaw_rate, "v": sailed.sway, "u": sailed.ahead}
    if sailed.rudder is not None:
        columns["delta_r"] = sailed.rudder
    write_columns(path, columns)

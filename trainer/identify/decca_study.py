"""A Decca study from its file, and program DECCON carried out over it."""

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.files import ConfigError, Place, collecting, nearest, parse_toml, read_text
from trainer.config.schema import (
    Choice,
    Quantity,
    Rows,
    Text,
    above,
    of,
    optional,
    read_record,
    tables_of,
    within,
)
from trainer.core.kernel import Numbers
from trainer.identify.decca import (
    LETTERS,
    ZONES,
    Fix,
    Point,
    Slave,
    along,
    derivative,
    even_interval,
    lane_number,
    smooth_spencer,
    sway_of_track,
    track,
)
from trainer.io.atomic_write import replacing
from trainer.units import KNOT

METRES: Final = within(-1e7, 1e7)
TABLES: Final = ("slaves", "columns", "ship")
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
    problems = [
        place.wrong(key, value, f"no such key{nearest(key, KNOWN)}")
        for key, value in table.items()
        if key not in KNOWN
    ]
    parts: dict[str, Any] = {"columns": ColumnNames(), "antenna": 0.0}
    with collecting(problems):
        own = {key: value for key, value in table.items() if key in KNOWN and key not in TABLES}
        parts["heading"] = read_record(Heading, own, place, ("note",))
    with collecting(problems):
        rows = SLAVES.read("slaves", table.get("slaves", []), place)
        parts["chain"] = _chain(rows, place)
    with collecting(problems):
        if "columns" in table:
            inside = place.inside("columns")
            parts["columns"] = read_record(ColumnNames, table["columns"], inside, ("note",))
    with collecting(problems):
        if "ship" in table:
            inside = place.inside("ship")
            parts["antenna"] = read_record(ShipTable, table["ship"], inside, ("note",)).antenna_m
    if problems:
        raise ConfigError(*problems)
    return DeccaFile(path=path, **parts)


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
    """Rows of the CSV file: times [s], heading and yaw rate [rad, rad/s], lanes."""

    t: list[float]
    heading: list[float]
    yaw_rate: list[float] | None
    lanes: list[dict[str, float]]


def load_readings(file: DeccaFile) -> Readings:
    """Return the readings of a study; ConfigError naming row and column of what is wrong."""
    path = file.path.parent / file.heading.data
    columns = file.columns
    wanted = {"t": columns.t_s or "t", "heading": columns.heading_deg or "heading"}
    wanted |= {colour: getattr(columns, colour) or colour for colour in file.chain}
    if columns.yaw_rate_deg_s:
        wanted["yaw_rate"] = columns.yaw_rate_deg_s
    rows = _rows(path, wanted)
    turn = math.radians
    return Readings(
        t=[row["t"] for row in rows],
        heading=[turn(row["heading"]) for row in rows],
        yaw_rate=[turn(row["yaw_rate"]) for row in rows] if "yaw_rate" in wanted else None,
        lanes=[{colour: row[colour] for colour in file.chain} for row in rows],
    )


def _rows(path: Path, wanted: Mapping[str, str]) -> list[dict[str, float]]:
    """Return the wanted columns of each row; ConfigError naming the first fault."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            table = csv.DictReader(file)
            names = table.fieldnames or []
            lacking = [name for name in wanted.values() if name not in names]
            if lacking:
                raise ConfigError(
                    f"{path}: no column {lacking[0]!r}{nearest(lacking[0], names)}; "
                    f"it has {', '.join(names)}"
                )
            return [
                {key: _cell(path, table.line_num, key, row[name]) for key, name in wanted.items()}
                for row in table
            ]
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise ConfigError(f"{path}: is not a CSV text: {error}") from error


def _cell(path: Path, line: int, key: str, text: str | None) -> float:
    """Return a number, of a colour the lane it names; an empty lane is NaN."""
    text = (text or "").strip()
    if key in ZONES:
        if not text:
            return math.nan
        if text[0].upper() in LETTERS:
            try:
                return lane_number(key, text)
            except ConfigError as wrong:
                raise ConfigError(f"{path}: row {line}: {wrong}") from None
    try:
        number = float(text)
    except ValueError:
        number = math.inf
    if not math.isfinite(number):
        raise ConfigError(f"{path}: row {line}: {key} = {text!r}: must be a number")
    return number


def key_tables() -> str:
    """Return the Markdown tables of every key, as docs/identification.md shows them."""
    return tables_of(RECORDS)


HEADS: Final = ("t", "east", "north", "psi", "r", "v", "u")


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
    colours: tuple[str, ...]  # that each fix is by, "" for none

    @property
    def fixed(self) -> int:
        """Return how many rows have a fix."""
        return sum(1 for colours in self.colours if colours)


def sail(file: DeccaFile, readings: Readings, *, smooth: bool) -> Sailed:
    """Return the track and sway velocity of a study.

    ConfigError if too few rows have a fix, or times are not even.
    """
    t = np.array(readings.t)
    interval = even_interval(t, str(file.path.parent / file.heading.data))
    fixes = track(file.chain, readings.lanes, file.start)
    if sum(fix is not None for fix in fixes) < 5:
        raise ConfigError(f"{file.path.name}: fewer than 5 rows give a fix; is the start right?")
    east, north = (_coordinate(fixes, axis) for axis in (0, 1))
    heading = np.unwrap(np.array(readings.heading))
    heading -= math.radians(file.heading.convergence_deg or 0.0)
    rate = derivative(heading, interval)
    if readings.yaw_rate is not None:
        rate = np.array(readings.yaw_rate)
    scale = file.heading.grid_scale or 1.0
    course = float(heading[0])
    x0, y0 = along(east / scale, north / scale, course)
    if smooth:
        x0, y0 = smooth_spencer(x0), smooth_spencer(y0)
    over_ground = sway_of_track(x0, y0, heading - course, interval)
    turned = heading - course
    x_rate, y_rate = derivative(x0, interval), derivative(y0, interval)
    ahead = x_rate * np.cos(turned) + y_rate * np.sin(turned)
    current_ahead, current_aside = _current(file, heading)
    return Sailed(
        source=file.heading.name,
        t=t,
        east=east,
        north=north,
        heading=heading,
        yaw_rate=rate,
        sway=over_ground - rate * file.antenna - current_aside,
        ahead=ahead - current_ahead,
        colours=tuple("+".join(fix.colours) if fix else "" for fix in fixes),
    )


def _coordinate(fixes: list[Fix | None], axis: int) -> Numbers:
    """Return one coordinate [m] of the fixes, NaN where there is none."""
    return np.array([fix.place[axis] if fix else math.nan for fix in fixes])


def _current(file: DeccaFile, heading: Numbers) -> tuple[Numbers, Numbers]:
    """Return the current [m/s] ahead and to starboard of the ship."""
    east = KNOT * (file.heading.current_east_kn or 0.0)
    north = KNOT * (file.heading.current_north_kn or 0.0)
    s, c = np.sin(heading), np.cos(heading)
    return north * c + east * s, east * c - north * s


def write_track(sailed: Sailed, path: Path) -> None:
    """Write the track as CSV, SI and radians, a missing value empty. ConfigError if it cannot."""
    columns = (
        sailed.t,
        sailed.east,
        sailed.north,
        sailed.heading,
        sailed.yaw_rate,
        sailed.sway,
        sailed.ahead,
    )
    try:
        with replacing(path) as made, made.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(HEADS)
            for row in zip(*columns, strict=True):
                writer.writerow(["" if math.isnan(x) else repr(float(x)) for x in row])
    except OSError as error:
        raise ConfigError(f"--csv {path}: cannot be written: {error.strerror}") from error

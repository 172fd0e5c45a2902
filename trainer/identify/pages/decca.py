"""``trainer ship decca``: Decca lanes to sway velocity, as text and as a plot (DECCON).

It is for trials whose ships had no log of sway. Section 11 with equations 5.7-5.9 re-derived. Decca
was a chain of radio stations: a receiver counts lanes, hyperbolas between the master and a slave,
and two of them cross at the ship. The master station is at the origin, slaves at (u, v) [m] in a
plane grid. A lane is counted from the master: L = (MS + MP - SP)/d, MS the base line, P the ship, d
the wavelength, twice a lane's width on that line. Velocities are in knots on the page, in m/s in
the data.
"""

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import combinations
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np

from trainer.config.files import ConfigError, Position, collecting, parse_toml, quote, read_text
from trainer.config.schema import (
    Choice,
    Rows,
    Text,
    above,
    optional,
    required,
    with_default,
    within,
)
from trainer.config.ship.fit_options import FIT_KINDS
from trainer.config.tables import CsvTable, read_table
from trainer.core.kernel import Numbers
from trainer.identify.record.sources import write_columns
from trainer.identify.record.study import read_parts
from trainer.identify.record.track import (
    Drift,
    derivative,
    even_interval,
    smooth_spencer,
    through_water,
)
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, cut_text, format_number, table
from trainer.units import KNOT

ZONE_LETTERS: Final = "ABCDEFGHIJ"
LANE_ZONES: Final = {  # the lanes of a zone by their names, from the first to the last
    "red": range(24),
    "green": range(30, 48),
    "purple": range(50, 80),
}
GRID_LIMITS_M: Final = within(-1e7, 1e7)
PROPAGATION_SPEED_KM_S: Final = 299_700.0  # [km/s] usual of long waves over sea
MIN_FIXES: Final = 5  # of a track at least, because velocities come from neighbours
MAX_ROWS_SHOWN: Final = 20  # rows
NUMBER_FORMS: Final = (
    (1.0, ".1f"),
    (1.0, ".1f"),
    (KNOT, ".3f"),
    (KNOT, ".2f"),
)  # of the page's numbers


class Point(NamedTuple):
    """A location in the grid [m]: x east, y north, or the chain's own axes."""

    x: float
    y: float


class Slave(NamedTuple):
    """A slave station: its location, and twice its lanes' width on the base line [m]."""

    location: Point
    width: float

    @property
    def base(self) -> float:
        """Return the length of the base line [m]."""
        return math.hypot(*self.location)


Chain = Mapping[str, Slave]  # by colour


def lane_number(colour: str, text: str) -> float:
    """Return the lane of a reading such as D12.34, in lanes from zone A.

    ConfigError if it is no lane, or the zone of that colour has no such lane.
    """
    match = re.fullmatch(r"\s*([A-Ja-j])\s*(\d+(?:\.\d*)?)\s*", text)
    if match is None:
        raise ConfigError(f"{colour} lane {quote(text)}: must be a zone A to J and a lane: D12.34")
    zone, number = LANE_ZONES[colour], float(match[2])
    if not zone.start <= number < zone.stop:
        raise ConfigError(
            f"{colour} lane {quote(text)}: zones of {colour} have lanes {zone[0]} to {zone[-1]}"
        )
    return ZONE_LETTERS.index(match[1].upper()) * len(zone) + number - zone.start


def resolve_lane(colour: str, lane: float, expected: float) -> float:
    """Return the lane of that name which is nearest to the ``expected`` one.

    A name alone is not enough, because zones A to J repeat.
    """
    cycle = len(LANE_ZONES[colour]) * len(ZONE_LETTERS)
    return lane + cycle * round((expected - lane) / cycle)


def lane_at(slave: Slave, ship: Point) -> float:
    """Return the lane [lanes] that a receiver at ``ship`` shows (5.1)."""
    to_slave = math.hypot(ship.x - slave.location.x, ship.y - slave.location.y)
    return (slave.base + math.hypot(*ship) - to_slave) / slave.width


def fixes(first: Slave, second: Slave, lanes: tuple[float, float]) -> tuple[Point, ...]:
    """Return the locations, none to two, that have these lanes of two colours (5.7-5.9).

    ConfigError if master and both slaves are in one line.
    """
    (u1, v1), (u2, v2) = first.location, second.location
    delta = u1 * v2 - u2 * v1
    if abs(delta) <= 1e-9 * first.base * second.base:
        raise ConfigError("master and both slaves are in one line: no fix from these two colours")
    P1 = lanes[0] * first.width - first.base
    P2 = lanes[1] * second.width - second.base
    q1, q2 = 0.5 * (first.base**2 - P1**2), 0.5 * (second.base**2 - P2**2)
    bx, gx = (P1 * v2 - P2 * v1) / delta, (q1 * v2 - q2 * v1) / delta
    by, gy = (u1 * P2 - u2 * P1) / delta, (u1 * q2 - u2 * q1) / delta
    a, b, c = bx * bx + by * by - 1.0, 2.0 * (bx * gx + by * gy), gx * gx + gy * gy
    inside = b * b - 4.0 * a * c
    if inside < 0.0:
        return ()
    half = -0.5 * (b + math.copysign(math.sqrt(inside), b))  # no root by cancellation
    ranges = [c / half] if half else [0.0]
    if abs(a) > 1e-14 and half:
        ranges.append(half / a)
    slack = -1e-6 * max(first.base, second.base)
    return tuple(
        Point(bx * h + gx, by * h + gy)
        for h in dict.fromkeys(ranges)
        if h >= slack and h - P1 >= slack and h - P2 >= slack
    )


def sharpness(first: Slave, second: Slave, ship: Point) -> float:
    """Return how well two colours cross at a location [-], 0 to 4.

    It is the area of their gradients: the sine of the angle at which the lanes cross, times how
    narrow the lanes are there. ``track`` takes the best pair.
    """
    distance = math.hypot(*ship) or 1.0
    gradients = []
    for slave in (first, second):
        x, y = ship.x - slave.location.x, ship.y - slave.location.y
        other = math.hypot(x, y) or 1.0
        gradients.append((ship.x / distance - x / other, ship.y / distance - y / other))
    (x1, y1), (x2, y2) = gradients
    return abs(x1 * y2 - y1 * x2)


class Fix(NamedTuple):
    """A location, and the two colours that cross there; none where they do not."""

    location: Point
    colours: tuple[str, ...]


NO_FIX: Final = Fix(Point(math.nan, math.nan), ())


def track(chain: Chain, readings: Sequence[Mapping[str, float]], start: Point) -> list[Fix]:
    """Return a fix for each set of lanes by colour, NO_FIX where they give none.

    The last location (``start`` at first) resolves the lanes and chooses the two colours that cross
    best there. Two hyperbolas may cross twice; then the nearer location is taken.
    """
    track_fixes, last = list[Fix](), start
    for reading in readings:
        known = [colour for colour in chain if not math.isnan(reading.get(colour, math.nan))]
        lanes = {c: resolve_lane(c, reading[c], lane_at(chain[c], last)) for c in known}
        pairs = [(chain[a], chain[b], (a, b)) for a, b in combinations(known, 2)]
        track_fixes.append(NO_FIX)
        for one, two, colours in sorted(pairs, key=lambda pair: -sharpness(pair[0], pair[1], last)):
            if locations := fixes(one, two, (lanes[colours[0]], lanes[colours[1]])):
                last = min(locations, key=lambda at: math.dist(at, last))
                track_fixes[-1] = Fix(last, colours)
                break
    return track_fixes


@dataclass(frozen=True, kw_only=True)
class DeccaHeading:
    """The run of a ship, and the lie of the grid."""

    schema: str = required(Choice(("decca/1",), "form of the file"))
    name: str = required(Text(79, "what was sailed"))
    data: str = required(Text(200, "CSV file of lanes and heading, from this file's folder"))
    start_east_m: float = required("m", GRID_LIMITS_M, "place at the first row, from the master")
    start_north_m: float = required("m", GRID_LIMITS_M, "likewise")
    convergence_deg: float = with_default(
        0.0, "deg", within(-180, 180), "true less grid heading; else 0"
    )
    grid_scale: float = with_default(
        1.0, "-", within(0.5, 2), "grid distance over true distance; else 1"
    )
    current_east_kn: float = with_default(0.0, "kn", within(-20, 20), "taken off; else 0")
    current_north_kn: float = with_default(0.0, "kn", within(-20, 20), "likewise")
    positive_rudder: str = with_default("port", FIT_KINDS["positive_rudder"])


@dataclass(frozen=True, kw_only=True)
class SlaveRow:
    """One slave station."""

    colour: str = required(Choice(tuple(LANE_ZONES), "of its lanes"))
    east_m: float = required("m", GRID_LIMITS_M, "place from the master, in the grid")
    north_m: float = required("m", GRID_LIMITS_M, "likewise")
    lane_m: float | None = optional("m", above(0, 1e5), "twice a lane's width on the base line")
    frequency_khz: float | None = optional(
        "kHz", above(0, 1e4), "comparison frequency, instead of lane_m"
    )
    propagation_km_s: float = with_default(
        PROPAGATION_SPEED_KM_S,
        "km/s",
        within(2.9e5, 3e5),
        f"of the waves; else {PROPAGATION_SPEED_KM_S:g}",
    )


@dataclass(frozen=True, kw_only=True)
class ColumnNames:
    """Headings of the CSV file."""

    t_s: str = with_default("t", Text(80, "times [s]; else t"))
    heading_deg: str = with_default("heading", Text(80, "true heading [deg]; else heading"))
    yaw_rate_deg_s: str | None = optional(Text(80, "yaw rate; else from the heading"))
    rudder_deg: str | None = optional(Text(80, "rudder, for the record written; else none"))
    red: str = with_default("red", Text(80, "red lanes, D12.34 or numbers; else red"))
    green: str = with_default("green", Text(80, "green lanes; else green"))
    purple: str = with_default("purple", Text(80, "purple lanes; else purple"))


@dataclass(frozen=True, kw_only=True)
class ShipTable:
    """Where the antenna is."""

    antenna_m: float = required("m", within(-600, 600), "forward of the point wanted")


SLAVE_ROWS: Final = Rows(SlaveRow, ("note",), 2, 3, "slave stations, below")
DECCA_TABLES: Final = {"columns": ColumnNames, "ship": ShipTable}
KNOWN_KEYS: Final = (*(item.name for item in fields(DeccaHeading)), "note", "slaves", *DECCA_TABLES)


class DeccaFile(NamedTuple):
    """Everything a file of a Decca trial says."""

    path: Path
    heading: DeccaHeading
    chain: Chain
    columns: ColumnNames
    ship: ShipTable | None


def load_decca(path: Path) -> DeccaFile:
    """Return the study in a TOML file; ConfigError with all that is wrong."""
    position = Position(path.name, "")
    table = parse_toml(read_text(path), path.name)
    parts, problems = read_parts(table, position, (DeccaHeading, KNOWN_KEYS), DECCA_TABLES)
    chain: dict[str, Slave] = {}
    with collecting(problems):
        for i, row in enumerate(SLAVE_ROWS.read("slaves", table.get("slaves", []), position)):
            inside = position.inside(f"slaves[{i}]")
            if row.colour in chain:
                problems.append(inside.wrong("colour", row.colour, "is given twice"))
            if (row.lane_m is None) == (row.frequency_khz is None):
                problems.append(inside.problem("give one of lane_m, frequency_khz"))
            width = row.lane_m or row.propagation_km_s / (row.frequency_khz or 1.0)
            chain[row.colour] = Slave(Point(row.east_m, row.north_m), width)
    if problems:
        raise ConfigError(*problems)
    columns = parts["columns"] or ColumnNames()
    return DeccaFile(path, parts["heading"], chain, columns, parts["ship"])


@dataclass(frozen=True)
class ShipTrack:
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


def solve_track(file: DeccaFile, *, smooth: bool) -> ShipTrack:
    """Return the track and sway velocity of a study.

    ConfigError naming row and column of what is wrong, or if too few rows have a fix, or times are
    not even.
    """
    said, names, source = file.heading, file.columns, file.path.parent / file.heading.data
    table = read_table(source)
    t = table.known(table.index(names.t_s))
    true = np.radians(table.known(table.index(names.heading_deg)))
    lanes = {colour: _lanes(table, colour, getattr(names, colour)) for colour in file.chain}
    own_rate, rudder = (
        np.radians(table.known(table.index(name))) if name else None
        for name in (names.yaw_rate_deg_s, names.rudder_deg)
    )
    interval = even_interval(t, str(source))
    readings = [dict(zip(lanes, row, strict=True)) for row in zip(*lanes.values(), strict=True)]
    track_fixes = track(file.chain, readings, Point(said.start_east_m, said.start_north_m))
    if sum(fix is not NO_FIX for fix in track_fixes) < MIN_FIXES:
        raise ConfigError(
            f"{file.path.name}: fewer than {MIN_FIXES} rows give a fix; is the start right?"
        )
    east, north = np.array([fix.location for fix in track_fixes]).T
    heading = np.unwrap(true) - math.radians(said.convergence_deg)
    rate = derivative(heading, interval) if own_rate is None else own_rate
    sides = (side / said.grid_scale for side in (east, north))
    x, y = (smooth_spencer(side) if smooth else side for side in sides)
    current = KNOT * said.current_east_kn, KNOT * said.current_north_kn
    drift = Drift(*current, file.ship.antenna_m if file.ship else 0.0)
    ground = derivative(x, interval), derivative(y, interval)
    ahead, sway = through_water(*ground, heading, rate, drift)
    if rudder is not None and said.positive_rudder == "starboard":
        rudder = -rudder
    colours = tuple("+".join(fix.colours) for fix in track_fixes)
    return ShipTrack(said.name, t, east, north, heading, rate, sway, ahead, rudder, colours)


def _lanes(table: CsvTable, colour: str, name: str) -> list[float]:
    """Return the lanes that cells name or count, NaN of an empty one; ConfigError with the row."""
    index, lanes = table.index(name), []
    for row, cells in enumerate(table.cells):
        text = cells[index]
        if text[:1].upper() not in tuple(ZONE_LETTERS):
            lanes.append(table.number(row, index, text))
            continue
        try:
            lanes.append(lane_number(colour, text))
        except ConfigError as wrong:
            raise ConfigError(f"{table.path}: row {table.lines[row]}: {wrong}") from None
    return lanes


def write_track(sailed: ShipTrack, path: Path) -> None:
    """Write the track as CSV, SI and radians, a missing value empty. ConfigError if it fails."""
    columns = {"t": sailed.t, "east": sailed.east, "north": sailed.north}
    columns |= {"psi": sailed.heading, "r": sailed.yaw_rate, "v": sailed.sway, "u": sailed.ahead}
    if sailed.rudder is not None:
        columns["delta_r"] = sailed.rudder
    write_columns(path, columns)


@dataclass(frozen=True)
class DeccaReport:
    """The answer of ``trainer ship decca``, as printed and as ``--json`` has it.

    NaN, null in JSON, is where lanes or neighbours lack.
    """

    source: str
    rows: int
    fixed: int
    smoothed: bool
    t_s: tuple[float, ...]
    east_m: tuple[float, ...]
    north_m: tuple[float, ...]
    sway_m_s: tuple[float, ...]
    ahead_m_s: tuple[float, ...]
    colours: tuple[str, ...]


def report_of(sailed: ShipTrack, *, smooth: bool) -> DeccaReport:
    """Return the report of a track."""
    columns = (sailed.t, sailed.east, sailed.north, sailed.sway, sailed.ahead)
    t, east, north, sway, ahead = (tuple(one.tolist()) for one in columns)
    known = sailed.source, len(t), sum(map(bool, sailed.colours)), smooth
    return DeccaReport(*known, t, east, north, sway, ahead, sailed.colours)


def render(report: DeccaReport) -> str:
    """Return the report as text: at most MAX_ROWS_SHOWN rows of the track, evenly spaced."""
    numbers = zip(report.east_m, report.north_m, report.sway_m_s, report.ahead_m_s, strict=True)
    rows = [
        (
            f"{t:g}",
            *(
                format_number(None if math.isnan(x) else x / unit, form)
                for x, (unit, form) in zip(row, NUMBER_FORMS, strict=True)
            ),
            colours or "no fix",
        )
        for t, row, colours in zip(report.t_s, numbers, report.colours, strict=True)
    ]
    heads = ("t\n[s]", "east\n[m]", "north\n[m]", "sway\n[kn]", "ahead\n[kn]", "by\n")
    how = "smoothed by Spencer's 15 points" if report.smoothed else "not smoothed"
    return "\n".join(
        [
            "DECCA TRACK (DECCON)",
            f"{INDENT}{cut_text(report.source, 70)}",
            f"{INDENT}{report.fixed} of {report.rows} rows have a fix; {how}",
            "",
            *table(heads, rows[:: max(1, -(-report.rows // MAX_ROWS_SHOWN))]),
        ]
    )


def panels(sailed: ShipTrack) -> tuple[Panel, ...]:
    """Return track and sway velocity."""
    track = (Curve("fixes", sailed.east, sailed.north),)
    sway = (Curve("sway", sailed.t, sailed.sway / KNOT),)
    return (
        Panel("track, from the master station", "east [m]", "north [m]", track),
        Panel("sway velocity", "time [s]", "to starboard [kn]", sway, levels=(0.0,)),
    )

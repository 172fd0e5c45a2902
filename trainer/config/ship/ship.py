"""The file of a ship: dimensions, columns of records, and a fit's result.

``trainer identify`` reads and writes it, and exercises sail it. One form serves both ways: what is
written before a fit, and what a fit writes, which sails.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Final

from trainer.config.files import (
    ConfigError,
    Position,
    as_table,
    collecting,
    nearest,
    parse_toml,
    read_text,
    toml_value,
)
from trainer.config.schema import (
    Choice,
    Quantities,
    Quantity,
    Rows,
    Text,
    above,
    describe_kind,
    file_schema,
    list_schema,
    optional,
    read_record,
    record_schema,
    required,
    with_default,
    within,
)
from trainer.config.ship.fit_options import FIT_KINDS
from trainer.config.ship.sensors import Sensors
from trainer.config.units import UNIT_FACTORS
from trainer.config.words import SHIP_FILE_SCHEMA

SHIP_SCHEMA: Final = SHIP_FILE_SCHEMA
MAX_LENGTH_M: Final = 500.0  # [m] the longest ship is shorter
UNIT_NAMES: Final = ", ".join(
    " ".join(UNIT_FACTORS[one]) for one in ("s", "rad", "rad/s", "m/s", "1/s")
)
COLUMN_SCALE: Final = Quantity("-", within(-1e9, 1e9), "units to 1 in the column")
COLUMN_OFFSET: Final = Quantity("-", within(-1e9, 1e9), "units at 0 in the column")
# fmt: off
SHIP_CHANNELS: Final = (
    "t", "rudder", "revolutions", "speed", "sway", "yaw_rate", "heading",
    "north_velocity", "east_velocity", "wind_speed", "wind_from",
    "wind_ahead", "wind_starboard", "roll", "roll_rate",
)
# fmt: on
MAX_ROWS: Final = 100  # of a covariance, for editors
NUMBER_LIMITS: Final = within(-1e9, 1e9)
ROLL_GYRATION_BEAMS: Final = 0.38  # [-] of the beam: radius of gyration in roll, with the water
GRAVITY_M_S2: Final = 9.81  # [m/s^2]
COEFFICIENT_NUMBER: Final = Quantity("-", NUMBER_LIMITS, "coefficient")
# of two that know nothing of each other it is as small as rounding makes it
COVARIANCE_NUMBER: Final = Quantity("-", NUMBER_LIMITS, "covariance", least=0.0)


@dataclass(frozen=True, kw_only=True)
class ShipHeading:
    """The name of a ship."""

    schema: str = required(Choice((SHIP_SCHEMA,), "form of the file"))
    name: str = required(Text(79, "name shown"))


@dataclass(frozen=True, kw_only=True)
class Dimensions:
    """A ship and its propeller."""

    length_m: float = required("m", within(0.1, MAX_LENGTH_M), "between perpendiculars")
    propeller_diameter_m: float = required("m", within(0.01, 15), "of one propeller")
    wake_fraction: float = required("-", within(0, 0.8), "w: the propeller meets (1-w) u")
    thrust: tuple[float, ...] = required(
        Quantities(Quantity("-", within(-5, 5), "K_T = k0 + k1 J + k2 J^2"), 3, 3)
    )
    advance_m: float | None = optional(
        "m", within(0.001, 100), "a turn, from which further terms count the speed"
    )
    beam_m: float | None = optional("m", within(0.05, 100), "for the prior")
    draught_m: float | None = optional("m", within(0.01, 40), "for the prior")
    block_coefficient: float | None = optional("-", within(0.3, 0.95), "for the prior")
    rudder_area_m2: float | None = optional("m^2", above(0, 500), "for the prior")
    rudder_height_m: float | None = optional("m", above(0, 30), "for the prior")
    rudder_limit_deg: float = with_default(35.0, "deg", within(1, 90), "limit; else 35")
    rudder_rate_deg_s: float = with_default(
        2.32, "deg/s", within(0.01, 1000), "rate; else 2.32, of a full-size ship"
    )


@dataclass(frozen=True, kw_only=True)
class Roll:
    """A ship whose roll is fitted too."""

    gm_m: float = required("m", above(0, 20), "metacentric height")
    radius_m: float | None = optional(
        "m", above(0, 50), "of gyration, with the water; else 0.38 of the beam"
    )


@dataclass(frozen=True, kw_only=True)
class RecordSettings:
    """How the ship's records are meant."""

    positive_rudder: str | None = optional(FIT_KINDS["positive_rudder"])
    between_readings: str | None = optional(FIT_KINDS["between_readings"])
    anyway: str | None = optional(FIT_KINDS["anyway"])
    current: str | None = optional(
        Choice(("none",), "said where velocities are over ground, and the water stood still")
    )
    interval_s: float | None = optional(
        "s", within(1e-4, 3600), "from row to row, instead of the times"
    )


MISSING_NUMBERS: Final = Quantities(
    Quantity("-", within(-1e15, 1e15), "in this column they say that there is no reading"), 1, 20
)


@dataclass(frozen=True, kw_only=True)
class ShipColumn:
    """Where one channel of a record is found; columns of the trainer need none."""

    channel: str = required(Choice(SHIP_CHANNELS, "what it is"))
    column: str = required(Text(80, "heading of the column"))
    unit: str | None = optional(Text(8, f"{UNIT_NAMES}; else that of the heading"))
    missing: tuple[float, ...] | None = optional(MISSING_NUMBERS)
    scale: float | None = optional(COLUMN_SCALE)
    offset: float | None = optional(COLUMN_OFFSET)


@dataclass(frozen=True, kw_only=True)
class FitResult:
    """The fit that a file holds."""

    model: str = required(Choice(("linear", "mavmm", "abkowitz", "mmg"), "model"))
    speed_kn: float = required("kn", within(0.01, 60), "at which manoeuvres begin")
    revolutions_per_s: float = required("1/s", within(-50, 50), "that keep it there")


COLUMN_ROWS: Final = Rows(ShipColumn, ("note",), 0, len(SHIP_CHANNELS), "columns, below")
SHIP_TABLES: Final = {
    "dimensions": Dimensions,
    "roll": Roll,
    "records": RecordSettings,
    "sensors": Sensors,
    "result": FitResult,
}


@dataclass(frozen=True, kw_only=True)
class ShipFile:
    """A ship as its file tells it; without a result it cannot sail."""

    path: Path
    name: str
    dimensions: Dimensions
    records: RecordSettings
    sensors: Sensors | None
    columns: tuple[ShipColumn, ...]
    roll: Roll | None = None
    result: FitResult | None = None
    coefficients: Mapping[str, float] = field(default_factory=dict)
    covariance: tuple[tuple[float, ...], ...] | None = None  # of those ``uncertain``
    uncertain: tuple[str, ...] = ()
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def stiffness(self) -> float:
        """Return g GM/k^2 [1/s^2] of roll, as its file says; 0 where there is none."""
        if self.roll is None:
            return 0.0
        radius = self.roll.radius_m or ROLL_GYRATION_BEAMS * (self.dimensions.beam_m or math.inf)
        return GRAVITY_M_S2 * self.roll.gm_m / radius**2

    @property
    def constants(self) -> tuple[float, ...]:
        """Return length, diameter, K_T, 1-w, advance and stiffness, as the kernels take them."""
        hull = self.dimensions
        propeller = hull.propeller_diameter_m, *hull.thrust, 1.0 - hull.wake_fraction
        return hull.length_m, *propeller, hull.advance_m or 0.0, self.stiffness


def is_ship(path: Path) -> bool:
    """Return whether a TOML file is of a ship. ConfigError if it is no TOML."""
    return parse_toml(read_text(path), path.name).get("schema") == SHIP_SCHEMA


def load_ship(path: Path) -> ShipFile:
    """Return the ship in a file; ConfigError with all that is wrong."""
    return parse_ship(read_text(path), path)


def parse_ship(text: str, path: Path) -> ShipFile:
    """Return the ship in ``text``, which came from ``path``; ConfigError with all faults."""
    return read_ship(parse_toml(text, path.name), path)


def read_ship(table: Mapping[str, Any], path: Path) -> ShipFile:
    """Return the ship in the tables of the file ``path``; ConfigError with all faults."""
    position = Position(path.name, "")
    known = ("schema", "name", *SHIP_TABLES, "columns", "coefficients", "covariance", "ranges")
    problems = [
        position.wrong(key, value, f"no such key{nearest(key, known)}")
        for key, value in table.items()
        if key not in (*known, "note", "source")
    ]
    parts: dict[str, Any] = {"sensors": None, "result": None, "roll": None}
    heading_values = {key: table[key] for key in ("schema", "name") if key in table}
    with collecting(problems):
        parts["name"] = read_record(ShipHeading, heading_values, position, ()).name
    for key, record in SHIP_TABLES.items():
        if key in table or key in ("dimensions", "records"):
            with collecting(problems):
                content = table.get(key, {} if key == "records" else None)
                if content is None:
                    raise ConfigError(position.problem(f"lacks [{key}]"))
                parts[key] = read_record(record, content, position.inside(key), ("note",))
    with collecting(problems):
        parts["columns"] = COLUMN_ROWS.read("columns", table.get("columns", []), position)
    if "result" in table:
        with collecting(problems):
            parts |= _numbers(table, position)
    if problems:
        raise ConfigError(*(_with_feet(problem) for problem in problems))
    ship = ShipFile(path=path, **parts)
    if ship.roll is not None and ship.stiffness == 0.0:
        inside = position.inside("roll")
        raise ConfigError(inside.problem("lacks radius_m, or beam_m in [dimensions]"))
    return ship


def _with_feet(problem: str) -> str:
    """Return a problem; beside a length that is too long, what it may be."""
    if "length_m" in problem and f"to {MAX_LENGTH_M:g}" in problem:
        return f"{problem}; is it in feet? 1 m is 3.281 feet"
    return problem


def _numbers(table: Mapping[str, Any], position: Position) -> dict[str, Any]:
    """Return coefficients, covariance and ranges of a result; ConfigError if one is wrong."""
    tables = {
        key: as_table(table.get(key, {}), position.inside(key))
        for key in ("coefficients", "covariance", "ranges")
    }
    numbers = {
        name: COEFFICIENT_NUMBER.read(name, value, position.inside("coefficients"))
        for name, value in tables["coefficients"].items()
    }
    if not numbers:
        raise ConfigError(position.problem("[result] needs [coefficients]"))
    rows = tables["covariance"]
    names = tuple(rows)
    inside = position.inside("covariance")
    line = Quantities(COVARIANCE_NUMBER, max(len(names), 1), max(len(names), 1))
    matrix = tuple(line.read(name, row, inside) for name, row in rows.items())
    strange = [name for name in names if name not in numbers]
    if strange:
        raise ConfigError(inside.problem(f"{strange[0]} is no coefficient of the file"))
    pair = Quantities(Quantity("-", NUMBER_LIMITS, "range"), 2, 2)
    ranges = {
        name: (low, high)
        for name, value in tables["ranges"].items()
        for low, high in [pair.read(name, value, position.inside("ranges"))]
    }
    return {
        "coefficients": numbers,
        "covariance": matrix if names else None,
        "uncertain": names,
        "ranges": ranges,
    }


def ship_text(ship: ShipFile, source: str) -> str:
    """Return the text of a ship's file."""
    heading = {"schema": SHIP_SCHEMA, "name": ship.name, "source": source}
    lines = [f"{key} = {toml_value(value)}" for key, value in heading.items()]
    lines += _table_lines("dimensions", ship.dimensions)
    if ship.roll is not None:
        lines += _table_lines("roll", ship.roll)
    lines += _table_lines("records", ship.records)
    if ship.sensors is not None:
        lines += _table_lines("sensors", ship.sensors)
    for column in ship.columns:
        lines += _table_lines("[columns]", column)
    if ship.result is not None:
        lines += _table_lines("result", ship.result)
        lines += ["", "[coefficients]  # accelerations in prime units"]
        lines += [f"{name} = {toml_value(value)}" for name, value in ship.coefficients.items()]
        lines += ["", "[ranges]  # of the records: v', r' [-], rudder, roll [rad], speed [m/s]"]
        lines += [f"{name} = {toml_value(ends, '.6g')}" for name, ends in ship.ranges.items()]
    if ship.covariance is not None:
        lines += ["", "[covariance]  # rows in the order of the names"]
        for name, row in zip(ship.uncertain, ship.covariance, strict=True):
            lines.append(f"{name} = {toml_value(row, '.9g')}")
    return "\n".join(lines) + "\n"


def _table_lines(name: str, record: Any) -> list[str]:
    """Return a record as the lines of a table."""
    lines = ["", f"[{name}]"]
    for item in fields(record):
        value = getattr(record, item.name)
        if value is None or value == ():
            continue
        lines.append(f"{item.name} = {toml_value(value)}")
    return lines if len(lines) > 2 else []


def ship_schema() -> dict[str, Any]:
    """Return the JSON Schema of a ship's file."""
    heading = record_schema(ShipHeading, ("note", "source"))
    tables = {name: record_schema(record, ("note",)) for name, record in SHIP_TABLES.items()}
    row = list_schema(COVARIANCE_NUMBER.form.schema, 1, MAX_ROWS)
    numbers = {
        "coefficients": ("accelerations in prime units", COEFFICIENT_NUMBER.form.schema),
        "covariance": ("rows in the order of the names", row),
        "ranges": ("seen in the records", list_schema(COEFFICIENT_NUMBER.form.schema, 2, 2)),
    }
    named = {
        key: {"type": "object", "description": meaning, "additionalProperties": form}
        for key, (meaning, form) in numbers.items()
    }
    keys = {**heading["properties"], **tables, "columns": describe_kind(COLUMN_ROWS), **named}
    return file_schema("ship", keys, (*heading["required"], "dimensions"))

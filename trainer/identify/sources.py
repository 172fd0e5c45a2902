"""Records from files, and instruments between a recording's exact state and a record."""

import csv
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.analysis.recording_export import table_layout
from trainer.config.files import ConfigError, nearest, quote
from trainer.config.schema import Quantity, optional, within
from trainer.core.kernel import Numbers
from trainer.identify.measurements import CHANNELS, Record
from trainer.io.paths import SUFFIX
from trainer.session.header import reading
from trainer.units import DEGREE, KNOT

UNITS: Final[Mapping[str, Mapping[str, float]]] = {  # to SI and radians
    "s": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    "rad": {"rad": 1.0, "deg": DEGREE},
    "rad/s": {"rad/s": 1.0, "deg/s": DEGREE, "deg/min": DEGREE / 60.0},
    "m/s": {"m/s": 1.0, "kn": KNOT},
}
OWN: Final = {  # columns of the trainer, SI and radians
    "rudder": "delta_r",
    "heading": "psi",
    "yaw_rate": "r",
    "sway": "v",
    "speed": "u",
}
EMPTY: Final = ("", "nan", "na", "null", "-")


@dataclass(frozen=True)
class Column:
    """The source of a channel: its column, and the factor from its unit to SI."""

    name: str
    scale: float


def own_columns() -> dict[str, Column]:
    """Return the columns of the trainer's own files, times among them."""
    return {"t": Column("t", 1.0)} | {key: Column(name, 1.0) for key, name in OWN.items()}


def factor(channel: str, unit: str) -> float:
    """Return what numbers in ``unit`` are times in SI. ConfigError if the channel has none such."""
    known = UNITS["s" if channel == "t" else CHANNELS[channel]]
    if unit not in known:
        raise ConfigError(f"{channel}: unit {quote(unit)}: must be {' or '.join(known)}")
    return known[unit]


def load_record(path: Path, columns: Mapping[str, Column]) -> Record:
    """Return the record in a CSV file or a recording. ConfigError naming what is wrong with it.

    ``columns`` says where each channel is, and under "t" the times; without "t" rows are counted.
    """
    table = _read_recording(path) if path.suffix == SUFFIX else _read_csv(path)
    problems = [
        f"{path}: no column {quote(column.name)} for {channel}{nearest(column.name, table.names)}; "
        f"it has {', '.join(table.names)}"
        for channel, column in columns.items()
        if column.name not in table.names
    ]
    if problems:
        raise ConfigError(*problems)
    taken = {channel: table.taken(column) for channel, column in columns.items()}
    times = taken.pop("t", np.arange(len(table.rows), dtype=float))
    record = Record(
        source=str(path),
        t=times,
        rows=np.array(table.rows),
        names={channel: column.name for channel, column in columns.items()},
        **taken,
    )
    check_times(record)
    return record


@dataclass(frozen=True)
class _Table:
    """What a source holds; ``rows`` as people count."""

    names: tuple[str, ...]
    rows: list[int]
    numbers: Numbers  # (rows, names)

    def taken(self, column: Column) -> Numbers:
        """Return a column in SI."""
        return np.asarray(self.numbers[:, self.names.index(column.name)] * column.scale)


def _read_csv(path: Path) -> _Table:
    """Return the columns of a CSV file, NaN where a cell is empty."""
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            lines = csv.reader(file)
            names = tuple(name.strip() for name in next(lines, []))
            cells = [
                (lines.line_num, _cells(path, lines.line_num, names, row)) for row in lines if row
            ]
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise ConfigError(f"{path}: is not a CSV text: {error}") from error
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    if twice:
        raise ConfigError(f"{path}: column {quote(twice[0])} is given twice")
    return _table(path, names, cells)


def _cells(path: Path, line: int, names: tuple[str, ...], row: list[str]) -> list[float]:
    """Return the numbers of one row; ConfigError naming row and column if one is none."""
    if len(row) != len(names):
        raise ConfigError(f"{path}: row {line}: has {len(row)} fields, the heading {len(names)}")
    numbers = []
    for name, text in zip(names, row, strict=True):
        if text.strip().casefold() in EMPTY:
            numbers.append(math.nan)
            continue
        try:
            number = float(text)
        except ValueError:
            number = math.inf
        if math.isinf(number):
            raise ConfigError(
                f"{path}: row {line}: {name} = {quote(text)}: must be a number, or empty"
            )
        numbers.append(number)
    return numbers


def _read_recording(path: Path) -> _Table:
    """Return the columns of the latest branch of a recording; a row is a tick."""
    with reading(path) as recording:
        layout = table_layout(recording)
        names = ("t", *layout.columns)
        cells = [
            (tick.tick, [tick.tick * layout.step, *layout.numbers(tick.state)])
            for tick in recording.flown(recording.branch)
        ]
    return _table(path, names, cells)


def _table(path: Path, names: tuple[str, ...], cells: Iterable[tuple[int, Any]]) -> _Table:
    """Return the table; ConfigError if it has fewer than two rows."""
    rows = list(cells)
    if len(rows) < 2:
        raise ConfigError(f"{path}: has {len(rows)} rows of numbers; needs 2 or more")
    return _Table(names, [row for row, _ in rows], np.array([numbers for _, numbers in rows]))


def check_times(record: Record) -> None:
    """Check that time is known and rises; ConfigError naming the first bad row."""
    missing = np.isnan(record.t)
    if missing.any():
        row = record.row(int(np.argmax(missing)))
        raise ConfigError(f"{record.source}: row {row}: {record.name('t')} has no value")
    rises = np.diff(record.t) > 0.0
    if rises.all():
        return
    place = int(np.argmin(rises)) + 1
    now, before = record.t[place], record.t[place - 1]
    how = "is repeated" if now == before else f"is before {before:g} s of the row before"
    raise ConfigError(
        f"{record.source}: row {record.row(place)}: {record.name('t')} = {now:g} s {how}; "
        "times must rise"
    )


DEVIATION: Final = within(0, 100)
STREAMS: Final = ("sway", "bow_sway", "stern_sway", "yaw_rate", "heading")


@dataclass(frozen=True, kw_only=True)
class Sensors:
    """Standard deviations of white errors added to an exact record; none where not said."""

    sway_kn: float | None = optional(Quantity("kn", DEVIATION, "of each log"))
    yaw_rate_deg_s: float | None = optional(Quantity("deg/s", DEVIATION, "of the rate gyro"))
    heading_deg: float | None = optional(Quantity("deg", DEVIATION, "of the compass"))
    seed: float | None = optional(Quantity("-", within(0, 1e15), "of the errors; else 1"))

    def error(self, channel: str) -> float:
        """Return the standard deviation of a channel, SI."""
        if channel == "yaw_rate":
            return math.radians(self.yaw_rate_deg_s or 0.0)
        if channel == "heading":
            return math.radians(self.heading_deg or 0.0)
        return KNOT * (self.sway_kn or 0.0)


USUAL: Final = Sensors(sway_kn=0.05, yaw_rate_deg_s=0.02, heading_deg=0.1)


def read_by(record: Record, sensors: Sensors) -> Record:
    """Return what instruments would have read; each channel has a stream of its own."""
    columns = {}
    for place, channel in enumerate(STREAMS):
        values = getattr(record, channel)
        if values is not None:
            seed = np.random.SeedSequence((int(sensors.seed or 1), place))
            stream = np.random.Generator(np.random.PCG64(seed))
            columns[channel] = values + sensors.error(channel) * stream.standard_normal(len(values))
    return replace(record, **columns)

"""Records from files, and the errors of instruments put on a recording's exact state.

A CSV file or a recording of the trainer becomes a ``Record`` in SI and radians. A recording has the
exact state, which no ship's instruments read, so a study's [sensors] add errors from its own seed.
"""

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.analysis.recording_export import table_layout
from trainer.config.files import ConfigError, collecting, nearest, quote
from trainer.config.sensors import Sensors
from trainer.config.tables import CsvTable, read_table, rebuild_times
from trainer.core.kernel import Numbers
from trainer.identify.record.codes import CODES_TEXT, find_codes, find_impossible, without_jumps
from trainer.identify.record.measurements import CHANNEL_UNITS, POSITION_CHANNELS, Finding, Record
from trainer.io.outputs import replacing
from trainer.io.paths import RECORDING_SUFFIX
from trainer.session.header import open_whole_recording
from trainer.units import DEGREE, KNOT

UNIT_FACTORS: Final[Mapping[str, Mapping[str, float]]] = {  # to SI and radians
    "s": {"s": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    "rad": {"rad": 1.0, "deg": DEGREE},
    "rad/s": {"rad/s": 1.0, "deg/s": DEGREE, "deg/min": DEGREE / 60.0},
    "m/s": {"m/s": 1.0, "kn": KNOT},
    "place": {"deg": DEGREE, "ddmm": DEGREE, "rad": 1.0},
}
TRAINER_COLUMNS: Final = {  # columns of the trainer, SI and radians
    "rudder": "delta_r",
    "heading": "psi",
    "yaw_rate": "r",
    "sway": "v",
    "speed": "u",
}
FURTHER_COLUMNS: Final = {  # likewise, of what a record has not: ships that are not linear
    "revolutions": "n",
    "wind_ahead": "wind_ahead",
    "wind_starboard": "wind_starboard",
    "roll": "phi",
    "roll_rate": "p",
}
FURTHER_CHANNELS: Final[Mapping[str, Mapping[str, float]]] = {  # channels and their units
    "revolutions": {"1/s": 1.0, "rps": 1.0, "rpm": 1.0 / 60.0},
    **dict.fromkeys(("north_velocity", "east_velocity"), UNIT_FACTORS["m/s"]),
    **dict.fromkeys(("wind_speed", "wind_ahead", "wind_starboard"), UNIT_FACTORS["m/s"]),
    "wind_from": UNIT_FACTORS["rad"],
    "roll": UNIT_FACTORS["rad"],
    "roll_rate": UNIT_FACTORS["rad/s"],
}
NO_UNIT: Final = "-"  # unit of a column that is taken as it stands
Taken = tuple[Sequence[int], dict[str, Any], list[str]]  # rows, channels in SI, what to tell
NOISE_STREAMS: Final = ("sway", "bow_sway", "stern_sway", "yaw_rate", "heading")
USUAL_SENSORS: Final = Sensors(sway_kn=0.05, yaw_rate_deg_s=0.02, heading_deg=0.1)


@dataclass(frozen=True)
class Column:
    """The source of a channel: its column and unit. None as a unit is as the file says."""

    name: str
    unit: str | None
    missing: tuple[float, ...] = ()  # numbers that say that there is no reading


def own_columns() -> dict[str, Column]:
    """Return the columns of the trainer's own files, times among them."""
    columns = {key: Column(name, CHANNEL_UNITS[key]) for key, name in TRAINER_COLUMNS.items()}
    return {"t": Column("t", "s"), **columns}


def units_of(channel: str) -> Mapping[str, float]:
    """Return the units that a channel can have, and what each is in SI."""
    if channel in FURTHER_CHANNELS:
        return FURTHER_CHANNELS[channel]
    return UNIT_FACTORS[
        "place"
        if channel in POSITION_CHANNELS
        else "s"
        if channel == "t"
        else CHANNEL_UNITS[channel]
    ]


def factor(channel: str, unit: str | None) -> float:
    """Return the factor from ``unit`` to SI; without a unit it is 1.

    ConfigError if the channel has no such unit.
    """
    if unit is None:
        return 1.0
    known = units_of(channel)
    if unit not in known:
        raise ConfigError(f"{channel}: unit {quote(unit)}: must be {' or '.join(known)}")
    return known[unit]


def load_record(path: Path, columns: Mapping[str, Column]) -> Record:
    """Return the record in a CSV file or a recording. ConfigError naming what is wrong with it.

    ``columns`` says where each channel is, and under "t" the times; without "t" rows are counted.
    """
    read = _read_recording if path.suffix == RECORDING_SUFFIX else _read_csv
    rows, taken, remarks = read(path, columns)
    if len(rows) < 2:
        raise ConfigError(f"{path}: has {len(rows)} rows of numbers; needs 2 or more")
    times = taken.pop("t", np.arange(len(rows), dtype=float))
    plain = {name: taken.pop(name) for name, one in columns.items() if one.unit == NO_UNIT}
    record = Record(
        source=str(path),
        t=times,
        rows=np.array(rows),
        names={channel: column.name for channel, column in columns.items()},
        findings=tuple(Finding(path.name, 0, text) for text in remarks),
        plain=plain,
        **taken,
    )
    check_times(record)
    return without_jumps(record)


class NoColumnError(ConfigError):
    """A file lacks columns that are to be read."""


def _read_csv(path: Path, columns: Mapping[str, Column]) -> Taken:
    """Return the wanted columns of a CSV file, NaN where a cell is empty."""
    table = read_table(path)
    lacking = [(name, one) for name, one in columns.items() if not table.has(one.name)]
    problems = list[str]()
    for channel, column in lacking:
        with collecting(problems):
            table.index(column.name, channel)
    if problems:
        raise NoColumnError(*problems)
    remarks, other = list(table.told), list[str]()
    taken = {channel: _take(table, channel, one, other) for channel, one in columns.items()}
    if "t" in columns:
        name = columns["t"].name
        if table.is_clock(table.index(name)):
            remarks.append("times by ISO 8601")
        taken["t"], rebuilt = rebuild_times(taken["t"], table.repeats)
        other += [f"{name}: {rebuilt}"] if rebuilt else []
    return table.lines, taken, ([f"read with {', '.join(remarks)}"] if remarks else []) + other


def _take(table: CsvTable, channel: str, column: Column, told: list[str]) -> Numbers:
    """Return a channel in SI; ConfigError if it has no unit, or a cell is no number."""
    index = table.index(column.name)
    if column.unit == NO_UNIT:
        numbers = table.numbers(index)
        if codes := find_codes(numbers):
            told.append(f"{column.name}: is {codes[0]:g} for no reading? then leave it empty")
        return numbers
    if channel == "t" and table.is_clock(index):
        return table.seconds(index)
    said, known = table.units[index], units_of(channel)
    unit = column.unit or said
    if unit not in known:
        where = f"the file says {quote(said)}" if said else "the file does not say its unit"
        raise ConfigError(
            f"{table.path}: {column.name} for {channel}: {where}: "
            f"say in the study unit = {' or '.join(map(quote, known))}"
        )
    if said and said != unit:
        told.append(f"{column.name} is in {said}, the study says {unit}: taken as {unit}")
    return read_channel(table, channel, column, unit)


def read_channel(table: CsvTable, channel: str, column: Column, unit: str) -> Numbers:
    """Return a column in SI, its ``missing`` numbers NaN; ConfigError naming what cannot be."""
    index, scale = table.index(column.name), units_of(channel)[unit]
    table = table.without(index, column.missing) if column.missing else table
    numbers = table.angles(index, unit) if channel in POSITION_CHANNELS else table.numbers(index)
    if fault := find_impossible(channel, numbers * scale, unit):
        remedy = f"say missing = [{table.cells[fault[0]][index]}] in its [[columns]]; {CODES_TEXT}"
        raise table.wrong(fault[0], index, f"{fault[1]} {remedy}")
    return numbers * scale


def _read_recording(path: Path, columns: Mapping[str, Column]) -> Taken:
    """Return the wanted columns of the latest branch of a recording; a row is a tick."""
    with open_whole_recording(path) as recording:
        layout = table_layout(recording)
        names = ("t", *layout.columns)
        ticks, cells = [], []
        for tick in recording.flown(recording.branch):
            ticks.append(tick.tick)
            cells.append([tick.tick * layout.step, *layout.numbers(tick.state)])
    taken = {}
    for channel, column in columns.items():
        if column.name not in names:
            raise ConfigError(
                f"{path}: no column {quote(column.name)} for {channel}"
                f"{nearest(column.name, names)}; it has {', '.join(names)}"
            )
        index = names.index(column.name)
        scale = 1.0 if column.unit == NO_UNIT else factor(channel, column.unit or "")
        taken[channel] = scale * np.array([row[index] for row in cells])
    return ticks, taken, []


def check_times(record: Record) -> None:
    """Check that time is known and rises; ConfigError naming the first bad row."""
    missing = np.isnan(record.t)
    if missing.any():
        row = record.row(int(np.argmax(missing)))
        raise ConfigError(f"{record.source}: row {row}: {record.name('t')} has no value")
    rises = np.diff(record.t) > 0.0
    if rises.all():
        return
    index = int(np.argmin(rises)) + 1
    now, before = record.t[index], record.t[index - 1]
    how = "is repeated" if now == before else f"is before {before:g} s of the row before"
    raise ConfigError(
        f"{record.source}: row {record.row(index)}: {record.name('t')} = {now:g} s {how}; "
        "times must rise"
    )


def write_columns(path: Path, columns: Mapping[str, Numbers], form: str = "") -> None:
    """Write columns as CSV, a missing value empty. ConfigError if it cannot be."""
    try:
        with replacing(path) as made, made.open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            for row in zip(*columns.values(), strict=True):
                writer.writerow(["" if math.isnan(x) else format(float(x), form) for x in row])
    except OSError as error:
        raise ConfigError(f"--csv {path}: cannot be written: {error.strerror}") from error


def read_by(record: Record, sensors: Sensors) -> Record:
    """Return what instruments would have read.

    Each channel has a random stream of its own, so that a further channel changes no other one.
    """
    columns = {}
    for index, channel in enumerate(NOISE_STREAMS):
        values = getattr(record, channel)
        if values is not None:
            seed = np.random.SeedSequence((int(sensors.seed or 1), index))
            stream = np.random.Generator(np.random.PCG64(seed))
            columns[channel] = values + sensors.error(channel) * stream.standard_normal(len(values))
    return replace(record, **columns)

"""Records from files and arrays, and the errors of instruments put on an exact state.

A CSV file, a recording of the trainer or arrays by channel (``trainer.identify.fit``) become a
``Record`` in SI and radians; names and units are resolved alike. A recording has the exact state,
which no ship's instruments read, so a study's [sensors] add errors from its own seed. Numbers that
loggers write where there is no reading, 511 or -9999, are told from readings, because a filter
follows them as if the ship had jumped.
"""

import csv
import math
import re
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from trainer.config.files import ConfigError, collecting, nearest, quote
from trainer.config.ship.sensors import Sensors
from trainer.config.tables import CsvTable, read_table, rebuild_times
from trainer.config.units import KNOWN_UNITS, SCALELESS_UNITS, UNIT_FACTORS, spell_unit
from trainer.core.kernel import Numbers
from trainer.debrief.passage.recording_export import table_layout
from trainer.identify.record.log_columns import Log
from trainer.identify.record.logs import read_log
from trainer.identify.record.measurements import (
    BOAT_CHANNEL_UNITS,
    CHANNEL_UNITS,
    FIN_CHANNELS,
    POSITION_CHANNELS,
    SHIP_CHANNEL_UNITS,
    Finding,
    Record,
)
from trainer.identify.record.readings import keep_readings
from trainer.io.outputs import replacing
from trainer.io.paths import RECORDING_SUFFIX
from trainer.session.past.header import open_whole_recording

USUAL_CODES: Final = (
    *(511.0, 655.35, 999.0, 999.9, 9999.0, 32767.0, 65535.0, 99999.0),
    *(-999.0, -9999.0, -32767.0, -32768.0, -99999.0),
)
CODES_TEXT: Final = "usual are 511, 999, -9999, 32767, 65535, of AIS 91 and 102.3"
MAX_SIZES: Final = {  # of what a ship does, SI: beyond is no reading
    **dict.fromkeys(("rudder", "yaw_rate", "latitude"), 0.5 * math.pi),
    **dict.fromkeys(("stern", "bow", *FIN_CHANNELS, "pitch", "pitch_rate"), 0.5 * math.pi),
    **dict.fromkeys(("command_speed", "ground_speed"), 50.0),
    "depth": 12000.0,
    **dict.fromkeys(("sway", "bow_sway", "stern_sway", "speed"), 50.0),
    **dict.fromkeys(("north_velocity", "east_velocity"), 50.0),
    **dict.fromkeys(("wind_speed", "wind_ahead", "wind_starboard", "revolutions"), 110.0),
    **dict.fromkeys(("wind_from", "roll", "roll_rate"), math.radians(500.0)),
}
CODE_SHARE: Final = 1.4  # [-] of the largest other number: a usual code beyond it is one
HEADING_RANGE_DEG: Final = (-185.0, 365.0)  # [deg] of a heading within a turn, and its noise
MIN_CODE_STEP_DEG: Final = 60.0  # [deg] from a heading to a number that stands for none
MAX_JUMP_ROWS: Final = 5  # [rows] until it is back
JUMP_STEPS: Final = 4.0  # [-] of the change that nine of ten rows do not exceed: a jump is more
MIN_JUMP_DEG: Final = 3.0  # [deg] whatever the rows: a compass that is read in whole degrees
MAX_INTERVAL_S: Final = 300.0  # [s] no trial is read so rarely: its times are in ms or us
MAX_CODES: Final = 3  # [numbers] that one logger writes for no reading
MAX_ROWS_TOLD: Final = 10
TRAINER_COLUMNS: Final = {  # columns of the trainer, SI and radians
    "rudder": "delta_r",
    "heading": "psi",
    "yaw_rate": "r",
    "sway": "v",
    "speed": "u",
}
SHIP_COLUMNS: Final = {  # likewise, of SHIP_CHANNEL_UNITS
    "revolutions": "n",
    "wind_ahead": "wind_ahead",
    "wind_starboard": "wind_starboard",
    "roll": "phi",
    "roll_rate": "p",
}
BOAT_COLUMNS: Final = {  # likewise, of BOAT_CHANNEL_UNITS
    "stern": "delta_s",
    "bow": "delta_b",
    "command_speed": "u_c",
    "pitch": "theta",
    "pitch_rate": "q",
    "depth": "z",
    "roll": "phi",
    "roll_rate": "p",
}
ALL_UNITS: Final = {**CHANNEL_UNITS, **SHIP_CHANNEL_UNITS, **BOAT_CHANNEL_UNITS}
LIKELY_UNITS: Final = ("deg", "s", "kn", "m")
SAID_COLUMN: Final = re.compile(  # heading, unit, scale, offset
    r"(.+):([^:*]+)(?:\*([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)([+-](?:\d+\.?\d*|\.\d+))?)?"
)
NO_UNIT: Final = "-"  # unit of a column that is taken as it stands
# rows, channels in SI, their units in the file, what to tell
Taken = tuple[Sequence[int], dict[str, Any], dict[str, str], list[str]]
NOISE_STREAMS: Final = ("sway", "bow_sway", "stern_sway", "yaw_rate", "heading")
USUAL_SENSORS: Final = Sensors(sway_kn=0.05, yaw_rate_deg_s=0.02, heading_deg=0.1)


def find_codes(numbers: Numbers) -> tuple[float, ...]:
    """Return the usual codes among numbers that are far beyond all others."""
    usual = np.isin(numbers, USUAL_CODES)
    largest = float(np.nanmax(np.abs(numbers), where=~usual, initial=0.0))
    return tuple(np.unique(numbers[usual & (np.abs(numbers) > CODE_SHARE * largest)]).tolist())


def find_impossible(channel: str, values: Numbers, unit: str) -> tuple[int, str] | None:
    """Return the index of a reading [SI] that no ship has, and why; else None."""
    beyond = np.abs(np.nan_to_num(values)) > MAX_SIZES.get(channel, math.inf)
    degrees = f'; are these degrees? say unit = "{unit.replace("rad", "deg")}"'
    degrees *= unit in ("rad", "rad/s")
    text = f"no {channel} in {unit} is so large{degrees}; if it stands for no reading"
    return (int(np.argmax(beyond)), text) if beyond.any() else None


def without_jumps(record: Record) -> Record:
    """Return the record, readings of its heading missing that leave it and come back."""
    if record.heading is None:
        return record
    known = np.flatnonzero(~np.isnan(record.heading))
    degrees = np.degrees(record.heading[known])
    indices = known[sorted({*_outside(degrees), *_back_again(degrees)})]
    if not indices.size:
        return record
    rows, raw = record.rows[indices].tolist(), math.degrees(record.heading[indices[0]])
    told = f"{len(rows)} missing, rows {', '.join(map(str, rows[:MAX_ROWS_TOLD]))}"
    finding = record.finding("heading", f"{raw:g} deg is no heading here: {told}", indices[0])
    heading = record.heading.copy()
    heading[indices] = np.nan
    return replace(record, heading=heading, findings=(*record.findings, finding))


def _outside(heading: Numbers) -> Iterator[int]:
    """Yield the readings [deg] outside one turn: a few numbers, reached by no small step."""
    outside = (heading < HEADING_RANGE_DEG[0]) | (heading > HEADING_RANGE_DEG[1])
    steps = np.abs(np.diff(heading))[np.diff(outside)]
    if (
        steps.size
        and steps.min() > MIN_CODE_STEP_DEG
        and np.unique(heading[outside]).size <= MAX_CODES
    ):
        yield from np.flatnonzero(outside).tolist()


def _back_again(heading: Numbers) -> Iterator[int]:
    """Yield the readings [deg] far from those before and after them, in a few rows.

    Far is what this ship does not turn from row to row, by the shorter way.
    """
    steps, done = _turned(np.diff(heading)), 0
    usual = float(np.quantile(steps, 0.9)) if len(steps) else math.inf
    limit = max(MIN_JUMP_DEG, JUMP_STEPS * usual)
    for i in (np.flatnonzero(steps > limit) + 1).tolist():
        away = _turned(heading[i : i + MAX_JUMP_ROWS + 1] - heading[i - 1]) > limit
        if i >= done and not away.all():
            done = i + int(np.argmin(away)) + 1
            yield from range(i, done - 1)


def _turned(change: Numbers) -> Numbers:
    """Return the size of a change of heading [deg], by the shorter way."""
    return np.asarray(np.abs(np.mod(change + 180.0, 360.0) - 180.0))


@dataclass(frozen=True)
class Column:
    """The source of a channel: its column and unit. None as a unit is as the file says.

    A number times ``scale`` plus ``offset`` is the unit; a scale of None is not said, and 1.
    """

    name: str
    unit: str | None
    missing: tuple[float, ...] = ()  # numbers that say that there is no reading
    scale: float | None = None
    offset: float = 0.0

    def in_unit(self, numbers: Numbers) -> Numbers:
        """Return numbers of the source in the unit."""
        if self.scale is None and not self.offset:
            return numbers
        return numbers * (1.0 if self.scale is None else self.scale) + self.offset


def own_columns(further: Mapping[str, str] = MappingProxyType({})) -> dict[str, Column]:
    """Return the columns of the trainer's own files, times among them, and ``further`` ones."""
    names = {**TRAINER_COLUMNS, **further}
    columns = {key: Column(one, ALL_UNITS[key]) for key, one in names.items()}
    return {"t": Column("t", "s"), **columns}


def units_of(channel: str) -> Mapping[str, float]:
    """Return the units that a channel can have, and what each is in SI."""
    special = {"t": "s", **dict.fromkeys(POSITION_CHANNELS, "place")}
    return UNIT_FACTORS[{**ALL_UNITS, **special}[channel]]


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


def column_said(text: str) -> Column:
    """Return what an option's words say of a column: ``Keel``, ``Keel:ft``, ``RSA:deg*0.35-91``."""
    said = SAID_COLUMN.fullmatch(text)
    if said is None or (unit := spell_unit(said[2])) not in KNOWN_UNITS:
        return Column(text, None)
    scale, offset = (float(number) if number else None for number in said.group(3, 4))
    return Column(said[1], unit, (), scale, offset or 0.0)


def check_unit(path: Path, channel: str, column: Column, said: str, option: str = "") -> str:
    """Return the unit of a column, ``said`` by its file unless said otherwise.

    ConfigError with the units known, and how to say one: by ``option``, else in the study.
    """
    unit, known = column.unit or said or SHIP_CHANNEL_UNITS.get(channel, ""), units_of(channel)
    scaleless = said in SCALELESS_UNITS and said not in known and column.scale is None
    if unit in known and not scaleless:
        return unit
    where = f"the file says {quote(said)}" if said else "the file does not say its unit"
    if column.unit and not scaleless:
        where = f"unit {quote(unit)} is none of it"
    likely = next((one for one in known if one in LIKELY_UNITS), next(iter(known)))
    typed = f"{option} {channel}={shlex.quote(column.name)}:"
    say = f"say in the study unit = {' or '.join(map(quote, known))}"
    if option:
        say = f"say {typed}{likely}, or {', '.join(f':{one}' for one in known if one != likely)}"
    if scaleless:
        key = f"in its [[columns]] unit = {quote(likely)} and scale = 0.35"
        say = f"say how much one is: {f'{typed}{likely}*0.35' if option else key} where 100 are 35"
        say += f" {likely}; known are {', '.join(known)}"
    raise ConfigError(f"{path}: {column.name} for {channel}: {where}: {say}")


def load_record(path: Path, columns: Mapping[str, Column]) -> Record:
    """Return the record in a CSV file or a recording. ConfigError naming what is wrong with it.

    ``columns`` says where each channel is, and under "t" the times; without "t" rows are counted.
    """
    return own_readings(read_record(path, columns))


def own_readings(record: Record) -> Record:
    """Return a record of readings alone: no repeats, no heading that stands for none.

    ConfigError if its times do not rise. An exact recording is read in each row.
    """
    check_times(record)
    exact = Path(record.source).suffix == RECORDING_SUFFIX
    return without_jumps(record if exact else keep_readings(record))


def read_record(path: Path, columns: Mapping[str, Column]) -> Record:
    """Return a record as its rows stand, its times and its heading too."""
    if path.suffix == RECORDING_SUFFIX:
        rows, taken, units, remarks = _read_recording(path, columns)
    elif log := read_log(path):
        rows, taken, units, remarks = _read_log(log, columns)
    else:
        rows, taken, units, remarks = _read_csv(path, columns)
    if len(rows) < 2:
        raise ConfigError(f"{path}: has {len(rows)} rows of numbers; needs 2 or more")
    times = taken.pop("t", np.arange(len(rows), dtype=float))
    plain = {name: taken.pop(name) for name, one in columns.items() if one.unit == NO_UNIT}
    return Record(
        source=str(path),
        t=times,
        rows=np.array(rows),
        names={channel: column.name for channel, column in columns.items()},
        findings=tuple(Finding(path.name, 0, text) for text in remarks),
        plain=plain,
        units=units,
        **taken,
    )


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
    units = {
        channel: check_unit(path, channel, one, table.units[table.index(one.name)])
        for channel, one in columns.items()
        if one.unit != NO_UNIT and not table.is_clock(table.index(one.name))
    }
    taken = {channel: _take(table, channel, one, other) for channel, one in columns.items()}
    if "t" in columns:
        name = columns["t"].name
        if table.is_clock(table.index(name)):
            remarks.append("times by ISO 8601")
        taken["t"], rebuilt = rebuild_times(taken["t"], table.repeats)
        other += [f"{name}: {rebuilt}"] if rebuilt else []
    return (
        table.lines,
        taken,
        units,
        ([f"read with {', '.join(remarks)}"] if remarks else []) + other,
    )


def _read_log(log: Log, columns: Mapping[str, Column]) -> Taken:
    """Return the wanted columns of a log at all their times, NaN where one was not read."""
    found = {
        channel: log.column(one.name, channel) for channel, one in columns.items() if channel != "t"
    }
    units = {
        channel: check_unit(log.path, channel, columns[channel], one.unit)
        for channel, one in found.items()
    }
    t = np.unique(np.concatenate([one.t for one in found.values()]))
    taken = {"t": t}
    for channel, one in found.items():
        column, unit = columns[channel], units[channel]
        numbers = np.where(np.isin(one.values, column.missing), np.nan, one.values)
        values = column.in_unit(numbers) * units_of(channel)[unit]
        if fault := find_impossible(channel, values, unit):
            when = f"{log.path}: {column.name} at {one.t[fault[0]]:.6g} s"
            raise ConfigError(f"{when}: {fault[1]} say missing = [...] in its [[columns]]")
        taken[channel] = np.full(len(t), np.nan)
        taken[channel][np.searchsorted(t, one.t)] = values
    return range(1, len(t) + 1), taken, units, list(log.told)


def _take(table: CsvTable, channel: str, column: Column, told: list[str]) -> Numbers:
    """Return a channel in SI, its ``missing`` numbers NaN.

    ConfigError if it has no unit, a cell is no number, or no ship has such a reading.
    """
    index = table.index(column.name)
    if column.unit == NO_UNIT:
        numbers = table.numbers(index)
        if codes := find_codes(numbers):
            told.append(f"{column.name}: is {codes[0]:g} for no reading? then leave it empty")
        return numbers
    if channel == "t" and table.is_clock(index):
        return table.seconds(index)
    said = table.units[index]
    unit = check_unit(table.path, channel, column, said)
    if said in KNOWN_UNITS and said != unit and column.scale is None:
        told.append(f"{column.name} is in {said}, the study says {unit}: taken as {unit}")
    scale = units_of(channel)[unit]
    table = table.without(index, column.missing) if column.missing else table
    numbers = table.angles(index, unit) if channel in POSITION_CHANNELS else table.numbers(index)
    numbers = column.in_unit(numbers)
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
    return ticks, taken, {}, []


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

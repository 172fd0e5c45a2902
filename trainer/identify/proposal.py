"""A study proposed from a record, for its user to correct.

Columns are told by their names and units.
"""

import difflib
import json
import math
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from trainer.config.files import ConfigError, as_typed, write_once
from trainer.config.tables import Table, read_table, spelt
from trainer.core.kernel import Numbers
from trainer.identify.findings import examine, positive_turns
from trainer.identify.measurements import PLACES, Record
from trainer.identify.sources import USUAL, Column, load_record, own_columns, units_of
from trainer.identify.track import Drift, derivative, unwrapped, with_sway
from trainer.io.paths import SUFFIX

WORDS: Final[Mapping[str, tuple[str, ...]]] = {  # what a column of a channel is called
    "t": ("t", "time", "utc", "timestamp", "date time", "clock"),
    "rudder": ("rudder", "rudder angle", "helm", "delta", "delta r"),
    "heading": ("heading", "hdg", "psi", "gyro", "compass", "yaw", "yaw angle"),
    "yaw_rate": ("yaw rate", "rot", "r", "rate of turn", "turn rate", "rate"),
    "sway": ("sway", "v", "sway velocity", "sway speed", "lateral speed"),
    "bow_sway": ("bow sway", "v1", "bow log"),
    "stern_sway": ("stern sway", "v2", "stern log"),
    "speed": ("speed", "u", "stw", "log", "surge", "speed through water"),
    "latitude": ("latitude", "lat"),
    "longitude": ("longitude", "lon", "long"),
}
OUTPUTS: Final = "heading, yaw rate, sway or a track"
MEASURED: Final = WORDS.keys() - {"t", "rudder", "speed"}  # what a ship answers a rudder by
LIKE: Final = 0.75  # [-] likeness of two names that are one
ENDINGS: Final = (  # of a heading such as psi_deg
    *("deg s", "deg min", "rad s", "m s", "deg", "rad", "kn", "kts", "s", "ms", "min"),
)
HALF_ROUND: Final = 1.6  # [rad] no rudder goes so far
ROUND: Final = 7.0  # [rad] a heading beyond it is in degrees
FAST: Final = 12.0  # [m/s] what goes faster is in knots
TURNING: Final = 0.05  # [1/s] usual yaw rate to a rudder
NAUTICAL: Final = re.compile(r"-?\d{4,5}(?:\.|$)")  # 5430.5 is a place in degrees and minutes
TEXT: Final = """\
# A study of {record}. What was guessed is marked: correct it. Fill in [ship]; then:
# trainer identify {path}
schema = "identify/1"
name = {name}
data = {data}
{sign}# from_s = {begin:g}  # first time used
# to_s = {end:g}  # last time used
# every = 2  # takes one sample of so many
{interval}
{columns}[ship]
{length}
{speed}

[model]
kind = "{kind}"  # {others}
outputs = {outputs}
"""
SENSORS: Final = f"""\
[sensors]  # a recording is exact: what instruments add
sway_kn = {USUAL.sway_kn}
yaw_rate_deg_s = {USUAL.yaw_rate_deg_s}
heading_deg = {USUAL.heading_deg}

"""


@dataclass(frozen=True)
class Proposal:
    """The text of a study, and what there is to say of its record."""

    text: str
    rows: int
    interval: float  # [s]
    columns: Mapping[str, Column]
    remarks: tuple[str, ...]


def write_proposal(data: Path, path: Path, length: float | None, speed: float | None) -> Proposal:
    """Write the study proposed for a record to a new file.

    ConfigError if the file is there, or nothing looks like the rudder.
    """
    guessed: dict[str, str] = {}
    own = data.suffix == SUFFIX
    columns = own_columns() if own else _columns(read_table(data), guessed)
    record = load_record(data, columns)
    record, sign = _turned(record)
    record, remarks = _examined(record)
    text = TEXT.format(
        record=data.name,
        path=as_typed(path),
        name=_quoted(data.stem[:79]),
        data=_quoted(os.path.relpath(data, path.parent)),
        sign=sign,
        begin=record.t[0],
        end=record.t[-1],
        interval="" if "t" in columns else "interval_s = 1  # guessed: there is no time\n",
        columns=SENSORS if own else "".join(_rows(columns, guessed)),
        length=f"length_m = {length:g}" if length else "# length_m = 100  # fill in",
        speed=_speed(record, speed),
        **_model(record),
    )
    write_once(path, text)
    return Proposal(text, len(record.t), record.interval, columns, remarks)


def _turned(record: Record) -> tuple[Record, str]:
    """Return the record with a rudder that turns to port, and the line that says so."""
    turning = positive_turns(record)
    if turning is None or turning < 0.0:
        return record, ""
    line = f'positive_rudder = "starboard"  # guessed: {turning:.0f} standard errors say so\n'
    return replace(record, rudder=-record.column("rudder")), line


def _examined(record: Record) -> tuple[Record, tuple[str, ...]]:
    """Return the record with the sway of its track, and what there is to say of it."""
    try:
        record = with_sway(record, Drift(0.0, 0.0, 0.0))
        return record, tuple(map(str, examine(record)))
    except ConfigError as wrong:
        return record, tuple(str(wrong).splitlines())


def _quoted(text: str) -> str:
    """Return a text as TOML writes it."""
    return json.dumps(text, ensure_ascii=False)


def _rows(columns: Mapping[str, Column], guessed: Mapping[str, str]) -> list[str]:
    """Return the tables of the columns."""
    return [
        f'[[columns]]\nchannel = "{channel}"\ncolumn = {_quoted(one.name)}\n'
        f'unit = "{one.unit}"{guessed.get(channel, "")}\n\n'
        for channel, one in columns.items()
    ]


def _speed(record: Record, speed: float | None) -> str:
    """Return the line of the ship's speed."""
    if speed:
        return f"speed_kn = {speed:g}"
    if record.speed is not None:
        return "# speed_kn = 12  # else the record's mean"
    return "# speed_kn = 12  # fill in"


def _model(record: Record) -> dict[str, str]:
    """Return the model to begin with, and which others there are."""
    turning = [name for name in ("yaw_rate", "heading") if getattr(record, name) is not None]
    kind, others = "nomoto1", "nomoto2 has three time constants; 1 fits sway too, with a vessel"
    if not turning:
        kind, others = "2", "sway alone"
    return {"kind": kind, "others": others, "outputs": json.dumps(turning or ["sway"])}


def _columns(table: Table, guessed: dict[str, str]) -> dict[str, Column]:
    """Return the columns by channel; ConfigError if none is the rudder, or it has no number."""
    names = {name: _plain(name) for name in table.names}
    found: dict[str, str] = {}
    for channel, head in sorted(
        ((channel, name) for channel in WORDS for name in names),
        key=lambda pair: -_likeness(names[pair[1]][0], pair[0]),
    ):
        free = channel not in found and head not in found.values()
        if free and _likeness(names[head][0], channel) >= LIKE:
            found[channel] = head
    found |= _clock(table, found)
    for what, wanted in (("the rudder", {"rudder"}), (OUTPUTS, MEASURED)):
        if wanted.isdisjoint(found):
            name = "it rudder" if "rudder" in wanted else "one so"
            raise ConfigError(
                f"{table.path}: no column looks like {what}; it has {', '.join(table.names)}: "
                f"name {name}"
            )
    columns = {channel: found[channel] for channel in WORDS if channel in found}
    units: dict[str, str] = {}
    for channel, head in columns.items():
        said = [one for one in (table.units[table.place(head)], names[head][1]) if one]
        known = [one for one in said if one in units_of(channel)]
        if not known and not table.is_clock(table.place(head)):
            guessed[channel] = "  # guessed"
        units[channel] = known[0] if known else _guess(table, channel, columns, units)
    return {channel: Column(head, units[channel]) for channel, head in columns.items()}


def _clock(table: Table, found: Mapping[str, str]) -> dict[str, str]:
    """Return the column of times by its unit or dates, where none has the name of one."""
    if "t" in found:
        return {}
    for place, (name, unit) in enumerate(zip(table.names, table.units, strict=True)):
        if name not in found.values() and (unit in units_of("t") or table.is_clock(place)):
            return {"t": name}
    return {}


def _plain(name: str) -> tuple[str, str]:
    """Return a heading in small letters without its unit, and that: psi_deg is psi in deg."""
    words = re.sub(r"[\W_]+", " ", name.casefold()).strip()
    for ending in ENDINGS:
        if words.endswith(f" {ending}"):
            return words.removesuffix(f" {ending}"), spelt(ending.replace(" ", "/"))
    return words, ""


def _likeness(name: str, channel: str) -> float:
    """Return how like a name is to the usual ones of a channel [-]; 1 for one of them."""
    return max(difflib.SequenceMatcher(None, name, word).ratio() for word in WORDS[channel])


def _guess(table: Table, channel: str, columns: Mapping[str, str], units: Mapping[str, str]) -> str:
    """Return the likeliest unit of a column by its numbers."""
    if channel == "t":
        return "s"
    if channel in PLACES:
        both = [table.place(columns[one]) for one in PLACES if one in columns]
        cells = (row[place] for row in table.cells for place in both)
        return "ddmm" if any(map(NAUTICAL.match, cells)) else "deg"
    values = table.numbers(table.place(columns[channel]))
    if channel == "yaw_rate":
        return _rate_unit(table, values, columns, units)
    limits = {"rudder": (HALF_ROUND, "rad", "deg"), "heading": (ROUND, "rad", "deg")}
    limit, small, large = limits.get(channel, (FAST, "m/s", "kn"))
    return large if float(np.nanmax(np.abs(values))) > limit else small


def _rate_unit(
    table: Table, values: Numbers, columns: Mapping[str, str], units: Mapping[str, str]
) -> str:
    """Return the unit in which a yaw rate is nearest to the heading's, or to a usual ship's."""
    wanted = {one: Column(columns[one], units[one]) for one in units}
    record = load_record(table.path, wanted)
    size = TURNING * float(np.std(record.column("rudder")))
    if record.heading is not None:
        size = float(np.nanstd(derivative(unwrapped(record.heading), record.interval)))
    own, known = float(np.nanstd(values)), units_of("yaw_rate")
    if not (own > 0.0 and size > 0.0):
        return "deg/s"
    return min(known, key=lambda one: abs(math.log(own * known[one] / size)))

"""A study proposed from a record, for its user to correct.

Columns are guessed by their names, units and numbers. ``trainer identify new`` writes it, because
nobody knows the keys of a study by heart.
"""

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from trainer.config.files import ConfigError, as_typed, toml_value, write_once
from trainer.identify.record.columns import (
    CHANNEL_WORDS,
    NOTHING_TOLD,
    GuessedColumns,
    guess_file,
    names_in,
)
from trainer.identify.record.contradictions import settle_columns
from trainer.identify.record.evidence import Course
from trainer.identify.record.findings import examine_record
from trainer.identify.record.readings import fill_inputs
from trainer.identify.record.sources import USUAL_SENSORS, Column, own_columns
from trainer.identify.record.track import Drift, no_sway, with_sway
from trainer.io.paths import RECORDING_SUFFIX
from trainer.units import KNOT

OUTPUTS_TEXT: Final = "heading, yaw rate, sway or a track"
ANSWER_CHANNELS: Final = CHANNEL_WORDS.keys() - {
    "t",
    "rudder",
    "speed",
}  # what a ship answers a rudder by
SURFACE_NAME: Final = re.compile("rudder|servo|RCOU|actuator|fin", re.IGNORECASE)
STUDY_TEXT: Final = """\
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
SENSORS_TEXT: Final = f"""\
[sensors]  # a recording is exact: what instruments add
sway_kn = {USUAL_SENSORS.sway_kn}
yaw_rate_deg_s = {USUAL_SENSORS.yaw_rate_deg_s}
heading_deg = {USUAL_SENSORS.heading_deg}

"""


@dataclass(frozen=True)
class Proposal:
    """The text of a study, and remarks on its record."""

    text: str
    rows: int
    interval: float  # [s]
    columns: Mapping[str, Column]
    remarks: tuple[str, ...]


def write_proposal(
    data: Path,
    path: Path,
    length: float | None,
    speed: float | None,
    told: Mapping[str, Column] = NOTHING_TOLD,
    *,
    anyway: bool = False,
) -> Proposal:
    """Write the study proposed for a record to a new file.

    ``told`` are columns by channel, where the headings do not tell by themselves.
    ConfigError if the file is there, nothing looks like the rudder, or its channels contradict each
    other and nobody wants it ``anyway``.
    """
    is_recording = data.suffix == RECORDING_SUFFIX
    if is_recording and told:
        raise ConfigError(f"{data}: a recording's columns are known; leave --column out")
    guess = GuessedColumns(own_columns(), frozenset()) if is_recording else _guessed(data, told)
    ship = Course(length, speed * KNOT if speed else None, None)
    settled = settle_columns(data, guess, ship, anyway=anyway)
    guess, columns = settled.columns, settled.columns.columns
    record = fill_inputs(settled.record, ("rudder",), "straight")
    try:
        record = with_sway(record, Drift(0.0, 0.0, 0.0))
    except ConfigError as wrong:
        record = replace(record, findings=(*record.findings, no_sway(record, wrong)))
    try:
        remarks = tuple(map(str, examine_record(record)))
    except ConfigError as wrong:
        remarks = tuple(str(wrong).splitlines())
    lacking = "fill in" if record.speed is None else "else the record's mean"
    turning = [name for name in ("yaw_rate", "heading") if getattr(record, name) is not None]
    kind, others = "nomoto1", "nomoto2 has three time constants; 1 fits sway too, with a vessel"
    if not turning:
        kind, others = "2", "sway alone"
    text = STUDY_TEXT.format(
        record=data.name,
        path=as_typed(path),
        name=toml_value(data.stem[:79]),
        data=toml_value(os.path.relpath(data, path.parent)),
        sign=settled.sign + settled.anyway,
        begin=record.t[0],
        end=record.t[-1],
        interval="" if "t" in columns else "interval_s = 1  # guessed: there is no time\n",
        columns=SENSORS_TEXT if is_recording else columns_text(guess),
        length=f"length_m = {length:.12g}" if length else "# length_m = 100  # fill in",
        speed=f"speed_kn = {speed:.12g}" if speed else f"# speed_kn = 12  # {lacking}",
        kind=kind,
        others=others,
        outputs=toml_value(turning or ["sway"]),
    )
    write_once(path, text)
    return Proposal(text, len(record.t), record.interval, columns, (*guess.told, *remarks))


def _guessed(data: Path, told: Mapping[str, Column]) -> GuessedColumns:
    """Return the columns of a file; ConfigError if rudder or ship's answer is lacking."""
    columns = guess_file(data, CHANNEL_WORDS, told)
    for what, wanted in (("the rudder", {"rudder"}), (OUTPUTS_TEXT, ANSWER_CHANNELS)):
        if wanted.isdisjoint(columns.columns):
            names = names_in(data)
            name = "rudder" if "rudder" in wanted else "heading"
            likely = (one for one in names if name == "rudder" and SURFACE_NAME.search(one))
            raise ConfigError(
                f"{data}: no column looks like {what}; it has {', '.join(names)}: "
                f"say which it is: --column {name}={next(likely, names[0])}, for example"
            )
    return columns


def columns_text(found: GuessedColumns) -> str:
    """Return the tables of the columns; a unit that was guessed is marked."""
    return "".join(
        f'[[columns]]\nchannel = "{channel}"\ncolumn = {toml_value(one.name)}\n'
        f'unit = "{one.unit}"{"  # guessed" if channel in found.unsure else ""}\n'
        + (f"scale = {one.scale!r}\n" if one.scale is not None else "")
        + (f"offset = {one.offset!r}\n" if one.offset else "")
        + (f"missing = {list(one.missing)}  # guessed\n\n" if one.missing else "\n")
        for channel, one in found.columns.items()
    )

"""``trainer identify new RECORD --ship FILE``: a ship's file begun, for its user to complete.

The record gives the columns; what only the user knows (dimensions, propeller) is left as a
question.
"""

import shlex
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Final

from trainer.config.files import ConfigError, toml_value, write_once
from trainer.config.tables import CsvTable, read_table
from trainer.identify.record.columns import (
    NOTHING_TOLD,
    SHIP_WORDS,
    GuessedColumns,
    guess_file,
    names_in,
)
from trainer.identify.record.contradictions import settle_columns
from trainer.identify.record.evidence import Course
from trainer.identify.record.findings import examine_record
from trainer.identify.record.logs import read_log
from trainer.identify.record.proposal import Proposal, columns_text
from trainer.identify.record.readings import fill_inputs
from trainer.identify.record.sources import (
    SHIP_COLUMNS,
    Column,
    own_columns,
)
from trainer.identify.ships.records import GROUND_VELOCITIES, NEEDED_CHANNELS

SHIP_FILE_TEXT: Final = """\
# The file of a ship, for records like {record}. What was guessed is marked: correct it.
# Fill in [dimensions]; then: {command}
schema = "ship/1"
name = {name}

[dimensions]
{length} between perpendiculars
# propeller_diameter_m = 9.86  # fill in: of one propeller
# wake_fraction = 0.4  # fill in: w, the propeller meets (1-w) u; 0.35 to 0.4 for the tanker KVLCC2
# thrust = [0.324, -0.221, -0.149]  # fill in: K_T = k0 + k1 J + k2 J^2; these are KVLCC2's
# For the prior, else it is that of full tankers:
# beam_m = 58.0
# draught_m = 20.8
# block_coefficient = 0.81

[records]
{records}
{columns}"""
GUESSED_NOTE: Final = "  # guessed: say so if the water stood still"
MISSING_COLUMN_TEXT: Final = """\
# [[columns]]  # fill in: {why}
# channel = "{channel}"
# column = ""

"""
WIND_REMARK: Final = (
    "is taken for the relative wind; leave its [[columns]] out if it is over ground"
)


def write_ship_file(
    data: Path,
    path: Path,
    length: float | None,
    told: Mapping[str, Column] = NOTHING_TOLD,
    *,
    anyway: bool = False,
) -> Proposal:
    """Write the file proposed for the ship of a record to a new file.

    ``told`` are columns by channel, where the headings do not tell by themselves.
    ConfigError if the file is there, or no column of the record is known.
    """
    trainer_columns = None if told or read_log(data) else _own(read_table(data))
    columns = trainer_columns or guess_file(data, SHIP_WORDS, told)
    if columns.columns.keys() <= {"t"}:
        raise ConfigError(
            f"{data}: no column looks like the rudder, the speed or the heading; it has "
            f"{', '.join(names_in(data))}: "
            f"say which they are, such as --column rudder={names_in(data)[0]}"
        )
    settled = settle_columns(data, columns, Course(length, None, None), anyway=anyway)
    columns, sign = settled.columns, settled.sign + settled.anyway
    record = fill_inputs(settled.record, ("rudder",), "straight")
    lacking = _lacking(columns.columns)
    lines = []
    if "t" not in columns.columns:
        lines.append("interval_s = 1  # guessed: there is no time\n")
    if (
        all(channel in columns.columns for channel in GROUND_VELOCITIES)
        and "speed" not in columns.columns
    ):
        lines.append(f'current = "none"{GUESSED_NOTE}\n')
    text = SHIP_FILE_TEXT.format(
        record=data.name,
        command=fit_command(data, path),
        name=toml_value(data.stem[:79]),
        length=f"length_m = {length:.12g}  #" if length else "# length_m = 320.0  # fill in:",
        records=sign + "".join(lines),
        columns=("" if trainer_columns else columns_text(columns))
        + "".join(
            MISSING_COLUMN_TEXT.format(channel=channel, why=why) for channel, why in lacking.items()
        ),
    )
    write_once(path, text.rstrip() + "\n")
    remarks = [*columns.told, *map(str, examine_record(record))]
    if "wind_speed" in columns.columns:
        remarks.append(f"{columns.columns['wind_speed'].name}: {WIND_REMARK}")
    remarks += [f"no column for {channel} found" for channel in lacking]
    return Proposal(text, len(record.t), record.interval, columns.columns, tuple(remarks))


def _own(table: CsvTable) -> GuessedColumns | None:
    """Return the columns as the trainer writes them: a ship's file need not name these."""
    trainer_columns = own_columns(SHIP_COLUMNS).items()
    columns = {key: column for key, column in trainer_columns if table.has(column.name)}
    return None if _lacking(columns) else GuessedColumns(columns, frozenset())


def fit_command(data: Path, path: Path) -> str:
    """Return the command that fits the ship of a file to a record."""
    names = [shlex.quote(str(one)) for one in (data, path)]
    return f"trainer identify {names[0]} --model mmg --ship {names[1]}"


def _lacking(columns: Collection[str]) -> dict[str, str]:
    """Return the channels that a fit needs and the record lacks, and why."""
    needed = {"rudder": "what the ship answers", **NEEDED_CHANNELS}
    if all(channel in columns for channel in (*GROUND_VELOCITIES, "heading")):
        del needed["speed"], needed["sway"]
    if "heading" not in columns and "yaw_rate" not in columns:
        needed["heading"] = "or the yaw rate, as yaw_rate"
    return {channel: why for channel, why in needed.items() if channel not in columns}

"""The tables of an identification study: keys, units and limits.

``study`` reads files by them. Unit, limits and meaning of a key stand here once, and serve the
reader, its messages, the JSON Schema and docs/identification.md.
"""

from dataclasses import dataclass
from typing import Final

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
from trainer.config.ship.fit_options import FIT_KINDS, MOTION_CHANNELS
from trainer.config.ship.ship import COLUMN_OFFSET, COLUMN_SCALE, MISSING_NUMBERS, UNIT_NAMES
from trainer.config.words import LINEAR_MODELS
from trainer.identify.record.measurements import (
    CHANNEL_UNITS,
    POSITION_CHANNELS,
)

STUDY_MODELS: Final = (*LINEAR_MODELS, "own")
MEAN_TREATMENTS: Final = ("none", "mean", "trend")
YES_NO: Final = ("yes", "no")
# other starts in a row that must find nothing better, before a fit counts as settled
USUAL_RESTARTS: Final = 12.0


@dataclass(frozen=True, kw_only=True)
class StudyHeading:
    """The subject of a study, and the file of it."""

    schema: str = required(Choice(("identify/1",), "form of the file"))
    name: str = required(Text(79, "what is studied"))
    data: str = required(Text(200, "CSV file or recording, from this file's folder"))
    positive_rudder: str = with_default("port", FIT_KINDS["positive_rudder"])
    between_readings: str | None = optional(FIT_KINDS["between_readings"])
    anyway: str = with_default("no", FIT_KINDS["anyway"])
    from_s: float | None = optional(FIT_KINDS["begin"])
    to_s: float | None = optional(FIT_KINDS["end"])
    every: float = with_default(1.0, "-", within(1, 1000), "takes one sample of so many")
    interval_s: float | None = optional(
        "s", within(1e-4, 3600), "from row to row, where there is no column of times"
    )


@dataclass(frozen=True, kw_only=True)
class ColumnRow:
    """Where one channel is found; a recording of the trainer needs none."""

    channel: str = required(Choice(("t", *CHANNEL_UNITS, *POSITION_CHANNELS), "what it is"))
    column: str = required(Text(80, "heading of the column"))
    unit: str | None = optional(Text(8, f"{UNIT_NAMES}, ddmm; else what the file says"))
    missing: tuple[float, ...] = with_default((), MISSING_NUMBERS)
    scale: float | None = optional(COLUMN_SCALE)
    offset: float = with_default(0.0, COLUMN_OFFSET)


@dataclass(frozen=True, kw_only=True)
class Ship:
    """The ship that sailed."""

    length_m: float = required(FIT_KINDS["length"])
    speed_kn: float | None = optional(FIT_KINDS["speed"])
    bow_log_m: float | None = optional(
        "m", within(0, 600), "forward log, ahead of the centre of mass"
    )
    stern_log_m: float | None = optional("m", within(0, 600), "aft log, behind the centre of mass")
    displacement_m3: float | None = optional(
        "m^3", above(0, 1e7), "for derivatives in the other system"
    )
    vessel: str | None = optional(
        Text(200, "vessel file that acceleration terms and starting values come from")
    )


@dataclass(frozen=True, kw_only=True)
class Track:
    """The antenna and the current, between a track of latitudes and longitudes and sway."""

    antenna_m: float = with_default(
        0.0, "m", within(-600, 600), "forward of the centre of mass; else 0"
    )
    current_east_kn: float = with_default(0.0, "kn", within(-20, 20), "taken off; else 0")
    current_north_kn: float = with_default(0.0, "kn", within(-20, 20), "likewise")


@dataclass(frozen=True, kw_only=True)
class ModelTable:
    """The model and how it is fitted."""

    kind: str = required(Choice(STUDY_MODELS, "model"))
    outputs: tuple[str, ...] = with_default((), FIT_KINDS["outputs"])
    file: str | None = optional(Text(200, "system file, or a program, of kind own"))
    system: str = with_default("prime", Choice(("prime", "bis"), "of the derivatives; else prime"))
    noise: str = with_default("covariance", FIT_KINDS["noise"])
    measurement: str = with_default(
        "instantaneous", Choice(("instantaneous", "integrating"), "else instantaneous")
    )
    method: str = with_default("scoring", FIT_KINDS["method"])
    restarts: float = with_default(
        USUAL_RESTARTS, "-", within(0, 100), "others in a row that find no better; else 12"
    )
    predict_from: float = with_default(1.0, "-", within(1, 1000), "steps predicted, fewest; else 1")
    predict_to: float = with_default(1.0, "-", within(1, 1000), "steps predicted, most; else 1")
    reject: float | None = optional(FIT_KINDS["reject"])


@dataclass(frozen=True, kw_only=True)
class ParameterRow:
    """One parameter: where it starts, and whether it is estimated."""

    name: str = required(Text(20, "theta1 ..., as the model has them"))
    start: float | None = optional("-", within(-1e12, 1e12), "else the model's own")
    free: str | None = optional(Choice(YES_NO, "estimated? else as the model has it"))
    scale: float | None = optional("-", above(0, 1e12), "size of a unit step; else own")
    per_run: str | None = optional(
        Choice(YES_NO, "does each run have its own? else the first state and steady forces have")
    )


@dataclass(frozen=True, kw_only=True)
class RunRow:
    """A further record of the same ship, fitted together with the first."""

    data: str = required(Text(200, "CSV file or recording of the same columns"))
    from_s: float | None = optional(FIT_KINDS["begin"])
    to_s: float | None = optional(FIT_KINDS["end"])
    speed_kn: float | None = optional("kn", within(0.01, 60), "else the ship's")


@dataclass(frozen=True, kw_only=True)
class ArmaxTable:
    """ARMAX models of one output by the rudder."""

    output: str = required(Choice(MOTION_CHANNELS, "channel"))
    most: float = with_default(4.0, "-", within(1, 10), "highest order tried; else 4")
    remove: str = with_default("mean", Choice(MEAN_TREATMENTS, "taken off both series; else mean"))
    dead_time: float = with_default(0.0, "-", within(0, 100), "samples; else 0")
    initial: str = with_default("yes", Choice(YES_NO, "estimate the initial state? else yes"))
    lags: float = with_default(10.0, "-", within(1, 50), "of the residual tests; else 10")


COLUMN_ROWS: Final = Rows(ColumnRow, ("note",), 0, len(CHANNEL_UNITS) + 3, "columns, below")
RUN_ROWS: Final = Rows(RunRow, ("note",), 0, 50, "further records, below")
PARAMETER_ROWS: Final = Rows(ParameterRow, ("note",), 0, 60, "parameters, below")

"""The tables of an identification study: keys, units and limits."""

from dataclasses import dataclass, field
from typing import Final

from trainer.config.schema import (
    Choice,
    Choices,
    Quantity,
    Rows,
    Text,
    above,
    of,
    optional,
    tables_of,
    within,
)
from trainer.config.sensors import Sensors
from trainer.identify.record.measurements import CHANNELS, OUTPUTS, PLACES

LONGEST: Final = 1e9  # [s]
MODELS: Final = ("1", "2", "3", "nomoto1", "nomoto2", "own")
NOISES: Final = ("output-error", "innovations", "covariance")
METHODS: Final = ("scoring", "bfgs", "direct")
TREATMENTS: Final = ("none", "mean", "trend")
YES_NO: Final = ("yes", "no")
TURNING: Final = Choice(("port", "starboard"), "way a positive rudder turns the ship; else port")


@dataclass(frozen=True, kw_only=True)
class Heading:
    """The subject of a study, and the file of it."""

    schema: str = of(Choice(("identify/1",), "form of the file"))
    name: str = of(Text(79, "what is studied"))
    data: str = of(Text(200, "CSV file or recording, from this file's folder"))
    positive_rudder: str | None = optional(TURNING)
    from_s: float | None = optional(Quantity("s", within(-LONGEST, LONGEST), "first time used"))
    to_s: float | None = optional(Quantity("s", within(-LONGEST, LONGEST), "last time used"))
    every: float | None = optional(Quantity("-", within(1, 1000), "takes one sample of so many"))
    interval_s: float | None = optional(
        Quantity("s", within(1e-4, 3600), "from row to row, where there is no column of times")
    )


@dataclass(frozen=True, kw_only=True)
class ColumnRow:
    """Where one channel is found; a recording of the trainer needs none."""

    channel: str = of(Choice(("t", *CHANNELS, *PLACES), "what it is"))
    column: str = of(Text(80, "heading of the column"))
    unit: str | None = optional(
        Text(8, "s ms min h, rad deg, rad/s deg/s deg/min, m/s kn, ddmm; else what the file says")
    )


@dataclass(frozen=True, kw_only=True)
class Ship:
    """The ship that sailed."""

    length_m: float = of(Quantity("m", within(0.1, 600), "length"))
    speed_kn: float | None = optional(Quantity("kn", within(0.01, 60), "else the record's mean"))
    bow_log_m: float | None = optional(
        Quantity("m", within(0, 600), "forward log, ahead of the centre of mass")
    )
    stern_log_m: float | None = optional(
        Quantity("m", within(0, 600), "aft log, behind the centre of mass")
    )
    displacement_m3: float | None = optional(
        Quantity("m^3", above(0, 1e7), "for derivatives in the other system")
    )
    vessel: str | None = optional(
        Text(200, "vessel file that acceleration terms and starting values come from")
    )


@dataclass(frozen=True, kw_only=True)
class Track:
    """The antenna and the current, between a track of latitudes and longitudes and sway."""

    antenna_m: float | None = optional(
        Quantity("m", within(-600, 600), "forward of the centre of mass; else 0")
    )
    current_east_kn: float | None = optional(Quantity("kn", within(-20, 20), "taken off; else 0"))
    current_north_kn: float | None = optional(Quantity("kn", within(-20, 20), "likewise"))


@dataclass(frozen=True, kw_only=True)
class ModelTable:
    """The model and how it is fitted."""

    kind: str = of(Choice(MODELS, "model"))
    outputs: tuple[str, ...] = field(
        default=(), metadata={"kind": Choices(OUTPUTS, "channels fitted; none for own")}
    )
    file: str | None = optional(Text(200, "system file, or a program, of kind own"))
    system: str | None = optional(Choice(("prime", "bis"), "of the derivatives; else prime"))
    noise: str | None = optional(Choice(NOISES, "noise model; else covariance"))
    measurement: str | None = optional(
        Choice(("instantaneous", "integrating"), "else instantaneous")
    )
    method: str | None = optional(Choice(METHODS, "minimiser; else scoring"))
    restarts: float | None = optional(
        Quantity("-", within(0, 100), "others in a row that find no better; else 12")
    )
    predict_from: float | None = optional(
        Quantity("-", within(1, 1000), "steps predicted, fewest; else 1")
    )
    predict_to: float | None = optional(
        Quantity("-", within(1, 1000), "steps predicted, most; else 1")
    )
    reject: float | None = optional(
        Quantity("-", above(0, 0.5), "probability below which a sample is an outlier; else none")
    )


@dataclass(frozen=True, kw_only=True)
class ParameterRow:
    """One parameter: where it starts, and whether it is estimated."""

    name: str = of(Text(20, "theta1 ..., as the model has them"))
    start: float | None = optional(Quantity("-", within(-1e12, 1e12), "else the model's own"))
    free: str | None = optional(Choice(YES_NO, "estimated? else as the model has it"))
    scale: float | None = optional(Quantity("-", above(0, 1e12), "size of a unit step; else own"))
    per_run: str | None = optional(
        Choice(YES_NO, "does each run have its own? else the first state and steady forces have")
    )


@dataclass(frozen=True, kw_only=True)
class RunRow:
    """A further record of the same ship, fitted together with the first."""

    data: str = of(Text(200, "CSV file or recording of the same columns"))
    from_s: float | None = optional(Quantity("s", within(-LONGEST, LONGEST), "first time used"))
    to_s: float | None = optional(Quantity("s", within(-LONGEST, LONGEST), "last time used"))
    speed_kn: float | None = optional(Quantity("kn", within(0.01, 60), "else the ship's"))


@dataclass(frozen=True, kw_only=True)
class ArmaxTable:
    """ARMAX models of one output by the rudder."""

    output: str = of(Choice(OUTPUTS, "channel"))
    most: float | None = optional(Quantity("-", within(1, 10), "highest order tried; else 4"))
    remove: str | None = optional(Choice(TREATMENTS, "taken off both series; else mean"))
    dead_time: float | None = optional(Quantity("-", within(0, 100), "samples; else 0"))
    initial: str | None = optional(Choice(YES_NO, "estimate the initial state? else yes"))
    lags: float | None = optional(Quantity("-", within(1, 50), "of the residual tests; else 10"))


COLUMNS: Final = Rows(ColumnRow, ("note",), 0, len(CHANNELS) + 3, "columns, below")
RUNS: Final = Rows(RunRow, ("note",), 0, 50, "further records, below")
PARAMETERS: Final = Rows(ParameterRow, ("note",), 0, 60, "parameters, below")

RECORDS: Final = {
    "": Heading,
    "[columns]": ColumnRow,
    "[runs]": RunRow,
    "ship": Ship,
    "sensors": Sensors,
    "track": Track,
    "model": ModelTable,
    "[parameters]": ParameterRow,
    "armax": ArmaxTable,
}


def key_tables() -> str:
    """Return the Markdown tables of every key, as docs/identification.md shows them."""
    return tables_of(RECORDS)

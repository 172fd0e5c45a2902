"""Records of ships that are not linear: read, examined and averaged.

Such a fit needs speed, sway and propeller revolutions beside helm and turning. The record is that
of all fits, a positive rudder to port. ``filter_table`` alone turns it into the columns of
``kernels/extended_filter``, in which it turns to starboard, as the forces of a ship take it.
"""

import math
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.boat.ship.forces import STIFFNESS_INDEX
from trainer.config.files import ConfigError, raise_problems
from trainer.config.ship.sensors import Sensors
from trainer.config.ship.ship import GRAVITY_M_S2, ShipFile
from trainer.config.tables import read_table
from trainer.core.kernel import Numbers
from trainer.identify.record.contradictions import check_evidence, in_study
from trainer.identify.record.evidence import Course
from trainer.identify.record.findings import (
    PATH_TEXTS,
    choose_path,
    examine_record,
    unwrap_heading,
)
from trainer.identify.record.measurements import (
    CHANNEL_UNITS,
    SHIP_CHANNEL_UNITS,
    Finding,
    Record,
)
from trainer.identify.record.readings import fill_inputs
from trainer.identify.record.sources import (
    SHIP_COLUMNS,
    Column,
    load_record,
    own_columns,
    read_by,
)
from trainer.identify.record.track import resolve_along
from trainer.io.paths import RECORDING_SUFFIX

INPUT_CHANNELS: Final = (  # beside the rudder, known in each row
    "revolutions",
    *("wind_speed", "wind_from", "wind_ahead", "wind_starboard"),
)
ROLL_CHANNELS: Final = ("roll_rate", "roll")  # readings, in the order of the filter
RUDDER_PATH_SIGNS: Final = {"straight": 1.0, "step": -1.0}  # of extended_filter's PARTS_COLUMN
NEEDED_CHANNELS: Final = {  # and why
    "speed": "the speed through the water drives every force",
    "sway": "the drift cannot be told from the turning",
    "revolutions": "the propeller's slipstream drives the rudder",
}
ADVANCE_RATIO_RANGE: Final = (0.1, 1.6)  # J of a propeller that drives a ship ahead
FINE_STEP_SHARE: Final = 0.1  # [L/U] of a step of Runge and Kutta
MIN_TRIAL_SAMPLES: Final = 30  # samples
INWARD_LEAN_CORRELATION: Final = 0.5  # [-] of roll and turning: beyond, the ship leans inwards
GROUND_VELOCITIES: Final = ("north_velocity", "east_velocity")
READING_CHANNELS: Final = ("speed", "sway", "yaw_rate", "heading")
SPEED_STREAM, ROLL_STREAM = 13, 14  # of the errors of instruments
MAX_ROLL_STEP_RAD: Final = 0.5  # [rad] of roll's own period in a step of Runge and Kutta
MIN_ROLL_SAMPLES: Final = 6  # samples in that period, at least
HEEL_LEVER_RANGE: Final = (0.002, 0.5)  # [L] of the forces that heel a ship


def readings_of(record: Record) -> Numbers:
    """Return u, v, r, heading (n, 4), and any roll rate and roll (n, 6).

    What was not read is NaN.
    """
    names = READING_CHANNELS if record.roll is None else (*READING_CHANNELS, *ROLL_CHANNELS)
    none = np.full(len(record.t), math.nan)
    channels = (getattr(record, name) for name in names)
    return np.column_stack([none if one is None else one for one in channels])


def inputs_of(record: Record) -> Numbers:
    """Return rudder to starboard, revolutions and wind (n, 4), as forces take them."""
    calm = np.zeros(len(record.t))  # a relative wind that was not recorded is none
    wind = (record.wind_ahead, record.wind_starboard)
    return np.column_stack(
        [
            -record.column("rudder"),
            record.column("revolutions"),
            *(calm if one is None else one for one in wind),
        ]
    )


def filter_table(record: Record, constants: Numbers) -> Numbers:
    """Return the rows that extended_filter takes: readings, inputs, steps, then roll.

    A step of Runge and Kutta must be short against the ship's own motions.
    """
    readings, gaps = readings_of(record), np.append(np.diff(record.t), 0.0)
    length, speed = constants[0], float(np.nanmax(np.abs(readings[:, 0])))
    # steps are short against a ship's length and against its period of roll; 1e-9 is for rounding
    parts = np.maximum(np.ceil(gaps / (FINE_STEP_SHARE * length / speed) - 1e-9), 1.0)
    stiffness = constants[STIFFNESS_INDEX]
    parts = np.maximum(parts, np.ceil(gaps * math.sqrt(stiffness) / MAX_ROLL_STEP_RAD))
    parts *= RUDDER_PATH_SIGNS[record.between_readings]
    columns = readings[:, :4], inputs_of(record), gaps, parts, readings[:, 4:]
    return np.ascontiguousarray(np.column_stack(columns))


def with_path(ship: ShipFile, between_readings: str | None, *, anyway: bool = False) -> ShipFile:
    """Return the ship, its records' rudder going as said, contradictions taken if ``anyway``."""
    records = ship.records
    said = between_readings or records.between_readings
    taken = "yes" if anyway else records.anyway
    return replace(ship, records=replace(records, between_readings=said, anyway=taken))


def load_trial(path: Path, ship: ShipFile, every: int = 1) -> Record:
    """Return a record, its rows averaged by ``every``. ConfigError with what forbids its use."""
    return trial_of(_read(path, ship), ship, every)


def trial_of(record: Record, ship: ShipFile, every: int = 1) -> Record:
    """Return a record examined and averaged. ConfigError."""
    record = _from_ground(record, ship)
    if ship.roll is None:
        record = replace(record, roll=None, roll_rate=None)
    _check_needed(record, ship)
    if ship.records.positive_rudder == "starboard" and record.rudder is not None:
        record = replace(record, rudder=-record.rudder)
    record = check_evidence(
        record,
        Course(ship.dimensions.length_m, None, None),
        in_study(record, ship.records.positive_rudder or "port"),
        anyway=ship.records.anyway == "yes",
    )
    record, path, told = _with_path(record, ship, every)
    findings = [*examine_record(record), told]
    record = unwrap_heading(record)
    if ship.sensors is not None:
        record = _read_by(record, ship.sensors)
    if record.wind_speed is not None and record.wind_from is not None:
        size, angle = record.wind_speed, record.wind_from
        ahead, starboard = size * np.cos(angle), size * np.sin(angle)
        record = replace(record, wind_ahead=ahead, wind_starboard=starboard)
    if ship.roll is not None:
        remarks = _check_roll(record, ship, ship.roll.gm_m, every)
        findings += [Finding(Path(record.source).name, 0, text) for text in remarks]
    _check_propeller(record, ship)
    record = _averaged(record, every)
    if len(record.t) < MIN_TRIAL_SAMPLES:
        raise ConfigError(
            f"{record.source}: has {len(record.t)} samples of {every} rows; needs "
            f"{MIN_TRIAL_SAMPLES} or more"
        )
    return replace(record, between_readings=path, findings=tuple(findings))


def _averaged(record: Record, every: int) -> Record:
    """Return the means of ``every`` rows around each such row."""
    if every == 1:
        return record
    indices = np.arange(every // 2, len(record.t) - every // 2, every)
    around = indices[:, None] + np.arange(every) - every // 2
    channels = (*CHANNEL_UNITS, *SHIP_CHANNEL_UNITS)
    values = {name: one for name in channels if (one := getattr(record, name)) is not None}
    means: dict[str, Any] = {name: one[around].mean(axis=1) for name, one in values.items()}
    return replace(record.part(indices), **means)


def _with_path(record: Record, ship: ShipFile, every: int) -> tuple[Record, str, Finding]:
    """Return the record with its inputs known in each row, the rudder's way, and what tells it."""
    path, why = choose_path(record, ("rudder",), ship.records.between_readings)
    record = fill_inputs(fill_inputs(record, INPUT_CHANNELS, "straight"), ("rudder",), path)
    if every > 1:  # between two means it goes evenly
        path, why = "straight", f"each the mean of {every} rows"
    return record, path, record.finding("rudder", f"taken as {PATH_TEXTS[path]}, {why}")


def _columns(path: Path, ship: ShipFile) -> dict[str, Column]:
    """Return where each channel is: as the ship's file says, or as the trainer writes them."""
    if ship.columns:
        columns = {
            row.channel: Column(
                row.column, row.unit, row.missing or (), row.scale, row.offset or 0.0
            )
            for row in ship.columns
        }
        if "rudder" not in columns:
            raise ConfigError(f"{ship.path.name}: [columns]: no column is the rudder")
        return columns
    table = read_table(path)
    unread = ROLL_CHANNELS if ship.roll is None else ()
    trainer_columns = own_columns(SHIP_COLUMNS)
    return {
        key: one
        for key, one in trainer_columns.items()
        if table.has(one.name) and key not in unread
    }


def _read(path: Path, ship: ShipFile) -> Record:
    """Return the record of a file, SI."""
    columns = _columns(path, ship)
    if path.suffix == RECORDING_SUFFIX:
        raise ConfigError(
            f"{path}: records for this model are CSV files: trainer export {path} --csv FILE "
            "writes one"
        )
    interval = ship.records.interval_s
    if interval is None and "t" not in columns:
        raise ConfigError(
            f"{path}: no column of times: name it, or say interval_s in [records] of "
            f"{ship.path.name}"
        )
    if interval is None:
        return load_record(path, columns)
    record = load_record(path, {key: one for key, one in columns.items() if key != "t"})
    return replace(record, t=record.t * interval)


def _from_ground(record: Record, ship: ShipFile) -> Record:
    """Return the record with velocities over ground turned into the ship's axes."""
    if record.north_velocity is None or record.east_velocity is None:
        return record
    if ship.records.current != "none":
        raise ConfigError(
            f"{record.source}: north_velocity, east_velocity: these are over ground, and forces "
            f'come from the speed through the water: say current = "none" in [records] of '
            f"{ship.path.name} if the water stood still, or give the log as speed and sway"
        )
    speed, sway = resolve_along(
        record.east_velocity, record.north_velocity, record.column("heading")
    )
    return replace(record, speed=speed, sway=sway)


def _check_needed(record: Record, ship: ShipFile) -> None:
    """Check that all that the model needs was recorded; ConfigError saying what is missing."""
    problems = [
        f"{record.source}: no {channel} was recorded: {why}; name its column as channel {channel} "
        f"in [[columns]] of {ship.path.name}"
        for channel, why in NEEDED_CHANNELS.items()
        if getattr(record, channel) is None
    ]
    if ship.roll is not None and record.roll is None:
        problems.append(
            f"{record.source}: no roll was recorded, and {ship.path.name} has [roll]: name its "
            "column as channel roll in [[columns]], or take [roll] out"
        )
    if record.heading is None and record.yaw_rate is None:
        problems.append(f"{record.source}: neither heading nor yaw_rate was recorded")
    raise_problems(problems)


def _rate(record: Record) -> Numbers:
    """Return the yaw rate [rad/s], that of the heading where none was recorded."""
    if record.yaw_rate is not None:
        return record.yaw_rate
    return np.asarray(np.gradient(record.column("heading"), record.t))


def _check_propeller(record: Record, ship: ShipFile) -> None:
    """Check that propeller, revolutions and speed belong together; ConfigError with the remedy."""
    speed, n = record.column("speed"), record.column("revolutions")
    driven = np.isfinite(n) & np.isfinite(speed) & (n != 0.0)
    if not driven.any():
        raise ConfigError(f"{record.source}: revolutions are 0 in all rows: is the unit right?")
    D, w = ship.dimensions.propeller_diameter_m, ship.dimensions.wake_fraction
    advance = (1.0 - w) * speed[driven] / (n[driven] * D)
    usual = float(np.median(advance))
    if ADVANCE_RATIO_RANGE[0] <= usual <= ADVANCE_RATIO_RANGE[1]:
        return
    row = record.row(int(np.flatnonzero(driven)[0]))
    raise ConfigError(
        f"{record.source}: row {row}: the propeller advances J = {usual:.3g} diameters a turn, "
        f"{ADVANCE_RATIO_RANGE[0]:g} to {ADVANCE_RATIO_RANGE[1]:g} are usual: is the diameter in "
        "feet, are revolutions per minute (rpm) or per second (1/s), is the speed in knots?"
    )


def _check_roll(record: Record, ship: ShipFile, gm: float, every: int) -> Iterator[str]:
    """Yield what is odd about a roll; ConfigError if it cannot be used.

    There must be enough samples in its period. In a turn a ship heels by u r/g times a lever over
    GM; if the record needs a lever that no ship has, its unit is wrong.
    """
    period = 2.0 * math.pi / math.sqrt(ship.stiffness)
    step = every * float(np.median(np.diff(record.t)))
    if MIN_ROLL_SAMPLES * step > period:
        raise ConfigError(
            f"{record.source}: a sample each {step:.3g} s, and a roll of {ship.path.name} lasts "
            f"{period:.3g} s: needs {MIN_ROLL_SAMPLES} samples or more; take fewer rows by --every"
        )
    roll, pull = record.column("roll"), record.column("speed") * _rate(record) / GRAVITY_M_S2
    known, length = np.isfinite(roll + pull), ship.dimensions.length_m
    if np.count_nonzero(known) < MIN_TRIAL_SAMPLES:
        raise ConfigError(f"{record.source}: roll: fewer than {MIN_TRIAL_SAMPLES} rows have one")
    rolled, pulled = float(np.std(roll[known])), float(np.std(pull[known]))
    lever = gm * rolled / max(pulled, 1e-12) / length
    if not HEEL_LEVER_RANGE[0] <= lever <= HEEL_LEVER_RANGE[1]:
        way = "rad, not deg" if lever < HEEL_LEVER_RANGE[0] else "deg, not rad"
        raise ConfigError(
            f"{record.source}: row {record.row(0)} on: roll of {rolled:.3g} rad, and turning "
            f"heels it by {pulled:.3g} rad for a lever of GM: is it in {way}, "
            f"is gm_m = {gm:g} of {ship.path.name} right?"
        )
    if np.corrcoef(roll[known], pull[known])[0, 1] > INWARD_LEAN_CORRELATION:
        yield f"{record.name('roll')}: leans into the turn: is it positive to starboard?"


def _read_by(record: Record, sensors: Sensors) -> Record:
    """Return what instruments would have read, each file with its own errors.

    The log reads speed too. Roll has the errors of heading, and its rate those of the yaw rate.
    """
    if record.speed is None:
        return record
    seeds = int(sensors.seed or 1), zlib.crc32(Path(record.source).name.encode())

    def errors(like: str, number: int) -> Numbers:
        stream = np.random.Generator(np.random.PCG64(np.random.SeedSequence((*seeds, number))))
        return sensors.error(like) * stream.standard_normal(len(record.t))

    others = read_by(record, replace(sensors, seed=float(sum(seeds))))
    rolls = {
        name: values + errors(like, ROLL_STREAM + i)
        for i, (name, like) in enumerate(zip(ROLL_CHANNELS, ("yaw_rate", "heading"), strict=True))
        if (values := getattr(record, name)) is not None
    }
    return replace(others, speed=record.speed + errors("sway", SPEED_STREAM), **rolls)


def turned_ranges(trials: Sequence[Record], length: float) -> dict[str, tuple[float, float]]:
    """Return ranges of v', r' [-], rudder, roll [rad] and speed [m/s] in the records."""
    rows, inputs = (np.vstack([*map(of, trials)]) for of in (readings_of, inputs_of))
    u, v, r = rows.T[:3]
    size = np.hypot(u, np.nan_to_num(v))
    seen = {"v": v / size, "r": r * length / size, "rudder": inputs[:, 0], "speed": u}
    seen |= {"roll": rows[:, -1]} if rows.shape[1] > len(READING_CHANNELS) else {}
    return {
        name: (float(np.nanmin(values)), float(np.nanmax(values)))
        for name, values in seen.items()
        if np.isfinite(values).any()
    }


def notes_of(trials: Sequence[Record]) -> Iterator[str]:
    """Yield what was found in the records, each with its file where there are several."""
    for trial in trials:
        for text in map(str, trial.findings):
            yield f"{Path(trial.source).name}: {text}" if len(trials) > 1 else text

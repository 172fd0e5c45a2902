"""Records of ships that are not linear: read, examined, and averaged to samples.

Such a fit needs speed, sway and propeller revolutions beside helm and turning. ``Trial`` has them
as one table in the columns of ``kernels/extended_filter``, SI and radians. There a positive rudder
turns to starboard, unlike in a record.
"""

import math
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from trainer.config.files import ConfigError, quote, raise_problems
from trainer.config.sensors import Sensors
from trainer.config.ship import GRAVITY_M_S2, ShipFile
from trainer.config.tables import read_table
from trainer.core.kernel import Numbers
from trainer.identify.record.findings import (
    PATH_TEXTS,
    choose_path,
    examine_record,
    unwrap_heading,
)
from trainer.identify.record.measurements import Finding, Record
from trainer.identify.record.sources import (
    FURTHER_CHANNELS,
    FURTHER_COLUMNS,
    Column,
    load_record,
    own_columns,
    read_by,
    read_channel,
)
from trainer.identify.record.track import resolve_along
from trainer.io.paths import RECORDING_SUFFIX

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
WRONG_SIGN_CORRELATION: Final = 0.2  # [-] of rudder and turning: beyond, the sign is plainly wrong
GROUND_VELOCITIES: Final = ("north_velocity", "east_velocity")
READING_COLUMNS: Final = (0, 1, 2, 3, 10, 11)  # columns of the table
SPEED_STREAM, ROLL_STREAM = 13, 14  # of the errors of instruments
MAX_ROLL_STEP_RAD: Final = 0.5  # [rad] of roll's own period in a step of Runge and Kutta
MIN_ROLL_SAMPLES: Final = 6  # samples in that period, at least
HEEL_LEVER_RANGE: Final = (0.002, 0.5)  # [L] of the forces that heel a ship


@dataclass(frozen=True)
class Trial:
    """A record ready for the filter; ``table`` has its columns, positive rudder to starboard."""

    source: str
    t: Numbers  # [s]
    table: Numbers  # (n, 10), with roll (n, 12)
    findings: tuple[str, ...]
    windy: bool

    @property
    def readings(self) -> Numbers:
        """Return u, v, r, heading (n, 4), and any roll rate and roll (n, 6)."""
        return self.table[:, :4] if self.table.shape[1] == 10 else self.table[:, READING_COLUMNS]

    @property
    def inputs(self) -> Numbers:
        """Return rudder, revolutions and wind (n, 4)."""
        return self.table[:, 4:8]


def load_trial(path: Path, ship: ShipFile, every: int = 1) -> Trial:
    """Return a record, its rows averaged by ``every``. ConfigError with what forbids its use."""
    return trial_of(*_read(path, ship, _columns(path, ship)), ship, every)


def trial_of(record: Record, further: dict[str, Numbers], ship: ShipFile, every: int = 1) -> Trial:
    """Return a record with its ``further`` channels, SI, examined and averaged. ConfigError."""
    record = _from_ground(record, further, ship)
    if ship.roll is None:
        further = {key: one for key, one in further.items() if key not in ROLL_CHANNELS}
    _check_needed(record.source, ship, {**further, **dict.fromkeys(record.channels, record.t)})
    if ship.records.positive_rudder == "starboard" and record.rudder is not None:
        record = replace(record, rudder=-record.rudder)
    findings = examine_record(record)
    record = unwrap_heading(record)
    _check_sign(record)
    path, told = _rudder_path(record, ship, every)
    findings.append(told)
    if ship.sensors is not None:
        record, further = _read_by(record, further, ship.sensors)
    none = np.full(len(record.t), math.nan)
    readings = [record.speed, record.sway, record.yaw_rate, record.heading]
    calm = np.zeros(len(record.t))  # a relative wind that was not recorded is none
    ahead, starboard = further.get("wind_ahead", calm), further.get("wind_starboard", calm)
    if "wind_speed" in further and "wind_from" in further:
        size, angle = further["wind_speed"], further["wind_from"]
        ahead, starboard = size * np.cos(angle), size * np.sin(angle)
    # within the model a positive rudder turns to starboard (docs/nonlinear-ships.md)
    inputs = [-record.column("rudder"), further["revolutions"], ahead, starboard]
    rolls = [further.get(name, none) for name in ROLL_CHANNELS] if "roll" in further else []
    table = np.column_stack([*(none if one is None else one for one in readings), *inputs, *rolls])
    if ship.roll is not None:
        remarks = _check_roll(record, further["roll"], ship, ship.roll.gm_m, every)
        findings += [Finding(Path(record.source).name, 0, text) for text in remarks]
    _check_propeller(record, further["revolutions"], ship)
    for channel, values in further.items():
        missing = np.isnan(values)
        if channel not in (*GROUND_VELOCITIES, *ROLL_CHANNELS) and missing.any():
            row = record.row(int(np.argmax(missing)))
            raise ConfigError(f"{record.source}: row {row}: {channel}: an input must be known")
    t = record.t
    if every > 1:  # rows are the means of as many around them
        indices = np.arange(every // 2, len(t) - every // 2, every)
        around = indices[:, None] + np.arange(every) - every // 2
        t, table = t[indices], table[around].mean(axis=1)
    if len(t) < MIN_TRIAL_SAMPLES:
        raise ConfigError(
            f"{record.source}: has {len(t)} samples of {every} rows; needs "
            f"{MIN_TRIAL_SAMPLES} or more"
        )
    table = with_steps(t, table, ship)
    table[:, 9] *= RUDDER_PATH_SIGNS[path]
    return Trial(record.source, t, table, tuple(map(str, findings)), bool(np.any(table[:, 6:8])))


def _rudder_path(record: Record, ship: ShipFile, every: int) -> tuple[str, Finding]:
    """Return how the rudder goes from reading to reading, one of INPUT_PATHS, and what tells it."""
    path, why = choose_path(record, ("rudder",), ship.records.between_readings)
    if every > 1:  # between two means it goes evenly
        path, why = "straight", f"each the mean of {every} rows"
    return path, record.finding("rudder", f"taken as {PATH_TEXTS[path]}, {why}")


def _columns(path: Path, ship: ShipFile) -> dict[str, Column]:
    """Return where each channel is: as the ship's file says, or as the trainer writes them."""
    if ship.columns:
        columns = {
            row.channel: Column(row.column, row.unit, row.missing or ()) for row in ship.columns
        }
        if "rudder" not in columns:
            raise ConfigError(f"{ship.path.name}: [columns]: no column is the rudder")
        return columns
    table = read_table(path)
    trainer_columns = {
        **own_columns(),
        **{key: Column(name, None) for key, name in FURTHER_COLUMNS.items()},
    }
    unread = ROLL_CHANNELS if ship.roll is None else ()
    return {
        key: one
        for key, one in trainer_columns.items()
        if table.has(one.name) and key not in unread
    }


def _read(
    path: Path, ship: ShipFile, columns: Mapping[str, Column]
) -> tuple[Record, dict[str, Numbers]]:
    """Return the record and its further channels, SI."""
    if path.suffix == RECORDING_SUFFIX:
        raise ConfigError(
            f"{path}: records for this model are CSV files: trainer export {path} --csv FILE "
            "writes one"
        )
    usual = {key: one for key, one in columns.items() if key not in FURTHER_CHANNELS}
    if ship.records.interval_s is not None:
        usual.pop("t", None)
    elif "t" not in usual:
        raise ConfigError(
            f"{path}: no column of times: name it, or say interval_s in [records] of "
            f"{ship.path.name}"
        )
    record = load_record(path, usual)
    if ship.records.interval_s is not None:
        record = replace(record, t=record.t * ship.records.interval_s)
    table = read_table(path)
    further = {}
    for key, one in columns.items():
        if key in FURTHER_CHANNELS:
            index = table.index(one.name, key)
            known = FURTHER_CHANNELS[key]
            unit = one.unit or table.units[index] or next(iter(known))
            if unit not in known:
                wrong = f"unit {quote(unit)}: must be {' or '.join(known)}"
                raise ConfigError(f"{path}: {one.name}: {wrong}")
            further[key] = read_channel(table, key, one, unit)
    return record, further


def _from_ground(record: Record, further: dict[str, Numbers], ship: ShipFile) -> Record:
    """Return the record with velocities over ground turned into the ship's axes."""
    if not all(key in further for key in GROUND_VELOCITIES):
        return record
    if ship.records.current != "none":
        raise ConfigError(
            f"{record.source}: north_velocity, east_velocity: these are over ground, and forces "
            f'come from the speed through the water: say current = "none" in [records] of '
            f"{ship.path.name} if the water stood still, or give the log as speed and sway"
        )
    speed, sway = resolve_along(
        further[GROUND_VELOCITIES[1]], further[GROUND_VELOCITIES[0]], record.column("heading")
    )
    return replace(record, speed=speed, sway=sway)


def _check_needed(source: str, ship: ShipFile, found: Mapping[str, Numbers]) -> None:
    """Check that all that the model needs was recorded; ConfigError saying what is missing."""
    problems = [
        f"{source}: no {channel} was recorded: {why}; name its column as channel {channel} in "
        f"[[columns]] of {ship.path.name}"
        for channel, why in NEEDED_CHANNELS.items()
        if channel not in found
    ]
    if ship.roll is not None and "roll" not in found:
        problems.append(
            f"{source}: no roll was recorded, and {ship.path.name} has [roll]: name its column as "
            "channel roll in [[columns]], or take [roll] out"
        )
    if "heading" not in found and "yaw_rate" not in found:
        problems.append(f"{source}: neither heading nor yaw_rate was recorded")
    raise_problems(problems)


def _rate(record: Record) -> Numbers:
    """Return the yaw rate [rad/s], that of the heading where none was recorded."""
    if record.yaw_rate is not None:
        return record.yaw_rate
    return np.asarray(np.gradient(record.column("heading"), record.t))


def _check_sign(record: Record) -> None:
    """Check that a positive rudder turns the ship to port; ConfigError with the remedy."""
    rate, rudder = _rate(record), record.column("rudder")
    # a rudder makes yaw acceleration at once, while the yaw rate follows it late
    change = np.gradient(np.nan_to_num(rate), record.t)
    good = np.isfinite(rate)
    together = float(np.corrcoef(rudder[good], change[good])[0, 1])
    if together > WRONG_SIGN_CORRELATION:
        text = f"positive helm turns this ship to starboard (correlation {together:.2f}): "
        remedy = 'say positive_rudder = "starboard" in [records]'
        what = record.finding("rudder", text + remedy, np.argmax(np.abs(rudder)))
        raise ConfigError(f"{record.source}: {what}")


def _check_propeller(record: Record, n: Numbers, ship: ShipFile) -> None:
    """Check that propeller, revolutions and speed belong together; ConfigError with the remedy."""
    speed = record.column("speed")
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


def _check_roll(
    record: Record, roll: Numbers, ship: ShipFile, gm: float, every: int
) -> Iterator[str]:
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
    pull = record.column("speed") * _rate(record) / GRAVITY_M_S2
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


def _read_by(
    record: Record, further: dict[str, Numbers], sensors: Sensors
) -> tuple[Record, dict[str, Numbers]]:
    """Return what instruments would have read, each file with its own errors.

    The log reads speed too. Roll has the errors of heading, and its rate those of the yaw rate.
    """
    if record.speed is None:
        return record, further
    seeds = int(sensors.seed or 1), zlib.crc32(Path(record.source).name.encode())

    def errors(like: str, number: int) -> Numbers:
        stream = np.random.Generator(np.random.PCG64(np.random.SeedSequence((*seeds, number))))
        return sensors.error(like) * stream.standard_normal(len(record.t))

    others = read_by(record, replace(sensors, seed=float(sum(seeds))))
    rolls = {
        name: further[name] + errors(like, ROLL_STREAM + i)
        for i, (name, like) in enumerate(zip(ROLL_CHANNELS, ("yaw_rate", "heading"), strict=True))
        if name in further
    }
    return replace(others, speed=record.speed + errors("sway", SPEED_STREAM)), further | rolls


def with_steps(t: Numbers, table: Numbers, ship: ShipFile) -> Numbers:
    """Return the table as extended_filter takes it: with times and steps, then roll.

    A step of Runge and Kutta must be short against the ship's own motions.
    """
    gaps = np.append(np.diff(t), 0.0)
    length, speed = ship.dimensions.length_m, float(np.nanmax(np.abs(table[:, 0])))
    # steps are short against a ship's length and against its period of roll; 1e-9 is for rounding
    parts = np.maximum(np.ceil(gaps / (FINE_STEP_SHARE * length / speed) - 1e-9), 1.0)
    parts = np.maximum(parts, np.ceil(gaps * math.sqrt(ship.stiffness) / MAX_ROLL_STEP_RAD))
    return np.ascontiguousarray(np.column_stack([table[:, :8], gaps, parts, table[:, 8:]]))


def turned_ranges(trials: Sequence[Trial], length: float) -> dict[str, tuple[float, float]]:
    """Return ranges of v', r' [-], rudder, roll [rad] and speed [m/s] in the records."""
    rows = np.vstack([trial.table for trial in trials])
    u, v, r = rows[:, 0], rows[:, 1], rows[:, 2]
    size = np.hypot(u, np.nan_to_num(v))
    seen = {"v": v / size, "r": r * length / size, "rudder": rows[:, 4], "speed": u}
    seen |= {"roll": rows[:, -1]} if rows.shape[1] > 10 else {}
    return {
        name: (float(np.nanmin(values)), float(np.nanmax(values)))
        for name, values in seen.items()
        if np.isfinite(values).any()
    }


def notes_of(trials: Sequence[Trial]) -> Iterator[str]:
    """Yield what was found in the records, each with its file where there are several."""
    for trial in trials:
        for text in trial.findings:
            yield f"{Path(trial.source).name}: {text}" if len(trials) > 1 else text

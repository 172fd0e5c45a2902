"""Records of ships that are not linear: read, examined, and averaged to samples."""

import math
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from trainer.config.files import ConfigError, quote
from trainer.config.tables import read_table
from trainer.core.kernel import Numbers
from trainer.identify.findings import examine, unwrap_heading
from trainer.identify.measurements import Record
from trainer.identify.ships.ship_file import CHANNELS, ShipFile
from trainer.identify.sources import UNITS, Column, Sensors, load_record, own_columns, read_by

OWN: Final = {  # columns of the trainer that ships that are not linear need beside the usual ones
    "revolutions": "n",
    "wind_ahead": "wind_ahead",
    "wind_starboard": "wind_starboard",
}
FURTHER: Final[Mapping[str, Mapping[str, float]]] = {  # channels that are not a record's, and units
    "revolutions": {"1/s": 1.0, "rps": 1.0, "rpm": 1.0 / 60.0},
    **dict.fromkeys(("north_velocity", "east_velocity"), UNITS["m/s"]),
    **dict.fromkeys(("wind_speed", "wind_ahead", "wind_starboard"), UNITS["m/s"]),
    "wind_from": UNITS["rad"],
}
NEEDED: Final = {  # and why
    "speed": "the speed through the water drives every force",
    "sway": "the drift cannot be told from the turning",
    "revolutions": "the propeller's slipstream drives the rudder",
}
ADVANCE: Final = (0.1, 1.6)  # J of a propeller that drives a ship ahead
FINE: Final = 0.1  # [L/U] of a step of Runge and Kutta
SHORTEST: Final = 30  # samples
TURNS_RIGHT: Final = 0.2  # correlation of rudder and turning beyond which the sign is plain
GROUND: Final = ("north_velocity", "east_velocity")


@dataclass(frozen=True)
class Trial:
    """A record ready for the filter; ``table`` has its columns, positive rudder to starboard."""

    source: str
    t: Numbers  # [s]
    table: Numbers  # (n, 10)
    findings: tuple[str, ...]
    windy: bool

    @property
    def readings(self) -> Numbers:
        """Return u, v, r and heading (n, 4)."""
        return self.table[:, :4]

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
    _check_needed(record.source, ship, {**further, **dict.fromkeys(record.channels, record.t)})
    if ship.records.positive_rudder == "starboard" and record.rudder is not None:
        record = replace(record, rudder=-record.rudder)
    findings = [*record.told, *examine(record)]
    record = unwrap_heading(record)
    _check_sign(record)
    if ship.sensors is not None:
        record = _read_by(record, ship.sensors)
    table = _table(record, further)
    _check_propeller(record, further["revolutions"], ship)
    _check_inputs(record, further)
    t, table = _averaged(record.t, table, every)
    if len(t) < SHORTEST:
        raise ConfigError(
            f"{record.source}: has {len(t)} samples of {every} rows; needs {SHORTEST} or more"
        )
    table = with_steps(t, table, ship)
    return Trial(record.source, t, table, tuple(map(str, findings)), bool(np.any(table[:, 6:8])))


def _columns(path: Path, ship: ShipFile) -> dict[str, Column]:
    """Return where each channel is: as the ship's file says, or as the trainer writes them."""
    if ship.columns:
        found = {row.channel: Column(row.column, row.unit) for row in ship.columns}
        if "rudder" not in found:
            raise ConfigError(f"{ship.path.name}: [columns]: no column is the rudder")
        return found
    table = read_table(path)
    own = {**own_columns(), **{key: Column(name, None) for key, name in OWN.items()}}
    return {key: one for key, one in own.items() if table.has(one.name)}


def _read(
    path: Path, ship: ShipFile, columns: Mapping[str, Column]
) -> tuple[Record, dict[str, Numbers]]:
    """Return the record and its further channels, SI."""
    if path.suffix != ".csv":
        raise ConfigError(f"{path}: records for this model are CSV files")
    usual = {key: one for key, one in columns.items() if key not in FURTHER}
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
        if key in FURTHER:
            place = table.place(one.name, key)
            unit = one.unit or table.units[place] or next(iter(FURTHER[key]))
            if unit not in FURTHER[key]:
                known = " or ".join(FURTHER[key])
                raise ConfigError(f"{path}: {one.name}: unit {quote(unit)}: must be {known}")
            further[key] = table.numbers(place) * FURTHER[key][unit]
    return record, further


def _from_ground(record: Record, further: dict[str, Numbers], ship: ShipFile) -> Record:
    """Return the record with velocities over ground turned into the ship's axes."""
    if not all(key in further for key in GROUND):
        return record
    if ship.records.current != "none":
        raise ConfigError(
            f"{record.source}: north_velocity, east_velocity: these are over ground, and forces "
            f'come from the speed through the water: say current = "none" in [records] of '
            f"{ship.path.name} if the water stood still, or give the log as speed and sway"
        )
    psi, north, east = record.column("heading"), further[GROUND[0]], further[GROUND[1]]
    return replace(
        record,
        speed=north * np.cos(psi) + east * np.sin(psi),
        sway=east * np.cos(psi) - north * np.sin(psi),
    )


def _check_needed(source: str, ship: ShipFile, found: Mapping[str, Numbers]) -> None:
    """Check that all that the model needs was recorded; ConfigError saying what is missing."""
    problems = [
        f"{source}: no {channel} was recorded: {why}; name its column as channel {channel} in "
        f"[[columns]] of {ship.path.name}"
        for channel, why in NEEDED.items()
        if channel not in found
    ]
    if "heading" not in found and "yaw_rate" not in found:
        problems.append(f"{source}: neither heading nor yaw_rate was recorded")
    if problems:
        raise ConfigError(*problems)


def _rate(record: Record) -> Numbers:
    """Return the yaw rate [rad/s], that of the heading where none was recorded."""
    if record.yaw_rate is not None:
        return record.yaw_rate
    return np.asarray(np.gradient(record.column("heading"), record.t))


def _check_sign(record: Record) -> None:
    """Check that a positive rudder turns the ship to port; ConfigError with the remedy."""
    rate, rudder = _rate(record), record.column("rudder")
    change = np.gradient(np.nan_to_num(rate), record.t)
    good = np.isfinite(rate)
    together = float(np.corrcoef(rudder[good], change[good])[0, 1])
    if together > TURNS_RIGHT:
        row = record.row(int(np.argmax(np.abs(rudder))))
        raise ConfigError(
            f"{record.source}: row {row}: {record.name('rudder')}: positive helm turns this ship "
            f'to starboard (correlation {together:.2f}): say positive_rudder = "starboard" in '
            "[records]"
        )


def _check_propeller(record: Record, n: Numbers, ship: ShipFile) -> None:
    """Check that propeller, revolutions and speed belong together; ConfigError with the remedy."""
    speed = record.column("speed")
    driven = np.isfinite(n) & np.isfinite(speed) & (n != 0.0)
    if not driven.any():
        raise ConfigError(f"{record.source}: revolutions are 0 in all rows: is the unit right?")
    D, w = ship.dimensions.propeller_diameter_m, ship.dimensions.wake_fraction
    advance = (1.0 - w) * speed[driven] / (n[driven] * D)
    usual = float(np.median(advance))
    if ADVANCE[0] <= usual <= ADVANCE[1]:
        return
    row = record.row(int(np.flatnonzero(driven)[0]))
    raise ConfigError(
        f"{record.source}: row {row}: the propeller advances J = {usual:.3g} diameters a turn, "
        f"{ADVANCE[0]:g} to {ADVANCE[1]:g} are usual: is the diameter in feet, are revolutions "
        "per minute (rpm) or per second (1/s), is the speed in knots?"
    )


def _check_inputs(record: Record, further: Mapping[str, Numbers]) -> None:
    """Check that no input is missing anywhere; ConfigError with its first row."""
    for channel, values in further.items():
        missing = np.isnan(values)
        if channel not in GROUND and missing.any():
            row = record.row(int(np.argmax(missing)))
            raise ConfigError(f"{record.source}: row {row}: {channel}: an input must be known")


def _read_by(record: Record, sensors: Sensors) -> Record:
    """Return what instruments would have read, each file anew; the log reads speed too."""
    if record.speed is None:
        return record
    own = int(sensors.seed or 1), zlib.crc32(Path(record.source).name.encode())
    seed = np.random.SeedSequence((*own, len(CHANNELS)))
    stream = np.random.Generator(np.random.PCG64(seed))
    error = sensors.error("sway") * stream.standard_normal(len(record.t))
    others = read_by(record, replace(sensors, seed=float(sum(own))))
    return replace(others, speed=record.speed + error)


def _table(record: Record, further: Mapping[str, Numbers]) -> Numbers:
    """Return readings and inputs (n, 8), the rudder positive to starboard."""
    none = np.full(len(record.t), math.nan)
    readings = [record.speed, record.sway, record.yaw_rate, record.heading]
    ahead, starboard = _wind(further, len(record.t))
    inputs = [-record.column("rudder"), further["revolutions"], ahead, starboard]
    return np.column_stack([*(none if one is None else one for one in readings), *inputs])


def _wind(further: Mapping[str, Numbers], count: int) -> tuple[Numbers, Numbers]:
    """Return the relative wind from ahead and from starboard [m/s], 0 where not recorded."""
    if "wind_speed" in further and "wind_from" in further:
        size, angle = further["wind_speed"], further["wind_from"]
        return size * np.cos(angle), size * np.sin(angle)
    calm = np.zeros(count)
    return further.get("wind_ahead", calm), further.get("wind_starboard", calm)


def _averaged(t: Numbers, table: Numbers, every: int) -> tuple[Numbers, Numbers]:
    """Return every so many rows, each the mean of as many around it."""
    if every == 1:
        return t, table
    places = np.arange(every // 2, len(t) - every // 2, every)
    around = places[:, None] + np.arange(every) - every // 2
    return t[places], np.asarray(table[around].mean(axis=1))


def with_steps(t: Numbers, table: Numbers, ship: ShipFile) -> Numbers:
    """Return the table with seconds to the next row and the steps in them."""
    gaps = np.append(np.diff(t), 0.0)
    length, speed = ship.dimensions.length_m, float(np.nanmax(np.abs(table[:, 0])))
    parts = np.maximum(np.ceil(gaps / (FINE * length / speed) - 1e-9), 1.0)
    found = np.column_stack([table, gaps, parts])
    return np.ascontiguousarray(found)


def turned_ranges(trials: Sequence[Trial], length: float) -> dict[str, tuple[float, float]]:
    """Return what the records saw of v', r' [-], rudder [rad] and speed [m/s]."""
    rows = np.vstack([trial.table for trial in trials])
    u, v, r = rows[:, 0], rows[:, 1], rows[:, 2]
    size = np.hypot(u, np.nan_to_num(v))
    seen = {"v": v / size, "r": r * length / size, "rudder": rows[:, 4], "speed": u}
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

"""Published results of a boat, from a file beside its own, with ours beside them.

Manoeuvres are flown; motion in regular waves is that of the linear equations.

The file of ``boat.toml`` is ``boat.trials.toml``; those of shipped boats are among ``trials``.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Final

from trainer.analysis.guide.programme import FlightTable, Task
from trainer.analysis.manoeuvres.catalogue import MANOEUVRES, find_manoeuvre
from trainer.analysis.manoeuvres.flight import FIELD_CHOICES, Flight, Manoeuvre
from trainer.boat.assemble import Method
from trainer.boat.boat import Boat
from trainer.boat.linear import head_wave_response, head_waves
from trainer.config.files import (
    ConfigError,
    Place,
    as_table,
    collecting,
    nearest,
    parse_toml,
    quote,
    read_text,
    shipped_names,
    shipped_path,
)
from trainer.config.schema import Choice, Quantities, Quantity, Text, read_record, required, within
from trainer.config.vessel import VesselFile

TRIAL_KEYS: Final = ("title", "source", "note", "manoeuvre", "speed_m_s", "columns", "results")
FILE_UNITS: Final = {  # of the file, to SI and radians
    **dict.fromkeys(("m", "s", "m/s", "rad", "rad/s", "-"), 1.0),
    **dict.fromkeys(("deg", "deg/s"), math.radians(1.0)),
}
NOTE_FIELD: Final = Text(500, "what it is, and whose")
SPEED_FIELD: Final = Quantity("m/s", within(0, 50), "at which it begins; 0: from rest")
PARAMETER_FIELD: Final = Quantity("-", within(-1e6, 1e6), "of a manoeuvre, in the unit of its name")
VALUE_FIELD: Final = Quantity("-", within(-1e9, 1e9), "as published, in the unit of its result")
STEP_SHARE: Final = 0.2  # of the boat's own: the step of Runge and Kutta
TIMED_READING: Final = re.compile(r"(\w+) after (\d+(?:\.\d*)?) s")


@dataclass(frozen=True)
class PublishedValue:
    """One quantity as published, in the units of its source."""

    quantity: str
    unit: str
    values: tuple[float | None, ...]  # by column


@dataclass(frozen=True)
class Trial:
    """One manoeuvre as published."""

    title: str
    source: str
    note: str
    manoeuvre: Manoeuvre
    speed: float  # [m/s]
    columns: tuple[str, ...]  # of the results: trials, computations of others
    results: tuple[PublishedValue, ...]

    def task(self, file: VesselFile) -> Task:
        """Return our flight of it."""
        return Task(
            self.manoeuvre,
            self.speed,
            Method("full", "exact", "exact", "rk4", STEP_SHARE * file.run.step_s),
        )


def _by_depth(unit: str, meaning: str) -> Quantities:
    """Return numbers of waves, one for each depth."""
    return Quantities(Quantity(unit, within(0, 12000), meaning), 1, 20)


@dataclass(frozen=True, kw_only=True)
class HeadWaves:
    """Motion in regular waves from ahead as published, planes fixed."""

    title: str = required(NOTE_FIELD)
    source: str = required(NOTE_FIELD)
    speed_m_s: float = required(Quantity("m/s", within(0.1, 50), "of the boat"))
    period_s: float = required(Quantity("s", within(1, 60), "of the waves"))
    height_m: float = required(Quantity("m", within(0.01, 25), "of the waves"))
    depth_m: tuple[float, ...] = required(_by_depth("m", "depths of the origin"))
    heave: tuple[float, ...] = required(_by_depth("-", "amplitude over the waves'"))
    pitch_deg: tuple[float, ...] = required(_by_depth("deg", "amplitude"))


@dataclass(frozen=True)
class WaveMotion:
    """One depth of published waves, and our heave [-] and pitch [deg]."""

    depth_m: float
    published: tuple[float, float]
    ours: tuple[float, float]
    without_flow: tuple[float, float]  # the hull's lift does not feel the water's own motion


@dataclass(frozen=True)
class WaveComparison:
    """Published waves and our motion in them."""

    waves: HeadWaves
    problem: str  # why there is none
    rows: tuple[WaveMotion, ...]


@dataclass(frozen=True)
class TrialComparison:
    """One trial and our numbers, in the units of its source."""

    trial: Trial
    problem: str  # why there are none
    ours: tuple[float | None, ...]  # by result


def trials_path(file: VesselFile) -> Path | None:
    """Return where the published results of a boat are, None if there are none."""
    beside = file.path.with_suffix(".trials.toml")
    if beside.is_file():
        return beside
    name = file.path.stem
    is_shipped = name in shipped_names("vessels") and shipped_path("vessels", name) == file.path
    return shipped_path("trials", name) if is_shipped and name in shipped_names("trials") else None


def load_published(path: Path) -> tuple[tuple[Trial, ...], tuple[HeadWaves, ...]]:
    """Return the trials and the waves of a file. ConfigError with all that is wrong in it."""
    tables = parse_toml(read_text(path), path.name)
    lists = [tables.get(name, []) for name in ("trials", "waves")]
    known = {"trials"} <= set(tables) <= {"trials", "waves"}
    if not known or not all(isinstance(rows, list) for rows in lists):
        text = "must hold tables [[trials]], may hold [[waves]], and nothing else"
        raise ConfigError(f"{path.name}: {text}")
    problems: list[str] = []

    def read_all(name: str, read: Callable[[Mapping[str, Any], Place], Any]) -> Iterator[Any]:
        for i, row in enumerate(tables.get(name, []), start=1):
            place = Place(path.name, f"{name} {i}")
            with collecting(problems):
                yield read(as_table(row, place), place)

    published = tuple(read_all("trials", _trial)), tuple(read_all("waves", _waves))
    if problems:
        raise ConfigError(*problems)
    return published


def _waves(row: Mapping[str, Any], place: Place) -> HeadWaves:
    """Return regular waves; ConfigError if they are wrong."""
    waves = read_record(HeadWaves, row, place, ())
    for name in ("heave", "pitch_deg"):
        values = getattr(waves, name)
        if len(values) != len(waves.depth_m):
            wanted = f"must have {len(waves.depth_m)} numbers as depth_m has"
            raise ConfigError(place.wrong(name, list(values), wanted))
    return waves


def _trial(row: Mapping[str, Any], place: Place) -> Trial:
    """Return one trial; ConfigError if it is wrong."""
    for key in TRIAL_KEYS:
        if key not in row:
            raise ConfigError(place.problem(f"lacks {key}"))
    columns = _words("columns", row["columns"], place)
    if not isinstance(row["results"], list):
        raise ConfigError(place.wrong("results", row["results"], "must be a list of results"))
    return Trial(
        title=NOTE_FIELD.read("title", row["title"], place),
        source=NOTE_FIELD.read("source", row["source"], place),
        note=str(row["note"]),
        manoeuvre=_manoeuvre(row, place),
        speed=SPEED_FIELD.read("speed_m_s", row["speed_m_s"], place),
        columns=columns,
        results=tuple(_read_result(result, columns, place) for result in row["results"]),
    )


def _manoeuvre(row: Mapping[str, Any], place: Place) -> Manoeuvre:
    """Return the manoeuvre that a trial names, with its parameters; ConfigError if it has none."""
    name = row["manoeuvre"]
    if not isinstance(name, str) or name not in MANOEUVRES:
        advice = f"no such manoeuvre{nearest(str(name), MANOEUVRES)}"
        raise ConfigError(place.wrong("manoeuvre", name, advice))
    manoeuvre = find_manoeuvre(name)
    known = {field.name: getattr(manoeuvre, field.name) for field in fields(manoeuvre)}
    field_values = {}
    for key, value in row.items():
        if key in TRIAL_KEYS:
            continue
        if key not in known:
            raise ConfigError(place.wrong(key, value, f"no such key{nearest(key, known)}"))
        read: Callable[[str, object, Place], Any] = PARAMETER_FIELD.read
        if key in FIELD_CHOICES:
            read = Choice(FIELD_CHOICES[key], "as --side, or rise and dive").read
        elif isinstance(known[key], tuple):
            read = _words
        field_values[key] = read(key, value, place)
    return replace(manoeuvre, **field_values)


def _words(key: str, value: object, place: Place) -> tuple[str, ...]:
    """Return a list of words; ConfigError if it is none."""
    if not isinstance(value, list) or not all(isinstance(word, str) for word in value):
        raise ConfigError(place.wrong(key, value, "must be a list of words"))
    return tuple(value)


def _read_result(row: Any, columns: tuple[str, ...], place: Place) -> PublishedValue:
    """Return one result; ConfigError if it is not a quantity, a unit and a value by column."""
    if not isinstance(row, list) or len(row) != len(columns) + 2:
        wanted = f"must be quantity, unit and {len(columns)} values, '' for none"
        raise ConfigError(place.wrong("results", row, wanted))
    quantity, unit, *values = row
    if not isinstance(unit, str) or unit not in FILE_UNITS:
        raise ConfigError(
            place.wrong("results", unit, f"unit must be one of {', '.join(FILE_UNITS)}")
        )
    numbers = tuple(
        None if value == "" else VALUE_FIELD.read(f"results, {quote(str(quantity))}", value, place)
        for value in values
    )
    return PublishedValue(str(quantity), unit, numbers)


def compare_trials(
    file: VesselFile, trials: tuple[Trial, ...], flown: FlightTable
) -> Iterator[TrialComparison]:
    """Yield the trials with our numbers; ConfigError if a quantity is none of the manoeuvre's."""
    for trial in trials:
        flight = flown[trial.task(file)]
        if isinstance(flight, str) or flight.lost:
            problem = flight if isinstance(flight, str) else flight.lost
            yield TrialComparison(trial, problem, (None,) * len(trial.results))
            continue
        ours = {one.name: one.value for one in trial.manoeuvre.measures(flight)}
        yield TrialComparison(trial, "", tuple(_ours(one, ours, flight) for one in trial.results))


def _ours(wanted: PublishedValue, ours: Mapping[str, float | None], flight: Flight) -> float | None:
    """Return our number in the published unit; ConfigError if there is no such quantity."""
    reading = TIMED_READING.fullmatch(wanted.quantity)
    if wanted.quantity in ours:
        value = ours[wanted.quantity]
    elif reading and flight.has(reading[1]):
        begin = flight.marks[0].t if flight.marks else 0.0
        value = flight.at(begin + float(reading[2]), reading[1])
    else:
        raise ConfigError(
            f"no measure {quote(wanted.quantity)}{nearest(wanted.quantity, ours)}; there are "
            f"{', '.join(ours)}, and any column as 'u after 40 s'"
        )
    return None if value is None else value / FILE_UNITS[wanted.unit]


def compare_waves(file: VesselFile, waves: Sequence[HeadWaves]) -> Iterator[WaveComparison]:
    """Yield published waves with our motion in them, by the full set."""
    for one in waves:
        boat = Boat(file, Method("full", "exact", "exact", "rk4", file.run.step_s))
        if not boat.trimmed(one.speed_m_s):
            yield WaveComparison(one, f"no straight level flight at {one.speed_m_s:g} m/s", ())
            continue
        known = zip(one.depth_m, one.heave, one.pitch_deg, strict=True)
        rows = tuple(
            WaveMotion(
                depth,
                (heave, pitch),
                _motion(boat, one, depth, one.speed_m_s),
                _motion(boat, one, depth, 0.0),
            )
            for depth, heave, pitch in known
        )
        yield WaveComparison(one, "", rows)


def _motion(boat: Boat, waves: HeadWaves, depth: float, speed: float) -> tuple[float, float]:
    """Return our heave [-] and pitch [deg]; the lift feels the water at ``speed`` [m/s]."""
    omega = 2.0 * math.pi / waves.period_s
    heave, pitch = head_wave_response(boat, head_waves(boat, omega, depth, speed), omega)
    return heave, math.degrees(0.5 * waves.height_m * pitch)

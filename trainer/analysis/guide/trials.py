"""The file of a boat's published figures.

It says what was measured, by whom, how it was read, and how surely.
The file of ``boat.toml`` is ``boat.trials.toml``; those of shipped boats are among ``trials``. A
figure is fitted, where a coefficient was chosen by it, or held out. The file has the digest of the
boat that this was said of, so that no coefficient changes without somebody saying it again.
"""

import hashlib
import json
import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Final

from trainer.analysis.guide.programme import Task
from trainer.analysis.guide.verdicts import unit_of
from trainer.analysis.manoeuvres.catalogue import MANOEUVRES, find_manoeuvre
from trainer.analysis.manoeuvres.flight import FIELD_CHOICES, Flight, Manoeuvre
from trainer.boat.assemble import Method
from trainer.config.boat.vessel import VesselFile
from trainer.config.files import (
    ConfigError,
    Position,
    as_table,
    collecting,
    lines_of,
    nearest,
    number_problems,
    parse_toml,
    quote,
    raise_problems,
    read_text,
    shipped_names,
    shipped_path,
)
from trainer.config.schema import (
    Choice,
    Quantities,
    Quantity,
    Text,
    Texts,
    above,
    optional,
    read_record,
    required,
    with_default,
    within,
)

FILE_UNITS: Final = {  # of the file, to SI and radians
    **dict.fromkeys(("m", "s", "m/s", "rad", "rad/s", "-"), 1.0),
    **dict.fromkeys(("deg", "deg/s"), math.radians(1.0)),
}
SI_UNITS: Final = {"deg": "rad", "deg/s": "rad/s"}  # of those that have another
# [-] of a computed figure that nobody has measured: the root of the mean square of how far RANS is
# from the free-running model in the 16 figures of BB2's 20/20 (configs/trials/bb2.toml)
COMPUTED_SHARE: Final = 0.13
DATA_KINDS: Final = {
    "sea": "measured on the vessel",
    "model": "measured on a free-running model",
    "computed": f"computed by others: u_D is at least how far that is from a measurement, or "
    f"{COMPUTED_SHARE:.0%} where there is none",
}
MEASURED_KINDS: Final = ("sea", "model")
FITTED, HELD_OUT = "fitted", "held out"
INPUT_FIELD: Final = Text(20, "coefficient, or mass, Ix, Iy, Iz, BG")
NOTE_FIELD: Final = Text(500, "what it is, and whose")
PARAMETER_FIELD: Final = Quantity("-", within(-1e6, 1e6), "of a manoeuvre, in the unit of its name")
UNCERTAINTY_FIELD: Final = Quantity("-", above(0, 1e9), "one standard deviation, in its unit")
# fmt: off
FLOWN_TABLES: Final = (  # what a flight of the full set rests on
    "fluid", "vessel", "propulsion", "control_surfaces", "coefficients", "envelope", "run",
)
# fmt: on
FIGURE_TABLES: Final = ("fits", "deviations", "trials", "waves")
MAX_INPUTS: Final = 131
STEP_SHARE: Final = 0.2  # of the boat's own: the step of Runge and Kutta
NUMBERED_MEASURE: Final = re.compile(  # of a swing, which a flight may lack
    r"(time of )?(heading|pitch) (peak|zero|overshoot) \d|time of peak \d, of the first's"
    r"|(amplitude after|kept over) cycle \d"
)
TIMED_READING: Final = re.compile(r"(\w+) after (\d+(?:\.\d*)?) s")
WAVE_KEYS: Final = ("heave", "pitch_deg")
TRIAL_LINE: Final = re.compile(r"\s*\[\[\s*trials\s*\]\]")
FIGURE_LINE: Final = re.compile(r"\s*\{")
RESULTS_LINE: Final = re.compile(r"\s*results\s*=")
USE_FIELD: Final = Choice((FITTED, HELD_OUT), "whether a coefficient was chosen by it")


@dataclass(frozen=True, kw_only=True)
class FigureRecord:
    """One published figure as the file has it, in the units of its source."""

    quantity: str = required(Text(79, "a measure of the manoeuvre, or a column as 'u after 40 s'"))
    unit: str = required(Choice(tuple(FILE_UNITS), "of value and u"))
    value: float = required("-", within(-1e9, 1e9), "as published, D")
    use: str = required(USE_FIELD)
    u: float | None = optional(UNCERTAINTY_FIELD)


@dataclass(frozen=True)
class Figure:
    """One published figure with its uncertainty, and its line of the file."""

    quantity: str
    unit: str
    value: float
    use: str
    u: float
    line: int


@dataclass(frozen=True, kw_only=True)
class TrialHeading:
    """Where the figures of one manoeuvre come from."""

    title: str = required(NOTE_FIELD)
    data: str = required(Choice(tuple(DATA_KINDS), "what was done"))
    source: str = required(NOTE_FIELD)
    figure: str = required(Text(200, "figure, table or page of the source"))
    read: str = required(NOTE_FIELD)
    note: str = with_default("", NOTE_FIELD)
    speed_m_s: float = required("m/s", within(0, 50), "at which it begins; 0: from rest")


@dataclass(frozen=True)
class Trial:
    """One manoeuvre as published."""

    heading: TrialHeading
    name: str  # of the manoeuvre
    manoeuvre: Manoeuvre
    results: tuple[Figure, ...]

    def task(self, file: VesselFile, coarser: float = 1.0) -> Task:
        """Return our flight of it, by a step so many times the usual one."""
        step = coarser * STEP_SHARE * file.run.step_s
        method = Method("full", "exact", "exact", "rk4", step)
        return Task(self.manoeuvre, self.heading.speed_m_s, method)

    def read_flight(self, published: "Published", flight: Flight | str) -> list[float | None]:
        """Return our figures in the published units; ConfigError if one is none of its measures."""
        if isinstance(flight, str) or flight.lost:
            return [None] * len(self.results)
        measures = {one.name: (one.value, one.unit) for one in self.manoeuvre.measures(flight)}
        return [_read_figure(published, each, measures, flight) for each in self.results]


def _by_depth(unit: str, meaning: str) -> Quantities:
    """Return numbers of waves, one for each depth."""
    return Quantities(Quantity(unit, within(0, 12000), meaning), 1, 20)


@dataclass(frozen=True, kw_only=True)
class WavesHeading(TrialHeading):
    """Motion in regular waves from ahead as published, planes fixed."""

    use: str = required(USE_FIELD)
    period_s: float = required("s", within(1, 60), "of the waves")
    height_m: float = required("m", within(0.01, 25), "of the waves")
    depth_m: tuple[float, ...] = required(_by_depth("m", "depths of the origin"))
    heave: tuple[float, ...] = required(_by_depth("-", "amplitude over the waves'"))
    u_heave: float = required(UNCERTAINTY_FIELD)
    pitch_deg: tuple[float, ...] = required(_by_depth("deg", "amplitude"))
    u_pitch_deg: float = required(UNCERTAINTY_FIELD)


@dataclass(frozen=True)
class HeadWaves:
    """Published motion in regular waves, heave and pitch by depth."""

    heading: WavesHeading
    results: tuple[Figure, ...]


@dataclass(frozen=True, kw_only=True)
class Provenance:
    """When the figures were called fitted or held out, and of which boat."""

    judged: str = required(Text(10, "day"))
    digest: str = required(Text(16, "of the vessel file's numbers on that day"))
    nothing_found: str = with_default("", NOTE_FIELD)


@dataclass(frozen=True, kw_only=True)
class GuideFit:
    """Coefficients, and the figures by which they were chosen."""

    coefficients: tuple[str, ...] = required(Texts(Text(20, "name"), MAX_INPUTS))
    to: str = required(NOTE_FIELD)


@dataclass(frozen=True, kw_only=True)
class Deviation:
    """The standard deviation of some coefficients or masses, which their source tells."""

    inputs: tuple[str, ...] = required(Texts(INPUT_FIELD, MAX_INPUTS))
    share: float | None = optional("-", above(0, 5), "of the value")
    size: float | None = optional("-", above(0, 1e9), "in the file's unit")
    reason: str = required(NOTE_FIELD)


@dataclass(frozen=True)
class Published:
    """A file of published figures."""

    path: Path
    text: str
    provenance: Provenance
    fits: tuple[GuideFit, ...]
    deviations: tuple[Deviation, ...]
    trials: tuple[Trial, ...]
    waves: tuple[HeadWaves, ...]

    @property
    def figures(self) -> tuple[tuple[str, Figure], ...]:
        """Return every figure with the title that it stands under."""
        every: tuple[Trial | HeadWaves, ...] = (*self.trials, *self.waves)
        return tuple((one.heading.title, figure) for one in every for figure in one.results)

    @property
    def file(self) -> str:
        """Return its name."""
        return self.path.name

    def wrong(self, figure: Figure, text: str) -> ConfigError:
        """Return the error that ``text`` is wrong with a figure."""
        name = f"{self.file}: line {figure.line}: "
        return ConfigError(f"{name}quantity = {quote(figure.quantity)}: {text}")


def trials_path(file: VesselFile) -> Path | None:
    """Return where the published results of a boat are, None if there are none."""
    beside = file.path.with_suffix(".trials.toml")
    if beside.is_file():
        return beside
    name = file.path.stem
    is_shipped = name in shipped_names("vessels") and shipped_path("vessels", name) == file.path
    return shipped_path("trials", name) if is_shipped and name in shipped_names("trials") else None


def numbers_digest(file: VesselFile) -> str:
    """Return the digest of a vessel file's numbers that its full set flies by."""
    return tables_digest(file.text, file.path.name, FLOWN_TABLES)


def figures_digest(published: Published) -> str:
    """Return the digest of what the uncertainty of our figures rests on, beside the boat."""
    return tables_digest(published.text, published.file, FIGURE_TABLES)


def tables_digest(text: str, file: str, names: tuple[str, ...]) -> str:
    """Return the digest of some tables of a file."""
    tables = parse_toml(text, file)
    chosen = {name: tables[name] for name in names if name in tables}
    return hashlib.sha256(json.dumps(chosen, sort_keys=True).encode()).hexdigest()[:16]


def load_published(path: Path) -> Published:
    """Return the figures of a file. ConfigError with all that is wrong in it, by line."""
    text = read_text(path)
    tables = parse_toml(text, path.name)
    lines, keys = _row_lines(text), lines_of(text)
    problems: list[str] = []
    position = Position(path.name, "")
    known = ("boat", *ROW_READERS)
    unknown = (name for name in tables if name not in known)
    problems += [
        position.problem(f"{name} = ...: no such table{nearest(name, known)}") for name in unknown
    ]

    def read_rows(name: str, read: RowReader) -> Iterator[Any]:
        rows = tables.get(name, [])
        if not isinstance(rows, list):
            problems.append(position.wrong(name, rows, f"must be tables [[{name}]]"))
            return
        for i, row in enumerate(rows):
            inside = position.inside(f"{name}[{i}]")
            own = [keys.get((inside.table, key), 0) for key in WAVE_KEYS]
            own = lines.get(i, []) if name == "trials" else own
            with collecting(problems):
                yield read(as_table(row, inside), inside, own)

    rows = [tuple(read_rows(name, read)) for name, read in ROW_READERS.items()]
    boat = as_table(tables.get("boat", {}), position.inside("boat"))
    if not (rows[2] or rows[3] or problems or boat.get("nothing_found")):
        problems.append(position.problem("has no [[trials]]: say nothing_found in [boat]"))
    with collecting(problems):
        provenance = read_record(Provenance, boat, position.inside("boat"), ())
    raise_problems(number_problems(problems, text, path.name))
    return _doubt_computed(Published(path, text, provenance, *rows))


def _doubt_computed(published: Published) -> Published:
    """Return figures, each computed one with the uncertainty that its computation has at least."""
    measured = {
        (*_flown(trial), one.quantity, one.unit): one.value
        for trial in published.trials
        if trial.heading.data in MEASURED_KINDS
        for one in trial.results
    }

    def doubted(compared: Any) -> Any:
        if compared.heading.data in MEASURED_KINDS:
            return compared
        figures = []
        for one in compared.results:
            nothing = (1.0 - COMPUTED_SHARE) * one.value
            apart = one.value - measured.get((*_flown(compared), one.quantity, one.unit), nothing)
            figures.append(replace(one, u=max(one.u, abs(apart))))
        return replace(compared, results=tuple(figures))

    trials, waves = map(doubted, published.trials), map(doubted, published.waves)
    return replace(published, trials=tuple(trials), waves=tuple(waves))


def _flown(compared: Trial | HeadWaves) -> tuple[float, Manoeuvre | None]:
    """Return by what a computed figure and a measured one are of the same."""
    return compared.heading.speed_m_s, getattr(compared, "manoeuvre", None)


def _row_lines(text: str) -> dict[int, list[int]]:
    """Return the lines, from 1, of the figures of each trial."""
    lines: dict[int, list[int]] = {}
    trial, inside = -1, False
    for number, line in enumerate(text.split("\n"), start=1):
        if TRIAL_LINE.match(line):
            trial, inside = trial + 1, False
        elif RESULTS_LINE.match(line):
            inside = True
        elif inside and FIGURE_LINE.match(line):
            lines.setdefault(trial, []).append(number)
    return lines


def _deviation(row: Mapping[str, Any], position: Position, _lines: list[int]) -> Deviation:
    """Return a standard deviation; ConfigError if it is wrong."""
    deviation = read_record(Deviation, row, position, ())
    if (deviation.share is None) == (deviation.size is None):
        raise ConfigError(position.problem("must have share or size, one of them"))
    return deviation


def _waves(row: Mapping[str, Any], position: Position, lines: list[int]) -> HeadWaves:
    """Return regular waves; ConfigError if they are wrong. ``lines`` are those of their keys."""
    waves = read_record(WavesHeading, row, position, ())
    pitch = ("deg", waves.pitch_deg, waves.u_pitch_deg)
    by_name = {"heave": ("-", waves.heave, waves.u_heave), "pitch_deg": pitch}
    figures = []
    for i, depth in enumerate(waves.depth_m):
        for (name, (unit, values, u)), line in zip(by_name.items(), lines, strict=True):
            if len(values) != len(waves.depth_m):
                wanted = f"must have {len(waves.depth_m)} numbers as depth_m has"
                raise ConfigError(position.wrong(name, list(values), wanted))
            quantity = f"{name.partition('_')[0]} at {depth:.4g} m"
            figures.append(Figure(quantity, unit, values[i], waves.use, u, line))
    return HeadWaves(waves, tuple(figures))


def _trial(row: Mapping[str, Any], position: Position, lines: list[int]) -> Trial:
    """Return one trial; ConfigError if it is wrong. ``lines`` are its figures'."""
    headed = {each.name for each in fields(TrialHeading)}
    own = {"manoeuvre", "results", "u_D"}
    problems: list[str] = []
    with collecting(problems):
        given = {key: value for key, value in row.items() if key in headed}
        heading = read_record(TrialHeading, given, position, ())
    with collecting(problems):
        manoeuvre = _manoeuvre(row, position, headed | own)
    by_unit = dict[str, float]()
    with collecting(problems):
        by_unit = _by_unit(row.get("u_D", {}), position)
    rows, figures = row.get("results"), list[Figure]()
    if not isinstance(rows, list) or not rows:
        problems.append(position.wrong("results", rows, "must be a list of figures"))
        rows = []
    for i, figure in enumerate(rows):
        line = lines[i] if i < len(lines) else 0
        with collecting(problems):
            figures.append(_figure(figure, by_unit, position, line))
    raise_problems(problems)
    return Trial(heading, row["manoeuvre"], manoeuvre, tuple(figures))


def _by_unit(table: object, position: Position) -> dict[str, float]:
    """Return the uncertainty of readings by their unit; ConfigError."""
    by_unit = {}
    for unit, value in as_table(table, position).items():
        if unit not in FILE_UNITS:
            raise ConfigError(
                position.wrong("u_D", unit, f"no such unit{nearest(unit, FILE_UNITS)}")
            )
        by_unit[unit] = UNCERTAINTY_FIELD.read("u_D", value, position)
    return by_unit


def _figure(row: object, by_unit: Mapping[str, float], position: Position, line: int) -> Figure:
    """Return one figure with its uncertainty; ConfigError with its line."""
    at = (
        Position(f"{position.file}: line {line}", f"{position.table}.results") if line else position
    )
    figure = read_record(FigureRecord, row, at, ())
    u = by_unit.get(figure.unit) if figure.u is None else figure.u
    if u is None:
        text = f"has no uncertainty: give it u [{figure.unit}], or the trial u_D of {figure.unit}"
        raise ConfigError(at.wrong("quantity", figure.quantity, text))
    return Figure(figure.quantity, figure.unit, figure.value, figure.use, u, line)


def _manoeuvre(row: Mapping[str, Any], position: Position, others: set[str]) -> Manoeuvre:
    """Return the manoeuvre that a trial names, with its parameters; ConfigError if it has none."""
    name = row.get("manoeuvre", "")
    if not isinstance(name, str) or name not in MANOEUVRES:
        advice = f"no such manoeuvre{nearest(str(name), MANOEUVRES)}"
        raise ConfigError(position.wrong("manoeuvre", name, advice))
    manoeuvre = find_manoeuvre(name)
    known = {field.name: getattr(manoeuvre, field.name) for field in fields(manoeuvre)}
    field_values = {}
    for key, value in row.items():
        if key in others:
            continue
        if key not in known:
            text = f"no such key{nearest(key, {*known, *others})}"
            raise ConfigError(position.wrong(key, value, text))
        read: Any = PARAMETER_FIELD.read
        if key in FIELD_CHOICES:
            read = Choice(FIELD_CHOICES[key], "as --side, or rise and dive").read
        elif isinstance(known[key], tuple):
            read = Texts(Text(20, "axis"), 9).read
        field_values[key] = read(key, value, position)
    return replace(manoeuvre, **field_values)


RowReader = Callable[[Mapping[str, Any], Position, list[int]], Any]
ROW_READERS: Final[Mapping[str, RowReader]] = {  # tables of the file, as Published has them
    "fits": lambda row, position, _lines: read_record(GuideFit, row, position, ()),
    "deviations": _deviation,
    "trials": _trial,
    "waves": _waves,
}


def _read_figure(
    published: Published,
    wanted: Figure,
    measures: Mapping[str, tuple[float | None, str]],
    flight: Flight,
) -> float | None:
    """Return our number in the published unit, None for none; ConfigError if it is wrong."""
    reading = TIMED_READING.fullmatch(wanted.quantity)
    if wanted.quantity in measures:
        value, unit = measures[wanted.quantity]
    elif reading and flight.has(reading[1]):
        begin = flight.marks[0].t if flight.marks else 0.0
        value, unit = flight.at(begin + float(reading[2]), reading[1]), unit_of(reading[1])
    elif NUMBERED_MEASURE.fullmatch(wanted.quantity):  # a swing that ours does not make
        return None
    else:
        raise published.wrong(
            wanted,
            f"no such measure{nearest(wanted.quantity, measures)}; there are "
            f"{', '.join(measures)}, and any column as 'u after 40 s'",
        )
    if SI_UNITS.get(wanted.unit, wanted.unit) != unit:
        raise published.wrong(wanted, f"unit = {quote(wanted.unit)} does not fit, it is in {unit}")
    return None if value is None else value / FILE_UNITS[wanted.unit]

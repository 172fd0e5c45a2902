"""Check cases: exact start, controls, surroundings, outputs at times, as TOML and CSV.

The form follows the check cases of NASA's NESC for flight (NASA/TM-2015-218675). Any program can
read the files: units are in the names, and nothing but the boat's own file is left to defaults.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, make_dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np

from trainer.config.boat.vessel import VesselFile, load_vessel
from trainer.config.exercise.exercise import ORDER_ROWS, read_orders, sea_given
from trainer.config.files import (
    ConfigError,
    Position,
    collecting,
    nearest,
    number_problems,
    parse_toml,
    quote,
    raise_problems,
    read_text,
    relative_name,
    shipped_names,
    shipped_path,
)
from trainer.config.schema import (
    Choice,
    LongText,
    Quantities,
    Quantity,
    Rows,
    Text,
    above,
    describe_kind,
    file_schema,
    optional,
    read_record,
    record_schema,
    required,
    with_default,
    within,
)
from trainer.config.tables import read_table
from trainer.config.words import EQUATION_SETS
from trainer.config.world.sea import SeaFile, load_sea
from trainer.config.world.world import WORLD_READERS, WORLD_SCHEMAS, WorldTables, read_world
from trainer.core.kernel import Numbers
from trainer.io.orders.schedule import ScheduledOrder

MAX_CASE_S: Final = 3600.0  # [s] of a case
TIME_TOLERANCE_S: Final = 1e-6  # [s] within which a row of a file is at a time of the case
MAX_RUNS: Final = 20  # of a case
TIME_COLUMN: Final = "t_s"
DEG_PER_RAD: Final = math.degrees(1.0)  # [deg/rad]


class Channel(NamedTuple):
    """A column of a check case's files."""

    state: str  # the offset in the core's state
    unit: str
    factor: float  # from SI to the unit
    limit: float  # of a start either way; 0: no start has it
    meaning: str


# fmt: off
CASE_CHANNELS: Final[Mapping[str, Channel]] = {
    "u_m_s": Channel("u", "m/s", 1.0, 40.0, "speed ahead through the water"),
    "v_m_s": Channel("v", "m/s", 1.0, 40.0, "speed to starboard through the water"),
    "w_m_s": Channel("w", "m/s", 1.0, 40.0, "speed towards the keel through the water"),
    "p_deg_s": Channel("p", "deg/s", DEG_PER_RAD, 360.0, "roll rate, starboard side down"),
    "q_deg_s": Channel("q", "deg/s", DEG_PER_RAD, 360.0, "pitch rate, bow up"),
    "r_deg_s": Channel("r", "deg/s", DEG_PER_RAD, 360.0, "yaw rate, bow to starboard"),
    "x_m": Channel("x", "m", 1.0, 1e6, "north of the start, over ground"),
    "y_m": Channel("y", "m", 1.0, 1e6, "east of the start, over ground"),
    "z_m": Channel("z", "m", 1.0, 12000.0, "depth of the body's origin"),
    "phi_deg": Channel("phi", "deg", DEG_PER_RAD, 180.0, "heel, the last of the three angles"),
    "theta_deg": Channel("theta", "deg", DEG_PER_RAD, 89.0, "pitch"),
    "psi_deg": Channel("psi", "deg", DEG_PER_RAD, 360.0, "heading"),
    "rudder_deg": Channel("delta_r", "deg", DEG_PER_RAD, 90.0, "rudder, signs of the coefficients"),
    "stern_deg": Channel("delta_s", "deg", DEG_PER_RAD, 90.0, "stern planes, likewise"),
    "bow_deg": Channel("delta_b", "deg", DEG_PER_RAD, 90.0, "bow planes, likewise"),
    "u_c_m_s": Channel("u_c", "m/s", 1.0, 40.0, "command speed, what the revolutions are for"),
    "weight_kN": Channel("weight", "kN", 1e-3, 0.0, "weight with the water in the tanks"),
    "x_g_m": Channel("x_g", "m", 1.0, 0.0, "centre of that weight, forward"),
    "y_g_m": Channel("y_g", "m", 1.0, 0.0, "centre of that weight, to starboard"),
    "z_g_m": Channel("z_g", "m", 1.0, 0.0, "centre of that weight, towards the keel"),
    "wave_m": Channel("eta_wave", "m", 1.0, 0.0, "elevation of the sea above the boat"),
}
# fmt: on
ANGLE_CHANNELS: Final = ("phi_deg", "theta_deg", "psi_deg")  # compared over whole turns


@dataclass(frozen=True, kw_only=True)
class CaseHeading:
    """The heading of a case: its boat, its equations and its times."""

    schema: str = required(Choice(("check-case/1",), "form of the file"))
    title: str = required(Text(79, "what is flown, one line"))
    mechanism: str = required(LongText(2000, "what the case checks, and what a program needs"))
    source: str | None = optional(LongText(1000, "where outputs of other programs come from"))
    vessel: str = required(Text(200, "name of a boat, or path of its file"))
    equations: str = required(Choice(EQUATION_SETS, "set of equations"))
    duration_s: float = required("s", above(0, MAX_CASE_S), "length")
    sample_s: float = required("s", within(0.01, 600), "time from output to output")
    seed: float = with_default(1.0, "-", within(0, 1e15), "of everything random; else 1")


@dataclass(frozen=True, kw_only=True)
class CaseRun:
    """Outputs of a case: flown by this trainer, or read from a file alone."""

    name: str = required(Text(40, "as tables and plots have it"))
    integrator: str | None = optional(Text(200, "as --integrator; without it nothing is flown"))
    rates: str | None = optional(
        Choice(("exact", "lagged"), "how accelerations are found; else exact")
    )
    step_s: float | None = optional("s", within(0.001, 2), "time step")
    file: str | None = optional(Text(200, "CSV file of the outputs, beside the case"))
    beside: str | None = optional(Text(40, "the run above that it is laid beside; else the first"))
    spread: tuple[float, ...] | None = optional(
        Quantities(
            Quantity("-", above(0, 1e6), "another spread than the case's, in its order"),
            1,
            len(CASE_CHANNELS),
        )
    )


CaseStart: Final[type[Any]] = make_dataclass(
    "CaseStart",
    [
        (
            name,
            float,
            with_default(
                0.0, channel.unit, within(-channel.limit, channel.limit), f"{channel.meaning}"
            ),
        )
        for name, channel in CASE_CHANNELS.items()
        if channel.limit
    ],
    frozen=True,
    kw_only=True,
)
CaseSpread: Final[type[Any]] = make_dataclass(
    "CaseSpread",
    [
        (name, float | None, optional(channel.unit, above(0, 1e6), channel.meaning))
        for name, channel in CASE_CHANNELS.items()
    ],
    frozen=True,
    kw_only=True,
)
RUN_ROWS: Final = Rows(CaseRun, ("note",), 1, MAX_RUNS, "who flies it, and how")
OTHER_TABLES: Final = ("start", "spread", "runs", "orders", "sea", *WORLD_READERS)


@dataclass(frozen=True, kw_only=True)
class CheckCase:
    """Everything that the file of a check case says."""

    path: Path
    heading: CaseHeading
    boat: VesselFile
    start: Mapping[str, float]  # by channel, in its unit
    spread: Mapping[str, float]  # likewise: how far two sound computations may be apart
    runs: tuple[CaseRun, ...]
    orders: tuple[ScheduledOrder, ...]
    sea: SeaFile
    world: WorldTables

    @property
    def name(self) -> str:
        """Return the name of the case, that of its file."""
        return self.path.stem

    @property
    def times(self) -> Numbers:
        """Return the times [s] of its outputs."""
        count = round(self.heading.duration_s / self.heading.sample_s)
        return np.asarray(np.arange(count + 1) * self.heading.sample_s, np.float64)

    def problem(self, text: str) -> ConfigError:
        """Return an error about the case's file, with its line where that can be told."""
        problem = Position(self.path.name, "").problem(text)
        return ConfigError(*number_problems([problem], read_text(self.path), self.path.name))


def case_schema() -> dict[str, Any]:
    """Return the JSON Schema of a check case."""
    heading = record_schema(CaseHeading, ("note",))
    keys = {
        **heading["properties"],
        "start": record_schema(CaseStart, ("note",)),
        "spread": record_schema(CaseSpread, ("note",)),
        "runs": describe_kind(RUN_ROWS),
        "orders": describe_kind(ORDER_ROWS),
        "sea": {"type": "string"},
        **{name: schema() for name, schema in WORLD_SCHEMAS.items()},
    }
    return file_schema("case", keys, (*heading["required"], "start", "spread", "runs"))


def case_paths(folder: Path | None) -> list[Path]:
    """Return the cases' files in a folder, else those shipped; ConfigError if none is."""
    if folder is None:
        return [shipped_path("check-cases", name) for name in shipped_names("check-cases")]
    paths = sorted(path for path in folder.glob("*.toml") if "." not in path.stem)
    if not paths:
        lacking = "has no check case NAME.toml" if folder.is_dir() else "there is no such folder"
        raise ConfigError(f"{folder}: {lacking}")
    return paths


def load_case(path: Path) -> CheckCase:
    """Return the check case in a file; ConfigError naming the line of what is wrong."""
    return parse_case(read_text(path), path)


def parse_case(text: str, path: Path) -> CheckCase:
    """Return the check case in ``text``, which came from ``path``; ConfigError as above."""
    table = parse_toml(text, path.name)
    try:
        return _read_case(table, path)
    except ConfigError as wrong:
        raise ConfigError(*number_problems(wrong.problems, text, path.name)) from None


def _read_case(table: Mapping[str, Any], path: Path) -> CheckCase:
    """Return the case of parsed tables; ConfigError with all that is wrong."""
    position = Position(path.name, "")
    problems: list[str] = []
    parts: dict[str, Any] = {}
    with collecting(problems):
        own = {key: value for key, value in table.items() if key not in OTHER_TABLES}
        parts["heading"] = read_record(CaseHeading, own, position, ("note",))
    with collecting(problems):
        start = read_record(CaseStart, table.get("start", {}), position.inside("start"), ("note",))
        parts["start"] = {item.name: getattr(start, item.name) for item in fields(CaseStart)}
    with collecting(problems):
        spread = read_record(
            CaseSpread, table.get("spread", {}), position.inside("spread"), ("note",)
        )
        values = {name: getattr(spread, name) for name in CASE_CHANNELS}
        parts["spread"] = {name: value for name, value in values.items() if value is not None}
        if not parts["spread"]:
            raise ConfigError(position.problem("[spread] names no channel: nothing is compared"))
    with collecting(problems):
        parts["runs"] = RUN_ROWS.read("runs", table.get("runs", []), position)
    with collecting(problems):
        parts["orders"] = tuple(read_orders(table, position))
    with collecting(problems):
        parts["sea"] = sea_given(table["sea"], path) if "sea" in table else load_sea("calm")
    with collecting(problems):
        parts["world"] = read_world(table, path)
    raise_problems(problems)
    parts["boat"] = load_vessel(relative_name(path, parts["heading"].vessel))
    case = CheckCase(path=path, **parts)
    raise_problems([*_start_problems(case, position), *_run_problems(case, position)])
    return case


def _start_problems(case: CheckCase, position: Position) -> list[str]:
    """Return what the boat of the case cannot start with."""
    surfaces = case.boat.surfaces
    limits = {
        "rudder_deg": surfaces.rudder_limit_deg,
        "stern_deg": surfaces.stern_plane_limit_deg,
        "bow_deg": surfaces.bow_plane_limit_deg,
    }
    inside = position.inside("start")
    return [
        inside.wrong(name, case.start[name], f"beyond the boat's limit, {limit:g} deg")
        for name, limit in limits.items()
        if abs(case.start[name]) > limit
    ]


def _run_problems(case: CheckCase, position: Position) -> list[str]:
    """Return what does not fit together among the runs and the times of a case."""
    problems = []
    heading, names = case.heading, [run.name for run in case.runs]
    if not is_multiple(heading.duration_s, heading.sample_s):
        text = f"must be a multiple of sample_s, {heading.sample_s:g} s"
        problems.append(position.wrong("duration_s", heading.duration_s, text))
    if case.runs[0].integrator is None:
        problems.append(
            position.inside("runs[0]").problem("the first run is flown: give integrator")
        )
    for i, run in enumerate(case.runs):
        inside = position.inside(f"runs[{i}]")
        if (run.integrator is None) != (run.step_s is None):
            problems.append(inside.problem("integrator and step_s go together"))
        if run.integrator is None and run.file is None:
            problems.append(inside.problem("give integrator and step_s, or a file"))
        if run.step_s is not None and not is_multiple(heading.sample_s, run.step_s):
            text = f"sample_s, {heading.sample_s:g} s, must be a multiple of it"
            problems.append(inside.wrong("step_s", run.step_s, text))
        if run.name in names[:i]:
            problems.append(inside.wrong("name", run.name, "is given twice"))
        if run.beside is not None and run.beside not in names[:i]:
            text = f"no run above has that name{nearest(run.beside, names[:i])}"
            problems.append(inside.wrong("beside", run.beside, text))
        if run.spread is not None and len(run.spread) != len(case.spread):
            text = f"must be {len(case.spread)} numbers: {', '.join(case.spread)}"
            problems.append(inside.wrong("spread", [*run.spread], text))
    return problems


def is_multiple(whole: float, part: float) -> bool:
    """Return whether a time [s] is a whole number of times another."""
    count = round(whole / part)
    return count >= 1 and abs(whole - count * part) <= 1e-9 * whole


def read_outputs(path: Path, times: Numbers, channels: Sequence[str]) -> dict[str, Numbers]:
    """Return the channels that a CSV file has, at the times [s] of a case.

    Rows between those times are passed over. ConfigError naming line and column of what is wrong.
    """
    table = read_table(path)
    unknown = [name for name in table.names if name not in (TIME_COLUMN, *CASE_CHANNELS)]
    if unknown:
        text = f"no channel {quote(unknown[0])}{nearest(unknown[0], (TIME_COLUMN, *CASE_CHANNELS))}"
        raise ConfigError(f"{path}: line 1: {text}")
    known = [name for name in channels if table.has(name)]
    if not known:
        raise ConfigError(f"{path}: line 1: has none of the case's channels {', '.join(channels)}")
    t = table.known(table.index(TIME_COLUMN))
    if (falls := np.flatnonzero(np.diff(t) <= 0.0)).size:
        raise table.wrong(int(falls[0]) + 1, table.index(TIME_COLUMN), "times must rise")
    if not t.size:
        raise ConfigError(f"{path}: line 2: there are no outputs")
    after = np.clip(np.searchsorted(t, times), 1, max(t.size - 1, 1))
    before = after - 1
    after = np.minimum(after, t.size - 1)
    rows = np.where(np.abs(t[after] - times) < np.abs(t[before] - times), after, before)
    if (lacking := np.abs(t[rows] - times) > TIME_TOLERANCE_S).any():
        first = float(times[np.argmax(lacking)])
        line = table.lines[int(rows[np.argmax(lacking)])]
        raise ConfigError(
            f"{path}: no output at {TIME_COLUMN} = {first:g}; the nearest is row {line}"
        )
    return {name: table.known(table.index(name))[rows] for name in known}

"""A study from its file: the common part, the differences, the outputs.

The key of a varied number is a path: words with dots between, ``vessel.fluid.rho``, and indices in
lists in brackets, ``exercise.orders[2].at_s``. All of the vessel's coefficients can be named, also
those that its file leaves out, and the compensation's factors of all terms that the compact set
keeps.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Any, Final

from trainer.analysis.estimate.uncertainty import (
    drawn_fit,
    drawn_tables,
    filed_estimate,
    filed_fit,
    filed_joint,
)
from trainer.analysis.sweep.draws import GRID_SAMPLE, Draws
from trainer.analysis.sweep.records import (
    ESTIMATE_DISTRIBUTION,
    MAX_MEMBERS,
    PARAMETER_ROWS,
    VARY_ROWS,
    IdentificationTable,
    ManoeuvreTable,
    MethodTable,
    Sample,
    SweepHeading,
    VaryRow,
)
from trainer.analysis.sweep.sobol import MIN_BASE_POINTS, SET_COUNT, SOBOL_SAMPLE
from trainer.boat.assemble import Method
from trainer.config.boat.coefficients import EQUATION_SETS
from trainer.config.boat.vessel import VesselFile, load_vessel, with_defaults
from trainer.config.exercise.file_schemas import exercise_keys
from trainer.config.extras import require_library
from trainer.config.files import (
    ConfigError,
    Position,
    as_table,
    collecting,
    is_path,
    nearest,
    parse_toml,
    path_named,
    quote,
    raise_problems,
    read_text,
    relative_name,
)
from trainer.config.schema import (
    describe_kind,
    file_schema,
    object_schema,
    read_record,
    record_schema,
)
from trainer.config.words import SHIP_FILE_SCHEMA
from trainer.core.scheme import RUNGE_KUTTAS
from trainer.core.terms import COEFFICIENTS

TableMap = Mapping[str, Any]
PathStep = str | int

KEY_WORD: Final = re.compile(r"([A-Za-z0-9_-]+)((?:\[\d{1,4}\])*)")
BLANK_MARK: Final = "{}"  # in a text: where the number goes
TEXT_DECIMALS: Final = 9  # of a number in a text
MANOEUVRE_STUDY, EXERCISE_STUDY, IDENTIFICATION_STUDY = "manoeuvre", "exercise", "identification"
STUDY_KINDS: Final = (MANOEUVRE_STUDY, EXERCISE_STUDY, IDENTIFICATION_STUDY)
STUDY_TABLES: Final = ("method", *STUDY_KINDS, "parameters", "sample", "vary")
KNOWN_KEYS: Final = (*(item.name for item in fields(SweepHeading)), "note", *STUDY_TABLES)
VARIED_TABLES: Final = {  # the tables whose numbers may be varied, by what every member is
    MANOEUVRE_STUDY: ("vessel", "manoeuvre"),
    EXERCISE_STUDY: ("vessel", "exercise"),
    IDENTIFICATION_STUDY: ("identification", "parameters"),
}
DISTRIBUTION_KEYS: Final[Mapping[str | None, tuple[str, ...]]] = {  # keys of [[vary]] that say how
    None: ("values",),
    "uniform": ("low", "high"),
    "normal": ("mean", "std"),
    "triangular": ("low", "mode", "high"),
    ESTIMATE_DISTRIBUTION: (),
}
WHOLE_VESSEL: Final = "vessel"  # the key of draws of an estimate

DrawTables = Callable[[TableMap, int], TableMap]  # puts that draw into a vessel's tables


def steps_of(key: str) -> tuple[PathStep, ...]:
    """Return the words and indices of a key; ConfigError if it is none."""
    steps: list[PathStep] = []
    for part in key.split("."):
        match = KEY_WORD.fullmatch(part)
        if match is None:
            raise ConfigError(f"{part!r} is no word of a key")
        steps.append(match[1])
        steps += [int(index) for index in re.findall(r"\d+", match[2])]
    return tuple(steps)


def value_at(tables: Any, steps: tuple[PathStep, ...]) -> Any:
    """Return the value at a path, None without one; ConfigError naming the nearest table."""
    here = tables
    for depth, step in enumerate(steps):
        last = depth == len(steps) - 1
        if isinstance(here, Mapping) and isinstance(step, str):
            if step not in here and not last:
                raise ConfigError(f"there is no table {step!r}{nearest(step, here)}")
            here = here.get(step)
        elif isinstance(here, list) and isinstance(step, int) and step < len(here):
            here = here[step]
        else:
            kind = "it is a table" if isinstance(here, Mapping) else "it is no table and no list"
            if isinstance(here, list):
                kind = f"it is a list of {len(here)}, counted from 0"
            raise ConfigError(f"{step!r} has no place there: {kind}")
    return here


def change_value(tables: Any, steps: tuple[PathStep, ...], value: Any) -> Any:
    """Return tables with another value at a path, or in a text's blank.

    The tables given do not change.
    """
    if not steps:
        if not isinstance(tables, str) or BLANK_MARK not in tables:
            return value
        if not isinstance(value, str):
            value = f"{value:.{TEXT_DECIMALS}f}".rstrip("0").rstrip(".")
        return tables.replace(BLANK_MARK, value)
    step, rest = steps[0], steps[1:]
    if isinstance(step, int):
        return [*tables[:step], change_value(tables[step], rest, value), *tables[step + 1 :]]
    return {**tables, step: change_value(tables.get(step), rest, value)}


@dataclass(frozen=True)
class Variable:
    """One varied number: its path, and the value that the files have there."""

    row: VaryRow
    steps: tuple[PathStep, ...]
    base: float | None  # what its factors are of; None: it takes the place
    draw: DrawTables | None = None  # where the value is the number of a draw

    def value(self, drawn: Any) -> Any:
        """Return the value to put at the path."""
        return drawn if self.base is None else self.base * drawn


@dataclass(frozen=True, kw_only=True)
class Study:
    """The content of a study's file, read and checked."""

    path: Path
    heading: SweepHeading
    kind: str
    method: MethodTable
    file: VesselFile | None  # of the boat; None of a ship
    tables: TableMap  # that may be varied, as the files have them
    variables: tuple[Variable, ...]
    draws: Draws

    def varied(self, drawn: Mapping[str, Any]) -> Any:
        """Return the tables with the numbers of one member in them."""
        tables: Any = self.tables
        for variable in sorted(self.variables, key=lambda each: each.draw is None):
            if variable.draw is not None:
                number = int(drawn[variable.row.name])
                tables = {**tables, WHOLE_VESSEL: variable.draw(tables[WHOLE_VESSEL], number)}
                continue
            tables = change_value(tables, variable.steps, variable.value(drawn[variable.row.name]))
        return tables


def load_study(name_or_path: str) -> Study:
    """Return the shipped study of that name or the one in that file. ConfigError if it is wrong.

    Whatever has a path separator or ends in .toml is a path.
    """
    path = path_named(name_or_path, "studies")
    return parse_study(read_text(path), path)


def parse_study(text: str, path: Path) -> Study:
    """Return the study in ``text``, which came from ``path``; ConfigError with all faults."""
    position = Position(path.name, "")
    table = parse_toml(text, path.name)
    problems = [
        position.wrong(key, value, f"no such key{nearest(key, KNOWN_KEYS)}")
        for key, value in table.items()
        if key not in KNOWN_KEYS
    ]
    parts: dict[str, Any] = {}
    own = {key: table[key] for key in KNOWN_KEYS if key in table and key not in STUDY_TABLES}
    with collecting(problems):
        parts["heading"] = read_record(SweepHeading, own, position, ("note",))
    with collecting(problems):
        parts["kind"] = _kind(table, position)
    for name, record in (("method", MethodTable), ("sample", Sample)):
        with collecting(problems):
            parts[name] = read_record(record, table.get(name, {}), position.inside(name), ("note",))
    with collecting(problems):
        parts["rows"] = VARY_ROWS.read("vary", table.get("vary", []), position)
    raise_problems(problems)
    with collecting(problems):
        _check_rows(parts["rows"], parts["sample"], position)
    with collecting(problems):
        parts["file"], parts["tables"] = _subject(parts["kind"], parts["heading"], table, path)
    raise_problems(problems)
    variables = []
    for i, row in enumerate(parts["rows"]):
        with collecting(problems):
            variables.append(_variable(row, parts, position.inside(f"vary[{i}]")))
    raise_problems(problems)
    draws = Draws(parts.pop("sample"), parts.pop("rows"))
    return Study(path=path, variables=tuple(variables), draws=draws, **parts)


def _kind(table: Mapping[str, Any], position: Position) -> str:
    """Return what every member is; ConfigError if the file does not say one."""
    kinds = [kind for kind in STUDY_KINDS if kind in table]
    if len(kinds) != 1:
        have = f"has {' and '.join(kinds)}" if kinds else "has none of them"
        raise ConfigError(position.problem(f"{have}: give one of {', '.join(STUDY_KINDS)}"))
    if kinds[0] != IDENTIFICATION_STUDY and "parameters" in table:
        raise ConfigError(position.inside("parameters").problem("goes with [identification]"))
    if kinds[0] == IDENTIFICATION_STUDY and "method" in table:
        raise ConfigError(position.inside("method").problem("goes with a boat, not with a model"))
    return kinds[0]


def _check_rows(rows: tuple[VaryRow, ...], sample: Sample, position: Position) -> None:
    """Check plan, names and numbers of what is varied; ConfigError with all faults."""
    problems: list[str] = []
    inside = position.inside("sample")
    if sample.plan == GRID_SAMPLE and sample.members is not None:
        problems.append(inside.wrong("members", sample.members, "a grid has all its points"))
    if sample.plan == GRID_SAMPLE and not rows:
        problems.append(position.problem("lacks [[vary]]: a grid is of values"))
    if sample.plan == SOBOL_SAMPLE:
        problems += _sobol_problems(rows, sample, position)
    if sample.plan != GRID_SAMPLE and sample.members is None:
        problems.append(inside.problem("lacks members"))
    names = [row.name for row in rows]
    for i, row in enumerate(rows):
        problems += _row_problems(row, sample, position.inside(f"vary[{i}]"))
        if row.name in names[:i]:
            problems.append(position.inside(f"vary[{i}]").wrong("name", row.name, "is given twice"))
    raise_problems(problems)


def _sobol_problems(rows: tuple[VaryRow, ...], sample: Sample, position: Position) -> list[str]:
    """Return why a plan gives no indices: nothing varies, or the number of members is none."""
    require_library("scipy", "the plan sobol")
    if not rows:
        return [position.problem("lacks [[vary]]: sobol tells variables apart")]
    if sample.members is None or sample.members == _whole_members(len(rows), sample.members):
        return []
    reason = _describe_members(len(rows), sample.members)
    return [position.inside("sample").wrong("members", sample.members, reason)]


def _whole_members(variables: int, members: int) -> int:
    """Return the largest number of members up to ``members`` that fills all sets of points."""
    sets = variables + SET_COUNT
    points = max(members / sets, MIN_BASE_POINTS)
    return int(sets * 2 ** math.floor(math.log2(points)))


def _describe_members(variables: int, members: int) -> str:
    """Describe the numbers of members near ``members`` that fill all sets of points."""
    low = _whole_members(variables, members)
    near = f"{low} or {2 * low}" if 2 * low <= MAX_MEMBERS else f"{low}"
    sets = variables + SET_COUNT
    return f"sobol of {variables} variables has {sets} times a power of two: {near}"


def _row_problems(row: VaryRow, sample: Sample, position: Position) -> list[str]:
    """Return what is wrong with the numbers of one variable."""
    if (row.values is None) == (row.distribution is None):
        return [position.problem("give one of values, distribution")]
    if sample.plan == GRID_SAMPLE and row.values is None:
        return [position.wrong("distribution", row.distribution, "a grid wants values")]
    wanted = DISTRIBUTION_KEYS[row.distribution]
    given_names = [name for name, value in asdict(row).items() if value is not None]
    numbers = {name for names in DISTRIBUTION_KEYS.values() for name in names}
    extra = [name for name in given_names if name in numbers and name not in wanted]
    lacking = [name for name in wanted if name not in given_names]
    what = row.distribution or "values"
    if lacking or extra:
        have = [f"lacks {', '.join(lacking)}"] * bool(lacking)
        have += [f"has {', '.join(extra)} besides"] * bool(extra)
        return [position.problem(f"{what} {' and '.join(have)}")]
    ends = [getattr(row, name) for name in ("low", "mode", "high") if name in wanted]
    if ends != sorted(ends) or (ends and ends[0] == ends[-1]):
        return [position.problem(f"{', '.join(wanted)} must rise")]
    if row.relative and row.values and isinstance(row.values[0], str):
        return [position.wrong("relative", row.relative, "words are no factors")]
    return []


def _subject(
    kind: str, heading: SweepHeading, table: Mapping[str, Any], path: Path
) -> tuple[VesselFile | None, dict[str, Any]]:
    """Return the boat, if there is one, and the tables that may be varied."""
    position = Position(path.name, "")
    if kind == IDENTIFICATION_STUDY:
        if heading.vessel is not None:
            raise ConfigError(position.wrong("vessel", heading.vessel, "goes with a boat"))
        read_record(IdentificationTable, table[kind], position.inside(kind), ("note",))
        PARAMETER_ROWS.read("parameters", table.get("parameters", []), position)
        return None, {name: table[name] for name in VARIED_TABLES[kind]}
    subject_table = dict(as_table(table[kind], position.inside(kind)))
    name = heading.vessel
    if kind == MANOEUVRE_STUDY:
        read_record(ManoeuvreTable, subject_table, position.inside(kind), ("note",))
        subject_table.pop("note", None)
        vessel_path = relative_name(path, name or "bb2")
        if is_path(vessel_path):  # of a ship that was identified, or of a boat
            ship = parse_toml(read_text(Path(vessel_path)), Path(vessel_path).name)
            if ship.get("schema") == SHIP_FILE_SCHEMA:
                return None, {WHOLE_VESSEL: ship, kind: subject_table}
    else:
        subject_table = _exercise(subject_table, heading, path)
        name = name or subject_table.get("vessel")
    file = load_vessel(relative_name(path, name or "bb2"))
    tables, _ = with_defaults(parse_toml(file.text, file.path.name))
    extra = file.compact.extra_terms
    ones = {term.key: 1.0 for term in COEFFICIENTS if term.kept or term.key in extra}
    factors = {name: ones | dict(file.compensation[name]) for name in EQUATION_SETS}
    boat = {**tables, "coefficients": dict(file.coefficients), "compensation": factors}
    return file, {WHOLE_VESSEL: boat, kind: subject_table}


def _exercise(own: dict[str, Any], heading: SweepHeading, path: Path) -> dict[str, Any]:
    """Return the tables of an exercise: of the file it names, over them the study's own."""
    position = Position(path.name, EXERCISE_STUDY)
    base: dict[str, Any] = {"schema": "exercise/1", "name": heading.name[:55], "briefing": "-"}
    named = own.pop("file", None)
    if named is not None:
        if not isinstance(named, str):
            raise ConfigError(
                position.wrong("file", named, "must be a name, or the path of a file")
            )
        source = path_named(relative_name(path, named), "exercises")
        base = parse_toml(read_text(source), source.name)
    return {**base, **own}


def _variable(row: VaryRow, parts: Mapping[str, Any], position: Position) -> Variable:
    """Return draws of a whole boat or ship, or one number; ConfigError if it cannot vary."""
    tables, file = parts["tables"], parts["file"]
    if row.distribution == ESTIMATE_DISTRIBUTION:
        if WHOLE_VESSEL not in tables or row.key != WHOLE_VESSEL:
            problem = f"must be {WHOLE_VESSEL}: an estimate is drawn whole, of a boat or a ship"
            raise ConfigError(position.wrong("key", row.key, problem))
        if row.relative:
            raise ConfigError(position.wrong("relative", row.relative, "an estimate has no factor"))
        whole = tables[WHOLE_VESSEL]
        draw: DrawTables
        if file is None:
            draw = filed_joint(whole, position).drawn_tables
        elif "covariance" in whole:  # fitted to its trials, which tell more than its hull
            draw = partial(drawn_fit, filed_fit(file, whole))
        else:
            draw = partial(drawn_tables, filed_estimate(file, whole))
        return Variable(row, (WHOLE_VESSEL,), None, draw)
    try:
        steps = steps_of(row.key)
        here = value_at({root: tables[root] for root in VARIED_TABLES[parts["kind"]]}, steps)
    except ConfigError as wrong:
        raise ConfigError(position.wrong("key", row.key, str(wrong))) from None
    if not row.relative:
        if isinstance(here, str) and BLANK_MARK not in here and not isinstance(row.values, tuple):
            problem = f"is {quote(here)}, without a {BLANK_MARK}"
            raise ConfigError(position.wrong("key", row.key, problem))
        return Variable(row, steps, None)
    if isinstance(here, bool) or not isinstance(here, int | float) or here == 0.0:
        raise ConfigError(position.problem(f"relative: {row.key} is {quote(here)}: no factor"))
    return Variable(row, steps, float(here))


def method_of(table: MethodTable, file: VesselFile) -> Method:
    """Return how a boat is computed."""
    integrator = table.integrator or "adams2"
    return Method(
        table.equations or file.own_equations,
        table.rates or ("exact" if integrator in RUNGE_KUTTAS else "lagged"),
        table.trig or "exact",
        integrator,
        table.step_s or file.run.step_s,
    )


def with_members(study: Study, members: int) -> Study:
    """Return the study with another number of members; ConfigError of a grid."""
    sample = study.draws.sample
    if sample.plan == GRID_SAMPLE:
        raise ConfigError("--members: a grid has all its points")
    varied = len(study.draws.rows)
    if sample.plan == SOBOL_SAMPLE and members != _whole_members(varied, members):
        raise ConfigError(f"--members {members}: {_describe_members(varied, members)}")
    return replace(study, draws=replace(study.draws, sample=replace(sample, members=members)))


def study_schema() -> dict[str, Any]:
    """Return the JSON Schema of a study. Every member is of one of three kinds."""
    named = {"file": {"type": "string", "description": "name or path of the exercise"}}
    heading = record_schema(SweepHeading, ("note",))
    keys = {
        **heading["properties"],
        "method": record_schema(MethodTable, ("note",)),
        MANOEUVRE_STUDY: record_schema(ManoeuvreTable, ("note",)),
        EXERCISE_STUDY: object_schema({**exercise_keys(), **named}, ()),
        IDENTIFICATION_STUDY: record_schema(IdentificationTable, ("note",)),
        "parameters": describe_kind(PARAMETER_ROWS),
        "sample": record_schema(Sample, ("note",)),
        "vary": describe_kind(VARY_ROWS),
    }
    one = {"oneOf": [{"required": [kind]} for kind in STUDY_KINDS]}
    return {**file_schema("study", keys, (*heading["required"], "sample")), **one}

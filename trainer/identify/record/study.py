"""An identification study from its file: record, ship, model and parameters, checked at load.

``load_study`` reads the file, ``observe_record`` the record that it names: signs and units as the
models have them, thinned, cut to the times asked for, and examined. ``study_records`` has the keys.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from trainer.config.files import ConfigError, Position, collecting, nearest, parse_toml, read_text
from trainer.config.schema import (
    describe_kind,
    file_schema,
    kind_of,
    read_record,
    record_schema,
)
from trainer.config.ship.sensors import Sensors
from trainer.identify.model.own_systems import System
from trainer.identify.record.contradictions import check_evidence, in_study
from trainer.identify.record.evidence import Course
from trainer.identify.record.findings import (
    PATH_TEXTS,
    choose_path,
    examine_columns,
    examine_record,
    unwrap_heading,
)
from trainer.identify.record.measurements import Finding, Record
from trainer.identify.record.readings import fill_inputs
from trainer.identify.record.sources import (
    USUAL_SENSORS,
    Column,
    NoColumnError,
    factor,
    load_record,
    own_columns,
    read_by,
)
from trainer.identify.record.study_records import (
    COLUMN_ROWS,
    PARAMETER_ROWS,
    RUN_ROWS,
    ArmaxTable,
    ColumnRow,
    ModelTable,
    ParameterRow,
    RunRow,
    Ship,
    StudyHeading,
    Track,
)
from trainer.identify.record.track import Drift, no_sway, with_sway
from trainer.io.paths import RECORDING_SUFFIX
from trainer.units import KNOT

OPTIONAL_TABLES: Final = {
    "ship": Ship,
    "sensors": Sensors,
    "track": Track,
    "model": ModelTable,
    "armax": ArmaxTable,
}
STUDY_TABLES: Final = ("columns", "runs", "parameters", *OPTIONAL_TABLES)
KNOWN_KEYS: Final = (*(item.name for item in fields(StudyHeading)), "note", *STUDY_TABLES)


@dataclass(frozen=True, kw_only=True)
class Study:
    """Everything a study says; a table that it lacks is None."""

    path: Path
    heading: StudyHeading
    columns: Mapping[str, Column]
    ship: Ship | None
    sensors: Sensors | None
    track: Track | None
    model: ModelTable | None
    parameters: tuple[ParameterRow, ...]
    armax: ArmaxTable | None
    runs: tuple[RunRow, ...] = ()
    system: System | None = None  # of the user's own

    @property
    def channels(self) -> tuple[str, ...]:
        """Return what is recorded, and the sway of a track."""
        return (*self.columns, "sway") if "latitude" in self.columns else tuple(self.columns)

    @property
    def data(self) -> Path:
        """Return the path of the record."""
        return self.path.parent / self.heading.data


def load_study(path: Path) -> Study:
    """Return the study in a TOML file; ConfigError with all that is wrong."""
    return parse_study(read_text(path), path)


def plain_study(data: Path) -> Study:
    """Return the study of a record of the trainer's own, whose columns are known.

    A recording has the exact state of the boat, so instruments with usual errors read it.
    """
    heading = StudyHeading(schema="identify/1", name=data.stem, data=data.name)
    return Study(
        path=data,
        heading=heading,
        columns=own_columns(),
        ship=None,
        sensors=USUAL_SENSORS if data.suffix == RECORDING_SUFFIX else None,
        track=None,
        model=None,
        parameters=(),
        armax=None,
    )


def parse_study(text: str, path: Path) -> Study:
    """Return the study in ``text``, which came from ``path``; ConfigError with all faults."""
    position = Position(path.name, "")
    table = parse_toml(text, path.name)
    parts, problems = read_parts(table, position, (StudyHeading, KNOWN_KEYS), OPTIONAL_TABLES)
    model = table.get("model")
    # a user's own system names its own columns, and needs no rudder
    own_kind = isinstance(model, Mapping) and model.get("kind") == "own"
    with collecting(problems):
        rows = COLUMN_ROWS.read("columns", table.get("columns", []), position)
        parts["columns"] = _columns(rows, position, steered=not own_kind)
    with collecting(problems):
        parts["runs"] = RUN_ROWS.read("runs", table.get("runs", []), position)
    with collecting(problems):
        parts["parameters"] = PARAMETER_ROWS.read(
            "parameters", table.get("parameters", []), position
        )
        _check_once([row.name for row in parts["parameters"]], position, "parameters")
    with collecting(problems):
        _check_whole(parts, table, position)
    if problems:
        raise ConfigError(*problems)
    study = Study(path=path, **parts)
    if not study.columns and not own_kind:
        if study.data.suffix != RECORDING_SUFFIX:
            raise ConfigError(
                position.problem("lacks [[columns]]: only a recording of the trainer needs none")
            )
        return replace(study, columns=own_columns())
    return study


def read_parts(
    table: Mapping[str, Any],
    position: Position,
    heading: tuple[type[Any], Sequence[str]],
    records: Mapping[str, type[Any]],
) -> tuple[dict[str, Any], list[str]]:
    """Return heading and tables of a file, None for those lacking, and all faults.

    ``heading`` is the record of the keys above all tables, and all keys that there may be.
    """
    record, known = heading
    if "schema" in table:  # alone: a file of another form has other keys
        kind_of(record.__dataclass_fields__["schema"]).read("schema", table["schema"], position)
    problems = [
        position.wrong(key, value, f"no such key{nearest(key, known)}")
        for key, value in table.items()
        if key not in known
    ]
    parts: dict[str, Any] = dict.fromkeys(records)
    above = {item.name for item in fields(record)} | {"note"}
    with collecting(problems):
        heading_values = {key: value for key, value in table.items() if key in above}
        parts["heading"] = read_record(record, heading_values, position, ("note",))
    for name, kind in records.items():
        with collecting(problems):
            if name in table:
                parts[name] = read_record(kind, table[name], position.inside(name), ("note",))
    return parts, problems


def _columns(
    rows: tuple[ColumnRow, ...], position: Position, *, steered: bool
) -> dict[str, Column]:
    """Return the columns by channel; ConfigError if one is given twice or in a wrong unit."""
    _check_once([row.channel for row in rows], position, "columns")
    problems: list[str] = []
    columns = {}
    for i, row in enumerate(rows):
        try:
            factor(row.channel, row.unit)
            columns[row.channel] = Column(row.column, row.unit, row.missing, row.scale, row.offset)
        except ConfigError as wrong:
            problems.append(position.inside(f"columns[{i}]").problem(str(wrong)))
    if columns and steered and "rudder" not in columns and not problems:
        problems.append(position.inside("columns").problem("no column is the rudder"))
    if problems:
        raise ConfigError(*problems)
    return columns


def _check_once(names: list[str], position: Position, table: str) -> None:
    """Check that no name stands twice in a table; ConfigError naming the first that does."""
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    if twice:
        raise ConfigError(position.inside(table).problem(f"{twice[0]} is given twice"))


def _check_whole(parts: Mapping[str, Any], table: Mapping[str, Any], position: Position) -> None:
    """Check whole numbers, and what goes together; ConfigError with all faults."""
    problems: list[str] = []
    heading = parts.get("heading")
    begin, end = (heading.from_s, heading.to_s) if heading else (None, None)
    if begin is not None and end is not None and end <= begin:
        problems.append(position.wrong("to_s", end, f"must be after from_s = {begin:g}"))
    counts = {"": ("heading", ("every",)), "armax": ("armax", ("most", "dead_time", "lags"))}
    counts["model"] = ("model", ("restarts", "predict_from", "predict_to"))
    for name, (part, keys) in counts.items():
        for key in keys:
            value = getattr(parts.get(part), key, None)
            if value is not None and value != int(value):
                inside = position.inside(name) if name else position
                problems.append(inside.wrong(key, value, "must be a whole number"))
    model = parts.get("model")
    if model is not None and (parts.get("ship") or "ship" not in table):
        problems += _model_problems(model, parts.get("ship"), position)
    if problems:
        raise ConfigError(*problems)


def _model_problems(model: ModelTable, ship: Ship | None, position: Position) -> Iterator[str]:
    """Yield what a model lacks, and what does not go with it."""
    inside = position.inside("model")
    if model.kind == "own":
        if model.outputs:
            yield inside.problem("of kind own has outputs of its own")
        if model.file is None:
            yield inside.problem("of kind own lacks file, its system")
        return
    if not model.outputs:
        yield inside.problem("lacks outputs")
    if model.file is not None:
        yield inside.wrong("file", model.file, "goes with kind own")
    if ship is None:
        yield position.problem("[model] needs a [ship] with its length_m")
        return
    for channel, key in (("bow_sway", "bow_log_m"), ("stern_sway", "stern_log_m")):
        if channel in model.outputs and getattr(ship, key) is None:
            yield position.inside("ship").problem(f"output {channel} needs {key}")


def observe_record(study: Study, loaded: Record | None = None) -> Record:
    """Return the record of a study: signs and units as here, thinned, cut, examined.

    The record is ``loaded``, or else that of the study's file. ConfigError with all that forbids
    its use; if the file is no study, it says which command writes one.
    """
    heading = study.heading
    try:
        record = loaded or load_record(study.data, study.columns)
    except NoColumnError as error:
        if study.path != study.data:
            raise
        advice = f"trainer identify new {study.data} -o study.toml writes a study of its columns"
        raise ConfigError(*error.problems, advice) from None
    if "t" not in study.columns:
        record = replace(record, t=record.t * (heading.interval_s or 1.0))
    if heading.positive_rudder == "starboard" and record.rudder is not None:
        record = replace(record, rudder=-record.rudder)
    if study.system is not None:
        record = replace(record, driving=study.system.inputs)
        record, path, told = _with_path(record, study, study.system.inputs)
        findings = examine_columns(record)
    else:
        record = check_evidence(
            record,
            course_of(study),
            in_study(record, heading.positive_rudder),
            anyway=heading.anyway == "yes",
        )
        track = study.track or Track()
        current = KNOT * track.current_east_kn, KNOT * track.current_north_kn
        try:
            record = with_sway(record, Drift(*current, track.antenna_m))
        except ConfigError as wrong:
            if "sway" in (
                *(study.model.outputs if study.model else ()),
                study.armax and study.armax.output,
            ):
                raise
            record = replace(record, findings=(*record.findings, no_sway(record, wrong)))
        record, path, told = _with_path(record, study, ("rudder",))
        findings = examine_record(record, study.ship)
    record = replace(unwrap_heading(record), findings=(*findings, *told))
    record = replace(record.every(int(study.heading.every)), between_readings=path)
    if study.sensors is not None:
        record = read_by(record, study.sensors)
    return _cut(record, study)


def course_of(study: Study) -> Course:
    """Return what a study says of its ship, to judge a record by."""
    ship = study.ship
    if ship is None:
        return Course(None, None, None)
    return Course(ship.length_m, ship.speed_kn * KNOT if ship.speed_kn else None, None)


def _cut(record: Record, study: Study) -> Record:
    """Return the times that a study uses."""
    heading = study.heading
    return record.between(
        -np.inf if heading.from_s is None else heading.from_s,
        np.inf if heading.to_s is None else heading.to_s,
    )


def _with_path(
    record: Record, study: Study, inputs: Sequence[str]
) -> tuple[Record, str, tuple[Finding, ...]]:
    """Return the record with its inputs known in each row, their way in the fit, what tells it."""
    if not inputs:
        return record, record.between_readings, ()
    path, why = choose_path(_cut(record, study), inputs, study.heading.between_readings)
    record = replace(fill_inputs(record, inputs, path), between_readings=path)
    if study.heading.every > 1:
        path, why = "step", f"the mean of {study.heading.every:g} readings"
    stepwise = "ARMAX models" if study.model is None and study.armax is not None else ""
    stepwise = "matrices of one step" if study.system and study.system.discrete else stepwise
    if stepwise:
        path, why = "step", f"{stepwise} know no other"
    return record, path, (record.finding(inputs[0], f"taken as {PATH_TEXTS[path]}, {why}"),)


def studies_of(study: Study) -> tuple[Study, ...]:
    """Return the study of each run alone, the first record's first.

    A further run has another seed, because its instruments do not repeat the errors of the first.
    """
    studies = [study]
    for number, row in enumerate(study.runs, 1):
        ship, sensors = study.ship, study.sensors
        if ship is not None and row.speed_kn is not None:
            ship = replace(ship, speed_kn=row.speed_kn)
        if sensors is not None:
            sensors = replace(sensors, seed=(sensors.seed or 1) + number)  # other errors
        heading = replace(study.heading, data=row.data, from_s=row.from_s, to_s=row.to_s)
        studies.append(replace(study, heading=heading, ship=ship, sensors=sensors, runs=()))
    return tuple(studies)


def speed_of(study: Study, record: Record) -> float:
    """Return the ship's speed [m/s]; ConfigError if neither study nor record says it."""
    if study.ship is not None and study.ship.speed_kn is not None:
        return study.ship.speed_kn * KNOT
    if record.speed is None:
        position = Position(study.path.name, "ship")
        raise ConfigError(position.problem("lacks speed_kn, and no speed was recorded"))
    return float(np.nanmean(record.speed))


def identification_schema() -> dict[str, Any]:
    """Return the JSON Schema of an identification study."""
    heading = record_schema(StudyHeading, ("note",))
    tables = {name: record_schema(record, ("note",)) for name, record in OPTIONAL_TABLES.items()}
    arrays = {"columns": COLUMN_ROWS, "runs": RUN_ROWS, "parameters": PARAMETER_ROWS}
    rows = {name: describe_kind(each) for name, each in arrays.items()}
    keys = {**heading["properties"], **tables, **rows}
    return file_schema("identification", keys, heading["required"])

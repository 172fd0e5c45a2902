"""Members flown one by one: a manoeuvre by a boat of its own, as ``trainer manoeuvre`` flies it."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from trainer.config import ConfigError, Place
from trainer.files.schema import read_record
from trainer.files.vessel_file import VesselFile, read_vessel
from trainer.fitout import Method
from trainer.study.manoeuvres.catalogue import PARAMETERS, adjusted, named
from trainer.study.manoeuvres.flight import Flight, Manoeuvre, fly
from trainer.study.manoeuvres.submarine import Rig, Submarine
from trainer.sweep.study_file import Study, method_of
from trainer.sweep.study_records import ManoeuvreTable
from trainer.units import KNOT


@dataclass(frozen=True)
class Case:
    """One member: a boat, how it is computed and handled, and what it flies."""

    file: VesselFile
    method: Method
    rig: Rig
    table: ManoeuvreTable


def case_of(study: Study, drawn: Mapping[str, Any]) -> Case:
    """Return the member with these numbers; ConfigError if there can be no such boat."""
    tables, file = study.varied(drawn), study.file
    if file is None:
        raise ConfigError(f"{study.path.name}: has no boat")
    if any(variable.steps[0] == "vessel" for variable in study.variables):
        file = read_vessel(tables["vessel"], file.text, file.path)
    place = Place(study.path.name, "manoeuvre")
    table = read_record(ManoeuvreTable, tables["manoeuvre"], place, ())
    rig = Rig(table.controls or "own", table.trim or "own", table.law or "trainer")
    return Case(file, method_of(study.method, file), rig, table)


def manoeuvre_of(case: Case, boat: Any) -> Manoeuvre:
    """Return the manoeuvre of a case for a vehicle; ConfigError if it cannot fly it."""
    told = asdict(case.table)
    given = {name: told[key] for name, key in PARAMETERS.items() if told[key] is not None}
    try:
        manoeuvre = adjusted(case.table.name, boat, given)
    except ConfigError as wrong:
        raise ConfigError(f"[manoeuvre] {str(wrong).removeprefix('--')}") from None
    if case.table.depth_kept is None:
        return manoeuvre
    if not hasattr(manoeuvre, "keep") or "keep" not in asdict(manoeuvre):
        raise ConfigError(f"[manoeuvre] depth_kept: {case.table.name} has no such choice")
    return replace(manoeuvre, keep=("depth",) * case.table.depth_kept)  # type: ignore[call-arg]


def speed_of(case: Case) -> float:
    """Return the speed [m/s] that a case begins with; ConfigError for a speed at rest."""
    if not named(case.table.name).from_rest:
        knots = case.table.speed_kn
        return (case.file.run.start_speed_kn if knots is None else knots) * KNOT
    if case.table.speed_kn is not None:
        raise ConfigError("[manoeuvre] speed_kn: this manoeuvre starts from rest")
    return 0.0


def flown(case: Case) -> tuple[Manoeuvre, Flight]:
    """Return the manoeuvre of a case and its flight; ConfigError if it cannot begin."""
    boat = Submarine(case.file, case.method, case.rig)
    manoeuvre = manoeuvre_of(case, boat)
    return manoeuvre, fly(boat, manoeuvre, speed_of(case))

"""The tables of keys, measures and laws in the documents, made of the readers' own records.

    python -m helpers.key_tables vessel-files

prints the tables of docs/vessel-keys.md, to be put in their place by hand; ``TABLES`` has the
other names. Tests compare each with its document, so that the two cannot differ for long.
"""

import sys
from collections.abc import Callable, Mapping
from dataclasses import fields
from typing import Any, Final

from trainer.analysis.sweep import records as sweep
from trainer.config.boat import ballast_records as ballast
from trainer.config.boat import hull
from trainer.config.boat import plant_records as plant
from trainer.config.boat import vessel_records as vessel
from trainer.config.boat.casualties import SEVERITY_MEASURES, CasualtyEntry, CompoundEntry
from trainer.config.boat.similarity import LAW_EXCEPTIONS, formula, power_of
from trainer.config.boat.vessel import DOCUMENTARY_KEYS, DOCUMENTARY_TABLES, VESSEL_RECORDS
from trainer.config.exercise import check_case, exercise, reference_crew
from trainer.config.exercise.condition import STATE_QUANTITIES
from trainer.config.exercise.score_rules import (
    SCORE_MEASURES,
    TIMELESS_MEASURES,
    WINDOW_KEYS,
    ScoreRow,
)
from trainer.config.exercise.stated import StatedRow
from trainer.config.exercise.steps import StepRow
from trainer.config.schema import kind_of
from trainer.config.ship import ship
from trainer.config.ship.derivatives import DerivativesFile
from trainer.config.ship.nomoto import NomotoFile
from trainer.config.ship.sensors import Sensors
from trainer.config.world import contacts
from trainer.config.world.bottom import BottomTable
from trainer.config.world.current import Current, Tide
from trainer.config.world.sea import Sea
from trainer.core.casualties import KINDS
from trainer.identify.model.system_files import SystemFile, SystemParameter
from trainer.identify.pages import decca
from trainer.identify.record import study_records

Records = Mapping[str, type[Any]]  # by the heading of the table; "" is above all tables

# fmt: off
VESSEL_UNITS: Final = (
    "W", "kg m2", "N m", "m3", "kg", "N", "kg/s", "m2", "cm2", "mm2", "m", "s", "kn", "m/s", "-",
    "deg", "degC", "m/s2", "kg/m3", "1/s", "deg/s", "rad/s", "rad s/m", "1/m", "rad/m", "deg/s2",
    "rad/(m s)",
)
# fmt: on
BALLAST_RECORDS: Final = {
    "ballast": ballast.Ballast,
    "[ballast.blown]": ballast.BlownTank,
    "[ballast.pumped]": ballast.PumpedTank,
    "[ballast.compartments]": ballast.Compartment,
    "[ballast.banks]": ballast.Bank,
    "ballast.air": ballast.Air,
    "ballast.pumps": ballast.Pumps,
    "ballast.hover": ballast.HoverControl,
    "ballast.sea": ballast.HullBuoyancy,
}
PLANT_RECORDS: Final = {
    "plant": plant.Plant,
    "plant.main": plant.OilSystem,
    "plant.vital": plant.OilSystem,
    "plant.surfaces": plant.SurfaceOil,
    "plant.battery": plant.Battery,
    "plant.fire": plant.Fire,
    "[plant.pumps]": plant.OilPump,
    "[plant.consumers]": plant.Consumer,
    "[plant.hotel]": plant.Hotel,
    "[plant.compartments]": plant.Compartment,
    "[plant.burning]": plant.BurningItem,
}
EXERCISE_RECORDS: Final = {
    "": exercise.ExerciseHeading,
    "initial": exercise.StartState,
    "[orders]": exercise.OrderRow,
    "[casualties]": exercise.CasualtyRow,
    "limits": exercise.ExerciseLimits,
    "[scores]": ScoreRow,
    "[contact]": contacts.ContactRow,
    "contacts": contacts.Encounters,
    "bottom": BottomTable,
    "[crew]": reference_crew.CrewRow,
    "planesman": reference_crew.Planesman,
    "helmsman": reference_crew.Helmsman,
    "[stated]": StatedRow,
    "[steps]": StepRow,
}
CHECK_CASE_RECORDS: Final[Records] = {
    "": check_case.CaseHeading,
    "start": check_case.CaseStart,
    "spread": check_case.CaseSpread,
    "[runs]": check_case.CaseRun,
}
VESSEL_FILE_RECORDS: Final = {
    "fluid": vessel.Fluid,
    "vessel": vessel.Hull,
    "propulsion": vessel.Propulsion,
    "[propulsion.sets]": vessel.ThrustSet,
    "control_surfaces": vessel.Surfaces,
    "envelope": vessel.Envelope,
    "compact": vessel.CompactTerms,
    "run": vessel.RunDefaults,
    "autopilot": vessel.Autopilot,
    "free_surface": vessel.FreeSurface,
    "[free_surface.rows]": vessel.SurfaceRow,
    "wave_strips": vessel.WaveStrips,
    "scope": vessel.Scope,
}
SHIP_RECORDS: Final = {
    "": ship.ShipHeading,
    **{name: record for name, record in ship.SHIP_TABLES.items() if name != "sensors"},
    "[columns]": ship.ShipColumn,
}
IDENTIFICATION_RECORDS: Final = {
    "": study_records.StudyHeading,
    "[columns]": study_records.ColumnRow,
    "[runs]": study_records.RunRow,
    "ship": study_records.Ship,
    "sensors": Sensors,
    "track": study_records.Track,
    "model": study_records.ModelTable,
    "[parameters]": study_records.ParameterRow,
    "armax": study_records.ArmaxTable,
}
SWEEP_RECORDS: Final = {
    "": sweep.SweepHeading,
    "method": sweep.MethodTable,
    "manoeuvre": sweep.ManoeuvreTable,
    "identification": sweep.IdentificationTable,
    "[parameters]": sweep.SweptParameter,
    "sample": sweep.Sample,
    "[vary]": sweep.VaryRow,
}


def tables_of(records: Records) -> str:
    """Return the tables that document each key of each record."""
    text = "\n\n".join("\n".join(key_rows(record, name)) for name, record in records.items())
    return text.replace("### `[]`", "### Above all tables") + "\n"


def key_rows(record: type[Any], table: str) -> list[str]:
    """Return the lines of a table that documents each key of ``record``."""
    rows = [f"| `{item.name}` | {' | '.join(kind_of(item).form[:3])} |" for item in fields(record)]
    return [f"### `[{table}]`", "", "| key | unit | range | meaning |", "|---|---|---|---|", *rows]


def plain_table(record: type[Any]) -> str:
    """Return the table of a file's keys, without a heading, as the file has no tables."""
    return tables_of({"plain": record}).replace("### `[plain]`\n\n", "")


def kind_table() -> str:
    """Return the table of the kinds of casualties."""
    rows = ["| kind | severity | is |", "|---|---|---|"]
    for kind in KINDS:
        measure = SEVERITY_MEASURES[kind]
        limits = "1" if measure.sudden else str(measure.limits)
        rows.append(f"| `{kind}` | {limits} | {measure.meaning} |")
    return "\n".join(rows) + "\n"


def quantity_table() -> str:
    """Return the table of the quantities that conditions are about."""
    rows = ["| quantity | units | is |", "|---|---|---|"]
    rows += [
        f"| `{name}` | {', '.join(q.units)} | {q.meaning} |" for name, q in STATE_QUANTITIES.items()
    ]
    return "\n".join(rows) + "\n"


def law_table() -> str:
    """Return the table of the laws by which a boat's numbers follow its length."""
    by_power: dict[float, list[str]] = {}
    for unit in VESSEL_UNITS:
        by_power.setdefault(power_of(unit), []).append(unit)
    rows = ["| follows the length as | units |", "|---|---|"]
    for power, units in sorted(by_power.items(), reverse=True):
        rows.append(f"| {formula(power)} | {', '.join(units)} |")
    rows += ["", "| key | law, where it is not that of the unit |", "|---|---|"]
    rows += [
        f"| `[{table}] {key}` | {law.reason} |" for (table, key), law in LAW_EXCEPTIONS.items()
    ]
    return "\n".join(rows) + "\n"


def documentary_keys() -> dict[str, tuple[str, ...]]:
    """Return by table of a vessel file the keys that are for the reader only."""
    keys = dict(DOCUMENTARY_KEYS)
    for table, record in VESSEL_RECORDS.items():
        for item in fields(record):
            inner = getattr(kind_of(item), "documentary", ())
            if inner:
                keys[f"{table}.{item.name}"] = inner
    return keys


def documentary_list() -> str:
    """Return the list of what is for the reader only in a vessel file."""
    lines = [f"- `[{name}]`, all of it." for name in DOCUMENTARY_TABLES]
    for table, keys in documentary_keys().items():
        where = f"`[{table}]`" if table else "Above all tables"
        lines.append(f"- {where}: {', '.join(f'`{key}`' for key in keys)}.")
    return "\n".join(lines)


def measure_table() -> str:
    """Return the table of the measures by which exercises are judged."""
    rows = [
        "| measure | unit | needs | may have | value | place told |",
        "|---|---|---|---|---|---|",
    ]
    spoken = {"q": "quantity", "t": "target", "b": "band", "by": " by band", "c": "casualty"}
    spoken["f"] = ", or its distance from target"
    for name, measure in SCORE_MEASURES.items():
        timed = () if name in TIMELESS_MEASURES else WINDOW_KEYS
        cells = (
            f"`{name}`",
            measure.unit or "the quantity's",
            ", ".join(measure.needs) or "nothing",
            ", ".join((*measure.may, *timed)),
            measure.formula.format(**spoken, o=" (of the orders named)", k=" (of the rank named)"),
            measure.moment,
        )
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows) + "\n"


TABLES: Final[Mapping[str, Callable[[], str]]] = {  # by the page, or what it is of
    "ballast": lambda: tables_of(BALLAST_RECORDS),
    "casualties": lambda: tables_of(
        {"casualty.NAME": CasualtyEntry, "casualty.NAME], with parts": CompoundEntry}
    ).replace("], with parts]`", "]`, with parts"),
    "casualty-kinds": kind_table,
    "casualty-quantities": quantity_table,
    "check-cases": lambda: tables_of(CHECK_CASE_RECORDS),
    "decca": lambda: tables_of(
        {"": decca.DeccaHeading, "[slaves]": decca.SlaveRow, **decca.DECCA_TABLES}
    ),
    "derivatives": lambda: plain_table(DerivativesFile),
    "documentary": documentary_list,
    "exercises": lambda: tables_of(EXERCISE_RECORDS),
    "identification": lambda: tables_of(IDENTIFICATION_RECORDS),
    "laws": law_table,
    "measures": measure_table,
    "nomoto": lambda: plain_table(NomotoFile),
    "nonlinear-ships": lambda: tables_of(SHIP_RECORDS),
    "own-hull": lambda: tables_of({**hull.HULL_TABLES, "[surfaces]": hull.Panels}),
    "seas": lambda: tables_of({"sea": Sea}),
    "plant": lambda: tables_of(PLANT_RECORDS),
    "sweeps": lambda: tables_of(SWEEP_RECORDS),
    "systems": lambda: tables_of({"": SystemFile, "[parameters]": SystemParameter}),
    "vessel-files": lambda: tables_of(VESSEL_FILE_RECORDS),
    "world": lambda: tables_of({"current": Current, "current.tide": Tide}),
}

if __name__ == "__main__":
    print(TABLES[sys.argv[1]](), end="")

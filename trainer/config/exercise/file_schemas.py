"""JSON Schemas of the files that users write, made of the readers' own records.

``trainer dev schema`` prints them. Editors complete keys and underline faults by them. Whether keys
fit together is checked only by the readers.
"""

from dataclasses import fields
from typing import Any

from trainer.config.boat import casualties, hull, vessel
from trainer.config.boat.coefficients import (
    COEFFICIENT_QUANTITY,
    EQUATION_SETS,
    FACTOR_QUANTITY,
    FORCE_AXES,
)
from trainer.config.exercise.exercise import (
    CASUALTY_ROWS,
    ORDER_ROWS,
    ExerciseHeading,
    ExerciseLimits,
    StartState,
)
from trainer.config.exercise.reference_crew import CREW_RULE_ROWS, Helmsman, Planesman
from trainer.config.exercise.score_rules import SCORE_ROWS
from trainer.config.exercise.stated import STATED_ROWS
from trainer.config.exercise.steps import STEP_ROWS
from trainer.config.schema import describe_kind, file_schema, object_schema, record_schema
from trainer.config.world import sea
from trainer.config.world.current import current_schema
from trainer.config.world.world import WORLD_SCHEMAS
from trainer.core.terms import COEFFICIENTS, EXTRA_TERMS


def coefficients_schema() -> dict[str, Any]:
    """Return the JSON Schema of the table [coefficients]."""
    known = {
        term.key: {
            **COEFFICIENT_QUANTITY.form.schema,
            "description": f"L^{term.power}, times {term.multiplies}",
        }
        for term in COEFFICIENTS
    }
    by_axis = {
        axis: object_schema({key: each for key, each in known.items() if key[0] == axis}, ())
        for axis in FORCE_AXES
    }
    return object_schema({**by_axis, **known}, ())


def compensation_schema() -> dict[str, Any]:
    """Return the JSON Schema of the table [compensation]."""
    kept_keys = [term.key for term in COEFFICIENTS if term.kept or term.key in EXTRA_TERMS]
    factors = object_schema(dict.fromkeys(kept_keys, describe_kind(FACTOR_QUANTITY)), ())
    return object_schema(dict.fromkeys(EQUATION_SETS, factors), ())


def vessel_schema() -> dict[str, Any]:
    """Return the JSON Schema of a vessel file."""
    # Keys that the defaults file has are not necessary in a user's file.
    supplied, _ = vessel.with_defaults({})
    heads = {"schema": vessel.VESSEL_SCHEMA, **vessel.HEADING_FIELDS}
    keys = {name: describe_kind(kind) for name, kind in heads.items()}
    keys |= {
        name: record_schema(record, vessel.DOCUMENTARY_KEYS.get(name, ()), supplied.get(name, ()))
        for name, record in vessel.VESSEL_RECORDS.items()
    }
    keys |= {"coefficients": coefficients_schema(), "compensation": compensation_schema()}
    keys |= {name: {"description": "for the reader"} for name in vessel.DOCUMENTARY_TABLES}
    return file_schema("vessel", keys, ("fluid", "vessel", "propulsion", "coefficients"))


def hull_schema() -> dict[str, Any]:
    """Return the JSON Schema of a hull file."""
    keys = {name: record_schema(record, ("note",)) for name, record in hull.HULL_TABLES.items()}
    whole = {
        "name": describe_kind(hull.BOAT_NAME),
        **keys,
        "surfaces": describe_kind(hull.SURFACE_ROWS),
    }
    needed = ("name", *hull.NECESSARY_TABLES, "surfaces")
    return file_schema("hull", {**whole, "note": {"description": "for the reader"}}, needed)


def sea_table_schema() -> dict[str, Any]:
    """Return the JSON Schema of a table [sea]; one of the three measures is given."""
    table = record_schema(sea.Sea, ("note",), sea.sea_defaults())
    return {**table, "oneOf": [{"required": [name]} for name in sea.HEIGHT_KEYS]}


def sea_schema() -> dict[str, Any]:
    """Return the JSON Schema of a sea file."""
    keys = {name: describe_kind(kind) for name, kind in sea.HEADING_FIELDS.items()}
    tables = {"sea": sea_table_schema(), "current": current_schema()}
    return file_schema("sea", {**keys, **tables}, ("sea",))


def exercise_keys() -> dict[str, dict[str, Any]]:
    """Return the JSON Schemas of the keys and tables of an exercise file."""
    heading = record_schema(ExerciseHeading, ("note",))["properties"]
    tables = {
        "initial": StartState,
        "limits": ExerciseLimits,
        "planesman": Planesman,
        "helmsman": Helmsman,
    }
    rows = {
        "orders": ORDER_ROWS,
        "casualties": CASUALTY_ROWS,
        "scores": SCORE_ROWS,
        "crew": CREW_RULE_ROWS,
    }
    return {
        **heading,
        **{name: record_schema(record, ("note",)) for name, record in tables.items()},
        **{name: describe_kind(kind) for name, kind in rows.items()},
        "stated": describe_kind(STATED_ROWS),
        "steps": describe_kind(STEP_ROWS),
        "sea": {"anyOf": [{"type": "string"}, sea_table_schema()]},
        **{name: schema() for name, schema in WORLD_SCHEMAS.items()},
    }


def exercise_schema() -> dict[str, Any]:
    """Return the JSON Schema of an exercise file."""
    needed = record_schema(ExerciseHeading, ())["required"]
    return file_schema("exercise", exercise_keys(), needed)


def casualties_schema() -> dict[str, Any]:
    """Return the JSON Schema of a table of casualties.

    Only ``kind`` is necessary, because the standard table supplies the other keys.
    """
    supplied = [item.name for item in fields(casualties.CasualtyEntry) if item.name != "kind"]
    entry = record_schema(casualties.CasualtyEntry, ("note",), supplied)
    compound = record_schema(casualties.CompoundEntry, ("note",))
    compound["properties"]["parts"]["items"] = entry
    entries = {
        "type": "object",
        "propertyNames": {
            "pattern": f"^{casualties.CASUALTY_NAME.pattern}$",
            "not": {"const": "all"},
        },
        "additionalProperties": {"if": {"required": ["parts"]}, "then": compound, "else": entry},
    }
    keys = {name: describe_kind(kind) for name, kind in casualties.HEADING_FIELDS.items()}
    return file_schema("casualties", {**keys, "casualty": entries}, ("casualty",))

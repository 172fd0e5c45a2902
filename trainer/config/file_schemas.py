"""JSON Schemas of the files that users write, made of the readers' own records.

Editors complete and underline by them. What fits together among keys the readers alone know.
"""

from dataclasses import fields
from typing import Any

from trainer.config import casualties, hull, sea, vessel
from trainer.config.coefficients import AXES, COEFFICIENT, EQUATION_SETS, FACTOR
from trainer.config.current import current_schema
from trainer.config.exercise import CASUALTIES, ORDERS, Heading, Initial, Limits
from trainer.config.reference_crew import RULES, Helmsman, Planesman
from trainer.config.schema import described, file_schema, object_schema, record_schema
from trainer.config.score_rules import SCORES
from trainer.config.stated import STATED
from trainer.config.world import SCHEMAS
from trainer.core.terms import COEFFICIENTS, EXTRA_TERMS


def coefficients_schema() -> dict[str, Any]:
    """Return the JSON Schema of the table [coefficients]."""
    known = {
        term.key: {
            **COEFFICIENT.form.schema,
            "description": f"L^{term.power}, times {term.multiplies}",
        }
        for term in COEFFICIENTS
    }
    by_axis = {
        axis: object_schema({key: each for key, each in known.items() if key[0] == axis}, ())
        for axis in AXES
    }
    return object_schema({**by_axis, **known}, ())


def compensation_schema() -> dict[str, Any]:
    """Return the JSON Schema of the table [compensation]."""
    kept = [term.key for term in COEFFICIENTS if term.kept or term.key in EXTRA_TERMS]
    factors = object_schema(dict.fromkeys(kept, described(FACTOR)), ())
    return object_schema(dict.fromkeys(EQUATION_SETS, factors), ())


def vessel_schema() -> dict[str, Any]:
    """Return the JSON Schema of a vessel file."""
    supplied, _ = vessel.with_defaults({})
    heads = {"schema": vessel.SCHEMA, **vessel.HEADING}
    keys = {name: described(kind) for name, kind in heads.items()}
    keys |= {
        name: record_schema(record, vessel.DOCUMENTARY_KEYS.get(name, ()), supplied.get(name, ()))
        for name, record in vessel.RECORDS.items()
    }
    keys |= {"coefficients": coefficients_schema(), "compensation": compensation_schema()}
    keys |= {name: {"description": "for the reader"} for name in vessel.DOCUMENTARY_TABLES}
    return file_schema("vessel", keys, ("fluid", "vessel", "propulsion", "coefficients"))


def hull_schema() -> dict[str, Any]:
    """Return the JSON Schema of a hull file."""
    keys = {name: record_schema(record, ("note",)) for name, record in hull.TABLES.items()}
    whole = {"name": described(hull.NAME), **keys, "surfaces": described(hull.SURFACES)}
    needed = ("name", *hull.NEEDED, "surfaces")
    return file_schema("hull", {**whole, "note": {"description": "for the reader"}}, needed)


def sea_table_schema() -> dict[str, Any]:
    """Return the JSON Schema of a table [sea]; one of the three measures is given."""
    table = record_schema(sea.Sea, ("note",), sea.sea_defaults())
    return {**table, "oneOf": [{"required": [name]} for name in sea.MEASURES]}


def sea_schema() -> dict[str, Any]:
    """Return the JSON Schema of a sea file."""
    keys = {name: described(kind) for name, kind in sea.HEADING.items()}
    tables = {"sea": sea_table_schema(), "current": current_schema()}
    return file_schema("sea", {**keys, **tables}, ("sea",))


def exercise_keys() -> dict[str, dict[str, Any]]:
    """Return the JSON Schemas of the keys and tables of an exercise file."""
    heading = record_schema(Heading, ("note",))["properties"]
    tables = {"initial": Initial, "limits": Limits, "planesman": Planesman, "helmsman": Helmsman}
    rows = {"orders": ORDERS, "casualties": CASUALTIES, "scores": SCORES, "crew": RULES}
    return {
        **heading,
        **{name: record_schema(record, ("note",)) for name, record in tables.items()},
        **{name: described(kind) for name, kind in rows.items()},
        "stated": described(STATED),
        "sea": {"anyOf": [{"type": "string"}, sea_table_schema()]},
        **{name: schema() for name, schema in SCHEMAS.items()},
    }


def exercise_schema() -> dict[str, Any]:
    """Return the JSON Schema of an exercise file."""
    needed = record_schema(Heading, ())["required"]
    return file_schema("exercise", exercise_keys(), needed)


def casualties_schema() -> dict[str, Any]:
    """Return the JSON Schema of a table of casualties. The standard one gives all but the kind."""
    supplied = [item.name for item in fields(casualties.Entry) if item.name != "kind"]
    entry = record_schema(casualties.Entry, ("note",), supplied)
    entries = {
        "type": "object",
        "propertyNames": {"pattern": f"^{casualties.NAME.pattern}$", "not": {"const": "all"}},
        "additionalProperties": entry,
    }
    keys = {name: described(kind) for name, kind in casualties.HEADING.items()}
    return file_schema("casualties", {**keys, "casualty": entries}, ("casualty",))

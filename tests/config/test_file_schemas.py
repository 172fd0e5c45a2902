"""The JSON Schemas that editors use: every shipped file fits, and slips are refused by them too."""

import copy
import json
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import click
import pytest
from fuzz.files import SHIP
from helpers.places import ROOT
from helpers.typed import type_command
from jsonschema import Draft202012Validator

from trainer.cli.schema import SCHEMA_MODULES, schema, schema_of

CONFIGS = ROOT / "configs"
FOLDERS = {
    "vessel": "vessels",
    "hull": "hulls",
    "exercise": "exercises",
    "sea": "seas",
    "ship": "ships",
    "casualties": "casualties",
    "study": "studies",
    "case": "check-cases",
}
SHIPPED = [
    (kind, path)
    for kind, folder in FOLDERS.items()
    for path in sorted((CONFIGS / folder).glob("*.toml"))
    if "." not in path.stem  # what is kept beside a file, such as a baseline
]
SHIPPED.append(("exercise", CONFIGS / "exercise-skeleton.toml"))
SHIPPED.append(("hull", CONFIGS / "hull-skeleton.toml"))
IDENTIFICATION = """
schema = "identify/1"
name = "trial"
data = "trial.csv"
[model]
kind = "1"
outputs = ["sway", "yaw_rate"]
[ship]
length_m = 70.2
"""


@cache
def validator(kind: str) -> Draft202012Validator:
    return Draft202012Validator(schema_of(kind))


def faults(kind: str, table: dict[str, Any]) -> list[str]:
    """Return what the schema of a kind has against a file."""
    return [error.message for error in validator(kind).iter_errors(table)]


def shipped(name: str) -> dict[str, Any]:
    return tomllib.loads((CONFIGS / name).read_text(encoding="utf-8"))


@pytest.mark.parametrize("kind", SCHEMA_MODULES)
def test_a_schema_is_one_of_draft_2020_12(kind: str) -> None:
    made = schema_of(kind)

    assert made["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    Draft202012Validator.check_schema(made)
    assert json.loads(json.dumps(made, allow_nan=False)) == made


@pytest.mark.parametrize(("kind", "path"), SHIPPED, ids=lambda each: getattr(each, "name", each))
def test_every_shipped_file_fits_its_schema(kind: str, path: Path) -> None:
    assert not faults(kind, tomllib.loads(path.read_text(encoding="utf-8")))


def test_an_identification_fits_its_schema() -> None:
    assert not faults("identification", tomllib.loads(IDENTIFICATION))
    assert faults("identification", tomllib.loads(IDENTIFICATION.replace("kind", "knid")))


def test_a_ship_fits_its_schema() -> None:
    whole = SHIP.decode()

    assert not faults("ship", tomllib.loads(whole))
    assert faults("ship", tomllib.loads(whole.replace("length_m", "lenght_m")))
    assert faults("ship", tomllib.loads(whole.replace("Y_d = [0.01,", 'Y_d = ["a",')))


@pytest.mark.parametrize(
    ("kind", "name", "keys", "value", "told"),
    [
        ("vessel", "vessels/bb2.toml", ("vessel", "lenght"), 70.0, "'lenght' was unexpected"),
        ("vessel", "vessels/bb2.toml", ("vessel", "length"), "70 m", "is not of type 'number'"),
        ("vessel", "vessels/bb2.toml", ("vessel", "length"), 500.0, "maximum of 400"),
        ("vessel", "vessels/bb2.toml", ("coefficients", "X", "X_udto"), 0.0, "unexpected"),
        ("vessel", "vessels/bb2.toml", ("propulsion", "bells_kn", "full"), 9.0, "unexpected"),
        ("vessel", "vessels/bb2.toml", ("vessel", "cg"), [0.0, 0.0], "too short"),
        ("vessel", "vessels/bb2.toml", ("ballast", "air", "temperature_c"), 90, "maximum of 40"),
        ("exercise", "exercises/backing.toml", ("duration_s",), "10 min", "not of type 'number'"),
        ("exercise", "exercises/backing.toml", ("initial", "depht_m"), 60.0, "unexpected"),
        ("exercise", "exercises/backing.toml", ("initial", "course_deg"), 400.0, "maximum of 360"),
        ("exercise", "exercises/backing.toml", ("hand",), ["ruder"], "is not one of"),
        ("sea", "seas/sea-state-5.toml", ("sea", "sea_stat"), 5, "unexpected"),
        ("sea", "seas/sea-state-5.toml", ("sea", "direction_deg"), "north", "type 'number'"),
        ("sea", "seas/sea-state-5.toml", ("sea", "wind_kn"), 20.0, "valid under each of"),
        ("casualties", "casualties/standard.toml", ("casualty", "rudder-slow", "kind"), "x", "one"),
        ("casualties", "casualties/standard.toml", ("casualty", "rudder-slow", "ramp"), 1, "unexp"),
        ("study", "studies/circles.toml", ("sample", "plan"), "gird", "is not one of"),
        ("study", "studies/circles.toml", ("sample", "seed"), 1.5, "not of type 'integer'"),
        ("study", "studies/circles.toml", ("exercise",), {}, "valid under each of"),
    ],
)
def test_a_slip_is_refused_by_the_schema_too(
    kind: str, name: str, keys: tuple[str, ...], value: object, told: str
) -> None:
    table = copy.deepcopy(shipped(name))
    inside: Any = table
    for key in keys[:-1]:
        inside = inside.setdefault(key, {})
    inside[keys[-1]] = value

    found = faults(kind, table)

    assert any(told in each for each in found), found


def test_a_file_that_lacks_a_table_is_refused() -> None:
    table = shipped("vessels/bb2.toml")
    del table["propulsion"]

    assert faults("vessel", table) == ["'propulsion' is a required property"]


def test_a_key_that_the_defaults_give_may_be_left_out() -> None:
    table = shipped("vessels/bb2.toml")
    del table["vessel"]["Ixy"], table["run"], table["propulsion"]["bells_kn"]

    assert not faults("vessel", table)


def test_editors_show_unit_and_meaning() -> None:
    length = schema_of("vessel")["properties"]["vessel"]["properties"]["length"]

    assert length["description"] == "[m] reference length L of the coefficients"


def test_words_of_a_vessel_file_that_nothing_reads_are_said_to_be_free() -> None:
    keys = schema_of("vessel")["properties"]
    for name in ("kind", "scale"):
        assert keys[name]["description"].startswith("for the reader, in any words")
        assert not faults("vessel", shipped("vessels/bb2.toml") | {name: "a houseboat"})


def test_the_command_writes_a_schema_and_says_the_line_that_names_it(tmp_path: Path) -> None:
    path = tmp_path / "exercise.schema.json"

    done = type_command(schema, "exercise", "-o", path)
    assert done.output.endswith("first line of your file: #:schema ./exercise.schema.json\n")
    assert json.loads(path.read_text(encoding="utf-8")) == schema_of("exercise")


@pytest.mark.parametrize(("typed", "nearest"), [("exercize", "exercise"), ("Vesel", "vessel")])
def test_a_mistyped_kind_is_refused_with_the_nearest(typed: str, nearest: str) -> None:
    told = f"'{typed}' is not one of 'vessel', .*; nearest is {nearest}$"
    with pytest.raises(click.UsageError, match=told) as wrong:
        schema.main([typed], standalone_mode=False)
    assert wrong.value.exit_code == 2

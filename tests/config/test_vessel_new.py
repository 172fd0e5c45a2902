"""A boat of one's own: a file written out, scaled by Froude's law, and flown beside its source."""

import functools
import re
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
from helpers.key_tables import BALLAST_RECORDS, PLANT_RECORDS, VESSEL_UNITS

from trainer.analysis.guide.programme import own_method
from trainer.analysis.manoeuvres.catalogue import find_manoeuvre, within_limits
from trainer.analysis.manoeuvres.flight import fly_manoeuvre
from trainer.analysis.manoeuvres.submarine import Rig, Submarine
from trainer.config.boat.similarity import LAW_EXCEPTIONS, law_of, power_of
from trainer.config.boat.vessel import VESSEL_RECORDS, VesselFile, load_vessel, parse_vessel
from trainer.config.boat.vessel_records import SurfaceRow, ThrustSet
from trainer.config.boat.vessel_template import vessel_text, write_new
from trainer.config.files import ConfigError
from trainer.config.schema import kind_of, kinds_of
from trainer.units import KNOT

BOATS = ("bb2", "sdv-mk9", "remus100")
TOLERANCE = 1e-3  # [-] of what is similar
LIKE = ("advance", "transfer", "tactical diameter", "heading overshoot 1", "heading overshoot 2")
TABLES = {
    **VESSEL_RECORDS,
    **{name.strip("[]"): record for name, record in BALLAST_RECORDS.items()},
    **{name.strip("[]"): record for name, record in PLANT_RECORDS.items()},
    "propulsion.sets": ThrustSet,
    "free_surface.rows": SurfaceRow,
}
PLANT_NAMES = {name.strip("[]") for name in PLANT_RECORDS}  # of another law, whatever the unit
POWERS = {"m": 1.0, "s": 0.5, "rad": 0.0}


def made(source: str, length: float | None) -> VesselFile:
    return parse_vessel(vessel_text(source, length, None), Path("boat.toml"))


# --- the laws


@pytest.mark.parametrize(
    ("unit", "power"),
    [
        ("m", 1.0),
        ("cm2", 2.0),
        ("m3", 3.0),
        ("kg", 3.0),
        ("kg m2", 5.0),
        ("N m", 4.0),
        ("W", 3.5),
        ("kn", 0.5),
        ("m/s2", 0.0),
        ("deg/s", -0.5),
        ("rad s/m", -0.5),
        ("rad/(m s)", -1.5),
        ("kg/m3", 0.0),
        ("kg/s", 2.5),
    ],
)
def test_a_unit_tells_the_power_of_the_length(unit: str, power: float) -> None:
    assert power_of(unit) == power


def test_every_key_of_a_vessel_file_has_a_law() -> None:
    for name, record in TABLES.items():
        for key, kind in kinds_of(record).items():
            assert isinstance(law_of(name, key, kind).power, float), f"{name}.{key}"


def test_the_table_of_laws_has_every_unit_of_a_vessel_file() -> None:
    found = {
        kind.form.unit
        for table, record in TABLES.items()
        for key, kind in kinds_of(record).items()
        if (table, key) not in LAW_EXCEPTIONS and table not in PLANT_NAMES
    }

    assert found - {"word", "words", "table", "tables"} == {*VESSEL_UNITS}


def test_every_exception_is_of_a_key_that_is_there() -> None:
    for table, key in LAW_EXCEPTIONS:
        assert key in {item.name for item in fields(TABLES[table])}


# --- the file


@pytest.mark.parametrize("source", BOATS)
def test_a_copy_is_the_boat_itself(source: str) -> None:
    boat, copy = load_vessel(source), made(source, None)

    for item in fields(VesselFile):
        if item.name not in ("path", "text", "defaulted"):
            ours, theirs = getattr(copy, item.name), getattr(boat, item.name)
            if item.name == "remarks":  # which begin with the name of the file
                ours, theirs = ([text.partition(": ")[2] for text in own] for own in (ours, theirs))
            assert ours == theirs, item.name


@pytest.mark.parametrize("source", BOATS)
def test_every_key_in_a_new_file_has_its_meaning_beside_it(source: str) -> None:
    text = vessel_text(source, 30.0, None)

    for record in VESSEL_RECORDS.values():
        for item in fields(record):
            if hasattr(kind_of(item), "words"):
                continue
            assert (
                re.search(rf"^(# )?\[*{item.name}\b|\.{item.name}\]", text, re.MULTILINE)
                or (record.__doc__ or "").partition("\n")[0] in text
            )


def test_a_scaled_file_says_the_law_of_each_number() -> None:
    text = vessel_text("bb2", 60.0, None)

    assert "mass = 2758984.0   # [kg, L^3] mass" in text
    assert "time_constant_s = 5.547002   # [s, L^0.5]" in text
    assert "\ntest_depth_m = 250.0" in text
    assert "bears the same" in text
    assert "X_udot = -0.0012263   # L^3: udot" in text
    assert "[reduction]" not in text  # evidence of another boat


def test_a_boat_starts_no_deeper_than_it_may_go() -> None:
    boat = made("remus100", 100.0)

    assert boat.run.start_depth_m == boat.hull.max_depth_m


def test_a_source_without_a_compact_set_gives_a_boat_without(tmp_path: Path) -> None:
    source = tmp_path / "own.toml"
    source.write_text(without_compact_set(), encoding="utf-8")

    assert not made(str(source), 60.0).has_compact_set
    assert made("bb2", 60.0).has_compact_set


def without_compact_set() -> str:
    """Return the text of bb2 with the tables of its compact set taken out."""
    text = load_vessel("bb2").text
    own = re.compile(r"^\[(compact|compensation\.\w+)\].*?(?=^\[)", re.DOTALL | re.MULTILINE)
    return own.sub("", text)


def test_a_file_that_is_there_is_never_written_over(tmp_path: Path) -> None:
    path = tmp_path / "boat.toml"
    path.write_text("mine", encoding="utf-8")

    with pytest.raises(ConfigError, match="is there already: give a new name"):
        write_new(path, "bb2", 60.0, None)

    assert path.read_text(encoding="utf-8") == "mine"


def test_a_boat_beyond_the_limits_of_a_key_is_refused_by_that_key(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"propeller_diameter = 28\.49003: must be 0.01 to 20 m"):
        write_new(tmp_path / "big.toml", "bb2", 400.0, None)

    assert not (tmp_path / "big.toml").exists()


def test_a_new_boat_has_the_name_that_is_given(tmp_path: Path) -> None:
    told = write_new(tmp_path / "boat.toml", "bb2", 60.0, "Halibut")

    assert load_vessel(str(tmp_path / "boat.toml")).name == "Halibut"
    assert told.endswith(f"next: trainer boat check {tmp_path / 'boat.toml'}")


def test_a_scaled_boat_without_a_name_is_called_as_its_file(tmp_path: Path) -> None:
    path = tmp_path / "halibut.toml"

    write_new(path, "bb2", 60.0, None)

    assert load_vessel(str(path)).name == "halibut"


# --- the boat


Measured = dict[str, tuple[float, str]]


@functools.cache
def flown(source: str, length: float, name: str, equations: str) -> Measured:
    """Return the numbers of a manoeuvre at the own speed of a boat, scaled if there is a length."""
    file = made(source, length) if length else load_vessel(source)
    boat = Submarine(file, own_method(file, equations), Rig())
    manoeuvre = within_limits(find_manoeuvre(name), boat)
    flight = fly_manoeuvre(boat, manoeuvre, file.run.start_speed_kn * KNOT)
    numbers: Any = manoeuvre.measures(flight)
    return {one.name: (one.value, one.unit) for one in numbers if one.value is not None}


@pytest.mark.slow
@pytest.mark.parametrize("equations", ["full", "modified"])
@pytest.mark.parametrize("name", ["turning-circle", "zigzag-20", "zigzag-10"])
@pytest.mark.parametrize(
    ("source", "length"),
    [("bb2", 60.0), ("bb2", 10.0), ("bb2", 120.0), ("sdv-mk9", 20.0), ("remus100", 10.0)],
)
def test_a_scaled_boat_turns_and_weaves_as_its_source_in_lengths(
    source: str, length: float, name: str, equations: str
) -> None:
    factor = length / load_vessel(source).hull.length
    here = flown(source, 0.0, name, equations)
    there = flown(source, length, name, equations)

    compared = [key for key in LIKE if key in here]
    assert compared
    for key in compared:
        value, unit = here[key]
        assert there[key][0] / factor ** POWERS[unit] == pytest.approx(value, rel=TOLERANCE), key

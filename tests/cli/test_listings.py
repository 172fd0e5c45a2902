"""What is shipped is listed, a line each, without loading the core."""

import json

import pytest
from helpers.shell import HEAVY, imported
from helpers.typed import type_command

from trainer.cli import listings
from trainer.cli.main import cli
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import shipped_names
from trainer.config.world.sea import load_sea

LISTS = ("vessels", "seas", "exercises")


def said(*words: str) -> str:
    """Return what a command prints."""
    return type_command(cli, *words).stdout


@pytest.mark.parametrize("what", LISTS)
def test_each_shipped_file_has_a_line_that_fits_a_terminal(what: str) -> None:
    lines = said(what).splitlines()
    names = [line.split()[0] for line in lines if line]

    assert sorted(set(names) & set(shipped_names(what))) == list(shipped_names(what))
    assert len(names) == len(set(names))
    assert all(len(line) <= 79 for line in lines)
    assert set(json.loads(said(what, "--json"))) == set(shipped_names(what))


def test_a_listed_boat_is_the_one_of_its_file() -> None:
    for name, row in json.loads(said("vessels", "--json")).items():
        file = load_vessel(name)
        assert row["name"] == file.name
        assert row["length_m"] == file.hull.length
        assert row["compact_set"] == bool(file.compensation)


def test_a_boat_without_a_compact_set_says_so() -> None:
    table = {"name": "A boat", "kind": "submarine", "vessel": {"length": 60.0}}

    assert not listings.vessel_row(table)["compact_set"]
    assert listings.vessel_row({**table, "compensation": {"modified": {}}})["compact_set"]


def test_a_listed_sea_is_the_one_of_its_file() -> None:
    for name, row in json.loads(said("seas", "--json")).items():
        assert (row["name"], row["sea_state"]) == (
            load_sea(name).name,
            load_sea(name).sea.sea_state,
        )


@pytest.mark.process
@pytest.mark.parametrize("what", LISTS)
def test_a_list_loads_no_core(what: str) -> None:
    names = imported((what,))

    assert "trainer.config.files" in names
    assert not names.intersection(HEAVY)

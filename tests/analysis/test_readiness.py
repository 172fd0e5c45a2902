"""A check ends with the compact set beside the full one, and with what the file lacks."""

import json
import re
from dataclasses import asdict
from pathlib import Path

import pytest
from click.testing import CliRunner
from helpers.lanes import sample_cases
from helpers.nursery import run_trainer
from helpers.places import environment

from trainer.analysis.check_page import Readiness, examine_boat, render_readiness
from trainer.cli.workshop.vessel import check
from trainer.config.boat.vessel import VesselFile, load_vessel, parse_vessel
from trainer.config.boat.vessel_template import vessel_text
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run

BOATS = ("bb2", "sdv-mk9", "remus100")
OF_COMPACT = re.compile(r"^\[(compact|compensation\.\w+)\].*?(?=^\[)", re.DOTALL | re.MULTILINE)
OF_AUTOPILOT = re.compile(r"^\[autopilot\].*?(?=^\[|^# -)", re.DOTALL | re.MULTILINE)


def changed(text: str) -> VesselFile:
    return parse_vessel(text, Path("boat.toml"))


def plain(folder: Path) -> Path:
    """Write bb2 without its compact set; return the file."""
    path = folder / "boat.toml"
    path.write_text(OF_COMPACT.sub("", load_vessel("bb2").text), encoding="utf-8")
    return path


def remedies(found: Readiness) -> dict[str, str]:
    return {lack.what.partition(":")[0]: lack.remedy for lack in found.lacks}


@pytest.mark.long
@pytest.mark.parametrize("name", sample_cases(BOATS, "bb2", "sdv-mk9"))
def test_a_shipped_boat_is_accepted(name: str) -> None:
    done = CliRunner().invoke(check, [name])

    assert done.exit_code == 0, done.output
    assert "The compact set is within tolerance in all of them." in done.output
    assert done.output.isascii()
    assert max(map(len, done.output.splitlines())) <= 79
    for heading in ("COEFFICIENTS", "HULL", "MODES", "STEPS", "TURN"):
        assert re.search(rf"^{heading}\b", done.output, re.MULTILINE), heading


@pytest.mark.slow
@pytest.mark.parametrize(("source", "length"), [("bb2", 60.0), ("bb2", 10.0), ("remus100", 2.0)])
def test_a_scaled_boat_is_accepted(source: str, length: float, tmp_path: Path) -> None:
    path = tmp_path / "boat.toml"
    path.write_text(vessel_text(source, length, None), encoding="utf-8")

    done = CliRunner().invoke(check, [str(path)])

    assert done.exit_code == 0, done.output


@pytest.mark.slow
def test_a_compact_set_out_of_tolerance_is_told_and_not_accepted(tmp_path: Path) -> None:
    text = load_vessel("bb2").text
    wrong = text.replace("N_r = 1.165", "N_r = 0.5", 1)
    assert wrong != text
    path = tmp_path / "boat.toml"
    path.write_text(wrong, encoding="utf-8")

    done = CliRunner().invoke(check, [str(path)])

    assert done.exit_code == 1
    assert "BEYOND" in done.output
    assert "The compact set is NOT within tolerance." in done.output
    assert f"trainer boat reduce {path} --write" in done.output


@pytest.mark.slow
def test_a_change_of_length_alone_is_not_accepted() -> None:
    text = load_vessel("bb2").text
    assert not examine_boat(changed(text.replace("length = 70.2", "length = 60.0", 1))).passed


def test_a_complete_boat_lacks_nothing() -> None:
    found = examine_boat(load_vessel("bb2"))

    assert found.lacks == ()
    assert render_readiness(found).endswith("MISSING: nothing.")


def test_what_is_missing_is_told_with_what_makes_it() -> None:
    found = examine_boat(changed(OF_AUTOPILOT.sub("", load_vessel("bb2").text)))

    assert remedies(found)["gains"] == "trainer boat gains boat.toml >> boat.toml"


@pytest.mark.long
def test_a_boat_without_tanks_is_told_where_to_take_them() -> None:
    told = remedies(examine_boat(load_vessel("remus100")))

    assert "trainer boat new like.toml --from bb2 --length 1.33" in told["[ballast]"]
    assert told["periscope_depth_m"] == "a line in [run]"


def test_the_figures_are_json() -> None:
    wrong = load_vessel("bb2").text.replace("N_r = 1.048", "N_r = 0", 1)

    assert json.dumps(asdict(examine_boat(changed(wrong))), allow_nan=False)


# --- a boat without a compact set


def test_a_boat_without_a_compact_set_is_flown_by_the_full_one(tmp_path: Path) -> None:
    path = plain(tmp_path)

    plan = plan_run(RunOptions(vessel=str(path)))

    assert plan.method.equations == "full"
    assert plan.note == (
        "boat.toml has no compact set of its own: the full set is flown; "
        "trainer boat reduce makes one"
    )


@pytest.mark.process
def test_a_run_begins_by_saying_so(tmp_path: Path) -> None:
    line = ["run", "--headless", "--speed", "max", "--duration", "5", "--no-record", "--verbose"]

    done = run_trainer(*line, "--vessel", str(plain(tmp_path)), env=environment(), timeout=300)

    assert done.returncode == 0, done.stderr
    assert "trainer: boat.toml has no compact set of its own: the full set is flown" in done.stderr
    assert "computed    full set" in done.stdout


def test_an_order_for_the_compact_equations_is_obeyed_all_the_same(tmp_path: Path) -> None:
    options = RunOptions(vessel=str(plain(tmp_path)), equations="modified")

    plan = plan_run(options)

    assert plan.method.equations == "modified"
    assert plan.note == ""


@pytest.mark.parametrize("name", BOATS)
def test_a_shipped_boat_is_flown_by_its_compact_set(name: str) -> None:
    plan = plan_run(RunOptions(vessel=name))

    assert plan.method.equations == "modified"
    assert plan.note == ""


def test_a_check_says_that_there_is_no_compact_set(tmp_path: Path) -> None:
    done = CliRunner().invoke(check, [str(plain(tmp_path))])

    assert done.exit_code == 0, done.output
    assert "COMPACT SET: the file has none of its own; the full set is flown." in done.output
    assert f"trainer boat reduce {tmp_path / 'boat.toml'} --write" in done.output

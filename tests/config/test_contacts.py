"""The ships of an exercise file: what is read, and each thing that is refused by its name."""

from pathlib import Path

import pytest
from helpers.sessions import start_exercise, start_plan

from trainer.boat.world.contacts import contacts_in
from trainer.config.exercise.exercise import parse_exercise
from trainer.config.files import ConfigError
from trainer.config.world.contacts import SHIP_TYPES
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run
from trainer.units import KNOT

HEAD = 'schema = "exercise/1"\nname = "Ships"\nbriefing = "Ships."\nduration_s = 60\n'
SHIP = '[[contact]]\nname = "one"\ntype = "cargo"\npoints = [[2000, 1000], [2000, 9000]]\n'


def write(folder: Path, tables: str) -> Path:
    """Return the path of an exercise with these tables."""
    path = folder / "ships.toml"
    path.write_text(HEAD + tables)
    return path


def refused(folder: Path, tables: str) -> tuple[str, ...]:
    """Return why an exercise cannot begin."""
    try:
        plan = plan_run(RunOptions(exercise=str(write(folder, tables))))
        start_plan(plan)
    except ConfigError as wrong:
        return wrong.problems
    return ()


@pytest.mark.parametrize(
    ("tables", "told"),
    [
        (SHIP.replace("cargo", "carrgo"), 'line 7: [contact[0]] type = "carrgo": must be'),
        (SHIP.replace('"one"', '"One"'), 'name = "One": must be small letters'),
        (SHIP.replace('"one"', '"add"'), 'name = "add": must be small letters'),
        (SHIP + "speed_kn = 21\n", "speed_kn = 21.0: a cargo makes 20 kn"),
        (SHIP + "speed_kn = [5, 6]\n", "speed_kn = [5.0, 6.0]: must be one number, or 1"),
        (SHIP + "mmsi = 1234\n", "mmsi = 1234: must be a whole number, 100000000 to 999999999"),
        (SHIP + "mmsi = 211000001.5\n", "mmsi = 211000001.5: must be a whole number"),
        (SHIP + "course_deg = 90\n", "course_deg = 90.0: goes with one point alone"),
        (SHIP + "drifts = 1\n", "drifts = 1: must be true or false"),
        (
            SHIP + 'drifts = true\nstatus = "at anchor"\n',
            'drifts = true: does not go with status = "at anchor"',
        ),
        (SHIP + 'status = "sunk"\n', 'status = "sunk": must be under way or'),
        (SHIP + "heading = 3\n", "heading = 3: no such key"),
        (SHIP.replace("[2000, 9000]", "[2000]"), "points[1] = [2000]: must be a pair"),
        (SHIP.replace("[2000, 9000]", "[2000, 1e9]"), "points[1][1] = 1000000000.0: must be"),
        (
            SHIP + "mmsi = 211000001\n" + SHIP.replace('"one"', '"two"') + "mmsi = 211000001\n",
            "mmsi = 211000001: another [[contact]] has it",
        ),
        (
            SHIP.replace("[2000, 9000]", "[2100, 1000], [2100, 9000]") + "speed_kn = 9\n",
            "leg 1 is 100 m: its turns of radius 350 m take 350 m",
        ),
        (
            SHIP.replace("9000]", "3000], [2000, 3400]") + "speed_kn = [2, 18]\n",
            "18 kn is not reached",
        ),
        (SHIP + "[contacts]\ncpa = 3\n", "[contacts] cpa = 3: no such key; nearest is cpa_m"),
        (SHIP + '[contacts]\ncollision = "sink"\n', 'collision = "sink": must be freeze or end'),
        ("[[contact]]\nname = 3\n", "[contact[0]] lacks type, points"),
    ],
)
def test_what_is_wrong_with_a_ship_is_refused_by_its_name(
    tmp_path: Path, tables: str, told: str
) -> None:
    said = refused(tmp_path, tables)
    assert all(each.startswith("ships.toml:") for each in said)
    assert any(told in each for each in said)


def test_a_ship_in_the_boats_hull_is_refused(tmp_path: Path) -> None:
    near = "[initial]\ndepth_m = 10\n" + SHIP.replace("[2000, 1000]", "[0, 0]")
    assert "points[0] = [0, 0]: one starts in the boat's own hull" in refused(tmp_path, near)[0]


def test_a_ship_in_anothers_hull_is_refused(tmp_path: Path) -> None:
    other = SHIP.replace('"one"', '"two"').replace("[2000, 1000]", "[2010, 1010]")
    assert "two starts in the hull of one" in refused(tmp_path, SHIP + other)[0]


def test_all_that_is_wrong_with_the_ways_of_ships_is_told(tmp_path: Path) -> None:
    short = SHIP.replace("[2000, 9000]", "[2100, 1000], [2100, 9000]")
    first, second = refused(tmp_path, short + short.replace('"one"', '"two"'))
    assert "[contact[0]] points" in first
    assert "[contact[1]] points" in second


def test_what_a_file_leaves_out_is_as_its_type_has_it() -> None:
    text = HEAD + '[[contact]]\nname = "net"\ntype = "fishing"\npoints = [[900, 0]]\nspeed_kn = 3\n'
    (ship,) = parse_exercise(text, Path("x.toml")).world["contact"]
    assert (ship.status, ship.course, ship.speeds) == ("fishing", 0.0, (3.0 * KNOT,))
    (ship,) = parse_exercise(text.replace("= 3", "= 0"), Path("x.toml")).world["contact"]
    assert ship.status == "at anchor"


@pytest.mark.parametrize("name", SHIP_TYPES)
def test_every_type_of_ship_sails_and_is_seen(tmp_path: Path, name: str) -> None:
    path = write(tmp_path, SHIP.replace("cargo", name) + "speed_kn = 5\nmmsi = 211000001\n")
    boat = start_exercise(path)
    contacts = contacts_in(boat)
    assert contacts is not None
    (seen,) = contacts.seen(100)
    assert (seen.north, seen.east) == pytest.approx((2000.0, 1000.0 + 50.0 * 5.0 * KNOT))
    assert seen.mast >= seen.height > 0.0
    assert seen.lights

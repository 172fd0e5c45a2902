"""Ships that answer their rudder: courses reached, circles at every speed, the same again."""

import math
from pathlib import Path

import pytest

from trainer.analysis.manoeuvres.nomoto_ship import NomotoShip
from trainer.boat.world.contacts import contacts_of
from trainer.boat.world.steered import SteeredContact, SteeredNomoto, SteeredState
from trainer.config.files import ConfigError, Position, remembering
from trainer.config.ship.nomoto import NomotoFile, nomoto_text_of
from trainer.config.world.contacts import read_contacts
from trainer.units import KNOT

STEP = 0.5  # [s]


def ship(**changes: float) -> NomotoFile:
    """Return a cargo ship of 161 m, stable on its course."""
    numbers = {
        "length_m": 161.0,
        "speed_kn": 15.0,
        "K_per_s": -0.18,
        "T1_s": 118.0,
        "T2_s": 7.8,
        "T3_s": 18.5,
        "rudder_limit_deg": 35.0,
        "rudder_rate_deg_s": 2.5,
        "step_s": 0.5,
    }
    return NomotoFile(schema="nomoto/1", name="a ship", **{**numbers, **changes})


def steered(speed: float, course: float, file: NomotoFile | None = None) -> SteeredContact:
    start = SteeredState(0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0)
    return SteeredContact(SteeredNomoto(file or ship()), STEP, 0.0, start, course, speed)


@pytest.mark.parametrize("course", [math.radians(60.0), math.radians(-120.0), 0.0])
def test_a_course_is_reached_and_kept(course: float) -> None:
    going = steered(15.0 * KNOT, course)
    for time in (3000.0, 3100.0):
        now = going.at(time)
        assert math.remainder(now.course - course, math.tau) == pytest.approx(0.0, abs=2e-3)
        assert now.turning == pytest.approx(0.0, abs=1e-5)


def test_the_turn_settles_at_the_rate_that_the_gain_gives() -> None:
    """Ordered far round, a slow ship's rudder stays at its limit: r = -K delta."""
    file = ship(rudder_limit_deg=1.0)
    rates = [steered(15.0 * KNOT, 3.0, file).at(time).turning for time in (650.0, 700.0)]
    assert rates == pytest.approx([0.18 * math.radians(1.0)] * 2, rel=2e-2)


def test_a_rudder_gives_the_same_circle_at_half_the_speed() -> None:
    file = ship(rudder_limit_deg=1.0)
    circles = [
        speed / steered(speed, 3.0, file).at(time).turning
        for speed, time in ((15.0 * KNOT, 700.0), (7.5 * KNOT, 1400.0))
    ]
    assert circles[0] == pytest.approx(circles[1], rel=1e-3)


def test_a_turn_does_not_depend_on_the_step() -> None:
    """A rudder that is held still within each step would come half a step late."""
    file, speed = ship(rudder_limit_deg=10.0), 15.0 * KNOT
    start = SteeredState(0.0, 0.0, 0.0, speed, 0.0, 0.0, 0.0)
    headings = [
        math.degrees(
            SteeredContact(SteeredNomoto(file), step, 0.0, start, 3.0, speed).at(40.0).course
        )
        for step in (STEP, STEP / 32)
    ]
    assert headings[0] == pytest.approx(headings[1], abs=0.02)


def test_a_nomoto_ship_that_is_met_turns_as_one_in_a_manoeuvre() -> None:
    met = steered(15.0 * KNOT, 3.0, ship(rudder_limit_deg=5.0))
    flown = NomotoShip(ship(rudder_limit_deg=5.0))
    flown.start(15.0 * KNOT)
    flown.order("rudder", math.radians(5.0))
    for tick in range(1, 121):
        flown.advance()
        now = met.at(tick * STEP)
        there = dict(zip(flown.columns, flown.observe(), strict=True))
        assert (now.course, now.turning, now.rudder) == pytest.approx(
            (there["psi"], there["r"], there["delta_r"]), rel=1e-12
        )


def test_an_order_goes_on_from_where_the_ship_is() -> None:
    before = steered(7.0, 0.5)
    after = before.then(100.0, 2.0, 3.0)
    assert after.at(100.0) == before.at(100.0)
    assert after.at(1000.0).speed == 3.0
    moved = after.moved(200.0, 50.0, -60.0)
    assert moved.at(200.0)[:2] == (50.0, -60.0)
    assert moved.at(200.0)[2:] == after.at(200.0)[2:]


class Boat:
    """What a ship needs of a boat: its step."""

    class method:  # noqa: N801  as a boat has it
        step = STEP


def exercise(folder: Path, file: NomotoFile) -> object:
    """Return the ships of an exercise with a file of an identified one."""
    (folder / "ship.toml").write_text(nomoto_text_of(file, "a test", {}))
    row = {"name": "one", "type": "cargo", "points": [[100, 200]], "course_deg": 90, "speed_kn": 12}
    rows = [{**row, "nomoto": "./ship.toml"}]
    return read_contacts(rows, Position("x.toml", "contact"), folder / "x.toml")


def test_an_exercise_has_an_identified_ship(tmp_path: Path) -> None:
    contacts = contacts_of(Boat, {"contact": exercise(tmp_path, ship())})
    (seen,) = contacts.seen(200)
    assert (seen.north, seen.east) == pytest.approx((100.0, 200.0 + 100.0 * 12.0 * KNOT))


def test_a_ship_that_nobody_can_steer_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"ship.toml: K_per_s = 0.18: one cannot be steered"):
        exercise(tmp_path, ship(K_per_s=0.18))


def test_a_recording_keeps_the_file_of_the_ship(tmp_path: Path) -> None:
    with remembering() as texts:
        exercise(tmp_path, ship())
    assert any('schema = "nomoto/1"' in text for text in texts.values())

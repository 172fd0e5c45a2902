"""Ships that are not linear among the contacts: courses reached, drift, speed, what is refused."""

import math
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from helpers.orders import read_order
from helpers.ships import NOMOTO_SHIP

from trainer.boat.ship.motion import ShipMotion
from trainer.boat.world.contacts import Contacts, contacts_of
from trainer.boat.world.steered import SteeredContact
from trainer.boat.world.steered_ship import ENGINE_RISE_S, SteeredShip
from trainer.config.files import ConfigError, Position, read_text, remembering, shipped_path
from trainer.config.ship.ship import ShipFile, load_ship
from trainer.config.world.contacts import read_contacts
from trainer.io.orders.grammar import Refused, Reply
from trainer.units import KNOT

STEP = 0.5  # [s]
SPEED = 15.0 * KNOT


@pytest.fixture(scope="module")
def file() -> ShipFile:
    """Return the Mariner, as it is shipped."""
    return load_ship(shipped_path("ships", "mariner"))


@pytest.fixture(scope="module")
def ship(file: ShipFile) -> SteeredShip:
    return SteeredShip(file)


def going(ship: SteeredShip, course: float, speed: float = SPEED) -> SteeredContact:
    return SteeredContact(ship, STEP, 0.0, ship.begin(0.0, 0.0, 0.0, SPEED), course, speed)


@pytest.mark.parametrize("course", [math.radians(60.0), math.radians(-120.0), 0.0])
def test_a_course_is_reached_and_kept(ship: SteeredShip, course: float) -> None:
    way = going(ship, course)
    for time in (900.0, 1000.0):
        now = way.at(time)
        assert math.remainder(now.course - course, math.tau) == pytest.approx(0.0, abs=2e-3)
        assert now.turning == pytest.approx(0.0, abs=1e-5)
    beyond = max(abs(way.at(t).course) for t in np.arange(0.0, 1000.0, STEP))
    assert beyond <= abs(course) + math.radians(1.0)


def test_it_loses_speed_and_drifts_in_the_turn_and_gets_both_back(ship: SteeredShip) -> None:
    way = going(ship, 2.5)
    turning = way.at(120.0)
    assert turning.speed < 0.85 * SPEED
    assert turning.sway < -0.05 * SPEED
    assert way.at(1500.0).speed == pytest.approx(SPEED, rel=1e-3)


def test_with_the_rudder_held_it_goes_as_a_manoeuvre_has_it(
    file: ShipFile, ship: SteeredShip
) -> None:
    """Far off its course the law's rudder lies at its limit, as in a turning circle."""
    motion, way = ShipMotion(file), going(ship, math.pi - 1e-3)
    now = motion.straight(SPEED)
    for _ in range(40):
        now = motion.after(now, 1e9, STEP) or now
    there = way.at(40 * STEP)
    assert (there.north, there.east) == pytest.approx((now.north, now.east))
    assert there.rudder == pytest.approx(math.radians(file.dimensions.rudder_limit_deg))


def test_its_propeller_takes_a_minute_to_the_revolutions_ordered(
    file: ShipFile, ship: SteeredShip
) -> None:
    way = going(ship, 0.0, 10.0 * KNOT)
    assert file.result
    slower = file.result.revolutions_per_s / ENGINE_RISE_S * 2.0
    assert way.at(2.0).turns == pytest.approx(way.at(0.0).turns - slower)
    assert way.at(3000.0).speed == pytest.approx(10.0 * KNOT, rel=1e-3)


def test_the_numbers_are_the_same_in_whatever_order_they_are_asked_for(ship: SteeredShip) -> None:
    one, other = going(ship, 1.0), going(ship, 1.0)
    late = one.at(400.0)
    for time in (10.0, 399.5, 3.0, 400.0):
        assert other.at(time) == one.at(time)
    assert other.at(400.0) == late
    assert one.then(100.0, 2.0, None).at(100.0) == one.at(100.0)


class Boat:
    """What ships need of a boat: its step, and no current."""

    class method:  # noqa: N801  as a boat has it
        step = STEP

    class world:  # noqa: N801
        parts: ClassVar[dict[str, object]] = {}


ROW = {"name": "one", "type": "cargo", "points": [[100, 200]], "course_deg": 90, "speed_kn": 15}


def exercise(folder: Path, **changes: object) -> Contacts:
    """Return the ships of an exercise with one whose file is beside it."""
    (folder / "found.toml").write_text(
        read_text(shipped_path("ships", "mariner")), encoding="utf-8"
    )
    given = {**ROW, "ship": "./found.toml", **changes}
    rows = [{key: value for key, value in given.items() if value is not None}]
    read = read_contacts(rows, Position("x.toml", "contact"), folder / "x.toml")
    return contacts_of(Boat, {"contact": read})


def order(contacts: Contacts, text: str, tick: int) -> Reply:
    given = read_order(text)
    return contacts.obey(given, tick)


def test_an_exercise_has_such_a_ship_and_its_way_over_the_ground_is_with_its_drift(
    tmp_path: Path,
) -> None:
    contacts = exercise(tmp_path)
    (seen,) = contacts.seen(200)
    assert seen.east == pytest.approx(200.0 + 100.0 * SPEED, rel=1e-6)
    assert "course" in str(order(contacts, "contact one course 210", 200))
    before, now, after = (contacts.seen(tick)[0] for tick in (439, 440, 441))
    north, east = after.north - before.north, after.east - before.east
    assert now.course == pytest.approx(math.atan2(east, north) % math.tau, abs=1e-3)
    assert now.speed == pytest.approx(math.hypot(north, east) / (2.0 * STEP), rel=1e-3)
    assert abs(math.remainder(now.course - now.heading, math.tau)) > math.radians(3.0)


def test_a_shipped_ship_goes_by_its_name(tmp_path: Path) -> None:
    assert exercise(tmp_path, ship="mariner").seen(0)[0].speed == pytest.approx(SPEED, rel=1e-5)


def test_a_recording_keeps_the_file_of_the_ship(tmp_path: Path) -> None:
    with remembering() as texts:
        exercise(tmp_path)
    assert any('schema = "ship/1"' in text for text in texts.values())


BAD: dict[str, tuple[dict[str, object], str]] = {
    "two ships": ({"nomoto": "./nomoto.toml"}, r"ship = .*: goes without nomoto: give one"),
    "no way on": ({"speed_kn": 0}, r"ship = .*: goes with speed_kn: it has way on"),
    "late": ({"starts_s": 60}, r"starts_s = 60.0: goes without ship"),
    "a way of points": (
        {"points": [[0, 0], [5000, 0]]},
        r"ship = .*: goes with one point",
    ),
    "a Nomoto ship": ({"ship": "./nomoto.toml"}, "nomoto.toml: is a Nomoto ship: one has it as"),
    "not one": (
        {"ship": None, "nomoto": "./found.toml"},
        "found.toml: is a ship that is not linear",
    ),
    "no such file": ({"ship": "./lost.toml"}, "lost.toml"),
    "no such name": ({"ship": "marinr"}, "mariner"),
}


@pytest.mark.parametrize("kind", BAD)
def test_what_cannot_be_is_refused(tmp_path: Path, kind: str) -> None:
    changes, told = BAD[kind]
    (tmp_path / "nomoto.toml").write_text(NOMOTO_SHIP, encoding="utf-8")
    with pytest.raises(ConfigError, match=told):
        exercise(tmp_path, **changes)


def test_a_ship_that_no_fit_has_written_cannot_sail(tmp_path: Path) -> None:
    text = read_text(shipped_path("ships", "mariner")).split("[result]")[0]
    (tmp_path / "bare.toml").write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError, match=r"bare.toml: lacks \[result\]"):
        exercise(tmp_path, ship="./bare.toml")


@pytest.mark.slow
def test_a_ship_that_has_lost_its_way_lies_there_and_says_why(tmp_path: Path) -> None:
    contacts = exercise(tmp_path)
    assert "speed" in str(order(contacts, "contact one speed 0", 10))
    assert contacts.seen(10_000)[0].speed > 0.0
    at_last = 120_000  # ticks: without a propeller it takes hours
    seen, later = (contacts.seen(at_last + more)[0] for more in (0, 1000))
    assert seen.speed == 0.0
    assert (later.north, later.east) == (seen.north, seen.east)
    refused = order(contacts, "contact one speed 8", at_last)
    assert isinstance(refused, Refused)
    assert "it has lost its way" in refused.reason

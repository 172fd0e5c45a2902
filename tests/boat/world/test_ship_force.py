"""The pull of ships near: the limits of theory, symmetry, sizes, nothing where it is off."""

import math
from pathlib import Path

import numpy as np
import pytest
from helpers.boats import make_boat, take_ticks
from helpers.sessions import start_exercise

from trainer.boat.boat import Boat
from trainer.boat.world.hulls import Pose
from trainer.boat.world.ship_force import (
    EVEN_STATIONS,
    MAX_PULLING_SHIPS,
    STATION_WEIGHTS,
    PassingShip,
    ShipPull,
    pull_share,
    water_acceleration,
)
from trainer.boat.world.world import World
from trainer.config.world.contacts import SHIP_TYPES
from trainer.session.past.options import RunOptions
from trainer.session.past.plan import plan_run

TANKER = SHIP_TYPES["tanker"]
SPEED = 15.0 * 1852.0 / 3600.0  # [m/s]
HEAD = 'schema = "exercise/1"\nname = "Ships"\nbriefing = "Ships."\nduration_s = 1200\n'


@pytest.fixture(scope="module")
def boat() -> Boat:
    return make_boat("bb2", "modified")


def test_far_away_a_ship_is_a_dipole_of_its_double_body() -> None:
    """The dipole's moment is 2 Cb L B T U; its water is accelerated by -U dv/dx."""
    moment = 2.0 * TANKER.block * TANKER.length * TANKER.beam * TANKER.draught * SPEED
    r = np.array([20000.0, 15000.0, 2000.0])
    h = 1.0

    def velocity(at: np.ndarray) -> np.ndarray:
        far = math.sqrt(float(at @ at))
        axis = np.array([1.0, 0.0, 0.0])
        found: np.ndarray = moment / (4.0 * math.pi) * (3.0 * at[0] * at / far**5 - axis / far**3)
        return found

    step = np.array([h, 0.0, 0.0])
    expected = -SPEED * (velocity(r + step) - velocity(r - step)) / (2.0 * h)
    found = water_acceleration((TANKER, 0.0, 0.0, 0.0, SPEED), r[None, :])[0]
    assert found == pytest.approx(expected, rel=1e-3)


def peaks(boat: Boat, abeam: float, depth: float) -> np.ndarray:
    """Return the largest forces [t] and moments [t m] as a tanker passes."""
    pull = ShipPull(boat)
    pose = Pose(0.0, 0.0, depth, 0.0, 0.0, 0.0)
    passing = [
        pull.whole(pose, (TANKER, float(north), abeam, 0.0, SPEED)) for north in range(-400, 401, 5)
    ]
    found: np.ndarray = np.abs(passing).max(axis=0) / 9810.0
    return found


@pytest.mark.parametrize(
    ("abeam", "depth", "place", "tonnes"),
    [(60.0, 17.5, 1, 13.0), (100.0, 17.5, 1, 4.5), (200.0, 17.5, 1, 0.6), (0.0, 40.0, 2, 25.0)],
)
def test_a_tanker_pulls_as_much_as_another_program_has_it(
    boat: Boat, abeam: float, depth: float, place: int, tonnes: float
) -> None:
    """Its numbers were told to two digits, of a boat with slightly other added masses."""
    assert peaks(boat, abeam, depth)[place] == pytest.approx(tonnes, rel=0.15)


def test_a_ship_on_the_other_side_pulls_the_other_way(boat: Boat) -> None:
    pull, pose = ShipPull(boat), Pose(0.0, 0.0, 17.5, 0.0, 0.0, 0.0)
    right = pull.whole(pose, (TANKER, 30.0, 80.0, 0.0, SPEED))
    left = pull.whole(pose, (TANKER, 30.0, -80.0, 0.0, SPEED))
    assert right * np.array((1, -1, 1, 1, 1, -1)) == pytest.approx(left, rel=1e-12)
    assert abs(right[1]) > 1e4


def test_moments_are_those_of_the_forces_along_the_axis(boat: Boat) -> None:
    """Each station's force, by the water's acceleration there, at its arm: r x F."""
    pull, pose = ShipPull(boat), Pose(0.0, 0.0, 20.0, 0.0, 0.0, 0.0)
    ship: PassingShip = (TANKER, 40.0, 70.0, 0.2, SPEED)
    arms = np.stack(
        [EVEN_STATIONS * boat.file.hull.length, *[np.zeros(EVEN_STATIONS.size)] * 2], axis=1
    )
    c = boat.vessel
    masses = [c.buoyancy / c.g - c[name] for name in ("X_udot", "Y_vdot", "Z_wdot")]
    points = arms + np.array((0.0, 0.0, 20.0))
    forces = STATION_WEIGHTS[:, None] * water_acceleration(ship, points) * np.array(masses, float)
    found = pull.whole(pose, ship)
    assert found[:3] == pytest.approx(forces.sum(axis=0), rel=1e-9)
    assert found[3:] == pytest.approx(np.cross(arms, forces).sum(axis=0), rel=1e-9)
    assert abs(found[4]) > 1e5
    assert abs(found[5]) > 1e5


def test_only_the_relative_place_matters(boat: Boat) -> None:
    """The whole scene turned and moved gives the same forces in body axes."""
    pull = ShipPull(boat)
    first = pull.whole(Pose(0.0, 0.0, 20.0, 0.0, 0.0, 0.0), (TANKER, 0.0, 90.0, 0.3, SPEED))
    turned = Pose(500.0, -200.0, 20.0, 0.0, 0.0, 0.5 * math.pi)
    there: PassingShip = (TANKER, 410.0, -200.0, 0.3 + 0.5 * math.pi, SPEED)
    assert pull.whole(turned, there) == pytest.approx(first, rel=1e-9, abs=1e-3)


def test_a_pull_fades_out_and_comes_of_the_nearest_alone(boat: Boat) -> None:
    length = boat.file.hull.length
    mean = 0.5 * (TANKER.length + length)
    assert (pull_share(mean, TANKER, length), pull_share(1.5 * mean, TANKER, length)) == (1.0, 0.0)
    assert pull_share(1.25 * mean, TANKER, length) == pytest.approx(0.5)
    pull, pose = ShipPull(boat), Pose(0.0, 0.0, 17.5, 0.0, 0.0, 0.0)
    ships: list[PassingShip] = [
        (TANKER, 10.0, 60.0 + 5.0 * i, 0.0, SPEED) for i in range(MAX_PULLING_SHIPS + 1)
    ]
    assert pull.on(pose, ships) == pytest.approx(pull.on(pose, ships[:-1]), rel=1e-15)


PASSING = """
[initial]
speed_kn = 5
depth_m = 25
[[contact]]
name = "big"
type = "tanker"
points = [[-600, 60]]
speed_kn = 15
[contacts]
collision = "call"
"""


def flown(folder: Path, force: str) -> Boat:
    """Return the boat after a tanker has passed."""
    path = folder / f"{force}.toml"
    path.write_text(HEAD + PASSING + f'force = "{force}"\n')
    boat = start_exercise(path)
    take_ticks(boat, 400)
    return boat


def test_force_is_off_unless_an_exercise_asks_for_it(tmp_path: Path) -> None:
    without, pulled = flown(tmp_path, "off"), flown(tmp_path, "on")
    assert not without.state.ship_force.any()
    free = Boat(without.file, without.method)
    plan = plan_run(RunOptions(exercise=str(tmp_path / "off.toml")))
    plan.start(free)
    free.world = World()
    take_ticks(free, 400)
    assert free.records.state.tobytes() == without.records.state.tobytes()
    assert abs(float(pulled.state.y) - float(without.state.y)) > 0.05

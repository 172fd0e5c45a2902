"""Ships that come near: closest approach, its calls, collisions and what they do."""

import math
import time
from pathlib import Path

import numpy as np
import pytest

from trainer.boat.boat import Boat
from trainer.boat.helm import obey
from trainer.boat.world.encounters import (
    EncounterMonitor,
    Own,
    closest_approach,
    plot,
)
from trainer.boat.world.hulls import OwnHull, Pose, overlap
from trainer.boat.world.tracks import Situation
from trainer.config.contacts import TYPES
from trainer.io.orders.grammar import Order, Refused, parse
from trainer.session.options import RunOptions
from trainer.session.plan import plan_run

HEAD = 'schema = "exercise/1"\nname = "Ships"\nbriefing = "Ships."\nduration_s = 1200\n'
LIMIT = 500.0  # [m]


def under_way(folder: Path, tables: str, depth: float = 60.0) -> Boat:
    """Return a boat that goes north at 6 knots among the ships of an exercise."""
    path = folder / "ships.toml"
    start = f"[initial]\nspeed_kn = 6\ndepth_m = {depth}\n"
    path.write_text(f"{HEAD}{start}{tables}")
    plan = plan_run(RunOptions(exercise=str(path)))
    boat = Boat(plan.file, plan.method)
    plan.start(boat)
    return boat


def ordered(boat: Boat, text: str) -> str:
    """Return how a boat's world answers an order; refusals begin with one."""
    order = parse(text)
    assert isinstance(order, Order)
    reply = obey(boat, order)
    return f"refused: {reply.reason}" if isinstance(reply, Refused) else reply


def one(north: float, east: float, course: float, speed: float, turning: float = 0.0) -> Situation:
    """Return one ship."""
    return Situation(*(np.array([each]) for each in (north, east, course, speed, turning)))


def test_the_closest_approach_of_the_textbook() -> None:
    # r (0, 2000), v (2, -10): t = 20000/104, |r + v t| = |(384.6, 76.9)|
    closest, until = closest_approach(*(np.array([each]) for each in (0.0, 2000.0, 2.0, -10.0)))
    assert until[0] == pytest.approx(192.31, abs=0.005)
    assert closest[0] == pytest.approx(392.23, abs=0.005)


def test_without_relative_speed_there_is_no_time_of_closest_approach() -> None:
    seen = plot(Own(0.0, 0.0, 0.0, 5.0, 0.0), one(300.0, 400.0, 0.0, 5.05), LIMIT)
    assert (seen.closest[0], seen.range[0]) == pytest.approx((500.0, 500.0))
    assert math.isnan(seen.until[0])
    assert not seen.turning[0]


def test_a_ship_that_has_passed_has_its_closest_approach_behind() -> None:
    seen = plot(Own(0.0, 0.0, 0.0, 5.0, 0.0), one(-1000.0, 200.0, math.pi, 5.0), LIMIT)
    assert seen.until[0] == pytest.approx(-100.0)
    assert seen.closest[0] == pytest.approx(200.0)


def test_a_turning_ship_is_foreseen_on_its_arc() -> None:
    """It circles with a radius of 500 m: never nearer than that circle, which a line would cut."""
    ship = one(0.0, 1500.0, -0.5 * math.pi, 5.0, 0.01)
    seen = plot(Own(0.0, 0.0, 0.0, 0.0, 0.0), ship, LIMIT)
    # the circle's middle is 500 m to starboard of the ship, that is north of it
    assert seen.turning[0]
    assert seen.closest[0] == pytest.approx(math.hypot(500.0, 1500.0) - 500.0, abs=1.0)
    straight = plot(Own(0.0, 0.0, 0.0, 0.0, 0.0), one(0.0, 1500.0, -0.5 * math.pi, 5.0), LIMIT)
    assert straight.closest[0] == pytest.approx(0.0, abs=1e-9)


CROSSING = """
[[contact]]
name = "ferry"
type = "ferry"
points = [[1000, 2000]]
course_deg = 270
speed_kn = 12
[contacts]
cpa_m = 800
"""


def fly(boat: Boat, monitor: EncounterMonitor, seconds: float) -> list[str]:
    """Return what was called out meanwhile."""
    told = []
    for _ in range(round(seconds / boat.method.step)):
        assert boat.tick() == 0
        told += monitor.look(boat)
    return told


def test_an_approach_is_called_once_and_again_when_it_changes(tmp_path: Path) -> None:
    boat = under_way(tmp_path, CROSSING)
    monitor = EncounterMonitor.over(boat)
    told = fly(boat, monitor, 30.0)
    assert [each.split(": ")[1] for each in told] == ["CLOSEST APPROACH"]
    assert "ferry" in told[0]
    assert ordered(boat, "contact ferry course 285") == "contact ferry course 285"
    assert fly(boat, monitor, 60.0)


def test_the_measured_approach_is_the_least_distance_between_ticks_too(tmp_path: Path) -> None:
    boat = under_way(tmp_path, CROSSING)
    monitor = EncounterMonitor.over(boat)
    fine = math.inf
    contacts = monitor.contacts
    assert contacts is not None
    before = float(boat.state.x)
    for tick in range(600):
        assert boat.tick() == 0
        monitor.look(boat)
        now = float(boat.state.x)
        for part in range(10):
            there = contacts.fleet(0).at((tick + part / 10) * boat.method.step)
            ahead = before + part / 10 * (now - before)
            fine = min(fine, float(np.hypot(there.north - ahead, there.east - boat.state.y)[0]))
        before = now
    assert monitor.closest["ferry"][0] == pytest.approx(fine, abs=0.5)
    assert monitor.account().startswith("ferry ")


AHEAD = """
[[contact]]
name = "anchored"
type = "tanker"
points = [[200, 0]]
course_deg = 90
"""


@pytest.mark.parametrize(("depth", "struck"), [(17.5, True), (60.0, False)])
def test_a_boat_runs_into_a_ship_in_its_way_and_passes_below_it(
    tmp_path: Path, depth: float, *, struck: bool
) -> None:
    boat = under_way(tmp_path, AHEAD, depth)
    told = fly(boat, EncounterMonitor.over(boat), 120.0)
    assert ["COLLISION with anchored, a tanker" in each for each in told].count(True) == struck


def test_the_sail_alone_touches_a_keel(tmp_path: Path) -> None:
    """A tanker draws 11 m; the sail of bb2 is 11.4 m above its origin, the hull 6 m at most."""
    hull = OwnHull.of(under_way(tmp_path, ""))
    pose = Pose(0.0, 0.0, 21.0, 0.0, 0.0, 0.0)
    tanker = TYPES["tanker"]
    assert hull.touches(pose, tanker, 0.0, 0.0, 0.5 * math.pi)
    assert not hull.touches(pose, tanker, -40.0, 0.0, 0.5 * math.pi)  # the sail is ahead of it
    assert not hull.touches(pose._replace(depth=23.0), tanker, 0.0, 0.0, 0.5 * math.pi)


def test_nothing_is_passed_over_between_two_looks(tmp_path: Path) -> None:
    """A yacht's beam is gone in a fraction of a tick."""
    hull = OwnHull.of(under_way(tmp_path, ""))
    yacht = TYPES["yacht"]
    assert hull.looks(30.0, yacht) >= 30.0 / (0.25 * yacht.beam)


def test_ships_lie_in_each_other_or_beside() -> None:
    tug = TYPES["tug"]
    across = (0.0, 20.0, 0.5 * math.pi, tug)
    assert overlap((0.0, 0.0, 0.0, tug), across)
    assert not overlap((0.0, 0.0, 0.0, tug), (0.0, 12.0, 0.0, tug))


def test_without_ships_nothing_is_watched(tmp_path: Path) -> None:
    boat = under_way(tmp_path, "")
    monitor = EncounterMonitor.over(boat)
    assert fly(boat, monitor, 5.0) == []
    assert monitor.nearest[1] == math.inf
    assert not boat.world.acts


def cost(folder: Path, ships: int) -> float:
    """Return the least time [s] of a look at so many ships under way."""
    rows = (
        f'[[contact]]\nname = "s{i}"\ntype = "cargo"\nspeed_kn = 12\n'
        f"points = [[{3000 + 60 * i}, -4000], [{9000 + 60 * i}, 5000]]\n"
        for i in range(ships)
    )
    boat = under_way(folder, "".join(rows))
    monitor, best = EncounterMonitor.over(boat), math.inf
    for _ in range(40):
        boat.state.tick += 1
        begun = time.process_time()
        monitor.look(boat)
        best = min(best, time.process_time() - begun)
    return best


def test_many_ships_are_looked_at_in_one_pass(tmp_path: Path) -> None:
    """Forty times the ships must not cost ten times as much."""
    assert cost(tmp_path, 200) < 10.0 * cost(tmp_path, 5)

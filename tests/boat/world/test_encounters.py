"""Ships that come near: closest approach, its calls, collisions and what they do."""

import math
import sys
from collections import Counter
from pathlib import Path
from random import Random

import numpy as np
import pytest
from helpers.boats import calls_of, take_ticks
from helpers.orders import read_order
from helpers.sessions import start_exercise

from trainer.boat.boat import Boat
from trainer.boat.calls import Rank
from trainer.boat.helm import obey_order
from trainer.boat.world import encounters
from trainer.boat.world.approach import (
    OwnMotion,
    closest_approach,
    nears_on_arcs,
    on_arcs,
    plot_ship,
)
from trainer.boat.world.contacts import Contacts
from trainer.boat.world.encounters import (
    EncounterMonitor,
    collisions_in,
    passed_ships,
    passing_range,
)
from trainer.boat.world.hulls import POSE_NAMES, OwnHull, Pose, ships_overlap
from trainer.boat.world.tracks import ShipMotion, piece_column, situation
from trainer.config.world.contacts import SHIP_TYPES
from trainer.io.orders.grammar import Refused
from trainer.units import KNOT

HEAD = 'schema = "exercise/1"\nname = "Ships"\nbriefing = "Ships."\nduration_s = 1200\n'
LIMIT = 500.0  # [m]


def under_way(folder: Path, tables: str, depth: float = 60.0) -> Boat:
    """Return a boat that goes north at 6 knots among the ships of an exercise."""
    path = folder / "ships.toml"
    start = f"[initial]\nspeed_kn = 6\ndepth_m = {depth}\n"
    path.write_text(f"{HEAD}{start}{tables}")
    return start_exercise(path)


def ordered(boat: Boat, text: str) -> str:
    """Return how a boat's world answers an order; refusals begin with one."""
    reply = obey_order(boat, read_order(text))
    return f"refused: {reply.reason}" if isinstance(reply, Refused) else reply


def one(north: float, east: float, course: float, speed: float, turning: float = 0.0) -> ShipMotion:
    """Return one ship."""
    return ShipMotion(north, east, course, speed, turning, 0.0, 0.0)


def test_the_closest_approach_of_the_textbook() -> None:
    # r (0, 2000), v (2, -10): t = 20000/104, |r + v t| = |(384.6, 76.9)|
    closest, until = closest_approach(0.0, 2000.0, 2.0, -10.0)
    assert until == pytest.approx(192.31, abs=0.005)
    assert closest == pytest.approx(392.23, abs=0.005)


def test_without_relative_speed_there_is_no_time_of_closest_approach() -> None:
    seen = plot_ship(OwnMotion(0.0, 0.0, 0.0, 5.0, 0.0), one(300.0, 400.0, 0.0, 5.05), LIMIT)
    assert (seen.closest, seen.range) == pytest.approx((500.0, 500.0))
    assert math.isnan(seen.until)
    assert not seen.turning


def test_a_ship_that_has_passed_has_its_closest_approach_behind() -> None:
    seen = plot_ship(OwnMotion(0.0, 0.0, 0.0, 5.0, 0.0), one(-1000.0, 200.0, math.pi, 5.0), LIMIT)
    assert seen.until == pytest.approx(-100.0)
    assert seen.closest == pytest.approx(200.0)


def test_a_turning_ship_is_foreseen_on_its_arc() -> None:
    """It circles with a radius of 500 m: never nearer than that circle, which a line would cut."""
    ship = one(0.0, 1500.0, -0.5 * math.pi, 5.0, 0.01)
    seen = plot_ship(OwnMotion(0.0, 0.0, 0.0, 0.0, 0.0), ship, LIMIT)
    # the circle's middle is 500 m to starboard of the ship, that is north of it
    assert seen.turning
    assert seen.closest == pytest.approx(math.hypot(500.0, 1500.0) - 500.0, abs=1.0)
    straight = plot_ship(
        OwnMotion(0.0, 0.0, 0.0, 0.0, 0.0), one(0.0, 1500.0, -0.5 * math.pi, 5.0), LIMIT
    )
    assert straight.closest == pytest.approx(0.0, abs=1e-9)


def test_no_ship_that_nears_on_an_arc_is_taken_for_one_far_off() -> None:
    """A few ranges tell of most ships that they stay away, and of none that comes near."""
    dice, may, will = Random(8), 0, 0  # noqa: S311  chances, not secrets
    for _ in range(4000):
        own = OwnMotion(0.0, 0.0, dice.uniform(-3.0, 3.0), 9.0, dice.uniform(-0.03, 0.03))
        north, east, course, turning = (dice.uniform(-x, x) for x in (4000.0, 4000.0, 3.0, 0.02))
        ship = ShipMotion(north, east, course, dice.choice((0.0, 8.0)), turning, 0.5, -0.5)
        limit, seconds = dice.uniform(100.0, 1500.0), dice.uniform(30.0, 900.0)
        closest, until = on_arcs(own, ship)
        nears = closest <= limit and until < seconds
        told = nears_on_arcs(own, ship, limit, seconds)
        assert told >= nears
        may, will = may + told, will + nears
    assert 300 < will <= may < 1.5 * will


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
    return [call.text for call in calls_of(boat, monitor, seconds)]


def test_an_approach_is_called_once_and_again_when_it_changes(tmp_path: Path) -> None:
    boat = under_way(tmp_path, CROSSING)
    monitor = EncounterMonitor.over(boat)
    told = fly(boat, monitor, 30.0)
    assert [each.split(": ")[1] for each in told] == ["CLOSEST APPROACH"]
    assert "ferry" in told[0]
    north, east = (float(each[0]) for each in ships_of(monitor).at(boat.ticks)[:2])
    assert "move" in ordered(boat, f"contact ferry move {north + 10:.0f} {east:.0f}")
    assert fly(boat, monitor, 10.0) == []  # it comes as near as before, or nearly
    assert "move" in ordered(boat, f"contact ferry move {north + 400:.0f} {east:.0f}")
    assert len(fly(boat, monitor, 10.0)) == 1


def test_waves_that_yaw_the_boat_call_no_approach_again(tmp_path: Path) -> None:
    """A ship will pass within the limit, ten minutes ahead: what the waves do is no news."""
    waves = '[sea]\nsea_state = 4\ndirection_deg = 60\ngenerator = "cosines"\n'
    boat = under_way(tmp_path, waves + CROSSING.replace("1000, 2000]]", "1300, 4000]]"), 17.5)
    (told,) = fly(boat, EncounterMonitor.over(boat), 120.0)
    assert "m in 9 min 55 s; now 072 at" in told


def test_ships_that_are_too_far_off_to_come_near_are_passed_over_and_no_call_is_lost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dice, tables = Random(5), ""  # noqa: S311  chances, not secrets
    for number in range(40):
        north, east, off = (dice.uniform(-x, x) for x in (2500.0, 2500.0, 40.0))
        course = math.degrees(math.atan2(-east, -north)) + off
        tables += f'[[contact]]\nname = "ship{number}"\ntype = "fishing"\n'
        tables += f"points = [[{north:.0f}, {east:.0f}]]\ncourse_deg = {course % 360:.0f}\n"
        tables += f"speed_kn = {dice.choice((4, 12)):g}\n"
    tables += "[contacts]\ncpa_m = 500\nwarn_s = 150\n"
    told = []
    for margin in (encounters.FAR_MARGIN, math.inf):
        monkeypatch.setattr(encounters, "FAR_MARGIN", margin)
        boat = under_way(tmp_path, tables)
        told.append(fly(boat, EncounterMonitor.over(boat), 300.0))
    assert len(told[0]) > 5
    assert told[0] == told[1]


def ships_of(monitor: EncounterMonitor) -> Contacts:
    """Return the ships that are watched."""
    assert monitor.contacts is not None
    return monitor.contacts


def test_the_least_range_of_a_tick_lies_between_its_ends() -> None:
    """A ship lies 300 m east of the middle of a step of 400 m."""
    lying, pose = one(0.0, 300.0, 0.0, 0.0), Pose(0.0, 0.0, 60.0, 0.0, 0.0, 0.0)
    least = passing_range(lying, lying, pose._replace(north=-200.0), pose._replace(north=200.0))
    assert least == pytest.approx(300.0)
    least = passing_range(lying, lying, pose._replace(north=100.0), pose._replace(north=400.0))
    assert least == pytest.approx(math.hypot(100.0, 300.0))


def test_a_passage_has_the_ranges_and_collisions_of_its_ticks(tmp_path: Path) -> None:
    """A ship is moved on the way, so that two fleets are met; then the boat runs into it."""
    boat = under_way(tmp_path, AHEAD + CROSSING, 17.5)
    monitor, nearest, struck, rows = EncounterMonitor.over(boat), [], [], []
    for tick in range(240):
        rows.append(boat.numbers(POSE_NAMES))
        if tick == 40:
            ordered(boat, "contact anchored move 250 5")
        assert boat.tick() == 0
        monitor.look(boat)
        nearest.append(monitor.nearest[1])
        struck += [(tick + 1, monitor.struck)] if monitor.struck else []
    poses = np.array([*rows, boat.numbers(POSE_NAMES)]).T
    passed = list(passed_ships(ships_of(monitor), np.arange(241), poses))
    least = np.full(241, np.inf)
    for each in passed:
        least[each.rows] = np.minimum(least[each.rows], each.ranges)
    assert len(passed) == 4
    assert least[1:].tolist() == nearest
    assert struck
    assert collisions_in(passed, OwnHull.of(boat), poses) == struck


def test_the_measured_approach_is_the_least_distance_between_ticks_too(tmp_path: Path) -> None:
    boat = under_way(tmp_path, CROSSING)
    monitor = EncounterMonitor.over(boat)
    fine = math.inf
    contacts = ships_of(monitor)
    before = float(boat.state.x)
    for tick in range(600):
        assert boat.tick() == 0
        monitor.look(boat)
        now = float(boat.state.x)
        for part in range(10):
            way = contacts.fleet(0).order[0].way
            time = (tick + part / 10) * boat.method.step
            there = situation(piece_column(way.at(time)), time)
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


def test_a_collision_is_an_emergency(tmp_path: Path) -> None:
    boat = under_way(tmp_path, AHEAD, 17.5)
    monitor, ranks = EncounterMonitor.over(boat), []
    for _ in range(240):
        assert boat.tick() == 0
        ranks += [call.rank for call in monitor.look(boat) if monitor.struck]
    assert ranks == [Rank.EMERGENCY]


def test_the_sail_alone_touches_a_keel(tmp_path: Path) -> None:
    """A tanker draws 11 m; the sail of bb2 is 11.4 m above its origin, the hull 6 m at most."""
    hull = OwnHull.of(under_way(tmp_path, ""))
    pose = Pose(0.0, 0.0, 21.0, 0.0, 0.0, 0.0)
    tanker = SHIP_TYPES["tanker"]
    assert hull.touches(pose, tanker, 0.0, 0.0, 0.5 * math.pi)
    assert not hull.touches(pose, tanker, -40.0, 0.0, 0.5 * math.pi)  # the sail is ahead of it
    assert not hull.touches(pose._replace(depth=23.0), tanker, 0.0, 0.0, 0.5 * math.pi)


def test_nothing_is_passed_over_between_two_looks(tmp_path: Path) -> None:
    """A yacht's beam is gone in a fraction of a tick."""
    hull = OwnHull.of(under_way(tmp_path, ""))
    yacht = SHIP_TYPES["yacht"]
    assert hull.looks(30.0, yacht) >= 30.0 / (0.25 * yacht.beam)


def test_ships_lie_in_each_other_or_beside() -> None:
    tug = SHIP_TYPES["tug"]
    across = (0.0, 20.0, 0.5 * math.pi, tug)
    assert ships_overlap((0.0, 0.0, 0.0, tug), across)
    assert not ships_overlap((0.0, 0.0, 0.0, tug), (0.0, 12.0, 0.0, tug))


def test_without_ships_nothing_is_watched(tmp_path: Path) -> None:
    boat = under_way(tmp_path, "")
    monitor = EncounterMonitor.over(boat)
    assert fly(boat, monitor, 5.0) == []
    assert monitor.nearest[1] == math.inf
    assert not boat.world.acts


def calls_of_a_look(folder: Path, ships: int) -> int:
    """Return how many functions a look at so many ships calls."""
    rows = (
        f'[[contact]]\nname = "s{i}"\ntype = "cargo"\nspeed_kn = 12\n'
        f"points = [[{3000 + 60 * i}, -4000], [{9000 + 60 * i}, 5000]]\n"
        for i in range(ships)
    )
    boat = under_way(folder, "".join(rows))
    monitor, called = EncounterMonitor.over(boat), Counter[str]()
    monitor.look(boat)  # the first prepares what later ones use
    boat.state.tick += 1
    sys.setprofile(lambda _frame, event, _what: called.update([event]))
    try:
        monitor.look(boat)
    finally:
        sys.setprofile(None)
    return called["call"] + called["c_call"]


def test_a_contact_costs_little_of_a_tick(tmp_path: Path) -> None:
    more = calls_of_a_look(tmp_path, 40) - calls_of_a_look(tmp_path, 10)

    assert 0 < more <= 30 * 20  # a far one takes seven, a near one thirteen


ADRIFT = """
[current]
set_deg = 90
drift_kn = 2
[[contact]]
name = "hulk"
type = "tug"
points = [[900, 0]]
drifts = true
[[contact]]
name = "crosser"
type = "tug"
points = [[0, -800]]
course_deg = 0
speed_kn = 2
drifts = true
[[contact]]
name = "liner"
type = "ferry"
points = [[2000, 0]]
"""


def test_a_ship_that_drifts_goes_with_the_water(tmp_path: Path) -> None:
    contacts = ships_of(EncounterMonitor.over(under_way(tmp_path, ADRIFT)))
    hulk, crosser, liner = contacts.seen(200)  # 100 s
    carried = 200.0 * KNOT
    assert (hulk.north, hulk.east, liner.east) == pytest.approx((900.0, carried, 0.0))
    assert (hulk.course, hulk.speed, hulk.heading) == pytest.approx((0.5 * math.pi, 2 * KNOT, 0.0))
    assert (crosser.north, crosser.east) == pytest.approx((carried, carried - 800.0))
    assert (crosser.course, crosser.heading) == pytest.approx((0.25 * math.pi, 0.0))
    assert crosser.speed == pytest.approx(math.sqrt(8.0) * KNOT)
    assert (hulk.status, liner.status, liner.speed) == ("adrift", "at anchor", 0.0)


def test_the_closest_approach_of_a_ship_that_drifts_is_over_the_ground(tmp_path: Path) -> None:
    """It goes to the north-east, and passes north-west of the boat."""
    contacts = ships_of(EncounterMonitor.over(under_way(tmp_path, ADRIFT)))
    _, crosser, _ = contacts.fleet(0).motions(0)
    straight = plot_ship(OwnMotion(100.0, 0.0, 0.0, 0.0, 0.0), crosser, LIMIT)
    assert straight.closest == pytest.approx(700.0 / math.sqrt(2.0))
    assert straight.until == pytest.approx(450.0 / KNOT / 2.0)
    turning = crosser._replace(turning=1e-9)
    bent = plot_ship(OwnMotion(100.0, 0.0, 0.0, 0.0, 1e-9), turning, 1e-9)
    assert bent.turning
    assert bent.closest == pytest.approx(straight.closest, rel=1e-3)


def test_a_ship_that_drifts_is_ordered_through_the_water_and_moved_over_the_ground(
    tmp_path: Path,
) -> None:
    boat = under_way(tmp_path, ADRIFT)
    contacts = ships_of(EncounterMonitor.over(boat))
    take_ticks(boat, 100)
    ordered(boat, "contact hulk move 500 -100")
    ordered(boat, "contact crosser course 180")
    hulk, _, _ = contacts.seen(100)
    assert (hulk.north, hulk.east) == pytest.approx((500.0, -100.0))
    ordered(boat, "current off")
    for tick in (100, 220, 1000):  # the last of the water within the ramp of 60 s
        hulk, crosser, _ = contacts.seen(tick)
        left = KNOT * min((tick - 100) * 0.5, 60.0)
        gone = 2.0 * left - left * left / (60.0 * KNOT)
        assert hulk.east == pytest.approx(-100.0 + gone, abs=1e-6)
    assert (crosser.course, crosser.heading) == pytest.approx((math.pi, math.pi))
    assert crosser.speed == pytest.approx(2.0 * KNOT)

"""The ways of ships: closed forms against steps, turns, speeds, legs too short."""

import math

import pytest

from trainer.boat.world.tracks import (
    Piece,
    Stretch,
    Way,
    lay_way,
    path_along,
    piece_column,
    rest_of,
    situation,
    unreached_stretch,
)
from trainer.config.world.contacts import SHIP_ACCELERATION_M_S2

START = Piece(0.0, math.inf, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def where(way: Way, time: float) -> tuple[float, ...]:
    """Return north, east, course, speed and rate of turn at a time."""
    return tuple(float(each[0]) for each in situation(piece_column(way.at(time)), time)[:5])


@pytest.mark.long
def test_a_way_is_what_small_steps_of_its_speed_and_turn_add_up_to() -> None:
    points = [(0.0, 0.0), (4000.0, 0.0), (6000.0, 5000.0), (2000.0, 9000.0)]
    course, path = path_along(points, (3.0, 7.0, 5.0), 500.0)
    way = lay_way(20.0, START._replace(course=course), path)
    north, east, h = 0.0, 0.0, 0.05
    for i in range(round(3000.0 / h)):
        _, _, psi, speed, _ = where(way, (i + 0.5) * h)
        north, east = north + h * speed * math.cos(psi), east + h * speed * math.sin(psi)
    found = where(way, 3000.0)
    assert found[0] == pytest.approx(north, abs=0.05)
    assert found[1] == pytest.approx(east, abs=0.05)
    assert found[3] == 5.0
    assert not unreached_stretch(way)


def test_nothing_jumps_from_piece_to_piece() -> None:
    points = [(0.0, 0.0), (3000.0, 1000.0), (3000.0, 8000.0), (-3000.0, 9000.0)]
    course, path = path_along(points, (4.0, 6.0, 2.0), 300.0)
    way = lay_way(0.0, START._replace(course=course, speed=4.0), path)
    for before, after in zip(way.pieces, way.pieces[1:], strict=False):
        end = situation(piece_column(before), before.ends)
        begin = situation(piece_column(after), before.ends)
        for one, other in zip(end[:4], begin[:4], strict=True):
            assert one[0] == pytest.approx(other[0], abs=1e-6)


def test_a_ship_passes_a_way_point_inside_its_turn_and_goes_on_along_the_next_leg() -> None:
    """A right angle of radius R is cut by R (sqrt 2 - 1) at its corner."""
    _, path = path_along([(0.0, 0.0), (2000.0, 0.0), (2000.0, 3000.0)], (5.0, 5.0), 400.0)
    way = lay_way(0.0, START._replace(speed=5.0), path)
    middle = (1600.0 + 0.25 * math.pi * 400.0) / 5.0
    north, east, psi, _, turning = where(way, middle)
    assert math.hypot(north - 2000.0, east) == pytest.approx(400.0 * (math.sqrt(2.0) - 1.0))
    assert (psi, turning) == pytest.approx((math.pi / 4, 5.0 / 400.0))
    assert where(way, 5000.0)[0] == pytest.approx(2000.0)


def test_a_speed_is_changed_by_the_same_rate_either_way() -> None:
    way = lay_way(0.0, START._replace(speed=8.0), [Stretch(0.0, math.inf, 2.0)])
    slow = 6.0 / SHIP_ACCELERATION_M_S2
    assert where(way, 0.5 * slow)[3] == pytest.approx(5.0)
    assert where(way, 2.0 * slow)[:1] == pytest.approx((5.0 * slow + 2.0 * slow,))
    assert where(way, 2.0 * slow)[3] == 2.0


def test_a_ship_stops_and_stays() -> None:
    way = lay_way(0.0, START._replace(speed=4.0), [Stretch(0.0, math.inf, 0.0)])
    assert where(way, 1e6)[:1] == pytest.approx((16.0 / (2.0 * SHIP_ACCELERATION_M_S2),))
    assert where(way, 1e6)[3] == 0.0


@pytest.mark.parametrize(
    ("points", "told"),
    [
        ([(0, 0), (300, 0), (300, 4000)], "leg 1 is 300 m"),
        ([(0, 0), (3000, 0), (0, 1)], "leg 1 is 3000 m"),
        ([(0, 0), (0, 0)], "leg 1 has no length"),
    ],
)
def test_a_leg_too_short_for_its_turns_is_refused(
    points: list[tuple[float, float]], told: str
) -> None:
    with pytest.raises(ValueError, match=told):
        path_along(points, (5.0,) * (len(points) - 1), 500.0)


def test_a_speed_that_a_leg_is_too_short_for_is_found() -> None:
    points = [(0.0, 0.0), (2000.0, 0.0), (2500.0, 0.0)]
    _, path = path_along(points, (2.0, 8.0), 300.0)
    assert unreached_stretch(lay_way(0.0, START._replace(speed=2.0), path)) == 1


def test_the_rest_of_a_way_is_the_same_way() -> None:
    points = [(0.0, 0.0), (3000.0, 0.0), (3000.0, 9000.0)]
    _, path = path_along(points, (2.0, 6.0), 300.0)
    way = lay_way(0.0, START._replace(speed=2.0), path)
    for time in (100.0, 1400.0, 1500.0, 1700.0):
        now, rest = rest_of(way, time)
        again = lay_way(time, now, rest)
        assert where(again, 2500.0) == pytest.approx(where(way, 2500.0), abs=1e-6)

"""Orders to the crew as they stand in the state."""

import math

import pytest
from helpers.boats import make_boat, start_bb2
from helpers.orders import read_order

from trainer.boat import casualties
from trainer.boat.boat import Boat
from trainer.boat.crew_orders import standing_order, standing_orders
from trainer.boat.helm import obey_order
from trainer.io.orders.grammar import Refused, Reply

KNOT = 1852.0 / 3600.0


@pytest.fixture
def boat() -> Boat:
    """Return a BB2 at 10 knots, 60 m and course 000, a minute on its way."""
    boat = start_bb2()
    boat.state.tick = 120.0
    return boat


def give(boat: Boat, *lines: str) -> Reply:
    """Give orders; return the answer to the last."""
    answer: Reply = ""
    for line in lines:
        order = read_order(line)
        answer = obey_order(boat, order)
    return answer


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("order course 045", "course 045"),
        ("order course left 45", "course left to 045"),
        ("order course starboard 360", "course right to 000"),
        ("order course 359.7", "course 000"),
        ("order course steady", "course 000"),
        ("order depth 60", "depth 60 m"),
        ("order depth 200 ft", "depth 200 ft"),
        ("order depth 66 ft", "depth 66 ft"),
        ("order periscope", "depth 17.5 m"),
        ("order speed 8", "speed 8 kn"),
        ("order pitch 5 down", "pitch 5 down"),
        ("order pitch 5 up", "pitch 5 up"),
        ("order pitch zero", "pitch zero"),
    ],
)
def test_an_order_stands_as_it_was_said(boat: Boat, line: str, told: str) -> None:
    assert give(boat, line) == f"ordered: {told}"
    (only,) = standing_orders(boat)
    assert (str(only), only.tick) == (told, 120)


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ("order depth 1900", "this boat's greatest depth is"),
        ("order speed 60", "this boat's greatest speed is 20 kn"),
        ("order clear course", "the crew has no order on course"),
        ("order clear all", "the crew has no order"),
    ],
)
def test_what_the_boat_cannot_do_is_not_ordered(boat: Boat, line: str, why: str) -> None:
    before = boat.records.state.tobytes()
    answer = give(boat, line)
    assert isinstance(answer, Refused)
    assert why in answer.reason
    assert boat.records.state.tobytes() == before


def test_a_new_order_takes_the_place_of_the_old_one_on_its_axis_alone(boat: Boat) -> None:
    give(boat, "order course left 045", "order depth 80", "order course 090")
    assert [str(each) for each in standing_orders(boat)] == ["course 090", "depth 80 m"]


def test_an_order_to_the_crew_moves_nothing() -> None:
    boats = [make_boat("bb2"), make_boat("bb2")]
    for each in boats:
        each.start(10.0 * KNOT, 60.0, 0.0)
    give(boats[0], "order course 090", "order depth 90", "order speed 5", "order pitch 5 down")
    for _ in range(20):
        assert not any(each.tick() for each in boats)
    for name in ("z", "psi", "u", "theta", "delta_r", "delta_s", "delta_b", "u_c"):
        assert float(boats[0].state[name]) == float(boats[1].state[name])


def test_an_order_survives_hand_steering_and_is_in_a_snapshot(boat: Boat) -> None:
    give(boat, "order course 045", "rudder left 5")
    kept = boat.records.state.copy()
    give(boat, "order clear course")
    assert standing_order(boat, "course") is None

    boat.restore(kept)

    assert str(standing_order(boat, "course")) == "course 045"
    assert boat.state.rudder_by_hand


def test_one_order_or_all_stand_no_longer(boat: Boat) -> None:
    give(boat, "order course 045", "order depth 80", "order speed 5")

    assert give(boat, "order clear speed") == "no longer ordered: speed 5 kn"
    assert [str(each) for each in standing_orders(boat)] == ["course 045", "depth 80 m"]
    assert give(boat, "order clear all") == "no longer ordered: course 045, depth 80 m"
    assert not standing_orders(boat)


def test_the_way_to_turn_is_by_the_compass_shown(boat: Boat) -> None:
    assert isinstance(casualties.insert_casualty(boat, "gyro-biased", 10.0, 0.0), str)
    assert boat.tick() == 0
    shown = casualties.instrument_readings(boat).heading
    assert math.degrees(shown - float(boat.state.psi)) > 15.0

    give(boat, "order course right 010")

    course = standing_order(boat, "course")
    assert course
    assert math.degrees(course.value - shown) > 200.0  # by the true heading, 10

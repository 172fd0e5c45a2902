"""The safe depth: what a jam or a flooding would do now, flown ahead by the boat's own tick."""

import math

import pytest
from helpers.boats import fly, make_boat, start_bb2, start_boat, take_in_hand

from trainer.boat.boat import Boat
from trainer.boat.casualties import insert_casualty
from trainer.boat.helm import obey_order
from trainer.boat.safe_depth import (
    AFT_FLOODING,
    FLOWN_AFTER_S,
    STERN_JAM,
    Danger,
    Flight,
    FlightAhead,
)
from trainer.io.orders.grammar import Order, parse
from trainer.units import KNOT

FAST, SLOW = 15.0 * KNOT, 5.0 * KNOT


def fast_boat(depth: float = 100.0) -> Boat:
    """Return BB2 at 15 kn."""
    return start_boat(FAST, depth, equations="modified")


def fly_by_orders(boat: Boat, danger: Danger) -> float:
    """Return the greatest depth [m] of a boat in hand that suffers a danger and answers it."""
    take_in_hand(boat)
    boat.state.trim_by_hand = 1.0
    insert_casualty(boat, danger.casualty, danger.severity, 0.0)
    deepest = float(boat.state.z)
    for tick in range(boat.ticks_in(danger.answered_s + FLOWN_AFTER_S)):
        if tick == boat.ticks_in(danger.answered_s):
            for text in danger.answers:
                order = parse(text)
                assert isinstance(order, Order)
                assert obey_order(boat, order)
        fly(boat, boat.method.step)
        deepest = max(deepest, float(boat.state.z))
    return deepest


@pytest.mark.parametrize("danger", [STERN_JAM, AFT_FLOODING])
def test_the_depth_told_is_that_of_a_boat_that_suffers_it(danger: Danger) -> None:
    told = FlightAhead(fast_boat()).find_deepest(Flight(FAST, 100.0), danger)
    assert told == fly_by_orders(fast_boat(), danger)


def test_a_jam_takes_a_fast_boat_deeper_than_a_slow_one_and_a_steep_one_deepest() -> None:
    ahead = FlightAhead(fast_boat())
    flights = (Flight(SLOW, 100.0), Flight(FAST, 100.0), Flight(FAST, 100.0, math.radians(-5.0)))
    slow, fast, steep = (ahead.find_deepest(each, STERN_JAM) or 0.0 for each in flights)
    assert slow == pytest.approx(100.0, abs=3.0)
    assert 150.0 < fast < 200.0  # flown by hand: 69 m deeper if answered after 15 s
    assert steep > fast + 10.0


def test_the_boat_that_is_flown_ahead_leaves_the_real_one_as_it_is() -> None:
    boat = fast_boat()
    before = boat.snapshot()
    ahead = FlightAhead(boat)
    ahead.find_deepest(Flight(FAST, 100.0), STERN_JAM)
    assert ahead.safe_depths
    assert boat.snapshot() == before


def test_a_fast_boat_is_safe_from_jams_higher_up_and_a_slow_one_from_floodings() -> None:
    boat = start_bb2("modified")
    depths = FlightAhead(boat).safe_depths
    jams, floodings = ([row[at] or 0.0 for row in depths] for at in (1, 2))
    assert [round(row.speed / KNOT, 1) for row in depths][-1] == 20.0
    assert jams == sorted(jams, reverse=True)
    assert floodings == sorted(floodings)
    assert jams[0] == floodings[-1] == boat.file.hull.test_depth_m == 250.0
    assert jams[-1] < 130.0
    assert floodings[0] < 200.0


def test_from_a_safe_depth_a_jam_ends_above_test_depth_and_from_a_little_deeper_beyond() -> None:
    [safe] = [row for row in FlightAhead(fast_boat()).safe_depths if row.speed == FAST]
    assert safe.jam is not None
    reached = [fly_by_orders(fast_boat(safe.jam + more), STERN_JAM) for more in (0.0, 5.0)]
    assert reached[0] <= 250.0 < reached[1]


def test_a_boat_has_no_depth_for_what_it_cannot_suffer_or_fly() -> None:
    ahead = FlightAhead(make_boat("remus100", "full", step=0.1))
    assert (ahead.find_deepest(Flight(3.0 * KNOT, 20.0), STERN_JAM) or 0.0) > 20.0
    assert ahead.find_deepest(Flight(3.0 * KNOT, 20.0), AFT_FLOODING) is None
    assert ahead.find_deepest(Flight(20.0 * KNOT, 20.0), STERN_JAM) is None
    assert {row.flooding for row in ahead.safe_depths} == {None}

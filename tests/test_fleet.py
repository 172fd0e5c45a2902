"""Boats flown many at once are the boats flown alone."""

from collections.abc import Callable

import numpy as np
import pytest

from trainer.boat import PLACES, Boat
from trainer.core.ensemble import Fleet
from trainer.study.fleet import NO_ORDERS, fly_members, orders

TICKS = 90
MakeBoat = Callable[..., Boat]


@pytest.fixture
def boat(make_boat: MakeBoat) -> Boat:
    """Return a boat of the modified set under way."""
    boat = make_boat(equations="modified")
    boat.start(5.0, 100.0, 0.0)
    return boat


def fleet_of(boat: Boat, members: int) -> Fleet:
    """Return so many of a boat."""
    records = boat.records
    return Fleet(records.vessel, records.compact, records.scheme, np.repeat(records.state, members))


def test_a_member_is_the_boat_flown_alone_to_the_bit(boat: Boat) -> None:
    fleet = fleet_of(boat, 3)
    fleet.states["ordered_depth"] = [80.0, 100.0, 120.0]
    start = fleet.states.copy()

    flown = fly_members(fleet, NO_ORDERS, TICKS, TICKS, ("z",))

    for member in range(3):
        boat.restore(start[member : member + 1])
        for _ in range(TICKS):
            boat.tick()
        assert boat.state.whole.tobytes() == fleet.states[member].whole.tobytes()
        assert flown.rows[member, :, 0].tolist() == [100.0, boat.state.z]


def test_an_order_acts_before_its_tick(boat: Boat) -> None:
    fleet = fleet_of(boat, 2)
    places = [PLACES["ordered_r"], PLACES["rudder_by_hand"]]
    schedule = orders([3, 3], places, [[0.1, 1.0], [0.2, 1.0]])

    flown = fly_members(fleet, schedule, 5, 1, ("command_r", "ordered_r"))

    assert flown.rows[:, 3].tolist() == [[0.0, 0.0], [0.0, 0.0]]
    assert flown.rows[:, 4].tolist() == [[0.1, 0.1], [0.2, 0.2]]


def test_a_member_whose_numbers_are_lost_stays_and_the_others_go_on(boat: Boat) -> None:
    fleet = fleet_of(boat, 3)
    schedule = orders(4, PLACES["q"], [[0.0], [np.inf], [0.0]])

    flown = fly_members(fleet, schedule, 10, 2, ("tick",))

    assert flown.lost.tolist() == [-1, 4, -1]
    assert fleet.states["tick"].tolist() == [10.0, 4.0, 10.0]
    assert np.isnan(flown.rows[1, 3:]).all()
    assert not np.isnan(flown.rows[[0, 2]]).any()

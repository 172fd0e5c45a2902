"""Depth, position or tanks frozen while all else goes on, and released again."""

import numpy as np
import pytest
from helpers.boats import make_boat, start_boat

from trainer.boat import casualties
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.boat.helm import obey_order
from trainer.config.world.sea import load_sea
from trainer.core.state import STATE_FIELDS
from trainer.io.orders.grammar import Order, Refused, Reply
from trainer.session.stations.status import status_lines
from trainer.session.time.ledger import Ledger
from trainer.units import KNOT

pytestmark = pytest.mark.long  # each freeze, at each kind of method
TWO_PASTS = "a=0.5,0.5;b=1.5"  # a method that looks back on motion as well as on rates
INTEGRATORS = ("adams2", TWO_PASTS, "best2", "abm4", "rk4", "rkv")
PLACE = {"x", "y", "past_motion", "held_position"}  # what a hold of position may change


def busy(integrator: str = "adams2") -> Boat:
    """Return a BB2 in a turn and a dive, in a sea, with pumps at work and things breaking."""
    boat = start_boat(8.0 * KNOT, 40.0, 1.0, seed=7, integrator=integrator)
    boat.put_to_sea(load_sea("sea-state-5"))
    s = boat.state
    s.sea_cosines = s.sea_1969 = s.sea_peaked = 0.5
    s.ordered_depth, s.ordered_psi = 70.0, 2.5
    s.blow[0], s.vent[1] = 1.0, 1.0
    s.move_trim = 3000.0
    for name, ramp in (("depth-gauge-noisy", 0.0), ("rudder-slow", 30.0), ("flooding-aft", 20.0)):
        assert isinstance(casualties.insert_casualty(boat, name, None, ramp), str)
    sail(boat, 20)
    return boat


@pytest.fixture
def boat() -> Boat:
    return busy()


def sail(boat: Boat, ticks: int) -> None:
    with np.errstate(all="ignore"):
        assert [boat.tick() for _ in range(ticks)] == [0] * ticks


def told(boat: Boat, name: str, word: str) -> Reply:
    return obey_order(boat, Order(name, 0.0, word, f"{name} {word}"))


def bits(boat: Boat) -> bytes:
    return boat.records.state.tobytes()


def alike(one: Boat, other: Boat, but: set[str]) -> list[str]:
    """Return the fields that differ by a bit, leaving out ``but`` and the blocks that hold it."""
    blocks = {"motion", "held"}
    return [
        name
        for name in STATE_FIELDS
        if name not in but | blocks and one.state[name].tobytes() != other.state[name].tobytes()
    ]


# Position


@pytest.mark.core
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_boat_held_in_place_does_all_else_to_the_bit_as_if_she_were_not(integrator: str) -> None:
    plain, held = busy(integrator), busy(integrator)
    x, y = float(held.state.x), float(held.state.y)
    assert told(held, "hold", "position") == (
        f"position frozen at {x:.0f} m north, {y:.0f} m east of the start"
    )

    for _ in range(6):
        sail(plain, 20)
        sail(held, 20)
        assert alike(plain, held, PLACE) == []

    assert (held.state.x, held.state.y) == (x, y)
    assert abs(plain.state.x - x) + abs(plain.state.y - y) > 100.0


@pytest.mark.core
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_once_released_she_sails_on_from_where_she_was_held(integrator: str) -> None:
    plain, held = busy(integrator), busy(integrator)
    told(held, "hold", "position")
    sail(plain, 40)
    sail(held, 40)
    apart = held.state.motion - plain.state.motion

    assert told(held, "release", "position") == "position released"
    sail(plain, 40)
    sail(held, 40)

    # the same way as the plain run's, the two tracks apart by rounding only
    assert held.state.motion - plain.state.motion == pytest.approx(apart, abs=1e-9)
    assert abs(apart[9]) + abs(apart[10]) > 50.0
    assert alike(plain, held, PLACE | {"sailed", "sailed_x", "sailed_y", "largest"}) == []


# Depth


@pytest.mark.core
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_a_boat_held_at_her_depth_pitches_and_turns_and_stays_there(integrator: str) -> None:
    boat = busy(integrator)
    told(boat, "hold", "depth")
    depth, pitch = float(boat.state.z), float(boat.state.theta)
    water, north = float(boat.state.flood_aft), float(boat.state.x)
    seen = set()
    for _ in range(120):
        sail(boat, 1)
        seen.add(float(boat.state.z))

    assert seen == {depth}
    assert abs(boat.state.theta - pitch) > np.radians(1.0)
    assert abs(boat.state.zdot) > 0.05  # she would go down if she could
    assert abs(boat.state.x - north) > 50.0
    assert boat.state.flood_aft > water


@pytest.mark.core
@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_depth_released_goes_on_without_a_jump(integrator: str) -> None:
    boat = busy(integrator)
    told(boat, "hold", "depth")
    sail(boat, 60)
    depth = float(boat.state.z)
    assert told(boat, "release", "depth") == "depth released"

    sail(boat, 1)

    rate = float(boat.state.zdot)
    assert abs(rate) > 0.05
    assert boat.state.z - depth == pytest.approx(0.5 * rate, rel=0.3)


# Tanks


@pytest.mark.core
def test_frozen_tanks_keep_water_air_and_weight_whatever_is_ordered(boat: Boat) -> None:
    kept = ("water", "tank_air", "bank", "to_move", "weight", "x_g", "z_g", "water_taken")
    before = [boat.state[name].tobytes() for name in kept]
    depth = float(boat.state.z)
    assert told(boat, "hold", "tanks") == "tanks frozen"

    sail(boat, 100)
    assert [boat.state[name].tobytes() for name in kept] == before
    assert abs(boat.state.z - depth) > 1.0

    assert told(boat, "release", "tanks") == "tanks released"
    sail(boat, 10)
    assert all(boat.state[name].tobytes() != old for name, old in zip(kept, before, strict=True))


# All of them


@pytest.mark.core
@pytest.mark.parametrize("integrator", INTEGRATORS)
@pytest.mark.parametrize("part", ["depth", "position", "tanks"])
def test_nothing_but_the_state_remembers_that_something_was_frozen(
    part: str, integrator: str
) -> None:
    boat = busy(integrator)
    told(boat, "hold", part)
    sail(boat, 30)
    still_held = boat.snapshot()
    told(boat, "release", part)
    sail(boat, 30)

    fresh = make_boat("bb2", "full", "lagged", integrator)
    fresh.restore(still_held)
    fresh.state[f"held_{part}"] = 0.0
    sail(fresh, 30)

    assert bits(fresh) == bits(boat)


@pytest.mark.core
def test_a_boat_is_held_to_the_bit_again_from_a_snapshot_taken_in_the_middle() -> None:
    boat, other = busy("rkv"), make_boat("bb2", "full", "lagged", "rkv")
    for part in ("depth", "position", "tanks"):
        told(boat, "hold", part)
    sail(boat, 15)
    other.restore(boat.snapshot())

    sail(boat, 30)
    sail(other, 30)

    assert bits(boat) == bits(other)


@pytest.mark.core
def test_a_second_order_to_freeze_changes_nothing(boat: Boat) -> None:
    told(boat, "hold", "position")
    sail(boat, 10)
    before = bits(boat)

    assert isinstance(told(boat, "hold", "position"), str)

    assert bits(boat) == before


def test_release_all_lets_go_of_what_is_frozen_and_says_what_that_was(boat: Boat) -> None:
    assert told(boat, "release", "all") == "nothing is frozen"
    boat.state.z = 60.04
    assert told(boat, "hold", "depth") == "depth frozen at 60.0 m"
    told(boat, "hold", "tanks")

    assert told(boat, "release", "all") == "depth and tanks released"
    assert not boat.state.held.any()


def test_what_is_not_frozen_cannot_be_released_and_the_answer_says_what_is(boat: Boat) -> None:
    assert told(boat, "release", "depth") == Refused("depth is not frozen; frozen: nothing")
    told(boat, "hold", "tanks")
    assert told(boat, "release", "depth") == Refused("depth is not frozen; frozen: tanks")
    assert boat.state.held_tanks == 1.0


def test_a_boat_without_tanks_has_none_to_freeze() -> None:
    boat = make_boat("remus100", step=0.1)
    answer = told(boat, "hold", "tanks")
    assert answer == Refused("remus100.toml has no [ballast] table: this boat has no tanks")
    assert not boat.state.held.any()


def test_the_status_says_what_is_frozen(boat: Boat) -> None:
    summary = Ledger(boat.method.step).summary()
    assert not [line for line in status_lines(boat, summary) if line.startswith("frozen")]

    boat.state.z = 60.0
    told(boat, "hold", "depth")
    told(boat, "hold", "tanks")

    assert "frozen: depth at 60.0 m, tanks" in status_lines(boat, summary)


def test_the_places_that_a_hold_may_change_are_places_of_the_state() -> None:
    assert set(STATE_OFFSETS) >= PLACE

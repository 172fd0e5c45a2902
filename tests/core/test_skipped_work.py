"""What a tick leaves out where it cannot matter: its bits are those of the tick that does all."""

import math
from itertools import product
from typing import Final

import numpy as np
import pytest
from helpers.boats import make_boat
from helpers.loops import in_a_loop

from trainer.boat.boat import Boat
from trainer.config.world.sea import load_sea
from trainer.core.ballast.ballast import balance, flow_through_holes, is_quiet
from trainer.core.ballast.tanks import TANKS_END
from trainer.core.elementary import cosine, sine
from trainer.core.kinematics import EXACT_TRIGONOMETRY, attitude_of
from trainer.core.sea.sea import COSINES, DIRECTION
from trainer.core.state import new_scratch, new_state
from trainer.core.surfaced import is_near_surface
from trainer.core.update import copy_written, is_sound, lost
from trainer.units import KNOT

SEAS: Final = ("calm", "sea-state-3", "sea-state-6")
DEPTHS_M: Final = (60.0, 18.0, 8.0)
PITCHES: Final = (0.0, 0.6)  # [rad]
WAYS: Final = (("modified", "lagged", "adams2"), ("modified", "lagged", "rk4"))
FLIGHT_TICKS: Final = 240


def boat_at(depth: float, sea: str = "calm", way: tuple[str, str, str] = WAYS[0]) -> Boat:
    """Return a boat under way at a depth [m] in a sea."""
    equations, rates, integrator = way
    boat = make_boat("bb2", equations, rates, integrator)
    boat.start(5.0 * KNOT, depth, 0.3, 7)
    boat.put_to_sea(load_sea(sea))
    return boat


@pytest.mark.long
def test_a_boat_that_asks_its_pitch_for_the_surface_has_the_bits_of_one_that_always_looks() -> None:
    seen = set()
    for regime in product(SEAS, DEPTHS_M, PITCHES, WAYS):
        sea, depth, pitch, way = regime
        boat, careful = boat_at(depth, sea, way), boat_at(depth, sea, way)
        careful.vessel.hull_reach = 1e9  # near wherever any attitude would bring it up
        for each in (boat, careful):
            each.state.theta = pitch
        for tick in range(FLIGHT_TICKS):
            status = in_a_loop(boat.records, 1), in_a_loop(careful.records, 1)
            assert status == (0, 0)
            assert boat.records.state.tobytes() == careful.records.state.tobytes(), (regime, tick)
            work, careful_work = boat.records.scratch[0], careful.records.scratch[0]
            assert work.cut == careful_work.cut
            seen.add((work.levels > 0.0, careful_work.levels > 0.0, work.cut > 0.0))

    assert seen == {  # far below, spared at periscope depth, near, and cut
        (False, False, False),
        (False, True, False),
        (True, True, False),
        (True, True, True),
    }


def test_the_surface_is_near_before_a_station_can_reach_a_trough() -> None:
    boat = boat_at(18.0)
    c, s = boat.vessel, boat.state
    s.motion[:6] = 0.0
    s.sea_height = 2.0
    for pitch in (-1.0, -0.2, 0.0, 0.3, 1.2):
        s.theta = pitch
        s.z = c.station_reach * abs(math.sin(pitch)) + c.hull_reach + 3.0 - 1e-6
        assert is_near_surface(boat.records.vessel, 0.0, boat.records.state)
    s.theta, s.z = 0.0, c.hull_reach + 3.0 + 1.0
    assert not is_near_surface(boat.records.vessel, 0.5, boat.records.state)
    s.w = -1.5  # it rises into the waves within the tick
    assert is_near_surface(boat.records.vessel, 0.5, boat.records.state)


def test_the_water_at_the_stations_is_level_again_once_the_surface_is_far() -> None:
    boat = boat_at(12.0, "sea-state-5")
    work = boat.records.scratch[0]
    in_a_loop(boat.records, 1)
    assert work.level.any()

    boat.state.z = 120.0
    in_a_loop(boat.records, 1)

    assert work.levels == 0.0
    assert not work.level.any()
    assert not work.rise.any()


@pytest.mark.parametrize("cosines", [0.0, 0.5, 1.0])
def test_a_sea_that_turns_has_the_bits_of_a_work_space_that_knows_no_direction(
    cosines: float,
) -> None:
    boat, fresh = boat_at(30.0, "sea-state-5"), boat_at(30.0, "sea-state-5")
    for each in (boat, fresh):
        each.state.sea[COSINES] = each.state.sea_target[COSINES] = cosines
    for tick in range(120):
        if tick in (40, 80):
            for each in (boat, fresh):
                each.state.sea[DIRECTION] += 0.7
                each.state.sea_target[DIRECTION] = each.state.sea[DIRECTION]
        fresh.records.scratch[:] = new_scratch()
        in_a_loop(boat.records, 1)
        in_a_loop(fresh.records, 1)
        assert boat.records.state.tobytes() == fresh.records.state.tobytes(), tick
    assert boat.records.scratch[0].direction == boat.state.sea_direction


def test_a_tick_has_the_bits_of_one_whose_work_space_is_empty() -> None:
    boat, fresh = boat_at(18.0, "sea-state-5"), boat_at(18.0, "sea-state-5")
    periods = set()
    for tick in range(FLIGHT_TICKS):
        if tick == FLIGHT_TICKS - 40:
            for each in (boat, fresh):
                each.records.scheme["h"] = 0.25
                each.vessel.propulsion_lag *= 2.0
        fresh.records.scratch[:] = new_scratch()
        in_a_loop(boat.records, 1)
        in_a_loop(fresh.records, 1)
        assert boat.records.state.tobytes() == fresh.records.state.tobytes(), tick
        periods.add(float(boat.records.scratch[0].notch_period))
    work = boat.records.scratch[0]
    assert len(periods) > 2  # notches were made anew as waves were counted
    assert (work.notch_h, work.lag_h, work.lag) == (0.25, 0.25, boat.vessel.propulsion_lag)


def test_numbers_whose_sums_are_in_range_are_in_range_one_by_one() -> None:
    state = new_state()
    s, rng = state[0], np.random.default_rng(9)
    seen = set()
    for _ in range(4000):
        numbers = rng.normal(size=24) * 10.0 ** rng.uniform(-3.0, 10.0, 24)
        numbers[rng.integers(0, 24)] *= rng.choice([1.0, 1.0, 1.0, math.inf, math.nan])
        s.motion[:6], s.motion[6:], s.rates[:] = (
            numbers[:6] * 1e-6,
            numbers[6:12],
            numbers[12:] * 1e-3,
        )
        seen.add((is_sound(state), lost(state) == 0))
    assert seen == {(True, True), (False, True), (False, False)}
    s.motion[:], s.rates[:] = 1.0, 1.0
    assert is_sound(state)
    for place in ("motion", "rates"):
        for i in range(12):
            for wrong in (math.nan, math.inf, -1e9):
                s[place][i] = wrong
                assert not is_sound(state), (place, i)
                s[place][i] = 1.0


def test_a_tick_writes_no_number_that_it_does_not_save() -> None:
    copy = getattr(copy_written, "py_func", copy_written)
    ways = (*WAYS, ("full", "exact", "adams4"))
    for depth, sea, way in product((60.0, 12.0), ("calm", "sea-state-3"), ways):
        boat = boat_at(depth, sea, way)
        s = boat.state
        s.bottom[0], s.ship_force[:], s.current[:] = depth + 4.0, 1e3, 0.1
        s.crew_order[:] = s.crew_order_tick[:] = 3.0
        s.blow_forward, s.casualty[0], s.casualty_ticks[0] = 2.0, 1.0, 9.0
        for _ in range(60):
            before = s.whole.copy()
            in_a_loop(boat.records, 1)
            written = np.flatnonzero(before != s.whole)
            saved = np.full_like(before, np.nan)
            copy(before, saved)
            lost_ones = saved[written] != before[written]
            assert not lost_ones.any(), written[lost_ones]


def test_a_hand_over_is_faded_while_there_is_any() -> None:
    boat = boat_at(60.0)
    for surface in range(3):
        boat.state.handover[:] = 0.0
        boat.state.handover[surface] = 1e-3
        in_a_loop(boat.records, 1)
        assert 0.0 < boat.state.handover[surface] < 1e-3


def test_pitch_and_roll_have_the_bits_of_sine_and_cosine() -> None:
    state = new_state()
    for phi, theta in np.random.default_rng(3).uniform(-4.0, 4.0, (2000, 2)):
        state["phi"], state["theta"] = phi, theta
        assert attitude_of(EXACT_TRIGONOMETRY, state) == (
            sine(phi),
            cosine(phi),
            sine(theta),
            cosine(theta),
        )


def test_only_tanks_that_nothing_can_move_are_left_alone() -> None:
    boat = boat_at(60.0)
    vessel, state, s = boat.records.vessel, boat.records.state, boat.state
    s.water[:3], s.tank_air[:3] = boat.vessel.capacity[:3], 0.0
    assert is_quiet(vessel, state)
    before = boat.snapshot()
    flow_through_holes(vessel, 0.5, state)
    assert before.tobytes() == state.tobytes()

    for name, place in (("breach", 0), ("breach", 6), ("vent", 1), ("blow", 2), ("tank_air", 0)):
        s[name][place] = 1e-3
        assert not is_quiet(vessel, state), name
        flow_through_holes(vessel, 0.5, state)
        assert s[name][place] == 1e-3 or name == "tank_air"
        assert before.tobytes() != state.tobytes()
        boat.restore(before)


def test_the_balance_without_tanks_as_at_the_start_has_the_bits_of_the_whole_sum() -> None:
    boat = boat_at(60.0)
    c, s, rng = boat.vessel, boat.state, np.random.default_rng(5)
    for _ in range(200):
        s.water[:] = np.where(rng.random(TANKS_END) < 0.5, c.start, rng.uniform(0.0, c.capacity))
        balance(boat.records.vessel, boat.records.state)
        sums = [0.0] * 4
        for i in range(TANKS_END):
            more = (s.water[i] - c.start[i]) * c.g
            parts = (1.0, c.x[i] - c.x_g, c.y[i] - c.y_g, c.z[i] - c.z_g)
            sums = [total + more * part for total, part in zip(sums, parts, strict=True)]
        weight = c.weight + sums[0]
        own = (weight, c.x_g + sums[1] / weight, c.y_g + sums[2] / weight, c.z_g + sums[3] / weight)
        assert (s.weight, s.x_g, s.y_g, s.z_g) == own

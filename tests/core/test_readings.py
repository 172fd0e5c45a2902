"""What is read off a boat: each reading computed anew, and where there is nothing to read."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from helpers.boats import make_boat, take_ticks
from helpers.orders import obey_all

from trainer.boat.boat import Boat
from trainer.boat.readings import READING_OFFSETS, read_rates, read_states
from trainer.boat.world.bottom import height_of_keel, keel_of
from trainer.core.ballast.tanks import BANKS, TANKS
from trainer.core.readings import READINGS, new_readings, write_readings
from trainer.core.state import STATE
from trainer.core.surfaces import SURFACES

NAMES = [name for name in READINGS.names or () if name != "whole"]
UNDER_WAY = (
    *("rudder right 20", "stern planes dive 8", "flood auxiliary 5", "sea state 4"),
    *("order course left 20", "order depth 80", "order speed 4", "order pitch 3 up"),
)


def readings_of(boat: Boat) -> dict[str, float]:
    """Return what is read off a boat now, by name."""
    records, found = boat.records, new_readings()
    write_readings(records.vessel, records.state, records.scratch, found)
    return {name: float(found[name][0]) for name in NAMES if not found[name][0].shape}


@pytest.fixture
def boat() -> Boat:
    """Return a boat that turns and dives in a current, over a ground, with orders to its crew."""
    boat = make_boat("bb2")
    boat.start(6.0, 60.0, 0.4)
    obey_all(boat, *UNDER_WAY)
    take_ticks(boat, 60)
    s = boat.state
    s.water_north, s.water_east, s.shear_north, s.shear_east = 0.4, -0.3, 0.001, 0.002
    s.bottom[0], s.bottom[1], s.bottom[2] = (140.0, 138.0, 135.0, 131.0, 128.0), 0.01, 0.0
    return boat


def expected(boat: Boat) -> dict[str, float]:
    """Return the readings of a boat, computed in other words."""
    s, c = boat.state, boat.vessel
    rates = read_rates(lambda name: float(s[name]))
    north, east = (s[f"water_{way}"] + s[f"shear_{way}"] * s.z for way in ("north", "east"))
    found: dict[str, float] = {
        "depth": s.z,
        "heading": s.psi,
        "speed": s.u,
        "sounding": s.bottom[0, 2] - s.z,
        "ordered_course": math.nan if s.rudder_by_hand else s.ordered_psi,
        "ordered_depth": s.ordered_depth,
        "ordered_speed": math.nan if s.speed_by_hand else s.ordered_speed,
        "ordered_turns": s.ordered_u_c if s.speed_by_hand else s.command_u_c,
        "heel_rate": rates.heel,
        "pitch_rate": rates.pitch,
        "turn_rate": rates.heading,
        "north_rate": rates.north,
        "east_rate": rates.east,
        "depth_rate": rates.down,
        "way": rates.way,
        "track": math.atan2(rates.east, rates.north),
        "drift": math.hypot(north, east),
        "set": math.atan2(east, north),
        "heavy": (s.weight - c.buoyancy) / c.g,
        "clearance": height_of_keel(boat.plain, c.ell, keel_of(c)),
        "over_sail": s.z
        + s.eta_wave
        - c.x_sail * math.sin(s.theta)
        + c.z_sail * math.cos(s.theta) * math.cos(s.phi),
        "height": s.sea[0],
        "ordered_height": s.sea_target[0],
        "period": math.tau / s.sea[1],
        "ordered_period": math.tau / s.sea_target[1],
        "origin": s.sea[3] + math.pi,
        "ordered_origin": s.sea_target[3] + math.pi,
        **dict.fromkeys(("main_pressure", "vital_pressure"), 20.7e6),
        "main_level": 0.2,
        "vital_level": 0.08,
        "port_load": 78e3
        + 20e3 * bool(s.move_trim or s.trim_forward)
        + 40e3 * bool(s.move_depth_control or s.hover),
        "starboard_load": 76e3
        + 45e3 * bool(s.move_auxiliary or s.drained or s.trim_flood)
        + 60e3 * bool(s.compressor),
        "dc_load": 5.2e3,
        "charge": 1.0 - s.battery_spent / 43.2e9,
        "overload_left": math.nan,
    }
    for surface, letter in SURFACES.items():
        by_hand = s[f"{surface}_by_hand"]
        found[surface] = s[f"delta_{letter}"] * boat.toward[surface]
        ordered = s[f"{'ordered' if by_hand else 'command'}_{letter}"]
        found[f"ordered_{surface}"] = ordered * boat.toward[surface]
    for i, tank in enumerate(TANKS):
        name = tank.replace("compartment_", "flood_")
        found[name] = s.water[i]
        if i < 8:
            found[f"{name}_full"] = s.water[i] / c.capacity[i]
    for i, bank in enumerate(BANKS):
        found[bank] = s.bank[i] * c.gas / c.bank_volume[i]
        found[f"{bank}_full"] = s.bank[i] / c.bank_full[i]
    shown = {"course": s.psi, "depth": s.z, "speed": s.u, "pitch": s.theta}
    for i, (axis, now) in enumerate(shown.items()):
        found[f"crew_{axis}"] = s.crew_order[i]
        found[f"{axis}_error"] = s.crew_order[i] - now
        found[f"{axis}_since"] = s.tick - s.crew_order_tick[i] + 1.0
    return {name: float(value) for name, value in found.items()}


def test_each_reading_is_what_it_says(boat: Boat) -> None:
    read, wanted = readings_of(boat), expected(boat)

    assert read.keys() == wanted.keys()
    for name, value in wanted.items():
        assert read[name] == pytest.approx(value, rel=1e-12, abs=1e-12, nan_ok=True), name


def test_the_readings_of_many_states_are_those_of_each(boat: Boat) -> None:
    states: list[Any] = []
    read: list[dict[str, float]] = []
    for _ in range(5):
        take_ticks(boat, 7)
        states.append(boat.records.state["whole"][0].copy())
        read.append(readings_of(boat))

    rows = read_states(boat, np.array(states))

    places = {name: READING_OFFSETS[name] for name in read[0]}
    for row, each in zip(rows, read, strict=True):
        assert {name: row[place] for name, place in places.items()} == pytest.approx(
            each, abs=0.0, rel=0.0, nan_ok=True
        )


def remove(name: str, value: float = 0.0) -> Callable[[Boat], None]:
    """Return what sets numbers of the vessel or the state to a value."""

    def change(boat: Boat) -> None:
        record: Any = boat.vessel if name in (boat.vessel.dtype.names or ()) else boat.state
        record[name] = value

    return change


@pytest.mark.parametrize(
    ("change", "names"),
    [
        (remove("N_dr"), ("rudder", "ordered_rudder")),
        (remove("M_ds"), ("stern", "ordered_stern")),
        (remove("Z_db"), ("bow", "ordered_bow")),
        (remove("capacity"), ("forward", "trim_aft_full", "flood_centre")),
        (remove("bank_volume"), ("main", "emergency")),
        (remove("bank_full"), ("main_full", "emergency_full")),
        (remove("crew_order_tick"), ("crew_course", "course_error", "depth_since", "pitch_error")),
        (remove("bottom"), ("sounding", "clearance")),
        (remove("sea"), ("period", "origin")),
        (remove("sea_target"), ("ordered_period", "ordered_origin")),
        (remove("current"), ("set",)),
        (remove("speed_by_hand", 1.0), ("ordered_speed",)),
        (remove("by_hand", 1.0), ("ordered_course", "ordered_depth")),
    ],
)
def test_what_is_lacking_or_not_ordered_reads_nothing(
    boat: Boat, change: Callable[[Boat], None], names: tuple[str, ...]
) -> None:
    obey_all(boat, "autopilot on")
    before = readings_of(boat)

    change(boat)

    read = readings_of(boat)
    assert not any(math.isnan(before[name]) for name in names)
    assert all(math.isnan(read[name]) for name in names), names


def test_hovering_keeps_the_depth_with_all_planes_in_hand(boat: Boat) -> None:
    boat.state.by_hand[:], boat.state.hover = 1.0, 1.0

    assert readings_of(boat)["ordered_depth"] == boat.state.ordered_depth


def test_what_is_held_has_no_rate_and_a_boat_without_way_heads_its_track(boat: Boat) -> None:
    boat.state.held[:] = 1.0
    read = readings_of(boat)

    assert [read[name] for name in ("north_rate", "east_rate", "depth_rate", "way")] == [0.0] * 4
    assert read["track"] == boat.state.psi


@pytest.mark.parametrize(("side", "left"), [(0.0, 40.0), (-1.0, -320.0), (1.0, 40.0)])
def test_what_is_to_go_to_a_course_goes_the_way_that_was_ordered(
    boat: Boat, side: float, left: float
) -> None:
    s = boat.state
    s.crew_course_side, s.psi = side, 0.0
    s.crew_order[0] = math.radians(left)

    assert math.degrees(readings_of(boat)["course_error"]) == pytest.approx(left)


def test_a_turn_that_is_nearly_round_is_over(boat: Boat) -> None:
    s = boat.state
    s.crew_course_side, s.psi, s.crew_order[0] = 1.0, 0.1, 0.1 + math.radians(355.0)

    assert math.degrees(readings_of(boat)["course_error"]) == pytest.approx(-5.0)


def test_each_name_is_one_number() -> None:
    singles = [name for name in NAMES if not READINGS[name].shape]

    assert 8 * len(singles) == READINGS.itemsize
    assert STATE.names

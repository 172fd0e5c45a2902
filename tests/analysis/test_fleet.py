"""Boats flown many at once are the boats flown alone."""

import hashlib
import re
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from helpers.places import environment
from numba import config, float64, int64
from numba.types import Type  # type: ignore[attr-defined]

from trainer.analysis.fleet import tick as tick_module
from trainer.analysis.fleet.block import supports_boat, supports_scheme, tanks_rest
from trainer.analysis.fleet.ensemble import (
    NO_ORDERS,
    Ensemble,
    FleetFlight,
    Schedule,
    fly_members,
    orders,
)
from trainer.analysis.fleet.lanes import BLOCK_TYPE, LANE_COUNT, relay_kernel
from trainer.analysis.fleet.side_by_side import new_work
from trainer.boat import compilation, machine_code
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.core import kernel
from trainer.core.elementary import cosine, exponential, sine
from trainer.core.kernel import inlined
from trainer.core.kinematics import EXACT_TRIGONOMETRY, LINEAR_TRIGONOMETRY, POLYNOMIAL_TRIGONOMETRY
from trainer.core.state import STATE, new_scratch
from trainer.core.update import update

pytestmark = pytest.mark.process  # fleets are compiled

TICKS = 120
MEMBERS = LANE_COUNT + 5  # a whole block, and one that is not full
MakeBoat = Callable[..., Boat]
compiled = pytest.mark.skipif(config.DISABLE_JIT, reason="without JIT every member flies alone")  # type: ignore[attr-defined]


@pytest.fixture
def boat(make_boat: MakeBoat) -> Boat:
    """Return a boat of the modified set under way."""
    boat = make_boat(equations="modified")
    boat.start(5.0, 100.0, 0.0)
    boat.state.trim_by_hand = 1.0  # with water on the move a boat flies alone
    return boat


def fleet_of(boat: Boat, members: int) -> Ensemble:
    """Return so many of a boat."""
    records = boat.records
    return Ensemble(
        records.vessel, records.compact, records.scheme, np.repeat(records.state, members)
    )


def random_fleet(boat: Boat, seed: int) -> Ensemble:
    """Return members that differ in constants, gear, state and orders, some by hand."""
    random = np.random.default_rng(seed)
    vessels, compacts, states = (
        np.repeat(record, MEMBERS)
        for record in (boat.records.vessel, boat.records.compact, boat.records.state)
    )
    for name in compacts.dtype.names:  # type: ignore[union-attr]
        if name not in {"whole", "rho", "g", "mass"}:
            compacts[name] *= random.uniform(0.9, 1.1, compacts[name].shape)
    for flag in ("extended", "slipping"):
        compacts[flag] = random.choice([0.0, 1.0], MEMBERS)
    vessels["gain"] *= random.uniform(0.7, 1.3, vessels["gain"].shape)
    for name, choices in (
        ("surface_lag", (0.0, 1.5)),
        ("propulsion_lag", (0.0, 6.0)),
        ("telegraph_dead_time", (0.0, 2.0)),
        ("x_tail", (0.0, 1.0)),
    ):
        vessels[name] = random.choice(choices, MEMBERS)
    for name, spread in (("u", 0.3), ("v", 0.2), ("q", 0.005), ("phi", 0.1), ("theta", 0.1)):
        states[name] += random.normal(0.0, spread, MEMBERS)
    for name, low, high in (
        ("psi", -7.0, 7.0),
        ("ordered_psi", -7.0, 7.0),
        ("ordered_depth", 80.0, 120.0),
        ("ordered_speed", 1.0, 10.0),
        ("ordered_u_c", -5.0, 12.0),
        ("ordered_r", -0.4, 0.4),
        ("ordered_s", -0.1, 0.1),
    ):
        states[name] = random.uniform(low, high, MEMBERS)
    for name in ("rudder_by_hand", "stern_by_hand", "bow_by_hand", "speed_by_hand"):
        states[name] = random.choice([0.0, 1.0], MEMBERS)
    return Ensemble(vessels, compacts, boat.records.scheme, states)


def flown_alone(
    fleet: Ensemble,
    schedule: Schedule,
    ticks: int,
    columns: tuple[str, ...] = ("u", "z", "delta_s"),
) -> tuple[np.ndarray, np.ndarray]:
    """Return the states, and a row a tick, of members advanced by ``update`` one by one."""
    states = fleet.states.copy()
    rows = np.full((states.size, ticks + 1, len(columns)), np.nan)
    for member in range(states.size):
        vessel = fleet.vessels[member:][:1] if fleet.vessels.size > 1 else fleet.vessels
        compact = fleet.compacts[member:][:1] if fleet.compacts.size > 1 else fleet.compacts
        state, scratch = states[member : member + 1], new_scratch()
        row = min(member, len(schedule.tick) - 1)
        rows[member, 0] = [state[0][name] for name in columns]
        for tick in range(ticks):
            for i, due in enumerate(schedule.tick[row].tolist()):
                if due == tick:
                    state[0].whole[schedule.offset[row, i]] = schedule.value[row, i]
            if update(vessel, compact, fleet.scheme, state, scratch) != 0:
                break
            rows[member, tick + 1] = [state[0][name] for name in columns]
    return states, rows


def digest(states: np.ndarray) -> str:
    """Return the SHA-256 of states."""
    return hashlib.sha256(states["whole"].tobytes()).hexdigest()


def names_at(difference: np.ndarray) -> set[str]:
    """Return the fields that have places where there is a difference."""
    places = set(np.nonzero(difference.any(axis=0))[0].tolist())
    return {name for name in STATE.names or () if STATE_OFFSETS[name] in places}


def fly_as_alone(
    fleet: Ensemble, schedule: Schedule = NO_ORDERS, ticks: int = TICKS
) -> FleetFlight:
    """See that members flown at once end in all as those flown one by one; return the flight."""
    alone, rows = flown_alone(fleet, schedule, ticks)

    flown = fly_members(fleet, schedule, ticks, 1, ("u", "z", "delta_s"))

    different = fleet.states["whole"].view(np.uint64) != alone["whole"].view(np.uint64)
    assert names_at(different) == set()
    assert digest(fleet.states) == digest(alone)
    assert np.array_equal(flown.rows, rows, equal_nan=True)
    return flown


@pytest.fixture
def works(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Return where a fleet works, once it has flown."""
    made: list[Any] = []

    def make() -> Any:
        made.append(new_work())
        return made[0]

    monkeypatch.setattr("trainer.analysis.fleet.side_by_side.new_work", make)
    return made


@pytest.mark.parametrize(
    ("vessel", "equations", "trig", "step"),
    [
        ("bb2", "modified", EXACT_TRIGONOMETRY, 0.5),
        ("bb2", "modified", POLYNOMIAL_TRIGONOMETRY, 1.0),
        ("bb2", "basic", LINEAR_TRIGONOMETRY, 0.5),
        ("sdv-mk9", "modified", EXACT_TRIGONOMETRY, 0.1),
        ("remus100", "modified", EXACT_TRIGONOMETRY, 0.05),
    ],
)
def test_every_number_of_a_member_is_that_of_the_boat_flown_alone(
    make_boat: MakeBoat, vessel: str, equations: str, trig: int, step: float
) -> None:
    boat = make_boat(vessel, equations, step=step)
    boat.records.scheme["trig"] = trig
    boat.start(2.0 if vessel != "bb2" else 5.0, 100.0, 0.0)
    fleet = random_fleet(boat, 7)

    rows = fly_as_alone(fleet).rows

    assert np.isfinite(rows[:, -1]).all(axis=1).sum() > MEMBERS // 2, "most come to the end"


@compiled
def test_ordinary_members_are_not_flown_alone(boat: Boat, works: list[Any]) -> None:
    fly_members(fleet_of(boat, LANE_COUNT), NO_ORDERS, 10, 10, ("z",))

    assert works[0].alone.tolist() == [0] * LANE_COUNT
    numbers = works[0].block.reshape(-1, LANE_COUNT)
    assert numbers[STATE_OFFSETS["tick"]].tolist() == [10.0] * LANE_COUNT


def test_members_obey_at_ticks_of_their_own(boat: Boat) -> None:
    random = np.random.default_rng(5)
    fleet = random_fleet(boat, 8)
    names = ("ordered_depth", "ordered_psi", "rudder_by_hand", "x", "sea_height", "held_depth")
    place = random.choice([STATE_OFFSETS[name] for name in names], (MEMBERS, 4))
    schedule = orders(
        random.integers(0, TICKS, (MEMBERS, 4)), place, random.uniform(0.0, 3.0, place.shape)
    )
    fleet.states["sea_omega"] = 0.6

    fly_as_alone(fleet, schedule)


def test_a_member_that_comes_up_from_the_deep_feels_the_surface(boat: Boat) -> None:
    fleet = fleet_of(boat, 4)
    fleet.states["ordered_depth"] = [100.0, 20.0, 100.0, 30.0]
    fleet.states["z"] = [100.0, 41.0, 100.0, 36.0]

    fly_as_alone(fleet)

    assert min(fleet.states["z"]) < 35.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("sea_height", 3.0),
        ("casualty", 1.0),
        ("held_position", 1.0),
        ("depth_law", 1.0),
        ("move_trim", 500.0),
        ("hover", 1.0),
        ("breach_aft", 0.01),
        ("negative_flood", 1.0),
        ("compressor", 1.0),
        ("drained", 2.0),
        ("trim_by_hand", 0.0),
        ("wave_share", 0.5),
        ("ascent", 1.0),
    ],
)
def test_a_boat_with_more_going_on_is_no_ordinary_one_and_flies_among_them(
    boat: Boat, name: str, value: float
) -> None:
    fleet = fleet_of(boat, 3)
    fleet.states["sea_omega"] = 0.6
    fleet.states[1].whole[STATE_OFFSETS[name]] = value

    assert [supports_boat(fleet.vessels, fleet.states[i : i + 1]) for i in range(3)] == [1, 0, 1]
    fly_as_alone(fleet, ticks=30)


@compiled
def test_members_off_centre_fly_alone_and_the_others_side_by_side(
    boat: Boat, works: list[Any]
) -> None:
    fleet = fleet_of(boat, 4)._replace(compacts=np.repeat(boat.records.compact, 4))
    fleet.compacts["off_centre"][1] = 1.0
    fleet.compacts["YB"][1] = 1e5
    fleet.states["water"][2] -= 1.0
    fleet = fleet._replace(vessels=np.repeat(boat.records.vessel, 4))
    fleet.vessels["y"][2] = 0.5  # of the tanks: seen when their water is weighed

    fly_as_alone(fleet, ticks=30)

    assert works[0].alone[:4].tolist() == [0, 1, 1, 0]


def test_a_boat_whose_buoyancy_varies_with_depth_is_no_ordinary_one(boat: Boat) -> None:
    for name in ("compressibility", "layers"):
        vessel = boat.records.vessel.copy()
        vessel[name] = 1.0

        assert tanks_rest(vessel, boat.records.state)
        assert not supports_boat(vessel, boat.records.state)


@pytest.mark.parametrize(
    ("equations", "rates", "integrator"),
    [
        ("full", "lagged", "adams2"),
        ("modified", "exact", "adams2"),
        ("modified", "lagged", "rk4"),
        ("modified", "lagged", "adams3"),
    ],
)
def test_other_ways_to_compute_a_fleet_are_flown_alone(
    make_boat: MakeBoat, equations: str, rates: str, integrator: str
) -> None:
    boat = make_boat("bb2", equations, rates, integrator)
    boat.start(5.0, 100.0, 0.0)
    fleet = random_fleet(boat, 9)

    assert not supports_scheme(boat.records.scheme)
    fly_as_alone(fleet, ticks=20)


def test_armed_triggers_fire_in_a_fleet(boat: Boat) -> None:
    boat.records.scheme["trigger_kind"][0, 0] = 1.0
    boat.records.scheme["trigger_place"][0, 0] = STATE_OFFSETS["tick"]
    boat.records.scheme["trigger_sense"][0, 0] = 1.0
    boat.records.scheme["trigger_threshold"][0, 0] = 5.0
    fleet = fleet_of(boat, 2)

    fly_members(fleet, NO_ORDERS, 10, 10, ("z",))

    assert fleet.states["triggers_spent"].tolist() == [1.0, 1.0]


def test_gains_follow_the_speed_through_the_schedule(boat: Boat) -> None:
    fleet = fleet_of(boat, 3)
    speeds = boat.vessel.gain_speed
    fleet.states["u"] = fleet.states["ordered_speed"] = [speeds[0], speeds[3], speeds[4] - 0.01]
    fleet.states["ordered_speed"] = [speeds[5], speeds[0], speeds[7]]
    fleet.states["ordered_psi"] = 0.5

    rows = fly_as_alone(fleet, ticks=400).rows

    brackets = np.searchsorted(speeds[: int(boat.vessel.gain_count)], rows[:, :, 0])
    assert (np.ptp(brackets, axis=1) >= 1).all(), "each leaves the bracket it began in"


def test_a_boat_without_autopilot_may_follow_one_that_has_it(boat: Boat) -> None:
    fleet = random_fleet(boat, 11)
    fleet.vessels["gain_count"][LANE_COUNT:] = 0.0  # in lanes that had one

    fly_as_alone(fleet, ticks=30)


def test_an_order_acts_before_its_tick(boat: Boat) -> None:
    fleet = fleet_of(boat, 2)
    places = [STATE_OFFSETS["ordered_r"], STATE_OFFSETS["rudder_by_hand"]]
    schedule = orders([3, 3], places, [[0.1, 1.0], [0.2, 1.0]])

    flown = fly_members(fleet, schedule, 5, 1, ("command_r", "ordered_r"))

    assert flown.rows[:, 3] == pytest.approx(np.zeros((2, 2)), abs=1e-12)
    assert flown.rows[:, 4].tolist() == [[0.1, 0.1], [0.2, 0.2]]


def test_a_member_whose_numbers_are_lost_stays_and_the_others_go_on(boat: Boat) -> None:
    fleet = fleet_of(boat, 3)
    schedule = orders(4, STATE_OFFSETS["q"], [[0.0], [np.inf], [0.0]])

    flown = fly_members(fleet, schedule, 10, 2, ("tick",))

    assert flown.lost.tolist() == [-1, 4, -1]
    assert fleet.states["tick"].tolist() == [10.0, 4.0, 10.0]
    assert np.isnan(flown.rows[1, 3:]).all()
    assert not np.isnan(flown.rows[[0, 2]]).any()


def test_a_member_lost_on_the_way_has_rows_up_to_there(boat: Boat) -> None:
    fleet = fleet_of(boat, 3)
    fleet = fleet._replace(
        vessels=np.repeat(fleet.vessels, 3), compacts=np.repeat(fleet.compacts, 3)
    )
    fleet.compacts["K_p"][1] *= -5.0  # the water feeds her roll
    fleet.states["p"][1], fleet.states["ordered_psi"] = 0.1, 1.0

    flown = fly_as_alone(fleet)

    assert 0 < flown.lost[1] < TICKS
    assert np.isnan(flown.rows[1, flown.lost[1] + 1]).all()


def test_fleets_in_threads_are_those_flown_one_after_the_other(boat: Boat) -> None:
    fleets = [random_fleet(boat, seed) for seed in (1, 2, 1, 2)]
    long = 20 * TICKS  # that they do overlap

    with ThreadPoolExecutor(2) as pool:
        list(pool.map(lambda fleet: fly_members(fleet, NO_ORDERS, long, long, ("z",)), fleets[:2]))
    for fleet in fleets[2:]:
        fly_members(fleet, NO_ORDERS, long, long, ("z",))

    assert digest(fleets[0].states) == digest(fleets[2].states)
    assert digest(fleets[1].states) == digest(fleets[3].states)


@compiled
@pytest.mark.parametrize(
    ("name", "first"),
    [
        ("compute_rates", int64),
        pytest.param("deflect_surfaces", float64, marks=pytest.mark.slow),
        pytest.param("advance_command_speed", float64, marks=pytest.mark.slow),
    ],
)
def test_boats_side_by_side_are_vector_code(name: str, first: Type) -> None:
    # a cached kernel cannot be looked into
    fresh = inlined(getattr(tick_module, name).py_func).dispatcher
    fresh.compile((first, BLOCK_TYPE))

    assert re.search(r"<\d+ x double>", fresh.inspect_llvm(fresh.signatures[0]))


@compiled
@pytest.mark.parametrize("function", [sine, cosine, exponential])
def test_elementary_functions_have_the_same_bits_in_a_lane(function: Callable) -> None:  # type: ignore[type-arg]
    in_lane = relay_kernel(function, tick_module.LANE_KERNELS)
    random = np.random.default_rng(3)
    arguments = [
        *random.uniform(-20.0, 20.0, 3000),
        *random.uniform(-1e5, 1e5, 1000),
        *(k * np.pi / 4 for k in range(-9, 10)),
        *(0.0, -0.0, 1e9, -1e12, 700.0, -800.0),
    ]

    for x in arguments:
        assert np.float64(in_lane(x)).tobytes() == np.float64(function(x)).tobytes()


@pytest.mark.slow
def test_a_fleet_without_vector_code_is_flown_to_the_same_bits(
    boat: Boat, monkeypatch: pytest.MonkeyPatch
) -> None:
    fleets = [random_fleet(boat, 11) for _ in range(2)]
    schedule = orders(
        [3, 40, 40],
        [STATE_OFFSETS["ordered_depth"], STATE_OFFSETS["ordered_r"], STATE_OFFSETS["ordered_psi"]],
        [90.0, 0.2, 0.0],
    )
    first = fly_members(fleets[0], schedule, TICKS, 2, ("u", "z", "psi"))

    monkeypatch.setattr(kernel, "TESTED_NUMBA", ((9, 0), (9, 1)))
    assert not compilation.known_compiler()
    monkeypatch.setitem(sys.modules, "trainer.analysis.fleet.side_by_side", None)
    second = fly_members(fleets[1], schedule, TICKS, 2, ("u", "z", "psi"))

    assert digest(fleets[0].states) == digest(fleets[1].states)
    assert np.array_equal(first.rows, second.rows, equal_nan=True)
    assert np.array_equal(first.lost, second.lost)


@compiled
def test_the_compiler_is_one_that_vector_code_was_tested_with() -> None:
    assert compilation.known_compiler(), (
        f"numba {numba.__version__} is not within TESTED of core/kernel.py: fleets fly one by one "
        "with it, ticks are slower, nothing is exported. Extend it, and run this, test_tick.py "
        "and test_export.py."
    )


FLEET_IN_A_NEW_PROCESS = """
import numpy as np
from trainer.analysis.fleet import shipped
from trainer.analysis.sweep.fleets import by_files, start_members
from trainer.boat.assemble import Method
from trainer.config.vessel import load_vessel

method = Method("modified", "lagged", "exact", "adams2", 0.5)
fleet, able = start_members(by_files([load_vessel("bb2")], method), method, np.array([5.0]), 0, ())
compiled = [each.__name__ for each in shipped.SHIPPED_KERNELS if "dispatcher" in vars(each)]
print(f"fit {able.astype(float)}, compiled {compiled}")
"""


@compiled
@pytest.mark.skipif(
    machine_code.way_name() == machine_code.BY_NUMBA, reason="no machine code is shipped for this"
)
def test_a_fleet_does_not_compile_what_is_shipped(tmp_path: Path) -> None:
    told = subprocess.run(
        [sys.executable, "-c", FLEET_IN_A_NEW_PROCESS],
        env=environment(XDG_CACHE_HOME=str(tmp_path)),  # nothing is compiled yet
        capture_output=True,
        text=True,
        check=True,
    )

    assert told.stdout == "fit [1.], compiled []\n"

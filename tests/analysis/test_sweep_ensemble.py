"""Boats flown many at once are the boats flown alone."""

import hashlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from trainer.analysis.sweep.ensemble import (
    NO_ORDERS,
    Ensemble,
    EnsembleFlight,
    Schedule,
    fly_members,
    orders,
)
from trainer.boat.boat import STATE_OFFSETS, Boat
from trainer.core.kinematics import EXACT_TRIGONOMETRY, LINEAR_TRIGONOMETRY, POLYNOMIAL_TRIGONOMETRY
from trainer.core.state import STATE, new_scratch
from trainer.core.update import update

TICKS = 120
MEMBERS = 7
MakeBoat = Callable[..., Boat]


@pytest.fixture
def boat(make_boat: MakeBoat) -> Boat:
    """Return a boat of the modified set under way."""
    boat = make_boat(equations="modified")
    boat.start(5.0, 100.0, 0.0)
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
) -> EnsembleFlight:
    """See that members flown at once end in all as those flown one by one; return the flight."""
    alone, rows = flown_alone(fleet, schedule, ticks)

    flown = fly_members(fleet, schedule, ticks, ("u", "z", "delta_s"))

    different = fleet.states["whole"].view(np.uint64) != alone["whole"].view(np.uint64)
    assert names_at(different) == set()
    assert digest(fleet.states) == digest(alone)
    assert np.array_equal(flown.rows, rows, equal_nan=True)
    return flown


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
    ("equations", "rates", "integrator"),
    [
        ("full", "lagged", "adams2"),
        ("modified", "exact", "adams2"),
        ("modified", "lagged", "rk4"),
        ("modified", "lagged", "adams3"),
    ],
)
def test_a_member_flies_by_any_equations_and_integrator(
    make_boat: MakeBoat, equations: str, rates: str, integrator: str
) -> None:
    boat = make_boat("bb2", equations, rates, integrator)
    boat.start(5.0, 100.0, 0.0)
    fleet = random_fleet(boat, 9)

    fly_as_alone(fleet, ticks=20)


def test_armed_triggers_fire_in_a_fleet(boat: Boat) -> None:
    boat.records.scheme["trigger_kind"][0, 0] = 1.0
    boat.records.scheme["trigger_place"][0, 0] = STATE_OFFSETS["tick"]
    boat.records.scheme["trigger_sense"][0, 0] = 1.0
    boat.records.scheme["trigger_threshold"][0, 0] = 5.0
    fleet = fleet_of(boat, 2)

    fly_members(fleet, NO_ORDERS, 10, ("z",))

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
    fleet.vessels["gain_count"][1:] = 0.0

    fly_as_alone(fleet, ticks=30)


def test_an_order_acts_before_its_tick(boat: Boat) -> None:
    fleet = fleet_of(boat, 2)
    places = [STATE_OFFSETS["ordered_r"], STATE_OFFSETS["rudder_by_hand"]]
    schedule = orders([3, 3], places, [[0.1, 1.0], [0.2, 1.0]])

    flown = fly_members(fleet, schedule, 5, ("command_r", "ordered_r"))

    assert flown.rows[:, 3] == pytest.approx(np.zeros((2, 2)), abs=1e-12)
    assert flown.rows[:, 4].tolist() == [[0.1, 0.1], [0.2, 0.2]]


def test_a_member_whose_numbers_are_lost_stays_and_the_others_go_on(boat: Boat) -> None:
    fleet = fleet_of(boat, 3)
    schedule = orders(4, STATE_OFFSETS["q"], [[0.0], [np.inf], [0.0]])

    flown = fly_members(fleet, schedule, 10, ("tick",))

    assert flown.lost.tolist() == [-1, 4, -1]
    assert fleet.states["tick"].tolist() == [10.0, 4.0, 10.0]
    assert np.isnan(flown.rows[1, 5:]).all()
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
        list(pool.map(lambda fleet: fly_members(fleet, NO_ORDERS, long, ("z",)), fleets[:2]))
    for fleet in fleets[2:]:
        fly_members(fleet, NO_ORDERS, long, ("z",))

    assert digest(fleets[0].states) == digest(fleets[2].states)
    assert digest(fleets[1].states) == digest(fleets[3].states)

"""One tick: what it never does to the state, and the surfaces and the engine it moves."""

import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers import places
from helpers.boats import make_boat, start_bb2, take_ticks
from helpers.installation import run_program

from trainer.boat.assemble import Method, fit_out
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import load_vessel
from trainer.config.world.sea import load_sea
from trainer.core.actuators import move_surfaces
from trainer.core.propulsion import answer_telegraph, excess_eta, thrust
from trainer.core.state import STATE
from trainer.core.update import WATCHED_NAMES, update

KNOT = 1852.0 / 3600.0
DEGREE = math.pi / 180.0
EQUATIONS = ("full", "modified", "basic", "longitudinal")


def under_way(*method: str) -> Boat:
    """Return a BB2 in the middle of a turn and a dive."""
    boat = start_bb2(*method)
    s = boat.state
    s.rudder_by_hand = s.stern_by_hand = s.bow_by_hand = 1.0
    s.ordered_r, s.ordered_s = 0.2, 0.05
    take_ticks(boat, 20)
    return boat


# A tick that fails


@pytest.mark.laws
@pytest.mark.core
@pytest.mark.parametrize(
    ("place", "value", "named"),
    [("v", 1e200, "udot"), ("x", math.inf, "x"), ("psi", math.nan, "xdot"), ("q", -1e160, "udot")],
)
def test_a_tick_that_fails_leaves_the_state_as_it_was_and_names_the_place(
    place: str, value: float, named: str
) -> None:
    boat = under_way()
    boat.state[place] = value
    before = boat.records.state.tobytes()

    with np.errstate(all="ignore"):  # without JIT numpy would warn where the core reports
        status = boat.tick()

    assert boat.records.state.tobytes() == before
    assert WATCHED_NAMES[status - 1] == named
    assert boat.failure(status).startswith(f"{named} is out of all bounds after tick 20 (10 s)")


@pytest.mark.core
def test_a_tick_that_fails_in_a_sea_leaves_the_waves_as_they_were() -> None:
    boat = under_way()
    boat.put_to_sea(load_sea("sea-state-5"))
    take_ticks(boat, 4)
    boat.state.v = 1e200
    before = boat.records.state.tobytes()
    with np.errstate(all="ignore"):
        assert boat.tick() != 0

    assert boat.records.state.tobytes() == before


@pytest.mark.core
def test_a_tick_after_a_failed_one_is_as_if_it_had_never_been_tried() -> None:
    tried, untried = under_way(), under_way()
    good = tried.snapshot()
    tried.state.v = 1e200
    with np.errstate(all="ignore"):
        assert tried.tick() != 0
    tried.restore(good)

    assert [boat.tick() for boat in (tried, untried)] == [0, 0]

    assert tried.records.state.tobytes() == untried.records.state.tobytes()


# What a state record is


def test_a_snapshot_is_at_most_four_kibibytes() -> None:
    assert STATE.itemsize <= 4096


@pytest.mark.core
@pytest.mark.parametrize("equations", EQUATIONS)
@pytest.mark.parametrize("integrator", ["adams2", "adams3", "abm4", "rk4", "rkv"])
def test_a_turn_goes_on_from_a_snapshot_to_the_bit(equations: str, integrator: str) -> None:
    boat, other = (under_way(equations, "lagged", integrator) for _ in range(2))
    for each in (boat, other):
        each.put_to_sea(load_sea("sea-state-5"))
        each.state.sea_cosines = 0.5
    assert boat.tick() == 0
    snapshot = boat.snapshot()
    ends: list[bytes] = []
    for each in (boat, boat, other):  # nothing hides elsewhere
        if ends:
            each.restore(snapshot)
        take_ticks(each, 20)
        ends.append(each.records.state.tobytes())

    assert ends[0] == ends[1] == ends[2]
    assert ends[0] != snapshot.tobytes()


COUNT_ALLOCATIONS = """
import numpy as np
from numba import njit
from numba.core.runtime import rtsys

from trainer.boat.boat import Boat
from trainer.core.update import update
from trainer.boat.casualties import insert_casualty
from trainer.boat.assemble import Method
from helpers.loops import CASUALTY_KINDS
from trainer.config.world.sea import load_sea
from trainer.config.boat.vessel import load_vessel

@njit
def ticks(count, vessel, compact, scheme, state, scratch):
    for _ in range(count):
        update(vessel, compact, scheme, state, scratch)

@njit
def wasteful(count, vessel, compact, scheme, state, scratch):
    for i in range(count):
        state[0].y += np.zeros(3 + i).sum()

for equations in ("full", "modified", "basic", "longitudinal"):
    for integrator in ("adams2", "rk4", "rkv"):
        for rates in ("exact", "lagged"):
            method = Method(equations, rates, "exact", integrator, 0.5)
            boat = Boat(load_vessel("bb2"), method)
            boat.start(5.0, 60.0, 0.0)
            if equations != "longitudinal":  # a sea of all generators, tanks at work, casualties
                boat.put_to_sea(load_sea("sea-state-5"))
                boat.state.sea_cosines = boat.state.sea_1969 = boat.state.sea_peaked = 0.5
                boat.state.hover = 1.0
                boat.state.blow[0] = boat.state.vent[2] = 1.0
                for name in CASUALTY_KINDS:
                    assert isinstance(insert_casualty(boat, name), str)
            for run in (ticks, wasteful):
                run(0, *boat.records)  # numba counts once it has compiled something
                found = []
                for count in (1, 1, 1001):
                    before = rtsys.get_allocation_stats()
                    run(count, *boat.records)
                    after = rtsys.get_allocation_stats()
                    found.append(after.alloc - before.alloc)
                print(run.__name__, found[2] - found[1])
"""


@pytest.mark.process
@pytest.mark.slow
def test_a_thousand_ticks_allocate_nothing(tmp_path: Path) -> None:
    # the call from Python itself wraps its arguments: what counts is what more ticks add to that
    ran = run_program(
        [sys.executable, "-c", COUNT_ALLOCATIONS],
        cwd=tmp_path,
        env=places.tests_environment(NUMBA_NRT_STATS="1", NUMBA_DISABLE_JIT="0"),
    )
    counts = [line.split() for line in ran.stdout.splitlines()]

    assert [number for name, number in counts if name == "ticks"] == ["0"] * 24
    # the measure sees an allocation where there is one
    assert [number for name, number in counts if name == "wasteful"] == ["1000"] * 24


def test_a_tick_leaves_nothing_behind_in_the_interpreter() -> None:
    boat = under_way()
    blocks = []
    for _ in range(3):
        for _ in range(1000):
            update(*boat.records)
        blocks.append(sys.getallocatedblocks())
    assert blocks[2] - blocks[1] < 50


# Control surfaces


def told(boat: Boat, rudder: float, stern: float, bow: float = 0.0) -> None:
    """Command the surfaces [deg]."""
    s = boat.state
    s.command_r, s.command_s, s.command_b = rudder * DEGREE, stern * DEGREE, bow * DEGREE


def standing(boat: Boat) -> list[float]:
    """Return rudder, stern planes and bow planes [deg]."""
    return [float(angle) / DEGREE for angle in boat.state.surface]


@pytest.mark.laws
@pytest.mark.core
def test_surfaces_move_at_7_1_degrees_a_second_and_stop_at_30() -> None:
    boat = make_boat("bb2")
    told(boat, -90.0, 0.0, 90.0)
    seen = []
    for _ in range(10):
        move_surfaces(boat.records.vessel, 0.5, boat.records.state)
        seen.append(standing(boat))

    travel = [min(0.5 * 7.1 * (i + 1), 30.0) for i in range(10)]
    assert [s[0] for s in seen] == pytest.approx([-angle for angle in travel], rel=1e-12)
    assert [s[2] for s in seen] == pytest.approx(travel, rel=1e-12)


@pytest.mark.core
def test_a_lagging_surface_covers_its_share_of_the_way_each_tick() -> None:
    # time constant 0.1 s, step 0.1 s: 1 - 1/e of the way, slower than its rate of 20 deg/s
    boat = make_boat("sdv-mk9")
    told(boat, 3.0, -3.0)
    for ticks in (1, 2, 3):
        move_surfaces(boat.records.vessel, 0.1, boat.records.state)
        way = 3.0 * (1.0 - math.exp(-ticks))
        assert standing(boat) == pytest.approx([way, -way, 0.0], rel=1e-12)


@pytest.mark.core
@pytest.mark.parametrize(
    ("rudder", "stern", "reached"),
    [
        # pairs of planes stand at stern + rudder and stern - rudder, each within 30
        (25.0, 20.0, (17.5, 12.5)),
        (-25.0, 20.0, (-17.5, 12.5)),
        (30.0, -30.0, (15.0, -15.0)),
        (20.0, 10.0, (20.0, 10.0)),
    ],
)
def test_rudder_and_stern_planes_of_an_x_tail_share_30_degrees(
    rudder: float, stern: float, reached: tuple[float, float]
) -> None:
    boat = make_boat("bb2")
    told(boat, rudder, stern)
    for _ in range(40):
        move_surfaces(boat.records.vessel, 0.5, boat.records.state)
        now = standing(boat)
        assert abs(now[0]) + abs(now[1]) <= 30.0 + 1e-12
    assert now[:2] == pytest.approx(reached, rel=1e-12)


@pytest.mark.core
def test_rudder_and_stern_planes_of_a_cruciform_tail_each_have_all_of_their_travel() -> None:
    boat = make_boat("sdv-mk9")
    told(boat, 90.0, -90.0)
    for _ in range(200):
        move_surfaces(boat.records.vessel, 0.1, boat.records.state)
    assert standing(boat) == pytest.approx([20.0, -20.0, 0.0], rel=1e-9)


# Engine


@pytest.mark.core
def test_revolutions_wait_three_seconds_and_then_close_in_with_six() -> None:
    boat = make_boat("bb2")
    s = boat.state
    s.speed_by_hand = 1.0
    s.u_c = s.telegraph_order = s.telegraph_answer = 5.0
    s.ordered_u_c = s.command_u_c = 2.0
    seen = []
    for _ in range(30):
        answer_telegraph(boat.records.vessel, 0.5, boat.records.state)
        seen.append(float(s.u_c))

    assert seen[:6] == [5.0] * 6
    lag = [2.0 + 3.0 * math.exp(-0.5 * (i + 1) / 6.0) for i in range(24)]
    assert seen[6:] == pytest.approx(lag, rel=1e-12)


@pytest.mark.core
def test_a_second_bell_before_the_first_is_answered_starts_the_wait_again() -> None:
    boat = make_boat("bb2")
    s = boat.state
    s.speed_by_hand = 1.0
    s.u_c = s.telegraph_order = s.telegraph_answer = 5.0
    for order, ticks in ((2.0, 4), (-1.0, 6)):
        s.ordered_u_c = s.command_u_c = order
        for _ in range(ticks):
            answer_telegraph(boat.records.vessel, 0.5, boat.records.state)
            assert s.u_c == 5.0

    answer_telegraph(boat.records.vessel, 0.5, boat.records.state)

    assert s.u_c == pytest.approx(-1.0 + 6.0 * math.exp(-0.5 / 6.0), rel=1e-12)


@pytest.mark.core
@pytest.mark.parametrize(
    ("u", "u_c", "row"),
    [
        (4.0, 4.0, 1),
        (4.0, 2.0, 1),  # eta 0.5 is of the first row
        (4.0, 1.99, 2),
        (4.0, 0.0, 2),  # eta 0 of the second
        (4.0, -0.01, 3),
        (0.0, 3.0, 1),  # at rest the sign of the revolutions decides
        (0.0, -3.0, 3),
        (-1.0, 3.0, 1),
        (-1.0, 0.0, 1),
        (-1.0, -3.0, 3),
    ],
)
def test_the_row_of_thrust_is_that_of_its_eta(u: float, u_c: float, row: int) -> None:
    # model document, section 2, Propulsion: by comparison, without dividing
    boat = make_boat("bb2")
    c, s = boat.vessel, boat.state
    c.eta_1, c.eta_2 = 0.5, 0.0
    rows = {1: (-2.0, 0.5, 1.5), 2: (-3.0, 0.25, 7.0), 3: (-5.0, 0.125, -11.0)}
    for number, (a, b, k) in rows.items():
        c[f"a{number}"], c[f"b{number}"], c[f"c{number}"] = a, b, k
    s.u, s.u_c = u, u_c

    a, b, k = rows[row]
    assert thrust(boat.records.vessel, boat.records.state) == pytest.approx(
        a * u * abs(u) + b * u * u_c + k * u_c * u_c, rel=1e-15
    )


@pytest.mark.core
@pytest.mark.parametrize(
    ("u", "v", "w", "u_c", "ahead", "whole"),  # the row by u, and by U
    [
        (4.0, 0.0, 0.0, 2.0, 1, 1),
        (4.0, 3.0, 0.0, 2.5, 1, 1),  # u_c/u 0.625, u_c/U 0.5
        (4.0, 3.0, 0.0, 2.4, 1, 2),
        (4.0, 0.0, -3.0, 2.4, 1, 2),
        (4.0, 3.0, 0.0, -0.1, 3, 3),
        (0.0, 5.0, 0.0, 2.4, 1, 2),  # athwart U is not 0
        (0.0, 0.0, 0.0, -2.4, 3, 3),
    ],
)
def test_eta_is_by_speed_ahead_or_by_the_whole_speed(
    u: float, v: float, w: float, u_c: float, ahead: int, whole: int
) -> None:
    # errata A28: u_c/u, and as an option u_c/U, in thrust rows and in the terms of eta - 1
    file = load_vessel("bb2")
    option = replace(file, propulsion=replace(file.propulsion, eta_speed="whole"))
    for boat, row, speed in (
        (file, ahead, u),
        (option, whole, math.sqrt(u * u + v * v + w * w)),
    ):
        records = fit_out(boat, Method("modified", "lagged", "exact", "adams2", 0.5))
        s = records.state[0]
        s.u, s.v, s.w, s.u_c = u, v, w, u_c
        for constants in (records.vessel, records.compact):
            c = constants[0]
            c.eta_1, c.eta_2 = 0.5, 0.0
            for number in (1, 2, 3):
                c[f"a{number}"] = c[f"b{number}"] = 0.0
                c[f"c{number}"] = number
            assert thrust(constants, records.state) == pytest.approx(row * u_c * u_c, rel=1e-15)
        slip = u_c / speed - 1.0 if speed else 0.0
        assert excess_eta(records.vessel, records.state) == pytest.approx(slip, abs=1e-15)

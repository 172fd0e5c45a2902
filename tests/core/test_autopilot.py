"""What the autopilot promises of depth, course and speed.

Figures without another source are this project's own limits.
"""

import json
import math

import numpy as np
import pytest
from helpers.boats import start_boat
from helpers.places import DATA
from numpy.typing import NDArray

from trainer.boat.boat import Boat
from trainer.core.autopilot.reference import slewed_rate
from trainer.core.autopilot.report_law import report_angle, report_law
from trainer.core.autopilot.steering import REPORT_LAW, REPORT_LITERAL
from trainer.core.state import new_state
from trainer.core.vessel import VESSEL
from trainer.units import FOOT, KNOT

pytestmark = [pytest.mark.core, pytest.mark.long]

STEPS = {"bb2": 0.5, "sdv-mk9": 0.1, "remus100": 0.05}
DEGREE = math.radians(1.0)


def start(knots: float, equations: str = "full", vessel: str = "bb2") -> Boat:
    """Return a boat started on autopilot, 100 m deep, course north."""
    return start_boat(knots * KNOT, 100.0, vessel=vessel, equations=equations, step=STEPS[vessel])


@pytest.fixture
def boat() -> Boat:
    return start(10.0)


def sail(boat: Boat, seconds: float) -> dict[str, NDArray[np.float64]]:
    """Return depth below 100 m [m], pitch, course and heel [deg] after each tick, as columns."""
    s = boat.state
    rows = []
    for _ in range(round(seconds / boat.method.step)):
        assert boat.tick() == 0
        assert np.all(np.abs(s.command) <= boat.vessel.limit)
        rows.append((s.z - 100.0, s.theta / DEGREE, s.psi / DEGREE, s.phi / DEGREE))
    return dict(zip(("depth", "pitch", "course", "heel"), np.array(rows).T, strict=True))


def last(column: NDArray[np.float64], share: float = 0.2) -> NDArray[np.float64]:
    """Return the end of a column."""
    return column[-int(share * len(column)) :]


def turn_by_hand(boat: Boat, degrees: float) -> None:
    """Order right rudder and constant revolutions, depth still automatic."""
    s = boat.state
    s.speed_by_hand = s.rudder_by_hand = 1.0
    s.ordered_r = -degrees * DEGREE


# --- turns


@pytest.mark.parametrize("equations", ["full", "modified"])
def test_depth_holds_in_a_15_degree_turn_at_10_knots(equations: str) -> None:
    boat = start(10.0, equations)
    turn_by_hand(boat, 15.0)
    run = sail(boat, 900.0)

    assert np.abs(run["depth"]).max() < 5.0
    assert np.abs(last(run["depth"])).max() < 0.5


@pytest.mark.parametrize("knots", [6.0, 10.0, 15.0, 20.0])
@pytest.mark.parametrize("degrees", [10.0, 30.0])
def test_depth_comes_back_in_every_turn(knots: float, degrees: float) -> None:
    # hard over, the X-tail leaves the stern planes only what they wrest from the rudder
    boat = start(knots)
    turn_by_hand(boat, degrees)
    run = sail(boat, 900.0)

    assert np.abs(run["depth"]).max() < (4.0 if degrees < 20.0 else 20.0)
    assert np.abs(last(run["depth"])).max() < 1.0
    assert np.abs(run["pitch"]).max() < 13.0


def test_in_a_hard_turn_the_bow_planes_leave_the_tail_to_the_rudder() -> None:
    # the stern planes, out of room on the X-tail, do not relieve the bow planes
    boat = start(15.0)
    turn_by_hand(boat, 30.0)
    sail(boat, 600.0)

    assert abs(boat.state.delta_r) > 25.0 * DEGREE
    assert abs(boat.state.delta_b) > 10.0 * DEGREE


def test_lasting_angles_go_to_the_stern_planes() -> None:
    boat = start(12.0)
    turn_by_hand(boat, 10.0)
    sail(boat, 30.0)
    soon = abs(boat.state.delta_b)
    sail(boat, 600.0)

    assert soon > 2.0 * DEGREE
    assert abs(boat.state.delta_b) < 0.1 * DEGREE
    assert abs(boat.state.delta_s) > 0.5 * DEGREE


def test_the_reports_law_leaves_the_boat_12_metres_deep(boat: Boat) -> None:
    # known of BB2 and this law: it has no integral (errata G4)
    turn_by_hand(boat, 15.0)
    boat.state.depth_law = REPORT_LAW
    run = sail(boat, 900.0)

    assert last(run["depth"]).mean() == pytest.approx(12.0, abs=1.5)


# --- depth changes


@pytest.mark.parametrize("equations", ["full", "modified"])
@pytest.mark.parametrize("knots", [6.0, 8.0, 10.0, 15.0, 20.0])
@pytest.mark.parametrize("change", [50.0, -50.0])
def test_a_50_metre_depth_change_overshoots_by_less_than_a_metre(
    equations: str, knots: float, change: float
) -> None:
    boat = start(knots, equations)
    boat.state.ordered_depth = 100.0 + change
    run = sail(boat, 4200.0 / knots)
    beyond = run["depth"] * math.copysign(1.0, change) - 50.0

    assert beyond.max() < 1.0
    assert np.abs(last(beyond)).max() < 0.3
    assert np.abs(run["pitch"]).max() < 12.0


@pytest.mark.parametrize("knots", [3.0, 4.0, 4.8, 10.0])
@pytest.mark.parametrize("change", [2.0, -10.0])
def test_small_depth_changes_arrive_below_the_critical_speed_too(
    knots: float, change: float
) -> None:
    boat = start(knots)
    boat.state.ordered_depth = 100.0 + change
    run = sail(boat, 600.0)
    gone = run["depth"] * math.copysign(1.0, change)

    assert gone.min() > -0.05
    assert gone.max() < abs(change) + 0.5
    assert np.abs(last(gone) - abs(change)).max() < 0.3


# --- steady flight


@pytest.mark.parametrize("knots", [3.0, 4.8, 10.0, 20.0])
def test_an_hour_from_trim_keeps_depth_and_course(knots: float) -> None:
    boat = start(knots, "modified")
    boat.state.trim_by_hand = 1.0
    run = sail(boat, 3600.0)

    assert np.abs(run["depth"]).max() < 0.1
    assert np.abs(run["course"]).max() < 0.1
    assert boat.state.u / KNOT == pytest.approx(knots, abs=0.01)


def test_a_boat_heavier_than_its_trim_finds_a_new_one() -> None:
    boat = start(8.0)
    boat.state.trim_by_hand = 1.0
    boat.state.water_auxiliary += 0.002 * boat.vessel.mass
    run = sail(boat, 900.0)

    assert np.abs(run["depth"]).max() > 0.05
    assert np.abs(last(run["depth"])).max() < 0.05


# --- course changes


@pytest.mark.parametrize("knots", [5.0, 10.0, 20.0])
@pytest.mark.parametrize("change", [5.0, 30.0, -90.0, 179.0])
def test_a_course_change_neither_overshoots_nor_loses_depth(knots: float, change: float) -> None:
    boat = start(knots, "modified")
    boat.state.ordered_psi = change * DEGREE
    run = sail(boat, 5000.0 / knots)
    turned = run["course"] * math.copysign(1.0, change)

    assert turned.max() < abs(change) + 2.0
    assert np.abs(last(turned) - abs(change)).max() < 0.1
    assert np.abs(run["depth"]).max() < 2.0


def test_a_boat_shoved_off_course_returns_without_hard_rudder(boat: Boat) -> None:
    boat.state.psi = -60.0 * DEGREE
    most = 0.0
    for _ in range(600):
        assert boat.tick() == 0
        most = max(most, abs(boat.state.delta_r))

    assert most < 25.0 * DEGREE
    assert abs(boat.state.psi) < 0.1 * DEGREE


# --- hands on and off


@pytest.mark.parametrize("surface", ["rudder", "stern", "bow"])
def test_taking_over_in_settled_flight_moves_no_surface(surface: str) -> None:
    boat = start(7.0)
    letter = {"rudder": "r", "stern": "s", "bow": "b"}[surface]
    s = boat.state
    sail(boat, 20.0)
    for by_hand in (1.0, 0.0, 1.0):
        s[f"ordered_{letter}"] = before = float(s[f"delta_{letter}"])
        s[f"{surface}_by_hand"] = by_hand
        assert boat.tick() == 0
        assert abs(float(s[f"command_{letter}"]) - before) < 0.5 * DEGREE
        sail(boat, 20.0)


def test_taking_over_in_a_dive_starts_from_the_present_angle(boat: Boat) -> None:
    s = boat.state
    s.stern_by_hand, s.ordered_s = 1.0, s.delta_s + 8.0 * DEGREE
    sail(boat, 20.0)
    s.stern_by_hand = 0.0
    before = s.delta_s
    assert boat.tick() == 0

    # the law moves on by what one tick changes; the angle itself is taken over
    assert abs(s.command_s - before) < 3.0 * DEGREE
    assert np.abs(last(sail(boat, 300.0)["depth"])).max() < 0.5


def test_bow_planes_hold_depth_alone_when_the_stern_planes_are_in_hand() -> None:
    boat = start(8.0)
    s = boat.state
    s.stern_by_hand, s.ordered_s = 1.0, s.delta_s + DEGREE
    run = sail(boat, 900.0)

    assert np.abs(run["depth"]).max() < 2.0
    assert np.abs(last(run["depth"])).max() < 0.05
    assert abs(s.delta_b) > 2.0 * DEGREE


def test_with_the_rudder_in_hand_the_heading_reference_is_the_boats(boat: Boat) -> None:
    turn_by_hand(boat, 10.0)
    sail(boat, 60.0)
    psi, r = boat.state.psi, boat.state.r
    boat.tick()

    assert psi > 20.0 * DEGREE
    assert boat.state.psi_reference == psi
    assert 0.0 < boat.state.psi_reference_rate < r  # as fast as it is ever slewed


# --- speed


def test_ordered_speeds_are_reached_and_kept(boat: Boat) -> None:
    for knots in (6.0, 12.0, 18.0):
        boat.state.ordered_speed = knots * KNOT
        sail(boat, 600.0)
        assert boat.state.u / KNOT == pytest.approx(knots, abs=0.05)
        assert boat.state.speed_trim / KNOT == pytest.approx(0.0, abs=0.02), "nothing to learn"


def test_a_long_run_down_in_speed_is_not_mistaken_for_a_wrong_trim() -> None:
    boat = start(20.0)
    boat.state.ordered_speed = 3.0 * KNOT
    sail(boat, 1500.0)

    assert boat.state.u / KNOT == pytest.approx(3.0, abs=0.01)


def test_a_wrong_speed_trim_is_unlearnt(boat: Boat) -> None:
    boat.state.speed_trim += 0.4 * KNOT
    sail(boat, 60.0)
    after_a_minute = boat.state.u / KNOT
    sail(boat, 600.0)

    assert after_a_minute > 10.05
    assert boat.state.u / KNOT == pytest.approx(10.0, abs=0.01)


def test_speed_trim_does_not_wind_up_at_the_engines_limit() -> None:
    # its own limit is 4.5 kn of command speed, and control surfaces drag
    boat = start(4.5, "full", "remus100")
    sail(boat, 300.0)
    s = boat.state

    assert s.command_u_c <= boat.vessel.u_c_ahead
    assert s.ordered_speed + s.speed_trim < boat.vessel.u_c_ahead + 0.03


def test_speed_trim_is_learnt_in_straight_flight_only(boat: Boat) -> None:
    s = boat.state
    s.speed_trim += 0.1
    s.rudder_by_hand, s.ordered_r = 1.0, -15.0 * DEGREE
    sail(boat, 20.0)
    in_turn = s.speed_trim
    sail(boat, 200.0)

    assert s.speed_trim == pytest.approx(in_turn, abs=1e-3)
    assert s.command_u_c == s.ordered_speed + s.speed_trim


# --- the small boats


@pytest.mark.parametrize(
    ("vessel", "knots"), [("sdv-mk9", 1.5), ("sdv-mk9", 4.0), ("remus100", 3.0), ("remus100", 4.0)]
)
def test_the_small_boats_obey_too(vessel: str, knots: float) -> None:
    boat = start(knots, "full", vessel)
    hold = sail(boat, 60.0)
    boat.state.ordered_depth = 110.0
    dive = sail(boat, 240.0)
    boat.state.ordered_psi = 90.0 * DEGREE
    turn = sail(boat, 200.0)
    turn_by_hand(boat, 10.0)
    circle = sail(boat, 60.0)

    assert np.abs(hold["depth"]).max() < 0.01
    assert np.abs(hold["course"]).max() < 0.01
    assert dive["depth"].max() < 10.3
    assert np.abs(last(dive["depth"]) - 10.0).max() < 0.1
    assert turn["course"].max() < 92.0
    assert np.abs(last(turn["course"]) - 90.0).max() < 0.1
    assert np.abs(turn["depth"] - 10.0).max() < 0.5
    assert np.abs(circle["depth"] - 10.0).max() < 0.5
    assert circle["course"][-1] > 150.0


def test_a_boat_without_bow_planes_has_no_gains_for_them() -> None:
    table = start(3.0, "full", "remus100").file.autopilot
    assert table is not None
    for gain in ("depth", "depth_rate", "pitch", "pitch_rate", "integral", "relief"):
        assert not any(getattr(table, f"bow_{gain}"))
        assert gain == "relief" or any(getattr(table, f"stern_{gain}"))


# --- laws


def test_the_reports_law_is_the_reference_boats_law() -> None:
    # independent implementation, trajectory 1: feet and seconds, DB = DS literally, depth 400 ft
    data = json.loads((DATA / "trajectories.json").read_text())
    known = data["trajectories"][0]
    state, vessel = new_state(), np.zeros(1, VESSEL)
    s = state[0]
    vessel["Z_db"], s.ordered_depth = -1.0, 400.0 * 0.3048
    every = known["output_every"]
    for motion, (_, stern, bow, _) in zip(
        known["states"], known["control_per_step"][::every], strict=False
    ):
        s.motion[:] = motion
        for length in ("u", "v", "w", "x", "y", "z"):
            s[length] *= 0.3048
        s.depth_law = REPORT_LITERAL
        assert report_law(state) == pytest.approx(stern, abs=1e-9)
        assert report_angle(vessel, state, 2) == pytest.approx(bow, abs=1e-9)
        s.depth_law = REPORT_LAW  # errata G3: bow planes the other way where Z_db < 0
        assert report_angle(vessel, state, 2) == pytest.approx(-bow, abs=1e-9)


@pytest.mark.parametrize(
    ("law", "feet", "degrees"),
    [
        (REPORT_LAW, 40.0, 0.32 / DEGREE),  # .008 of each foot
        (REPORT_LAW, 60.0, 0.40 / DEGREE),  # the project's clamp at 50 ft
        (REPORT_LAW, -400.0, -0.40 / DEGREE),
        (REPORT_LITERAL, 60.0, 0.48 / DEGREE),  # errata G5: none in the report,
        (REPORT_LITERAL, -70.0, -0.56 / DEGREE),
        (REPORT_LITERAL, 76.0, 0.608 / DEGREE),
        (REPORT_LITERAL, 77.0, 35.0),  # whose planes are hard over from 76 ft on
        (REPORT_LITERAL, -400.0, -35.0),
    ],
)
def test_the_literal_law_is_literal_beyond_50_feet_too(
    law: int, feet: float, degrees: float
) -> None:
    state = new_state()
    state[0].z, state[0].ordered_depth = 100.0, 100.0 + feet * FOOT
    state[0].depth_law = law
    assert report_law(state) / DEGREE == pytest.approx(degrees, abs=1e-9)


def test_port_and_starboard_are_mirror_images_to_the_bit() -> None:
    one, other = start(10.0), start(10.0)
    for boat, side in ((one, 1.0), (other, -1.0)):
        boat.vessel.K_star = boat.vessel.K_star_eta = 0.0  # the propeller is no mirror image
        for name in ("v", "phi", "delta_r"):
            boat.state[name] = 0.0
        boat.state.integral[0] = 0.0
        boat.state.p, boat.state.ordered_psi = side * 0.01, side * 40.0 * DEGREE
        boat.state.ordered_depth = 110.0
    for _ in range(400):
        one.tick()
        other.tick()
        assert one.state.command_r == -other.state.command_r
        assert one.state.command_s == other.state.command_s
        assert one.state.command_b == other.state.command_b
    assert one.state.psi > 30.0 * DEGREE


def test_a_reference_obeys_its_rate_and_acceleration_and_stops() -> None:
    rate = place = 0.0
    rates = []
    for _ in range(600):
        rate = slewed_rate(50.0 - place, rate, 0.5, 0.02, 0.5)
        place += 0.5 * rate
        rates.append(rate)

    assert max(rates) == 0.5
    assert np.abs(np.diff(rates)).max() <= 0.02 * 0.5 + 1e-12
    assert place == pytest.approx(50.0, abs=1e-6)
    assert min(rates) > -1e-9

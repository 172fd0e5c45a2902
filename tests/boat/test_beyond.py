"""Boats taken where the coefficients do not reach: against the figures of docs/envelope.md."""

import math

import numpy as np
import pytest
from helpers.boats import calls_of, make_boat, start_bb2, start_boat

from trainer.boat.boat import Boat
from trainer.boat.calls import Rank
from trainer.boat.casualties import insert_casualty
from trainer.boat.envelope import surface_modes
from trainer.boat.limits import LimitMonitor
from trainer.boat.pilot import PilotMonitor
from trainer.config.exercise.exercise import ExerciseLimits
from trainer.config.world.sea import load_sea
from trainer.core.state import MOTION
from trainer.core.surfaced import take_off_dry_sail
from trainer.units import KNOT

SETS = [("full", "exact"), ("modified", "lagged"), ("basic", "lagged")]


def in_hand(boat: Boat, knots: float, rudder: float = 0.0) -> None:
    """Put all in hand: planes at zero, a command speed [kn], rudder to starboard [deg]."""
    s = boat.state
    s.rudder_by_hand = s.stern_by_hand = s.bow_by_hand = s.speed_by_hand = 1.0
    s.ordered_r = math.radians(rudder) * boat.toward["rudder"] if rudder else 0.0
    s.ordered_s = s.ordered_b = 0.0
    s.ordered_u_c = knots * KNOT


def flown(boat: Boat, seconds: float) -> np.ndarray:
    """Return time and motion at every tick."""
    rows = []
    for _ in range(round(seconds / boat.method.step)):
        assert boat.tick() == 0
        rows.append([boat.time, *boat.state.motion])
    return np.array(rows)


def of(rows: np.ndarray, name: str) -> np.ndarray:
    """Return one motion of the rows."""
    return rows[:, 1 + MOTION.index(name)]


def stopping(rows: np.ndarray) -> tuple[float, float]:
    """Return when [s] and after what way [m] the boat had stopped."""
    at = int(np.argmax(of(rows, "u") < 0.0))
    return float(rows[at, 0]), float(math.hypot(of(rows, "x")[at], of(rows, "y")[at]))


def neutral(boat: Boat) -> None:
    """Make weight and buoyancy the same, and take the tanks out."""
    boat.vessel.fitted = 0.0
    boat.vessel.weight = boat.state.weight = boat.vessel.buoyancy


@pytest.mark.parametrize(("equations", "rates"), SETS)
def test_bb2_stops_and_goes_astern_as_a_boat_does(equations: str, rates: str) -> None:
    boat = start_bb2(equations, rates, depth=300.0)
    in_hand(boat, -8.0)

    rows = flown(boat, 900.0)

    when, way = stopping(rows)
    assert when == pytest.approx(116.0, rel=0.05)
    assert way / boat.vessel.ell == pytest.approx(4.1, rel=0.05)
    assert -of(rows, "u").min() / KNOT == pytest.approx(7.0, rel=0.02)
    assert abs(math.degrees(of(rows, "psi")[-1])) == pytest.approx(370.0, rel=0.2), "pays off"
    assert abs(np.degrees(of(rows, "theta"))).max() < 10.0
    assert abs(np.degrees(of(rows, "phi"))).max() < 5.0


@pytest.mark.parametrize(
    ("vessel", "knots", "bell", "seconds", "lengths"),
    [
        ("bb2", 5.0, -8.0, 76.0, 1.5),
        ("bb2", 15.0, -8.0, 141.0, 6.8),
        ("sdv-mk9", 2.0, -2.5, 59.0, 5.0),
        ("sdv-mk9", 4.0, -2.5, 87.0, 13.0),
        ("sdv-mk9", 6.0, -2.5, 100.0, 20.0),
        ("remus100", 3.0, -2.0, 23.0, 11.0),
    ],
)
def test_a_crash_stop_takes_the_time_and_way_of_its_kind(
    vessel: str, knots: float, bell: float, seconds: float, lengths: float
) -> None:
    step = {"bb2": 0.5, "sdv-mk9": 0.1, "remus100": 0.02}[vessel]
    boat = start_boat(knots * KNOT, 300.0, vessel=vessel, rates="exact", step=step)
    neutral(boat)
    planes = boat.state.delta_s
    in_hand(boat, bell)
    boat.state.ordered_s = planes

    when, way = stopping(flown(boat, 1.5 * seconds))

    assert when == pytest.approx(seconds, rel=0.2)
    assert way / boat.vessel.ell == pytest.approx(lengths, rel=0.2)


def test_rudder_to_starboard_astern_takes_the_stern_to_starboard() -> None:
    boat = start_bb2("full", "exact", depth=300.0)
    in_hand(boat, -8.0, rudder=20.0)

    rows = flown(boat, 600.0)

    assert stopping(rows)[0] == pytest.approx(69.0, rel=0.2)
    assert -of(rows, "u")[-1] / KNOT == pytest.approx(4.0, rel=0.2)
    assert math.degrees(of(rows, "r")[-1]) == pytest.approx(-1.33, rel=0.2)


def test_taken_ahead_again_the_boat_goes_on_ahead() -> None:
    boat = start_bb2("full", "exact", depth=300.0)
    in_hand(boat, -8.0)
    while boat.state.u > 0.0:
        assert boat.tick() == 0
    flown(boat, 60.0)
    in_hand(boat, 7.0)

    rows = flown(boat, 600.0)

    assert rows[np.argmax(of(rows, "u") > 0.0), 0] - rows[0, 0] == pytest.approx(60.0, rel=0.2)
    assert of(rows, "u")[-1] / KNOT == pytest.approx(6.9, rel=0.05)
    assert abs(np.degrees(of(rows, "theta"))).max() < 3.0


@pytest.mark.parametrize(
    ("vessel", "heavy", "speed"),
    [
        ("bb2", 0.01, 1.59),
        ("bb2", 0.05, 3.54),
        ("sdv-mk9", 0.01, 0.79),
        ("sdv-mk9", 0.05, 1.76),
        ("remus100", 0.01, 0.15),
        ("remus100", 0.05, 0.33),
    ],
)
def test_a_heavy_boat_falls_level_at_a_bounded_speed(
    vessel: str, heavy: float, speed: float
) -> None:
    step = {"bb2": 0.5, "sdv-mk9": 0.1, "remus100": 0.02}[vessel]
    boat = make_boat(vessel, "full", "exact", "adams2", step)
    neutral(boat)
    s = boat.state
    s.weight *= 1.0 + heavy
    s.x_g = s.y_g = boat.vessel.x_b = boat.vessel.y_b = 0.0
    s.z = 1000.0
    in_hand(boat, 0.0)

    rows = flown(boat, 200.0)

    assert s.zdot == pytest.approx(speed, rel=0.05)
    assert abs(np.degrees(of(rows, "theta"))).max() < 8.0


@pytest.mark.parametrize(
    ("step", "integrator"),
    [(0.1, "adams2"), (0.5, "adams2"), (1.0, "adams2"), (1.0, "rk4"), (1.0, "rkv")],
)
def test_a_blown_boat_in_a_calm_comes_to_lie_still(step: float, integrator: str) -> None:
    boat = make_boat("bb2", "full", "exact", integrator, step)
    boat.vessel.fitted = 0.0
    s = boat.state
    s.weight -= 482e3 * 9.81
    s.z, s.phi, s.theta = 4.0 - 2.0, math.radians(3.0), math.radians(5.0)
    in_hand(boat, 0.0)

    rows = flown(boat, 300.0)

    last = of(rows, "z")[rows[:, 0] > 290.0]
    assert np.ptp(last) < 0.02
    assert last[-1] == pytest.approx(4.0, abs=0.05)
    assert abs(math.degrees(s.theta)) < 0.1


def test_the_modes_afloat_are_those_of_the_waterplane() -> None:
    expected = {
        "bb2": (8.83, 9.37, 13.5),
        "sdv-mk9": (5.5, 6.2, 7.1),
        "remus100": (1.7, 1.9, 1.3),
    }
    for vessel, periods in expected.items():
        modes = surface_modes(make_boat(vessel).records.vessel)
        found = [2.0 * math.pi / float(modes[name][0]) for name in ("heave", "pitch", "roll")]
        assert found == pytest.approx(periods, rel=0.05)


def afloat(boat: Boat, seed: float, swell: np.ndarray) -> None:
    """Let the boat float at rest, heading north, in a swell."""
    boat.start(5 * KNOT, 300.0, 0.0)
    boat.vessel.fitted = 0.0
    s = boat.state
    s.motion[:] = 0.0
    s.u_c = s.telegraph_answer = 0.0
    s.weight -= 482e3 * 9.81
    s.z, s.seed = 4.0, seed
    in_hand(boat, 0.0)
    boat.order_sea(swell, 0.0)


def swell_of(period: float, towards: float, cosines: float, peaked: float) -> np.ndarray:
    """Return a swell of 1 m; ``towards`` [rad] is where it runs."""
    gamma = 3.3 if peaked else 1.0
    return np.array([1.0, math.tau / period, gamma, towards, cosines, 0.0, 0.0, peaked, 0.0])


def heave(boat: Boat, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the boat's height [m] and the water's level [m] at every tick, after 5 minutes."""
    flown(boat, 300.0)
    rows = []
    for _ in range(round(seconds / boat.method.step)):
        assert boat.tick() == 0
        rows.append((-float(boat.state.z), float(boat.state.eta_wave)))
    heights, levels = np.array(rows).T
    return heights, levels


@pytest.mark.parametrize("cosines", [0.0, 1.0])
def test_a_boat_afloat_rides_a_long_swell(cosines: float) -> None:
    boat = make_boat("bb2", "full", "exact")
    afloat(boat, 3.0, swell_of(20.0, 0.5 * math.pi, cosines, 0.0))

    heights, levels = heave(boat, 1800.0)

    assert 0.2 < np.std(levels) < 0.3
    assert 0.9 < np.std(heights) / np.std(levels) < 1.2
    assert np.corrcoef(heights, levels)[0, 1] > 0.5
    assert abs(boat.state.phi) < 0.5


@pytest.mark.slow
@pytest.mark.parametrize("peaked", [0.0, 1.0])
@pytest.mark.parametrize(
    "towards",
    [
        pytest.param(0.0, marks=pytest.mark.slow),
        0.5 * math.pi,
        pytest.param(math.pi, marks=pytest.mark.slow),
    ],
)
@pytest.mark.parametrize(
    "period",
    [pytest.param(12.0, marks=pytest.mark.slow), 16.0, pytest.param(20.0, marks=pytest.mark.slow)],
)
def test_a_boat_afloat_heaves_alike_in_a_swell_of_either_generator(
    period: float, towards: float, peaked: float
) -> None:
    boat = make_boat("bb2", "full", "exact")

    def mean(cosines: float) -> float:
        ratios = []
        for seed in range(1, 21):
            afloat(boat, float(seed), swell_of(period, towards, cosines, peaked))
            heights, levels = heave(boat, 1200.0)
            ratios.append(np.std(heights) / np.std(levels))
        return float(np.mean(ratios))

    assert mean(0.0) == pytest.approx(mean(1.0), rel=0.1)


def in_a_turn_afloat(boat: Boat, rudder: float) -> np.ndarray:
    """Return time and motion in a turn afloat at 12 kn by the propeller, straight for 5 min before.

    The rudder is put over by ``rudder`` [deg], to starboard.
    """
    afloat(boat, 1.0, swell_of(20.0, 0.0, 0.0, 0.0) * 0.0)
    boat.state.u = 10.0 * KNOT
    in_hand(boat, 12.0)
    flown(boat, 300.0)
    in_hand(boat, 12.0, rudder)
    return flown(boat, 600.0)


@pytest.mark.parametrize("rudder", [10.0, 20.0, 30.0])
@pytest.mark.parametrize(("equations", "rates"), SETS)
def test_a_turn_afloat_heels_inward_as_a_pendulum_does(
    equations: str, rates: str, rudder: float
) -> None:
    boat = make_boat("bb2", equations, rates)
    right, left = (in_a_turn_afloat(boat, to * rudder) for to in (1.0, -1.0))
    heel = np.degrees([of(right, "phi")[-1], of(left, "phi")[-1]])
    inward = 0.5 * (heel[0] - heel[1])
    s = boat.state
    pendulum = math.degrees(math.atan(math.hypot(s.u, s.v) * abs(s.r) / 9.81))

    # the propeller heels the boat by a few tenths of a degree, to port
    assert heel[1] < 0.0 < heel[0]
    assert -0.7 < heel.sum() < 0.0
    # what is left of the sail in the wet share, and what the compact sets lack of its terms
    assert inward == pytest.approx(pendulum, abs=0.35)


def test_without_a_propeller_s_torque_both_sides_heel_alike() -> None:
    boat = make_boat("bb2", "full", "exact")
    boat.vessel.K_star = boat.vessel.K_star_eta = 0.0
    right, left = (in_a_turn_afloat(boat, to * 20.0) for to in (1.0, -1.0))

    assert of(right, "phi")[-1] == pytest.approx(-of(left, "phi")[-1], rel=1e-6)
    assert 0.5 < math.degrees(of(right, "phi")[-1]) < 1.2


def test_the_sail_comes_into_the_air_without_a_jump() -> None:
    boat = start_bb2("full", "exact", depth=300.0)
    s, c = boat.state, boat.vessel
    s.theta = s.phi = 0.0
    s.u, s.v, s.w, s.p, s.q, s.r = 5.0, -1.0, 0.1, 0.02, 0.0, 0.03
    forces = []
    for share in np.linspace(-0.1, 1.1, 1201):
        s.z = -float(c.z_sail) - share * float(c.sail_height)
        force = np.zeros(6)
        take_off_dry_sail(boat.records.vessel, boat.records.state, force)
        forces.append(force)
    steps = abs(np.diff(forces, axis=0)).max(axis=0)
    whole = abs(np.array(forces[-1]))

    assert (np.array(forces[:100]) == 0.0).all()
    assert (np.array(forces[-99:]) == forces[-1]).all()
    assert (whole[[1, 3, 5]] > 0.0).all()
    assert (steps <= 1.01e-3 * whole).all()


@pytest.mark.slow
@pytest.mark.parametrize("degree", range(1, 7))
def test_a_boat_is_afloat_for_an_hour_in_any_sea_state(degree: int) -> None:
    boat = make_boat("bb2", "modified", "lagged")
    afloat(boat, 5.0, swell_of(20.0, 0.0, 0.0, 0.0) * 0.0)
    boat.state.u = 8.0 * KNOT
    in_hand(boat, 8.0)
    boat.put_to_sea(load_sea(f"sea-state-{degree}"))

    rows = flown(boat, 3600.0)

    assert np.isfinite(boat.state.whole).all()
    assert np.isfinite(rows).all()
    assert abs(np.degrees(of(rows, "phi"))).max() < 60.0
    assert abs(np.degrees(of(rows, "theta"))).max() < 20.0
    assert abs(of(rows, "z")).max() < 20.0


def test_the_engine_s_torque_limits_revolutions() -> None:
    boat = start_boat(3 * KNOT, 300.0, rates="exact")
    in_hand(boat, 20.0)
    boat.state.u = 0.0
    for _ in range(60):
        boat.state.u = 0.0
        assert boat.tick() == 0
    assert boat.state.u_c / KNOT == pytest.approx(11.6, abs=0.2)

    boat.start(3 * KNOT, 300.0, 0.0)
    in_hand(boat, 20.0)
    flown(boat, 900.0)
    assert boat.state.u / KNOT == pytest.approx(20.0, abs=0.3)


def called(boat: Boat, monitor: LimitMonitor | PilotMonitor, seconds: float) -> list[str]:
    """Return what is called out, without the ticks."""
    return [call.text.partition(": ")[2] for call in calls_of(boat, monitor, seconds)]


def test_leaving_the_range_is_called_out_once_and_can_be_a_limit() -> None:
    boat = start_bb2("full", "exact", depth=300.0)
    monitor = LimitMonitor.over(boat, ExerciseLimits(validity_level_max=1.0))
    assert called(boat, monitor, 30.0) == []
    in_hand(boat, -8.0)

    said = called(boat, monitor, 300.0)

    assert [text.split(":")[0] for text in said] == [
        *("EQUATIONS EXTRAPOLATED", "OUTSIDE THE EQUATIONS", "LIMIT"),
    ]
    assert said[2] == "LIMIT: validity level above 1"


def test_a_remark_on_the_model_is_no_alarm_and_a_limit_passed_is_one() -> None:
    boat = start_bb2("full", "exact", depth=300.0)
    monitor = LimitMonitor.over(boat, ExerciseLimits(validity_level_max=1.0))
    in_hand(boat, -8.0)
    ranks = [call.rank for call in calls_of(boat, monitor, 300.0)]

    assert ranks == [Rank.CAUTION, Rank.WARNING, Rank.ALARM]


def test_what_rudder_and_stern_planes_of_an_x_tail_lack_is_told_and_not_why() -> None:
    boat = start_bb2("full", "exact", depth=100.0)
    monitor = PilotMonitor.over(boat)
    in_hand(boat, 10.0, rudder=25.0)
    boat.state.ordered_s = math.radians(20.0)

    said = called(boat, monitor, 20.0)

    shared = "rudder and stern planes share the fins"
    assert [text for text in said if "X-TAIL" in text] == [
        f"X-TAIL: the rudder has 18 of 25 deg: {shared}",
        f"X-TAIL: the stern planes have 12 of 20 deg: {shared}",
    ]
    assert {"rudder short on the X-tail", "stern short on the X-tail"} <= monitor.times.keys()
    cruciform = start_boat(3 * KNOT, 20.0, vessel="sdv-mk9", rates="exact", step=0.1)
    in_hand(cruciform, 3.0, rudder=20.0)
    cruciform.state.ordered_s = math.radians(20.0)
    quiet = called(cruciform, PilotMonitor.over(cruciform), 5.0)
    assert not [text for text in quiet if "X-TAIL" in text]


def test_a_jammed_surface_is_not_told_as_the_sharing_of_an_x_tail() -> None:
    boat = start_bb2("full", "exact", depth=100.0)
    monitor = PilotMonitor.over(boat)
    in_hand(boat, 10.0, rudder=25.0)
    boat.state.ordered_s = math.radians(25.0)
    insert_casualty(boat, "stern-hard-over", 0.4, 0.0)

    said = called(boat, monitor, 20.0)

    told = [text for text in said if "X-TAIL" in text]
    assert told == ["X-TAIL: the rudder has 18 of 25 deg: rudder and stern planes share the fins"]

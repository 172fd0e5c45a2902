"""The laws that the equations of motion must obey whatever the coefficients."""

import math

import numpy as np
import pytest
from helpers.boats import make_boat, start_bb2, take_in_hand, take_ticks

from trainer.boat.boat import Boat
from trainer.core import full, rates
from trainer.core.integrators import advance
from trainer.core.state import MOTION
from trainer.core.terms import LENGTH_POWERS

pytestmark = pytest.mark.core

KNOT = 1852.0 / 3600.0
IDEAL = "full-ideal.vessel.toml"
MIRRORED = ("v", "p", "r", "phi", "psi", "y", "delta_r")


def energy(boat: Boat) -> float:
    """Return kinetic and potential energy [J] of the boat with its water."""
    r = boat.records
    s = boat.state
    full.inertia(r.vessel, r.state, r.scratch[0].inertia)
    velocity = np.array(s.motion[:6])
    down = np.array(
        [
            -math.sin(s.theta),
            math.cos(s.theta) * math.sin(s.phi),
            math.cos(s.theta) * math.cos(s.phi),
        ]
    )
    c = boat.vessel
    gravity = s.weight * (s.z + down @ [s.x_g, s.y_g, s.z_g])
    lift = c.buoyancy * (s.z + down @ [c.x_b, c.y_b, c.z_b])
    return float(0.5 * velocity @ r.scratch[0].inertia @ velocity - gravity + lift)


@pytest.mark.long
@pytest.mark.parametrize("off_centre", [False, True])
def test_an_ideal_fluid_takes_no_energy(off_centre: bool) -> None:  # noqa: FBT001
    # model document, section 2, property 3: any centre of gravity and inertia
    boat = make_boat(IDEAL, "full", "exact", "rk4", 0.01)
    s, c = boat.state, boat.vessel
    if off_centre:
        s.x_g, s.y_g, s.z_g = 0.7, 0.2, 0.5
        c.x_b, c.y_b = 0.4, -0.3
        c.I_xy, c.I_yz, c.I_xz = 2e7, -1e7, 3e7
    s.motion[:9] = [4.0, 0.6, -0.3, 0.02, 0.01, -0.015, 0.3, -0.2, 0.5]
    boat.records.scheme["envelope"] = 0  # the equations of 1969 by themselves
    start = energy(boat)
    scale = abs(0.5 * c.mass * 16.0)

    for _ in range(60_000):
        advance(*boat.records)

    assert abs(s.p) > 0.0
    assert abs(energy(boat) - start) / scale < 1e-9


def asymmetric(boat: Boat) -> None:
    """Give the boat every symmetric coefficient it may have, so that none can hide."""
    rng = np.random.default_rng(5)
    for name in LENGTH_POWERS:
        if name not in ("Y_star", "K_star", "N_star", "K_star_eta") and "dot" not in name:
            boat.vessel[name] *= rng.uniform(0.5, 1.5)
    for name in ("K_star", "K_star_eta"):
        boat.vessel[name] = boat.records.compact[name] = 0.0  # the propeller's torque has a side


@pytest.mark.laws
@pytest.mark.parametrize("equations", ["full", "modified"])
@pytest.mark.parametrize("way", ["exact", "lagged"])
def test_port_mirrors_starboard_to_the_bit(equations: str, way: str) -> None:
    boats = [make_boat("bb2", equations, way) for _ in range(2)]
    for boat in boats:
        asymmetric(boat)
        boat.start(10 * KNOT, 60.0, 0.0)
    for boat, side in zip(boats, (1.0, -1.0), strict=True):
        boat.state.rudder_by_hand = 1.0
        boat.state.ordered_r = side * 0.3
        boat.state.phi = side * 0.05

    for _ in range(400):
        assert [boat.tick() for boat in boats] == [0, 0]

    starboard, port = (boat.state for boat in boats)
    assert abs(starboard.psi) > 1.0
    for name in (*MOTION, "delta_r", "delta_s", "delta_b"):
        assert port[name] == (-starboard[name] if name in MIRRORED else starboard[name]), name


@pytest.mark.long
@pytest.mark.parametrize("equations", ["full", "modified", "basic", "longitudinal"])
def test_straight_trimmed_flight_stays_straight_for_an_hour(equations: str) -> None:
    boat = start_bb2(equations)
    take_in_hand(boat)

    take_ticks(boat, 7200)

    s = boat.state
    assert s.z == pytest.approx(60.0, abs=1e-6)
    # the propeller's torque heels the full boat, which then makes a steady leeway of 0.3 mm/s
    assert s.psi == pytest.approx(0.0, abs=1e-9)
    assert s.y == pytest.approx(3600.0 * s.ydot, abs=1e-6)
    assert abs(s.ydot) < 1e-3
    assert s.u == pytest.approx(10 * KNOT, abs=1e-9)
    assert s.x == pytest.approx(3600 * math.hypot(s.u, s.w), rel=1e-6)


@pytest.mark.laws
def test_longitudinal_motion_never_excites_lateral_motion() -> None:
    boat = make_boat("sdv-mk9", "full", "exact", "rk4", 0.1)
    c = boat.vessel
    c.I_xy = c.I_yz = 0.0
    boat.start(1.5, 20.0, 0.0)
    take_in_hand(boat)
    boat.state.ordered_s = 0.05

    take_ticks(boat, 300)

    s = boat.state
    assert s.z > 21.0
    assert [s.v, s.p, s.r, s.phi, s.psi, s.y] == [0.0] * 6


@pytest.mark.laws
def test_a_neutral_boat_at_rest_stays_at_rest() -> None:
    boat = make_boat("sdv-mk9", "full", "exact")
    s = boat.state
    s.rudder_by_hand = s.stern_by_hand = s.bow_by_hand = s.speed_by_hand = 1.0
    s.z = 30.0

    take_ticks(boat, 1000)

    assert list(s.motion[:6]) == [0.0] * 6
    assert s.z == 30.0


@pytest.mark.laws
@pytest.mark.parametrize("speed", [8.0, 2.0, -2.0])
def test_without_thrust_drag_opposes_the_motion_ahead_and_astern(speed: float) -> None:
    boat = make_boat("bb2", "full")
    boat.state.u = speed

    rates.rates(*boat.records)

    assert boat.state.udot * speed < 0.0


@pytest.mark.laws
def test_fifty_tonnes_light_and_dead_in_the_water_rises_broadside() -> None:
    # 1.88 m/s by the drag of pure heave; gliding astern takes some of it. The equations of 1969,
    # which are out of their range here, give 1.9 m/s
    boat = make_boat("bb2", "full")
    s = boat.state
    take_in_hand(boat)
    boat.vessel.fitted = 0.0  # nothing but the weight is to change
    s.weight -= 50e3 * 9.81
    s.z = 1000.0

    take_ticks(boat, 800)

    assert -s.zdot == pytest.approx(1.7, abs=0.05)
    assert abs(math.degrees(s.theta)) < 3.0


@pytest.mark.laws
def test_steep_pitch_leaves_the_rates_finite() -> None:
    boat = make_boat("bb2", "full")
    s = boat.state
    s.u, s.theta, s.q, s.r, s.phi = 5.0, math.pi / 2, 0.1, 0.1, 0.2

    rates.rates(*boat.records)

    assert np.isfinite(s.rates).all()
    assert abs(s.psidot) < 20.0

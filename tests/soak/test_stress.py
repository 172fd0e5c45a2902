"""Stress of every boat by every set, and the ledger of energy that it keeps."""

import math

import numpy as np
import pytest
from helpers.boats import make_boat

from soak.stress import propulsion, stress, stress_one, water_forces, water_power
from trainer.boat.boat import Boat
from trainer.config.boat.vessel import load_vessel
from trainer.core import full
from trainer.core.elementary import cosine, sine


def energy(boat: Boat) -> tuple[float, float]:
    """Return the energy of motion and of place [J] of a boat deep in still water."""
    s, c = boat.state, boat.vessel
    matrix = np.zeros((6, 6))
    full.inertia(boat.records.vessel, boat.records.state, matrix)
    motion = np.array(s.motion[:6])
    level = cosine(s.theta)
    down = np.array([-sine(s.theta), level * sine(s.phi), level * cosine(s.phi)])
    arm = s.weight * np.array([s.x_g, s.y_g, s.z_g]) - c.buoyancy * np.array([c.x_b, c.y_b, c.z_b])
    place = -float(s.weight - c.buoyancy) * s.z - arm @ down
    return float(motion @ (0.25 * (matrix + matrix.T)) @ motion), float(place)


@pytest.mark.slow
@pytest.mark.parametrize(("vessel", "step"), [("bb2", 0.1), ("sdv-mk9", 0.02), ("remus100", 0.02)])
def test_what_the_boat_has_is_what_water_and_propeller_gave_it(vessel: str, step: float) -> None:
    # outside the range, where the added masses are symmetric, and on into it
    boat, rng = make_boat(vessel, "full", "exact", "adams2", step), np.random.default_rng(8)
    boat.vessel.fitted = 0.0
    for _ in range(5):
        s = boat.state
        s.motion[:] = s.rates[:] = 0.0
        speed = boat.vessel.u_c_ahead
        s.motion[:3] = rng.uniform(-0.6, 0.6, 3) * speed
        s.motion[3:6] = rng.uniform(-0.5, 0.5, 3) * speed / boat.vessel.ell
        s.phi, s.theta, s.z, s.history = rng.uniform(-2.0, 2.0), rng.uniform(-1.4, 1.4), 1e3, 0.0
        s.u_c = s.telegraph_answer = s.ordered_u_c = rng.uniform(-0.4, 0.4) * speed
        s.speed_by_hand = s.rudder_by_hand = s.stern_by_hand = s.bow_by_hand = 1.0
        s.surface[:] = s.ordered[:] = 0.0
        moving, place = energy(boat)
        start, given, largest, before = moving + place, 0.0, moving, power(boat)
        for _ in range(round(60.0 / step)):
            assert boat.tick() == 0
            now = power(boat)
            given, before = given + 0.5 * step * (before + now), now
            moving, place = energy(boat)
            largest = max(largest, moving)
            assert abs(moving + place - start - given) < 0.05 * largest


def power(boat: Boat) -> float:
    """Return the power [W] of water and propeller."""
    motion = np.array(boat.state.motion[:6])
    turning = propulsion(boat.records.vessel, boat.records.state) * motion[0]
    twist = 0.0
    if boat.state.validity == 2.0:
        twist = boat.vessel.K_star * boat.state.u_c * abs(boat.state.u_c) * motion[3]
    return float(water_forces(boat) @ motion + turning + twist)


def test_the_water_feeds_no_boat_inside_the_range_either() -> None:
    # measured, not a theorem: planes at zero; the files' own coefficients
    for vessel in ("bb2", "sdv-mk9", "remus100"):
        boat, rng = make_boat(vessel, "full", "exact"), np.random.default_rng(9)
        for _ in range(300):
            s = boat.state
            s.motion[:] = 0.0
            s.u = rng.uniform(0.2, 1.0) * boat.vessel.u_c_ahead
            s.v, s.w = rng.uniform(-0.4, 0.4, 2) * s.u
            s.motion[3:6] = rng.uniform(-0.3, 0.3, 3) * s.u / boat.vessel.ell
            s.z, s.u_c = 1e3, s.u
            s.surface[:] = 0.0
            assert water_power(boat) < 1e-4


def test_stress_keeps_numbers_attitude_and_energy() -> None:
    for found in stress(60, 0.1, 3):
        assert found.kept, found
        assert found.orders > 40
        assert math.isfinite(found.steepest_deg)


@pytest.mark.long
@pytest.mark.parametrize(
    ("vessel", "seconds"),
    [("remus100", 6000.0), pytest.param("sdv-mk9", 21600.0, marks=pytest.mark.slow)],
)
def test_a_small_boat_in_a_hurricane_s_waves_keeps_its_numbers(vessel: str, seconds: float) -> None:
    """They carry it along faster than its propeller could, and throw it out of the water."""
    way = ("longitudinal", "exact") if vessel == "remus100" else ("full", "exact")

    found = stress_one(load_vessel(vessel), way, seconds, round(seconds / 1.8), 1)

    assert found.kept, found

"""The boat beyond the range of its coefficients: no force that feeds it, no jump, no bit inside."""

import math

import numpy as np
import pytest
from helpers.boats import make_boat

from trainer.boat.boat import Boat
from trainer.boat.envelope import dissipative_forces, is_clipped
from trainer.core import wide
from trainer.core.attitude import turned
from trainer.core.elementary import arctangent
from trainer.core.envelope import (
    EXTRAPOLATED_RANGE,
    INSIDE_RANGE,
    OUTSIDE_RANGE,
    validity,
    wide_share,
)
from trainer.core.rates import rates
from trainer.core.scheme import equations_alone
from trainer.core.state import MOTION
from trainer.core.surfaced import take_off_dry_sail

pytestmark = pytest.mark.core

BOATS = ["bb2", "sdv-mk9", "remus100"]
DEEP = 1000.0


def put(boat: Boat, motion: dict[str, float]) -> None:
    """Put the boat into a motion at depth, propeller and surfaces at rest."""
    s = boat.state
    s.motion[:] = [motion.get(name, 0.0) for name in MOTION]
    s.z = motion.get("z", DEEP)
    s.surface[:] = s.u_c = 0.0


def any_way(rng: np.random.Generator, boat: Boat) -> dict[str, float]:
    """Return a motion in any direction, at any attitude."""
    speed, turning = boat.vessel.u_c_ahead, 2.0 * boat.vessel.u_c_ahead / boat.vessel.ell
    motion = dict(zip("uvw", rng.uniform(-speed, speed, 3), strict=True))
    motion |= dict(zip("pqr", rng.uniform(-turning, turning, 3), strict=True))
    return motion | dict(zip(("phi", "theta", "psi"), rng.uniform(-1.5, 1.5, 3), strict=True))


@pytest.mark.parametrize("vessel", BOATS)
def test_the_water_never_feeds_the_boat(vessel: str) -> None:
    # the theorem: every part of the wide set, planes at any angle, less weight, trim and thrust
    boat, rng = make_boat(vessel, "full", "exact"), np.random.default_rng(3)
    c, s = boat.vessel, boat.state
    c.weight = s.weight = c.buoyancy
    c.x_b = c.y_b = c.z_b = s.x_g = s.y_g = s.z_g = 0.0
    c.Z_star = c.M_star = c.K_star = 0.0
    for row in range(3):
        for name in "abc":
            c[f"{name}{row + 1}"] = 0.0
    c.thrust_astern[:] = 0.0
    force = np.zeros(6)
    for _ in range(400):
        put(boat, any_way(rng, boat))
        s.surface[:] = rng.uniform(-1.0, 1.0, 3) * c.limit
        wide.forces(boat.records.vessel, boat.records.state, force)
        s.z = rng.uniform(-20.0, 20.0)  # anything from none to all of the sail is in the air
        take_off_dry_sail(boat.records.vessel, boat.records.state, force)
        speed = math.sqrt(float(np.sum(s.motion[:3] ** 2)))
        scale = 0.5 * c.rho * c.ell**2 * max(speed, 0.1) ** 3

        assert float(force @ s.motion[:6]) / scale < 1e-9


@pytest.mark.laws
def test_an_ideal_fluid_does_no_work_in_any_direction() -> None:
    boat, rng = make_boat("bb2", "full", "exact"), np.random.default_rng(5)
    for _ in range(100):
        put(boat, any_way(rng, boat))
        for dry in (0.0, 0.7):
            force = np.zeros(6)
            wide.add_ideal_fluid(boat.records.vessel, dry, boat.records.state, force)
            powers = force * boat.state.motion[:6]
            assert abs(powers.sum()) < 1e-11 * abs(powers).sum()


def test_the_three_shipped_files_feed_nothing_and_one_that_would_is_clipped() -> None:
    for vessel in BOATS:
        boat = make_boat(vessel)
        assert not is_clipped(boat.file, boat.records.vessel)
    feeding = np.array([[[-1.0, 5.0], [5.0, -1.0]]])
    clipped, changed = dissipative_forces(feeding, (1.0, 1.0))
    assert changed.all()
    assert np.linalg.eigvalsh(0.5 * (clipped[0] + clipped[0].T)).max() < 1e-12
    assert not dissipative_forces(-np.eye(2)[None], (1.0, 1.0))[1].any()


@pytest.mark.parametrize("equations", ["full", "modified", "basic"])
@pytest.mark.parametrize("vessel", BOATS)
def test_inside_the_range_the_bits_are_those_of_the_equations_alone(
    vessel: str, equations: str
) -> None:
    boat, rng = make_boat(vessel, equations), np.random.default_rng(1)
    records = boat.records
    alone = equations_alone(records.scheme)
    for _ in range(200):
        put(boat, any_way(rng, boat))
        s = boat.state
        s.u = abs(s.u) + 2.0
        for name in "vwqr":
            s[name] *= 0.05
        assert wide_share(records.vessel, records.state) == 0.0
        s.rates[:] = 0.0
        rates(*records)
        found = s.rates.copy()
        s.rates[:] = 0.0
        rates(records.vessel, records.compact, alone, records.state, records.scratch)
        assert found.tobytes() == s.rates.tobytes()


def test_between_the_two_the_accelerations_are_blended_without_a_jump() -> None:
    boat = make_boat("bb2", "full", "exact")

    def at(degrees: float) -> np.ndarray:
        angle = math.radians(degrees)
        put(boat, {"u": 5.0 * math.cos(angle), "v": 5.0 * math.sin(angle)})
        rates(*boat.records)
        return np.asarray(boat.state.rates[:6].copy())

    for edge in (35.0, 55.0):
        assert at(edge - 1e-7) == pytest.approx(at(edge + 1e-7), abs=1e-8)
    share = [wide_share(boat.records.vessel, boat.records.state) for _ in [at(45.0)]]
    assert 0.2 < share[0] < 0.3, "by the squares of the tangents"
    astern, ahead = ({"u": u, "v": 0.3, "r": 0.01} for u in (-1e-9, 1e-9))
    put(boat, astern)
    rates(*boat.records)
    before = boat.state.rates[:6].copy()
    put(boat, ahead)
    rates(*boat.records)
    assert before == pytest.approx(boat.state.rates[:6], abs=1e-8)


@pytest.mark.parametrize(
    ("motion", "expected"),
    [
        ({"u": 5.0}, INSIDE_RANGE),
        ({}, INSIDE_RANGE),
        ({"u": 5.0, "w": 5.0 * math.tan(math.radians(11.9))}, INSIDE_RANGE),
        ({"u": 5.0, "w": 5.0 * math.tan(math.radians(12.1))}, EXTRAPOLATED_RANGE),
        ({"u": 5.0, "v": 5.0 * math.tan(math.radians(35.1))}, OUTSIDE_RANGE),
        ({"u": -0.1}, OUTSIDE_RANGE),
        ({"w": 0.1}, OUTSIDE_RANGE),
    ],
)
def test_how_far_the_equations_hold_is_told(motion: dict[str, float], expected: int) -> None:
    boat = make_boat("bb2", "full", "exact")
    put(boat, motion)
    assert validity(boat.records.vessel, boat.records.state) == expected


def test_the_arctangent_is_right_to_two_units_in_the_last_place() -> None:
    rng = np.random.default_rng(2)
    points = rng.normal(size=(20_000, 2)) * 10.0 ** rng.uniform(-6, 6, (20_000, 2))
    found = np.array([arctangent(y, x) for y, x in points])
    exact = np.arctan2(*points.T.astype(np.longdouble))
    assert float(np.max(abs(found - exact) / np.spacing(abs(found)))) <= 2.0
    assert [arctangent(0.0, 1.0), arctangent(0.0, 0.0)] == [0.0, 0.0]
    assert arctangent(1.0, 0.0) == math.pi / 2
    assert arctangent(0.0, -1.0) == math.pi


def test_angles_turned_about_the_boat_s_axes_are_those_of_the_matrix() -> None:
    rng = np.random.default_rng(4)
    for _ in range(200):
        phi, theta, psi = rng.uniform(-1.5, 1.5, 3)
        turn = rng.normal(size=3) * rng.choice([0.0, 1e-12, 1e-3, 1.0])
        heel, pitch, heading = turned(phi, theta, psi, tuple(turn))
        expected = matrix(phi, theta, psi) @ rotation(turn)
        assert matrix(heel, pitch, heading) == pytest.approx(expected, abs=1e-13)


def matrix(phi: float, theta: float, psi: float) -> np.ndarray:
    """Return the matrix of an attitude, body to earth."""
    about_x = rotation(np.array([phi, 0.0, 0.0]))
    about_y = rotation(np.array([0.0, theta, 0.0]))
    about_z = rotation(np.array([0.0, 0.0, psi]))
    return np.asarray(about_z @ about_y @ about_x)


def rotation(turn: np.ndarray) -> np.ndarray:
    """Return the matrix of a turn [rad], by the exponential series."""
    x, y, z = turn
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    total, term = np.eye(3), np.eye(3)
    for n in range(1, 30):
        term = term @ cross / n
        total = total + term
    return total


@pytest.mark.parametrize("integrator", ["adams2", "rk4", "euler", "adams3", "abm4"])
def test_a_boat_that_turns_through_the_vertical_keeps_its_angles(integrator: str) -> None:
    boat = make_boat("bb2", "full", "exact", integrator, 0.1)
    put(boat, {"u": 5.0, "theta": 1.2, "q": 0.2})
    boat.state.history = 0.0
    passed, headings = False, []
    for _ in range(400):
        boat.state.q = 0.2  # driven round
        before = float(boat.state.psi)
        assert boat.tick() == 0
        assert abs(boat.state.theta) <= math.pi / 2
        assert abs(boat.state.phi) <= math.pi + 1e-9
        headings.append(abs(float(boat.state.psi) - before))
        passed = passed or abs(boat.state.phi) > 3.0
    assert passed, "it went over on its back"
    assert max(headings) == pytest.approx(math.pi, abs=0.2)

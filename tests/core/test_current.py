"""Water that moves over ground: what it changes of a boat in it, and what it may not change."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from helpers.boats import make_boat, start_boat, take_in_hand
from helpers.orders import obey_all

from trainer.boat.boat import Boat
from trainer.config.words import EQUATION_SETS
from trainer.config.world.sea import SeaFile, load_sea
from trainer.core.current import carry_along
from trainer.core.state import PAST_CYCLES, new_state
from trainer.session.past.layout import LAYOUT
from trainer.units import KNOT

pytestmark = pytest.mark.core
CURRENT = (1.0, -2.0)  # [m/s]
PLACE = ("x", "y", "xdot", "ydot", "sailed_x", "sailed_y", "water_north", "water_east")
PAST = tuple(
    f"past_{what}[{back},{axis}]"
    for what in ("rates", "motion")
    for back in range(PAST_CYCLES)
    for axis in (9, 10)
)
SHEAR = (-0.02, 0.01)  # [1/s]


def sea_of(name: str) -> SeaFile:
    """Return a shipped sea, or the fifth by the sum of cosines."""
    if name != "cosines":
        return load_sea(name)
    fifth = load_sea("sea-state-5")
    return replace(fifth, sea=replace(fifth.sea, generator="cosines"))


def turning(boat: Boat, sea: str, current: tuple[float, float]) -> Boat:
    """Return a boat in a sea and a current that begins to turn and to change depth."""
    boat.start(8.0 * KNOT, 25.0, 0.3, seed=3)
    boat.put_to_sea(sea_of(sea))
    boat.state.current[:2] = current
    obey_all(boat, "rudder right 15", "depth 40")
    return boat


def sail(boat: Boat, ticks: int) -> None:
    """Take ticks; none may fail."""
    for _ in range(ticks):
        assert boat.advance() == 0


@pytest.mark.long
@pytest.mark.parametrize("sea", ["calm", "sea-state-5"])
@pytest.mark.parametrize("integrator", ["adams2", "rk4", "best2"])
@pytest.mark.parametrize("rates", ["lagged", "exact"])
@pytest.mark.parametrize("equations", EQUATION_SETS)
def test_a_uniform_current_changes_nothing_but_the_place(
    equations: str, rates: str, integrator: str, sea: str
) -> None:
    still, carried = (
        turning(make_boat("bb2", equations, rates, integrator, 0.5), sea, current)
        for current in ((0.0, 0.0), CURRENT)
    )
    began = still.state.z
    for boat in (still, carried):
        sail(boat, 400)
    assert abs(still.state.z - began) > 5.0
    assert_carried(still, carried)


def assert_carried(still: Boat, carried: Boat) -> None:
    """Assert that all bits are the same but those of the place, which is c t apart."""
    same, other = (boat.state.whole.view(np.int64) for boat in (still, carried))
    differs = [name for name, a, b in zip(LAYOUT, same, other, strict=True) if a != b]
    assert [name for name in differs if name not in (*PLACE, *PAST)] == []
    for name, c in zip("xy", CURRENT, strict=True):
        apart = float(carried.state[name] - still.state[name])
        assert apart == pytest.approx(c * still.time, abs=1e-9)


@pytest.mark.parametrize("sea", ["sea-state-5", "cosines"])
def test_waves_are_met_by_the_way_through_the_water(sea: str) -> None:
    still, carried = (turning(make_boat(), sea, current) for current in ((0.0, 0.0), CURRENT))
    for boat in (still, carried):
        boat.state.z = 17.5
        sail(boat, 60)
    assert abs(still.state.wave_cos) > 0.0 or still.state.eta_wave != 0.0
    assert_carried(still, carried)


@pytest.mark.laws
def test_speed_through_the_water_loses_what_the_water_gains() -> None:
    # turned over ground, what shear does to u v w is -c' zdot, level, in any attitude
    state, rng = new_state(), np.random.default_rng(7)
    s = state[0]
    s.shear_north, s.shear_east = SHEAR
    for heel, pitch, heading in rng.uniform(-1.4, 1.4, (50, 3)):
        s.phi, s.theta, s.psi, s.zdot, s.z = heel, pitch, heading, rng.uniform(-3.0, 3.0), 50.0
        s.udot = s.vdot = s.wdot = s.xdot = s.ydot = 0.0
        carry_along(state)
        felt = over_ground(heel, pitch, heading) @ np.array([s.udot, s.vdot, s.wdot])
        np.testing.assert_allclose(felt, [*(-c * s.zdot for c in SHEAR), 0.0], atol=1e-15)
        assert (s.xdot, s.ydot) == (SHEAR[0] * 50.0, SHEAR[1] * 50.0)


def over_ground(heel: float, pitch: float, heading: float) -> np.ndarray:
    """Return what turns a vector of the body's axes to north, east and down."""
    (a, b, c), (d, e, f) = np.cos([heel, pitch, heading]), np.sin([heel, pitch, heading])
    roll = np.array([[1.0, 0.0, 0.0], [0.0, a, -d], [0.0, d, a]])
    lift = np.array([[b, 0.0, e], [0.0, 1.0, 0.0], [-e, 0.0, b]])
    turn = np.array([[c, -f, 0.0], [f, c, 0.0], [0.0, 0.0, 1.0]])
    whole: np.ndarray = turn @ lift @ roll
    return whole


def dived(step: float) -> float:
    """Return the depth [m] after a dive of a minute in shear, surfaces fixed."""
    boat = start_boat(8.0 * KNOT, 60.0, 0.3, rates="exact", step=step)
    take_in_hand(boat)
    boat.state.ordered_s = boat.state.delta_s = boat.state.delta_s - 0.05
    boat.state.current[2:] = SHEAR
    sail(boat, round(60.0 / step))
    return float(boat.state.z)


@pytest.mark.long
def test_in_shear_the_method_keeps_its_second_order() -> None:
    exact = dived(1.0 / 64.0)
    errors = [abs(dived(step) - exact) for step in (1.0, 0.5, 0.25)]
    assert errors[0] < 0.05
    for rough, fine in pairwise(errors):
        assert 3.3 < rough / fine < 5.0

"""The engine turns what its torque and its power allow, and the crew is told at once."""

import math

import numpy as np
import pytest
from helpers.boats import calls_of, make_boat, start_boat, take_ticks

from trainer.boat.calls import MonitorCall, Rank
from trainer.boat.pilot import PilotMonitor
from trainer.core.envelope import AHEAD
from trainer.core.propulsion import most_revolutions
from trainer.units import KNOT

SHAFT_POWER_W, TORQUE_N_M = 5.2e6, 386000.0  # of configs/vessels/bb2.toml
KQ = (0.063982, -0.032470, -0.021064)


def torque(n: float, u: float) -> float:
    """Return the torque [N m] of BB2's propeller, rho n^2 D^5 K_Q(J)."""
    j = u / (n * 5.0)
    return 1025.0 * n * n * 5.0**5 * (KQ[0] + KQ[1] * j + KQ[2] * j * j)


@pytest.mark.parametrize("u", [0.0, 2.0, 5.0, 7.0, 8.0, 9.0, 10.0, 11.0])
def test_revolutions_are_those_of_the_tighter_limit(u: float) -> None:
    boat = make_boat("bb2", "full", "exact")
    n = float(most_revolutions(boat.records.vessel, AHEAD, u / 5.0))
    shares = torque(n, u) / TORQUE_N_M, 2.0 * math.pi * n * torque(n, u) / SHAFT_POWER_W
    assert max(shares) == pytest.approx(1.0, rel=1e-6)
    assert shares.index(max(shares)) == (1 if u > 8.0 else 0)


def test_twenty_knots_take_the_power_that_there_is() -> None:
    boat = start_boat(20.0 * KNOT, 300.0, rates="exact")
    boat.state.speed_by_hand, boat.state.ordered_u_c = 1.0, 20.0 * KNOT
    take_ticks(boat, 1200)
    n, u = float(boat.state.u_c) * 0.22937, float(boat.state.u)
    assert u / KNOT == pytest.approx(20.0, abs=0.02)
    assert 2.0 * math.pi * n * torque(n, u) == pytest.approx(SHAFT_POWER_W, rel=2e-3)


def test_a_limited_engine_is_told_as_soon_as_it_is_ordered() -> None:
    boat = start_boat(5.0 * KNOT, 300.0, equations="modified")
    monitor = PilotMonitor.over(boat)
    boat.state.speed_by_hand, boat.state.ordered_u_c = 1.0, 20.0 * KNOT
    said: list[MonitorCall] = []
    ticks = 0
    while not said and ticks < 40:
        assert boat.tick() == 0
        said, ticks = monitor.look(boat), ticks + 1
    assert boat.time <= 3.0 + 2.0 * boat.method.step  # the engine room's dead time
    assert said[0].rank is Rank.WARNING
    assert said[0].text.endswith("ENGINE: limited by torque, short of the 142 rpm ordered")
    assert list(monitor.times) == ["engine limited by torque"]
    assert calls_of(boat, monitor, 20.0) == []


def test_an_engine_that_has_room_is_not_told() -> None:
    boat = start_boat(5.0 * KNOT, 300.0, equations="modified")
    monitor = PilotMonitor.over(boat)
    boat.state.speed_by_hand, boat.state.ordered_u_c = 1.0, 8.0 * KNOT
    assert calls_of(boat, monitor, 30.0) == []
    assert np.isfinite(boat.state.u_c)

"""Large manoeuvres by linear constants and kappa."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from trainer.config.files import ConfigError
from trainer.identify.measurements import Record
from trainer.identify.nonlinear import Bent, kappa_from_record, kappa_from_turns, predict

STABLE = Bent(-0.05, 40.0, 8.0, 15.0, 400.0)
UNSTABLE = Bent(0.114, -304.0, 13.4, 33.4, 1230.0)  # A K Fernstrom, section 8


def record_of(ship: Any, rudder: Any, step: Any = 2.0, noise: Any = 0.0) -> Any:
    run = predict(ship, rudder, step, np.zeros(2))
    rate = run[:, 0] + noise * np.random.default_rng(4).standard_normal(len(rudder))
    t = step * np.arange(len(rudder))
    return Record(
        source="run", t=t, rudder=rudder, yaw_rate=rate, rows=np.arange(len(t)) + 1, names={}
    )


def helm(angle: Any, count: Any = 400, hold: Any = 50) -> Any:
    signs = np.where(np.arange(count) // hold % 2 == 0, 1.0, -1.0)
    return np.radians(angle) * signs


@pytest.mark.parametrize("ship", [STABLE, UNSTABLE])
def test_a_long_turn_ends_on_the_spiral(ship: Any) -> None:
    rudder = np.full(4000, np.radians(20.0))
    rate = predict(ship, rudder, 2.0, np.zeros(2))[-1, 0]
    assert float(ship.helm(np.array([rate]))[0]) == pytest.approx(np.radians(20.0), rel=1e-9)


def test_the_loop_of_the_unstable_ship_by_hand() -> None:
    # 1/(1230 0.114), half of it, and 1/(4 1230 0.114^2)
    assert UNSTABLE.loop == pytest.approx((0.0071317, 0.0035658, 0.0156396), rel=1e-4)
    rate, fold, angle = UNSTABLE.loop  # type: ignore[misc]
    assert UNSTABLE.helm(np.array([rate]))[0] == pytest.approx(0.0, abs=1e-15)
    assert UNSTABLE.helm(np.array([fold]))[0] == pytest.approx(angle)
    assert STABLE.loop is None


def test_without_kappa_it_is_the_linear_ship() -> None:
    # r of K (1 + T3 s)/((1 + T1 s)(1 + T2 s)) to a step: the textbook's two exponentials
    ship, t = replace(STABLE, kappa=0.0), 3.0 * np.arange(60)
    rate = predict(ship, np.full(60, 0.1), 3.0, np.zeros(2))[:, 0]
    a = (ship.T1 - ship.T3) / (ship.T1 - ship.T2)
    b = (ship.T3 - ship.T2) / (ship.T1 - ship.T2)
    expected = ship.K * 0.1 * (1.0 - a * np.exp(-t / ship.T1) - b * np.exp(-t / ship.T2))
    # in steady change at the first sample: T3 of the step is felt before it
    late = predict(ship, np.append(0.0, np.full(59, 0.1)), 3.0, np.zeros(2))[1:, 0]
    assert late == pytest.approx(expected[:59], abs=1e-8)
    assert rate[-1] == pytest.approx(expected[-1], rel=0.05)


def test_port_and_starboard_are_mirrors() -> None:
    rudder = helm(15.0)
    left = predict(UNSTABLE, rudder, 2.0, np.zeros(2))
    right = predict(UNSTABLE, -rudder, 2.0, np.zeros(2))
    assert left == pytest.approx(-right, abs=1e-15)


def test_kappa_comes_back_from_steady_turns() -> None:
    rates = np.array([-0.012, -0.008, 0.006, 0.009, 0.014])
    noisy = UNSTABLE.helm(rates) + np.radians(0.05) * np.array([1.0, -1.0, 0.5, -0.5, 0.0])
    exact = kappa_from_turns(replace(UNSTABLE, kappa=0.0), UNSTABLE.helm(rates), rates)
    found = kappa_from_turns(replace(UNSTABLE, kappa=0.0), noisy, rates)
    assert exact.ship.kappa == pytest.approx(1230.0, rel=1e-9)
    assert 0.0 < abs(found.ship.kappa - 1230.0) < 4.0 * found.deviation
    with pytest.raises(ConfigError, match="two steady turns"):
        kappa_from_turns(UNSTABLE, np.zeros(1), np.ones(1))


@pytest.mark.parametrize("ship", [STABLE, UNSTABLE])
def test_kappa_comes_back_from_a_manoeuvre(ship: Any) -> None:
    exact = kappa_from_record(replace(ship, kappa=0.0), record_of(ship, helm(20.0)))
    assert exact.ship.kappa == pytest.approx(ship.kappa, rel=1e-5)
    assert exact.deviation < 1e-3 * ship.kappa

    noisy = kappa_from_record(ship, record_of(ship, helm(20.0), noise=2e-4))
    assert abs(noisy.ship.kappa - ship.kappa) < 4.0 * noisy.deviation
    assert noisy.deviation < 0.1 * ship.kappa


def test_kappa_wants_one_interval() -> None:
    record = record_of(STABLE, helm(20.0))
    t = record.t.copy()
    t[10:] += 1.0
    with pytest.raises(ConfigError, match="this one varies"):
        kappa_from_record(STABLE, replace(record, t=t))

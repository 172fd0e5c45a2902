"""A ship that is not linear under way: the states of the filter, rates and limits of the rudder."""

import math
from dataclasses import replace

import numpy as np
import pytest
from helpers.ships import COEFFICIENTS, HEELED, ROLLING, SHIP

from trainer.boat.ship.forces import System
from trainer.boat.ship.models import model_of, with_roll
from trainer.boat.ship.motion import ShipMoment, ShipMotion
from trainer.config.ship.ship import FitResult, ShipFile
from trainer.identify.kernels.extended_filter import sail_record

RESULT = FitResult(model="mmg", speed_kn=15.0, revolutions_per_s=1.5)
QUICK = replace(SHIP.dimensions, rudder_rate_deg_s=1000.0)


def ship(file: ShipFile, coefficients: dict[str, float]) -> ShipFile:
    """Return the file of a fit without wind."""
    calm = {name: one for name, one in coefficients.items() if not name.endswith("w")}
    calm["c_w"] = coefficients["c_w"]
    return replace(file, result=RESULT, coefficients=calm, dimensions=QUICK)


LEVEL, HEELING = ship(SHIP, COEFFICIENTS), ship(ROLLING, HEELED)
T = 2.0  # [s]


@pytest.mark.parametrize("file", [LEVEL, HEELING], ids=["level", "heeling"])
def test_it_sails_to_the_bits_of_the_states_that_a_fit_goes_by(file: ShipFile) -> None:
    model = model_of("mmg", wind=False)
    model = with_roll(model) if file.roll else model
    rudder = math.radians(20.0) * np.sin(np.arange(200) / 15.0)
    record = np.zeros((200, 12))
    record[:, 4], record[:, 5], record[:, 8], record[:, 9] = rudder, 1.5, T, 1.0
    begin = np.array([8.0, *[0.0] * (model.states - 1)])
    values = np.concatenate([model.whole(file.coefficients), np.zeros(len(model.noises)), begin])
    none, states = np.empty((0, 1), np.int64), np.empty((200, model.states))
    system = System(np.array(file.constants), model.terms, values, none, model.driven)
    assert sail_record(system, record, states) == 200

    motion, now = ShipMotion(file), ShipMoment(0.0, 0.0, tuple(begin.tolist()), 0.0, 1.5)
    for row in range(1, 200):
        then = motion.after(now, float(rudder[row]), T)
        assert then is not None
        now = then
        assert now.state == tuple(states[row].tolist())
    assert abs(now.east) > 100.0


def test_the_rudder_goes_no_faster_and_no_further_than_it_can() -> None:
    motion = ShipMotion(replace(LEVEL, dimensions=SHIP.dimensions))
    now, angles = motion.straight(8.0), []
    for _ in range(40):
        then = motion.after(now, -9.0, 0.5)
        assert then is not None
        now = then
        angles.append(math.degrees(now.rudder))
    assert np.diff(angles)[:20] == pytest.approx(-0.5 * SHIP.dimensions.rudder_rate_deg_s)
    assert angles[-1] == pytest.approx(-SHIP.dimensions.rudder_limit_deg)


def test_straight_ahead_it_stays_so() -> None:
    motion = ShipMotion(HEELING)
    now = begun = motion.straight(7.0)
    for _ in range(100):
        then = motion.after(now, begun.rudder, 1.0)
        assert then is not None
        now = then
    assert now.state == pytest.approx(begun.state, abs=1e-8)
    assert now.north == pytest.approx(700.0)


def test_without_way_it_is_no_ship() -> None:
    motion = ShipMotion(LEVEL)
    assert (
        motion.after(ShipMoment(0.0, 0.0, (0.01001, 0.0, 0.0, 0.0), 0.0, 0.0), 0.0, 900.0) is None
    )

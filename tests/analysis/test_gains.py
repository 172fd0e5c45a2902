"""The design of the autopilot: it gives the gains that the vessel files hold, or says why not."""

import math
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from trainer.analysis.gains import design_gains, design_text, regulator
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError


@pytest.mark.parametrize("vessel", ["bb2", "sdv-mk9", "remus100"])
def test_the_gains_in_a_vessel_file_are_those_the_design_gives(vessel: str) -> None:
    file = load_vessel(vessel)
    assert file.autopilot is not None
    for key, designed in design_gains(file).items():
        assert getattr(file.autopilot, key) == pytest.approx(designed, rel=2e-3, abs=1e-9), key


def test_the_designed_table_is_read_as_written() -> None:
    file = load_vessel("sdv-mk9")
    assert tomllib.loads(design_text(file)) == {"autopilot": design_gains(file)}


def test_a_regulator_of_known_gain_is_found() -> None:
    # x' = x + u, costs 1 and 1: P = (1 + sqrt 5) / 2 and K = P / (1 + P), textbook
    golden = 0.5 * (1.0 + math.sqrt(5.0))
    one = np.eye(1)
    assert regulator(one, one, one, np.ones(1))[0, 0] == pytest.approx(golden / (1.0 + golden))


def test_a_boat_that_no_gains_hold_is_refused() -> None:
    file = load_vessel("remus100")
    slow = replace(file, surfaces=replace(file.surfaces, time_constant_s=30.0))
    with pytest.raises(ConfigError, match="no gains hold this boat"):
        design_gains(slow)

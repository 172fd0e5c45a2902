"""Whole runs of an independent implementation, replayed control by control."""

import json

import numpy as np
import pytest
from helpers.boats import make_boat
from helpers.places import DATA

from trainer.core.integrators import advance

pytestmark = pytest.mark.core

FOOT = 0.3048
RUNS = json.loads((DATA / "trajectories.json").read_text())
# u v w [ft/s], p q r [rad/s], phi theta psi [rad], x y z [ft]
SCALE = np.array([FOOT] * 3 + [1.0] * 6 + [FOOT] * 3)


@pytest.mark.parametrize("run", RUNS["trajectories"], ids=lambda run: run["title"][:2].strip())
def test_recorded_controls_give_the_recorded_trajectory(
    run: dict,  # type: ignore[type-arg]
) -> None:
    rates = "lagged" if run["lagged"] else "exact"
    integrator = {"ab2": "adams2", "rk4": "rk4"}[run["method"]]
    boat = make_boat("full-refsub.vessel.toml", "full", rates, integrator, run["h"])
    s = boat.state
    s.motion[:] = np.array(run["state0"]) * SCALE

    for step, (rudder, stern, bow, u_c) in enumerate(run["control_per_step"]):
        if step % run["output_every"] == 0:
            expected = np.array(run["states"][step // run["output_every"]]) * SCALE
            error = np.abs(np.array(s.motion) - expected) / np.maximum(np.abs(expected), 1.0)
            assert error.max() < 1e-7, f"step {step}"
        s.delta_r, s.delta_s, s.delta_b, s.u_c = rudder, stern, bow, u_c * FOOT
        advance(*boat.records)

"""States outside the range: ``trainer boat evaluate --wide`` against vectors made elsewhere.

Those of the deep states are of a program that has the wide set by vectors and matrices: momentum P
and angular momentum L of body and water turn with the axes, by -(omega x P) and by -(omega x L +
velocity x P). The last five, near the surface, are our own, kept.
"""

import json

import numpy as np
import pytest
from helpers.places import DATA

from trainer.analysis.programs.evaluate import evaluate_lines
from trainer.config.boat.vessel import load_vessel
from trainer.config.files import ConfigError

BOAT = "tests/bench/standard_boat.toml"  # frozen, so that the vectors stay
STATES = (DATA / "wide" / "states.jsonl").read_text().splitlines()
EXPECTED = (DATA / "wide" / "expected.jsonl").read_text().splitlines()
SURFACED_COUNT = 5  # of the states, at the end


def evaluated(lines: list[str], *, wide: bool = True) -> np.ndarray:
    """Return the rates of states (n, 12)."""
    file = load_vessel(BOAT)
    answers = evaluate_lines(file, "full", "exact", "exact", lines, wide=wide)
    return np.array([list(json.loads(answer).values()) for answer in answers])


def test_states_outside_the_range_have_the_rates_of_the_vectors() -> None:
    wanted = np.array([list(json.loads(text).values()) for text in EXPECTED])
    assert evaluated(STATES) == pytest.approx(wanted, rel=1e-9, abs=1e-10)


def test_a_surfaced_boat_is_pushed_down_by_the_weight_that_stands_out() -> None:
    for text in STATES[-SURFACED_COUNT:]:
        state = json.loads(text)
        sunk = json.dumps({**state, "z": 200.0})
        (high,), (low,) = evaluated([text]), evaluated([sunk])
        assert high[2] * np.cos(state["theta"]) > low[2] * np.cos(state["theta"]) + 0.01


def test_without_wide_the_same_states_have_the_equations_of_1969() -> None:
    assert np.abs(evaluated(STATES, wide=False) - evaluated(STATES)).max(axis=1).min() > 1e-6


def test_wide_needs_the_depth() -> None:
    state = json.loads(STATES[0])
    del state["z"]
    with pytest.raises(ConfigError, match="line 1: lacks z"):
        evaluated([json.dumps(state)])

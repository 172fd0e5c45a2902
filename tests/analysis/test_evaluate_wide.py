"""States outside the range: ``trainer boat evaluate --wide`` against a second implementation."""

import json

import numpy as np
import pytest
from helpers import wide_reference
from helpers.places import DATA

from trainer.analysis.programs.evaluate import evaluate_lines
from trainer.boat.assemble import Method, fit_out
from trainer.config.files import ConfigError
from trainer.config.vessel import load_vessel
from trainer.core.envelope import wide_share
from trainer.core.surfaced import is_near_surface

BOAT = "trainer/analysis/bench/standard_boat.toml"  # frozen, so that the vectors stay
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
    assert evaluated(STATES) == pytest.approx(wanted, rel=1e-9, abs=1e-12)


def test_a_second_implementation_has_the_same_rates() -> None:
    file = load_vessel(BOAT)
    records = fit_out(file, Method("full", "exact", "exact", "adams2", 1.0))
    deep = STATES[:-SURFACED_COUNT]
    found = evaluated(deep)
    for text, ours in zip(deep, found, strict=True):
        state = json.loads(text)
        for name, value in state.items():
            records.state[name] = value
        assert wide_share(records.vessel, records.state) == 1.0, text
        assert not is_near_surface(records.vessel, 0.0, records.state)
        theirs = wide_reference.rates(records.vessel[0], state)
        assert ours == pytest.approx(theirs, rel=1e-9, abs=1e-10), text


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

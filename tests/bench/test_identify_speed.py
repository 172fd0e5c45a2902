"""The speed of identification: what is compared is the same, and what is not here is said."""

import functools
import json
from typing import Any

import pytest
from cases.reference_ships import TANKER, TANKER_RUDDER
from helpers.typed import type_command

from bench import identify, sections
from bench.__main__ import bench as bench_command
from bench.identify import by_statsmodels
from trainer.identify.fitting.likelihood import Likelihood


@functools.cache
def record_of(name: str) -> Any:
    """Return a record of a kind that the filter treats in its own way."""
    if name == "whole":
        return identify.draw_record(TANKER.problem(TANKER_RUDDER[:300]))
    if name == "missing":
        return identify.draw_record(TANKER.problem(TANKER_RUDDER[:300], 0.2))
    variances = {"P11": 0.02, "P22": 1e-6, "P33": 1e-3, "P12": 1e-5}
    wind = {"Y_psi": 2e-3, "l_psi": 0.3}
    started = TANKER.freed(*variances, *wind, **variances, **wind)
    return identify.draw_record(started.problem(TANKER_RUDDER[:200]))


@pytest.mark.long
@pytest.mark.parametrize("name", ["whole", "missing", "started"])
def test_the_likelihood_of_statsmodels_is_ours(name: Any) -> None:
    kalman = pytest.importorskip("statsmodels.tsa.statespace.kalman_filter")
    problem = record_of(name)
    value = Likelihood(problem).value(problem.start)
    # its gain is kept from when its covariance changes by less than 1e-19, in squares of knots
    assert by_statsmodels(kalman, problem, problem.start)() == pytest.approx(value, rel=1e-6)


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let everything be measured once, and no process started."""
    monkeypatch.setattr(identify, "ROUNDS", 1)
    monkeypatch.setattr(identify, "BATCH_S", 0.0)
    monkeypatch.setattr(sections, "SAMPLES", 100)
    monkeypatch.setattr(identify, "FITS", 1)
    monkeypatch.setattr(identify, "MOST", 1)


def bench(*words: Any) -> Any:
    return type_command(bench_command, "--identify", *words).output


@pytest.mark.slow
@pytest.mark.usefixtures("quick")
def test_every_goal_has_its_figure() -> None:
    pytest.importorskip("statsmodels")
    found = json.loads(bench("--json"))["identify"]

    assert (found["samples"], found["parameters"]) == (100, 19)
    assert len(found["rows"]) == 6
    assert all(row["figure"] > 0.0 for row in found["rows"])
    figures = {row["name"]: row for row in found["rows"]}
    assert figures["gradient and information, likelihoods"]["figure"] > 1.0


@pytest.mark.long
@pytest.mark.usefixtures("quick")
def test_what_is_not_here_is_left_out_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> None:
        raise ImportError

    monkeypatch.setattr(identify, "filters", none)
    page = bench()

    assert "fit, of statsmodels' BFGS                            -      1/50  left out" in page
    assert page.count("statsmodels is not installed") == 3
    assert max(map(len, page.splitlines())) <= 79

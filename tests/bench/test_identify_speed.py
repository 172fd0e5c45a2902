"""The speed of identification: what is compared is the same, and what is not here is said."""

import functools
import json
from typing import Any

import pytest
from cases.reference_ships import TANKER, TANKER_RUDDER
from helpers.typed import type_command

from bench import identify, sections
from bench.__main__ import bench as bench_command
from bench.identify import Paces, Row, Speed, by_statsmodels, likelihoods_of_a_fit
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


def test_a_minimiser_by_differences_asks_for_many_likelihoods(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("scipy.optimize")
    monkeypatch.setattr(identify, "MOST", 2)
    problem = record_of("whole")
    asked = likelihoods_of_a_fit(Likelihood(problem), TANKER.start())
    assert asked >= 3 * (1 + len(problem.free))


def test_a_ratio_is_the_median_of_rounds() -> None:
    paces = Paces(((8.0, 4.0), (12.0, 12.0), (40.0, 10.0)))
    assert (paces.median(0), paces.ratio(0, 1)) == (12.0, 2.0)


def test_works_take_turns_in_batches_long_enough(monkeypatch: pytest.MonkeyPatch) -> Any:
    clock, done = [0.0], []
    monkeypatch.setattr(identify, "ROUNDS", 2)
    monkeypatch.setattr(identify.time, "thread_time", lambda: clock[0])  # type: ignore[attr-defined]

    def work(name: Any, seconds: Any) -> Any:
        def run() -> None:
            clock[0] += seconds
            done.append(name)

        return run

    paces = identify.time_in_turn([work("slow", 2e-3), work("quick", 1e-3)])

    assert done[-12:] == 2 * ["slow", "slow", *4 * ["quick"]]
    assert paces.ratio(0, 1) == pytest.approx(2.0)


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


@pytest.mark.usefixtures("quick")
def test_what_is_not_here_is_left_out_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> None:
        raise ImportError

    monkeypatch.setattr(identify, "filters", none)
    page = bench()

    assert "fit, of statsmodels' BFGS                            -      1/50  left out" in page
    assert page.count("statsmodels is not installed") == 3
    assert max(map(len, page.splitlines())) <= 79


def test_a_figure_beyond_what_is_wanted_is_missed() -> None:
    rows = Row("a", 0.021, 0.02), Row("b", 1.5, 1.5), Row("c", None, 5.0, "why")
    page = identify.lines(Speed(2000, 19, 65.4, rows))

    assert [row.word for row in rows] == ["MISSED", "holds", "left out"]
    assert [" ".join(line.split()) for line in page[-4:]] == [
        "a 1/47.6 1/50 MISSED",
        "b 1.5 1.5 holds",
        "c - 5 left out",
        "why",
    ]

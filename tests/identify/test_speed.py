"""The bench of identification: what it compares is the same, and what is not here is said."""

import json
import shutil
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from trainer.boat.export.targets import NoCompilerError
from trainer.cli import main
from trainer.identify.likelihood import Likelihood
from trainer.verify.bench import identify, sections
from trainer.verify.bench.identify import Paces, Row, Speed, by_statsmodels, likelihoods_of_a_fit
from trainer.verify.c_reference.compiler import likelihood_in_c
from trainer.verify.cases.reference_ships import ISLAND, TANKER, TANKER_RUDDER

compiler = pytest.mark.skipif(
    not shutil.which("gcc") and not shutil.which("cc"), reason="no C compiler"
)


def records() -> Any:
    """Yield records of every kind that the filter in C treats in its own way."""
    question = TANKER.problem(TANKER_RUDDER[:300])
    yield "whole", identify.draw_record(question)
    yield "missing", identify.draw_record(TANKER.problem(TANKER_RUDDER[:300], 0.2))
    yield "varied", identify.draw_record(identify.vary_intervals(question))
    yield "an island", identify.draw_record(ISLAND.problem(TANKER_RUDDER[:200]))
    variances = {"P11": 0.02, "P22": 1e-6, "P33": 1e-3, "P12": 1e-5}
    wind = {"Y_psi": 2e-3, "l_psi": 0.3}
    started = TANKER.freed(*variances, *wind, **variances, **wind)
    yield "started", identify.draw_record(started.problem(TANKER_RUDDER[:200]))


RECORDS = dict(records())


@compiler
@pytest.mark.parametrize("name", RECORDS)
def test_the_likelihood_in_c_is_ours(name: Any) -> None:
    problem = RECORDS[name]
    in_c = likelihood_in_c()
    for theta in (problem.start, 0.9 * problem.start):
        value = Likelihood(problem).value(theta)
        assert in_c(problem, theta)() == pytest.approx(value, rel=1e-9)


@compiler
def test_an_impossible_model_is_none_in_c_either() -> None:
    problem = TANKER.freed(P11=1e-3, P22=1e-6, P12=1.0).problem(TANKER_RUDDER[:50])
    assert np.isnan(likelihood_in_c()(problem, problem.start)())


@pytest.mark.parametrize("name", ["whole", "missing", "started"])
def test_the_likelihood_of_statsmodels_is_ours(name: Any) -> None:
    kalman = pytest.importorskip("statsmodels.tsa.statespace.kalman_filter")
    problem = RECORDS[name]
    value = Likelihood(problem).value(problem.start)
    # its gain is kept from when its covariance changes by less than 1e-19, in squares of knots
    assert by_statsmodels(kalman, problem, problem.start)() == pytest.approx(value, rel=1e-6)


def test_a_minimiser_by_differences_asks_for_many_likelihoods(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pytest.importorskip("scipy.optimize")
    monkeypatch.setattr("trainer.verify.bench.identify.MOST", 2)
    problem = RECORDS["whole"]
    asked = likelihoods_of_a_fit(Likelihood(problem), TANKER.start())
    assert asked >= 3 * (1 + len(problem.free))


def test_without_slopes_the_systems_are_real_and_the_same() -> None:
    problem = RECORDS["varied"]
    plain, sloped = problem.sampled(problem.start), problem.sloped(problem.start)
    for one, other in zip(plain.at(0), sloped.at(0), strict=True):
        assert np.isrealobj(one)
        np.testing.assert_allclose(one, other, rtol=1e-13, atol=1e-16)
    assert np.isrealobj(plain.mean)
    assert np.iscomplexobj(plain.as_complex().mean)


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
    monkeypatch.setattr("trainer.verify.bench.identify.MOST", 1)


def bench(*words: Any) -> Any:
    result = CliRunner().invoke(main.cli, ["bench", "--identify", *words])
    assert result.exit_code == 0, result.output
    return result.output


@compiler
@pytest.mark.usefixtures("quick")
def test_every_goal_has_its_figure() -> None:
    pytest.importorskip("statsmodels")
    found = json.loads(bench("--json"))["identify"]

    assert (found["samples"], found["parameters"]) == (100, 19)
    assert len(found["rows"]) == 9
    assert all(row["figure"] > 0.0 for row in found["rows"])
    figures = {row["name"]: row for row in found["rows"]}
    assert figures["gradient and information, likelihoods"]["figure"] > 1.0


@pytest.mark.usefixtures("quick")
def test_what_is_not_here_is_left_out_and_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> None:
        raise ImportError

    monkeypatch.setattr(identify, "filters", none)
    monkeypatch.setenv("CC", "no-such-compiler")

    page = bench()

    assert "likelihood, one interval, of C                       -       1.5  left out" in page
    assert "no C was compiled: CC is 'no-such-compiler'" in page
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


def test_no_compiler_is_the_only_trouble_that_leaves_c_out(monkeypatch: pytest.MonkeyPatch) -> None:
    def lacks() -> None:
        raise NoCompilerError("none")

    def fails() -> None:
        raise ValueError("another")

    monkeypatch.setattr(identify, "likelihood_in_c", lacks)
    assert identify.in_c() == identify.Other("C", None, "none")
    monkeypatch.setattr(identify, "likelihood_in_c", fails)
    with pytest.raises(ValueError, match="another"):
        identify.in_c()

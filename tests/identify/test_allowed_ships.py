"""What a record leaves open: other ships drawn, intervals, simpler models, and the page."""

import json
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.studies import columns
from helpers.typed import type_command

from trainer.cli.workshop.identify import identify
from trainer.identify.experiment import hold_bits, prbs
from trainer.identify.fitting.minimise import ignore_news
from trainer.identify.fitting.problem import problem_of
from trainer.identify.judge.allowed import _draw_parameters, draw_allowed, pulse_of, step_of
from trainer.identify.judge.fitted import fit_study
from trainer.identify.judge.uncertainty import draw_parameters as draws
from trainer.identify.judge.uncertainty import propagate_covariance, span_draws
from trainer.identify.judge.validation import draw_outputs
from trainer.identify.model.models import MODELS, Plant, Ship
from trainer.identify.options import IdentifyOptions, study_of
from trainer.identify.record.measurements import Samples
from trainer.identify.record.study import observe_record
from trainer.identify.sheet import sheet
from trainer.report.plots import Curve, Panel, Screen

pytest.importorskip("scipy")

K, T1, T2, T3 = -0.05, 20.0, 6.0, 4.0
STUDY = (
    """
schema = "identify/1"
name = "a <second>-order ship"
data = "trial.csv"

"""
    + columns(t="t s", rudder="helm deg", yaw_rate="rate deg/s")
    + """[ship]
length_m = 120
speed_kn = 12

[model]
kind = "nomoto2"
outputs = ["yaw_rate"]
"""
)


@pytest.fixture(scope="module")
def path(tmp_path_factory: Any) -> Any:
    """Return the study of a trial of a second-order ship, read every 2 s."""
    folder = tmp_path_factory.mktemp("trial")
    helm = np.resize(hold_bits(prbs(6), 5.0, 5), 300)
    plant = Plant(MODELS["nomoto2"], Ship(120.0, 6.2), ("yaw_rate",), 2.0)
    values = plant.model.vector(K=K, T1=T1, T2=T2, T3=T3, R1_2=1e-9, R2_r=4e-4)
    t = 2.0 * np.arange(300.0)
    problem = problem_of(plant, Samples(t, np.zeros((300, 1)), helm[:, None]), values, ("b2",))
    rate = draw_outputs(problem, problem.start, np.random.default_rng(3)).outputs[:, 0]
    rows = np.column_stack([t, helm, rate])
    np.savetxt(folder / "trial.csv", rows, delimiter=",", header="t,helm,rate", comments="")
    study = folder / "study.toml"
    study.write_text(STUDY)
    return study


@pytest.fixture(scope="module")
def fitted(path: Any) -> Any:
    study = study_of(path, IdentifyOptions())
    return fit_study(study, observe_record(study), ignore_news)


def told(path: Any, *options: Any) -> Any:
    return type_command(identify, path, *options).stdout


def test_intervals_of_what_is_linear_are_those_of_the_delta_method() -> Any:
    theta, covariance = np.array([2.0, 3.0]), np.array([[0.04, 0.01], [0.01, 0.09]])

    def derived(one: Any) -> Any:
        return np.array([one[0] - 2.0 * one[1]])

    spread = propagate_covariance(derived, theta, covariance)
    _, span = span_draws(derived, draws(theta, covariance, 20000, 1))
    half = 1.96 * spread.deviations
    # 20,000 draws know a 2.5 % quantile to 1.5 % of a deviation
    assert span.low == pytest.approx(spread.values - half, abs=0.05 * half[0])
    assert span.high == pytest.approx(spread.values + half, abs=0.05 * half[0])


def test_intervals_of_a_square_stay_above_nothing() -> None:
    _, span = span_draws(np.square, draws(np.array([0.1]), np.array([[1.0]]), 5000, 1))
    assert span.low[0] >= 0.0
    # z^2 is beyond 5.02 in 2.5 % of draws, and 0.1 is little beside 1
    assert span.high[0] == pytest.approx(5.02, rel=0.1)


def test_a_number_that_no_draw_has_has_no_interval() -> Any:
    def derived(one: Any) -> Any:
        return np.array([one[0], np.nan])

    _, span = span_draws(derived, draws(np.zeros(1), np.ones((1, 1)), 100, 1))
    assert np.isfinite(span.low[0])
    assert np.isnan(span.low[1])


def test_draws_of_small_numbers_are_not_lost_beside_a_huge_one() -> None:
    width = np.array([1e-6, 1e-6, 1e10])
    correlations = np.array([[1.0, 0.9, 0.5], [0.9, 1.0, 0.5], [0.5, 0.5, 1.0]])
    found = draws(np.zeros(3), correlations * np.outer(width, width), 20000, 1)
    assert np.std(found, axis=0) == pytest.approx(width, rel=0.03)
    assert np.corrcoef(found.T) == pytest.approx(correlations, abs=0.02)


@pytest.mark.slow
def test_the_ships_allowed_hold_the_truth_and_the_estimate(fitted: Any) -> None:
    others = draw_allowed(fitted)
    spans = dict(zip(fitted.quantity_names, zip(*others.spans, strict=True), strict=True))
    for name, truth in (("K", K), ("T1", T1), ("T2", T2), ("T1 + T2", T1 + T2)):
        low, high = spans[name]
        assert low < truth < high, name
    assert others.lost < 0.05


def test_a_step_ends_at_the_gain_and_a_pulse_is_its_slope(fitted: Any) -> None:
    others = draw_allowed(fitted)
    step = others.response(step_of(fitted)[:, None])
    told_of = dict(zip(fitted.quantity_names, fitted.quantity_spread.values, strict=True))
    assert (step.middle[:2] == 0.0).all()  # the rudder moves at the second sample
    # six time constants after, exp(-6) is left
    assert step.middle[-1, 0] == pytest.approx(told_of["K"], rel=0.02)
    assert (step.low <= step.middle).all()
    assert (step.middle <= step.high).all()
    pulse = others.response(pulse_of(fitted)[:, None])
    # a pulse is the difference of two steps over the interval between them
    assert np.sum(pulse.middle[:, 0]) * 2.0 == pytest.approx(told_of["K"], rel=0.05)


def test_draws_that_are_no_models_are_left_out_and_told(fitted: Any) -> None:
    loose = fitted.known.covariance.copy()
    place = fitted.problem.names.index("a1")
    loose[place, place] = 4.0  # a1 below nothing, a ship that spins away, is as likely as another
    others = draw_allowed(replace(fitted, known=replace(fitted.known, covariance=loose)))
    assert 0.0 < others.lost < 0.5
    assert np.isfinite(others.outputs.high).all()


def test_the_band_by_rudder_alone_is_about_the_model_itself(fitted: Any) -> None:
    band = draw_allowed(fitted).outputs
    run = band.middle[:, 0]
    measured = fitted.problem.samples.outputs[:, 0]
    assert np.std(measured - run) < 0.2 * np.std(measured)
    assert (band.low <= band.high).all()


def test_a_lever_arm_is_drawn_by_its_moment() -> None:
    names = ("Y_delta", "l_delta")
    theta = np.array([0.014, 0.5])
    # force known to a third, moment to a hundredth
    covariance = np.array([[2.2e-5, -7.8e-4], [-7.8e-4, 2.8e-2]])
    found = _draw_parameters(names, theta, covariance)
    assert np.std(found[:, 0] * found[:, 1]) < 0.1 * 0.007


@pytest.mark.slow
def test_the_page_and_the_json_have_intervals_and_directions(path: Any) -> None:
    report = json.loads(told(path, "--json"))
    ship = {one["name"]: one for one in report["ship"]}
    assert ship["T1"]["low"] < ship["T1"]["value"] < ship["T1"]["high"]
    assert len(report["eigenvalues"]) == len(report["parameters"])
    values = [one["eigenvalue"] for one in report["eigenvalues"]]
    assert values == sorted(values)
    assert sum(part**2 for part in report["eigenvalues"][-1]["parts"].values()) > 0.8
    assert report["collapsed"] == []
    assert "T1 + T2" in told(path)


@pytest.mark.slow
def test_a_model_is_tested_against_a_simpler_one_and_without_a_parameter(path: Any) -> None:
    report = json.loads(
        told(path, "--json", "--against", "nomoto1", "--without", "delta_0", "--without", "T3")
    )
    without, against = report["rivals"]
    assert against["name"] == "model nomoto1"
    assert against["probability"] < 0.001
    assert against["freedom"] == len(report["parameters"]) - against["parameters"]
    assert without["name"] == "without delta_0, T3"
    assert without["freedom"] == 2
    ratio = 2.0 * (report["log_likelihood"] - without["log_likelihood"])
    assert without["ratio"] == pytest.approx(ratio)


@pytest.mark.slow
def test_a_parameter_that_is_nothing_is_not_missed(path: Any) -> None:
    report = json.loads(told(path, "--json", "--without", "delta_0"))
    assert report["rivals"][0]["probability"] > 0.01


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--without", "lag"), "lag: it was not estimated"),
        (("--against", "2"), "it has no yaw_rate"),
        (("--model", "nomoto1", "--against", "nomoto2"), "not more than"),
    ],
)
def test_tests_of_what_is_no_simpler_model_are_refused(path: Any, options: Any, words: Any) -> None:
    result = CliRunner().invoke(identify, [str(path), *options])
    assert words in str(result.exception)


@pytest.mark.slow
def test_the_sheet_needs_nothing_beside_itself_and_holds_the_figures(
    path: Any, tmp_path: Path
) -> None:
    page = tmp_path / "fit.html"
    report = json.loads(told(path, "--html", str(page), "--json"))
    text = page.read_text()
    assert not re.search(r'(src|href)="http', text)
    data = re.search(r'<script type="application/json" id="identified">(.*?)</script>', text)
    assert json.loads(data[1]) == report  # type: ignore[index]
    assert "<second>" not in text.replace(data[0], "")  # type: ignore[index]
    assert "a &lt;second&gt;-order ship" in text
    assert text.count("<svg") > 6
    assert "by a step of 1 deg" in text
    assert "Known least</h2>" in text
    again = tmp_path / "again.html"
    told(path, "--html", str(again))
    assert again.read_bytes() == page.read_bytes()


def test_black_boxes_have_a_sheet_too(path: Any, tmp_path: Path) -> None:
    page = tmp_path / "armax.html"
    told(path, "--armax", "--most", "2", "--html", str(page))
    assert "ARMAX MODELS of yaw_rate" in page.read_text()


def test_a_record_that_tells_nothing_is_refused_with_what_is_odd_about_it(
    path: Any, tmp_path: Path
) -> None:
    rows = np.loadtxt(path.parent / "trial.csv", delimiter=",", skiprows=1)
    rows[:, 2] = 0.0
    np.savetxt(tmp_path / "trial.csv", rows, delimiter=",", header="t,helm,rate", comments="")
    (tmp_path / "study.toml").write_text(STUDY)
    result = CliRunner().invoke(identify, [str(tmp_path / "study.toml")])
    assert "tells nothing of" in str(result.exception)
    assert "rate: is the same in all rows" in str(result.exception)


def test_names_of_anybody_s_making_come_out_as_text() -> None:
    evil = '<script>alert("x")</script>'
    panel = Panel(evil, evil, evil, (Curve(evil, np.arange(3.0), np.arange(3.0)),))
    text = sheet(evil, f"{evil}\n{evil}", [Screen(evil, (panel,))], Named(evil))
    page, _, data = text.partition('<script type="application/json"')
    assert "<script" not in page
    assert page.count("&lt;script&gt;alert(&#34;x&#34;)&lt;/script&gt;") >= 6
    assert data.count("</script>") == 1  # its own end


@dataclass(frozen=True)
class Named:
    """A report of nothing but a name."""

    name: str

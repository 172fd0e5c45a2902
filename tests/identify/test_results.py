"""What a fit yields: its series, matrices, terms, Bode figures, and its page of screens."""

import csv
import json
import math
import re
from dataclasses import replace
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
from trainer.identify.fitting.nonlinear import BendEstimate, BentShip
from trainer.identify.fitting.problem import problem_of
from trainer.identify.judge.allowed import draw_allowed
from trainer.identify.judge.fitted import fit_study
from trainer.identify.judge.validation import draw_outputs, simulate_deterministic
from trainer.identify.model.models import MODELS, Plant, Ship
from trainer.identify.pages.identify import screens
from trainer.identify.pages.results import describe_fit
from trainer.identify.pages.series import bent_terms, matrices_of, series_of, terms_of
from trainer.identify.record.measurements import Samples
from trainer.identify.record.study import load_study, observe_record
from trainer.identify.sheet import MAX_PANELS
from trainer.report.panels import draw_panel
from trainer.report.plots import Curve, Panel

pytest.importorskip("scipy")

STEP, COUNT = 2.0, 200
SHIP = Ship(120.0, 6.2)
TRUTH = {  # Model 1, prime
    "m11": 0.02,
    "m12": 0.0,
    "m21": 0.0,
    "m22": 0.0012,
    "Y_v": -0.03,
    "Y_r": -0.012,
    "N_v": -0.008,
    "N_r": -0.006,
    "Y_delta": 0.006,
    "l_delta": 0.5,
    "R1_Y": 1e-8,
    "R1_N": 1e-9,
    "R2_v1": 1e-4,
    "R2_r": 4e-4,
    "R2_psi": 1e-3,
}
STUDY = (
    """
schema = "identify/1"
name = "a ship"
data = "trial.csv"

"""
    + columns(t="t s", rudder="helm deg", sway="log kn", yaw_rate="rate deg/s", heading="gyro deg")
    + """[ship]
length_m = 120
speed_kn = 12.052

[model]
kind = "1"
outputs = ["sway", "yaw_rate", "heading"]
"""
)
OUTPUTS = ("sway", "yaw_rate", "heading")


@pytest.fixture(scope="module")
def path(tmp_path_factory: Any) -> Any:
    """Return the study of a trial of Model 1's ship, one reading of which is missing."""
    folder = tmp_path_factory.mktemp("trial")
    helm = np.resize(hold_bits(prbs(6), 5.0, 5), COUNT)
    plant = Plant(MODELS["1"], SHIP, OUTPUTS, STEP)
    t = STEP * np.arange(float(COUNT))
    nothing = Samples(t, np.zeros((COUNT, 3)), helm[:, None])
    problem = problem_of(plant, nothing, plant.model.vector(**TRUTH), ("Y_v",))
    readings = draw_outputs(problem, problem.start, np.random.default_rng(5)).outputs
    readings[50, 0] = np.nan
    rows = np.column_stack([t, helm, readings])
    lines = [",".join("" if math.isnan(x) else repr(float(x)) for x in row) for row in rows]
    (folder / "trial.csv").write_text("\n".join(["t,helm,log,rate,gyro", *lines]) + "\n")
    given = [
        f'\n[[parameters]]\nname = "{name}"\nstart = {TRUTH[name]}\n' for name in list(TRUTH)[:10]
    ]
    (folder / "study.toml").write_text(STUDY + "".join(given))
    return folder / "study.toml"


def fitted_as(path: Path, kind: str = "1", noise: str = "covariance") -> Any:
    """Return the fit of the trial by a model and a noise model."""
    study = load_study(path)
    outputs = tuple(name for name in OUTPUTS if name in MODELS[kind].outputs)
    rows = study.parameters if kind == "1" else ()
    table = replace(study.model, kind=kind, outputs=outputs, noise=noise, restarts=2)  # type: ignore[type-var]
    study = replace(study, model=table, parameters=rows)
    return fit_study(study, observe_record(study), ignore_news)


@pytest.fixture(scope="module")
def fitted(path: Any) -> Any:
    return fitted_as(path)


@pytest.fixture(scope="module")
def described(fitted: Any) -> Any:
    return describe_fit(fitted)


def told(path: Path, *options: Any) -> Any:
    return type_command(identify, path, *options).stdout


@pytest.mark.parametrize("noise", ["covariance", "innovations", "output-error"])
def test_series_of_every_noise_model_add_up(path: Any, noise: Any) -> None:
    fitted = fitted_as(path, "nomoto1", noise)
    found = series_of(fitted)
    rate = found["yaw_rate_measured_deg_s"]
    assert rate == pytest.approx(np.degrees(fitted.record.yaw_rate))
    for known, left in (("model", "error"), ("predicted", "residual")):
        there = found[f"yaw_rate_{known}_deg_s"] + found[f"yaw_rate_{left}_deg_s"]
        assert there == pytest.approx(rate, abs=1e-9)
    # the prediction is the predicted state, read without error
    bias = fitted.values[fitted.problem.plant.model.index("r_0")]
    states = np.degrees(found["state_r"]) + bias
    assert states == pytest.approx(found["yaw_rate_predicted_deg_s"], abs=1e-9)
    alone = simulate_deterministic(fitted.problem, fitted.found.theta)
    assert found["yaw_rate_model_deg_s"] == pytest.approx(alone[:, 2])


def test_a_csv_holds_the_series_and_leaves_a_missing_reading_empty(
    path: Any, fitted: Any, tmp_path: Path
) -> None:
    file = tmp_path / "fit.csv"
    told(path, "--csv", file)
    with file.open() as opened:
        rows = list(csv.DictReader(opened))
    assert len(rows) == COUNT
    assert rows[50]["sway_measured_kn"] == rows[50]["sway_residual_kn"] == ""
    assert rows[50]["flag"] == "0"  # two others were read
    for name, column in series_of(fitted).items():
        if not np.isnan(column).any():
            there = [float(row[name]) for row in rows]
            assert there == pytest.approx(column, rel=1e-3, abs=1e-6), name


def test_a_csv_that_cannot_be_written_is_told(path: Any, tmp_path: Path) -> None:
    result = CliRunner().invoke(identify, [str(path), "--csv", str(tmp_path / "no" / "fit.csv")])
    assert "no" in result.output + str(result.exception)
    assert result.exit_code != 0


def test_terms_of_the_yaw_acceleration_make_the_motion(path: Any) -> None:
    fitted = fitted_as(path, "nomoto1", "output-error")
    states = simulate_deterministic(fitted.problem, fitted.found.theta)[:, :2]
    parts = terms_of(fitted, states)
    assert {key[0] for key in parts} == {"yaw acceleration"}
    T = fitted.values[fitted.problem.plant.model.index("T")]
    # under a held rudder r' fades by exp(-h/T): its integral over an interval is the change of r
    change = T * (1.0 - math.exp(-STEP / T)) * sum(parts.values())
    assert np.diff(states[:, 0]) == pytest.approx(change[:-1], abs=1e-12)


def test_terms_of_model_1_are_its_derivatives_times_the_motion(fitted: Any) -> None:
    states = np.array([[0.3, 0.01, 0.2]] * COUNT)
    parts = terms_of(fitted, states)
    p = dict(zip(fitted.problem.plant.model.names, fitted.values, strict=True))
    L, V = SHIP.length, fitted.problem.plant.ship.speed
    helm = np.radians(fitted.problem.samples.inputs[:, 0])
    by_hand = {
        ("sway force", "Y_v v"): p["Y_v"] * 0.3 / V,
        ("sway force", "Y_r r"): p["Y_r"] * 0.01 * L / V,
        ("sway force", "Y_delta delta"): p["Y_delta"] * helm,
        ("yaw moment", "N_v v"): p["N_v"] * 0.3 / V,
        ("yaw moment", "N_delta delta"): -p["Y_delta"] * p["l_delta"] * helm,
        ("yaw moment", "N_0"): p["N_0"],
    }
    for key, value in by_hand.items():
        assert parts[*key, "-"] == pytest.approx(value * np.ones(COUNT)), key


def test_the_report_tells_how_large_the_terms_are(path: Any) -> None:
    page, report = told(path), json.loads(told(path, "--json"))
    assert "Y_delta delta" in page
    for equation in ("sway force", "yaw moment"):
        shares = [one["share"] for one in report["terms"] if one["equation"] == equation]
        assert sum(shares) == pytest.approx(1.0)
        # a constant's two may differ in the last bit
        assert all(one["rms"] <= one["largest"] * (1.0 + 1e-12) for one in report["terms"])
    assert report["matrices"] == []


def test_matrices_of_the_first_order_ship_are_those_of_the_textbook(path: Any) -> None:
    fitted = fitted_as(path, "nomoto1")
    start, found = matrices_of(fitted)
    assert (start.of, found.of) == ("start values", "estimate")
    p = dict(zip(fitted.problem.plant.model.names, fitted.values, strict=True))
    K, T = p["K"], p["T"]
    assert np.array(found.continuous["A"]) == pytest.approx(np.array([[-1.0 / T, 0.0], [1.0, 0.0]]))
    assert np.array(found.continuous["B"])[0, 0] == pytest.approx(math.radians(K / T))
    fade = math.exp(-STEP / T)
    Phi = [[fade, 0.0], [T * (1.0 - fade), 1.0]]
    assert np.array(found.sampled["Phi"]) == pytest.approx(np.array(Phi))
    whole = np.add(found.sampled["G0"], found.sampled["G"])[0, 0]
    assert whole == pytest.approx(math.radians(K) * (1.0 - fade))
    # at the end the covariance has settled: one more step leaves it, and the gain is its own
    A, C = np.array(found.sampled["Phi"]), np.array(found.sampled["C"])
    P, gain = np.array(found.final["P"]), np.array(found.final["K"])
    R = C @ P @ C.T + found.sampled["R2"]
    assert np.array(found.final["R"]) == pytest.approx(R, rel=1e-6)
    assert gain == pytest.approx(A @ P @ C.T @ np.linalg.inv(R), rel=1e-6)
    assert pytest.approx(A @ P @ A.T + found.sampled["R1"] - gain @ R @ gain.T, rel=1e-6) == P


@pytest.mark.slow
def test_matrices_are_printed_when_asked(path: Any) -> None:
    page = told(path, "--matrices")
    assert "Matrices, start values; states v, r, psi, SI; outputs sway, yaw_rate, heading" in page
    for name in ("continuous:", "sampled:", "Phi", "R12", "lag_s"):
        assert name in page
    assert [line for line in page.splitlines() if len(line) > 80] == []
    (_, found) = json.loads(told(path, "--matrices", "--json"))["matrices"]
    assert np.shape(found["continuous"]["C"]) == (3, 3)
    gain = json.loads(told(path, "--matrices", "--json", "--noise", "innovations"))["matrices"][1]
    assert list(gain["final"]) == ["K"]


def test_a_bode_figure_is_that_of_the_transfer_function(fitted: Any) -> None:
    allowed = draw_allowed(fitted)
    allowed = replace(allowed, draws=fitted.found.theta[None])
    omega = np.geomspace(1e-3, 1.0, 40)
    outputs, gain, phase = allowed.bode(omega)
    assert outputs == ("yaw_rate", "heading", "sway")
    ship = dict(zip(fitted.quantity_names, fitted.quantity_spread.values, strict=True))
    s = 1j * omega
    below = (1.0 + ship["T1"] * s) * (1.0 + ship["T2"] * s)
    lag = np.exp(-s * STEP * abs(math.sin(fitted.values[-1])))
    yaw = -ship["K"] * (1.0 + ship["T3"] * s) / below * lag
    sway = -ship["K_v"] * (1.0 + ship["T3v"] * s) / below * lag * math.radians(1.0) / 0.514444
    for place, answer in ((0, yaw), (1, yaw / s), (2, sway)):
        assert gain.middle[:, place] == pytest.approx(20.0 * np.log10(np.abs(answer)), abs=1e-3)
        turned = np.exp(1j * np.radians(phase.middle[:, place]))
        assert turned == pytest.approx(answer / np.abs(answer), abs=1e-6)
        assert np.abs(np.diff(phase.middle[:, place])).max() < 90.0
    # a stable ship turns with a starboard rudder at once, and lags behind it
    assert -10.0 < phase.middle[0, 0] < 0.0
    assert -100.0 < phase.middle[0, 1] < -85.0


def test_the_band_of_a_bode_figure_is_about_its_middle(fitted: Any) -> None:
    _, gain, _ = draw_allowed(fitted).bode(np.array([0.02, 0.05]))
    assert (gain.low < gain.middle).all()
    assert (gain.middle < gain.high).all()


def test_a_figure_of_decades_labels_ones_twos_and_fives() -> None:
    x = np.geomspace(0.01, 1.0, 30)
    drawn = draw_panel(Panel("gain", "rad/s", "dB", (Curve("a", x, np.log10(x)),), decades=True))
    labels = re.findall(r'<text class="tick middle"[^>]*>([^<]*)</text>', drawn)
    assert labels[:7] == ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5", "1"]
    places = [float(x) for x in re.findall(r'<text class="tick middle" x="([^"]*)"', drawn)[:7]]
    assert places[3] - places[0] == pytest.approx(places[6] - places[3], abs=0.2)


def test_every_figure_is_on_a_screen_of_four_at_most(described: Any) -> None:
    shown = screens(described)
    names = [screen.title for screen in shown]
    assert names == [
        *("Fit 1", "Fit 2", "Record", "Correlations 1", "Correlations 2", "Step", "Pulse"),
        *("Bode 1", "Bode 2", "Terms"),
    ]
    assert all(1 <= len(screen.panels) <= MAX_PANELS for screen in shown)
    titles = [panel.title for screen in shown for panel in screen.panels]
    assert len(set(titles)) == len(titles) == 30


def test_the_page_has_a_link_to_every_screen(path: Any, tmp_path: Path) -> None:
    page = tmp_path / "fit.html"
    told(path, "--html", page)
    text = page.read_text()
    links, targets = re.findall(r'href="#(s\d+)"', text), re.findall(r'<section id="(s\d+)"', text)
    assert links == targets
    assert len(targets) == 12
    assert ">Known least</a>" in text


@pytest.mark.slow
def test_a_pdf_has_a_page_for_each_screen(path: Any, tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    told(path, "--plot", tmp_path / "fit.pdf")
    drawn = (tmp_path / "fit.pdf").read_bytes()
    assert len(re.findall(rb"/Type /Page\b", drawn)) == 10


def test_large_manoeuvres_have_no_terms_of_turns(described: Any) -> None:
    turns = BendEstimate("x", BentShip(-0.05, 20.0, 5.0, 4.0), {}, 0.0)
    assert bent_terms(turns, described.fitted.record) == {}

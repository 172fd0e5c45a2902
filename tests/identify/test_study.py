"""Studies carried out: the commands from record to ship, and what they refuse."""

import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from helpers.studies import columns
from helpers.typed import type_command

from trainer.cli.workshop.identify import identify, prbs
from trainer.config.files import ConfigError
from trainer.config.ship.nomoto import load_nomoto
from trainer.identify.experiment import hold_bits
from trainer.identify.experiment import prbs as sequence
from trainer.identify.judge.uncertainty import beside_bounds, uncertainty
from trainer.identify.judge.validation import draw_outputs
from trainer.identify.model.derived import nomoto_of
from trainer.identify.model.models import MODELS, Ship
from trainer.identify.monte_carlo import KnownShip

pytest.importorskip("scipy")

STEP = 5.0
K, T = -0.05, 20.0
FREE = ("K", "T", "delta_0", "R1_r", "R2_r", "R2_psi", "x1_0", "x2_0")
STUDY = (
    """
schema = "identify/1"
name = "a first-order ship"
data = "trial.csv"

"""
    + columns(t="t s", rudder="helm deg", yaw_rate="rate deg/s", heading="gyro deg")
    + """[ship]
length_m = 120
speed_kn = 12

[model]
kind = "nomoto1"
outputs = ["yaw_rate", "heading"]

[armax]
output = "yaw_rate"
most = 2
"""
)


def trial(folder: Any, seed: Any = 1, outlier: Any = 0.0, sea: Any = 0.0) -> Any:
    """Write a trial of a first-order ship with noisy sensors and its study; return its path."""
    rng = np.random.default_rng(seed)
    helm = np.tile(hold_bits(sequence(5), 5.0, 4), 4)[:400]
    rate, heading = np.zeros(400), np.zeros(400)
    p = math.exp(-STEP / T)
    for i in range(399):
        steady = K * helm[i]
        rate[i + 1] = steady + p * (rate[i] - steady)
        heading[i + 1] = heading[i] + steady * STEP + T * (1.0 - p) * (rate[i] - steady)
        rate[i + 1] += sea * rng.standard_normal()
    rate += 0.01 * rng.standard_normal(400)
    heading += 0.1 * rng.standard_normal(400)
    rate[200] += outlier
    lines = ["t,helm,rate,gyro"]
    lines += [f"{STEP * i},{helm[i]},{rate[i]},{heading[i]}" for i in range(400)]
    (folder / "trial.csv").write_text("\n".join(lines) + "\n")
    (folder / "study.toml").write_text(STUDY)
    return folder / "study.toml"


def run(command: Any, *arguments: Any, code: Any = 0) -> Any:
    """Return what a command prints; it must end with that exit code."""
    return type_command(command, *arguments, code=code).stdout


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the study of a trial without wind and waves."""
    return Path(trial(tmp_path_factory.mktemp("plain")))


def told(report: Any) -> Any:
    return {one["name"]: (one["value"], one["deviation"]) for one in report["ship"]}


@pytest.mark.parametrize(
    ("noise", "sea"), [("covariance", 0.005), ("output-error", 0.0), ("innovations", 0.005)]
)
def test_a_ship_is_found_within_three_deviations_by_every_noise_model(
    tmp_path: Path, noise: Any, sea: Any
) -> None:
    report = json.loads(run(identify, trial(tmp_path, sea=sea), "--noise", noise, "--json"))
    for name, true in (("K", K), ("T1", T)):
        value, deviation = told(report)[name]
        assert abs(value - true) < 3.0 * deviation
        assert deviation < 0.05 * abs(true)
    assert report["converged"]


def test_the_page_tells_parameters_ship_stability_losses_and_residuals(plain: Path) -> None:
    page = run(identify, plain)
    for part in (
        "IDENTIFICATION, model nomoto1",
        "120 m, 12.00 kn; 400 samples every 5 s",
        "The ship is stable: 1/T1",
        "A positive rudder turns to port here, so K of a stable ship is negative.",
        "Fit settled",
        "AIC",
        "one step ahead",
        "Known least",
        "white",
    ):
        assert part in page
    assert max(map(len, page.splitlines())) <= 79


@pytest.mark.long
def test_a_second_order_ship_asked_of_a_first_order_record_is_told(tmp_path: Path) -> None:
    # T2 and T3 cancel, T1 + T2 - T3 stands
    report = json.loads(
        run(identify, trial(tmp_path, sea=0.005), "--model", "3", "--to", "1000", "--json")
    )
    value, deviation = told(report)["T"]
    assert abs(value - T) < 3.0 * deviation


def test_a_disturbance_that_is_not_there_leaves_the_ship_known() -> None:
    curvature = np.array([[4.0, 0.0, 1.0], [0.0, 0.0, 0.0], [1.0, 0.0, 9.0]])
    found = beside_bounds(uncertainty(("K", "R1_r", "T"), curvature))
    # the inverse of [[4, 1], [1, 9]] is [[9, -1], [-1, 4]]/35
    assert found.covariance[0, 0] == pytest.approx(9.0 / 35.0)
    assert found.covariance[0, 2] == pytest.approx(-1.0 / 35.0)
    assert math.isnan(found.covariance[1, 1])
    assert np.isnan(beside_bounds(uncertainty(("K", "T1", "T"), curvature)).covariance).all()


def test_a_lag_at_its_bound_leaves_the_ship_known() -> None:
    # the angle of the lag moves nothing but what the gain does: a flat direction of both
    curvature = np.array([[4.0, 2.0, 1.0], [2.0, 1.0, 0.5], [1.0, 0.5, 9.0]])
    found = beside_bounds(uncertainty(("K", "lag", "T"), curvature))
    assert found.covariance[0, 0] == pytest.approx(9.0 / 35.0)
    assert math.isnan(found.covariance[1, 1])


@pytest.mark.long
def test_an_outlier_is_screened_when_asked(tmp_path: Path) -> None:
    path = trial(tmp_path, outlier=1.0)
    crude = told(json.loads(run(identify, path, "--json")))["T1"]
    path.write_text(STUDY.replace("[model]", "[model]\nreject = 1e-6"))
    report = json.loads(run(identify, path, "--json"))
    assert len(report["screened"]) == 1
    assert abs(told(report)["T1"][0] - T) < 3.0 * told(report)["T1"][1]
    assert told(report)["T1"][1] < crude[1]


def test_one_half_predicts_the_other(tmp_path: Path) -> None:
    # S9: the error on what was not fitted is below 1.5 of that on what was
    path = trial(tmp_path)
    (tmp_path / "other").mkdir()
    trial(tmp_path / "other", seed=2)
    arguments = ("--check", tmp_path / "other" / "trial.csv", "--json")
    check = json.loads(run(identify, path, *arguments))["check"]
    for share, own in zip(check["share"], check["own"], strict=True):
        assert share < 1.5 * own


def test_one_part_of_a_record_predicts_another(tmp_path: Path) -> None:
    path = trial(tmp_path)
    whole = tmp_path / "trial.csv"
    rows = whole.read_text().splitlines()
    later = tmp_path / "later.toml"
    later.write_text(STUDY.replace("[[columns]]", "from_s = 1000\nto_s = 1600\n\n[[columns]]", 1))
    arguments = ("--to", "900", "--json")
    part = json.loads(run(identify, path, *arguments, "--check", later))
    assert part["samples"] == 181
    assert min(part["check"]["explained"]) > 0.9
    # what lies outside from_s to to_s is not looked at: here it is another ship
    spoilt = [",".join([*row.split(",")[:2], "9", "9"]) for row in rows[330:]]
    whole.write_text("\n".join([*rows[:330], *spoilt]) + "\n")
    again = json.loads(run(identify, path, *arguments, "--check", later))
    assert again["check"]["rms"] == pytest.approx(part["check"]["rms"], rel=1e-9)


def test_a_check_begins_as_its_best_reading_says(tmp_path: Path) -> None:
    # the heading drifts as if the ship had begun by turning; the rate gyro knows that she did not
    path, other = trial(tmp_path), tmp_path / "other"
    path.write_text(STUDY + '\n[[parameters]]\nname = "R2_psi"\nstart = 4\nfree = "no"\n')
    other.mkdir()
    trial(other, seed=2)
    rows = (other / "trial.csv").read_text().splitlines()[:41]
    drifted = [row.rsplit(",", 1) for row in rows[1:]]
    drift = [5.0 * (1.0 - math.exp(-i * STEP / T)) for i in range(len(drifted))]
    lines = [f"{a},{float(b) + off}" for (a, b), off in zip(drifted, drift, strict=True)]
    (other / "trial.csv").write_text("\n".join([rows[0], *lines]) + "\n")
    report = json.loads(run(identify, path, "--check", other / "trial.csv", "--json"))
    assert report["check"]["rms"][0] < 0.05  # deg/s; by headings alone it is twice that


def test_a_search_goes_on_from_its_checkpoint(tmp_path: Path) -> None:
    path, kept = trial(tmp_path), tmp_path / "kept.json"
    first, again = (
        json.loads(run(identify, path, "--checkpoint", kept, "--to", "700", "--json"))
        for _ in range(2)
    )
    assert again["steps"] < first["steps"]
    assert told(again)["K"][0] == pytest.approx(told(first)["K"][0], rel=1e-5)


def test_the_ship_found_is_written_to_sail(plain: Path, tmp_path: Path) -> None:
    path = tmp_path / "ship.toml"
    run(identify, plain, "--write-nomoto", path)
    ship = load_nomoto(path)
    assert pytest.approx(K, rel=0.02) == ship.K_per_s
    assert ship.T2_s == 0.0
    assert "[deviations]" in path.read_text()
    with pytest.raises(ConfigError, match="needs model 1"):
        run(identify, plain, "--to", "250", "--write-vessel", tmp_path / "boat.toml")


@pytest.mark.slow
def test_a_plot_is_drawn(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    for more in ((), ("--armax",)):
        plot = tmp_path / f"fit{len(more)}.png"
        run(identify, trial(tmp_path), *more, "--plot", plot)
        assert plot.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.slow
def test_predictions_over_several_steps_have_no_deviations_and_say_why(tmp_path: Path) -> None:
    path = trial(tmp_path)
    path.write_text(STUDY.replace("[armax]", "predict_from = 3\npredict_to = 3\n\n[armax]"))
    report = json.loads(run(identify, path, "--json"))
    assert {one["deviation"] for one in report["parameters"]} == {None}
    assert "no standard deviations" in report["verdicts"][0]


def sway_trial(folder: Path) -> Path:
    """Write the trial of Model 2's ship and its study; return its path."""
    ship, a2 = Ship(160.93, 4.4964), 1.0 / (3.0 * 0.6)
    truth = {"a1": 3.6 * a2, "a2": a2, "c1": 1.0174 * a2 * 0.4265, "c2": 1.0174 * a2}
    truth |= {"R1_1": 1e-4, "R1_2": 1e-6, "R2_v": 0.01}
    rudder = np.resize(hold_bits(sequence(7), 10.0, 10), 600)
    problem = KnownShip("2", ship, ("sway",), 6.0, truth, ("a1",), {}).problem(rudder)
    samples = draw_outputs(problem, problem.start, np.random.default_rng(2))
    rows = np.column_stack([samples.t, rudder, samples.outputs])
    np.savetxt(folder / "trial.csv", rows, delimiter=",", header="t,helm,sway", comments="")
    text = STUDY.split('[[columns]]\nchannel = "yaw_rate', maxsplit=1)[0]
    text += '[[columns]]\nchannel = "sway"\ncolumn = "sway"\nunit = "kn"\n\n[ship]\n'
    text += "length_m = 160.93\nspeed_kn = 8.74\n\n"
    (folder / "study.toml").write_text(text + '[model]\nkind = "2"\noutputs = ["sway"]\n')
    return folder / "study.toml"


@pytest.mark.slow
def test_a_ship_of_sway_alone_is_found_from_its_own_start_with_intervals(tmp_path: Path) -> None:
    report = json.loads(run(identify, sway_trial(tmp_path), "--json"))
    assert report["converged"]
    time = 160.93 / 4.4964
    true = {"T1": 3.0 * time, "T2": 0.6 * time, "K_v": 1.0174 * 4.4964}
    ship = {one["name"]: one for one in report["ship"]}
    for name, value in true.items():
        one = ship[name]
        assert one["low"] < one["value"] < one["high"]
        assert abs(one["value"] - value) < 4.0 * one["deviation"], name


def parameter(name: str, more: str) -> str:
    """Return the table of a parameter."""
    return f'\n[[parameters]]\nname = "{name}"\n{more}\n'


FEW = ("--to", "190")
# what is added to the study, what is typed, and what is told
REFUSED: dict[str, tuple[str, tuple[str, ...], str]] = {
    "what the record cannot separate": (
        parameter("P11", 'free = "yes"\nstart = 1e-6'),
        (),
        "cannot separate x1_0 with P11",
    ),
    "all is fixed": (
        "".join(parameter(name, 'free = "no"') for name in FREE),
        (),
        "nothing is left to estimate",
    ),
    "an unknown parameter": (parameter("theta99", 'free = "yes"'), (), "no parameter 'theta99'"),
    "model 1 without a ship": ("", ("--model", "1"), "model 1 lacks a start for m11"),
    "fewer than five samples a coefficient": (
        "",
        FEW,
        r"trial\.csv: 39 samples for 8 coefficients: needs 5 to each, 40: record",
    ),
    "too few samples for orders": (
        "",
        (*FEW, "--armax", "--most", "5"),
        "39 samples for 20 coefficients: needs 5 to each, 100",
    ),
}


@pytest.mark.parametrize("what", REFUSED)
def test_a_study_that_cannot_be_fitted_is_refused(what: str, tmp_path: Path) -> None:
    more, words, told_why = REFUSED[what]
    path = trial(tmp_path)
    path.write_text(STUDY + more)
    with pytest.raises(ConfigError, match=told_why):
        run(identify, path, *words)


def test_a_fixed_parameter_stays(tmp_path: Path) -> None:
    path = trial(tmp_path)
    path.write_text(STUDY + parameter("T", 'start = 25\nfree = "no"'))
    report = json.loads(run(identify, path, "--json"))
    assert "T" not in {one["name"] for one in report["parameters"]}
    assert told(report)["T1"][0] == 25.0


def test_ship_constants_follow_from_every_models_parameters() -> None:
    # V/L = 0.05 1/s: K = k b2/a2, T1 T2 = 1/(k^2 a2), T1 + T2 = a1/(k a2), T3 = b1/(k b2)
    ship = Ship(120.0, 6.0)
    yaw = MODELS["3"]
    second = nomoto_of(yaw, yaw.vector(a1=3.0, a2=2.0, b1=-1.0, b2=-4.0), ship)
    assert pytest.approx(-0.1) == second.K
    assert (second.T1 * second.T2).real == pytest.approx(200.0)
    assert (second.T1 + second.T2).real == pytest.approx(30.0)
    assert pytest.approx(5.0) == second.T3
    # first order: K = k b1/a1, T = 1/(k a1)
    first = nomoto_of(yaw, yaw.vector(a1=2.0, b1=-1.0), ship)
    assert pytest.approx(-0.025) == first.K
    assert first.first_order == pytest.approx(10.0)
    # K_v = V c2/a2, T3v = c1/(k c2)
    sway = MODELS["2"]
    found = nomoto_of(sway, sway.vector(a1=3.0, a2=2.0, c1=0.5, c2=1.0), ship)
    assert found.K_v == pytest.approx(3.0)
    assert found.T3v == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--write-ship OUT.toml", "--write-ship: with --model linear, .* --write-nomoto writes"),
        ("--predict b.csv", "--predict: with --model linear, mavmm, abkowitz, mmg alone"),
        (
            "--armax --write-nomoto OUT.toml --csv OUT.csv",
            "--csv, --write-nomoto: not with --armax",
        ),
        ("--data-only --html OUT.html", "--html: not with --data-only"),
        ("--model mmg --at 12 --output sway", "--at, --output: not with the models"),
    ],
)
def test_an_option_that_would_do_nothing_is_refused_by_its_name(
    words: str, message: str, tmp_path: Path
) -> None:
    (tmp_path / "b.csv").write_text("t,rudder\n")
    typed_words = [tmp_path / word if "." in word else word for word in words.split()]
    done = type_command(identify, trial(tmp_path), *typed_words, code=2)
    assert re.search(message, done.output)


def test_nothing_to_identify_is_a_usage_error(tmp_path: Path) -> None:
    result = CliRunner().invoke(identify, [])
    assert result.exit_code == 2
    (tmp_path / "x.csv").write_text("t,delta_r,psi,r,v,u\n0,0,0,0,0,1\n1,0.1,0,0,0,1\n")
    with pytest.raises(ConfigError, match=r"^x.csv: lacks \[model\]: say --model"):
        run(identify, tmp_path / "x.csv")


def test_a_record_that_is_not_there_or_has_other_columns_is_named_with_the_next_step(
    tmp_path: Path,
) -> None:
    with pytest.raises(ConfigError, match=r"y.csv: there is no such file$"):
        run(identify, tmp_path / "y.csv", "--model", "1")
    path = tmp_path / "y.csv"
    path.write_text("t,rudder,heading\n0,0,0\n1,1,0\n2,1,0\n")
    with pytest.raises(ConfigError) as raised:
        run(identify, path, "--model", "1")
    assert 'no column "psi" for heading' in str(raised.value)
    assert f"trainer identify new {path} -o study.toml" in raised.value.problems[-1]


@pytest.mark.slow
def test_orders_of_armax_are_tried_and_told(tmp_path: Path) -> None:
    page = run(identify, trial(tmp_path), "--armax")
    for part in ("ARMAX MODELS of yaw_rate", "Order by AIC", "Poles", "order", "feedback"):
        assert part in page
    report = json.loads(run(identify, trial(tmp_path), "--armax", "--most", "3", "--json"))
    assert [row["order"] for row in report["orders"]] == [1, 2, 3]
    pole = report["orders"][0]["poles"][0][0]
    assert pole == pytest.approx(math.exp(-STEP / T), abs=0.02)


def test_armax_of_a_rate_that_was_not_recorded_names_what_was(tmp_path: Path) -> None:
    path = trial(tmp_path)
    lines = STUDY.split("[[columns]]")
    path.write_text("[[columns]]".join(one for one in lines if '"yaw_rate"\ncolumn' not in one))
    with pytest.raises(ConfigError, match="no yaw_rate was recorded: say --output heading"):
        run(identify, path, "--armax")


def test_armax_of_a_heading_gives_the_ship_without_wind(tmp_path: Path) -> None:
    path = trial(tmp_path)
    path.write_text(STUDY.replace('output = "yaw_rate"\nmost', 'output = "heading"\nmost'))
    report = json.loads(run(identify, path, "--armax", "--json"))
    assert report["first_order"][0] == pytest.approx(K, rel=0.1)
    assert report["first_order"][1] == pytest.approx(T, rel=0.2)


def test_an_experiment_is_designed_and_written(tmp_path: Path) -> None:
    path = tmp_path / "trial.toml"
    page = run(prbs, "bb2", "--amplitude", "2", "--bits", "5", "--write", path)
    for part in (
        "RUDDER EXPERIMENT: PRBS",
        "Expected from",
        "N_delta",
        "In a calm the ship swings",
    ):
        assert part in page
    assert 'schema = "exercise/1"' in path.read_text()
    report = json.loads(run(prbs, "bb2", "--zigzag", "10/10", "--seconds", "300", "--json"))
    assert report["kind"] == "zig-zag"
    assert report["reach_s"] > 5.0
    assert report["prospect"]["deviations"]["K"] > 0.0


def test_a_zigzag_without_angles_is_a_usage_error() -> None:
    result = CliRunner().invoke(prbs, ["bb2", "--zigzag", "ten"])
    assert result.exit_code == 2
    assert "such as 10/10" in result.output

"""Studies written from records, and the record that ships as an example."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import example_record
from helpers.places import ROOT
from helpers.studies import answered

from trainer.config.files import ConfigError
from trainer.identify.experiment import hold_bits, prbs
from trainer.identify.record.proposal import write_proposal
from trainer.identify.record.sources import USUAL_SENSORS, column_said
from trainer.identify.record.study import load_study, observe_record
from trainer.units import KNOT

EXAMPLE = ROOT / "configs" / "records" / "example.csv"


def motion() -> tuple[Any, Any, Any, Any]:
    """Return times [s], rudder [deg], yaw rate [deg/s] and heading [deg] of a ship."""
    helm = np.resize(hold_bits(prbs(6), 10.0, 8), 300)
    rate = np.zeros(300)
    for i in range(299):
        rate[i + 1] = 0.9 * rate[i] - 0.005 * helm[i]
    heading = 80.0 + np.cumsum(2.0 * rate)
    return 2.0 * np.arange(300), helm, rate, heading


def write(path: Path, columns: dict[str, Any]) -> Path:
    """Write columns as CSV; return the path."""
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(str(float(x)) for x in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


DEGREE = np.pi / 180.0
T, HELM, RATE, HEADING = motion()
SWAY = -45.0 * DEGREE * RATE
FILES = {
    "words": (
        {"Time": T, "Rudder angle": HELM, "ROT": 60.0 * RATE, "Gyro": HEADING},
        {"t": "s", "rudder": "deg", "heading": "deg", "yaw_rate": "deg/min"},
    ),
    "the trainer's own": (
        {"t": T, "delta_r": DEGREE * HELM, "psi": DEGREE * HEADING, "r": DEGREE * RATE, "v": SWAY},
        {"t": "s", "rudder": "rad", "heading": "rad", "yaw_rate": "rad/s", "sway": "m/s"},
    ),
    "endings": (
        {
            "time_min": T / 60.0,
            "helm_rad": DEGREE * HELM,
            "yaw_rate_deg_s": RATE,
            "v_kn": SWAY / KNOT,
            "rudder_order": HELM,
        },
        {"t": "min", "rudder": "rad", "yaw_rate": "deg/s", "sway": "kn"},
    ),
    "brackets": (
        {"t [s]": T, "rudder [deg]": HELM, "heading (°)": HEADING, "stw [kts]": SWAY + 12.0},
        {"t": "s", "rudder": "deg", "heading": "deg", "speed": "kn"},
    ),
    "a track": (
        {"t": T, "rudder": HELM, "hdg": HEADING, "lat": 54 + T / 1e4, "long": 8 + 0 * T},
        {"t": "s", "rudder": "deg", "heading": "deg", "latitude": "deg", "longitude": "deg"},
    ),
    "a track as instruments send it": (
        {"t": T, "rudder": HELM, "hdg": HEADING, "lat": 5400 + T / 1e3, "lon": -830 + 0 * T},
        {"t": "s", "rudder": "deg", "heading": "deg", "latitude": "ddmm", "longitude": "ddmm"},
    ),
}


@pytest.mark.parametrize("kind", FILES)
def test_columns_are_told_by_their_names_and_units(tmp_path: Path, kind: str) -> None:
    columns, units = FILES[kind]
    found = write_proposal(write(tmp_path / "a.csv", columns), tmp_path / "a.toml", 100.0, 12.0)
    assert {channel: one.unit for channel, one in found.columns.items()} == units
    record = observe_record(load_study(tmp_path / "a.toml"))
    assert record.t == pytest.approx(T)
    assert record.rudder == pytest.approx(DEGREE * HELM)


def test_the_sign_of_the_rudder_is_told_by_how_the_ship_turns(tmp_path: Path) -> None:
    columns = {"t": T, "rudder": -HELM, "heading": HEADING, "yaw rate [deg/s]": RATE}
    found = write_proposal(write(tmp_path / "a.csv", columns), tmp_path / "a.toml", 100.0, 12.0)
    assert found.remarks == ("a.csv: read with units of the heading",)
    study = load_study(tmp_path / "a.toml")
    assert study.heading.positive_rudder == "starboard"
    assert observe_record(study).rudder == pytest.approx(DEGREE * HELM)


def test_a_contradiction_of_channels_has_a_study_only_anyway(tmp_path: Path) -> None:
    columns = {"t": T, "rudder": HELM, "heading": HEADING, "yaw rate [deg/s]": -RATE}
    path, study = write(tmp_path / "a.csv", columns), tmp_path / "a.toml"
    with pytest.raises(ConfigError, match="say --column yaw_rate='yaw rate':deg/s") as wrong:
        write_proposal(path, study, None, None)
    assert "goes against the heading" in str(wrong.value)
    assert not study.exists()
    remarks = write_proposal(path, study, 70.0, None, anyway=True).remarks
    assert any("taken as it is: the yaw rate goes against" in one for one in remarks)
    assert 'anyway = "yes"' in study.read_text()
    told = observe_record(load_study(study)).findings
    assert any("taken as it is: the yaw rate goes against" in str(one) for one in told)
    study.write_text(study.read_text().replace('anyway = "yes"', ""))
    with pytest.raises(ConfigError, match="say scale = -1 in its"):
        observe_record(load_study(study))


def test_a_rudder_that_is_missing_somewhere_is_said(tmp_path: Path) -> None:
    helm = HELM.astype(float)
    helm[7] = np.nan
    path = write(tmp_path / "a.csv", {"t": T, "rudder": helm, "heading": HEADING})
    (told,) = write_proposal(path, tmp_path / "a.toml", None, None).remarks
    assert "row 10: rudder: has no reading for 4 s, one each 2 s else: taken straight" in told


def test_a_record_without_a_rudder_has_no_study(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"t": T, "heading": HEADING})
    with pytest.raises(
        ConfigError,
        match="the rudder; it has t, heading: say which it is: --column rudder=t",
    ):
        write_proposal(path, tmp_path / "a.toml", None, None)
    assert not (tmp_path / "a.toml").exists()


def test_times_are_told_by_their_unit_where_no_name_says_so(tmp_path: Path) -> None:
    columns = {"Zeit [s]": T, "rudder [deg]": HELM, "heading [deg]": HEADING}
    path = write(tmp_path / "a.csv", columns)
    found = write_proposal(path, tmp_path / "a.toml", 100.0, 12.0)
    assert found.interval == 2.0
    assert found.columns["t"].name == "Zeit"


def test_a_record_without_times_says_that_its_interval_is_guessed(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"rudder": HELM, "heading": HEADING})
    assert (
        "300 rows every 1 s (guessed: there is no column of times)" in answered("new", path).output
    )


def test_a_refused_fit_names_the_record_once_in_each_line(tmp_path: Path) -> None:
    columns = {"t [s]": T[::10], "rudder [deg]": HELM[::10], "heading [deg]": HEADING[::10]}
    answered("new", write(tmp_path / "a.csv", columns), "--length", 100, "--at", 10)
    with pytest.raises(ConfigError, match="30 samples for") as wrong:
        answered(tmp_path / "a.toml", code=2)
    assert [line.count("a.csv") for line in wrong.value.problems] == [1, 1, 1]


def test_a_record_without_an_answer_to_the_rudder_has_no_study(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"t": T, "rudder": HELM, "Kurs": HEADING})
    with pytest.raises(
        ConfigError, match=r"no column looks like heading, .*; it has .*Kurs.*say .* heading=t, for"
    ):
        write_proposal(path, tmp_path / "a.toml", None, None)
    assert not (tmp_path / "a.toml").exists()


def test_a_study_is_written_beside_its_record_and_never_over_another(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", {"t": T, "rudder": HELM, "heading": HEADING})
    printed = answered("new", path).stdout
    assert f"{tmp_path / 'a.toml'}: 300 rows every 2 s: t in t, rudder in rudder" in printed
    assert "fill in the length of [ship]; fit it by: trainer identify" in printed
    with pytest.raises(ConfigError, match="lacks length_m"):
        answered(tmp_path / "a.toml")
    with pytest.raises(ConfigError, match="is there already"):
        answered("new", path)
    (tmp_path / "b").mkdir()
    answered("new", path, "-o", tmp_path / "b" / "study.toml", "--length", 100, "--at", 12)
    assert load_study(tmp_path / "b" / "study.toml").data.resolve() == path


def test_a_folder_in_place_of_a_record_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"\.: cannot be read: Is a directory"):
        answered("new", Path())
    pytest.importorskip("scipy")
    assert ". is a folder; name a study" in answered(Path(), code=2).stderr


def test_a_study_is_fitted_as_it_was_written(tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    rng = np.random.default_rng(1)
    noisy = {"rot [deg/s]": RATE + 0.02 * rng.standard_normal(300)}
    path = write(tmp_path / "a.csv", {"t": T, "helm": -HELM} | noisy)
    answered("new", path, "--length", 100, "--at", 12)
    report = json.loads(answered(tmp_path / "a.toml", "--json").stdout)
    found = {one["name"]: one["value"] for one in report["ship"]}
    assert found["K"] == pytest.approx(-0.05, rel=0.05)


@pytest.mark.long
def test_the_example_ships_and_is_fitted_where_it_is_copied_to(tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    report = json.loads(answered("--example", "--json").stdout)
    assert report["converged"]
    ship = {one["name"]: one for one in report["ship"]}
    # the true ones of BB2 at no helm; at this helm it turns a little less (docs)
    assert ship["K"]["value"] == pytest.approx(-0.284, rel=0.12)
    assert ship["T1"]["value"] == pytest.approx(39.9, rel=0.15)
    folder = tmp_path / "lesson"
    copied = answered("--example", folder, "--model", "nomoto1", "--json")
    assert f"{folder / 'example.csv'} written" in copied.stderr
    assert json.loads(copied.stdout)["model"] == "nomoto1"
    with pytest.raises(ConfigError, match="is there already"):
        answered("--example", folder)


def test_the_example_takes_no_file_beside_it(tmp_path: Path) -> None:
    result = answered("--example", "--", tmp_path / "a.csv", code=2)
    assert "give no FILE" in result.stderr


@pytest.mark.slow
def test_the_example_is_what_the_trainer_flies(tmp_path: Path) -> None:
    flown = list(example_record.rows(tmp_path))
    shipped = EXAMPLE.read_text().splitlines()
    assert flown[:2] == shipped[:2]
    numbers = [np.array([row.split(",") for row in one[2:]], float) for one in (flown, shipped)]
    assert numbers[0] == pytest.approx(numbers[1], abs=0.02)
    answered("new", tmp_path / "trial.trainer", "-o", tmp_path / "own.toml", "--length", 70.2)
    study = load_study(tmp_path / "own.toml")
    assert study.sensors == USUAL_SENSORS
    assert len(observe_record(study).t) > 1000


FOREIGN = {"Zeit [s]": T, "Ruder [deg]": HELM, "Kurs [deg]": HEADING}


def test_a_column_is_what_its_user_says(tmp_path: Path) -> None:
    path = write(tmp_path / "a.csv", FOREIGN)
    said = {"rudder": "Ruder", "heading": "Kurs"}
    told = {channel: column_said(text) for channel, text in said.items()}
    found = write_proposal(path, tmp_path / "a.toml", 100.0, 12.0, told)
    assert {channel: one.name for channel, one in found.columns.items()} == {**said, "t": "Zeit"}
    assert observe_record(load_study(tmp_path / "a.toml")).rudder == pytest.approx(DEGREE * HELM)


@pytest.mark.parametrize(
    ("told", "says"),
    [
        ({"ruder": "Ruder"}, "--column ruder=Ruder: no channel ruder; nearest is rudder"),
        ({"rudder": "Ruda"}, "--column rudder=Ruda: no column Ruda; nearest is Ruder"),
    ],
)
def test_a_column_that_is_none_is_refused(tmp_path: Path, told: dict[str, str], says: str) -> None:
    path = write(tmp_path / "a.csv", FOREIGN)
    said = {channel: column_said(text) for channel, text in told.items()}
    with pytest.raises(ConfigError, match=says):
        write_proposal(path, tmp_path / "a.toml", 100.0, 12.0, said)
    assert not (tmp_path / "a.toml").exists()

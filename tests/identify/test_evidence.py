"""Units and signs that a record contradicts: found, named with their cure, not found falsely."""

import math
import re
import warnings
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from helpers import boat_trials
from helpers.bb2_trials import estimated_bb2, four_trials
from helpers.boat_trials import estimated_boat, made_trial, swing_controls, write_csv

from trainer.cli.main import cli
from trainer.config.files import ConfigError
from trainer.identify.boat import fit, search
from trainer.identify.boat.filter import CHANNEL_NAMES
from trainer.identify.boat.instruments import instruments_of
from trainer.identify.boat.prior import Knowledge, Prior, read_prior
from trainer.identify.boat.regressors import PARAMETER_NAMES
from trainer.identify.boat.trial import (
    INPUT_FIELDS,
    Trial,
    find_wrong_units,
    read_trial,
    trial_problems,
)
from trainer.identify.fitting.minimise import SearchOptions
from trainer.identify.record.evidence import TURNED_SIGN, Change, Ratio, explain
from trainer.identify.record.sources import Column
from trainer.units import DEGREE

RATE = CHANNEL_NAMES.index("r")
TURNED = {  # what is turned in a file, and the option that turns it back
    "rudder [deg]": "rudder=rudder:deg*-1",
    "stern planes [deg]": "stern='stern planes':deg*-1",
    "pitch [deg]": "pitch=pitch:deg*-1",
    "depth [m]": "depth=depth:m*-1",
    "heading [deg]": "heading=heading:deg*-1",
}


@pytest.fixture(scope="module")
def prior(tmp_path_factory: pytest.TempPathFactory) -> Prior:
    return read_prior(str(estimated_boat(tmp_path_factory.mktemp("boat"))))


@pytest.fixture(scope="module")
def file(prior: Prior, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a stranger's file of a clean trial."""
    made = made_trial(prior.vessel, prior.values)
    path = tmp_path_factory.mktemp("trial") / "trial.csv"
    write_csv(path, made, prior.vessel.file.propulsion.rps_per_mps)
    return path


def scaled(file: Path, folder: Path, head: str, factor: float) -> Path:
    """Return a copy of a file, a column times a factor."""
    lines = [line.split(",") for line in file.read_text(encoding="utf-8").splitlines()]
    at = lines[0].index(head)
    for row in lines[1:]:
        row[at] = f"{factor * float(row[at]):.7f}"
    path = folder / "scaled.csv"
    path.write_text("\n".join(map(",".join, lines)) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("head", TURNED)
def test_the_option_that_a_wrong_sign_names_reads_the_record_right(
    prior: Prior, file: Path, tmp_path: Path, head: str
) -> None:
    plain, path = read_trial(file, prior.vessel), scaled(file, tmp_path, head, -1.0)
    with pytest.raises(ConfigError) as wrong:
        read_trial(path, prior.vessel)
    assert f"--columns {TURNED[head]}" in str(wrong.value)
    assert "--anyway" in str(wrong.value)
    named = {"rudder", "heading"} if head.partition(" ")[0] in ("rudder", "heading") else set()
    options = {one.split("=")[0] for one in str(wrong.value).split("--columns ")[1:]}
    assert options == named or options == {TURNED[head].split("=")[0]}
    said = instruments_of([TURNED[head].replace("'", "")], [])
    read = read_trial(path, prior.vessel, said)
    assert read.readings == pytest.approx(plain.readings, abs=1e-4, nan_ok=True)
    assert read.inputs == pytest.approx(plain.inputs, abs=1e-9)


def test_a_rudder_of_radians_called_degrees_is_refused_and_read_as_radians(
    prior: Prior, file: Path, tmp_path: Path
) -> None:
    plain, path = read_trial(file, prior.vessel), scaled(file, tmp_path, "rudder [deg]", DEGREE)
    with pytest.raises(ConfigError, match="--columns rudder=rudder:rad; --anyway"):
        read_trial(path, prior.vessel)
    read = read_trial(path, prior.vessel, instruments_of(["rudder=rudder:rad"], []))
    assert read.inputs == pytest.approx(plain.inputs, abs=1e-6)
    told = read_trial(path, prior.vessel, instruments_of([], [], anyway=True)).told
    assert any("taken as it is: she turns by her rudder 88" in one for one in told)


def test_a_rudder_at_rest_is_not_taken_for_radians(
    prior: Prior, monkeypatch: pytest.MonkeyPatch
) -> None:
    def rest(*numbers: Any) -> np.ndarray:
        return np.asarray(swing_controls(*numbers) * (np.arange(4) != INPUT_FIELDS.index("rudder")))

    monkeypatch.setattr(boat_trials, "swing_controls", rest)
    columns = {"rudder": Column("rudder", "deg")}
    for seed in range(20):
        made = made_trial(prior.vessel, prior.draw(seed), seed=seed)
        inputs = made.inputs.copy()
        inputs[:, 0] = 0.01 * DEGREE * np.random.default_rng(seed).standard_normal(len(inputs))
        read = replace(made, inputs=inputs)
        if not [*trial_problems(read, prior.vessel)]:
            assert find_wrong_units(read, prior.vessel, columns) == ("", False)


@pytest.mark.long
@pytest.mark.parametrize(
    ("head", "factor", "option"),
    [
        ("roll [deg]", -1.0, "roll=roll:deg*-1"),
        ("bow planes [deg]", -1.0, "bow='bow planes':deg*-1"),
        ("bow planes [deg]", DEGREE, "bow='bow planes':rad"),
    ],
)
def test_a_fit_tells_what_no_channel_does(
    prior: Prior, file: Path, tmp_path: Path, head: str, factor: float, option: str
) -> None:
    path = scaled(file, tmp_path, head, factor)
    found = search.fit_trials(prior, [read_trial(path, prior.vessel)])
    found = replace(found, turned=search.find_turned(found))
    with pytest.raises(ConfigError, match=re.escape(f"scaled.csv: say --columns {option}: ")):
        fit.check_controls(found)
    read = read_trial(path, prior.vessel, instruments_of([option.replace("'", "")], []))
    plain = read_trial(file, prior.vessel)
    assert read.inputs == pytest.approx(plain.inputs, abs=1e-6)
    assert read.readings == pytest.approx(plain.readings, abs=1e-6, nan_ok=True)


@pytest.mark.long
def test_a_fit_turns_nothing_of_a_record_that_is_right(prior: Prior, file: Path) -> None:
    found = search.fit_trials(prior, [read_trial(file, prior.vessel)])
    assert search.find_turned(found) == ""


def test_anyway_reads_a_wrong_sign_and_says_so(prior: Prior, file: Path, tmp_path: Path) -> None:
    path = scaled(file, tmp_path, "rudder [deg]", -1.0)
    read = read_trial(path, prior.vessel, instruments_of([], [], anyway=True))
    assert any("taken as it is: positive rudder turns her to starboard" in one for one in read.told)


def test_a_heading_from_east_is_read_by_the_option_that_is_named(
    prior: Prior, file: Path, tmp_path: Path
) -> None:
    lines = [line.split(",") for line in file.read_text(encoding="utf-8").splitlines()]
    at = lines[0].index("heading [deg]")
    for row in lines[1:]:
        row[at] = f"{(90.0 - float(row[at])) % 360.0:.5f}"
    path = tmp_path / "east.csv"
    path.write_text("\n".join(map(",".join, lines)) + "\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"heading:deg\*-1 \(\*-1\+90 of one from east\)"):
        read_trial(path, prior.vessel)
    read = read_trial(path, prior.vessel, instruments_of(["heading=heading:deg*-1+90"], []))
    plain, at = read_trial(file, prior.vessel), CHANNEL_NAMES.index("heading")
    turns = (read.readings[:, at] - plain.readings[:, at]) / (2.0 * np.pi)
    assert turns == pytest.approx(np.round(turns), abs=1e-6)


def with_rate(trial: Trial) -> Trial:
    """Return a trial with the yaw rate of its heading."""
    readings, at = trial.readings.copy(), CHANNEL_NAMES.index("heading")
    readings[:, RATE] = np.gradient(readings[:, at], trial.interval)
    return replace(trial, readings=readings)


@pytest.mark.parametrize("channel", ["heading", "r", "rudder"])
def test_beside_a_yaw_rate_the_one_channel_is_named(prior: Prior, channel: str) -> None:
    trial = with_rate(made_trial(prior.vessel, prior.values))
    assert find_wrong_units(trial, prior.vessel, {}) == ("", False)
    readings, inputs = trial.readings.copy(), trial.inputs.copy()
    if channel in INPUT_FIELDS:
        inputs[:, INPUT_FIELDS.index(channel)] *= -1.0
    else:
        readings[:, CHANNEL_NAMES.index(channel)] *= -1.0
    wrong = replace(trial, readings=readings, inputs=inputs)
    told, refused = find_wrong_units(wrong, prior.vessel, {})
    assert refused
    assert told.endswith(f": turn the sign of {'yaw_rate' if channel == 'r' else channel}")


def signed(found: float, *channels: str) -> Ratio:
    """Return a ratio of signs alone."""
    return Ratio("sign", found, (0.0, math.inf), "", "a fault", {}, channels)


def sized(found: float, **powers: float) -> Ratio:
    """Return a ratio of sizes alone, which must be about 1."""
    return Ratio("size", found, (0.8, 1.25), "a fault of {}", "", powers)


def test_the_fewest_changes_explain_all_ratios() -> None:
    def turned(*ratios: Ratio) -> list[tuple[str, ...]]:
        return [tuple(one.channel for one in way) for way in explain(ratios, {})]

    turning = partial(signed, -9.0, "rudder", "heading")
    assert turned(turning()) == [("rudder",), ("heading",)]
    assert turned(turning(), signed(-0.99, "yaw_rate", "heading")) == [("heading",)]
    assert turned(turning(), signed(0.99, "yaw_rate", "heading")) == [("rudder",)]
    assert turned(turning(), signed(9.0, "rudder", "heading")) == []


def test_a_unit_is_named_where_it_alone_mends_all_sizes() -> None:
    units = {"speed": "m/s", "depth": "m", "pitch": "deg", "t": "s"}
    assert explain([sized(1.9438, speed=1)], units)[0] == (Change("speed", "kn"),)
    assert explain([sized(3.28, depth=1), sized(1.0, speed=-1)], units) == [
        (Change("depth", "ft"),)
    ]
    feet_of_mirrored = [sized(3.28, depth=1), signed(-1.0, "heading")]
    assert explain(feet_of_mirrored, units) == [
        (Change("heading", TURNED_SIGN), Change("depth", "ft"))
    ]


def test_a_control_coefficient_of_the_other_sign_is_refused(prior: Prior) -> None:
    made = made_trial(prior.vessel, prior.values, count=120)
    found = search.fit_trials(prior, [made], SearchOptions(1))
    fit.check_controls(found)
    values = found.posterior.values.copy()
    values[PARAMETER_NAMES.index("N_dr")] *= -1.0
    other = replace(found, posterior=Knowledge(values, found.posterior.root))
    with pytest.raises(ConfigError, match=r"N_dr \+.*other sign than every boat has"):
        fit.check_controls(other)


@pytest.mark.slow
def test_at_most_one_clean_record_in_a_hundred_is_refused(prior: Prior, tmp_path: Path) -> None:
    bb2 = read_prior(str(estimated_bb2(tmp_path)))
    made = [(prior, made_trial(prior.vessel, prior.draw(i), seed=i)) for i in range(100)]
    for i in range(25):
        boat = bb2.vessel.numbers(bb2.draw(i))
        made += [(bb2, trial) for trial in four_trials(boat, i, 600)]
    sailed = [one for one in made if not [*trial_problems(one[1], one[0].vessel)]]
    assert len(sailed) > 150
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        false = [one.source for boat, one in sailed if find_wrong_units(one, boat.vessel, {})[1]]
    assert len(false) <= len(sailed) // 100, false


def test_a_surface_without_a_column_is_asked_for_until_somebody_says_that_it_stood(
    prior: Prior, file: Path, tmp_path: Path
) -> None:
    lines = [line.split(",") for line in file.read_text(encoding="utf-8").splitlines()]
    at = lines[0].index("bow planes [deg]")
    path = tmp_path / "log.csv"
    rows = [",".join(row[:at] + row[at + 1 :]) for row in lines]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="has bow planes, the record has none: --still bow"):
        read_trial(path, prior.vessel)
    still = instruments_of([], [], anyway=True, still=["bow"])
    assert not read_trial(path, prior.vessel, still).inputs[:, INPUT_FIELDS.index("bow")].any()
    words = ["boat", "fit", str(path), "--prior", str(tmp_path / "none.toml"), "--still", "keel"]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 2
    assert "'bow'" in done.output

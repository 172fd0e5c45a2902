"""The command trainer boat fit, and trainer.fit_boat: files in, a boat out."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from helpers.boat_trials import estimated_boat, made_trial, swing_controls, write_csv

import trainer
from trainer.cli.main import cli
from trainer.config.boat.vessel import load_vessel
from trainer.identify.boat.filter import CHANNEL_NAMES
from trainer.identify.boat.prior import read_prior
from trainer.identify.boat.trial import Trial

TRUE_DRAW = 0  # the estimate itself, which gains hold


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with an estimated boat and two records of another of its kind."""
    where = tmp_path_factory.mktemp("trials")
    prior = read_prior(str(estimated_boat(where)))
    turns = prior.vessel.file.propulsion.rps_per_mps
    for name, seed in (("one", 1), ("two", 2)):
        trial = made_trial(prior.vessel, prior.draw(TRUE_DRAW), count=200, seed=seed)
        write_csv(where / f"{name}.csv", trial, turns)
    return where


@pytest.fixture(scope="module")
def unflown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with an estimated boat and a record that no boat has sailed."""
    where = tmp_path_factory.mktemp("unflown")
    prior = read_prior(str(estimated_boat(where)))
    count, speed = 60, prior.vessel.speed
    readings = np.full((count, len(CHANNEL_NAMES)), np.nan)
    for channel, value in {"speed": speed, "heading": 0.1, "pitch": 0.0, "depth": 90.0}.items():
        readings[:, CHANNEL_NAMES.index(channel)] = value
    controls = swing_controls(count, speed, prior.vessel.pace)
    trial = Trial("one.csv", "", 1.0, 1, readings, controls, (), ())
    write_csv(where / "one.csv", trial, prior.vessel.file.propulsion.rps_per_mps)
    return where


def typed(*words: object) -> Result:
    return CliRunner().invoke(cli, ["boat", "fit", *map(str, words)])


@pytest.mark.long
def test_a_fit_writes_a_boat_that_is_checked_and_sails(folder: Path) -> None:
    own, fitted = folder / "own.toml", folder / "fitted.toml"
    done = typed(
        folder / "one.csv",
        "--prior",
        own,
        "-o",
        fitted,
        "--hold-out",
        folder / "two.csv",
        "--draws",
        5,
        "--html",
        folder / "fit.html",
    )
    assert done.exit_code == 0, done.output
    assert "Foretold: two.csv" in (folder / "fit.html").read_text(encoding="utf-8")
    assert "HELD OUT" in done.output
    assert "next: trainer boat check" in done.output
    file = load_vessel(str(fitted))
    assert file.autopilot is not None
    for words in (["boat", "check", str(fitted)], ["boat", "manoeuvre", "zigzag-20", str(fitted)]):
        flown = CliRunner().invoke(cli, words)
        assert flown.exit_code == 0, flown.output
    again = typed(folder / "two.csv", "--prior", fitted, "--draws", 0, "--json")
    assert again.exit_code == 0, again.output
    report = json.loads(again.stdout)
    assert report["prior"] == "fitted.toml"
    assert len(report["coefficients"]) == 126


@pytest.mark.long
def test_a_fit_in_python_is_the_commands(folder: Path) -> None:
    answer = trainer.fit_boat(folder / "one.csv", prior=folder / "own.toml", draws=5)
    figure = answer.figures["turn at 15 deg: diameter"]
    assert figure.unit == "m"
    assert figure.low is not None
    assert figure.high is not None
    assert figure.low < (figure.value or 0.0) < figure.high
    assert answer.report.settled
    assert str(answer).startswith("FIT: ")


def test_an_output_is_never_an_input(unflown: Path) -> None:
    own, before = unflown / "own.toml", (unflown / "own.toml").read_bytes()
    done = typed(unflown / "one.csv", "--prior", own, "-o", own)
    assert done.exit_code == 2
    assert own.read_bytes() == before


def test_a_wrong_record_is_refused_before_anything_is_written(unflown: Path) -> None:
    bad, fitted = unflown / "bad.csv", unflown / "none.toml"
    bad.write_text("time [s],rudder [deg]\n0,1\n1,2\n", encoding="utf-8")
    done = typed(bad, "--prior", unflown / "own.toml", "-o", fitted)
    assert done.exit_code != 0
    assert "no column is taken for stern" in str(done.exception or done.output)
    assert not fitted.exists()


def test_a_boat_without_deviations_is_refused(unflown: Path) -> None:
    done = typed(unflown / "one.csv", "--prior", "bb2")
    assert done.exit_code != 0
    assert "has no deviations" in str(done.exception or done.output)


def test_python_says_what_the_command_says() -> None:
    with pytest.raises(trainer.TrainerError, match="draws"):
        trainer.fit_boat("a.csv", prior="bb2", draw=3)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--bias", "pich=1"), "nearest is pitch"),
        (("--columns", "depth=Keel:m"), "Keel"),
        (("--columns", "dept=depth"), "nearest is depth"),
        (("--late", "soon"), "is not a valid float"),
    ],
)
def test_a_wrong_word_on_instruments_is_one_line(
    unflown: Path, words: tuple[str, ...], told: str
) -> None:
    fitted = unflown / "never.toml"
    done = typed(unflown / "one.csv", "--prior", unflown / "own.toml", "-o", fitted, *words)
    assert done.exit_code != 0
    assert told in str(done.exception if done.exit_code == 1 else done.output)
    assert not fitted.exists()


def test_a_fit_that_did_not_settle_writes_a_boat_only_anyway(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("trainer.identify.boat.fit.MOST_STEPS", 2)
    fitted = folder / "unsettled.toml"
    words = (folder / "one.csv", "--prior", folder / "own.toml", "-o", fitted, "--draws", 0)
    done = typed(*words)
    assert done.exit_code == 1, done.output
    assert f"{fitted} is not written: not settled in 2 steps" in done.output
    assert "next: trainer boat check" not in done.output
    assert not fitted.exists()
    done = typed(*words, "--anyway")
    assert done.exit_code == 0, done.output
    assert "NOT settled" in done.output
    assert load_vessel(str(fitted)).name

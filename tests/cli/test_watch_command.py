"""The command trainer boat watch, and watch_boat in Python: what has changed, what is refused."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from helpers.boat_trials import estimated_boat, made_trial, write_csv

from trainer.api.calls import watch_boat
from trainer.cli.main import cli
from trainer.identify.boat.prior import read_prior
from trainer.identify.boat.regressors import PARAMETER_NAMES


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with an estimated boat, and records of it as it is and with a weak rudder."""
    where = tmp_path_factory.mktemp("watched")
    prior = read_prior(str(estimated_boat(where)))
    weak = prior.values.copy()
    for name in ("Y_dr", "K_dr", "N_dr"):
        weak[PARAMETER_NAMES.index(name)] *= 0.6
    for name, values, seed in (
        ("one", prior.values, 1),
        ("same", prior.values, 2),
        ("weak", weak, 3),
    ):
        trial = made_trial(prior.vessel, values, count=200, seed=seed)
        write_csv(where / f"{name}.csv", trial, prior.vessel.file.propulsion.rps_per_mps)
    return where


@pytest.fixture(scope="module")
def fitted(folder: Path) -> Path:
    """Return the file of the boat fitted to one record."""
    path = folder / "fitted.toml"
    words = ["fit", folder / "one.csv", "--prior", folder / "own.toml", "-o", path, "--draws", 0]
    done = CliRunner().invoke(cli, ["boat", *map(str, words)])
    assert done.exit_code == 0, done.output
    return path


def typed(*words: object) -> Result:
    return CliRunner().invoke(cli, ["boat", "watch", *map(str, words)])


@pytest.mark.long
def test_a_weak_rudder_is_told_on_the_page_as_json_and_in_python(
    folder: Path, fitted: Path
) -> None:
    same, weak, page = folder / "same.csv", folder / "weak.csv", folder / "watch.html"
    report = json.loads(typed(fitted, same, "--json").stdout)
    assert report["change"] is None
    assert len(report["parts"]) == len(report["deviations"])
    done = typed(fitted, weak, "--html", page)
    assert done.exit_code == 0, done.output
    assert "CHANGED: from about 0:00:00 of weak.csv" in done.output
    assert "lift of the rudder: -" in done.output
    text = page.read_text(encoding="utf-8")
    assert "lift of the rudder" in text
    assert "standard deviations" in text
    answer = watch_boat(fitted, [same, weak])
    assert answer.report.change is not None
    figure = answer.figures["lift of the rudder"]
    assert figure.value == pytest.approx(-0.4, abs=0.15)
    assert answer.report.change.told.source.endswith("weak.csv")
    assert answer.columns["t"][-1] == 2 * report["t"][-1]
    assert np.max(answer.columns["lift of the rudder"]) == figure.deviations
    assert str(answer).startswith("WATCH: ")


@pytest.mark.long
def test_a_damaged_fit_is_refused(folder: Path, fitted: Path) -> None:
    damaged = folder / "damaged.toml"
    text = fitted.read_text(encoding="utf-8")
    damaged.write_text(text.replace("disturbance = [", "disturbance = [-1.0, ", 1))
    done = typed(damaged, folder / "same.csv")
    assert "damaged.toml: fit: disturbance must be 6 numbers" in str(done.exception or done.output)


def test_a_boat_that_was_not_fitted_is_refused_with_what_to_do(folder: Path) -> None:
    done = typed(folder / "own.toml", folder / "one.csv")
    assert done.exit_code != 0
    told = str(done.exception or done.output)
    assert "own.toml: has no [fit]" in told
    assert "trainer boat fit RECORD..." in told


@pytest.mark.long
def test_options_of_records_and_of_sessions_are_not_mixed(folder: Path, fitted: Path) -> None:
    done = typed(fitted, folder / "same.csv", "--token", "WORD")
    assert "--token: is of a session, and records are given" in str(done.exception or done.output)
    done = typed(fitted, "--late", 2.0)
    assert "--late: is of records, and none is given" in str(done.exception or done.output)
    done = typed(fitted, "--connect", folder / "none")
    assert done.exit_code != 0
    told = str(done.exception or done.output)
    assert "no session listens there" in told
    assert "or name records to watch" in told


def test_wrong_words_and_files_are_refused(folder: Path) -> None:
    own, page = folder / "own.toml", folder / "never.html"
    for words in ((own,), (own, folder / "none.csv"), (own, folder / "one.csv", "--html", own)):
        assert typed(*words).exit_code != 0
    done = typed(own, folder / "one.csv", "--bias", "pich=1", "--html", page)
    assert "nearest is pitch" in str(done.exception or done.output)
    assert not page.exists()

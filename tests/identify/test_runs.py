"""Several records of one ship in one fit, the model as it starts, and a record alone."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.reference_ships import TANKER, TANKER_RUDDER
from click.testing import CliRunner
from helpers.rolling import SYSTEM, write_record, write_study
from helpers.studies import identified, numbers
from numpy.testing import assert_allclose

from trainer.cli.workshop.identify import identify
from trainer.config.files import ConfigError
from trainer.identify.fitting.estimate import find_best_minimum
from trainer.identify.fitting.likelihood import (
    Innovations,
    Likelihood,
    MultiStep,
    no_gain,
    settled_gain,
)
from trainer.identify.fitting.minimise import SearchOptions
from trainer.identify.fitting.problem import FurtherRun, Problem
from trainer.identify.judge.uncertainty import hessian
from trainer.identify.judge.validation import draw_outputs
from trainer.identify.model.models import MODELS

pytest.importorskip("scipy")

OWN = ("Y_0", "N_0", "x1_0", "x2_0", "x3_0")


def drawn(problem: Problem, seed: int) -> Problem:
    return problem.on(draw_outputs(problem, problem.start, np.random.default_rng(seed)))


def runs(count: int, speeds: tuple[float, ...] = (1.0, 0.8)) -> tuple[list[Problem], Problem]:
    """Return problems of Model 1 at two speeds, and of both together."""
    alone = []
    places = MODELS["1"].indices(OWN)
    for seed, by in enumerate(speeds, 1):
        ship = replace(TANKER, ship=replace(TANKER.ship, speed=by * TANKER.ship.speed))
        problem = ship.problem(TANKER_RUDDER[100 * seed :][:count])
        values = problem.values.copy()
        values[list(places)] *= seed
        alone.append(drawn(replace(problem, values=values), seed))
    first, *further = alone
    others = tuple(FurtherRun(one.plant, one.samples, one.values) for one in further)
    scale = np.ones(len(first.free) + len(places) * len(others))
    return alone, replace(first, others=others, own=places, scale=scale)


COSTS: dict[str, Any] = {
    "likelihood": Likelihood,
    "several steps": lambda problem: MultiStep(problem, 2, 3),
}


@pytest.mark.parametrize("name", COSTS)
def test_costs_of_runs_add_up_and_so_do_slopes_and_information(name: str) -> None:
    (first, second), both = runs(150)
    cost, theta = COSTS[name](both), both.start
    (_, one), (_, two) = both.runs
    assert_allclose(theta[one], first.start)
    assert_allclose(theta[two], second.start)
    parts = [(COSTS[name](first), one), (COSTS[name](second), two)]
    slope: Any = np.zeros(len(theta))
    information: Any = np.zeros((len(theta), len(theta)))
    for part, at in parts:
        slope[at] += part.slope(theta[at])[1]
        information[np.ix_(at, at)] += part.information(theta[at])

    value, found = cost.slope(theta)
    expected = sum(part.value(theta[at]) for part, at in parts)
    assert value == pytest.approx(expected, rel=1e-12)
    assert cost.value(theta) == pytest.approx(expected, rel=1e-12)
    assert_allclose(found, slope, rtol=1e-9, atol=1e-9)
    assert_allclose(cost.information(theta), information, rtol=1e-9, atol=1e-9)
    assert len(theta) == len(first.free) + len(OWN)
    assert both.names[-5:] == tuple(f"{name} of run 2" for name in sorted(OWN, key="YN123".find))


@pytest.mark.parametrize("gains", [no_gain, settled_gain])
def test_errors_of_all_runs_have_one_covariance_with_a_gain(gains: Any) -> None:
    (first, second), both = runs(120)
    errors = [Innovations(one, gains).shown(one.start)[1] for one in (first, second)]
    whole = np.concatenate(errors)
    S = whole.T @ whole / len(whole)
    expected = 0.5 * len(whole) * (np.linalg.slogdet(S)[1] + 3.0 * (1.0 + np.log(2.0 * np.pi)))
    cost, theta = Innovations(both, gains), both.start
    value, slope = cost.slope(theta)
    assert value == pytest.approx(expected, rel=1e-10)
    for place in (0, len(theta) - 1):
        step = 1e-5 * max(abs(theta[place]), 1e-3)
        move = step * np.eye(len(theta))[place]
        difference = (cost.value(theta + move) - cost.value(theta - move)) / (2.0 * step)
        assert slope[place] == pytest.approx(difference, rel=1e-4, abs=1e-4)


def test_two_runs_at_two_speeds_tell_more_than_one() -> None:
    (first, _), both = runs(300)
    found = find_best_minimum(Likelihood(both), both.start, "scoring", SearchOptions())
    alone = find_best_minimum(Likelihood(first), first.start, "scoring", SearchOptions())
    ours, theirs = (
        np.sqrt(np.diag(np.linalg.inv(hessian(Likelihood(problem), one.theta))))
        for problem, one in ((both, found), (first, alone))
    )
    assert found.converged
    ship = slice(0, 6)  # derivatives, which both share
    assert np.all(ours[ship] < 0.9 * theirs[ship])
    assert np.all(np.abs(found.theta - both.start)[ship] < 4.0 * ours[ship])


@pytest.mark.slow
def test_two_records_are_fitted_by_one_command(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    other = write_record(tmp_path / "other.csv", 2, (-3.0, 1.0), 200)
    alone, both = identified(study), identified(study, other)
    assert both["samples"] == 500
    assert [run["samples"] for run in both["runs"]] == [300, 200]
    assert both["runs"][1]["explained"][0] > 0.98
    value, deviation = numbers(both)["roll_0 of run 2"]
    assert abs(value + 3.0) < 4.0 * deviation
    assert numbers(both)["w"][1] < 0.95 * numbers(alone)["w"][1]
    study.write_text(study.read_text() + f'\n[[runs]]\ndata = "{other.name}"\n')
    assert identified(study)["parameters"] == both["parameters"]
    page = CliRunner().invoke(identify, [str(study), "--csv", str(tmp_path / "x.csv")]).stdout
    assert "2 other.csv" in page
    assert max(map(len, page.splitlines())) <= 79
    rows = (tmp_path / "x.csv").read_text().splitlines()
    assert len(rows) == 501
    assert rows[-1].startswith("2,99.5,")


def test_a_run_has_its_own_part_and_its_own_numbers(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    write_record(tmp_path / "other.csv", 2, (-3.0, 1.0), 200)
    runs = '\n[[runs]]\ndata = "other.csv"\nfrom_s = 20\nto_s = 59.5\n'
    own = '\n[[parameters]]\nname = "s"\nper_run = "yes"\n'
    study.write_text(study.read_text() + runs + own)
    report = identified(study)
    assert report["runs"][1]["samples"] == 80
    assert "s of run 2" in numbers(report)
    assert "w of run 2" not in numbers(report)


def test_outliers_are_rejected_in_each_run_and_named(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    other = write_record(tmp_path / "other.csv", 2, (-3.0, 1.0), 200)
    rows = other.read_text().splitlines()
    rows[50] = ",".join([*rows[50].split(",")[:2], "500"])
    other.write_text("\n".join(rows) + "\n")
    report = identified(study, other, "--reject", "1e-6")
    assert report["screened"] == [{"run": 2, "row": 51, "t_s": 24.5}]
    assert report["samples"] == 499


@pytest.mark.slow
def test_nothing_is_estimated_where_only_a_simulation_is_wanted(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    report = identified(study, "--simulate")
    start = {"w": 0.6, "z": 0.2, "k": 1.0}
    assert {name: numbers(report)[name] for name in start} == {
        n: (x, None) for n, x in start.items()
    }
    assert report["simulated"]
    fit = identified(study)
    row = '\n[[parameters]]\nname = "{}"\nstart = {!r}\n'
    held = "".join(row.format(name, value) for name, (value, _) in numbers(fit).items())
    (tmp_path / "system.toml").write_text(SYSTEM + held)
    again = identified(study, "--simulate")
    assert again["log_likelihood"] == pytest.approx(fit["log_likelihood"], abs=1e-6)
    assert again["log_likelihood"] > report["log_likelihood"]
    rows = (tmp_path / "roll.csv").read_text().splitlines()
    rows[100] = ",".join([*rows[100].split(",")[:2], "500"])
    (tmp_path / "roll.csv").write_text("\n".join(rows) + "\n")
    screened = identified(study, "--simulate", "--reject", "1e-6")["screened"]
    assert screened == [{"run": 1, "row": 101, "t_s": 49.5}]


def test_a_record_is_shown_alone(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    other = write_record(tmp_path / "other.csv", 2, (-3.0, 1.0), 200)
    report = identified(study, other, "--data-only")
    first, second = report["runs"]
    assert (first["samples"], second["samples"]) == (300, 200)
    assert [one["name"] for one in first["channels"]] == ["fin", "roll"]
    assert (first["channels"][0]["least"], first["channels"][0]["largest"]) == (-10.0, 10.0)
    page = CliRunner().invoke(identify, [str(study), "--data-only"]).stdout
    assert "300 samples every 0.5 s, from 0 s to 149.5 s" in page


def test_a_second_study_is_no_run(tmp_path: Path) -> None:
    study = write_study(tmp_path)
    with pytest.raises(ConfigError, match="is a study: one study"):
        identified(study, study)

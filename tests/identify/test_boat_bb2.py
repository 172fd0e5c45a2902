"""Fits of BB2 and of boats like it from an estimate that has not seen BB2: the acceptance.

The truth is the shipped boat, whose coefficients are of model tests and computed flows; the prior
is the estimate of its hull by constants that were fitted without it. docs/fitted-boat.md has these
figures.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from helpers.bb2_trials import estimated_bb2, four_trials, sail, vertical, zigzag
from helpers.held_bands import SURE, inside, scores, told

from trainer.config.boat.vessel import load_vessel
from trainer.identify.boat import search
from trainer.identify.boat.figures import BAND_DRAWS, FigureBand, figure_bands
from trainer.identify.boat.filter import CHANNEL_NAMES, GROUND_CHANNEL, SPEED_CHANNEL
from trainer.identify.boat.fitted_file import fitted_text
from trainer.identify.boat.motion import STATE
from trainer.identify.boat.noise import FLOW_NAMES
from trainer.identify.boat.prior import Prior, read_prior
from trainer.identify.boat.report import MAX_CONFLICT, report_fit
from trainer.identify.boat.trial import Trial, without_unflown
from trainer.identify.boat.vessel import FittedVessel

pytestmark = pytest.mark.slow

SEEDS = (1, 2, 3)


class Fitted(NamedTuple):
    """A fit of four trials of BB2, and a zig-zag held out."""

    found: search.SearchEnd
    bands: tuple[FigureBand, ...]
    held_out: Trial


@pytest.fixture(scope="module")
def prior(tmp_path_factory: pytest.TempPathFactory) -> Prior:
    """Return the estimate of BB2's hull."""
    return read_prior(str(estimated_bb2(tmp_path_factory.mktemp("bb2"))))


def true_bb2(prior: Prior) -> FittedVessel:
    """Return the shipped boat, with the prior's time step: overshoots depend on it."""
    file = load_vessel("bb2")
    return FittedVessel(replace(file, run=replace(file.run, step_s=prior.vessel.file.run.step_s)))


@cache
def fitted(prior: Prior, seed: int) -> Fitted:
    truth = true_bb2(prior)
    boat = truth.numbers(truth.values)
    found = search.fit_trials(prior, [*map(without_unflown, four_trials(boat, seed))])
    bands = figure_bands(prior.vessel, found.posterior, BAND_DRAWS, lambda _: None)
    return Fitted(found, bands, sail(boat, zigzag(20.0, 10.0), 10.0, 600, 1000 + seed, "held out"))


@pytest.mark.parametrize("seed", SEEDS)
def test_bb2_is_found_from_its_hull_and_an_hour_of_trials(prior: Prior, seed: int) -> None:
    found, bands, held_out = fitted(prior, seed)
    assert found.found.converged
    squares = [(one.innovations**2 / one.variances).ravel() for one in found.passes]
    assert 0.97 < np.nanmean(np.concatenate(squares)) < 1.03
    for name, least, most in (("turn at 15 deg", 8.0, 30.0), ("turn at 25 deg", 8.0, 35.0)):
        one = told(bands, true_bb2(prior))[f"{name}: diameter"]
        assert abs(one.value - one.truth) < 2.5 * one.sd
        assert least < one.sd < most
    (foretold,) = report_fit(found, [held_out], draws=0).held_out
    assert foretold.explained["yaw rate"][0] > 99.5
    assert foretold.explained["roll"][0] > 98.5


def test_most_figures_of_bb2_lie_inside_their_bands(prior: Prior) -> None:
    truth = true_bb2(prior)
    held = [inside(fitted(prior, seed).bands, truth) for seed in SEEDS]
    assert np.mean([np.mean(one) for one in held]) > 12.0 / 14.0
    coefficients = [scores(fitted(prior, seed).found, truth.values) for seed in SEEDS]
    assert 0.89 < np.mean(np.abs(coefficients) < SURE) < 0.99


def test_two_fits_one_after_the_other_agree_with_one(prior: Prior, tmp_path: Path) -> None:
    truth = true_bb2(prior)
    boat = truth.numbers(truth.values)
    trials = [*map(without_unflown, four_trials(boat, 4, 600))][1:3]
    both = search.fit_trials(prior, trials)
    first = search.fit_trials(prior, trials[:1])
    path = tmp_path / "first.toml"
    text, _ = fitted_text(first, report_fit(first, [], draws=0), path)
    path.write_text(text, encoding="utf-8")
    second = search.fit_trials(read_prior(str(path)), trials[1:])
    moving = prior.sd > 0.0
    off = (second.posterior.values - both.posterior.values)[moving] / both.posterior.sd[moving]
    assert np.sqrt(np.mean(off**2)) < 0.3
    assert np.abs(off).max() < 1.0


def without_depth(trial: Trial) -> Trial:
    """Return a trial without what its planes were used for."""
    readings = trial.readings.copy()
    readings[:, [CHANNEL_NAMES.index(name) for name in ("pitch", "depth", "q")]] = np.nan
    return replace(trial, readings=readings)


@pytest.mark.parametrize(
    ("draw", "seed", "seconds", "kept_holds"), [(0, 51, 600, False), (2007, 97, 500, True)]
)
def test_planes_that_only_kept_the_depth_may_mislead_with_their_readings(
    prior: Prior, draw: int, seed: int, seconds: int, *, kept_holds: bool
) -> None:
    """Without these readings both boats are right, and the turn is wider: see the page."""
    vessel = prior.vessel
    truth = FittedVessel(vessel.with_values(prior.draw(draw))) if draw else true_bb2(prior)
    boat = truth.numbers(truth.values)
    trial = without_unflown(sail(boat, zigzag(10.0, 10.0), 10.0, seconds, seed, "zigzag"))
    assert trial.has("depth")
    outside = []
    for one in (trial, without_depth(trial)):
        found = search.fit_trials(prior, [one])
        bands = told(figure_bands(vessel, found.posterior, BAND_DRAWS, lambda _: None), truth)
        vertical_ones = [each for name, each in bands.items() if "turn" not in name][3:]
        off = max(abs(each.value - each.truth) / each.sd for each in vertical_ones)
        outside.append(off > 2.5)
        words = report_fit(found, [], draws=0).warnings
        assert any("no record flies the planes" in each for each in words)
    assert outside == [not kept_holds, False]


def test_a_vertical_zigzag_beside_it_mends_that(prior: Prior) -> None:
    truth = true_bb2(prior)
    boat = truth.numbers(truth.values)
    trials = [
        sail(boat, zigzag(10.0, 10.0), 10.0, 600, 51, "zigzag"),
        sail(boat, vertical(8.0), 8.0, 600, 52, "vertical"),
    ]
    found = search.fit_trials(prior, [*map(without_unflown, trials)])
    bands = told(figure_bands(prior.vessel, found.posterior, 40, lambda _: None), truth)
    assert max(abs(one.value - one.truth) / one.sd for one in bands.values()) < 2.5
    assert not any("no record flies" in each for each in report_fit(found, [], draws=0).warnings)


def two_trials(truth: FittedVessel, seed: int) -> list[Trial]:
    """Return a zig-zag of 450 s and a vertical one of 500 s."""
    boat = truth.numbers(truth.values)
    return [
        sail(boat, zigzag(10.0, 10.0), 10.0, 450, 10 * seed, "zigzag"),
        sail(boat, vertical(8.0), 8.0, 500, 10 * seed + 1, "vertical"),
    ]


def carried(trial: Trial) -> Trial:
    """Return a trial in a current of 0.4 m/s whose only log reads the speed over ground."""
    readings = trial.readings.copy()
    heading = readings[:, CHANNEL_NAMES.index("heading")]
    readings[:, GROUND_CHANNEL] = readings[:, SPEED_CHANNEL] + 0.4 * np.cos(heading - 0.7)
    readings[:, SPEED_CHANNEL] = np.nan
    return replace(trial, readings=readings)


def test_a_current_is_found_where_it_is_allowed_for_and_misleads_where_not(prior: Prior) -> None:
    truth, allowed, refused = true_bb2(prior), list[bool](), list[bool]()
    still = dict.fromkeys(FLOW_NAMES, 1e-9)
    for seed in (1, 2):
        trials = [without_unflown(carried(one)) for one in two_trials(truth, seed)]
        found = search.fit_trials(prior, trials)
        allowed += inside(figure_bands(prior.vessel, found.posterior, 60, lambda _: None), truth)
        flow = found.passes[0].states[-1, [STATE.NORTH, STATE.EAST]]
        assert flow == pytest.approx(0.4 * np.array([np.cos(0.7), np.sin(0.7)]), abs=0.15)
        blind = search.fit_trials(prior, [replace(one, biases=still) for one in trials])
        refused += inside(figure_bands(prior.vessel, blind.posterior, 60, lambda _: None), truth)
    assert np.mean(allowed) > 0.92
    assert np.mean(refused) < 0.85


def test_a_vertical_zigzag_alone_tells_nothing_wrong_of_turning(prior: Prior) -> None:
    truth, shares = true_bb2(prior), list[bool]()
    boat = truth.numbers(truth.values)
    for seed in (1, 2):
        trial = without_unflown(sail(boat, vertical(8.0), 8.0, 900, 10 * seed + 2, "vertical"))
        assert trial.told == ("course only kept: nothing learned of turning",)
        found = search.fit_trials(prior, [trial])
        shares += inside(figure_bands(prior.vessel, found.posterior, 60, lambda _: None), truth)
    assert np.mean(shares) > 0.9


def test_a_log_of_bb2_that_is_two_seconds_late_is_told(prior: Prior) -> None:
    trials = [without_unflown(one) for one in two_trials(true_bb2(prior), 1)]
    found = search.fit_trials(prior, trials)
    assert found.conflict < MAX_CONFLICT
    assert search.find_delay(found) == 0.0
    late = search.fit_trials(prior, [one.hastened(-2.0) for one in trials])
    assert late.conflict > MAX_CONFLICT
    assert search.find_delay(late) == 2.0

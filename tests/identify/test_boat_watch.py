"""A boat that has changed is told, with its part; one that has not is left alone."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from helpers.bb2_trials import PUSHES
from helpers.boat_trials import estimated_boat
from helpers.changed_boats import NEVER, Alteration, altered_values, sail_changed

from trainer.identify.boat import altered, search, watch
from trainer.identify.boat.altered import ALTERED_PARTS, PART_COUNT
from trainer.identify.boat.filter import DRIVEN_COUNT
from trainer.identify.boat.motion import STATE
from trainer.identify.boat.noise import Noise, usual_noise
from trainer.identify.boat.prior import Prior, read_prior
from trainer.identify.boat.trial import Trial
from trainer.identify.boat.watch import BoatWatch, WatchFiles, watch_boat
from trainer.identify.boat.watch_page import html_page, is_unseen, render
from trainer.units import DEGREE

SECONDS = 320
KNOWN_SHARE = 0.05  # of the estimate's deviations, that a good fit leaves
CHANGES = (
    Alteration("lift of the rudder", -0.3, 200),
    Alteration("weight", 0.005, 200),
    Alteration("zero of the rudder", 2.0 * DEGREE, 200),
    Alteration("roll gauge", 2.0 * DEGREE, 200),
)


@pytest.fixture(scope="session")
def own(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of an estimated boat."""
    return estimated_boat(tmp_path_factory.mktemp("watch"))


@cache
def prior_of(path: Path, share: float = KNOWN_SHARE) -> Prior:
    """Return an estimated boat whose deviations are a ``share`` of what they were."""
    prior = read_prior(str(path))
    return replace(prior, root=share * prior.root)


def quiet_noise(prior: Prior) -> Noise:
    """Return the noise of a calm day."""
    logarithms = usual_noise(prior.vessel).logarithms.copy()
    logarithms[:DRIVEN_COUNT] -= 1.0
    return Noise(logarithms)


def sailed(prior: Prior, change: Alteration = NEVER, seed: int = 1, *, sea: bool = False) -> Trial:
    return sail_changed(prior.vessel, prior.values, SECONDS, seed, change, sea=sea)


def files_of(prior: Prior, *trials: Trial) -> WatchFiles:
    return WatchFiles(prior, quiet_noise(prior), trials)


def judged(files: WatchFiles) -> BoatWatch:
    """Return the verdict by the noise as it is given, not that of the day."""
    noises = [files.noise] * len(files.trials)
    vessel = files.fitted.vessel
    seen = altered.score_records(files.fitted, vessel, files.trials, noises, lambda _: None)
    return watch.judge_scores(files, seen)


@pytest.mark.long
@pytest.mark.parametrize("change", CHANGES, ids=lambda one: one.name)
def test_a_changed_part_is_told_by_name_time_and_size(own: Path, change: Alteration) -> None:
    prior = prior_of(own)
    found = watch_boat(files_of(prior, sailed(prior, change))).change
    assert found is not None
    likeliest = found.parts[0]
    assert likeliest.name == change.name
    assert likeliest.value == pytest.approx(change.amount, rel=0.4)
    assert change.at <= found.told.seconds <= change.at + 120
    assert found.earliest.seconds <= change.at + 30
    assert found.latest.seconds >= change.at - 60


@pytest.mark.long
def test_a_boat_that_has_not_changed_is_left_alone_in_calm_and_in_a_sea(own: Path) -> None:
    prior = prior_of(own)
    for sea in (False, True):
        files = files_of(prior, sailed(prior, seed=3, sea=sea))
        report = watch_boat(files)
        assert report.change is None, render(report)
        assert "Nothing told" in render(report)
    assert judged(files).change is not None, "a sea needs a noise of its own"


@pytest.mark.long
def test_a_boat_that_is_hardly_known_changes_unseen_and_not_falsely(own: Path) -> None:
    wide, narrow = prior_of(own, 0.1), prior_of(own, 0.001)
    trial = sail_changed(wide.vessel, wide.draw(5), SECONDS, 1)
    assert judged(files_of(wide, trial)).change is None
    assert judged(files_of(narrow, trial)).change is not None


@pytest.mark.long
def test_a_plane_that_does_not_move_is_told_as_unseen(own: Path) -> None:
    prior = prior_of(own)
    trial = sail_changed(prior.vessel, prior.values, SECONDS, 1, still=("bow",))
    report = watch_boat(files_of(prior, trial))
    assert [one.name for one in report.parts if is_unseen(one)] == ["lift of the bow planes"]
    assert "They cannot show: lift of the bow planes" in render(report)


@pytest.mark.long
def test_drag_and_thrust_at_one_speed_are_told_as_either(own: Path) -> None:
    prior, change = prior_of(own), Alteration("drag", 0.25, 200)
    trial = sail_changed(prior.vessel, prior.values, SECONDS, 1, change, still=("speed",))
    files = files_of(prior, trial)
    report = watch_boat(files)
    assert report.change is not None
    assert {"drag", "thrust"} <= {one.name for one in report.change.parts}
    text = render(report)
    assert "cannot be told apart" in text
    assert max(map(len, text.splitlines())) <= 79
    page = html_page(files, report)
    assert "how far from the boat that was fitted" in page
    assert "growth on the hull" in page


@pytest.mark.long
def test_several_records_are_one_after_the_other(own: Path) -> None:
    prior = prior_of(own)
    first = replace(sailed(prior, seed=1), source="monday.csv")
    change = Alteration("lift of the rudder", -0.3, 0)
    second = replace(sailed(prior, change, seed=2), source="tuesday.csv")
    report = watch_boat(files_of(prior, first, second))
    assert report.change is not None
    assert report.change.parts[0].name == change.name
    assert report.change.told.source == "tuesday.csv"
    assert report.change.told.t == SECONDS + report.change.told.seconds
    assert report.t[-1] == 2 * SECONDS
    assert (np.diff(report.t) > 0.0).all()


@pytest.mark.long
def test_slopes_by_windows_are_those_of_one_pass(own: Path) -> None:
    """What a change does to later windows is carried by the state, weight and gauges with it."""
    prior = prior_of(own, 1e-9)
    trial, noise = sailed(prior), quiet_noise(prior)
    seen = altered.score_records(prior, prior.vessel, [trial], [noise], lambda _: None)
    tested = watch.test_changes(seen, np.full(PART_COUNT, 1e-12))[-1]
    plain = search.run_pass(prior.vessel, prior.values, trial, noise, 0)
    for i, part in enumerate(ALTERED_PARTS[:5]):
        values = altered_values(prior.values, part, part.nudge)
        changed = search.run_pass(prior.vessel, values, trial, noise, 0)
        slopes = (plain.innovations - changed.innovations) / part.nudge
        weighted = slopes / plain.variances
        information = np.nansum(weighted * slopes)
        assert tested.variance[0, i, i] == pytest.approx(information, rel=0.05), part.name
        off = tested.score[0, i] - np.nansum(weighted * plain.innovations)
        assert abs(off) < 0.1 * math.sqrt(information), part.name


@pytest.mark.long
def test_scores_of_an_unchanged_boat_are_of_deviation_one(own: Path) -> None:
    prior, sizes = prior_of(own, 1e-9), []
    logarithms = usual_noise(prior.vessel).logarithms.copy()
    logarithms[:DRIVEN_COUNT] = np.log(PUSHES)
    for seed in range(1, 6):
        trial = sailed(prior, seed=seed)
        seen = altered.score_records(
            prior, prior.vessel, [trial], [Noise(logarithms)], lambda _: None
        )
        sizes.append(watch.test_changes(seen, np.full(PART_COUNT, 1e-12))[-1].deviations[0])
    assert 0.7 < math.sqrt(np.mean(np.square(sizes))) < 1.3


def test_lift_is_what_goes_with_the_angle_alone() -> None:
    terms = {part.name: part.terms for part in ALTERED_PARTS}
    assert {"Y_dr", "N_dr", "K_dr", "N_dr_eta"} <= set(terms["lift of the rudder"])
    assert "X_drdr" not in terms["lift of the rudder"]
    assert set(terms["lift of the bow planes"]) == {"Z_db", "M_db"}
    assert {part.state for part in ALTERED_PARTS if part.state >= 0} == {
        STATE.WEIGHT,
        STATE.TRIM,
        STATE.PITCH_ERROR,
        STATE.ROLL_ERROR,
        STATE.LOG_ERROR,
    }

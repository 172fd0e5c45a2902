"""What to sail next: expected deviations, waters that are kept, and the exercise."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from helpers.bb2_trials import PUSHES, estimated_bb2
from helpers.boat_trials import estimated_boat, made_trial

from trainer.cli.main import cli
from trainer.config.boat.vessel import load_vessel
from trainer.config.exercise.exercise import parse_exercise
from trainer.config.files import ConfigError
from trainer.identify.boat import plan, search
from trainer.identify.boat.filter import DRIVEN_COUNT
from trainer.identify.boat.motion import STATE
from trainer.identify.boat.noise import Noise, usual_noise
from trainer.identify.boat.planned_trial import exercise_text, render_plan
from trainer.identify.boat.prior import read_prior
from trainer.identify.boat.trial import read_trial
from trainer.identify.boat.trial_legs import TRIAL_LEGS, TrialLeg, room_of, sail_legs, waters_of
from trainer.identify.boat.vessel import FittedVessel
from trainer.units import DEGREE

MINUTES = 6.0
BY_NAME = {leg.name: leg for leg in TRIAL_LEGS}
TURN_20 = TrialLeg("turn at 20 deg", "rudder", 20.0)
# deviations after a quarter of an hour, of fits of BB2 by another program: diameters at 15 and
# 25 deg [m], depth after a minute of 5 deg of planes [m], critical speed [m/s]; NaN: it has none
FITTED_DEVIATIONS = {
    ("turn at 15 deg",): (7.0, 11.0, 5.7, 0.23),
    ("zig-zag 10/10",): (20.0, 19.0, 5.1, 0.34),
    ("zig-zag 20/20",): (8.0, 7.0, 5.5, 0.23),
    ("vertical zig-zag 8/5",): (math.nan, math.nan, 2.0, 0.09),
    ("zig-zag 10/10", "vertical zig-zag 8/5"): (21.0, 17.0, 1.4, 0.09),
    ("zig-zag 10/10", TURN_20.name, "vertical zig-zag 8/5"): (5.0, 5.0, 1.4, 0.10),
}


@pytest.fixture(scope="session")
def own(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of an estimated boat."""
    return estimated_boat(tmp_path_factory.mktemp("plan"))


@cache
def slopes_of(path: Path) -> plan.FigureSlopes:
    return plan.figure_slopes(read_prior(str(path)), lambda _: None)


def planned(
    path: Path, room: str | None = None, depth: str | None = None, *figures: str
) -> plan.TrialPlan:
    asked = plan.open_question(str(path), MINUTES, room, depth)
    return plan.find_plan(asked, slopes_of(path).chosen(figures))


def typed(*words: object) -> Result:
    return CliRunner().invoke(cli, [*map(str, words)])


@pytest.mark.slow
def test_expected_deviations_of_bb2_are_those_of_fits(tmp_path: Path) -> None:
    """By another program, another prior, and noise that is found: within a factor of two."""
    prior = read_prior(str(estimated_bb2(tmp_path)))
    shipped = load_vessel("bb2")
    step = prior.vessel.file.run.step_s
    truth = FittedVessel(replace(shipped, run=replace(shipped.run, step_s=step)))
    known = replace(prior, values=truth.values, vessel=truth)
    slopes = plan.figure_slopes(known, lambda _: None)
    chosen = [slopes.chosen([word]) for word in ("15 deg: dia", "25 deg: dia", "planes: ", "crit")]
    logarithms = usual_noise(truth).logarithms.copy()
    logarithms[:DRIVEN_COUNT] = np.log(PUSHES)
    legs, waters = {**BY_NAME, TURN_20.name: TURN_20}, waters_of(truth, None, None)
    for names, fitted in FITTED_DEVIATIONS.items():
        sailed = sail_legs(
            truth, truth.values, [legs[name] for name in names], 900.0 / len(names), waters
        )
        told = plan.information_of(known, sailed, Noise(logarithms))
        found = np.array([plan.deviations_of(known, one, told)[0] for one in chosen])
        ratios = (found / fitted)[np.isfinite(fitted)]
        assert (ratios > 0.5).all(), (names, found)
        assert (ratios < 1.3).all(), (names, found)


@pytest.mark.long
def test_what_is_expected_is_what_a_fit_then_tells(own: Path) -> None:
    prior = read_prior(str(own))
    trial = made_trial(prior.vessel, prior.draw(7))
    found = search.fit_trials(prior, [trial])
    assert found.found.converged
    there = replace(prior, values=found.posterior.values)
    sailed = sail_legs(
        prior.vessel, prior.values, TRIAL_LEGS[:1], 60.0, waters_of(prior.vessel, None, None)
    )
    told = plan.information_of(there, sailed._replace(trial=trial), found.noise)
    slopes = slopes_of(own)
    expected = plan.deviations_of(prior, slopes, told)
    root = np.einsum("fj,jk->fk", slopes.slopes, found.posterior.root)
    assert expected == pytest.approx(np.sqrt(np.sum(root**2, axis=1)), rel=1e-3)


@pytest.mark.long
def test_a_plan_tells_more_than_a_plain_zigzag_and_keeps_its_waters(own: Path) -> None:
    free = planned(own)
    ratios = [one.planned / one.plain for one in free.figures]
    assert np.exp(np.mean(np.log(ratios))) < 1.0
    assert all(one.planned < one.before for one in free.figures)
    wide = planned(own, f"{room_of(free.sailed):.0f}m")
    room = math.floor(0.8 * room_of(wide.sailed))
    small = planned(own, f"{room}m")
    assert room_of(small.sailed) <= room
    low, middle = free.waters.shallowest, free.waters.depth
    flat = planned(own, None, f"{middle - 8.0:.1f}:{middle + 8.0:.1f}")
    assert low < middle - 8.0 <= flat.sailed.states[:, STATE.Z].min()
    assert flat.sailed.states[:, STATE.Z].max() <= middle + 8.0
    text = render_plan(small)
    assert "WHAT TO SAIL NEXT" in text
    assert f"{room} m of room" in text
    assert max(map(len, text.splitlines())) <= 100


@pytest.mark.long
def test_what_is_asked_for_decides_what_is_sailed(own: Path) -> None:
    turning = {leg.control for leg in planned(own, None, None, "turn at 25").sailed.legs}
    diving = {leg.control for leg in planned(own, None, None, "vertical", "critical").sailed.legs}
    assert "rudder" in turning
    assert "stern" in diving


@pytest.mark.long
def test_the_exercise_is_sailed_at_once_and_its_record_fitted(own: Path, tmp_path: Path) -> None:
    trial, record = tmp_path / "trial.toml", tmp_path / "trial.trainer"
    done = typed("boat", "plan-trial", own, "--minutes", MINUTES, "-o", trial)
    assert done.exit_code == 0, done.output
    assert "plain 20/20" in done.output
    checked = typed("exercise", "check", trial)
    assert checked.exit_code == 0, checked.output
    done = typed("run", trial, "--headless", "--speed", "max", "--record", record)
    assert done.exit_code == 0, done.output
    prior, asked = read_prior(str(own)), parse_exercise(trial.read_text(encoding="utf-8"), trial)
    read = read_trial(record, prior.vessel)
    assert len(read.readings) * read.interval == pytest.approx(60.0 * MINUTES, rel=0.02)
    depth = read.readings[:, 4]
    limits = asked.limits
    assert limits.depth_m_min is not None
    assert limits.depth_m_max is not None
    assert limits.depth_m_min < depth.min() < depth.max() < limits.depth_m_max
    ordered = [one.order for one in asked.schedule]
    assert np.ptp(read.inputs[:, 0]) > 15.0 * DEGREE, ordered
    assert read.has("heading")
    assert read.has("pitch")


def test_a_rudder_goes_over_at_the_angle_of_its_zigzag(own: Path) -> None:
    vessel = read_prior(str(own)).vessel
    waters = waters_of(vessel, None, None)
    sailed = sail_legs(vessel, vessel.values, [BY_NAME["zig-zag 20/20"]], 200.0, waters)
    hands = ("rudder left", "rudder right")
    by_hand = [(seconds, words) for seconds, words in sailed.orders if words.startswith(hands)]
    assert [words for _, words in by_hand[:2]] == ["rudder right 20", "rudder left 20"]
    turned = sailed.states[:, STATE.PSI] - math.pi
    for side, (seconds, _) in zip((1.0, -1.0), by_hand[1:], strict=False):
        at = round(seconds / sailed.trial.interval)
        assert side * turned[at] >= 20.0 * DEGREE > side * turned[at - 1]
    assert sailed.trial.inputs[round(by_hand[0][0] / sailed.trial.interval) + 20, 0] < 0.0


def test_too_many_orders_are_told(own: Path, tmp_path: Path) -> None:
    asked = plan.open_question(str(own), MINUTES, None, None)
    vessel = asked.prior.vessel
    sailed = sail_legs(vessel, vessel.values, TRIAL_LEGS[:1], 60.0, asked.waters)
    many = sailed._replace(orders=sailed.orders * 600)
    with pytest.raises(ConfigError, match="orders, and an exercise has 500 at most"):
        exercise_text(plan.TrialPlan(asked.prior, asked.waters, many, ()), tmp_path / "x.toml")


@pytest.mark.parametrize(
    ("minutes", "room", "depth", "told"),
    [
        (15.0, "wide", None, "--room wide: 'wide' is no length in metres"),
        (15.0, "-5", None, "must be above 0"),
        (15.0, None, "40", "say the least and the greatest"),
        (15.0, None, "120:40", "the first must be less than the second"),
        (15.0, None, "1:90", "a fit takes no record above"),
        (0.1, None, None, "--minutes 0.1: needs"),
    ],
)
def test_a_question_that_cannot_be_answered_is_told(
    own: Path, minutes: float, room: str | None, depth: str | None, told: str
) -> None:
    with pytest.raises(ConfigError) as wrong:
        plan.open_question(str(own), minutes, room, depth)
    assert told in str(wrong.value)


def test_an_unknown_figure_is_told_with_the_nearest() -> None:
    some = plan.FigureSlopes((("turn at 15 deg: diameter", "m"),), np.ones(1), np.ones((1, 2)))
    assert some.chosen(["Diam"]).names == some.names
    with pytest.raises(ConfigError, match=r"no such figure; nearest is diameter; there are turn"):
        some.chosen(["diametre"])


@pytest.mark.long
def test_waters_that_no_trial_keeps_are_told_with_what_it_needs(own: Path) -> None:
    with pytest.raises(ConfigError, match=r"needs \d+ m of room.*give more --room"):
        planned(own, "20m")


@pytest.mark.parametrize(("hull", "orders"), [("small-boat", 1), ("remus100", 0)])
def test_bow_planes_are_ordered_only_of_a_boat_that_has_some(
    tmp_path: Path, hull: str, orders: int
) -> None:
    vessel = read_prior(str(estimated_boat(tmp_path, hull))).vessel
    leg, waters = BY_NAME["vertical zig-zag 8/5"], waters_of(vessel, None, None)
    sailed = sail_legs(vessel, vessel.values, [leg], 60.0, waters)
    assert [words for _, words in sailed.orders].count("bow planes zero") == orders

"""Estimates, what is known of them, and what cannot be told apart."""

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cases.reference_ships import TANKER, TANKER_RUDDER, study
from numpy.testing import assert_allclose

from trainer.config.files import ConfigError
from trainer.identify.fitting.estimate import MINIMISER_BY_NAME, find_best_minimum
from trainer.identify.fitting.likelihood import Innovations, Likelihood, MultiStep, settled_gain
from trainer.identify.fitting.minimise import SearchOptions, SearchResult, ignore_news
from trainer.identify.fitting.problem import Problem
from trainer.identify.judge.fitted import resume_search, save_steps
from trainer.identify.judge.uncertainty import hessian, inseparable, intervals, uncertainty
from trainer.identify.judge.validation import draw_outputs
from trainer.identify.model.models import MODELS, Ship
from trainer.identify.monte_carlo import KnownShip


def recorded(rehearsal: Any, count: Any, seed: Any = 1) -> Any:
    problem = rehearsal.problem(TANKER_RUDDER[:count])
    return problem.on(draw_outputs(problem, problem.start, np.random.default_rng(seed)))


@pytest.fixture(scope="module")
def cost() -> Any:
    return Likelihood(recorded(TANKER, 600))


@pytest.fixture(scope="module")
def best(cost: Any) -> Any:
    return find_best_minimum(cost, TANKER.start(), "bfgs", SearchOptions(most=500))


@pytest.mark.slow
@pytest.mark.parametrize("method", MINIMISER_BY_NAME)
def test_every_minimiser_comes_to_the_same_minimum(cost: Any, best: Any, method: Any) -> None:
    if method == "direct":
        pytest.importorskip("scipy")
    found = find_best_minimum(cost, TANKER.start(), method, SearchOptions(most=60))
    assert found.converged
    assert found.cost == pytest.approx(best.cost, abs=1e-3)


def test_the_minimum_is_one(cost: Any, best: Any) -> None:
    value, slope = cost.slope(best.theta)
    known = uncertainty(cost.problem.names, hessian(cost, best.theta))
    assert known.eigenvalues[0] > 0.0
    assert 0.5 * slope @ known.covariance @ slope < 1e-4
    assert value == pytest.approx(best.cost, rel=1e-12)
    assert value < cost.value(cost.problem.start)


def test_the_truth_is_within_four_standard_deviations(cost: Any, best: Any) -> None:
    known = uncertainty(cost.problem.names, cost.information(best.theta))
    # small disturbances and their correlation have no normal scatter near their ends
    usual = np.array([not name.startswith("R1") for name in known.names])
    away = (np.abs(best.theta - cost.problem.start) / known.deviations)[usual]
    assert np.max(away) < 4.0
    assert np.mean(away < 2.0) > 0.8


def test_the_hessian_is_near_the_information(cost: Any, best: Any) -> None:
    # they differ by the record's own luck only
    ratio = np.diag(hessian(cost, best.theta)) / np.diag(cost.information(best.theta))
    assert np.all((ratio > 0.5) & (ratio < 2.0))


def test_a_disturbance_near_nothing_is_known_no_better_than_the_record_tells(cost: Any) -> None:
    # below nothing is the same variance again: differences across it would see a kink
    theta = cost.problem.start.copy()
    place = cost.problem.names.index("R1_Y")
    theta[place] = 1e-18
    theta[cost.problem.names.index("R1_YN")] = 0.0
    curvature, information = hessian(cost, theta), cost.information(theta)
    assert abs(curvature[place, place]) < 10.0 * information[place, place]


@pytest.mark.slow
def test_an_impossible_gain_is_no_cost_and_no_traceback() -> None:
    held = tuple(n for n in TANKER.free if not n.startswith(("R2", "x", "R1_YN")))
    problem = recorded(replace(TANKER, free=held), 60)
    nothing = {"R1_Y", "R1_N", "R2_v1", "R2_r", "R2_psi"}
    values = problem.values.copy()
    values[[MODELS["1"].index(name) for name in nothing]] = 0.0
    dead = replace(problem, values=values)
    assert Innovations(dead, settled_gain).value(dead.start) == np.inf
    assert MultiStep(dead, 2, 3).value(dead.start) == np.inf


@pytest.mark.slow
def test_innovations_and_longer_predictions_find_the_ship_too() -> None:
    held = tuple(n for n in TANKER.free if not n.startswith(("R2", "x", "R1_YN")))
    problem = recorded(replace(TANKER, free=held), 800)
    known = uncertainty(problem.names, Likelihood(problem).information(problem.start))
    for cost in (Innovations(problem, settled_gain), MultiStep(problem, 1, 2)):
        found = find_best_minimum(cost, problem.start * 1.1, "bfgs", SearchOptions(most=60))
        # their deviations are larger than the likelihood's, but not by much
        assert np.max(np.abs(found.theta - problem.start) / known.deviations) < 6.0


def test_scale_changes_nothing_but_the_numbers_moved(cost: Any, best: Any) -> None:
    scale = np.geomspace(1e-3, 1e3, len(best.theta))
    scaled = Likelihood(replace(cost.problem, scale=scale))
    found = find_best_minimum(scaled, TANKER.start() / scale, "scoring", SearchOptions())
    assert found.cost == pytest.approx(best.cost, abs=1e-4)
    assert_allclose(found.theta * scale, best.theta, rtol=2e-2, atol=2e-3)


def test_a_parameter_that_is_not_free_stays(cost: Any) -> None:
    problem = replace(TANKER, free=tuple(n for n in TANKER.free if n != "N_v"))
    problem = problem.problem(TANKER_RUDDER[:600]).on(cost.problem.samples)  # type: ignore[assignment]
    start = np.delete(TANKER.start(), TANKER.free.index("N_v"))
    found = find_best_minimum(Likelihood(problem), start, "scoring", SearchOptions())  # type: ignore[arg-type]
    place = MODELS["1"].index("N_v")
    assert problem.whole(found.theta)[place] == TANKER.truth["N_v"]  # type: ignore[attr-defined]


@dataclass(frozen=True)
class Wells:
    """A cost of one parameter with a shallow minimum at 1 and a deep one at -1.1."""

    problem: Problem

    def value(self, theta: Any) -> Any:
        x = float(theta[0])
        return 5.0 * (x * x - 1.0) ** 2 + 2.0 * x

    def slope(self, theta: Any) -> Any:
        x = float(theta[0])
        return self.value(theta), np.array([20.0 * x * (x * x - 1.0) + 2.0])

    def information(self, theta: Any) -> Any:
        return np.full((1, 1), 4.0) + 0.0 * theta  # far too flat: whole steps overshoot


@pytest.fixture
def wells() -> Any:
    return Wells(replace(TANKER, free=("Y_v",)).problem(TANKER_RUDDER[:10]))


@pytest.mark.parametrize("method", ["scoring", "bfgs"])
def test_steps_that_overshoot_are_shortened_until_the_cost_falls(wells: Any, method: Any) -> None:
    found = find_best_minimum(wells, np.array([1.3]), method, SearchOptions(200))
    assert found.converged
    assert wells.slope(found.theta)[1] == pytest.approx([0.0], abs=1e-3)


def test_the_top_between_two_minima_is_left(wells: Any) -> None:
    # the slope is nothing there, and the second derivative is below nothing
    top = np.array([0.1010313])
    assert abs(wells.slope(top)[1][0]) < 1e-3
    found = find_best_minimum(wells, top, "scoring", SearchOptions(200))
    assert found.converged
    assert wells.slope(found.theta)[1] == pytest.approx([0.0], abs=0.1)
    assert found.cost < wells.value(top) - 2.0


@dataclass(frozen=True)
class Variance:
    """A cost of one variance with its minimum at 1."""

    problem: Problem

    def value(self, theta: Any) -> Any:
        return 50.0 * (abs(float(theta[0])) - 1.0) ** 2

    def slope(self, theta: Any) -> Any:
        return self.value(theta), np.array([100.0 * (float(theta[0]) - 1.0)])

    def information(self, theta: Any) -> Any:
        return np.full((1, 1), 100.0) + 0.0 * theta


@pytest.mark.parametrize("start", [1e-12, 1e-4, 30.0])
def test_a_variance_near_nothing_is_lifted_where_the_cost_would_fall(start: float) -> None:
    # its logarithm has no slope there: a search by slopes alone ends at once
    cost = Variance(replace(TANKER, free=("R1_Y",)).problem(TANKER_RUDDER[:10]))
    found = find_best_minimum(cost, np.array([start]), "scoring", SearchOptions(200))
    assert found.converged
    assert found.theta == pytest.approx([1.0], abs=1e-2)


def test_a_search_that_may_not_go_on_has_not_settled_and_says_why(cost: Any) -> None:
    found = find_best_minimum(cost, TANKER.start(), "direct", SearchOptions(1))
    assert not found.converged
    assert "promises" in found.doubt or "not all positive" in found.doubt


def test_a_ship_quicker_than_its_readings_is_no_minimum() -> None:
    quick = replace(TANKER, truth={**TANKER.truth, "N_r": -200.0}, free=("Y_v",), begin={})
    problem = recorded(quick, 60)
    found = find_best_minimum(
        Likelihood(problem), problem.start, "scoring", SearchOptions(), restarts=2
    )
    assert not found.converged
    assert "a time constant of 0.0" in found.doubt
    usual = recorded(replace(TANKER, free=("Y_v",)), 60)
    found = find_best_minimum(
        Likelihood(usual), usual.start, "scoring", SearchOptions(), restarts=2
    )
    assert found.converged


def nomoto_ship(K: float, T1: float) -> KnownShip:
    """Return a second-order ship whose search begins at a stable one."""
    truth = {"K": K, "T1": T1, "T2": 13.4, "T3": 33.4, "R1_2": 1e-11, "R2_r": 1e-4, "R2_psi": 1e-2}
    free = ("K", "T1", "T2", "T3", "R1_2", "R2_r", "R2_psi", "x2_0", "x3_0")
    begin = {"K": -0.2, "T1": 300.0, "T2": 20.0, "T3": 30.0}
    ship, outputs = Ship(244.0, 7.3), ("yaw_rate", "heading")
    return KnownShip("nomoto2", ship, outputs, 2.0, truth, free, begin)


@pytest.mark.parametrize(("K", "T1"), [(0.114, -304.0), (-0.114, 304.0)])
def test_a_search_passes_the_neutral_ship(K: float, T1: float) -> None:
    ship = nomoto_ship(K, T1)
    problem = recorded(ship, 200)
    assert problem.names[:4] == ("a1", "a2", "b1", "b2")
    found = find_best_minimum(Likelihood(problem), ship.start(), "scoring", SearchOptions())
    named = dict(zip(problem.names, found.theta, strict=True))
    assert found.converged
    assert named["b2"] / named["a2"] == pytest.approx(K, rel=0.1)
    assert -named["b2"] == pytest.approx(abs(K) / (abs(T1) * 13.4), rel=0.1)


def test_k_and_t_are_given_together_or_not_at_all() -> None:
    model = MODELS["nomoto2"]
    theta = model.vector(K=-0.05, T1=40.0, T2=5.0, T3=8.0)
    assert_allclose(theta[:4], [0.225, 0.005, -0.002, -0.00025])
    assert model.indices(("T1", "K", "T2", "T3", "lag")) == (0, 1, 2, 3, model.index("lag"))
    with pytest.raises(ConfigError, match="estimates a1, a2, b1, b2, and K follows from them"):
        model.indices(("K",))


def test_restarts_leave_a_shallow_minimum(wells: Any) -> None:
    shallow = find_best_minimum(wells, np.array([0.94]), "bfgs", SearchOptions(200))
    deep = find_best_minimum(wells, np.array([0.94]), "bfgs", SearchOptions(200), restarts=8)
    assert shallow.theta[0] > 0.5
    assert deep.theta[0] == pytest.approx(-1.047, abs=0.01)
    assert deep.cost < shallow.cost


def test_progress_is_told_and_a_search_resumes_where_it_stopped(
    cost: Any, best: Any, tmp_path: Path
) -> None:
    path = tmp_path / "search.json"
    short = find_best_minimum(
        cost, TANKER.start(), "direct", SearchOptions(1, save_steps(path, cost.problem))
    )
    assert not short.converged
    assert_allclose(resume_search(path, cost.problem), short.theta, rtol=1e-15)

    found = find_best_minimum(cost, resume_search(path, cost.problem), "scoring", SearchOptions())
    assert found.converged
    assert found.cost == pytest.approx(best.cost, abs=1e-5)


def test_a_checkpoint_of_something_else_is_refused(cost: Any, tmp_path: Path) -> None:
    path = tmp_path / "search.json"
    save_steps(path, cost.problem)(SearchResult(cost.problem.start, 1.0, 1, converged=False))
    more = TANKER.freed("v2_0").problem(TANKER_RUDDER[:600])
    with pytest.raises(ConfigError, match="lacks v2_0"):
        resume_search(path, more)
    for text in ("{", "[" * 100_000, '{"model": "x", "parameters": 1}'):
        path.write_text(text)
        with pytest.raises(ConfigError, match="no checkpoint"):
            resume_search(path, cost.problem)


@pytest.mark.parametrize("value", ["null", '"x"', "true", "1e999", "NaN"])
def test_a_checkpoint_s_parameter_that_is_no_number_is_refused_by_name(
    cost: Any, tmp_path: Path, value: Any
) -> None:
    path = tmp_path / "search.json"
    save_steps(path, cost.problem)(SearchResult(cost.problem.start, 1.0, 1, converged=False))
    name = cost.problem.names[0]
    told = json.loads(path.read_text())
    told["parameters"][name] = "here"
    path.write_text(json.dumps(told).replace('"here"', value))
    with pytest.raises(ConfigError, match=f"{name} = .*: must be a number"):
        resume_search(path, cost.problem)


@pytest.mark.parametrize(
    ("more", "group"),
    [
        # a shift of the sway velocity
        (("v1_0",), {"Y_0", "N_0", "v1_0", "x1_0"}),
        # no stern log is read
        (("v2_0",), {"v2_0"}),
        # rows may be mixed at will
        (
            ("m11", "m12", "m21", "m22"),
            {"m11", "m12", "m21", "m22", "Y_v", "Y_r", "N_v", "N_r", "Y_delta", "l_delta"},
        ),
        (("P33",), {"x3_0", "P33"}),
    ],
)
def test_what_cannot_be_told_apart_is_named_before_fitting(more: Any, group: Any) -> None:
    problem = recorded(TANKER.freed(*more, **({"P33": 1e-3} if "P33" in more else {})), 300)
    found = inseparable(problem)
    assert len(found) == 1
    assert group <= set(found[0])
    assert len(group) > 8 or group == set(found[0])


def test_without_a_heading_the_bias_of_the_rate_is_not_told_apart() -> None:
    free = tuple(n for n in TANKER.free if n not in ("R2_psi", "x3_0"))
    blind = replace(TANKER, outputs=("sway", "yaw_rate"), free=free)
    ((*names,),) = inseparable(recorded(blind, 300))
    assert {"Y_0", "N_0", "r_0"} <= set(names)


@pytest.mark.parametrize(
    ("kind", "outputs", "truth", "group"),
    [
        ("2", ("sway",), {"a1": 2.0, "a2": 1.0, "c1": 0.4, "c2": 1.0}, ("f1", "x2_0")),
        (
            "2",
            ("sway",),
            {"a1": 2.0, "a2": 1.0, "c1": 0.4, "c2": 1.0},
            ("f2", "v_0", "x1_0", "x2_0"),
        ),
        ("3", ("yaw_rate",), {"a1": 2.0, "a2": 1.0, "b1": -1.0, "b2": -0.9}, ("f2", "x1_0")),
    ],
)
def test_flat_directions_of_the_other_models_are_found(
    kind: Any, outputs: Any, truth: Any, group: Any
) -> None:
    noise = {"R1_1": 1e-8, "R1_2": 1e-9, "R2_v": 0.01, "R2_r": 1e-4}
    names = MODELS[kind].names
    truth = truth | {name: value for name, value in noise.items() if name in names}
    free = (*(n for n in truth if n[0] in "abc"), *group)
    free = tuple(name for name in names if name in free)
    rehearsal = KnownShip(kind, Ship(160.0, 4.5), outputs, 6.0, truth, free, {})
    problem = rehearsal.problem(TANKER_RUDDER[:300])
    assert inseparable(problem) == (tuple(name for name in problem.names if name in group),)


def test_a_good_question_has_nothing_to_name(cost: Any) -> None:
    assert inseparable(cost.problem) == ()


def test_the_eigenvalues_of_a_flat_direction_are_reported() -> None:
    curvature = np.array([[4.0, 2.0, 0.0], [2.0, 1.0, 0.0], [0.0, 0.0, 9.0]])
    known = uncertainty(("a", "b", "c"), curvature)
    assert known.eigenvalues == pytest.approx([0.0, 1.0, 2.0], abs=1e-12)
    assert known.flat == (("a", "b"),)
    assert np.isnan(known.covariance).all()


def test_deviations_by_hand() -> None:
    known = uncertainty(("a", "b"), np.linalg.inv([[4.0, 3.0], [3.0, 9.0]]))  # type: ignore[arg-type]
    assert known.deviations == pytest.approx([2.0, 3.0])
    assert known.flat == ()


def test_intervals_of_variances_are_by_the_logarithm_and_of_sure_coefficients_by_both() -> None:
    free = ("a1", "c1", "f2", "R1_1", "R2_v")
    truth = {"a1": 2.0, "c1": 0.2, "R1_1": 1e-4, "R2_v": 0.01}
    sway = KnownShip("2", Ship(160.93, 4.5), ("sway",), 6.0, truth, free, {})
    problem = sway.problem(np.zeros(4))
    # a1 is known to a quarter, c1 not even by its sign, R1_1 to two thirds, R2_v is lost
    theta = np.array([2.0, -0.2, 1.0, 1e-4, 0.01])
    found = intervals(problem, theta, np.array([0.5, 0.3, 1.0, 1e-4 / 1.5, np.nan]))
    assert found[0] == pytest.approx([2.0 - 0.979982, 2.0 * 1.63230], rel=1e-5)  # exp(1.96/4)
    assert found[1] == pytest.approx([-0.2 - 0.587989, -0.2 + 0.587989], rel=1e-5)
    assert found[2] == pytest.approx([1.0 - 1.959964, 1.0 + 1.959964], rel=1e-5)
    assert found[3] == pytest.approx([1e-4 / 3.69375, 1e-4 * 3.69375], rel=1e-5)  # exp(1.96/1.5)
    assert np.isnan(found[4]).all()
    assert np.isfinite(intervals(problem, theta, np.full(5, 1e300))).all()
    # a variance less than its deviation begins at nothing, whatever its sign in the search
    near_nothing = intervals(problem, -theta, np.array([0.5, 0.3, 1.0, 2e-4, 0.01]))
    assert near_nothing[3] == pytest.approx([0.0, 1e-4 + 1.959964 * 2e-4], rel=1e-5)
    # a coefficient below zero has its ends in order
    below = intervals(problem, -theta, np.full(5, 0.05))[0]
    assert below[0] < -2.0 < below[1] < 0.0


def test_a_free_variance_that_starts_at_nothing_is_refused(cost: Any) -> None:
    start = TANKER.start()
    start[TANKER.free.index("R2_r")] = 0.0
    with pytest.raises(ConfigError, match="R2_r: a free variance cannot start at 0"):
        find_best_minimum(cost, start, "scoring", SearchOptions())


def test_a_start_that_is_no_model_is_refused() -> None:
    hopeless = recorded(TANKER, 50)
    values = hopeless.values.copy()
    values[MODELS["1"].index("P12")] = 1.0
    hopeless = Likelihood(replace(hopeless, values=values))
    with pytest.raises(ConfigError, match="start values are no model"):
        find_best_minimum(hopeless, TANKER.start(), "scoring", SearchOptions())


def test_runs_are_their_seeds_own() -> None:
    problem = TANKER.problem(TANKER_RUDDER[:300])
    begin = replace(problem, values=problem.whole(TANKER.start()))
    one = study(begin, problem.start, range(2), lambda runs: runs)
    other = study(begin, problem.start, range(1, 2), lambda runs: runs)
    assert_allclose(one.runs[1].theta, other.runs[0].theta, rtol=0.0, atol=0.0)
    assert one.names == TANKER.free
    assert 0.5 < one.pooled <= 1.0


def test_angles_and_variances_that_mean_the_same_are_folded_together() -> None:
    problem = recorded(TANKER, 50)
    theta = problem.start
    same = theta.copy()
    for name, value in (("lag", np.pi - 0.3), ("R1_YN", np.pi - 0.3), ("R2_r", -1e-4)):
        same[problem.names.index(name)] = value
    assert_allclose(problem.folded(same), theta, rtol=1e-12)
    cost = Likelihood(problem)
    assert cost.value(same) == pytest.approx(cost.value(theta), rel=1e-12)


def test_nobody_need_listen(best: Any) -> None:
    assert ignore_news(best) is None  # type: ignore[func-returns-value]

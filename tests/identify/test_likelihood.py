"""Likelihood, gradient and information of a record, and the losses of other predictors."""

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from cases.reference_ships import TANKER, TANKER_RUDDER
from helpers.differences import fourth_order
from helpers.lanes import sample_cases
from numpy.testing import assert_allclose

from trainer.config.files import ConfigError
from trainer.identify.fitting.likelihood import (
    Innovations,
    Likelihood,
    MultiStep,
    _concentrate,
    chi_square_limits,
    loss_1,
    no_gain,
    no_limits,
    run_filter,
    settle_filter,
    settled_gain,
)
from trainer.identify.judge.validation import draw_outputs, simulate_deterministic
from trainer.identify.record.measurements import Samples

PERIOD = TANKER.period


def question(count: Any, missing: Any = 0.0) -> Any:
    return TANKER.problem(TANKER_RUDDER[:count], missing)


def recorded(problem: Any, seed: Any = 1) -> Any:
    return problem.on(draw_outputs(problem, problem.start, np.random.default_rng(seed)))


def plainly(problem: Any) -> Any:
    """Return -log L by the document's filter, a line an equation: 6.1 with Cholesky's factor."""
    sampled = problem.sampled(problem.start)
    mean, noise, start = sampled.at(0)
    x, P, states = start[:, 0].copy(), start[:, 1:].copy(), len(start)
    cost = 0.0
    for row, which in zip(problem.samples.table, problem.samples.steps[1], strict=True):
        W, Q = mean[which], noise[which]
        there = np.flatnonzero(~np.isnan(row[: len(W) - states]))
        w = np.array([*row[len(W) - states :], 1.0])
        C = W[states:][there, :states]
        error = row[there] - C @ x - W[states:][there, states:] @ w
        R = C @ P @ C.T + Q[states:, states:][np.ix_(there, there)]
        K = (W[:states, :states] @ P @ C.T + Q[:states, states:][:, there]) @ np.linalg.inv(R)
        cost += 0.5 * (np.linalg.slogdet(R)[1] + error @ np.linalg.solve(R, error))
        cost += 0.5 * len(there) * math.log(2.0 * math.pi)
        x = W[:states, :states] @ x + W[:states, states:] @ w + K @ error
        A = W[:states, :states]
        P = A @ P @ A.T + Q[:states, :states] - K @ R @ K.T
    return cost


def varied() -> Any:
    samples = question(300).samples
    jitter = np.random.default_rng(2).uniform(0.5, 1.5, 300)
    return question(300).on(Samples(np.cumsum(jitter) * PERIOD, samples.outputs, samples.inputs))


def with_a_gap() -> Any:
    samples = question(300).samples
    gap = np.delete(np.arange(300), slice(100, 117))
    return question(300).on(Samples(samples.t[gap], samples.outputs[gap], samples.inputs[gap]))


def started() -> Any:
    variances = {"P11": 0.02, "P22": 1e-6, "P33": 1e-3, "P12": 1e-5, "P13": 0.0, "P23": 0.0}
    wind = {"Y_psi": 2e-3, "l_psi": 0.3}
    return TANKER.freed(*variances, *wind, **variances, **wind).problem(TANKER_RUDDER[:300])


def settled_from_the_first() -> Any:
    problem = question(300)
    sampled = problem.sampled(problem.start).as_complex()
    settled = settle_filter(sampled.mean[:, 0], sampled.noise[:, 0], sampled.start[..., 1:])
    assert settled is not None
    steady = settled[0][0]
    P = {f"P{i + 1}{j + 1}": steady[i, j].real for i, j in ((0, 0), (1, 1), (2, 2))}
    P |= {f"P{i + 1}{j + 1}": steady[i, j].real for i, j in ((0, 1), (0, 2), (1, 2))}
    return TANKER.freed(**P).problem(TANKER_RUDDER[:300])


def of_four_outputs() -> Any:
    logs = replace(TANKER, outputs=("bow_sway", "stern_sway", "yaw_rate", "heading"))
    four = logs.freed("R2_v2", "v2_0", R2_v2=0.02, v2_0=0.1)
    return four.problem(TANKER_RUDDER[:200])


CASES: dict[str, Any] = {  # problems of every kind that the filter treats in its own way
    "whole": lambda: question(400),
    "missing": lambda: question(400, missing=0.1),
    "varied": varied,
    "gap": with_a_gap,
    "summed": lambda: replace(question(300), sampling="integrating"),
    "started": started,
    "settled from the first": settled_from_the_first,
    "four": of_four_outputs,
}


@cache
def case(name: str) -> Any:
    """Return a problem with a record of its own ship."""
    return recorded(CASES[name]())


@pytest.mark.parametrize("name", CASES)
def test_the_likelihood_is_that_of_the_filter_written_out(name: Any) -> None:
    problem = case(name)
    assert Likelihood(problem).value(problem.start) == pytest.approx(plainly(problem), rel=1e-11)


@pytest.mark.parametrize("name", CASES)
def test_the_gradient_is_exact(name: Any) -> None:
    assert_slope(Likelihood(case(name)), case(name).start)


def assert_slope(cost: Any, theta: Any, share: Any = 1e-3) -> None:
    """Check value and gradient by differences with an error of order step^4."""
    value, slope = cost.slope(theta)
    steps = share * np.maximum(np.abs(theta), 1e-6)
    expected = fourth_order(cost.value, theta, steps)
    # where a slope is next to nothing, the differences' own rounding
    rounding = 1e-13 * abs(value) / steps
    assert value == pytest.approx(cost.value(theta), rel=1e-12)
    assert np.all(np.abs(slope - expected) <= 1e-6 * np.abs(expected) + 3.0 * rounding)


def stepped(problem: Any, place: Any) -> Any:
    """Return errors (n, y), R (n, y, y) and -log L with an imaginary step in a parameter."""
    sampled = problem.sloped(problem.start)
    mean, noise, start = (part[1 + place] for part in (sampled.mean, sampled.noise, sampled.start))
    states, x, P = len(start), start[:, 0], start[:, 1:]
    errors, spreads, cost = [], [], 0j
    for row, which in zip(problem.samples.table, problem.samples.steps[1], strict=True):
        W, Q = mean[which], noise[which]
        w = np.array([*row[len(W) - states :], 1.0])
        A, C = W[:states, :states], W[states:, :states]
        error = row[: len(W) - states] - C @ x - W[states:, states:] @ w
        R = C @ P @ C.T + Q[states:, states:]
        K = (A @ P @ C.T + Q[:states, states:]) @ np.linalg.inv(R)
        cost += 0.5 * (np.log(np.linalg.det(R)) + error @ np.linalg.solve(R, error))
        errors.append(error)
        spreads.append(R)
        x = A @ x + W[:states, states:] @ w + K @ error
        P = A @ P @ A.T + Q[:states, :states] - K @ R @ K.T
    return np.array(errors), np.array(spreads), cost


@pytest.mark.long
@pytest.mark.parametrize(
    "name",
    sample_cases(
        ["whole", "varied", "summed", "started", "settled from the first"], "whole", "varied"
    ),
)
def test_gradient_and_information_are_those_of_an_imaginary_step(name: Any) -> None:
    problem = case(name)
    runs = [stepped(problem, place) for place in range(len(problem.free))]
    inverse = np.linalg.inv(runs[0][1].real)
    e = np.array([run[0].imag for run in runs]) / 1e-100
    R = np.array([inverse @ run[1].imag for run in runs]) / 1e-100
    information = np.einsum("ika,kab,jkb->ij", e, inverse, e)
    information += 0.5 * np.einsum("ikab,jkba->ij", R, R)
    width = np.sqrt(np.diag(information))
    found = Likelihood(problem).information(problem.start)

    assert_allclose(
        Likelihood(problem).slope(problem.start)[1],
        [run[2].imag / 1e-100 for run in runs],
        rtol=1e-6,
    )
    assert np.max(np.abs(found - information) / np.outer(width, width)) < 1e-7


def test_the_likelihood_is_that_of_statsmodels() -> None:
    kalman = pytest.importorskip("statsmodels.tsa.statespace.kalman_filter")
    problem = case("missing")
    mean, noise, start = problem.sampled(problem.start).at(0)
    y, u = problem.samples.outputs, problem.samples.table[:, 3:]
    inputs = np.hstack([u, np.ones((len(u), 1))])
    model = kalman.KalmanFilter(k_endog=3, k_states=3, k_posdef=3)
    model.bind(y.copy())
    model["design"], model["transition"] = mean[0, 3:, :3], mean[0, :3, :3]
    model["obs_cov"], model["state_cov"] = noise[0, 3:, 3:], noise[0, :3, :3]
    model["selection"] = np.eye(3)
    model["obs_intercept"] = mean[0, 3:, 3:] @ inputs.T
    model["state_intercept"] = mean[0, :3, 3:] @ inputs.T
    model.initialize_known(start[:, 0], start[:, 1:])

    assert Likelihood(problem).value(problem.start) == pytest.approx(-model.loglike(), rel=1e-9)


@pytest.mark.parametrize(("gains", "share"), [(no_gain, 3e-5), (settled_gain, 1e-3)])
def test_predictors_with_a_gain_have_exact_gradients(gains: Any, share: Any) -> None:
    problem = recorded(question(300))
    assert_slope(Innovations(problem, gains), problem.start, share)


def test_the_settled_gain_is_the_filters_own_after_a_while() -> None:
    problem = recorded(question(400))
    errors = Innovations(problem, settled_gain).shown(problem.start)[1]
    filtered = run_filter(problem, problem.start, no_limits(3)).errors
    assert_allclose(errors[200:], filtered[200:], rtol=1e-6, atol=1e-9)
    assert not np.allclose(errors[:5], filtered[:5], rtol=1e-6)


def test_an_interval_that_varies_has_no_settled_gain() -> None:
    problem = case("varied")
    with pytest.raises(ConfigError, match="take the covariance form"):
        Innovations(problem, settled_gain).value(problem.start)


def test_one_step_ahead_is_the_likelihood_and_more_steps_are_worse() -> None:
    problem = case("missing")
    one = MultiStep(problem, 1, 1).value(problem.start)
    assert one == pytest.approx(Likelihood(problem).value(problem.start), rel=1e-11)
    assert MultiStep(problem, 4, 8).value(problem.start) > one


def test_predictions_several_steps_ahead_have_exact_gradients() -> None:
    problem = recorded(question(60, missing=0.1))
    assert_slope(MultiStep(problem, 2, 4), problem.start)


def test_a_prediction_uses_only_what_was_known_so_many_samples_before() -> None:
    problem = recorded(question(40))
    three = MultiStep(problem, 3, 3).value(problem.start)
    # errors of three steps by hand: readings of the two samples before each are taken away
    total, count = 0.0, 0
    for m in range(2, 40):
        outputs = problem.samples.outputs[: m + 1].copy()
        outputs[m - 2 : m] = np.nan
        known = run_filter(
            problem.on(
                Samples(problem.samples.t[: m + 1], outputs, problem.samples.inputs[: m + 1])
            ),
            problem.start,
            no_limits(3),
        )
        error, R = known.errors[m], known.spreads[m]
        total += np.linalg.slogdet(R)[1] + error @ np.linalg.solve(R, error)
        count += 1
    expected = 0.5 * (total / count + 3.0 * math.log(2.0 * math.pi)) * 40
    assert three == pytest.approx(expected, rel=1e-10)


def test_the_filter_shown_is_the_one_whose_likelihood_is_minimised() -> None:
    problem = case("missing")
    run = run_filter(problem, problem.start, no_limits(3))
    total = 0.0
    for error, R, size in zip(run.errors, run.spreads, run.squares, strict=True):
        there = ~np.isnan(error)
        total += np.linalg.slogdet(R[np.ix_(there, there)])[1] + size
        total += there.sum() * math.log(2.0 * math.pi)
    assert 0.5 * total == pytest.approx(Likelihood(problem).value(problem.start), rel=1e-11)
    whole = run.errors[~np.isnan(run.errors).any(axis=1)]
    expected = np.linalg.slogdet(whole.T @ whole)[1] / len(whole)
    assert loss_1(run.errors) == pytest.approx(expected)


def test_an_outlier_is_rejected_and_moves_nothing() -> None:
    problem = recorded(question(200))
    outputs = problem.samples.outputs.copy()
    outputs[100, 2] += 5.0
    spoilt = problem.on(replace(problem.samples, outputs=outputs))
    gone = outputs.copy()
    gone[100] = np.nan
    limits = chi_square_limits(1e-6, 3)
    screened = run_filter(spoilt, problem.start, limits)
    without = run_filter(problem.on(replace(problem.samples, outputs=gone)), problem.start, limits)

    assert np.flatnonzero(screened.flags == 2).tolist() == [100]
    assert_allclose(screened.errors[101:], without.errors[101:], rtol=1e-12)
    assert np.count_nonzero(screened.counted) == 199


@pytest.mark.parametrize(
    ("probability", "freedom", "limit"),
    [(0.05, 1, 3.841459), (0.05, 2, 5.991465), (0.01, 3, 11.344867), (0.001, 4, 18.466827)],
)
def test_limits_are_those_of_the_chi_square_table(
    probability: Any, freedom: Any, limit: Any
) -> None:
    assert chi_square_limits(probability, 4)[freedom] == pytest.approx(limit, rel=1e-6)


def test_an_impossible_covariance_costs_infinitely_much() -> None:
    impossible = TANKER.freed(P11=1e-3, P22=1e-6, P12=1.0)
    problem = impossible.problem(TANKER_RUDDER[:50])
    assert Likelihood(problem).value(problem.start) == math.inf


def test_scaled_parameters_have_scaled_slopes() -> None:
    problem = recorded(question(100))
    scaled = replace(problem, scale=np.full(len(TANKER.free), 2.0))
    assert scaled.start == pytest.approx(problem.start / 2.0)
    ours, theirs = Likelihood(scaled), Likelihood(problem)
    assert_allclose(ours.slope(scaled.start)[1], 2.0 * theirs.slope(problem.start)[1], rtol=1e-9)
    assert_allclose(
        ours.information(scaled.start), 4.0 * theirs.information(problem.start), rtol=1e-9
    )


def test_a_model_left_alone_is_its_transfer_function_in_the_long_run() -> None:
    problem = question(2000)
    samples = replace(problem.samples, inputs=np.full((2000, 1), 2.0))
    steady = simulate_deterministic(problem.on(samples), problem.start)[-1]
    drift = problem.plant.blocks(problem.values.astype(complex)[None]).drift[0].real
    rest = np.linalg.solve(drift[:2, :2], -drift[:2, 3] * 2.0 - drift[:2, 4])
    assert steady[:2] == pytest.approx(rest, rel=1e-9)


def test_errors_too_large_to_be_squared_are_no_likelihood() -> None:
    errors = np.array([[1.0, 2.0], [2.0, -1.0], [0.5, 0.25]])
    assert math.isfinite(_concentrate(errors))
    assert _concentrate(1e200 * errors) == math.inf


def test_without_slopes_the_systems_are_real_and_the_same() -> None:
    problem = case("varied")
    plain, sloped = problem.sampled(problem.start), problem.sloped(problem.start)
    for one, other in zip(plain.at(0), sloped.at(0), strict=True):
        assert np.isrealobj(one)
        np.testing.assert_allclose(one, other, rtol=1e-13, atol=1e-16)
    assert np.isrealobj(plain.mean)
    assert np.iscomplexobj(plain.as_complex().mean)

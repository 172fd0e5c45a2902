"""Gains, standard deviations and ARMAX models against scipy and statsmodels."""

from typing import Any

import numpy as np
import pytest
from cases.reference_ships import ISLAND, TANKER, TANKER_RUDDER
from numpy.testing import assert_allclose

from trainer.identify.fitting.armax import Armax, fit_armax
from trainer.identify.fitting.estimate import find_best_minimum
from trainer.identify.fitting.likelihood import Likelihood, settled_gain
from trainer.identify.fitting.minimise import SearchOptions
from trainer.identify.judge.uncertainty import hessian, uncertainty
from trainer.identify.judge.validation import draw_outputs

linalg = pytest.importorskip("scipy.linalg")


@pytest.mark.long
@pytest.mark.parametrize("ship", [TANKER, ISLAND])
def test_the_settled_gain_is_that_of_scipys_riccati_equation(ship: Any) -> None:
    problem = ship.problem(TANKER_RUDDER[:50])
    sampled = problem.sampled(problem.start)
    W, Q = sampled.mean[0, 0].real, sampled.noise[0, 0].real
    A, C = W[:3, :3], W[3:, :3]
    P = linalg.solve_discrete_are(A.T, C.T, Q[:3, :3], Q[3:, 3:], s=Q[:3, 3:])
    K = (A @ P @ C.T + Q[:3, 3:]) @ np.linalg.inv(C @ P @ C.T + Q[3:, 3:])
    assert_allclose(settled_gain(problem, sampled)[0].real, K, rtol=1e-8, atol=1e-12)  # type: ignore[index]


@pytest.mark.long
def test_standard_deviations_are_those_of_the_likelihoods_own_curvature() -> Any:
    # second differences of the value itself, no gradient of ours in them
    problem = TANKER.problem(TANKER_RUDDER[:600])
    problem = problem.on(draw_outputs(problem, problem.start, np.random.default_rng(2)))
    cost = Likelihood(problem)
    theta = find_best_minimum(cost, TANKER.start(), "scoring", SearchOptions()).theta
    found = hessian(cost, theta)
    steps = 0.02 / np.sqrt(np.diag(found))
    place = np.diag(steps)

    def value(*moves: Any) -> Any:
        return cost.value(theta + sum(moves, np.zeros(len(theta))))

    n, H = len(theta), np.empty_like(found)
    for i in range(n):
        for j in range(i + 1):
            a, b = place[i], place[j]
            four = value(a, b) - value(a, -b) - value(-a, b) + value(-a, -b)
            H[i, j] = H[j, i] = four / (4.0 * steps[i] * steps[j])
    ours = uncertainty(problem.names, found).deviations
    theirs = np.sqrt(np.diag(np.linalg.inv(H)))
    # steps of 0.02 deviations leave an error of their square, and rounding of 1e-11 / 0.0016
    assert_allclose(ours, theirs, rtol=3e-3)


@pytest.mark.slow
def test_an_armax_model_has_the_loss_and_deviations_of_statsmodels() -> None:
    tsa = pytest.importorskip("statsmodels.tsa.statespace.sarimax")
    stream = np.random.default_rng(4)
    u = np.repeat(stream.choice([-1.0, 1.0], 400), 5)
    truth = Armax((-1.5, 0.6), (0.3, 0.2), (-0.4, 0.1), ())
    y = truth.simulated(u, 0.1 * stream.standard_normal(2000))
    ours = fit_armax(y, u, 2, initial=False)
    # A y = B u + C e has its inputs inside the recursion: lagged y and u as regressors, C as MA
    before = np.column_stack([-y[1:-1], -y[:-2], u[1:-1], u[:-2]])
    model = tsa.SARIMAX(y[2:], exog=before, order=(0, 0, 2))
    start = [*ours.model.a, *ours.model.b, *ours.model.c, ours.deviation**2]
    theirs = model.fit(start_params=start, disp=0)
    found = [*ours.model.a, *ours.model.b, *ours.model.c]
    # they begin two samples later, from the stationary errors
    assert_allclose(theirs.params[:6], found, atol=0.1 * np.max(theirs.bse[:6]))
    assert_allclose(theirs.bse[:6], ours.deviations[:6], rtol=0.1)
    assert theirs.params[6] == pytest.approx(ours.deviation**2, rel=0.01)

"""The likelihood of a problem by statsmodels, and what a fit by its minimiser asks for."""

import warnings
from collections.abc import Callable
from typing import Any, Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.likelihood import Likelihood
from trainer.identify.minimise import stretched
from trainer.identify.problem import Problem
from trainer.identify.simulate import deterministic

Value = Callable[[], float]

MOST: Final = 200  # steps of its minimiser


def filters() -> Any:
    """Return statsmodels' module of Kalman filters; ImportError where it is not installed."""
    from statsmodels.tsa.statespace import kalman_filter  # noqa: PLC0415  slow, and optional

    return kalman_filter


def by_statsmodels(kalman: Any, problem: Problem, theta: Numbers) -> Value:
    """Return minus the log-likelihood as ``kalman``, statsmodels' filter, has it, one interval.

    It is asked in the way that it is quickest in: what the rudder and the start do is taken off
    before, so that its system does not change from sample to sample and its gain may settle.
    """
    outputs = problem.samples.outputs
    states, readings = problem.plant.model.states, outputs.shape[1]
    model = kalman.KalmanFilter(k_endog=readings, k_states=states, k_posdef=states)
    model["selection"] = np.eye(states)
    unmoved = np.zeros(states)

    def value() -> float:
        mean, noise, start = problem.sampled(theta).at(0)
        model["transition"], model["design"] = mean[0, :states, :states], mean[0, states:, :states]
        model["state_cov"] = noise[0, :states, :states]
        model["obs_cov"] = noise[0, states:, states:]
        left = outputs - deterministic(problem, theta)[:, states:]
        model.bind(np.ascontiguousarray(left))
        model.initialize_known(unmoved, start[:, 1:])
        return -float(model.loglike())

    return value


def likelihoods_of_a_fit(cost: Likelihood, theta: Numbers) -> int:
    """Return how many likelihoods statsmodels' minimiser, scipy's BFGS by differences, asks for.

    It is given parameters without bounds, as statsmodels' own models give it; ours are counted,
    which have the same values.
    """
    from scipy.optimize import minimize  # noqa: PLC0415  optional

    problem = stretched(cost, theta)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # differences between impossible models
        found = minimize(
            lambda eta: cost.value(problem.theta(eta)),
            np.zeros(len(theta)),
            method="BFGS",
            options={"maxiter": MOST},
        )
    return int(found.nfev)

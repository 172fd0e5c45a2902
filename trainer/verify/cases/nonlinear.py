"""S10: a hull whose yaw moment weakens with drift, under a linear model.

The report blamed such terms for what its large zig-zags gave: N_v underestimated, and the more so
the larger the helm.
"""

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from trainer.core.kernel import Numbers
from trainer.identify.estimate import estimate
from trainer.identify.measurements import Samples
from trainer.identify.minimise import Search
from trainer.identify.monte_carlo import Rehearsal
from trainer.identify.prediction_error import Innovations, no_gain
from trainer.identify.problem import Problem
from trainer.identify.sampled import aside
from trainer.units import DEGREE, KNOT
from trainer.verify.cases.reference_ships import STATE, TANKER, TANKER_SHIP
from trainer.verify.cases.ships import Figure

WEAKENED: Final = 4.0  # [-] N_v of |v|/V: at a drift of 0.1 the moment is 0.6 of the line's
COUNT, PARTS = 300, 10  # samples, and steps of Runge and Kutta in each
TRUTH: Final = {**TANKER_SHIP, "R2_v1": 1e-4, "R2_r": 1e-6, "R2_psi": 1e-4}
FREE: Final = ("Y_v", "Y_r", "N_v", "N_r", "Y_delta", "l_delta", "Y_0", "N_0", *STATE)
HULL: Final = Rehearsal("1", TANKER.ship, TANKER.outputs, TANKER.period, TRUTH, FREE, {})


def zig_zag(problem: Problem, angle: float) -> tuple[Numbers, Numbers]:
    """Return rudder (n,) [deg] and readings (n, 3). The bent hull makes a zig-zag angle/angle."""
    values = problem.whole(problem.start)
    drift = problem.plant.blocks(aside(values, ())).drift[0].real[:3]
    place = problem.plant.model.place("N_v")
    # what a unit of N_v does to the rates, by sway
    by_moment = problem.plant.blocks(aside(values, (place,))).drift[1].imag[:3, 0] * 1e100
    weakening = -WEAKENED * values[place] * by_moment / problem.plant.ship.speed

    def rates(s: Numbers, helm: float) -> Numbers:
        straight = drift @ np.array([*s, helm, 1.0])
        return np.asarray(straight + weakening * abs(s[0]) * s[0])

    state, side = np.zeros(3), 1.0
    rudder, motion = np.empty(COUNT), np.empty((COUNT, 3))
    h = problem.plant.period / PARTS
    for k in range(COUNT):
        motion[k] = state
        if -side * state[2] / DEGREE >= angle:
            side = -side
        rudder[k] = side * angle
        for _ in range(PARTS):
            middle = state + 0.5 * h * rates(state, rudder[k])
            state = state + h * rates(middle, rudder[k])
    return rudder, motion * np.array([1.0 / KNOT, 1.0 / DEGREE, 1.0 / DEGREE])


def bent_hull() -> Iterator[Figure]:
    """Yield S10: the linear fit has too small an N_v, smallest at the largest helm."""
    true = HULL.truth["N_v"]
    found = {}
    for angle in (5.0, 10.0, 20.0):
        problem = HULL.problem(np.zeros(COUNT))
        rudder, readings = zig_zag(problem, angle)
        samples = Samples(problem.samples.t, readings, rudder[:, None])
        fit = estimate(
            Innovations(problem.on(samples), no_gain), problem.start, "scoring", Search(300)
        )
        found[angle] = float(fit.theta[problem.names.index("N_v")]) / true
    yield Figure("S10", "N_v by 10/10, of the true", 0.0, found[10.0], 0.95)
    yield Figure("S10", "N_v by 20/20, of that by 10/10", 0.0, found[20.0] / found[10.0], 0.95)
    yield Figure("S10", "N_v by 5/5, of the true", -math.inf, found[5.0], math.inf)

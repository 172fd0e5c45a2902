"""S11: sway velocity and the ship from Decca lanes, smoothed by Spencer or not.

The report found both equally good. Here they are not: 15 points over 75 s take away what a sequence
of one-minute bits puts into sway, and not what it puts into yaw.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from cases.reference_ships import SHIP_DERIVATIVES, TANKER, sequence
from cases.ships import Figure
from trainer.core.kernel import Numbers
from trainer.identify.fitting.estimate import find_best_minimum
from trainer.identify.fitting.likelihood import Likelihood
from trainer.identify.fitting.minimise import SearchOptions
from trainer.identify.fitting.problem import Problem
from trainer.identify.judge.uncertainty import beside_bounds, uncertainty
from trainer.identify.judge.validation import draw_outputs
from trainer.identify.model.derived import nomoto_of
from trainer.identify.pages.decca import Point, Slave, lane_at, track
from trainer.identify.record.measurements import Samples
from trainer.identify.record.track import derivative, resolve_along, smooth_spencer
from trainer.units import KNOT

CHAIN: Final = {"red": Slave(Point(-60e3, 20e3), 440.0), "green": Slave(Point(40e3, 70e3), 590.0)}
START: Final = Point(-10e3, 50e3)
LANES: Final = 0.01  # [lanes] error of a reading
RATE, HEADING = 0.01, 0.1  # [deg/s], [deg] errors of gyro and compass
FINE: Final = 10  # parts of an interval that the track is summed in
COUNT, BIT, HELM = 1200, 60.0, 5.0  # [samples], [s], [deg]
EXACT: Final = 1e-14  # variance of readings that are the state itself
STILL: Final = ("lag", "x1_0", "x2_0", "x3_0", "Y_0", "N_0", "r_0")


class Voyage(NamedTuple):
    """The run that was sailed: grid track [m], heading and yaw rate as read.

    Those are in [deg], [deg/s].
    """

    east: Numbers
    north: Numbers
    heading: Numbers
    rate: Numbers
    rudder: Numbers  # [deg]


def voyage(seed: int) -> Voyage:
    """Return a voyage of the tanker in disturbed water, fixed by lanes with errors."""
    stream = np.random.Generator(np.random.PCG64(seed))
    readings = dict.fromkeys(("R2_v1", "R2_r", "R2_psi"), EXACT)
    truth = {**TANKER.truth, **dict.fromkeys(STILL, 0.0), **readings}
    rudder = sequence(COUNT, BIT, HELM, TANKER.period)
    step = TANKER.period / FINE
    problem = replace(TANKER, period=step, truth=truth).problem(np.repeat(rudder, FINE))
    sway, rate, heading = draw_outputs(problem, problem.start, stream).outputs.T
    psi, v, u = np.radians(heading), sway * KNOT, TANKER.ship.speed
    east = _integrate(u * np.sin(psi) + v * np.cos(psi), step)
    north = _integrate(u * np.cos(psi) - v * np.sin(psi), step)
    places = [Point(START.x + e, START.y + n) for e, n in zip(east, north, strict=True)][::FINE]
    lanes = [
        {c: lane_at(slave, at) + LANES * stream.standard_normal() for c, slave in CHAIN.items()}
        for at in places
    ]
    found_east, found_north = np.array([fix.location for fix in track(CHAIN, lanes, START)]).T
    return Voyage(
        found_east,
        found_north,
        heading[::FINE] + HEADING * stream.standard_normal(COUNT),
        rate[::FINE] + RATE * stream.standard_normal(COUNT),
        rudder,
    )


def _integrate(rate: Numbers, step: float) -> Numbers:
    """Return the integral of a rate from its first value on, by trapezia."""
    return np.concatenate([[0.0], np.cumsum(0.5 * step * (rate[1:] + rate[:-1]))])


def fit_model(sailed: Voyage, *, smooth: bool) -> tuple[Problem, Numbers, Numbers]:
    """Return Model 1 fitted to a voyage: the problem, the estimate, its deviations."""
    x0, y0 = resolve_along(sailed.east, sailed.north, 0.0)
    if smooth:
        x0, y0 = smooth_spencer(x0), smooth_spencer(y0)
    v_x, v_y = (derivative(one, TANKER.period) for one in (x0, y0))
    sway = resolve_along(v_y, v_x, np.radians(sailed.heading))[1] / KNOT
    free = tuple(name for name in TANKER.free if name != "lag")
    truth = {**TANKER.truth, "lag": 0.0}
    # neighbours differ by the error alone
    known = sway[~np.isnan(sway)]
    begin = {**TANKER.begin, "R2_v1": float(np.var(np.diff(known, 3))) / 20.0}
    rehearsal = replace(TANKER, free=free, truth=truth, begin=begin)
    problem = rehearsal.problem(sailed.rudder)
    outputs = np.column_stack([sway, sailed.rate, sailed.heading])
    problem = problem.on(Samples(problem.samples.t, outputs, problem.samples.inputs))
    cost = Likelihood(problem)
    theta = find_best_minimum(cost, rehearsal.start(), "scoring", SearchOptions()).theta
    known_to = beside_bounds(uncertainty(problem.names, cost.information(theta)))
    return problem, theta, known_to.deviations


def by_lanes(records: int = 5) -> Iterator[Figure]:
    """Yield S11: the ship by lanes, and by how much smoothing shifts it."""
    numbers, shifts = [], []
    time = TANKER.ship.length / TANKER.ship.speed
    for seed in range(records):
        sailed = voyage(seed)
        problem, theta, deviations = fit_model(sailed, smooth=False)
        other = fit_model(sailed, smooth=True)[1]
        forms = [
            nomoto_of(problem.plant.model, problem.whole(x), TANKER.ship) for x in (theta, other)
        ]
        numbers.append([(f.K * time, f.T1.real / time) for f in forms])
        places = [problem.names.index(name) for name in SHIP_DERIVATIVES]
        shifts.append(np.median(np.abs(other - theta)[places] / deviations[places]))
    (gain, slow), (gain_smoothed, slow_smoothed) = np.median(numbers, axis=0)
    yield Figure("S11", "K' by lanes as they are", -1.75, float(gain), -1.50)
    yield Figure("S11", "T1' by lanes as they are", 3.3, float(slow), 4.4)
    # reported, not judged
    yield Figure("S11", "K' smoothed", -math.inf, float(gain_smoothed), math.inf)
    yield Figure("S11", "T1' smoothed", -math.inf, float(slow_smoothed), math.inf)
    yield Figure("S11", "shift by smoothing, std devs", 0.0, float(np.median(shifts)), math.inf)

"""The report's ships simulated, identified by maximum likelihood, and held against known ranges.

Each proof yields figures: the test's name, what was measured, lowest, value, highest. A range is
where the middle of many records must lie. Errors and disturbances that the tables do not have
legibly are of our choice.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from cases.reference_ships import (
    ISLAND,
    STATE,
    TANKER,
    TANKER_BEGIN,
    TANKER_RUDDER,
    TANKER_SHIP,
    sequence,
    study,
    zigzag_rudder,
)
from trainer.core.kernel import Numbers
from trainer.identify.fitting.estimate import find_best_minimum
from trainer.identify.fitting.likelihood import Innovations, Likelihood, no_gain
from trainer.identify.fitting.minimise import SearchOptions
from trainer.identify.fitting.nonlinear import BentShip
from trainer.identify.fitting.problem import Problem
from trainer.identify.judge import uncertainty as uncertainty_module
from trainer.identify.judge.uncertainty import (
    beside_bounds,
    draw_parameters,
    span_draws,
    uncertainty,
)
from trainer.identify.judge.validation import draw_outputs, simulate_deterministic
from trainer.identify.kernels.nonlinear_steering import run_bent
from trainer.identify.model.derived import nomoto_of
from trainer.identify.model.models import Ship
from trainer.identify.model.sampled import step_aside
from trainer.identify.monte_carlo import KnownShip
from trainer.identify.record.measurements import Samples
from trainer.units import DEGREE, KNOT

if TYPE_CHECKING:
    from numpy.typing import NDArray


RECORDS: Final = 40
COVERED: Final = 200
SWAY_RECORDS: Final = 60  # a share of 0.9 is then known to 0.04
SWAY_NUMBERS: Final = ("K_v", "T1", "T2", "T1 + T2")
DRAW_COUNT: Final = 1000  # draws of an interval: its ends are then known to 5 % of its width


class Figure(NamedTuple):
    """A measured number and where it must lie."""

    test: str
    quantity: str
    low: float
    value: float
    high: float


Ranges = dict[str, tuple[float, float]]
Change = Callable[[Samples], Samples]


def _fit_records(
    rehearsal: KnownShip, rudder: Numbers, records: int, change: Change = lambda samples: samples
) -> list[tuple[Problem, Numbers]]:
    """Return problem and estimate (f,) of each of so many simulated records."""
    problem, found = rehearsal.problem(rudder), []
    for seed in range(records):
        stream = np.random.Generator(np.random.PCG64(seed))
        one = problem.on(change(draw_outputs(problem, problem.start, stream)))
        theta = find_best_minimum(
            Likelihood(one), rehearsal.start(), "scoring", SearchOptions()
        ).theta
        found.append((one, theta))
    return found


def _prime(problem: Problem, theta: Numbers) -> dict[str, float]:
    """Return gains and time constants in prime units, lag in s, and the parameters by name."""
    plant = problem.plant
    ship, time = plant.ship, plant.ship.length / plant.ship.speed
    f = nomoto_of(plant.model, problem.whole(theta), ship)
    named = dict(zip(problem.names, map(float, theta), strict=True))
    return {
        **named,
        "K'": f.K * time,
        "T1'": f.T1.real / time,
        "T2'": f.T2.real / time,
        "T3'": f.T3 / time,
        "tau": plant.period * abs(math.sin(named.get("lag", 0.0))),
    }


def _middles(test: str, found: list[dict[str, float]], ranges: Ranges) -> Iterator[Figure]:
    """Yield the median of each quantity that has a range."""
    for name, (low, high) in ranges.items():
        middle = float(np.median([one[name] for one in found]))
        yield Figure(test, f"median {name}", low, middle, high)


def heading_only(records: int = RECORDS) -> Iterator[Figure]:
    """Yield S2: Atlantic Song by first-order Model 3 from headings read to a degree."""
    ship = Ship(197.0, 18.5 * KNOT)
    k = ship.speed / ship.length
    a1 = 1.0 / (k * 29.36)
    truth = {"a1": a1, "b1": -0.0743 * a1 / k, "R1_2": 3e-8, "R2_psi": 0.1}
    truth["lag"] = math.asin(12.1 / 15.0)
    begin = {"a1": 0.7 * a1, "b1": 0.7 * truth["b1"], "lag": 0.5, "R1_2": 1e-7, "R2_psi": 0.2}
    free = ("a1", "b1", "f2", "R1_2", "R2_psi", "x2_0", "x3_0", "lag")
    song = KnownShip("3", ship, ("heading",), 15.0, truth, free, begin)

    def read(samples: Samples) -> Samples:
        return replace(samples, outputs=np.round(samples.outputs))

    found = []
    for problem, theta in _fit_records(song, sequence(80, 60.0, 5.0, 15.0), records, read):
        one = _prime(problem, theta)
        found.append({"K": k * one["b1"] / one["a1"], "T_s": 1.0 / (k * one["a1"])} | one)
    ranges = {"K": (-0.087, -0.072), "T_s": (26.7, 35.1), "tau": (10.7, 13.2)}
    yield from _middles("S2", found, ranges)


def rate_only(records: int = RECORDS) -> Iterator[Figure]:
    """Yield S4: Bore I by a second-order model from the yaw rate. It has 900 samples at 1 s."""
    truth = {"K": -0.07, "T1": 23.6, "T2": 2.4, "T3": 4.2, "R1_2": 1e-9, "R2_r": 9e-4, "lag": 0.3}
    begin = {"K": -0.05, "T1": 20.0, "T2": 4.0, "T3": 6.0, "R2_r": 2e-3, "lag": 0.1}
    free = ("a1", "a2", "b1", "b2", "delta_0", "R1_2", "R2_r", "x1_0", "x2_0", "lag")
    ship = Ship(115.7, 18.0 * KNOT)
    bore = KnownShip("nomoto2", ship, ("yaw_rate",), 1.0, truth, free, begin)
    found = []
    for problem, theta in _fit_records(bore, sequence(900, 7.0, 5.0, 1.0), records):
        f = nomoto_of(problem.plant.model, problem.whole(theta), ship)
        found.append({"K": f.K, "T1": f.T1.real, "T2": f.T2.real, "T3": f.T3})
    ranges = {"K": (-0.0715, -0.0685), "T1": (22.3, 24.9), "T2": (1.7, 3.1), "T3": (2.9, 5.2)}
    yield from _middles("S4", found, ranges)


def zig_zag(ship: BentShip, angle: float, step: float, count: int) -> tuple[Numbers, Numbers]:
    """Return rudder (n,) and yaw rate with heading (n, 2), degrees, of a zig-zag angle/angle.

    The rudder moves at 2.3 deg/s and is held from sample to sample.
    """
    numbers, most = ship.numbers.astype(complex), 2.3 * step
    state, rudder, side = np.zeros(3, complex), 0.0, 1.0
    turns = math.copysign(1.0, ship.K / (ship.T1 * ship.T2))
    rudders, motions = np.empty(count), np.empty((count, 2))
    for k in range(count):
        motions[k] = state[1:].real / DEGREE
        if side * turns * motions[k, 1] >= angle:
            side = -side
        rudder += min(max(side * angle - rudder, -most), most)
        rudders[k] = rudder
        out = np.empty((2, 3), complex)
        helm = np.array([[rudder * DEGREE, 0.0]] * 2)
        run_bent(numbers, state, helm, step, 50, out)
        state = out[1].copy()
    return rudders, motions


def large_helm() -> Iterator[Figure]:
    """Yield S5: A K Fernstrom, unstable and bent: a linear fit to its zig-zags."""
    bent = BentShip(0.114, -304.0, 13.4, 33.4, 1230.0)
    small = _linear(bent, 5.0)
    yield Figure("S5", "5/5: K", 0.0, small["K"], 2.0)
    yield Figure("S5", "5/5: T1", -3000.0, small["T1"], 0.0)
    for angle in (10.0, 20.0):
        large = _linear(bent, angle)
        yield Figure("S5", f"{angle:g}/{angle:g}: K", -2.0, large["K"], 0.0)
        yield Figure("S5", f"{angle:g}/{angle:g}: T1", 0.0, large["T1"], 4000.0)
        yield Figure("S5", f"{angle:g}/{angle:g}: T2", 6.7, large["T2"], 26.8)
        yield Figure("S5", f"{angle:g}/{angle:g}: T3", 16.7, large["T3"], 66.8)
    straight = _linear(replace(bent, kappa=0.0), 10.0)
    yield Figure("S5", "kappa 0: K", 0.97 * 0.114, straight["K"], 1.03 * 0.114)
    yield Figure("S5", "kappa 0: T1", -1.03 * 304.0, straight["T1"], -0.97 * 304.0)


def _linear(bent: BentShip, angle: float) -> dict[str, float]:
    """Return K, T1, T2, T3 of Model 3 fitted by output error to a zig-zag of 1500 s."""
    rudder, motion = zig_zag(bent, angle, 5.0, 300)
    ship = Ship(244.0, 14.2 * KNOT)
    k = ship.speed / ship.length
    a2 = 1.0 / (bent.T1 * bent.T2) / k**2
    truth = {"a1": (bent.T1 + bent.T2) * a2 * k, "a2": a2, "b2": bent.K * a2 / k}
    truth |= {"b1": bent.K * bent.T3 * a2, "R2_r": 1e-5, "R2_psi": 1e-2}
    free = ("a1", "a2", "b1", "b2", "f1", *STATE)
    rehearsal = KnownShip("3", ship, ("yaw_rate", "heading"), 5.0, truth, free, {})
    problem = rehearsal.problem(rudder)
    problem = problem.on(replace(problem.samples, outputs=motion))
    found = find_best_minimum(
        Innovations(problem, no_gain), problem.start, "scoring", SearchOptions(300)
    )
    f = nomoto_of(problem.plant.model, problem.whole(found.theta), ship)
    return {"K": f.K, "T1": f.T1.real, "T2": f.T2.real, "T3": f.T3}


def two_logs(records: int = RECORDS) -> Iterator[Figure]:
    """Yield S6: Sea Splendour by Model 1 at 30 s.

    The record has both logs, yaw rate and heading.
    """
    noise = {"R1_Y": 0.0283, "R1_N": 0.00526, "R1_YN": math.asin(0.97)}
    reading = {"R2_v1": 1e-3, "R2_v2": 1e-3, "R2_r": 1e-6, "R2_psi": 1e-3}
    truth = {**TANKER_SHIP, **noise, **reading, "lag": math.asin(6.2 / 30.0)}
    begin = {**TANKER_BEGIN, "R1_Y": 0.05, "R1_N": 0.01, "R1_YN": 0.0, "lag": 0.3}
    outputs = ("bow_sway", "stern_sway", "yaw_rate", "heading")
    free = (*TANKER_SHIP, "Y_0", "N_0", "r_0", *noise, *reading, *STATE, "lag")
    free = tuple(name for name in free if name not in ("m11", "m22"))
    sea = KnownShip("1", TANKER.ship, outputs, 30.0, truth, free, begin)
    calm = {"R1_Y": noise["R1_Y"] / 100.0, "R1_N": noise["R1_N"] / 100.0}
    rudder = sequence(100, 60.0, 5.0, 30.0)
    ranges = {"K'": (-1.80, -0.76), "T1'": (2.3, 4.0), "Y_v": (-1.68, -1.45), "tau": (5.1, 7.2)}
    yield from _middles("S6", [_prime(*one) for one in _fit_records(sea, rudder, records)], ranges)
    quiet = replace(sea, truth=truth | calm, begin=begin | calm)
    found = [_prime(*one) for one in _fit_records(quiet, rudder, records)]
    yield from _middles("S6 calm", found, {"K'": (-1.69, -1.51)})
    found = [_prime(*one) for one in _fit_records(sea, rudder[:50], records)]
    yield from _middles("S6 50", found, {"K'": (-2.0, -0.23)})


def one_log(records: int = RECORDS) -> Iterator[Figure]:
    """Yield S7: Compass Island by Model 1 from a zig-zag 20/20 read every 6 s."""
    rudder = zigzag_rudder(ISLAND, 20.0, 100)
    found = [_prime(*one) for one in _fit_records(ISLAND, rudder, records)]
    ranges = {"K'": (-1.076, -0.997), "T1'": (1.54, 1.77), "T2'": (0.78, 0.97)}
    yield from _middles("S7", found, ranges | {"T3'": (1.70, 1.86), "tau": (5.0, 5.7)})


def sway_alone(records: int = SWAY_RECORDS) -> Iterator[Figure]:
    """Yield S8: Model 2 on the same record's sway. The truth is inside the intervals.

    T1 and T2 are next to a double root and have no normal scatter: their intervals are of draws.
    """
    K_v, T1, T2, T3v = 1.0174, 1.6917, 0.8457, 0.4265
    a2, c2 = 1.0 / (T1 * T2), K_v / (T1 * T2)
    truth = {"a1": (T1 + T2) * a2, "a2": a2, "c1": c2 * T3v, "c2": c2}
    noise = {"R1_1": 1e-4, "R1_2": 1e-8, "R2_v": 0.01, "lag": ISLAND.truth["lag"]}
    free = (*truth, "f2", "R1_1", "R1_2", "R1_12", "R2_v", "x1_0", "x2_0", "lag")
    alone = KnownShip("2", ISLAND.ship, ("sway",), 6.0, truth | noise, free, {})
    rudder = zigzag_rudder(ISLAND, 20.0, 100)
    problem, island, inside = alone.problem(rudder), ISLAND.problem(rudder), []
    told = partial(_sway_numbers, problem)
    within: list[NDArray[np.bool_]] = []
    for seed in range(records):
        stream = np.random.Generator(np.random.PCG64(seed))
        samples = draw_outputs(island, island.start, stream)
        cost = Likelihood(problem.on(replace(samples, outputs=samples.outputs[:, :1])))
        theta = find_best_minimum(cost, problem.start, "scoring", SearchOptions()).theta
        known = beside_bounds(uncertainty(problem.names, cost.information(theta)))
        low, high = uncertainty_module.intervals(problem, theta, known.deviations).T
        inside.append(((low <= problem.start) & (problem.start <= high))[:4])
        draws = draw_parameters(theta, np.nan_to_num(known.covariance), DRAW_COUNT, seed)
        span, truths = span_draws(told, draws)[1], told(problem.start)
        within.append((span.low <= truths) & (truths <= span.high))
    yield Figure("S8", "coefficients inside 95 % intervals", 0.85, float(np.mean(inside)), 1.0)
    for name, share in zip(SWAY_NUMBERS, np.mean(within, axis=0), strict=True):
        yield Figure("S8", f"{name} inside its interval", 0.85, float(share), 1.0)


def _sway_numbers(problem: Problem, theta: Numbers) -> Numbers:
    """Return SWAY_NUMBERS [SI] of a sway model."""
    f = nomoto_of(problem.plant.model, problem.whole(theta), problem.plant.ship)
    return np.array([f.K_v, f.T1.real, f.T2.real, (f.T1 + f.T2).real])


def other_half() -> Iterator[Figure]:
    """Yield S9: identified on one half, the other half predicted without its readings."""
    whole = TANKER.problem(TANKER_RUDDER[:1200])
    record = draw_outputs(whole, whole.start, np.random.Generator(np.random.PCG64(1)))
    first, second = (
        Samples(record.t[half], record.outputs[half], record.inputs[half])
        for half in (slice(0, 600), slice(600, 1200))
    )
    found = find_best_minimum(
        Likelihood(whole.on(first)), TANKER.start(), "scoring", SearchOptions()
    ).theta
    errors = []
    for theta in (found, whole.start):
        problem = whole.on(second)
        run = simulate_deterministic(problem, theta)[:, 3:]
        errors.append(np.std(run - second.outputs, axis=0))
    ratio = errors[0] / errors[1]
    yield Figure("S9", "sway error, of the truth's", 0.0, float(ratio[0]), 1.5)
    yield Figure("S9", "yaw rate error, of the truth's", 0.0, float(ratio[1]), 1.5)


def honest_intervals(records: int = COVERED) -> Iterator[Figure]:
    """Yield G6: 95 % intervals of 19 parameters from 2000 samples, pooled."""
    problem = TANKER.problem(TANKER_RUDDER)
    begin = replace(problem, values=problem.whole(TANKER.start()))
    found = study(begin, problem.start, range(records), lambda runs: runs)
    yield Figure("G6", "truths inside 95 % intervals", 0.93, found.pooled, 0.97)
    yield Figure("G6", "searches that came to an end", 0.99, found.converged, 1.0)


PROOFS: Final = (
    *(heading_only, rate_only, large_helm, two_logs, one_log, sway_alone),
    *(other_half, honest_intervals),
)


# S10: a hull whose yaw moment weakens with drift, under a linear model.
#
# The report blamed such terms for what its large zig-zags gave: N_v underestimated, and the more so
# the larger the helm.


WEAKENED: Final = 4.0  # [-] N_v of |v|/V: at a drift of 0.1 the moment is 0.6 of the line's
COUNT, PARTS = 300, 10  # samples, and steps of Runge and Kutta in each
TRUTH: Final = {**TANKER_SHIP, "R2_v1": 1e-4, "R2_r": 1e-6, "R2_psi": 1e-4}
FREE: Final = ("Y_v", "Y_r", "N_v", "N_r", "Y_delta", "l_delta", "Y_0", "N_0", *STATE)
HULL: Final = KnownShip("1", TANKER.ship, TANKER.outputs, TANKER.period, TRUTH, FREE, {})


def zig_zag_of(problem: Problem, angle: float) -> tuple[Numbers, Numbers]:
    """Return rudder (n,) [deg] and readings (n, 3). The bent hull makes a zig-zag angle/angle."""
    values = problem.whole(problem.start)
    drift = problem.plant.blocks(step_aside(values, ())).drift[0].real[:3]
    place = problem.plant.model.index("N_v")
    # what a unit of N_v does to the rates, by sway
    by_moment = problem.plant.blocks(step_aside(values, (place,))).drift[1].imag[:3, 0] * 1e100
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
        rudder, readings = zig_zag_of(problem, angle)
        samples = Samples(problem.samples.t, readings, rudder[:, None])
        fit = find_best_minimum(
            Innovations(problem.on(samples), no_gain), problem.start, "scoring", SearchOptions(300)
        )
        found[angle] = float(fit.theta[problem.names.index("N_v")]) / true
    yield Figure("S10", "N_v by 10/10, of the true", 0.0, found[10.0], 0.95)
    yield Figure("S10", "N_v by 20/20, of that by 10/10", 0.0, found[20.0] / found[10.0], 0.95)
    yield Figure("S10", "N_v by 5/5, of the true", -math.inf, found[5.0], math.inf)

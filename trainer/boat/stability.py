"""Which step an integration can take: the stability region, and the discrete map really flown.

``trainer boat check`` and the start of a run ask it, so that nobody flies at a step that makes a
stable boat unstable. The region asks how a method treats dx/dt = lambda x. The map is what a tick
does to a small disturbance of straight flight: method, lagged accelerations and equation set
together. What grows by the boat's own nature is never the step's fault.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from trainer.boat.boat import Boat
from trainer.boat.linear import (
    NEUTRAL_TOLERANCE,
    Matrix,
    RateResponse,
    bring_to,
    measure_response,
    mode_group,
)
from trainer.core.integrators import MIN_STEP_S
from trainer.core.kernel import Record
from trainer.core.scheme import MULTISTEP_CODES, PREDICTOR_CORRECTOR, VARIABLE_RUNGE_KUTTA
from trainer.units import KNOT

ROUNDING_GROWTH = 1e-9  # [-] growth per step that is only rounding
# [-] A swing with less than this damping ratio is barely damped: any explicit method and any lag
# may turn it, and a step is blamed only for growth of more than this, which doubles in 11 swings.
BLAMED_GROWTH = 0.01
# [-] |h lambda| beyond which no explicit method of four cycles is stable
MAX_STEP_EIGENVALUE = 30.0
MIN_SEARCH_STEP_S, MAX_SEARCH_STEP_S = 1e-3, 128.0  # [s] steps looked at
HALVING_COUNT = 20  # of the steps between which the largest stable one lies
MAX_EXPONENT = 300.0  # [-] exponent beyond which growth is simply large


class StepVerdict(NamedTuple):
    """Whether the step is stable, the largest stable one [s], and what fails beyond it."""

    ok: bool
    largest: float
    worst: str


def growth_factors(scheme: Record, mu: NDArray[np.complex128]) -> NDArray[np.float64]:
    """Return the largest factor [-] per step for each h lambda in ``mu``.

    The characteristic roots of the multistep method or of the pair, or Runge-Kutta's polynomial.
    """
    how = scheme[0]
    if how.method not in (*MULTISTEP_CODES, PREDICTOR_CORRECTOR):
        slope, total = mu, 0.0 * mu
        for i in range(int(how.stages)):
            total += how.weight[i] / how.weight_sum * slope
            slope = mu * (1.0 + how.share[i] * slope)
        return np.asarray(abs(1.0 + total))
    depth = int(how.depth)
    companion = np.zeros((len(mu), depth, depth), complex)
    companion[:, 0, :] = how.a[:depth] + mu[:, None] * how.b[:depth]
    if how.method == PREDICTOR_CORRECTOR:
        companion[:, 0, :] *= how.closed_b[0] * mu[:, None]
        companion[:, 0, :] += how.closed_a[:depth] + mu[:, None] * how.closed_b[1 : depth + 1]
    companion[:, range(1, depth), range(depth - 1)] = 1.0
    return np.asarray(abs(np.linalg.eigvals(companion)).max(axis=1))


def largest_step(scheme: Record, eigenvalue: complex) -> float:
    """Return the largest step [s] at which a damped ``eigenvalue`` [1/s] decays, 0 if none.

    Every smaller step is stable too, because the ray from the origin is searched outwards for the
    first point that is not. Seven rounds, each 150 times as fine, leave only rounding.
    """
    direction = eigenvalue / abs(eigenvalue)
    inside, outside = 0.0, MAX_STEP_EIGENVALUE
    for _ in range(7):
        radii = np.linspace(inside, outside, 151)[1:]
        stable = growth_factors(scheme, np.asarray(radii * direction, np.complex128)) <= 1.0 + 1e-13
        if stable.all():
            break
        first = int(np.argmin(stable))
        outside = float(radii[first])
        inside = float(radii[first - 1]) if first > 0 else inside
    return inside / abs(eigenvalue)


def multistep_map(response: RateResponse, scheme: Record, h: float) -> Matrix:
    """Return the matrix of a tick of ``h`` [s] on motions and rates, newest first."""
    how = scheme[0]
    n = len(response.J)
    held = max((i + 1 for i in range(int(how.depth)) if how.a[i] != 0.0), default=1)
    past = max(int(how.depth) - 1, 1)  # one at least: the lagged accelerations
    newest = n * held
    tick = np.zeros((n * (held + past), n * (held + past)))
    rate = np.zeros((n, len(tick)))
    rate[:, :n] = response.J
    rate[:, newest : newest + n] = response.G
    tick[:n] = h * how.b[0] * rate
    for i in range(held):
        tick[:n, n * i : n * (i + 1)] += how.a[i] * np.eye(n)
    for i in range(int(how.depth) - 1):
        tick[:n, newest + n * i : newest + n * (i + 1)] += h * how.b[i + 1] * np.eye(n)
    tick[n:newest, : newest - n] = np.eye(newest - n)
    tick[newest : newest + n] = rate
    tick[newest + n :, newest:-n] = np.eye(n * (past - 1))
    return tick


def runge_kutta_map(response: RateResponse, scheme: Record, h: float) -> Matrix:
    """Return the map of a tick of ``h`` [s], lagged inside the stages.

    It takes motion and last rates.
    """
    J, G = response.J, response.G
    how = scheme[0]
    now = np.eye(len(J), 2 * len(J))
    rate = np.hstack([J, G])
    total = how.weight[0] * rate
    for i in range(1, int(how.stages)):
        rate = J @ (now + how.share[i - 1] * h * rate) + G @ rate
        total += how.weight[i] * rate
    return np.vstack([now + h / how.weight_sum * total, rate])


def pair_map(response: RateResponse, scheme: Record, h: float) -> Matrix:
    """Return the map of a tick of ``h`` [s].

    It takes motions (newest first), last rates and past rates.

    The last rates are those of what was predicted, the past ones those of the motions.
    """
    how = scheme[0]
    n, depth = len(response.J), int(how.depth)
    motions, last = n * depth, n * (depth + 1)
    tick = np.zeros((2 * motions, 2 * motions))
    now = np.eye(2 * motions)
    rate = response.J @ now[:n] + response.G @ now[motions:last]
    past = [rate, *(now[last + n * i : last + n * (i + 1)] for i in range(depth - 1))]
    predicted, corrected = np.zeros((2, n, 2 * motions))
    for i in range(depth):
        held = now[n * i : n * (i + 1)]
        predicted += how.a[i] * held + h * how.b[i] * past[i]
        corrected += how.closed_a[i] * held + h * how.closed_b[i + 1] * past[i]
    ahead = response.J @ predicted + response.G @ rate
    tick[:n] = corrected + h * how.closed_b[0] * ahead
    tick[n:motions] = now[: motions - n]
    tick[motions:last] = ahead
    tick[last:] = np.vstack(past)[: 2 * motions - last]
    return tick


def tick_map(response: RateResponse, scheme: Record, h: float) -> Matrix:
    """Return the matrix of one tick of ``h`` [s]. The first rows are the present motion."""
    if scheme[0].method in MULTISTEP_CODES:
        return multistep_map(response, scheme, h)
    if scheme[0].method == PREDICTOR_CORRECTOR:
        return pair_map(response, scheme, h)
    return runge_kutta_map(response, scheme, h)


def allowed_rate(eigenvalue: complex) -> float:
    """Return the growth [1/s] that a step may show where the boat itself has ``eigenvalue``.

    It is 0 if the boat damps it well; else twice the boat's own and BLAMED_GROWTH of the frequency.
    """
    if eigenvalue.real < -max(BLAMED_GROWTH * abs(eigenvalue), NEUTRAL_TOLERANCE):
        return 0.0
    return float(2.0 * max(eigenvalue.real, 0.0) + BLAMED_GROWTH * abs(eigenvalue))


def added_growth(response: RateResponse, tick: Matrix, h: float) -> tuple[float, complex]:
    """Return the largest spurious factor [-] per tick of ``h`` [s], and its root.

    For each mode that the boat does not damp well, the root nearest to exp(h lambda) does not
    count, because it is the boat's own, unless it grows faster than is allowed.
    """
    roots = list(np.linalg.eigvals(tick))
    for eigenvalue in response.eigenvalues:
        exponent = h * allowed_rate(eigenvalue)
        if exponent > 0.0:
            natural_factor = np.exp(
                min(h * eigenvalue.real, MAX_EXPONENT) + 1j * h * eigenvalue.imag
            )
            nearest = int(np.argmin(abs(np.array(roots) - natural_factor)))
            if abs(roots[nearest]) <= np.exp(min(exponent, MAX_EXPONENT)) + ROUNDING_GROWTH:
                roots.pop(nearest)
    worst = max(roots, key=abs)
    return float(abs(worst)), complex(worst)


def leading_motion(response: RateResponse, tick: Matrix, root: complex) -> str:
    """Return the motion that takes part most in a root of the map."""
    shares = np.ones(len(tick))
    for matrix in (tick, tick.T):
        values, vectors = np.linalg.eig(matrix)
        shares *= abs(vectors[:, int(np.argmin(abs(values - root)))])
    n = len(response.names)
    return mode_group(response.names, shares.reshape(-1, n).sum(axis=0))


def boat_responses(boat: Boat, speeds: Iterable[float]) -> dict[float, RateResponse]:
    """Return the boat's response at each of ``speeds`` [m/s]; the boat's state is not changed."""
    before = boat.snapshot()
    by_speed = {}
    for speed in speeds:
        bring_to(boat, speed)
        by_speed[speed] = measure_response(boat)
    boat.restore(before)
    return by_speed


def inner_step(scheme: Record, h: float) -> float:
    """Return the step [s] inside a tick. The variable method goes down to its shortest."""
    return min(h, MIN_STEP_S) if scheme[0].method == VARIABLE_RUNGE_KUTTA else h


def stable_at(flights: Iterable[RateResponse], scheme: Record, h: float) -> bool:
    """Return whether ticks of ``h`` [s] add no growth to that of the boat itself."""
    h = inner_step(scheme, h)
    return all(
        added_growth(flight, tick_map(flight, scheme, h), h)[0] <= 1.0 + ROUNDING_GROWTH
        for flight in flights
    )


def largest_flown(flights: Iterable[RateResponse], scheme: Record) -> float:
    """Return the largest stable step [s] of the map. 0: none is stable; infinite: all are."""
    flights = list(flights)
    if not stable_at(flights, scheme, MIN_SEARCH_STEP_S):
        return 0.0
    stable = MIN_SEARCH_STEP_S
    while stable_at(flights, scheme, 2.0 * stable):
        stable *= 2.0
        if stable >= MAX_SEARCH_STEP_S:
            return math.inf
    unstable = 2.0 * stable
    for _ in range(HALVING_COUNT):
        middle = 0.5 * (stable + unstable)
        if stable_at(flights, scheme, middle):
            stable = middle
        else:
            unstable = middle
    return stable


def worst_motion(flights: dict[float, RateResponse], scheme: Record, h: float) -> tuple[float, str]:
    """Return the largest spurious factor [-] per tick of ``h`` [s], and its name."""
    h = inner_step(scheme, h)
    cases = []
    for speed, flight in flights.items():
        tick = tick_map(flight, scheme, h)
        cases.append((*added_growth(flight, tick, h), speed, flight, tick))
    factor, root, speed, flight, tick = max(cases, key=lambda entry: entry[0])
    return factor, f"{leading_motion(flight, tick, root)} at {speed / KNOT:.3g} kn"


def stable_step(boat: Boat, speeds: Iterable[float]) -> StepVerdict:
    """Return whether the boat's own step is stable in straight flight at ``speeds`` [m/s]."""
    flights = boat_responses(boat, speeds)
    scheme = boat.records.scheme
    largest = largest_flown(flights.values(), scheme)
    step = boat.method.step
    stable = stable_at(flights.values(), scheme, step)
    if math.isinf(largest):
        return StepVerdict(stable, largest, "nothing")
    beyond = 1.001 * largest if stable else step
    return StepVerdict(stable, largest, worst_motion(flights, scheme, beyond)[1])

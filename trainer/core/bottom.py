"""The ground under the hull: a soft spring with damping and friction.

At a station x ahead of the origin the keel is p below ground that rises with the unit normal n, and
moves over it at v. The ground then pushes with

    N = max(k p - d v.n, 0)        F = N n - mu N v_t/max(|v_t|, v0)
    m = W/g - Z_wdot        k = w^2 m/5        d = 2 zeta w m/5        v0 = max(0.1, 10 h mu N/m)

w, zeta and mu are this project's estimates, no soil's: they are so soft that Adams' second order
holds them in steps of up to 1 s, with w h at most 0.5. Twenty tonnes lie 0.1 m deep. Ground that
holds (mud) pulls likewise at a hull that lies on it, until its lift is the breakout's.

``update`` adds these forces in each tick over charted ground; ``boat/grounding`` tells the crew
when the boat lies there.
"""

import math
from typing import Final

from trainer.core.elementary import cosine_and_sine, sine
from trainer.core.kernel import Numbers, Record, inline_kernel
from trainer.core.state import (
    AXIAL,
    GROUND_DEPTH,
    GROUND_EAST,
    GROUND_NORTH,
    LATERAL,
    NORMAL,
    PITCHING,
    ROLLING,
    SOUNDING_COUNT,
    YAWING,
)

SOUNDING_STATIONS: Final = (-0.45, -0.225, 0.0, 0.225, 0.45)  # [-] of the hull's length, aft first
SOUNDING_REACH: Final = 0.45  # [-] of the hull's length, to the outermost station
SPRING_FREQUENCY: Final = 0.5  # [rad/s] w
SPRING_DAMPING: Final = 0.5  # [-] zeta
SMOOTH_FRICTION_SPEED: Final = 0.1  # [m/s] below which friction is smooth

NORTH, EAST, DOWN = 0, 1, 2  # of a vector over ground
Vector = tuple[float, float, float]
Axes = tuple[Vector, Vector, Vector]  # of the body over ground: ahead, to starboard, down


@inline_kernel
def keel_below(vessel: Record) -> float:
    """Return how far [m] the keel is below the origin."""
    return 0.5 * vessel[0].hull_diameter + vessel[0].hull_axis


@inline_kernel
def clearance(state: Record, keel: float) -> float:
    """Return the least height [m] of a level ``keel`` [m] over the ground."""
    s = state[0]
    least = math.inf
    for i in range(SOUNDING_COUNT):
        least = min(least, s.bottom[GROUND_DEPTH, i])
    return least - s.z - keel


@inline_kernel
def dot(a: Vector, b: Vector) -> float:
    """Return the product of two vectors."""
    return a[NORTH] * b[NORTH] + a[EAST] * b[EAST] + a[DOWN] * b[DOWN]


@inline_kernel
def carried(vessel: Record, scheme: Record, state: Record, p: float, rise: float) -> float:
    """Return the load [N] on a point ``p`` [m] below the ground.

    The point rises at ``rise`` [m/s]. The load is negative where the ground holds the hull.
    """
    mass = state[0].weight / vessel[0].g + vessel[0].m33
    normal = (
        SPRING_FREQUENCY
        / SOUNDING_COUNT
        * mass
        * (SPRING_FREQUENCY * p - 2.0 * SPRING_DAMPING * rise)
    )
    if p > 0.0:
        return max(normal, 0.0)
    return min(max(normal, -scheme[0].breakout / SOUNDING_COUNT), 0.0)


@inline_kernel
def push(
    vessel: Record, scheme: Record, state: Record, load: float, n: Vector, v: Vector
) -> Vector:
    """Return the force [N] of the ground on a point with a ``load`` [N].

    The point moves at ``v`` [m/s]. All vectors are over ground: north, east and down.
    """
    mass = state[0].weight / vessel[0].g + vessel[0].m33
    rise = dot(v, n)
    along = (v[NORTH] - rise * n[NORTH], v[EAST] - rise * n[EAST], v[DOWN] - rise * n[DOWN])
    rub = scheme[0].friction * abs(load)
    rub /= max(SMOOTH_FRICTION_SPEED, 10.0 * scheme[0].h * rub / mass, math.sqrt(dot(along, along)))
    return (
        load * n[NORTH] - rub * along[NORTH],
        load * n[EAST] - rub * along[EAST],
        load * n[DOWN] - rub * along[DOWN],
    )


@inline_kernel
def holding(vessel: Record, scheme: Record, state: Record) -> float:
    """Return up to which height [m] the ground holds a hull that lay there."""
    if scheme[0].breakout <= 0.0 or state[0].aground == 0.0:
        return 0.0
    mass = state[0].weight / vessel[0].g + vessel[0].m33
    return scheme[0].breakout / (SPRING_FREQUENCY * SPRING_FREQUENCY * mass)


@inline_kernel
def axes(state: Record) -> Axes:
    """Return the body's axes over ground: ahead, to starboard, down."""
    s = state[0]
    cos_phi, sin_phi = cosine_and_sine(s.phi)
    cos_th, sin_th = cosine_and_sine(s.theta)
    cos_psi, sin_psi = cosine_and_sine(s.psi)
    right = (
        sin_phi * sin_th * cos_psi - cos_phi * sin_psi,
        sin_phi * sin_th * sin_psi + cos_phi * cos_psi,
        sin_phi * cos_th,
    )
    down = (
        cos_phi * sin_th * cos_psi + sin_phi * sin_psi,
        cos_phi * sin_th * sin_psi - sin_phi * cos_psi,
        cos_phi * cos_th,
    )
    return (cos_th * cos_psi, cos_th * sin_psi, -sin_th), right, down


@inline_kernel
def over_ground(state: Record, turned: Axes, x: float, keel: float, z: float) -> Vector:
    """Return the velocity [m/s] over ground of the keel at ``x`` and ``z`` [m]."""
    s = state[0]
    ahead, right, down = turned
    a, b, c = s.u + keel * s.q, s.v + x * s.r - keel * s.p, s.w - x * s.q
    north = a * ahead[NORTH] + b * right[NORTH] + c * down[NORTH]
    east = a * ahead[EAST] + b * right[EAST] + c * down[EAST]
    return (
        north + s.water_north + s.shear_north * z,
        east + s.water_east + s.shear_east * z,
        a * ahead[DOWN] + b * right[DOWN] + c * down[DOWN],
    )


@inline_kernel
def add_at(turned: Axes, x: float, keel: float, f: Vector, force: Numbers) -> None:
    """Add a force [N] on the keel at ``x`` [m], with its moments.

    The force is north, east and down.
    """
    ahead, right, down = turned
    along, aside, below = dot(f, ahead), dot(f, right), dot(f, down)
    force[AXIAL] += along
    force[LATERAL] += aside
    force[NORMAL] += below
    force[ROLLING] -= keel * aside
    force[PITCHING] += keel * along - x * below
    force[YAWING] += x * aside


@inline_kernel
def add_ground(vessel: Record, scheme: Record, keel: float, state: Record, force: Numbers) -> None:
    """Add the forces [N] and moments [N m] of the ground on the keel."""
    s = state[0]
    turned = axes(state)
    ahead, _, down = turned
    free = -holding(vessel, scheme, state)
    for i in range(SOUNDING_COUNT):
        x = SOUNDING_STATIONS[i] * vessel[0].ell
        z = s.z + x * ahead[DOWN] + keel * down[DOWN]
        if z - s.bottom[GROUND_DEPTH, i] <= free:
            continue
        north, east = s.bottom[GROUND_NORTH, i], s.bottom[GROUND_EAST, i]
        norm = 1.0 / math.sqrt(1.0 + north * north + east * east)
        p = (z - s.bottom[GROUND_DEPTH, i]) * norm
        n = (north * norm, east * norm, -norm)
        v = over_ground(state, turned, x, keel, z)
        load = carried(vessel, scheme, state, p, dot(v, n))
        s.bottom_load += load
        add_at(turned, x, keel, push(vessel, scheme, state, load, n, v), force)


@inline_kernel
def bottom_forces(vessel: Record, scheme: Record, state: Record, force: Numbers) -> None:
    """Add what the ground does to a hull that touches it, and count the ticks.

    The count (the state's ``aground``) tells exercises and the crew that the boat lies on the
    ground.
    """
    s = state[0]
    keel = keel_below(vessel)
    s.bottom_load, lies = 0.0, False
    least = clearance(state, keel)
    # the cheap tests first, since near the ground its force costs a tenth of the tick
    if least <= SOUNDING_REACH * vessel[0].ell:
        least -= SOUNDING_REACH * vessel[0].ell * abs(sine(s.theta))
        holds = holding(vessel, scheme, state)
        if least <= holds:
            add_ground(vessel, scheme, keel, state, force)
            lies = holds > 0.0
    s.aground = s.aground + 1.0 if s.bottom_load != 0.0 or lies else 0.0

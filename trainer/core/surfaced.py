"""The hull at the surface: lost buoyancy, damping, waves, wave resistance, a dry sail.

The part of the hull above the water is found at stations along an axis of circular sections, whose
water forces pass through the axis; the sail displaces nothing. A station that is cut also loses
energy to waves, spray and water on deck. That damping ratio is this project's estimate: no decay
of a surfaced submarine is published. The local water level is that of the sea's components at the
station.

The share of the sail in the air feels no water. Its lift and drag across the flow, which the
coefficients of the deep boat contain, are taken off both sets of equations alike. The lateral force
that is left goes through the axis of the round sections, which lies above the centre of gravity: so
a boat afloat hangs from it like a pendulum and heels inward in a turn, by about atan(u r/g).
"""

import math
from typing import Final

from trainer.core.ballast.buoyancy import segment
from trainer.core.elementary import cosine_and_sine
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.kinematics import EXACT_TRIGONOMETRY, Attitude, attitude_of
from trainer.core.state import AXIAL, LATERAL, NORMAL, PITCHING, ROLLING, YAWING

HUMP_FROUDE: Final = (
    0.5  # [-] Froude number from which wave resistance grows by u^2 alone, an estimate
)
# [-] deepest trough over the significant height: six standard deviations, in one wave of e^18
TROUGH_SHARE: Final = 1.5
TRAVEL_SHARE: Final = 2.0  # [-] of the way at the present rates, since the boat may speed up


@inline_kernel
def is_shallow(vessel: Record, state: Record) -> bool:
    """Return whether anything of the boat could be above the water at some attitude."""
    return bool(state[0].z < vessel[0].surface_line + state[0].sea_height)


@inline_kernel
def is_near_surface(vessel: Record, h: float, state: Record) -> bool:
    """Return whether the water's surface can cut the hull within ``h`` [s].

    It can where a trough may reach the station that the pitch lifts highest. The angle stands for
    its sine, which is never larger: so a boat at periscope depth needs no trigonometry.
    """
    if not is_shallow(vessel, state):
        return False
    c, s = vessel[0], state[0]
    pitch = abs(s.theta)
    rise = abs(s.u) * pitch + abs(s.v) + abs(s.w) + c.station_reach * (abs(s.q) + abs(s.r))
    return bool(room_below(vessel, state) < TRAVEL_SHARE * h * rise)


@inline_kernel
def room_below(vessel: Record, state: Record) -> float:
    """Return the least room [m] between the hull and the deepest trough."""
    c, s = vessel[0], state[0]
    deepest = TROUGH_SHARE * s.sea_height
    return float(s.z - c.station_reach * abs(s.theta) - c.hull_reach - deepest)


@inline_kernel
def axis_depth(
    vessel: Record, station: int, attitude: Attitude, scratch: Record, state: Record
) -> float:
    """Return the depth [m] of the axis at a station, below the water there."""
    c, s = vessel[0], state[0]
    sin_phi, cos_phi, sin_th, cos_th = attitude
    level = s.z + scratch[0].level[station]
    across = c.hull_axis * cos_phi + c.y_b * sin_phi
    return level - c.station_x[station] * sin_th + across * cos_th


@inline_kernel
def share_above(vessel: Record, scratch: Record, state: Record) -> float:
    """Return the share of the hull's volume above the water [-]."""
    c = vessel[0]
    attitude = attitude_of(EXACT_TRIGONOMETRY, state)
    share = 0.0
    for i in range(c.station_x.size):
        depth = axis_depth(vessel, i, attitude, scratch, state)
        share += c.station_share[i] * segment(0.5 - depth / c.hull_diameter)
    return share


@inline_kernel
def is_cut(vessel: Record, scratch: Record, state: Record) -> bool:
    """Return whether the water's surface cuts the hull at some station."""
    attitude = attitude_of(EXACT_TRIGONOMETRY, state)
    for i in range(vessel[0].station_x.size):
        if axis_depth(vessel, i, attitude, scratch, state) < 0.5 * vessel[0].hull_diameter:
            return True
    return False


@inline_kernel
def dry_sail(vessel: Record, state: Record) -> float:
    """Return the share of the sail's height that is above the water [-]."""
    c, s = vessel[0], state[0]
    if c.sail_height <= 0.0 or not is_shallow(vessel, state):
        return 0.0
    if s.z + s.eta_wave >= abs(c.z_sail) + abs(c.x_sail * s.theta):
        return 0.0
    cos_th, sin_th = cosine_and_sine(s.theta)
    top = s.z + s.eta_wave - c.x_sail * sin_th + c.z_sail * cos_th * cosine_and_sine(s.phi)[0]
    return min(max(-top / c.sail_height, 0.0), 1.0)


@inline_kernel
def sinking(vessel: Record, station: int, attitude: Attitude, state: Record) -> float:
    """Return the speed [m/s] at which the axis goes down at a station."""
    c, s = vessel[0], state[0]
    x, z = c.station_x[station], c.hull_axis
    sin_phi, cos_phi, sin_th, cos_th = attitude
    aside, down = s.v + x * s.r - z * s.p, s.w - x * s.q
    down += c.y_b * s.p
    return (aside * sin_phi + down * cos_phi) * cos_th - (s.u + z * s.q - c.y_b * s.r) * sin_th


@inline_kernel
def damping(vessel: Record, station: int, chord: float) -> float:
    """Return the damping [N s/m] of a station that is cut, when it sinks.

    ``chord`` [-] is its chord in diameters. The damping ratio is that of the mode of its own
    stiffness, the exact derivative of the circle, and of its own mass with the added mass of the
    deep hull.
    """
    c = vessel[0]
    share = c.station_share[station]
    stiffness = share * c.buoyancy * 4.0 * chord / (math.pi * c.hull_diameter)
    return 2.0 * c.surface_damping * math.sqrt(stiffness * share * (c.mass + c.m33))


@kernel
def add_waterplane(vessel: Record, scratch: Record, state: Record, force: Numbers) -> None:
    """Add the forces of the stations that are cut, and their wave resistance.

    They are X Y Z [N] and K M N [N m].
    """
    c, s = vessel[0], state[0]
    attitude = attitude_of(EXACT_TRIGONOMETRY, state)
    heavy, x, above = 0.0, 0.0, 0.0
    for i in range(c.station_x.size):
        depth = axis_depth(vessel, i, attitude, scratch, state) / c.hull_diameter
        if depth >= 0.5:
            continue
        share = segment(0.5 - depth)
        down = c.station_share[i] * c.buoyancy * share
        if depth > -0.5:
            chord = math.sqrt(1.0 - 4.0 * depth * depth)
            speed = sinking(vessel, i, attitude, state) + scratch[0].rise[i]
            down -= damping(vessel, i, chord) * speed
        above += c.station_share[i] * share
        heavy += down
        x += down * c.station_x[i]
    if above == 0.0:
        return
    sin_phi, cos_phi, sin_th, cos_th = attitude
    down_x, down_y, down_z = -sin_th, cos_th * sin_phi, cos_th * cos_phi
    z = heavy * c.hull_axis
    square = min(s.u * s.u, HUMP_FROUDE * HUMP_FROUDE * c.g * c.ell)
    force[AXIAL] += heavy * down_x
    force[AXIAL] -= c.wave_drag * min(above / 0.05, 1.0) * square * square * s.u * abs(s.u)
    force[LATERAL] += heavy * down_y
    force[NORMAL] += heavy * down_z
    force[ROLLING] -= z * down_y
    force[PITCHING] += z * down_x - x * down_z
    force[YAWING] += x * down_y
    force[ROLLING] += heavy * c.y_b * down_z
    force[YAWING] -= heavy * c.y_b * down_x


@inline_kernel
def take_off(x: float, z: float, lateral: float, force: Numbers) -> None:
    """Take a lateral force [N] at a point [m] off Y, K and N."""
    force[LATERAL] -= lateral
    force[ROLLING] += z * lateral
    force[YAWING] -= x * lateral


@kernel
def take_off_dry_sail(vessel: Record, state: Record, force: Numbers) -> None:
    """Take off what the sail's share in the air no longer does, and its heel.

    Its lift and cross-flow drag are meant. Drift and turning heel a deep boat by its sail. What is
    left of their lateral force acts on the axis of the round sections, because pressure goes
    through it.
    """
    dry = dry_sail(vessel, state)
    if dry == 0.0:
        return
    c, s = vessel[0], state[0]
    ahead, cross = max(s.u, 0.0), math.sqrt(s.v * s.v + s.w * s.w)
    side = ahead * (c.Y_v * s.v + c.Y_r * s.r) + c.Y_vav * s.v * cross
    heeling = ahead * (c.K_v * s.v + c.K_r * s.r) + c.K_vav * s.v * cross
    along = s.v + c.lift_x * s.r
    lift = c.sail_lift * ahead * along
    take_off(c.lift_x, c.lift_z, -dry * c.sail_lift * abs(s.u) * (along - c.lift_z * s.p), force)
    aside = s.v + c.strip_x * s.r
    drag = c.strip_Y * math.sqrt(aside * aside + s.w * s.w) * aside
    aside -= c.strip_z * s.p
    by_roll = c.strip_Y * math.sqrt(aside * aside + s.w * s.w) * aside
    take_off(c.strip_x, c.strip_z, -dry * by_roll, force)
    side += lift + drag
    heeling -= c.lift_z * lift + c.strip_z * drag
    force[ROLLING] -= dry * (heeling + c.hull_axis * side)


@inline_kernel
def emerges(vessel: Record, state: Record) -> bool:
    """Return whether the surface may cut the hull, or the sail stands out."""
    if not is_shallow(vessel, state):
        return False
    return room_below(vessel, state) < 0.0 or dry_sail(vessel, state) != 0.0


@inline_kernel
def write_near(vessel: Record, scratch: Record, state: Record) -> None:
    """Write ``near``: what acts from outside in this tick, and what the surface does now.

    ``rates`` calls it within a step for a boat that ``emerges``, because the wet part of the hull
    changes faster than the sea. Forces are in [N], moments in [N m].
    """
    work = scratch[0]
    for i in range(6):
        work.near[i] = work.external[i]
    if room_below(vessel, state) < 0.0:  # a sail stands out before the hull does
        add_waterplane(vessel, scratch, state, work.near)
    take_off_dry_sail(vessel, state, work.near)

"""The hull at the surface: lost buoyancy, damping by station, waves along it, wave resistance.

The part of the hull above the water is found at stations along an axis of circular sections, whose
water forces pass through the axis; the sail counts nothing. A station that is cut also loses energy
to waves, spray and water on deck. That damping ratio is this project's estimate: no decay of a
surfaced submarine is published. The local water level is that of the sea's components at the
station.
"""

import math
from typing import Final

from trainer.core.ballast.buoyancy import segment
from trainer.core.elementary import cosine_and_sine
from trainer.core.kernel import Numbers, Record, kernel, part
from trainer.core.state import AXIAL, LATERAL, NORMAL, PITCHING, ROLLING, YAWING

HUMP_FROUDE: Final = (
    0.5  # [-] Froude number from which wave resistance grows by u^2 alone, an estimate
)


@part
def is_near_surface(vessel: Record, state: Record) -> bool:
    """Return whether anything of the boat can be above the water, whatever the attitude."""
    return bool(state[0].z < vessel[0].surface_line + state[0].sea_height)


@part
def axis_depth(vessel: Record, station: int, scratch: Record, state: Record) -> float:
    """Return the depth [m] of the axis at a station, below the water there."""
    c, s = vessel[0], state[0]
    cos_th, sin_th = cosine_and_sine(s.theta)
    cos_phi, sin_phi = cosine_and_sine(s.phi)
    level = s.z + scratch[0].level[station]
    across = c.hull_axis * cos_phi + c.y_b * sin_phi
    return level - c.station_x[station] * sin_th + across * cos_th


@part
def share_above(vessel: Record, scratch: Record, state: Record) -> float:
    """Return the share of the hull's volume above the water [-]."""
    c = vessel[0]
    share = 0.0
    for i in range(c.station_x.size):
        depth = axis_depth(vessel, i, scratch, state)
        share += c.station_share[i] * segment(0.5 - depth / c.hull_diameter)
    return share


@part
def is_cut(vessel: Record, scratch: Record, state: Record) -> bool:
    """Return whether the water's surface cuts the hull at some station."""
    for i in range(vessel[0].station_x.size):
        if axis_depth(vessel, i, scratch, state) < 0.5 * vessel[0].hull_diameter:
            return True
    return False


@part
def dry_sail(vessel: Record, state: Record) -> float:
    """Return the share of the sail's height that is above the water [-]."""
    c, s = vessel[0], state[0]
    if c.sail_height <= 0.0 or not is_near_surface(vessel, state):
        return 0.0
    cos_th, sin_th = cosine_and_sine(s.theta)
    top = s.z + s.eta_wave - c.x_sail * sin_th + c.z_sail * cos_th * cosine_and_sine(s.phi)[0]
    return min(max(-top / c.sail_height, 0.0), 1.0)


@part
def sinking(vessel: Record, station: int, state: Record) -> float:
    """Return the speed [m/s] at which the axis goes down at a station."""
    c, s = vessel[0], state[0]
    x, z = c.station_x[station], c.hull_axis
    cos_th, sin_th = cosine_and_sine(s.theta)
    cos_phi, sin_phi = cosine_and_sine(s.phi)
    aside, down = s.v + x * s.r - z * s.p, s.w - x * s.q
    down += c.y_b * s.p
    return (aside * sin_phi + down * cos_phi) * cos_th - (s.u + z * s.q - c.y_b * s.r) * sin_th


@part
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
    heavy, x, above = 0.0, 0.0, 0.0
    for i in range(c.station_x.size):
        depth = axis_depth(vessel, i, scratch, state) / c.hull_diameter
        if depth >= 0.5:
            continue
        share = segment(0.5 - depth)
        down = c.station_share[i] * c.buoyancy * share
        if depth > -0.5:
            chord = math.sqrt(1.0 - 4.0 * depth * depth)
            speed = sinking(vessel, i, state) + scratch[0].rise[i]
            down -= damping(vessel, i, chord) * speed
        above += c.station_share[i] * share
        heavy += down
        x += down * c.station_x[i]
    if above == 0.0:
        return
    cos_th, sin_th = cosine_and_sine(s.theta)
    cos_phi, sin_phi = cosine_and_sine(s.phi)
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


@part
def write_near(vessel: Record, scratch: Record, state: Record) -> None:
    """Write forces [N] and moments [N m] from outside.

    They are those of this tick with those of the water's surface now.
    """
    work = scratch[0]
    for i in range(6):
        work.near[i] = work.external[i]
    add_waterplane(vessel, scratch, state, work.near)

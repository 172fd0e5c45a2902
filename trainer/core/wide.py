"""The wide set: forces for any direction of the flow, whose power is never positive.

It has the forces of an ideal fluid, linear viscous forces that grow with the size of u, cross-flow
drag, and control surfaces that reverse astern. docs/envelope.md has derivations, sources and what
is estimated. ``rates`` blends it in where the motion leaves the range of the equations of 1969
(``envelope``), and going astern it is alone.
"""

import math

from trainer.core import full
from trainer.core.crossflow import add_hull_strips, add_tail_and_sail
from trainer.core.envelope import BY_P, BY_Q, BY_R, BY_V, BY_W, wide_share
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.propulsion import thrust, thrust_astern
from trainer.core.rigid_body import add_weight, body_forces
from trainer.core.scheme import LONGITUDINAL_EQUATIONS
from trainer.core.solve import exact
from trainer.core.state import AXIAL, LATERAL, NORMAL, PITCHING, ROLLING, YAWING
from trainer.core.surfaced import dry_sail


@inline_kernel
def add_ideal_fluid(vessel: Record, dry: float, state: Record, force: Numbers) -> None:
    """Add the forces [N] and moments [N m] of the added masses.

    ``dry`` [-] is the share of the sail that is in air. They are Kirchhoff's equations and do no
    work. They take the place of the vessel file's products of velocities, which are lift of sail
    and hull at small angles.
    """
    c, s = vessel[0], state[0]
    u, v, w, p, q, r = s.u, s.v, s.w, s.p, s.q, s.r
    sail = dry * c.sail_mass
    m22, m24 = c.m22 - sail, c.m24 + sail * c.strip_z
    m44, m26 = c.m44 - sail * c.strip_z * c.strip_z, c.m26 - sail * c.strip_x
    along = c.m11 * u
    aside = m22 * v + m24 * p + m26 * r
    down = c.m33 * w + c.m35 * q
    roll = m24 * v + m44 * p + c.m46 * r
    pitch = c.m35 * w + c.m55 * q
    yaw = m26 * v + c.m46 * p + c.m66 * r
    force[AXIAL] += r * aside - q * down
    force[LATERAL] += p * down - r * along
    force[NORMAL] += q * along - p * aside
    force[ROLLING] += r * pitch - q * yaw + w * aside - v * down
    force[PITCHING] += p * yaw - r * roll + u * down - w * along
    force[YAWING] += q * roll - p * pitch + v * along - u * aside


@inline_kernel
def add_viscous(vessel: Record, state: Record, force: Numbers) -> None:
    """Add the viscous forces [N] and moments [N m] of the whole boat.

    Those in proportion to |u| have other numbers astern. Added as well are the steady ones, of a
    boat not alike above and below and of the propeller's torque, and the damping of roll.
    """
    c, s = vessel[0], state[0]
    u, v, w, p, q, r = s.u, s.v, s.w, s.p, s.q, s.r
    way = 0 if u >= 0.0 else 1
    size = abs(u)
    for row in range(3):
        d = c.lateral[way, row]
        force[LATERAL + 2 * row] += size * (d[BY_V] * v + d[BY_P] * p + d[BY_R] * r)
    for row in range(2):
        d = c.vertical[way, row]
        force[NORMAL + 2 * row] += size * (d[BY_W] * w + d[BY_Q] * q)
    speed = math.sqrt(u * u + v * v + w * w)
    force[NORMAL] += c.Z_star * u * u
    force[ROLLING] += ((speed - size) * c.roll_damping + c.roll_drag * abs(p)) * p
    force[ROLLING] += c.K_star * s.u_c * abs(s.u_c)
    force[PITCHING] += c.M_star * u * u


@inline_kernel
def surface_effect(vessel: Record, surface: int, state: Record) -> float:
    """Return u|u| times the effective angle of a surface [m2/s2], at most that of stall."""
    c, s = vessel[0], state[0]
    effect, most = 1.0, c.stall_ahead[surface]
    if s.u < 0.0:
        effect, most = c.astern_effect, c.stall_astern[surface]
    return s.u * abs(s.u) * effect * min(max(s.surface[surface], -most), most)


@inline_kernel
def add_surfaces(vessel: Record, state: Record, force: Numbers) -> None:
    """Add forces [N] and moments [N m] of rudder and planes, which reverse astern."""
    c, s = vessel[0], state[0]
    rudder = surface_effect(vessel, 0, state)
    stern, bow = surface_effect(vessel, 1, state), surface_effect(vessel, 2, state)
    drag = 0.0
    for i in range(3):
        drag += c.plane_drag[i] * s.surface[i] * s.surface[i]
    force[AXIAL] += s.u * abs(s.u) * drag
    force[LATERAL] += c.Y_dr * rudder
    force[NORMAL] += c.Z_ds * stern + c.Z_db * bow
    force[ROLLING] += c.K_dr * rudder
    force[PITCHING] += c.M_ds * stern + c.M_db * bow
    force[YAWING] += c.N_dr * rudder


@kernel
def forces(vessel: Record, state: Record, force: Numbers) -> None:
    """Write the forces of the wide set, without accelerations, to ``force``.

    They are X Y Z [N] and K M N [N m].
    """
    dry = dry_sail(vessel, state)
    body_forces(vessel, state, force)
    add_weight(vessel, state, force)
    add_ideal_fluid(vessel, dry, state, force)
    add_viscous(vessel, state, force)
    add_hull_strips(vessel, state, force)
    add_tail_and_sail(vessel, state, force)
    add_surfaces(vessel, state, force)
    if state[0].u < 0.0:
        force[AXIAL] += thrust_astern(vessel, state)
    else:
        force[AXIAL] += thrust(vessel, state)


@inline_kernel
def make_symmetric(out: Numbers) -> None:
    """Make the matrix of added masses symmetric, as an ideal fluid's is.

    Coefficients of a file need not be, and would then make energy.
    """
    for i in range(6):
        for j in range(i):
            mean = 0.5 * (out[i, j] + out[j, i])
            out[i, j] = out[j, i] = mean


@kernel
def accelerations(
    vessel: Record, equations: int, state: Record, scratch: Record, outer: Numbers
) -> None:
    """Write the accelerations of the wide set and of what acts from outside, solved exactly."""
    work = scratch[0]
    forces(vessel, state, work.force)
    for i in range(6):
        work.force[i] += outer[i]
    full.inertia(vessel, state, work.inertia)
    make_symmetric(work.inertia)
    if equations == LONGITUDINAL_EQUATIONS:
        full.mask_lateral(work.force, work.inertia)
    exact(work.inertia, work.force, work.system, work.wide)


@kernel
def correct(vessel: Record, equations: int, state: Record, scratch: Record, outer: Numbers) -> None:
    """Blend the accelerations in the state with those of the wide set.

    The share of the wide set is how far the state is outside the range.
    """
    share = wide_share(vessel, state)
    accelerations(vessel, equations, state, scratch, outer)
    s, wide = state[0], scratch[0].wide
    for i in range(6):
        if share < 1.0:
            s.rates[i] = (1.0 - share) * s.rates[i] + share * wide[i]
        else:
            s.rates[i] = wide[i]

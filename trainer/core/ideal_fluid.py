"""Products of velocities in an ideal fluid: Kirchhoff's equations, for any direction of the flow.

They do no work: their power is zero identically. They take the place of every product of
velocities in the file, which are lift of sail and hull at small angles.
"""

from trainer.core.kernel import Numbers, Record, part


@part
def add_ideal_fluid(vessel: Record, dry: float, state: Record, force: Numbers) -> None:
    """Add forces [N] and moments [N m] of the added masses; ``dry`` [-] of the sail is in air."""
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
    force[0] += r * aside - q * down
    force[1] += p * down - r * along
    force[2] += q * along - p * aside
    force[3] += r * pitch - q * yaw + w * aside - v * down
    force[4] += p * yaw - r * roll + u * down - w * along
    force[5] += q * roll - p * pitch + v * along - u * aside

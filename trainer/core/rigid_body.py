"""The boat's own mass and weight in the equations: [GH67]'s left sides in vectors.

The wide set takes them from here; ``full`` and ``compact`` have theirs written out, term by term as
the report has them.
"""

from trainer.core.elementary import cosine_and_sine
from trainer.core.full import mass
from trainer.core.kernel import Numbers, Record, inline_kernel
from trainer.core.state import AXIAL, LATERAL, NORMAL, PITCHING, ROLLING, YAWING


@inline_kernel
def body_forces(vessel: Record, state: Record, force: Numbers) -> None:
    """Write forces [N] and moments [N m] of a turning body's mass to ``force``.

    -m(omega x v + omega x (omega x r_G)) and -(r_G x m(omega x v) + omega x I omega).
    """
    c, s = vessel[0], state[0]
    p, q, r = s.p, s.q, s.r
    m = mass(vessel, state)
    ahead, aside, down = s.v * r - s.w * q, s.w * p - s.u * r, s.u * q - s.v * p
    spin = p * s.x_g + q * s.y_g + r * s.z_g
    square = p * p + q * q + r * r
    force[AXIAL] = m * (ahead + s.x_g * square - p * spin)
    force[LATERAL] = m * (aside + s.y_g * square - q * spin)
    force[NORMAL] = m * (down + s.z_g * square - r * spin)
    roll = c.I_x * p - c.I_xy * q - c.I_xz * r
    pitch = c.I_y * q - c.I_xy * p - c.I_yz * r
    yaw = c.I_z * r - c.I_xz * p - c.I_yz * q
    force[ROLLING] = m * (s.y_g * down - s.z_g * aside) + r * pitch - q * yaw
    force[PITCHING] = m * (s.z_g * ahead - s.x_g * down) + p * yaw - r * roll
    force[YAWING] = m * (s.x_g * aside - s.y_g * ahead) + q * roll - p * pitch


@inline_kernel
def add_weight(vessel: Record, state: Record, force: Numbers) -> None:
    """Add weight and buoyancy [N] and their moments [N m]."""
    c, s = vessel[0], state[0]
    cos_th, sin_th = cosine_and_sine(s.theta)
    cos_phi, sin_phi = cosine_and_sine(s.phi)
    down_x, down_y, down_z = -sin_th, cos_th * sin_phi, cos_th * cos_phi
    heavy = s.weight - c.buoyancy
    x = s.x_g * s.weight - c.x_b * c.buoyancy
    y = s.y_g * s.weight - c.y_b * c.buoyancy
    z = s.z_g * s.weight - c.z_b * c.buoyancy
    force[AXIAL] += heavy * down_x
    force[LATERAL] += heavy * down_y
    force[NORMAL] += heavy * down_z
    force[ROLLING] += y * down_z - z * down_y
    force[PITCHING] += z * down_x - x * down_z
    force[YAWING] += x * down_y - y * down_x

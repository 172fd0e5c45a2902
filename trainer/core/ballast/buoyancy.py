"""Changes of the hull's buoyancy under water, by depth and by layers of the sea.

The layers are denser or lighter water. The equations of motion have a constant buoyancy; these are
the forces of its departures. Those at the surface are in ``surfaced``.
"""

import math
from typing import Final

from trainer.core.elementary import cosine_and_sine
from trainer.core.kernel import Numbers, Record, inline_kernel
from trainer.core.state import AXIAL, LATERAL, NORMAL, PITCHING, ROLLING, YAWING

SMALL_SEGMENT: Final = 16.0 / (3.0 * math.pi)  # area of a small segment over (height/diameter)^1.5
SEGMENT_SLOPE: Final = 2.0 - 1.0 / (SMALL_SEGMENT * math.sqrt(0.125))  # half height, half area


@inline_kernel
def segment(height: float) -> float:
    """Return the share [-] of a circle's area above a chord.

    ``height`` [-] is the height of that segment over the diameter. It is the area of a small
    segment with one correction, within 0.4 % of the circle.
    """
    t = min(max(height, 0.0), 1.0)
    part = min(t, 1.0 - t)
    share = SMALL_SEGMENT * part * math.sqrt(part) * (1.0 - SEGMENT_SLOPE * part)
    return share if t <= 0.5 else 1.0 - share


@inline_kernel
def excess_density(ballast: Record, depth: float) -> float:
    """Return how much denser [kg/m3] the sea is at ``depth`` [m], interpolated between layers."""
    b = ballast[0]
    last = int(b.layers) - 1
    if last < 0:
        return 0.0
    if depth <= b.layer_depth[0]:
        return b.layer_density[0]
    for i in range(last):
        if depth < b.layer_depth[i + 1]:
            share = (depth - b.layer_depth[i]) / (b.layer_depth[i + 1] - b.layer_depth[i])
            return b.layer_density[i] + share * (b.layer_density[i + 1] - b.layer_density[i])
    return b.layer_density[last]


@inline_kernel
def submerged_change(vessel: Record, state: Record) -> float:
    """Return the change of buoyancy [N] under water.

    The hull is compressed, and the density of the sea changes.
    """
    c = vessel[0]
    depth = state[0].z
    squeezed = c.g * c.compressibility * (max(depth, 0.0) - c.reference_depth)
    return c.buoyancy * excess_density(vessel, depth) / c.rho - squeezed


@inline_kernel
def add_compression(vessel: Record, state: Record, force: Numbers) -> None:
    """Add the forces of the buoyancy that depth and layers take or give.

    They are X Y Z [N] and K M N [N m].
    """
    c = vessel[0]
    if c.compressibility == 0.0 and c.layers == 0.0:
        return
    s = state[0]
    cos_th, sin_th = cosine_and_sine(s.theta)
    cos_phi, sin_phi = cosine_and_sine(s.phi)
    down_x, down_y, down_z = -sin_th, cos_th * sin_phi, cos_th * cos_phi
    heavy = -submerged_change(vessel, state)
    x, z = heavy * c.x_b, heavy * c.z_b
    force[AXIAL] += heavy * down_x
    force[LATERAL] += heavy * down_y
    force[NORMAL] += heavy * down_z
    force[ROLLING] -= z * down_y
    force[PITCHING] += z * down_x - x * down_z
    force[YAWING] += x * down_y
    if c.y_b != 0.0:
        force[ROLLING] += heavy * c.y_b * down_z
        force[YAWING] -= heavy * c.y_b * down_x

"""Drag of the flow across the boat, by strips of hull, tail and sail.

``wide`` adds it where the flow is beyond the range of the equations of 1969. The hull has five
strips. The form is that of Healey & Lienard and of MSS. The coefficients are derived so that pure
sway and pure heave give the file's own Y_vav and Z_waw (docs/envelope.md). Each strip takes energy
from the boat.
"""

import math

from trainer.core.kernel import Numbers, Record, inline_kernel
from trainer.core.state import LATERAL, NORMAL, PITCHING, ROLLING, YAWING


@inline_kernel
def add_hull_strips(vessel: Record, state: Record, force: Numbers) -> None:
    """Add Y Z [N] and M N [N m] of the hull's strips.

    They lie at the stations of its buoyancy.
    """
    c, s = vessel[0], state[0]
    for i in range(c.crossflow_Y.size):
        x = c.station_x[i]
        aside, down = s.v + x * s.r, s.w - x * s.q
        speed = math.sqrt(aside * aside + down * down)
        lateral, normal = -c.crossflow_Y[i] * speed * aside, -c.crossflow_Z[i] * speed * down
        force[LATERAL] += lateral
        force[NORMAL] += normal
        force[PITCHING] -= x * normal
        force[YAWING] += x * lateral


@inline_kernel
def add_tail_and_sail(vessel: Record, state: Record, force: Numbers) -> None:
    """Add the cross-flow drag [N], [N m] of tail and sail in the water."""
    c, s = vessel[0], state[0]
    aside, down = s.v + c.tail_x * s.r, s.w - c.tail_x * s.q
    lateral, normal = -c.tail_Y * abs(aside) * aside, -c.tail_Z * abs(down) * down
    force[LATERAL] += lateral
    force[NORMAL] += normal
    force[PITCHING] -= c.tail_x * normal
    force[YAWING] += c.tail_x * lateral
    aside = s.v + c.strip_x * s.r - c.strip_z * s.p
    lateral = -c.strip_Y * math.sqrt(aside * aside + s.w * s.w) * aside
    force[LATERAL] += lateral
    force[ROLLING] -= c.strip_z * lateral
    force[YAWING] += c.strip_x * lateral

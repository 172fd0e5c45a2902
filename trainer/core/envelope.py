"""The range of the equations of 1969, and how far the motion is beyond it.

Ahead, with the flow within ``handover`` of the bow, the equations stand as they are. Beyond that
range, and going astern, ``wide`` takes their place. Between the two limits the accelerations of
both are blended. Sources of the forms: docs/envelope.md. The limits are this project's estimate:
the largest angle of flow in any turn or zig-zag of the shipped boats is 31 deg.
"""

import math
from typing import Final

from trainer.core.kernel import Field, Record, inline_kernel

INSIDE_RANGE, EXTRAPOLATED_RANGE, OUTSIDE_RANGE = 0, 1, 2
# rows and columns of thrust_astern, by u and the command speed
TURNING_ASTERN, TURNING_AHEAD = 0, 1
BY_U_U, BY_U_UC, BY_UC_UC = 0, 1, 2
# rows and columns of torque, by the revolutions n and the flow u/D
AHEAD, STOPPING, ASTERN = 0, 1, 2
BY_N_N, BY_N_FLOW, BY_FLOW_FLOW = 0, 1, 2
# columns of the linear viscous forces
BY_V, BY_P, BY_R = 0, 1, 2  # of lateral
BY_W, BY_Q = 0, 1  # of vertical

ENVELOPE_FIELDS: Final[tuple[Field, ...]] = (
    # range: squares of the tangent of the angle of flow
    "tested",  # [-] beyond it the equations are extrapolated
    "handover_from",  # [-] beyond it the wide set is blended in
    "handover_to",  # [-] beyond it the wide set is alone
    "cross_arm",  # [m2] square of the arm at which turning counts as cross flow
    "stiffness",  # [1/m] fastest mode of the boat in a flow of 1 m/s, over that speed
    "still_mode",  # [rad/s] faster of roll and pitch of a deep boat at rest
    # ideal fluid: added masses, positive and symmetric [kg, kg m, kg m2]
    ("added", ["m11", "m22", "m33", "m44", "m55", "m66", "m24", "m26", "m35", "m46"]),
    # linear viscous forces by v p r (Y K N) and by w q (Z M), ahead and astern
    ("lateral", (2, 3, 3)),
    ("vertical", (2, 2, 2)),
    "roll_damping",  # [N s2] by p and the whole speed, 0 or below
    "roll_drag",  # [N m s2] by p|p|, 0 or below, without the sail's part
    # cross-flow drag [N s2/m2] of the hull by station, of the tail and of the sail
    ("crossflow_Y", (5,)),
    ("crossflow_Z", (5,)),
    "tail_x",  # [m]
    "tail_Y",
    "tail_Z",
    "strip_x",  # [m] of the sail
    "strip_z",
    "strip_Y",
    "lift_x",  # [m] where the sail's lift acts
    "lift_z",
    "sail_lift",  # [N s2/m2] Y by u and v, less its sign
    "sail_mass",  # [kg] added mass of the sail in sway
    "sail_height",  # [m] of the sail above the deck
    # control surfaces, in the order of the state
    "astern_effect",  # [-] effect of a surface going astern over that ahead
    ("stall_ahead", (3,)),  # [rad] incidence from which a surface stalls
    ("stall_slope", (3,)),  # [-] share of the lift beyond that incidence that is left
    ("stall_astern", (3,)),  # [rad] angle from which it gains nothing astern
    ("stall_arm", (3,)),  # [m] where its incidence is taken
    ("plane_drag", (3,)),  # [N s2/m2] X by the angle squared
    # thrust less drag, going astern: a, b, c with the propeller turning astern, and ahead
    ("thrust_astern", (2, 3)),
    # at the surface
    "surface_line",  # [m] depth of the origin, below which nothing of the boat can emerge
    "station_reach",  # [m] of the station farthest from the origin, along the boat
    "hull_reach",  # [m] of the hull's side from the origin, at most
    "surface_damping",  # [-] damping ratio of a station that is cut
    "surface_mode",  # [rad/s] fastest mode of the boat afloat at its lightest
    "wave_drag",  # [N s6/m6] by u^6, the hull awash
    # engine
    "torque_limit",  # [1/s2] limit over rho D^5; 0: none
    "power_limit",  # [1/s3] limit over 2 pi rho D^5; 0: none besides that of torque
    # [-] of n^2, n u/D and (u/D)^2: turning ahead, turning astern while going ahead, both astern
    ("torque", (3, 3)),
    "turns",  # [1/m] revolutions a second for 1 m/s of command speed
    "screw",  # [m] diameter of the propeller
)

SUBSTEP_PHASE: Final = 0.25  # [rad] most of a mode's phase in a substep, at large angles
STILL_SUBSTEP: Final = 0.15  # [rad] likewise of a deep boat's roll or pitch, hardly damped
SURFACE_SUBSTEP: Final = 0.2  # [rad] likewise afloat
PROVED_TURN_RATIO: Final = (
    1.5  # [-] of the fastest turns: up to there the vessel's own step is proved
)
MOST_SUBSTEPS: Final = 64


@inline_kernel
def cross_speed_squared(vessel: Record, state: Record) -> float:
    """Return v^2 + w^2 with the speed at 0.3 lengths from the origin [m2/s2]."""
    s = state[0]
    return s.v * s.v + s.w * s.w + vessel[0].cross_arm * (s.q * s.q + s.r * s.r)


@inline_kernel
def wide_share(vessel: Record, state: Record) -> float:
    """Return the share of the wide set in the accelerations [-]: 0 inside, 1 outside."""
    c = vessel[0]
    cross, square = cross_speed_squared(vessel, state), state[0].u * state[0].u
    if state[0].u < 0.0:
        return 1.0
    if cross <= c.handover_from * square:
        return 0.0
    if cross >= c.handover_to * square:
        return 1.0
    x = (cross - c.handover_from * square) / ((c.handover_to - c.handover_from) * square)
    return x * x * (3.0 - 2.0 * x)


@inline_kernel
def validity(vessel: Record, state: Record) -> int:
    """Return how far the equations hold: INSIDE_RANGE, EXTRAPOLATED_RANGE or OUTSIDE_RANGE [-].

    ``update`` writes it to the state, and consoles warn by it.
    """
    c, s = vessel[0], state[0]
    cross, square = cross_speed_squared(vessel, state), s.u * s.u
    if s.u < 0.0 or cross > c.handover_from * square:
        return OUTSIDE_RANGE
    return EXTRAPOLATED_RANGE if cross > c.tested * square else INSIDE_RANGE


@inline_kernel
def substeps(vessel: Record, h: float, afloat: int, state: Record) -> int:
    """Return into how many parts a tick of ``h`` [s] is divided.

    A tick is divided where modes of the boat are too fast for it. ``afloat`` is 1 where the water's
    surface cuts the hull and the method feeds undamped modes. Modes grow faster with the boat's
    speed: so a sea that carries the boat faster than its propeller could asks for parts too.
    """
    c, s = vessel[0], state[0]
    phase = 0.0
    if c.u_c_ahead > 0.0:
        phase = s.u / (PROVED_TURN_RATIO * c.u_c_ahead)
    if wide_share(vessel, state) > 0.0:
        speed = math.sqrt(s.u * s.u + cross_speed_squared(vessel, state))
        phase = max(phase, h * c.stiffness * speed / SUBSTEP_PHASE)
        phase = max(phase, h * c.still_mode / STILL_SUBSTEP)
    if afloat != 0:
        phase = max(phase, h * c.surface_mode / SURFACE_SUBSTEP)
    return math.ceil(min(phase - 1e-9, MOST_SUBSTEPS)) if phase > 1.0 else 1

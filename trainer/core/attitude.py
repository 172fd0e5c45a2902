"""The attitude near the vertical, where Euler's angles are turned instead of advanced.

Within 15 deg of the vertical the rates of heel and heading have no bound. There the matrix of the
attitude is turned by the body's own rates over the step (Rodrigues' formula), and the angles are
read from it again. Pitch stays within 90 deg, heel within 180. The state has no quaternion, because
it would change the bits of every run. ``integrators`` calls it.
"""

import math
from typing import Final

from trainer.core.elementary import arctangent, cosine_and_sine
from trainer.core.kernel import Record, inline_kernel
from trainer.core.state import PAST_CYCLES, PHI, PSI, THETA

POLAR_PITCH: Final = 1.3089969389957472  # [rad] 75 deg; Euler's rates divide by cos theta
HALF_TURN: Final = 3.141592653589793
FULL_TURN: Final = 6.283185307179586


@inline_kernel
def is_polar(state: Record) -> bool:
    """Return whether the boat is within 15 deg of the vertical."""
    return bool(abs(state[0].theta) > POLAR_PITCH)


@inline_kernel
def rotated(
    a: float, b: float, c: float, turn: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return a row of the attitude's matrix [-] after a turn [rad].

    ``turn`` is about the three axes of the body.
    """
    x, y, z = turn
    square = x * x + y * y + z * z
    size = math.sqrt(square)
    if size < 1e-9:  # the limits: dividing so small a difference loses all its digits
        first, second = 1.0, 0.5
    else:
        cos_size, sin_size = cosine_and_sine(size)
        first, second = sin_size / size, (1.0 - cos_size) / square
    # a row times [turn]x, and that times [turn]x again
    a1, b1, c1 = b * z - c * y, c * x - a * z, a * y - b * x
    a2, b2, c2 = b1 * z - c1 * y, c1 * x - a1 * z, a1 * y - b1 * x
    return a + first * a1 + second * a2, b + first * b1 + second * b2, c + first * c1 + second * c2


@inline_kernel
def nearest_turn(angle: float, old: float) -> float:
    """Return ``angle`` [rad] plus the whole turns that bring it nearest to ``old`` [rad]."""
    return angle + FULL_TURN * math.floor((old - angle) / FULL_TURN + 0.5)


@inline_kernel
def turned(
    phi: float, theta: float, psi: float, turn: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return heel, pitch and heading [rad] after a turn [rad] about the body's axes."""
    cos_phi, sin_phi = cosine_and_sine(phi)
    cos_th, sin_th = cosine_and_sine(theta)
    cos_psi, sin_psi = cosine_and_sine(psi)
    north, _, _ = rotated(
        cos_psi * cos_th,
        cos_psi * sin_th * sin_phi - sin_psi * cos_phi,
        cos_psi * sin_th * cos_phi + sin_psi * sin_phi,
        turn,
    )
    east, _, _ = rotated(
        sin_psi * cos_th,
        sin_psi * sin_th * sin_phi + cos_psi * cos_phi,
        sin_psi * sin_th * cos_phi - cos_psi * sin_phi,
        turn,
    )
    x, y, z = rotated(-sin_th, cos_th * sin_phi, cos_th * cos_phi, turn)
    level = y * y + z * z
    pitch = arctangent(-x, math.sqrt(level))
    # straight up or down, heel and heading are one angle: heel keeps its value
    heel = arctangent(y, z) if level >= 1e-18 else phi
    return heel, pitch, nearest_turn(arctangent(east, north), psi)


@inline_kernel
def take_attitude(phi: float, theta: float, psi: float, state: Record) -> None:
    """Set heel, pitch and heading [rad]; move the past motion by the same jump.

    A method that looks back would otherwise take the jump for motion: past the vertical heel and
    heading turn by 180 deg at once.
    """
    s = state[0]
    jump_phi, jump_theta, jump_psi = phi - s.phi, theta - s.theta, psi - s.psi
    s.phi, s.theta, s.psi = phi, theta, psi
    for back in range(PAST_CYCLES):
        s.past_motion[back, PHI] += jump_phi
        s.past_motion[back, THETA] += jump_theta
        s.past_motion[back, PSI] += jump_psi


@inline_kernel
def is_beyond(state: Record) -> bool:
    """Return whether heel is beyond half a turn, or pitch beyond the vertical."""
    s = state[0]
    return abs(s.theta) > 0.5 * HALF_TURN or abs(s.phi) > HALF_TURN


@inline_kernel
def bring_within(state: Record) -> None:
    """Bring heel within half a turn and pitch within a quarter, for the same attitude."""
    s = state[0]
    heel, pitch, heading = turned(s.phi, s.theta, s.psi, (0.0, 0.0, 0.0))
    take_attitude(heel, pitch, heading, state)


@inline_kernel
def forget_rates(state: Record) -> None:
    """Replace the past rates of the attitude by the present ones.

    The boat has just left the vertical, where these rates had no bound: as at a start, errata D10.
    """
    s = state[0]
    for i in range(3):
        for back in range(PAST_CYCLES):
            s.past_rates[back, PHI + i] = s.rates[PHI + i]

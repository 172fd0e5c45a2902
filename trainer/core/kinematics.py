"""Euler angles and earth velocities, [ASSES] (7), and the two programs' trigonometry."""

from trainer.core.elementary import cosine, cosine_and_sine, sine
from trainer.core.kernel import Record, part

EXACT_TRIGONOMETRY, POLYNOMIAL_TRIGONOMETRY, LINEAR_TRIGONOMETRY = (
    0,
    1,
    2,
)  # trigonometry of pitch and roll

MIN_PITCH_COSINE = 0.02  # smallest |cos theta| used: the equations are singular at 90 degrees


@part
def pitch_roll_sine(trig: int, angle: float) -> float:
    """Return the sine [-] of pitch or roll [rad] as the equation set takes it.

    Errata C21-C23.
    """
    if trig == POLYNOMIAL_TRIGONOMETRY:
        return angle - angle * angle * angle / 6.0
    if trig == LINEAR_TRIGONOMETRY:
        return 0.971 * angle
    return sine(angle)


@part
def pitch_roll_cosine(trig: int, angle: float) -> float:
    """Return the cosine [-] of pitch or roll [rad] as the equation set takes it."""
    if trig == POLYNOMIAL_TRIGONOMETRY:
        square = angle * angle
        return 1.0 - square / 2.0 + square * square / 24.0
    if trig == LINEAR_TRIGONOMETRY:
        return 1.02 - 0.281 * abs(angle)
    return cosine(angle)


@part
def guard_cosine(cos_theta: float) -> float:
    """Return ``cos_theta`` [-] kept away from zero."""
    if abs(cos_theta) >= MIN_PITCH_COSINE:
        return cos_theta
    return MIN_PITCH_COSINE if cos_theta >= 0.0 else -MIN_PITCH_COSINE


@part
def kinematics(trig: int, state: Record) -> None:
    """Write the rates of attitude and of place through the water, [ASSES] (7), errata A16-A19."""
    s = state[0]
    sin_phi, cos_phi = pitch_roll_sine(trig, s.phi), pitch_roll_cosine(trig, s.phi)
    sin_th, cos_th = pitch_roll_sine(trig, s.theta), pitch_roll_cosine(trig, s.theta)
    cos_psi, sin_psi = cosine_and_sine(s.psi)

    s.thetadot = s.q * cos_phi - s.r * sin_phi
    s.psidot = (s.q * sin_phi + s.r * cos_phi) / guard_cosine(cos_th)
    s.phidot = s.p + s.psidot * sin_th

    # turn about the boat's three axes one after the other: roll, pitch, heading
    across, down = s.v * cos_phi - s.w * sin_phi, s.v * sin_phi + s.w * cos_phi
    along = s.u * cos_th + down * sin_th
    s.through_north = s.xdot = along * cos_psi - across * sin_psi
    s.through_east = s.ydot = along * sin_psi + across * cos_psi
    s.zdot = down * cos_th - s.u * sin_th

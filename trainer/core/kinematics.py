"""Euler angles and earth velocities, [ASSES] (7), and the two programs' trigonometry."""

from trainer.core.elementary import cosine, cosine_and_sine, sine
from trainer.core.kernel import Record, part

EXACT, POLYNOMIAL, LINEAR = 0, 1, 2  # trigonometry of pitch and roll

STEEPEST = 0.02  # smallest |cos theta| used: the equations are singular at 90 degrees


@part
def pitch_roll_sine(trig: int, angle: float) -> float:
    """Return the sine [-] of pitch or roll [rad] as the equation set takes it (errata C21-C23)."""
    if trig == POLYNOMIAL:
        return angle - angle * angle * angle / 6.0
    if trig == LINEAR:
        return 0.971 * angle
    return sine(angle)


@part
def pitch_roll_cosine(trig: int, angle: float) -> float:
    """Return the cosine [-] of pitch or roll [rad] as the equation set takes it."""
    if trig == POLYNOMIAL:
        square = angle * angle
        return 1.0 - square / 2.0 + square * square / 24.0
    if trig == LINEAR:
        return 1.02 - 0.281 * abs(angle)
    return cosine(angle)


@part
def guarded(cos_theta: float) -> float:
    """Return ``cos_theta`` [-] kept away from zero."""
    if abs(cos_theta) >= STEEPEST:
        return cos_theta
    return STEEPEST if cos_theta >= 0.0 else -STEEPEST


@part
def kinematics(trig: int, state: Record) -> None:
    """Write the rates of attitude and position, [ASSES] (7) with errata A16-A19."""
    s = state[0]
    sin_phi, cos_phi = pitch_roll_sine(trig, s.phi), pitch_roll_cosine(trig, s.phi)
    sin_th, cos_th = pitch_roll_sine(trig, s.theta), pitch_roll_cosine(trig, s.theta)
    cos_psi, sin_psi = cosine_and_sine(s.psi)

    s.thetadot = s.q * cos_phi - s.r * sin_phi
    s.psidot = (s.q * sin_phi + s.r * cos_phi) / guarded(cos_th)
    s.phidot = s.p + s.psidot * sin_th

    s.xdot = (
        s.u * cos_th * cos_psi
        + s.v * (sin_phi * sin_th * cos_psi - cos_phi * sin_psi)
        + s.w * (cos_phi * sin_th * cos_psi + sin_phi * sin_psi)
    )
    s.ydot = (
        s.u * cos_th * sin_psi
        + s.v * (sin_phi * sin_th * sin_psi + cos_phi * cos_psi)
        + s.w * (cos_phi * sin_th * sin_psi - sin_phi * cos_psi)
    )
    s.zdot = -s.u * sin_th + s.v * cos_th * sin_phi + s.w * cos_th * cos_phi

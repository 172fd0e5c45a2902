"""The rates of attitude and location that follow from the boat's own motion, [ASSES] (7).

The symbols of this module, ``compact`` and ``full`` are those of [GH67], which [ASSES] took over.
Axes of the boat: x forward, y to starboard, z to the keel, from an origin on the hull's axis. Axes
of the earth: x north, y east, z down. Dots are rates. All are SI, angles in radians.

    u v w            velocity of the origin through the water, along the boat's axes
    p q r            turn about them: roll, pitch, yaw
    phi theta psi    heel to starboard, pitch bow up, heading; turned in the order psi, theta, phi
    x y z            the origin over the earth; z is its depth
    X Y Z, K M N     forces along the boat's axes, moments about them, and their coefficients: the
                     letters after one are its factors, "vav" v |v|, "star" none
    delta_r          rudder, trailing edge to port: it turns the boat to port
    delta_s delta_b  stern planes (dive) and bow planes (rise), trailing edge down
    u_c              command speed: the propeller's revolutions times a constant; eta = u_c / u
    x_g y_g z_g      centre of gravity; x_B y_B z_B of buoyancy

Sine and cosine of pitch and roll may be exact, or one of the two approximations of the report's
compact programs, which a scheme can ask for to compute as they did.

``rates`` calls it in each evaluation, a fleet for its lanes. ``surfaced`` takes the attitude from
here, always exact, because its equations are not the report's.
"""

from trainer.core.elementary import cosine_and_sine
from trainer.core.kernel import Record, inline_kernel

EXACT_TRIGONOMETRY, POLYNOMIAL_TRIGONOMETRY, LINEAR_TRIGONOMETRY = (
    0,
    1,
    2,
)  # trigonometry of pitch and roll

Attitude = tuple[float, float, float, float]  # [-] sine and cosine of roll, then of pitch

MIN_PITCH_COSINE = 0.02  # [-] of |cos theta|: the equations are singular at 90 degrees


@inline_kernel
def pitch_roll_sine_and_cosine(trig: int, angle: float) -> tuple[float, float]:
    """Return sine and cosine [-] of pitch or roll [rad].

    ``trig`` says how: exactly, by polynomials, or by straight lines (errata C21-C23).
    """
    if trig == POLYNOMIAL_TRIGONOMETRY:
        square = angle * angle
        return angle - square * angle / 6.0, 1.0 - square / 2.0 + square * square / 24.0
    if trig == LINEAR_TRIGONOMETRY:
        return 0.971 * angle, 1.02 - 0.281 * abs(angle)
    cos_angle, sin_angle = cosine_and_sine(angle)
    return sin_angle, cos_angle


@inline_kernel
def attitude_of(trig: int, state: Record) -> Attitude:
    """Return sine and cosine [-] of roll and pitch, as the equation set takes them."""
    s = state[0]
    sin_phi, cos_phi = pitch_roll_sine_and_cosine(trig, s.phi)
    sin_th, cos_th = pitch_roll_sine_and_cosine(trig, s.theta)
    return sin_phi, cos_phi, sin_th, cos_th


@inline_kernel
def guard_cosine(cos_theta: float) -> float:
    """Return ``cos_theta`` [-] kept away from zero."""
    if abs(cos_theta) >= MIN_PITCH_COSINE:
        return cos_theta
    return MIN_PITCH_COSINE if cos_theta >= 0.0 else -MIN_PITCH_COSINE


@inline_kernel
def kinematics(attitude: Attitude, state: Record) -> None:
    """Write the rates of attitude and of x, y, z, [ASSES] (7), errata A16-A19."""
    s = state[0]
    sin_phi, cos_phi, sin_th, cos_th = attitude
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

"""Forces of the waves on the submerged boat: Froude-Krylov and added mass, flow, suction.

The water's own acceleration at the depth of the axis pushes on the hull in STRIP_COUNT along it,
each with its displaced mass and its added masses down and sideways. Hull and waves are seen from
above, so that pitch and heel do not enter. The first-order forms are an extension of this
project's: [ASSES] computed its forces but did not print them. Take one component of amplitude a and
wave number k at depth d, heading off by chi, with phase A above the boat's origin and E = g k
exp(-k d). At the strip x_i ahead of the origin, with c_i = cos(k x_i cos chi) and s_i = sin(k x_i
cos chi):

    C_i = E a (cos A c_i + sin A s_i)               S_i = E a (sin A c_i - cos A s_i)
    X = -cos chi sum (m_i + x_i) S_i                Z = sum (m_i + a_i) C_i
    Y = -sin chi sum (m_i + b_i) S_i                M = -sum (m_i + a_i) x_i C_i
    N = -sin chi sum (m_i + b_i) x_i S_i               K = -(K_vdot + z_B B/g) a_y

m_i are shares of B/g, and those of -X_udot lie as they do; a_i are of -Z_wdot, b_i of -Y_vdot.
Their sums are tabulated over k cos chi. Seven strips stand for the hull in waves down to a quarter
of its length. In shorter waves the rest of the sums, some 3 %, fades to zero at a fifth of it.
a_y is the water's mean acceleration to starboard, Y/(B/g - Y_vdot). The boat's own acceleration
has the moment K_vdot: without K the water would roll a boat that it only carries along.

The hull's lift ahead feels the water's own vertical speed, w_o = E a sin A/omega downwards:

    Z = -Z_w u w_o       M = -M_w u w_o

Suction acts when the sea asks for it. Water that swings faster above than below draws a body up
with the mean gradient of half its speed squared, k E^2 a^2/(g k) per unit mass, so with (B/g -
Z_wdot) (E a)^2/g. For a circular cylinder, whose added mass is its own, that is 2 pi rho g (k R)^2
a^2 exp(-2 k d) per metre, the long-wave limit of T. Ogilvie, "First- and second-order forces on a
cylinder submerged under a free surface", J. Fluid Mech. 16 (1963) 451. For many waves the squared
envelope of E a takes the place of (E a)^2: its mean is the sum of the waves' own, and it varies
slowly with the groups. The boat is taken as held still; one that follows the waves is drawn up
less. Suction gives no moment.

The waves of the filter have a pair of outputs of their own for the force. It has the energy that is
left at the depth, with the length of the waves that are left there: an estimate. On a boat afloat
it has the length of the peak wave, as the water's levels have: an estimate too.

``update`` calls ``wave_forces`` once a tick, and ``boat/linear`` for gains that know the waves.
``ballast/hover`` and ``analysis/seaway`` ask for the mean suction alone.
"""

import math
from typing import Final

import numpy as np

from trainer.core.elementary import cosine_and_sine, exponential, logarithm
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.sea.cosine_sum import COMPONENT_COS, COMPONENT_SIN, write_phases
from trainer.core.state import (
    AXIAL,
    LATERAL,
    NORMAL,
    PITCHING,
    ROLLING,
    SEA_COMPONENTS,
    STRIP_COUNT,
    STRIP_ROWS,
    YAWING,
)
from trainer.core.surfaced import is_shallow, share_above

TAPER_DIAMETERS: Final = (
    4.0,
    5.0,
)  # [-] hull diameters from which to which waves fade out ([ASSES])
ROWS_PER_TURN: Final = 3.0  # [1/rad] rows of the strips' table for each radian of k L cos chi
LAST_TRUE: Final = 72  # row of the table, 24 rad, beyond which it fades to zero
SUM_NUMBERS: Final = 4  # of each sum over strips
COS, SIN, X_COS, X_SIN = 0, 1, 2, 3  # their indices
STATION, SHARES = 0, 1  # rows of the strips: x over the length, then three shares
SURGE, SWAY, SWAY_ADDED, HEAVE, HEAVE_ADDED, PITCH, PITCH_ADDED = range(7)  # sums over the waves
YAW, YAW_ADDED, RISE, SWING, FLOW = range(7, 12)
# ln of the integral of S(x) x^n exp(-2 kappa x^2) over the Pierson-Moskowitz spectrum, n 4 and 6,
# by 1, ln kappa, sqrt kappa, kappa and kappa^2. Fitted by this project, within 0.3 % from
# kappa 0.3 to 8
FADING_FIT: Final = np.array(
    [
        [2.04138, -0.0429752, -3.922061, -0.477556, 0.003725196],
        [1.853509, -0.622394, -3.445212, -0.556254, 0.005174789],
    ]
)
BY_1, BY_LOG, BY_ROOT, BY_KAPPA, BY_SQUARE = 0, 1, 2, 3, 4  # columns of it
MIN_KAPPA: Final = 0.3  # [-] kappa
MAX_KAPPA: Final = 60.0  # of the fit: no wave is left


@inline_kernel
def taper(vessel: Record, state: Record) -> float:
    """Return the share of the waves that is left at this depth [-].

    It is [ASSES]'s rule of five diameters.
    """
    s = state[0]
    diameter = vessel[0].diameter
    if s.sea_taper == 0.0 or diameter <= 0.0:
        return 1.0
    begins, ends = TAPER_DIAMETERS
    t = min(max(s.z / diameter - begins, 0.0) / (ends - begins), 1.0)
    return 1.0 - t * t * (3.0 - 2.0 * t)


@inline_kernel
def fading(row: int, kappa: float) -> float:
    """Return ln of one of FADING_FIT's integrals [-].

    ``kappa`` is the peak's wave number times the depth.
    """
    root = math.sqrt(kappa)
    value = (
        FADING_FIT[row, BY_1]
        + FADING_FIT[row, BY_LOG] * logarithm(kappa)
        + FADING_FIT[row, BY_ROOT] * root
    )
    return value + kappa * (FADING_FIT[row, BY_KAPPA] + FADING_FIT[row, BY_SQUARE] * kappa)


@kernel
def suction(g: float, omega: float, height: float, depth: float) -> tuple[float, float]:
    """Return the mean suction [N/kg] at ``depth`` [m], and its decrease with depth [N/kg/m].

    It is that of a Pierson-Moskowitz sea of significant ``height`` [m] with its peak at ``omega``
    [rad/s], for each kg of displaced mass and added mass in heave: g k^2 Hs^2/8 I2 and g k^3 Hs^2/4
    I3. Nearer to the surface than kappa 0.3 it is as it is there.
    """
    number = omega * omega / g
    kappa = min(max(number * depth, MIN_KAPPA), MAX_KAPPA)
    force = 0.125 * g * number * number * height * height
    lift = force * exponential(fading(0, kappa))
    return lift, 2.0 * number * force * exponential(fading(1, kappa))


@inline_kernel
def kept(row: int) -> float:
    """Return the share [-] that a row of the strips' table keeps.

    Sums of waves too short for the strips fade to zero.
    """
    t = max(row - LAST_TRUE, 0.0) / (STRIP_ROWS - LAST_TRUE)
    return 1.0 - t * t * (3.0 - 2.0 * t)


@inline_kernel
def are_summed(vessel: Record, scratch: Record) -> bool:
    """Return whether the table in the work space was summed over this boat's strips."""
    c, work = vessel[0], scratch[0]
    same = 0
    for i in range(4):
        for strip in range(STRIP_COUNT):
            same += 1 if work.strips_of[i, strip] == c.strips[i, strip] else 0
    return same == 4 * STRIP_COUNT


@inline_kernel
def add_strip(row: int, strip: int, scratch: Record) -> None:
    """Add a strip to the sums of a row of the table."""
    work = scratch[0]
    x = work.strips_of[STATION, strip]
    turn_cos, turn_sin = cosine_and_sine(row / ROWS_PER_TURN * x)
    for kind in range(3):
        share = kept(row) * work.strips_of[SHARES + kind, strip]
        work.strip_sums[row, kind, COS] += share * turn_cos
        work.strip_sums[row, kind, SIN] += share * turn_sin
        work.strip_sums[row, kind, X_COS] += share * x * turn_cos
        work.strip_sums[row, kind, X_SIN] += share * x * turn_sin


@kernel
def prepare_strips(vessel: Record, scratch: Record) -> None:
    """Write the sums over the boat's strips by wave number."""
    c, work = vessel[0], scratch[0]
    for i in range(4):
        for strip in range(STRIP_COUNT):
            work.strips_of[i, strip] = c.strips[i, strip]
    for row in range(STRIP_ROWS + 1):
        for kind in range(3):
            for j in range(SUM_NUMBERS):
                work.strip_sums[row, kind, j] = 0.0
        for strip in range(STRIP_COUNT):
            add_strip(row, strip, scratch)


@inline_kernel
def strip_row(kappa: float) -> tuple[int, float]:
    """Return the row of the strips' table before ``kappa`` [rad].

    The second number says where ``kappa`` is beyond it, 0 to 1.
    """
    x = ROWS_PER_TURN * abs(kappa)
    if not x < STRIP_ROWS:
        return STRIP_ROWS - 1, 1.0
    row = math.floor(x)
    return row, x - row


@inline_kernel
def strip_sum(scratch: Record, row: int, inside: float, kind: int, j: int) -> float:
    """Return a sum over the strips [-], between two rows of the table."""
    work = scratch[0]
    before = work.strip_sums[row, kind, j]
    return before + inside * (work.strip_sums[row + 1, kind, j] - before)


@inline_kernel
def at_strips(
    scratch: Record, at: tuple[int, float], kind: int, first: int, even: float, odd: float
) -> tuple[float, float]:
    """Return the sums over the strips of C_i and S_i [m/s2].

    They follow from C and S at the origin, ``even`` and ``odd`` [m/s2]. ``at`` is the wave's
    ``strip_row``. ``first`` is 0 for the sums of the shares, 2 for those of the shares times x in
    lengths.
    """
    work = scratch[0]
    row, inside = at
    c = strip_sum(scratch, row, inside, kind, first)
    s = strip_sum(scratch, row, inside, kind, first + 1)
    if work.kappa < 0.0:
        s = -s
    return even * c + odd * s, odd * c - even * s


@kernel
def raise_levels(scratch: Record, k: float, a_cos: float, a_sin: float) -> None:
    """Add one wave to the water's level [m] and its rate [m/s] at the stations.

    At x ahead of the origin its phase is k x cos chi less than at the origin.
    """
    work = scratch[0]
    omega = math.sqrt(work.g * k)
    for i in range(work.station.size):
        turn_cos, turn_sin = cosine_and_sine(k * work.station[i] * work.along)
        work.level[i] += a_cos * turn_cos + a_sin * turn_sin
        work.rise[i] -= omega * (a_sin * turn_cos - a_cos * turn_sin)


@inline_kernel
def add_component(scratch: Record, omega: float, rise: float, swing: float) -> None:
    """Add one wave to the sums.

    It has the frequency ``omega`` [rad/s]; ``rise`` and ``swing`` are E a cos A and E a sin A
    [m/s2].
    """
    work = scratch[0]
    work.kappa = omega * omega / work.g * work.ell * work.along
    at = strip_row(work.kappa)
    heave, surge = at_strips(scratch, at, 0, 0, rise, swing)
    pitch, yaw = at_strips(scratch, at, 0, 2, rise, swing)
    heave_added, _ = at_strips(scratch, at, 1, 0, rise, swing)
    pitch_added, _ = at_strips(scratch, at, 1, 2, rise, swing)
    _, sway_added = at_strips(scratch, at, 2, 0, rise, swing)
    _, yaw_added = at_strips(scratch, at, 2, 2, rise, swing)
    work.pull[SURGE] -= work.along * surge
    work.pull[SWAY] -= work.across * surge
    work.pull[SWAY_ADDED] -= work.across * sway_added
    work.pull[HEAVE] += heave
    work.pull[HEAVE_ADDED] += heave_added
    work.pull[PITCH] -= pitch
    work.pull[PITCH_ADDED] -= pitch_added
    work.pull[YAW] -= work.across * yaw
    work.pull[YAW_ADDED] -= work.across * yaw_added
    work.pull[RISE] += rise
    work.pull[SWING] += swing
    work.pull[FLOW] += swing / omega


@inline_kernel
def filter_number(vessel: Record, number: float, scratch: Record, state: Record) -> float:
    """Return the wave number [1/m] of the filter's push; ``number`` is the peak's.

    It is that of the waves that are left at the depth. A hull that the surface cuts is pushed up by
    its waterplane and down by the water's acceleration, which nearly cancel about its own period.
    They do so in waves of one length only, and that of the water's levels is the peak's.
    """
    c, s = vessel[0], state[0]
    work = scratch[0]
    if not is_shallow(vessel, state):
        return s.push_number
    covered = 2.0 * (work.depth + c.hull_axis) / c.hull_diameter - 1.0
    return number + min(max(covered, 0.0), 1.0) * (s.push_number - number)


@inline_kernel
def add_wave_filter(vessel: Record, a: float, scratch: Record, state: Record) -> None:
    """Add the force of the wave filter, as one wave.

    ``a`` [m] is the waves' standard deviation. The water's level has the length of the peak.
    """
    s = state[0]
    work = scratch[0]
    number = s.sea_omega * s.sea_omega / work.g
    size = a * work.g * number * exponential(-number * work.depth)
    omega = math.sqrt(work.g * filter_number(vessel, number, scratch, state))
    add_component(scratch, omega, size * s.push_cos, size * s.push_sin)
    if work.levels != 0.0:
        raise_levels(scratch, number, a * s.wave_cos, a * s.wave_sin)


@inline_kernel
def add_filter_1969(scratch: Record, a: float, state: Record) -> None:
    """Add the waves of the filter of 1969.

    All are taken as one wave of the peak's number; ``a`` [m] is their standard deviation.
    """
    s = state[0]
    work = scratch[0]
    number = s.sea_omega * s.sea_omega / work.g
    size = a * work.g * number * exponential(-number * work.depth)
    add_component(scratch, s.sea_omega, size * s.sea_elevation, size * s.sea_quadrature)
    if work.levels != 0.0:
        raise_levels(scratch, number, a * s.sea_elevation, a * s.sea_quadrature)


@inline_kernel
def add_filters(vessel: Record, scratch: Record, state: Record) -> None:
    """Add the waves of the filters in use to the sums."""
    s = state[0]
    work = scratch[0]
    work.along, work.across = cosine_and_sine(s.sea_direction - s.psi)
    a = 0.25 * s.sea_height * math.sqrt(1.0 - s.sea_cosines)
    if s.sea_1969 < 1.0:
        add_wave_filter(vessel, a * math.sqrt(1.0 - s.sea_1969), scratch, state)
    if s.sea_1969 > 0.0:
        add_filter_1969(scratch, a * math.sqrt(s.sea_1969), state)


@kernel
def add_sum(scratch: Record, state: Record) -> None:
    """Add each component of the cosine sum to the sums."""
    s = state[0]
    work = scratch[0]
    height = 0.25 * s.sea_height * math.sqrt(s.sea_cosines)
    chi_cos, chi_sin = cosine_and_sine(s.sea_direction - s.psi)
    write_phases(scratch, state)
    peak, g, depth = s.sea_omega, work.g, work.depth
    for i in range(SEA_COMPONENTS):  # several at once, as those above and unlike those below
        omega = peak * work.relative[i]
        number = omega * omega / g
        size = height * work.amplitude[i] * g * number * exponential(-number * depth)
        work.pull_cos[i], work.pull_sin[i] = size * work.phase_cos[i], size * work.phase_sin[i]
    for i in range(SEA_COMPONENTS):
        work.along = chi_cos * COMPONENT_COS[i] - chi_sin * COMPONENT_SIN[i]
        work.across = chi_sin * COMPONENT_COS[i] + chi_cos * COMPONENT_SIN[i]
        omega = peak * work.relative[i]
        add_component(scratch, omega, work.pull_cos[i], work.pull_sin[i])
        if work.levels != 0.0:
            a, number = height * work.amplitude[i], omega * omega / g
            raise_levels(scratch, number, a * work.phase_cos[i], a * work.phase_sin[i])


@inline_kernel
def push(vessel: Record, scratch: Record, left: float, state: Record, force: Numbers) -> None:
    """Add the forces [N] and moments [N m] of the sums.

    ``left`` [-] is the share of them that is felt.
    """
    c, s = vessel[0], state[0]
    work = scratch[0]
    displaced, arm = left * c.buoyancy / c.g, left * c.ell
    sway, heave = left * c.Y_vdot, left * c.Z_wdot
    swell = work.pull[RISE] * work.pull[RISE] + work.pull[SWING] * work.pull[SWING]
    flow = left * max(s.u, 0.0) * work.pull[FLOW]
    force[AXIAL] += (displaced - left * c.X_udot) * work.pull[SURGE]
    force[LATERAL] += displaced * work.pull[SWAY] - sway * work.pull[SWAY_ADDED]
    force[NORMAL] += displaced * work.pull[HEAVE] - heave * work.pull[HEAVE_ADDED]
    force[NORMAL] -= (displaced - heave) * s.sea_suction * left * swell / c.g + c.Z_w * flow
    force[PITCHING] += (
        displaced * c.ell * work.pull[PITCH] - arm * c.Z_wdot * work.pull[PITCH_ADDED]
    )
    force[PITCHING] -= c.M_w * flow
    force[YAWING] += displaced * c.ell * work.pull[YAW] - arm * c.Y_vdot * work.pull[YAW_ADDED]
    mass = c.buoyancy / c.g
    aside = mass * work.pull[SWAY] - c.Y_vdot * work.pull[SWAY_ADDED]
    force[ROLLING] -= left * (c.K_vdot + c.z_b * mass) * aside / (mass - c.Y_vdot)


@inline_kernel
def wave_forces(vessel: Record, scratch: Record, state: Record, force: Numbers) -> None:
    """Add the forces [N] and moments [N m] of the sea in force.

    ``scratch`` has the SEA record. A boat above the mean surface is taken as at it, and what is
    above the water feels nothing.
    """
    c = vessel[0]
    s = state[0]
    work = scratch[0]
    left = taper(vessel, state)
    if s.sea_height == 0.0 or left == 0.0:
        return
    if not are_summed(vessel, scratch):
        prepare_strips(vessel, scratch)
    work.g, work.depth, work.ell = c.g, max(s.z, 0.0), c.ell
    for i in range(work.pull.size):
        work.pull[i] = 0.0
    if s.sea_cosines < 1.0:
        add_filters(vessel, scratch, state)
    if s.sea_cosines > 0.0:
        add_sum(scratch, state)
    if work.levels != 0.0:
        left *= 1.0 - share_above(vessel, scratch, state)
    push(vessel, scratch, left, state, force)

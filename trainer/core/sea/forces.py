"""Forces of the waves on the submerged boat: Froude-Krylov and added mass, and the suction.

Each component is long against the hull's beam and pushes with the water's own acceleration at the
depth of the axis, averaged over the length; hull and waves are seen from above, so that pitch and
heel do not enter. The first-order forms are an extension of this project's: [ASSES] computed but
did not print its forces. Of one component of amplitude a and wave number k at depth d, heading off
by chi, phase A above the boat, kappa = (k l/2) cos chi and E = g k exp(-k d):

    X = -(B/g - X_udot) E a sin A cos chi S0        Y = -(B/g - Y_vdot) E a sin A sin chi S0
    Z =  (B/g - Z_wdot) E a cos A S0                M = -(B/g - Z_wdot) E a sin A (l/2) S1
    N =  (B/g - Y_vdot) E a cos A sin chi (l/2) S1

Suction, when the sea asks for it: water that swings faster above than below draws a body up with
the mean gradient of half its speed squared, k E^2 a^2/(g k) per unit mass, so with
(B/g - Z_wdot) (E a)^2/g. For a circular cylinder, whose added mass is its own, that is
2 pi rho g (k R)^2 a^2 exp(-2 k d) per metre, the long-wave limit of T. Ogilvie, "First- and
second-order forces on a cylinder submerged under a free surface", J. Fluid Mech. 16 (1963) 451.
Of many waves the squared envelope of E a takes the place of (E a)^2: the mean is that of each
by itself, and it varies slowly with the groups. The boat is taken as held still; one that follows
the waves is drawn up less. It gives no moment.
"""

import math
from typing import Final

import numpy as np

from trainer.core.elementary import cosine_and_sine, exponential, logarithm
from trainer.core.kernel import Numbers, Record, kernel, part
from trainer.core.sea.cosine_sum import ANGLE_COS, ANGLE_SIN, BANDS, phase
from trainer.core.state import SEA_COMPONENTS
from trainer.core.surfaced import share_above

TAPER: Final = (4.0, 5.0)  # [-] hull diameters from which to which waves fade out ([ASSES])


@part
def spread(kappa: float) -> tuple[float, float]:
    """Return S0 = sin kappa/kappa and S1 = (sin kappa - kappa cos kappa)/kappa^2 [-]."""
    z = kappa * kappa
    if z < 0.25:
        p = 1.0 - z / 42.0 * (1.0 - z / 72.0 * (1.0 - z / 110.0 * (1.0 - z / 156.0)))
        s0 = 1.0 - z / 6.0 * (1.0 - z / 20.0 * p)
        p = 1.0 - z / 54.0 * (1.0 - z / 88.0 * (1.0 - z / 130.0))
        return s0, kappa / 3.0 * (1.0 - z / 10.0 * (1.0 - z / 28.0 * p))
    cos_kappa, sin_kappa = cosine_and_sine(kappa)
    return sin_kappa / kappa, (sin_kappa - kappa * cos_kappa) / z


@part
def taper(vessel: Record, state: Record) -> float:
    """Return what is left of the waves [-] at this depth by [ASSES]'s rule of five diameters."""
    s = state[0]
    diameter = vessel[0].diameter
    if s.sea_taper == 0.0 or diameter <= 0.0:
        return 1.0
    t = min(max(s.z / diameter - TAPER[0], 0.0) / (TAPER[1] - TAPER[0]), 1.0)
    return 1.0 - t * t * (3.0 - 2.0 * t)


@kernel
def raise_levels(scratch: Record, k: float, chi_cos: float, a_cos: float, a_sin: float) -> None:
    """Add one wave to the water's level [m] at the stations, and to its rate there [m/s].

    Its phase at x ahead of the origin is k x cos chi less than at the origin.
    """
    work = scratch[0]
    omega = math.sqrt(work.g * k)
    for i in range(work.station.size):
        turn_cos, turn_sin = cosine_and_sine(k * work.station[i] * chi_cos)
        work.level[i] += a_cos * turn_cos + a_sin * turn_sin
        work.rise[i] -= omega * (a_sin * turn_cos - a_cos * turn_sin)


@part
def add_component(
    scratch: Record, k: float, chi_cos: float, chi_sin: float, a_cos: float, a_sin: float
) -> None:
    """Add to the sums one wave by its number [1/m], heading off, a cos A and a sin A [m]."""
    work = scratch[0]
    size = work.g * k * exponential(-k * work.depth)
    s0, s1 = spread(k * work.half_length * chi_cos)
    swing, heave = size * a_sin, size * a_cos
    work.pull[0] -= swing * chi_cos * s0
    work.pull[1] -= swing * chi_sin * s0
    work.pull[2] += heave * s0
    work.pull[3] -= swing * s1
    work.pull[4] += heave * chi_sin * s1
    work.pull[5] += heave
    work.pull[6] += swing
    if work.levels != 0.0:
        raise_levels(scratch, k, chi_cos, a_cos, a_sin)


@part
def add_filter(scratch: Record, state: Record) -> None:
    """Add the filtered waves to the sums, all as one wave of the peak's number."""
    s = state[0]
    a = 0.25 * s.sea_height * math.sqrt(1.0 - s.sea_cosines)
    chi_cos, chi_sin = cosine_and_sine(s.sea_direction - s.psi)
    k = s.sea_omega * s.sea_omega / scratch[0].g
    add_component(scratch, k, chi_cos, chi_sin, a * s.sea_elevation, a * s.sea_quadrature)


@kernel
def add_sum(scratch: Record, state: Record) -> None:
    """Add each component of the cosine sum to the sums."""
    s = state[0]
    work = scratch[0]
    height = 0.25 * s.sea_height * math.sqrt(s.sea_cosines)
    chi_cos, chi_sin = cosine_and_sine(s.sea_direction - s.psi)
    for i in range(SEA_COMPONENTS):
        angle_cos, angle_sin = ANGLE_COS[i // BANDS], ANGLE_SIN[i // BANDS]
        a = height * work.amplitude[i]
        omega = s.sea_omega * work.relative[i]
        phase_cos, phase_sin = cosine_and_sine(phase(scratch, state, i))
        add_component(
            scratch,
            omega * omega / work.g,
            chi_cos * angle_cos - chi_sin * angle_sin,
            chi_sin * angle_cos + chi_cos * angle_sin,
            a * phase_cos,
            a * phase_sin,
        )


@part
def wave_forces(vessel: Record, scratch: Record, state: Record, force: Numbers) -> None:
    """Add the forces [N] and moments [N m] of the sea in force; ``scratch`` is the SEA record.

    A boat above the mean surface is taken as at it, and what is above the water feels nothing.
    """
    c = vessel[0]
    s = state[0]
    work = scratch[0]
    left = taper(vessel, state)
    if s.sea_height == 0.0 or left == 0.0:
        return
    work.g, work.depth, work.half_length = c.g, max(s.z, 0.0), 0.5 * c.ell
    for i in range(work.pull.size):
        work.pull[i] = 0.0
    if s.sea_cosines < 1.0:
        add_filter(scratch, state)
    if s.sea_cosines > 0.0:
        add_sum(scratch, state)
    if work.levels != 0.0:
        left *= 1.0 - share_above(vessel, scratch, state)
    displaced = c.buoyancy / c.g
    surge, sway = left * (displaced - c.X_udot), left * (displaced - c.Y_vdot)
    heave = left * (displaced - c.Z_wdot)
    swell = work.pull[5] * work.pull[5] + work.pull[6] * work.pull[6]
    force[0] += surge * work.pull[0]
    force[1] += sway * work.pull[1]
    force[2] += heave * (work.pull[2] - s.sea_suction * left * swell / c.g)
    force[4] += heave * work.half_length * work.pull[3]
    force[5] += sway * work.half_length * work.pull[4]


SHALLOWEST, DEEPEST = 0.3, 16.0  # [-] kappa
FADING: Final = np.array(
    [
        [2.04138, -0.0429752, -3.922061, -0.477556, 0.003725196],
        [1.853509, -0.622394, -3.445212, -0.556254, 0.005174789],
    ]
)


@part
def fading(row: int, kappa: float) -> float:
    """Return ln of one of FADING's integrals [-]; kappa is the peak's number times the depth."""
    root = math.sqrt(kappa)
    value = FADING[row, 0] + FADING[row, 1] * logarithm(kappa) + FADING[row, 2] * root
    return value + kappa * (FADING[row, 3] + FADING[row, 4] * kappa)


@kernel
def suction(g: float, omega: float, height: float, depth: float) -> tuple[float, float]:
    """Stands in until the sea's own part is merged."""
    number = omega * omega / g
    kappa = min(max(number * depth, SHALLOWEST), DEEPEST)
    force = 0.125 * g * number * number * height * height
    return force * exponential(fading(0, kappa)), 2.0 * number * force * exponential(
        fading(1, kappa)
    )

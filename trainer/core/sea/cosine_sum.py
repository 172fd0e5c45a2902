"""Short-crested waves as a sum of cosines: bands of equal variance in five directions.

[ASSES] cosine series with errata H1-H6, H-a, H-c. A component of frequency q times the peak's has
above the boat the phase

    A = eps + q T - q^2 (D cos beta + C sin beta),    T = integral of omega_p dt,

where D and C are the integrals of omega_p^2/g times the boat's speed along and across the wind. So
no change of period, direction, course or speed makes the surface jump, and three numbers carry all
the phases. Departures: each component has a frequency of its own, drawn inside its band. The bands
share the whole variance below VARIANCE_SHARE of it, instead of that between 0.2 and 1.8 rad/s, so
that small seas keep their height (at 20 to 45 knots the two are much the same). The bands are equal
in Pierson-Moskowitz's spectrum; a peaked one weights the same components by how much it exceeds
that.
"""

import math
from typing import Final

import numpy as np

from trainer.core.elementary import (
    cosine_and_sine,
    cosine_and_sine_of_any,
    exponential,
    logarithm,
)
from trainer.core.kernel import Record, inline_kernel, kernel
from trainer.core.noise import SEA_FREQUENCY, SEA_PHASE, uniform
from trainer.core.state import SEA_COMPONENTS

BAND_COUNT: Final = 10
VARIANCE_SHARE: Final = (
    0.995  # [-] of the variance lies below the highest frequency, 4 times the peak's
)

# Directions -60, -30, 0, 30 and 60 degrees from the wind, as cosine and sine, and the amplitude of
# their components for variance 1, sqrt(2 (2/pi) a_i/BAND_COUNT). The weights a_i are exact, sum
# pi/2:
# pi/6 ahead, sqrt(3)/4 and (pi/3 - sqrt(3)/2)/2 to the sides (errata H4-H6).
ANGLE_COS: Final = (0.5, 0.8660254037844386, 1.0, 0.8660254037844386, 0.5)
ANGLE_SIN: Final = (-0.8660254037844386, -0.5, 0.0, 0.5, 0.8660254037844386)
COMPONENT_COS: Final = np.repeat(ANGLE_COS, BAND_COUNT)  # of each component
COMPONENT_SIN: Final = np.repeat(ANGLE_SIN, BAND_COUNT)
DIRECTION_WEIGHTS: Final = (
    0.10739542413197807,
    0.23480393851504963,
    0.2581988897471611,
    0.23480393851504963,
    0.10739542413197807,
)


@kernel
def below(part: float) -> float:
    """Return the frequency [-], over the peak's, below which ``part`` of the variance lies.

    It is that of Pierson-Moskowitz and Bretschneider: part = exp(-1.25 x^-4).
    """
    return math.sqrt(math.sqrt(-1.25 / logarithm(part)))


@kernel
def peakedness(gamma: float, x: float) -> float:
    """Return the factor [-] of JONSWAP over Pierson-Moskowitz.

    It is that at ``x`` times the peak frequency. K. Hasselmann et al., JONSWAP, Deutsche Hydrogr.
    Z. A8 no. 12 (1973), equation 2.4.1.
    """
    width = 0.07 if x <= 1.0 else 0.09
    off = (x - 1.0) / width
    return exponential(logarithm(gamma) * exponential(-0.5 * off * off))


@kernel
def prepare_sum(gamma: float, seed: float, scratch: Record) -> None:
    """Write each component's relative frequency, starting phase and amplitude [-].

    The frequency is over the peak's. The amplitudes give variance 1.
    """
    work = scratch[0]
    if work.gamma == gamma and work.seed == seed:
        return
    work.gamma, work.seed = gamma, seed
    total = 0.0
    for i in range(SEA_COMPONENTS):
        inside = uniform(int(seed), SEA_FREQUENCY, i)
        work.relative[i] = below(VARIANCE_SHARE * (i % BAND_COUNT + inside) / BAND_COUNT)
        work.phase_start[i] = 6.283185307179586 * (uniform(int(seed), SEA_PHASE, i) - 0.5)
        work.amplitude[i] = DIRECTION_WEIGHTS[i // BAND_COUNT]
        if gamma != 1.0:
            work.amplitude[i] *= math.sqrt(peakedness(gamma, work.relative[i]))
        total += 0.5 * work.amplitude[i] * work.amplitude[i]
    for i in range(SEA_COMPONENTS):
        work.amplitude[i] /= math.sqrt(total)


@inline_kernel
def find_direction(scratch: Record, state: Record) -> None:
    """Write the parts [-] of the sea's direction north and east, if it has turned.

    Both are 0 in an empty work space, and never in one that is filled.
    """
    work, direction = scratch[0], state[0].sea_direction
    if work.direction != direction or work.toward_north == 0.0 == work.toward_east:
        work.direction = direction
        work.toward_north, work.toward_east = cosine_and_sine(direction)


@inline_kernel
def advance_sum(vessel: Record, h: float, scratch: Record, state: Record) -> None:
    """Advance by ``h`` [s] the numbers from which the phases above the boat follow."""
    s = state[0]
    cos_wind, sin_wind = scratch[0].toward_north, scratch[0].toward_east
    number = s.sea_omega * s.sea_omega / vessel[0].g
    s.sea_turned += s.sea_omega * h
    north, east = s.through_north, s.through_east
    s.sea_along += number * (north * cos_wind + east * sin_wind) * h
    s.sea_across += number * (east * cos_wind - north * sin_wind) * h


@inline_kernel
def phase(scratch: Record, state: Record, i: int) -> float:
    """Return the phase [rad] of component ``i`` above the boat."""
    s = state[0]
    work = scratch[0]
    q = work.relative[i]
    met = s.sea_along * COMPONENT_COS[i] + s.sea_across * COMPONENT_SIN[i]
    return work.phase_start[i] + q * s.sea_turned - q * q * met


@inline_kernel
def write_phases(scratch: Record, state: Record) -> None:
    """Write cosine and sine [-] of each component's phase above the boat, several at once."""
    work = scratch[0]
    for i in range(SEA_COMPONENTS):
        even, odd = cosine_and_sine_of_any(phase(scratch, state, i))
        work.phase_cos[i], work.phase_sin[i] = even, odd


@kernel
def sum_elevation(scratch: Record, state: Record) -> float:
    """Return the surface elevation above the boat [-], of variance 1."""
    write_phases(scratch, state)
    elevation = 0.0
    for i in range(SEA_COMPONENTS):
        elevation += scratch[0].amplitude[i] * scratch[0].phase_cos[i]
    return elevation

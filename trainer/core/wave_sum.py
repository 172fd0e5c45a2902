"""Short-crested waves as a sum of cosines: bands of equal variance in five directions.

[ASSES] cosine series with errata H1-H6, H-a, H-c. Each component carries its phase above the boat,
moved on by the frequency at which the boat meets it, so that no change of sea, course or speed
makes the surface jump. Departures: each component has a frequency of its own, drawn inside its
band; the bands share the whole variance, below PART of it, not what lies between 0.2 and
1.8 rad/s, so that small seas keep their height; at 20 to 45 knots the two are much the same.
"""

import math
from typing import Final

from trainer.core.elementary import cosine, cosine_and_sine, exponential, logarithm
from trainer.core.kernel import Record, kernel
from trainer.core.noise import SEA_FREQUENCY, SEA_PHASE, uniform
from trainer.core.sea import CELLS
from trainer.core.state import SEA_COMPONENTS
from trainer.core.wave_filter import wrapped

BANDS: Final = 10
PART: Final = 0.995  # [-] of the variance lies below the highest frequency, 4 times the peak's

# Directions -60, -30, 0, 30 and 60 degrees from the wind, as cosine and sine, and the amplitude of
# their components for variance 1, sqrt(2 (2/pi) a_i/BANDS). The weights a_i are exact, sum pi/2:
# pi/6 ahead, sqrt(3)/4 and (pi/3 - sqrt(3)/2)/2 to the sides (errata H4-H6).
ANGLE_COS: Final = (0.5, 0.8660254037844386, 1.0, 0.8660254037844386, 0.5)
ANGLE_SIN: Final = (-0.8660254037844386, -0.5, 0.0, 0.5, 0.8660254037844386)
WEIGHT: Final = (
    0.10739542413197807,
    0.23480393851504963,
    0.2581988897471611,
    0.23480393851504963,
    0.10739542413197807,
)


@kernel
def below(part: float) -> float:
    """Return the frequency [-], over the peak's, below which ``part`` of the variance lies.

    Of Pierson-Moskowitz and Bretschneider: part = exp(-1.25 x^-4).
    """
    return math.sqrt(math.sqrt(-1.25 / logarithm(part)))


@kernel
def peakedness(gamma: float, x: float) -> float:
    """Return by how much JONSWAP exceeds Pierson-Moskowitz [-] at ``x`` times the peak frequency.

    K. Hasselmann et al., JONSWAP, Deutsche Hydrogr. Z. A8 no. 12 (1973), equation 2.4.1.
    """
    width = 0.07 if x <= 1.0 else 0.09
    off = (x - 1.0) / width
    return exponential(logarithm(gamma) * exponential(-0.5 * off * off))


@kernel
def _accumulate(gamma: float, scratch: Record) -> None:
    """Write the variance [-] below the edges of CELLS cells that share Pierson-Moskowitz's."""
    work = scratch[0]
    total = 0.0
    work.cumulative[0] = 0.0
    for cell in range(CELLS):
        total += peakedness(gamma, below((cell + 0.5) / CELLS))
        work.cumulative[cell + 1] = total
    for cell in range(CELLS + 1):
        work.cumulative[cell] /= total


@kernel
def _pierson_moskowitz_part(part: float, scratch: Record) -> float:
    """Return the part of Pierson-Moskowitz's variance [-] where ``part`` of this sea's lies."""
    work = scratch[0]
    low, high = 0, CELLS
    while high - low > 1:
        middle = (low + high) // 2
        if work.cumulative[middle] <= part:
            low = middle
        else:
            high = middle
    inside = (part - work.cumulative[low]) / (work.cumulative[high] - work.cumulative[low])
    return (low + inside) / CELLS


@kernel
def prepare_sum(gamma: float, seed: float, scratch: Record) -> None:
    """Write the frequency [-] of each component, over the peak's."""
    work = scratch[0]
    if work.gamma == gamma and work.seed == seed:
        return
    work.gamma, work.seed = gamma, seed
    if gamma != 1.0:
        _accumulate(gamma, scratch)
    for i in range(SEA_COMPONENTS):
        inside = uniform(int(seed), SEA_FREQUENCY, i)
        part = PART * (i % BANDS + inside) / BANDS
        if gamma != 1.0:
            part = _pierson_moskowitz_part(part, scratch)
        work.relative[i] = below(part)


@kernel
def scatter_phases(state: Record) -> None:
    """Write phases [rad] at random from -pi to pi."""
    s = state[0]
    for i in range(SEA_COMPONENTS):
        s.sea_phase[i] = 6.283185307179586 * (uniform(int(s.seed), SEA_PHASE, i) - 0.5)


@kernel
def advance_sum(vessel: Record, scratch: Record, h: float, state: Record) -> None:
    """Advance each component's phase by ``h`` [s] at the frequency at which the boat meets it."""
    s = state[0]
    work = scratch[0]
    g = vessel[0].g
    cos_wind, sin_wind = cosine_and_sine(s.sea_direction)
    for i in range(SEA_COMPONENTS):
        angle_cos, angle_sin = ANGLE_COS[i // BANDS], ANGLE_SIN[i // BANDS]
        along = s.xdot * (cos_wind * angle_cos - sin_wind * angle_sin)
        along += s.ydot * (sin_wind * angle_cos + cos_wind * angle_sin)
        omega = s.sea_omega * work.relative[i]
        met = omega - omega * omega / g * along
        s.sea_phase[i] = wrapped(s.sea_phase[i] + met * h)


@kernel
def sum_elevation(state: Record) -> float:
    """Return the surface elevation above the boat [-], of variance 1."""
    s = state[0]
    elevation = 0.0
    for i in range(SEA_COMPONENTS):
        elevation += WEIGHT[i // BANDS] * cosine(s.sea_phase[i])
    return elevation

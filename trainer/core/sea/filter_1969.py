"""The wave filter of 1969: noise through a low-pass and three high-pass sections.

All sections are of second order:

    H(s) = 1/(s^2 + 2 d_L w_L s + w_L^2) [s^2/(s^2 + 2 d_H w_H s + w_H^2)]^3

[ASSES] Table 15 with errata H7-H10, H-d, H-e: bilinear with pre-warping in place of the printed
Euler substitution. The table's frequencies hold at 35, 40 and 45 knots of wind; elsewhere w_L =
0.90 g/U and w_H = 0.50 g/U. Within 1 knot to either side of a wind of the table, one leads over
into the other.

``sea`` runs it where a sea asks for the report's own generator, so that its runs can be flown
again.
"""

import math
from typing import Final

import numpy as np

from trainer.core.elementary import cosine_and_sine
from trainer.core.kernel import Record, inline_kernel, kernel
from trainer.core.noise import SEA_FILTER, gaussian
from trainer.core.state import FILTER_DEGREE
from trainer.units import KNOT

PEAK_FACTOR: Final = (
    0.8771632473301956  # [-] peak frequency times wind speed over g, (4 0.74/5)^(1/4)
)
LOW_DAMPING: Final = 0.325
HIGH_DAMPING: Final = 0.707
SIMILAR_FREQUENCIES: Final = (0.90, 0.50)  # [-] w_L U/g, w_H U/g
# wind [kn], w_L [rad/s], w_H [rad/s]
WIND, CORNERS = 0, 1
WIND_TABLE: Final = np.array([[35.0, 0.48, 0.27], [40.0, 0.43, 0.24], [45.0, 0.39, 0.21]])
# indices in the memory: three high-pass sections, then the low-pass, each with two numbers
LOW_PASS: Final = 6
LAST_BUT_ONE: Final = 1
ELEVATION_POWER, QUADRATURE_POWER = 6, 7  # of x, in the numerators of the two outputs
G_OF_TABLE: Final = 32.2 * 0.3048  # [m/s2]
# Largest half angle per step: a larger one cannot be pre-warped. Only winds below 13 kn with
# steps near 2 s reach it; their variance stays exact.
MAX_HALF_ANGLE: Final = 1.4  # [rad]


@kernel
def corner(omega: float, g: float, which: int) -> float:
    """Return the filter's w_L (``which`` 0) or w_H (1) [rad/s].

    It is that for a peak at ``omega`` [rad/s].
    """
    wind = PEAK_FACTOR * g / omega  # [m/s]
    knots = wind / KNOT
    product = SIMILAR_FREQUENCIES[which]
    for row in range(3):
        share = 1.0 - abs(knots - WIND_TABLE[row, WIND])
        if share > 0.0:
            tabled = WIND_TABLE[row, CORNERS + which] * WIND_TABLE[row, WIND] * KNOT / G_OF_TABLE
            product += share * (tabled - product)
    return product * g / wind


@kernel
def warp(omega: float, h: float) -> float:
    """Return tan(omega h/2) [-], with omega h/2 at most MAX_HALF_ANGLE."""
    adjacent, opposite = cosine_and_sine(min(0.5 * omega * h, MAX_HALF_ANGLE))
    return opposite / adjacent


@kernel
def section(c: float, damping: float) -> tuple[float, float, float]:
    """Return a0, a1/a0, a2/a0 [-] of a bilinear section with c = tan(w h/2)."""
    a0 = 1.0 + 2.0 * damping * c + c * c
    return a0, 2.0 * (c * c - 1.0) / a0, (1.0 - 2.0 * damping * c + c * c) / a0


@kernel
def _times(scratch: Record, first: float, second: float, third: float) -> None:
    """Multiply the polynomial ``a`` by first x^2 + second x + third, or first x + second."""
    work = scratch[0]
    for i in range(FILTER_DEGREE, -1, -1):
        value = first * work.a[i]
        if i >= 1:
            value += second * work.a[i - 1]
        if i >= 2:
            value += third * work.a[i - 2]
        work.a[i] = value


@kernel
def _powers(scratch: Record) -> None:
    """Write the integrals of |b/a|^2 and |d/a|^2 over the frequency axis, over 2 pi.

    ``a`` has degree FILTER_DEGREE, ``b`` and ``d`` are one lower; all are used up. K. Astrom,
    Introduction to Stochastic Control Theory (1970), chapter 5, section 3: the integral of
    a rational spectrum by one Routh table, exact but for rounding.
    """
    work = scratch[0]
    work.elevation_power = work.quadrature_power = 0.0
    for degree in range(FILTER_DEGREE, 0, -1):
        alpha = work.a[0] / work.a[1]
        beta, delta = work.b[1] / work.a[1], work.d[1] / work.a[1]
        work.elevation_power += 0.5 * beta * beta / alpha
        work.quadrature_power += 0.5 * delta * delta / alpha
        for i in range(degree):
            other = work.a[i + 2] if i + 2 <= degree else 0.0
            if i & 1 == 0:
                if i >= 1:
                    work.b[i] = work.b[i + 1] - beta * work.a[i + 1]
                    work.d[i] = work.d[i + 1] - delta * work.a[i + 1]
                work.a[i] = work.a[i + 1]
            else:
                work.a[i] = work.a[i + 1] - alpha * other
                work.b[i], work.d[i] = work.b[i + 1], work.d[i + 1]


@kernel
def filter_powers(low: float, high: float, scratch: Record) -> None:
    """Write sum h_k^2 [-] of the discrete filter and of its quadrature, low-pass gain 1.

    ``low`` and ``high`` are tan(w_L h/2) and tan(w_H h/2). With z = (1 + s)/(1 - s) the sum is
    twice the analogue integral of |H(s)/(1 + s)|^2 over 2 pi; here s = low x.
    """
    work = scratch[0]
    for i in range(FILTER_DEGREE + 1):
        work.a[i] = work.b[i] = work.d[i] = 0.0
    work.a[0] = 1.0
    ratio = high / low
    _times(scratch, 1.0, 2.0 * LOW_DAMPING, 1.0)
    for _ in range(3):
        _times(scratch, 1.0, 2.0 * HIGH_DAMPING * ratio, ratio * ratio)
    _times(scratch, low, 1.0, 0.0)
    work.b[FILTER_DEGREE - ELEVATION_POWER] = 1.0
    work.d[FILTER_DEGREE - QUADRATURE_POWER] = 1.0
    _powers(scratch)
    work.elevation_power *= 2.0 * low
    work.quadrature_power *= 2.0 * low


@kernel
def prepare_filter(g: float, omega: float, h: float, scratch: Record) -> None:
    """Write sections and gains for a peak at ``omega`` [rad/s] and a step ``h`` [s]."""
    work = scratch[0]
    if work.omega == omega and work.h == h:
        return
    work.omega, work.h = omega, h
    low, high = warp(corner(omega, g, 0), h), warp(corner(omega, g, 1), h)
    low_a0, work.low_a1, work.low_a2 = section(low, LOW_DAMPING)
    high_a0, work.high_a1, work.high_a2 = section(high, HIGH_DAMPING)
    filter_powers(low, high, scratch)
    gain = 1.0 / (low_a0 * high_a0 * high_a0 * high_a0)
    work.elevation_gain = gain * low * low / math.sqrt(work.elevation_power)
    work.quadrature_gain = gain * low / math.sqrt(work.quadrature_power)


@inline_kernel
def filter_noise(scratch: Record, x: float, state: Record) -> None:
    """Advance the filter by one sample ``x`` [-] of noise, and write its two outputs.

    Direct form II. The memory of the low-pass section gives the elevation, gain (1 + 1/z)^2, and
    the derivative, gain 1 - 1/z^2, whose negative lags by a quarter of a period.
    """
    work = scratch[0]
    s = state[0]
    for i in range(3):
        one, two = s.sea_memory[2 * i], s.sea_memory[2 * i + LAST_BUT_ONE]
        w = x - work.high_a1 * one - work.high_a2 * two
        x = w - 2.0 * one + two
        s.sea_memory[2 * i + LAST_BUT_ONE], s.sea_memory[2 * i] = one, w
    one, two = s.sea_memory[LOW_PASS], s.sea_memory[LOW_PASS + LAST_BUT_ONE]
    w = x - work.low_a1 * one - work.low_a2 * two
    s.sea_memory[LOW_PASS + LAST_BUT_ONE], s.sea_memory[LOW_PASS] = one, w
    s.sea_elevation = work.elevation_gain * (w + 2.0 * one + two)
    s.sea_quadrature = -work.quadrature_gain * (w - two)


@inline_kernel
def advance_filter(scratch: Record, turn_cos: float, turn_sin: float, state: Record) -> None:
    """Advance the filtered waves by one tick.

    All waves turn as the peak wave does by the boat's way. The pair of outputs turns, which leaves
    the variance as it is.
    """
    s = state[0]
    filter_noise(scratch, gaussian(int(s.seed), SEA_FILTER, int(s.tick)), state)
    elevation, quadrature = s.sea_elevation, s.sea_quadrature
    s.sea_elevation = elevation * turn_cos + quadrature * turn_sin
    s.sea_quadrature = quadrature * turn_cos - elevation * turn_sin

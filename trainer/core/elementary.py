"""Sine, cosine, arctangent, exponential and logarithm, the same bits with every library.

A library's own versions differ in the last place, so that runs on two machines would differ too.
Errors are at most 2 units in the last place for |angle| <= 1e5, |exponent| <= 700 and every
positive argument of the logarithm (tested). Reduction after Cody & Waite: the period is subtracted
in parts that multiply exactly.

All of the core computes with these, as do the sweeps that draw random numbers.
"""

import math
from typing import Final

import numpy as np

from trainer.core.kernel import inline_kernel, kernel

# Taylor's coefficients, the highest power first; every divisor is a whole number below 2^53, so
# that each coefficient is rounded once, and alike on every machine.
SINE_COEFFICIENTS: Final = np.array(
    [(-1.0) ** k / math.factorial(2 * k + 1) for k in range(8, 0, -1)]
)
COSINE_COEFFICIENTS: Final = np.array(
    [(-1.0) ** k / math.factorial(2 * k) for k in range(8, 1, -1)]
)
EXPONENTIAL_COEFFICIENTS: Final = np.array([1.0 / math.factorial(k) for k in range(13, 1, -1)])
ARCTANGENT_COEFFICIENTS: Final = np.array([(-1.0) ** k / (2 * k + 1) for k in range(7, 0, -1)])
ARCTANGENT_EIGHTHS: Final = np.array(  # arctan k/8, to the nearest double
    [
        0.0,
        0.12435499454676144,
        0.24497866312686414,
        0.35877067027057225,
        0.4636476090008061,
        0.5585993153435624,
        0.6435011087932844,
        0.7188299996216245,
        0.7853981633974483,
    ]
)
# 1.5 times 2^52: what is added to it is rounded to a whole number, which its last bits then are
ROUNDER: Final = 6755399441055744.0
EXPONENT_BIAS, EXPONENT_SHIFT = 1023, 52  # of the exponent in a double's bits
SMALL_ANGLE: Final = 0.78  # [rad] below pi/4, where no quarter turn is the nearest
LOGARITHM_COEFFICIENTS: Final = np.array([1.0 / (2 * k + 1) for k in range(10, 0, -1)])


@inline_kernel
def _sine_series(r: float) -> float:
    """Return sin r [-] for |r| <= pi/4, by its Taylor series to r^17."""
    s = r * r
    p = SINE_COEFFICIENTS[0]
    for i in range(1, SINE_COEFFICIENTS.size):
        p = p * s + SINE_COEFFICIENTS[i]
    return r + r * s * p


@inline_kernel
def _cosine_series(r: float) -> float:
    """Return cos r [-] for |r| <= pi/4, by its Taylor series to r^16."""
    s = r * r
    p = COSINE_COEFFICIENTS[0]
    for i in range(1, COSINE_COEFFICIENTS.size):
        p = p * s + COSINE_COEFFICIENTS[i]
    half = 0.5 * s
    whole = 1.0 - half
    # give back what rounding took from 1 - s/2
    return whole + (((1.0 - whole) - half) + s * s * p)


@inline_kernel
def _bits(x: float) -> int:
    """Return the bits of ``x`` as a whole number."""
    return np.float64(x).view(np.int64)  # type: ignore[return-value]  # numpy's own kind


@inline_kernel
def _power_of_two(rounded: float) -> float:
    """Return 2 to the whole number, -1022 to 1023, that was added to ROUNDER [-]."""
    return np.int64((_bits(rounded) + EXPONENT_BIAS) << EXPONENT_SHIFT).view(np.float64)


@inline_kernel
def _remainder(x: float) -> tuple[float, int]:
    """Return ``x`` [rad] >= 0 less the nearest whole number of quarter turns, and the quadrant."""
    rounded = x * 0.6366197723675814 + ROUNDER
    k = rounded - ROUNDER
    # pi/2 in parts of at most 32 bits and a rest: products are exact up to 2^21 quarter turns
    r = x - k * 1.5707963267341256
    return (r - k * 6.077100506303966e-11) - k * 2.0222662487959506e-21, _bits(rounded) & 3


@kernel
def nearest_turn(x: float) -> float:
    """Return the angle ``x`` [rad] less whole turns, from -pi to pi, exactly.

    As the remainder of IEEE 754: of two turns that are as near, the even one is taken.
    """
    r, part_of_turn = abs(x), math.tau
    while part_of_turn * 2.0 <= r:
        part_of_turn *= 2.0
    odd = False
    while part_of_turn >= math.tau:
        if r >= part_of_turn:  # and less than twice of it, so that the difference is exact
            r -= part_of_turn
            odd = part_of_turn == math.tau
        part_of_turn *= 0.5
    if r > math.pi or (r == math.pi and odd):
        r -= math.tau
    return r if x >= 0.0 else -r


@inline_kernel
def sine(x: float) -> float:
    """Return sin x [-], exactly odd."""
    size = abs(x)
    if not size < 1e9:
        # NaN where x is not finite, 0 where no run goes on (MAX_DISTANCE of ``update``)
        return x - x
    r, quadrant = _remainder(size)
    value = _sine_series(r) if quadrant & 1 == 0 else _cosine_series(r)
    if quadrant >= 2:
        value = -value
    return value if x >= 0.0 else -value


@inline_kernel
def cosine_of_size(x: float) -> float:
    """Return cos x [-] for 0 <= x < 1e9."""
    r, quadrant = _remainder(x)
    value = _cosine_series(r) if quadrant & 1 == 0 else _sine_series(r)
    return -value if quadrant in (1, 2) else value


@inline_kernel
def cosine(x: float) -> float:
    """Return cos x [-], exactly even."""
    size = abs(x)
    if not size < 1e9:
        return 1.0 + (x - x)
    return cosine_of_size(size)


@inline_kernel
def cosine_and_sine(x: float) -> tuple[float, float]:
    """Return cos x and sin x [-], with the bits of ``cosine`` and ``sine``.

    Both cost little more than one. A small angle has no quarter turns to take off.
    """
    size = abs(x)
    if size < SMALL_ANGLE:
        odd = _sine_series(size)
        return _cosine_series(size), -odd if x < 0.0 else odd
    return cosine_and_sine_of_any(x)


@inline_kernel
def cosine_and_sine_of_any(x: float) -> tuple[float, float]:
    """Return cos x and sin x [-] by one way for all angles.

    It chooses between numbers, not between ways, so that a loop of it is computed side by side.
    """
    size = abs(x)
    r, quadrant = _remainder(size)
    even, odd = _cosine_series(r), _sine_series(r)
    crossed, known = quadrant & 1 == 1, size < 1e9
    c, s = (odd if crossed else even), (even if crossed else odd)
    c = -c if (quadrant + 1) & 2 == 2 else c
    s = -s if (quadrant & 2 == 2) != (x < 0.0) else s
    return (c if known else 1.0 + (x - x)), (s if known else x - x)


@inline_kernel
def exponential(x: float) -> float:
    """Return e^x [-]; x beyond +-700 is taken as +-700, since e^710 overflows."""
    bounded = min(max(x, -700.0), 700.0)
    rounded = bounded * 1.4426950408889634 + ROUNDER
    k = rounded - ROUNDER
    r = (bounded - k * 0.6931471803691238) - k * 1.9082149292705877e-10
    p = EXPONENTIAL_COEFFICIENTS[0]
    for i in range(1, EXPONENTIAL_COEFFICIENTS.size):
        p = p * r + EXPONENTIAL_COEFFICIENTS[i]
    return (1.0 + (r + r * r * p)) * _power_of_two(rounded)


@inline_kernel
def _logarithm_series(s: float) -> float:
    """Return (artanh s)/s - 1, doubled [-], for |s| <= 0.172, by its Taylor series to s^20."""
    z = s * s
    p = LOGARITHM_COEFFICIENTS[0]
    for i in range(1, LOGARITHM_COEFFICIENTS.size):
        p = p * z + LOGARITHM_COEFFICIENTS[i]
    return 2.0 * z * p


@inline_kernel
def logarithm_of_positive(x: float) -> float:
    """Return ln x [-] for a finite x > 0."""
    m, k = math.frexp(x)
    if m < 0.7071067811865476:
        m, k = 2.0 * m, k - 1
    f = m - 1.0
    s = f / (2.0 + f)
    half = 0.5 * f * f
    # ln(1 + f) = f - f^2/2 + s (f^2/2 + series), the small part added last
    small = s * (half + _logarithm_series(s)) + k * 1.9082149292705877e-10
    return k * 0.6931471803691238 - ((half - small) - f)


@inline_kernel
def logarithm(x: float) -> float:
    """Return ln x [-].

    ln 0 is minus infinity; below 0 it is not a number.
    """
    if not 0.0 < x < math.inf:
        if x == 0.0:
            return -math.inf
        return x if x > 0.0 else math.nan
    return logarithm_of_positive(x)


@inline_kernel
def _arctangent_of_share(t: float) -> float:
    """Return arctan t [rad] for 0 <= t <= 1, by the nearest eighth and a Taylor series to z^15."""
    if not t <= 1.0:
        return t  # not a number stays one
    rounded = 8.0 * t + ROUNDER
    c = 0.125 * (rounded - ROUNDER)
    z = (t - c) / (1.0 + t * c)
    s = z * z
    p = ARCTANGENT_COEFFICIENTS[0]
    for i in range(1, ARCTANGENT_COEFFICIENTS.size):
        p = p * s + ARCTANGENT_COEFFICIENTS[i]
    return ARCTANGENT_EIGHTHS[_bits(rounded) & 15] + (z + z * s * p)


@inline_kernel
def arctangent(y: float, x: float) -> float:
    """Return the angle [rad] of the point ``x``, ``y`` from the x axis.

    It is between -pi and pi, and 0 at the origin.
    """
    across, along = abs(y), abs(x)
    if across == 0.0 and along == 0.0:
        return 0.0
    if across <= along:
        angle = _arctangent_of_share(across / along)
    else:
        # the second number is the part of pi/2, or pi, that one double does not hold
        angle = (1.5707963267948966 - _arctangent_of_share(along / across)) + 6.123233995736766e-17
    if x < 0.0:
        angle = (3.141592653589793 - angle) + 1.2246467991473532e-16
    return angle if y >= 0.0 else -angle

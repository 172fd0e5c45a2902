"""Filters of second order, one section each: notch and low-pass, bilinear with pre-warping.

The numbers of a section are b0, b1, b2, a1, a2 [-]. It keeps two memories and its output. Each
section passes a constant unchanged.

The planesman (``waves``) passes the law of its planes through notches, because waves shall not move
planes. Hovering (``ballast/hover``) passes the depth error through notches and then the low-pass,
because waves shall not move pumps.
"""

from typing import Final

from trainer.core.elementary import cosine_and_sine
from trainer.core.kernel import Numbers, inline_kernel
from trainer.core.state import SECTION_NUMBERS

Section = tuple[float, float, float, float, float]
B0, B1, B2, A1, A2 = range(SECTION_NUMBERS)  # indices of its numbers
SECTION_SIZE: Final = 3  # numbers of a section in the state
EARLY, LATE, OUTPUT = 0, 1, 2  # their indices: two memories, and the output
MAX_HALF_ANGLE: Final = 1.4  # [rad] largest half angle per step; a larger one cannot be warped


@inline_kernel
def warped(omega: float, h: float) -> float:
    """Return tan(omega h/2) [-], with omega h/2 at most MAX_HALF_ANGLE."""
    cos_half, sin_half = cosine_and_sine(min(0.5 * omega * h, MAX_HALF_ANGLE))
    return sin_half / cos_half


@inline_kernel
def notch(omega: float, h: float, zeros: float, poles: float) -> Section:
    """Return the section of a notch at ``omega`` [rad/s].

    ``zeros`` and ``poles`` are the damping ratios [-] of its zeros and poles.
    """
    c = warped(omega, h)
    square = c * c
    a0 = 1.0 + 2.0 * poles * c + square
    middle = 2.0 * (square - 1.0) / a0
    first, last = 1.0 + 2.0 * zeros * c + square, 1.0 - 2.0 * zeros * c + square
    return first / a0, middle, last / a0, middle, (1.0 - 2.0 * poles * c + square) / a0


@inline_kernel
def low_pass(omega: float, h: float, damping: float) -> Section:
    """Return the section of a low-pass at ``omega`` [rad/s] with this damping ratio [-].

    Hovering alone smooths its depth error by it, because the pump follows slow errors only.
    """
    c = warped(omega, h)
    square = c * c
    a0 = 1.0 + 2.0 * damping * c + square
    gain = square / a0
    middle = 2.0 * (square - 1.0) / a0
    return gain, 2.0 * gain, gain, middle, (1.0 - 2.0 * damping * c + square) / a0


@inline_kernel
def section_in(numbers: Numbers) -> Section:
    """Return the section [-] whose numbers are in the work space."""
    return numbers[B0], numbers[B1], numbers[B2], numbers[A1], numbers[A2]


@inline_kernel
def pass_section(section: Section, x: float, fresh: bool, first: int, out: Numbers) -> None:  # noqa: FBT001 a fact
    """Pass ``x`` through a section whose numbers are from ``first`` on in ``out``.

    A ``fresh`` section begins as if x had stood for a long time.
    """
    b0, b1, b2, a1, a2 = section
    if fresh:
        out[first + EARLY], out[first + LATE] = (1.0 - b0) * x, (b2 - a2) * x
    y = b0 * x + out[first + EARLY]
    out[first + EARLY] = b1 * x - a1 * y + out[first + LATE]
    out[first + LATE] = b2 * x - a2 * y
    out[first + OUTPUT] = y

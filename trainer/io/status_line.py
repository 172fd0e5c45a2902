"""The boat in one line of 79 ASCII columns, under headings: the plain console.

It is what a printer or a terminal without a screen shows (``session/stations/display``).
"""

import math
from typing import NamedTuple

LONG_TIME_S = 100 * 3600  # [s]  from here on hours and minutes only

HEADER_LINE = "time      depth>order hdg>course speed pitch  heel  rudder  stern    bow    rpm"


class StatusView(NamedTuple):
    """The values of the console, in display units."""

    time_s: float
    depth_m: float
    course_deg: float
    speed_kn: float
    pitch_deg: float  # bow up positive
    heel_deg: float  # to starboard positive
    rudder_deg: float  # right positive
    stern_deg: float  # rise positive
    bow_deg: float  # rise positive
    rpm: float
    ordered_depth_m: float | None
    ordered_course_deg: float | None
    frozen: bool
    rudder_manual: bool
    stern_manual: bool
    bow_manual: bool


def header() -> str:
    """Return the headings of the state line."""
    return HEADER_LINE


def state_line(view: StatusView) -> str:
    """Return the state in 79 columns. F: frozen; *: a surface steered by hand.

    L, R are left, right; D, R dive, rise. A number too wide for its column is its sign and ###.
    """
    depth_order, course_order = view.ordered_depth_m, view.ordered_course_deg
    return (
        f"{clock(view.time_s)}{'F' if view.frozen else ' '}"
        f"{number(view.depth_m, 6)}"
        f"{'' if depth_order is None else '>' + number(depth_order, 6).lstrip():<7}"
        f" {course(view.course_deg, 1):>5}"
        f"{'' if course_order is None else '>' + course(course_order, 0):<4}"
        f" {number(view.speed_kn, 5)}"
        f" {number(view.pitch_deg, 5, '+')} {number(view.heel_deg, 5, '+')}"
        f"  {surface(view.rudder_deg, 'LR', by_hand=view.rudder_manual)}"
        f" {surface(view.stern_deg, 'DR', by_hand=view.stern_manual)}"
        f" {surface(view.bow_deg, 'DR', by_hand=view.bow_manual)}"
        f" {number(view.rpm, 6)}"
    )


def clock(time_s: float) -> str:
    """Return hours, minutes and seconds in 8 columns, without seconds beyond 100 hours."""
    if not 0.0 <= time_s < 1e8:
        return number(time_s, 8)
    minutes, seconds = divmod(int(time_s), 60)
    hours, minutes = divmod(minutes, 60)
    if time_s < LONG_TIME_S:
        return f"{hours:02d}:{minutes:02d}:{seconds:02d}"
    return f"{hours}:{minutes:02d}".rjust(8)


def course(angle_deg: float, decimals: int) -> str:
    """Return a course as three digits and decimals, 000 to 359.9."""
    if not math.isfinite(angle_deg):
        return "???"
    width = 4 + decimals if decimals else 3
    # Rounded first: 359.97 is 000.0, not 360.0.
    return f"{round(angle_deg, decimals) % 360.0:0{width}.{decimals}f}"


def number(value: float, width: int, sign: str = "-") -> str:
    """Return a number right-aligned with one decimal, with none where that does not fit."""
    for decimals in (1, 0):
        text = f"{round(value, decimals) + 0.0:{sign}{width}.{decimals}f}"
        if len(text) <= width:
            return text
    return ("-" if value < 0.0 else "+").ljust(width, "#")


def surface(angle_deg: float, sides: str, *, by_hand: bool) -> str:
    """Return an angle in 6 columns: the side's letter, the size. A star means by hand."""
    size = round(angle_deg, 1)
    side = sides[int(size > 0.0)] if size else " "
    return f"{side}{number(abs(size), 4)}{'*' if by_hand else ' '}"

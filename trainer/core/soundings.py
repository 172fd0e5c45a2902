"""The ground of a chart under the hull, written into the state before a tick.

A chart is a row of numbers: [m] north and east of its first sample, rows and columns by the metre,
1 where it has an end and 0 where it goes on as a plane, its numbers of rows and of columns, and then
the depths [m], the southernmost row first. Between samples the depth is bilinear.
Beyond the end it is that of the edge, and level across it.
"""

from typing import Final

from trainer.core.bottom import PLACES
from trainer.core.elementary import cosine, cosine_and_sine
from trainer.core.kernel import Numbers, Record, kernel, part
from trainer.core.state import SOUNDINGS

SOUTH, WEST, ALONG, ACROSS, ENDS, ROWS, COLUMNS, FIRST = 0, 1, 2, 3, 4, 5, 6, 7  # of a chart
SHALLOWEST: Final = 1e-9  # [m] instead of 0, which would be no ground at all
DISTANT: Final = 250.0  # [m] under the boat
SELDOM: Final = 15  # [-] a power of two less one


@part
def cell_of(at: float, count: float) -> int:
    """Return the cell [-] that a place is in, of ``count`` samples; the outermost beyond."""
    return int(max(min(at, count - 2.0), 0.0))


@part
def sound_at(chart: Numbers, north: float, east: float, place: int, state: Record) -> None:
    """Write depth and slopes of the ground at a place [m] of the plane, under one of the hull."""
    s = state[0]
    i, j = (north - chart[SOUTH]) * chart[ALONG], (east - chart[WEST]) * chart[ACROSS]
    along, across = chart[ALONG], chart[ACROSS]
    if chart[ENDS] != 0.0:
        inside = max(min(i, chart[ROWS] - 1.0), 0.0), max(min(j, chart[COLUMNS] - 1.0), 0.0)
        along = along if i == inside[0] else 0.0
        across = across if j == inside[1] else 0.0
        i, j = inside
    row, column, width = cell_of(i, chart[ROWS]), cell_of(j, chart[COLUMNS]), int(chart[COLUMNS])
    at = FIRST + row * width + column
    a, b = i - row, j - column
    near, far = chart[at], chart[at + width]
    right, beyond = chart[at + 1] - near, chart[at + width + 1] - far
    near, far = near + b * right, far + b * beyond
    depth = near + a * (far - near)
    s.bottom[0, place] = depth if depth != 0.0 else SHALLOWEST
    s.bottom[1, place] = along * (far - near)
    s.bottom[2, place] = across * (right + a * (beyond - right))


@kernel
def sound(vessel: Record, chart: Numbers, state: Record) -> None:
    """Write the ground under the places along the hull, as they lie now.

    Where it is DISTANT only one tick of SELDOM does: no boat makes more way than that in between.
    """
    s = state[0]
    if s.bottom[0, 0] != 0.0 and s.bottom[0, SOUNDINGS // 2] - s.z > DISTANT:
        if int(s.tick) & SELDOM != 0:
            return
    cos_psi, sin_psi = cosine_and_sine(s.psi)
    level = vessel[0].ell * cosine(s.theta)
    for place in range(SOUNDINGS):
        x = PLACES[place] * level
        sound_at(chart, s.x + x * cos_psi, s.y + x * sin_psi, place, state)

"""The ground of a chart under the hull, written into the state before a tick.

A chart is a row of numbers: [m] north and east of its first sample, rows and columns by the metre,
1 where it has an end and 0 where it goes on as a plane, its numbers of rows and of columns; then
the depths [m], the southernmost row first. Between samples the depth is bilinear. Beyond the end it
is that of the edge, and level across it.
"""

from typing import Final

from trainer.core.bottom import PLACES
from trainer.core.elementary import cosine, cosine_and_sine
from trainer.core.kernel import Numbers, Record, part
from trainer.core.state import SOUNDINGS

SOUTH, WEST, ALONG, ACROSS, ENDS, ROWS, COLUMNS, FIRST = 0, 1, 2, 3, 4, 5, 6, 7  # of a chart
SHALLOWEST: Final = 1e-9  # [m] instead of 0, which would be no ground at all
DISTANT: Final = 250.0  # [m] under the boat
SELDOM: Final = 15  # [-] a power of two less one

Cell = tuple[int, int]  # row and column of its first sample


@part
def sound_in(chart: Numbers, cell: Cell, i: float, j: float, place: int, state: Record) -> None:
    """Write depth and slopes at ``i`` rows and ``j`` columns of a chart."""
    s = state[0]
    width = int(chart[COLUMNS])
    at = FIRST + cell[0] * width + cell[1]
    a, b = i - cell[0], j - cell[1]
    near, far = chart[at], chart[at + width]
    right, beyond = chart[at + 1] - near, chart[at + width + 1] - far
    near, up = near + b * right, far - near + b * (beyond - right)
    depth = near + a * up
    s.bottom[0, place] = depth if depth != 0.0 else SHALLOWEST
    s.bottom[1, place] = chart[ALONG] * up
    s.bottom[2, place] = chart[ACROSS] * (right + a * (beyond - right))


@part
def sound_at_edge(chart: Numbers, i: float, j: float, place: int, state: Record) -> None:
    """Write depth and slopes where a chart may have ended, as at its edge."""
    s = state[0]
    rows, columns = chart[ROWS], chart[COLUMNS]
    row, column = max(min(i, rows - 1.0), 0.0), max(min(j, columns - 1.0), 0.0)
    cell = int(min(row, rows - 2.0)), int(min(column, columns - 2.0))
    sound_in(chart, cell, row, column, place, state)
    if row != i:
        s.bottom[1, place] = 0.0
    if column != j:
        s.bottom[2, place] = 0.0


@part
def sound_plane(chart: Numbers, i: float, j: float, place: int, state: Record) -> None:
    """Write depth and slopes of a plane, whose chart is a cell of it."""
    s = state[0]
    up, right = chart[FIRST + 2] - chart[FIRST], chart[FIRST + 1] - chart[FIRST]
    depth = chart[FIRST] + i * up + j * right
    s.bottom[0, place] = depth if depth != 0.0 else SHALLOWEST
    s.bottom[1, place] = chart[ALONG] * up
    s.bottom[2, place] = chart[ACROSS] * right


@part
def sound(vessel: Record, chart: Numbers, state: Record) -> None:
    """Write the ground under the places along the hull, as they lie now.

    Where it is DISTANT only one tick of SELDOM does: no boat makes more way than that in between.
    """
    s = state[0]
    distant = s.bottom[0, 0] != 0.0 and s.bottom[0, SOUNDINGS // 2] - s.z > DISTANT
    if distant and int(s.tick) & SELDOM != 0:
        return
    cos_psi, sin_psi = cosine_and_sine(s.psi)
    level = vessel[0].ell * cosine(s.theta)
    i, j = (s.x - chart[SOUTH]) * chart[ALONG], (s.y - chart[WEST]) * chart[ACROSS]
    up, right = level * cos_psi * chart[ALONG], level * sin_psi * chart[ACROSS]
    room = abs(up) + abs(right)
    inside = room < i < chart[ROWS] - 1.0 - room and room < j < chart[COLUMNS] - 1.0 - room
    for place in range(SOUNDINGS):
        row, column = i + PLACES[place] * up, j + PLACES[place] * right
        if chart[ENDS] == 0.0:
            sound_plane(chart, row, column, place, state)
        elif inside:
            sound_in(chart, (int(row), int(column)), row, column, place, state)
        else:
            sound_at_edge(chart, row, column, place, state)

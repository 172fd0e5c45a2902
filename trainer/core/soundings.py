"""The ground of a chart under the hull, written into the state before a tick.

``boat/world/bottom`` makes the chart of an exercise's ground; ``Boat`` keeps it, because the tick
sounds it.

A chart is a row of numbers: [m] north and east of its first sample, rows and columns by the metre,
1 where it has an end and 0 where it goes on as a plane, its numbers of rows and of columns; then
the depths [m], the southernmost row first. Between samples the depth is bilinear. Beyond the end it
is that of the edge, and level across it.
"""

from typing import Final

from trainer.core.bottom import SOUNDING_STATIONS
from trainer.core.elementary import cosine, cosine_and_sine
from trainer.core.kernel import Numbers, Record, inline_kernel
from trainer.core.state import GROUND_DEPTH, GROUND_EAST, GROUND_NORTH, SOUNDING_COUNT

SOUTH, WEST, ALONG, ACROSS, CHART_ENDS, ROWS, COLUMNS, FIRST_SAMPLE = (
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
)  # of a chart
EASTWARD: Final = 1  # depths from a sample to the next one in its row
PLANE_WIDTH: Final = 2  # depths in a row of a plane's cell
MIN_GROUND_DEPTH_M: Final = 1e-9  # [m] instead of 0, which would be no ground at all
DISTANT_GROUND_M: Final = 250.0  # [m] under the boat
SELDOM_MASK: Final = 15  # [-] a power of two less one

Cell = tuple[int, int]  # row and column of its first sample


@inline_kernel
def sound_in(chart: Numbers, cell: Cell, i: float, j: float, station: int, state: Record) -> None:
    """Write depth and slopes at ``i`` rows and ``j`` columns of a chart."""
    s = state[0]
    width = int(chart[COLUMNS])
    row, column = cell
    at = FIRST_SAMPLE + row * width + column
    a, b = i - row, j - column
    near, far = chart[at], chart[at + width]
    right, beyond = chart[at + EASTWARD] - near, chart[at + width + EASTWARD] - far
    near, up = near + b * right, far - near + b * (beyond - right)
    depth = near + a * up
    s.bottom[GROUND_DEPTH, station] = depth if depth != 0.0 else MIN_GROUND_DEPTH_M
    s.bottom[GROUND_NORTH, station] = chart[ALONG] * up
    s.bottom[GROUND_EAST, station] = chart[ACROSS] * (right + a * (beyond - right))


@inline_kernel
def sound_at_edge(chart: Numbers, i: float, j: float, station: int, state: Record) -> None:
    """Write depth and slopes where a chart may have ended, as at its edge."""
    s = state[0]
    rows, columns = chart[ROWS], chart[COLUMNS]
    row, column = max(min(i, rows - 1.0), 0.0), max(min(j, columns - 1.0), 0.0)
    cell = int(min(row, rows - 2.0)), int(min(column, columns - 2.0))
    sound_in(chart, cell, row, column, station, state)
    if row != i:
        s.bottom[GROUND_NORTH, station] = 0.0
    if column != j:
        s.bottom[GROUND_EAST, station] = 0.0


@inline_kernel
def sound_plane(chart: Numbers, i: float, j: float, station: int, state: Record) -> None:
    """Write depth and slopes of a plane, whose chart is a cell of it."""
    s = state[0]
    up, right = (
        chart[FIRST_SAMPLE + PLANE_WIDTH] - chart[FIRST_SAMPLE],
        chart[FIRST_SAMPLE + EASTWARD] - chart[FIRST_SAMPLE],
    )
    depth = chart[FIRST_SAMPLE] + i * up + j * right
    s.bottom[GROUND_DEPTH, station] = depth if depth != 0.0 else MIN_GROUND_DEPTH_M
    s.bottom[GROUND_NORTH, station] = chart[ALONG] * up
    s.bottom[GROUND_EAST, station] = chart[ACROSS] * right


@inline_kernel
def sound(vessel: Record, chart: Numbers, state: Record) -> None:
    """Write the ground under the stations along the hull, as they lie now.

    Ground more than DISTANT_GROUND_M below the boat is sounded in one tick of SELDOM_MASK + 1 only,
    because no boat makes so much way in between. ``entry`` calls it before each tick,
    ``boat/world/bottom`` once at the start; ``bottom`` makes forces of it.
    """
    s = state[0]
    distant = (
        s.bottom[GROUND_DEPTH, 0] != 0.0
        and s.bottom[GROUND_DEPTH, SOUNDING_COUNT // 2] - s.z > DISTANT_GROUND_M
    )
    if distant and int(s.tick) & SELDOM_MASK != 0:
        return
    cos_psi, sin_psi = cosine_and_sine(s.psi)
    level = vessel[0].ell * cosine(s.theta)
    i, j = (s.x - chart[SOUTH]) * chart[ALONG], (s.y - chart[WEST]) * chart[ACROSS]
    up, right = level * cos_psi * chart[ALONG], level * sin_psi * chart[ACROSS]
    room = abs(up) + abs(right)
    inside = room < i < chart[ROWS] - 1.0 - room and room < j < chart[COLUMNS] - 1.0 - room
    for station in range(SOUNDING_COUNT):
        row, column = i + SOUNDING_STATIONS[station] * up, j + SOUNDING_STATIONS[station] * right
        if chart[CHART_ENDS] == 0.0:
            sound_plane(chart, row, column, station, state)
        elif inside:
            sound_in(chart, (int(row), int(column)), row, column, station, state)
        else:
            sound_at_edge(chart, row, column, station, state)

"""The boat near a calm surface: its effect on four coefficients, and what emerges.

Near the surface [ASSES] keeps all deep coefficients but Z_star and M_star, tables of depth and
speed: the force and moment of a hull at no angle to the flow. It measured Z_w and M_w there too and
left them out, since Table 13 shows little of them; a vessel file may have them, by depth alone. The
report gives no values; the vessel file does. ``boat/limits`` warns by the heights of sail and deck.
"""

from typing import Final

from trainer.core.elementary import cosine, sine
from trainer.core.kernel import Numbers, Record, inline_kernel, kernel
from trainer.core.state import NORMAL, PITCHING

DECK_REACH: Final = 0.25  # [-] of the length, either way from the origin: the parallel middle body


@inline_kernel
def cell(grid: Numbers, count: int, value: float) -> tuple[int, float]:
    """Return the cell of an ascending ``grid`` that contains ``value``.

    The second number says where in the cell it is, 0 to 1 [-]. Values outside the grid are taken as
    at its end.
    """
    low = 0
    while low < count - 2 and value >= grid[low + 1]:
        low += 1
    inside = (value - grid[low]) / (grid[low + 1] - grid[low])
    return low, min(max(inside, 0.0), 1.0)


@inline_kernel
def between_depths(column: Numbers, low: int, across: float) -> float:
    """Return a column's value inside a cell, linear, in the column's unit."""
    return column[low] + across * (column[low + 1] - column[low])


@inline_kernel
def between(table: Numbers, row: int, column: int, along: float, across: float) -> float:
    """Return a table's value inside a cell, bilinear, in the table's unit."""
    first = table[row, column] + across * (table[row, column + 1] - table[row, column])
    second = table[row + 1, column] + across * (table[row + 1, column + 1] - table[row + 1, column])
    return first + along * (second - first)


@inline_kernel
def surface_forces(vessel: Record, state: Record, force: Numbers) -> None:
    """Add Z [N] and M [N m] of the calm surface.

    Below the last depth of the tables there are none.
    """
    c = vessel[0]
    s = state[0]
    speeds, depths = int(c.surface_speeds), int(c.surface_depths)
    if depths == 0 or s.z >= c.surface_depth[depths - 1]:
        return
    row, along = cell(c.surface_speed, speeds, abs(s.u))
    column, across = cell(c.surface_depth, depths, s.z)
    square = s.u * s.u
    force[NORMAL] += square * between(c.surface_Z, row, column, along, across)
    force[PITCHING] += square * between(c.surface_M, row, column, along, across)
    slant = s.u * s.w
    force[NORMAL] += slant * between_depths(c.surface_Z_w, column, across)
    force[PITCHING] += slant * between_depths(c.surface_M_w, column, across)


@kernel
def height_above_water(state: Record, x: float, z: float) -> float:
    """Return the height [m] above the water of a point amidships.

    ``x`` and ``z`` [m] are in body axes. The water stands as high there as above the boat's origin.
    """
    s = state[0]
    lifted = x * sine(s.theta) - z * cosine(s.theta) * cosine(s.phi)
    return lifted - s.z - s.eta_wave


@kernel
def sail_height(vessel: Record, state: Record) -> float:
    """Return the height [m] of the sail's top above the water; negative: covered."""
    c = vessel[0]
    return height_above_water(state, c.x_sail, c.z_sail)


@kernel
def deck_height(vessel: Record, state: Record) -> float:
    """Return the height [m] of the deck's higher end above the water; negative: covered."""
    c = vessel[0]
    reach = DECK_REACH * c.ell
    fore = height_above_water(state, reach, c.z_deck)
    aft = height_above_water(state, -reach, c.z_deck)
    return max(fore, aft)

"""Units of columns on a page: degrees for radians.

Flights and recordings are in radians inside; people read degrees. Plots and CSV headings ask here.
One table for all, so that a column has one unit on every page.
"""

import math
from typing import Final

# factor and unit on the page, by column; whatever is not here is shown as it is
PAGE_UNITS: Final = {
    **dict.fromkeys(("u", "v", "w", "u_c"), (1.0, "m/s")),
    **dict.fromkeys(("x", "y", "z"), (1.0, "m")),
    **dict.fromkeys(("p", "q", "r"), (math.degrees(1.0), "deg/s")),
    **dict.fromkeys(("phi", "theta", "psi"), (math.degrees(1.0), "deg")),
    **dict.fromkeys(("delta_r", "delta_s", "delta_b"), (math.degrees(1.0), "deg")),
}
DEPTH_COLUMNS: Final = frozenset({"z", "ordered_depth", "depth", "depth_m"})  # larger is lower


def page_unit(name: str) -> tuple[float, str]:
    """Return the factor to the page's unit of a column, and that unit."""
    return PAGE_UNITS.get(name, (1.0, "SI"))


def figure(value: float | None, unit: str) -> str:
    """Return a number of a ``unit`` as text, degrees for radians; "-" for none."""
    if value is None or not math.isfinite(value):
        return "-"
    return f"{math.degrees(value) if unit.startswith('rad') else value:.4g}"

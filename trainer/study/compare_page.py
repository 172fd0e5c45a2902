"""Two runs compared, as a page for a terminal and as a plot."""

import math
from typing import Final

import numpy as np

from trainer.study.compare import Comparison, Point, changes
from trainer.study.page import INDENT, WIDTH, cut, table, wrapped
from trainer.study.plots import Curve, Panel
from trainer.study.series import Series

# factor and unit on the page, by column; whatever is not here is shown as it is
UNITS: Final = {
    **dict.fromkeys(("u", "v", "w", "u_c"), (1.0, "m/s")),
    **dict.fromkeys(("x", "y", "z"), (1.0, "m")),
    **dict.fromkeys(("p", "q", "r"), (math.degrees(1.0), "deg/s")),
    **dict.fromkeys(("phi", "theta", "psi"), (math.degrees(1.0), "deg")),
    **dict.fromkeys(("delta_r", "delta_s", "delta_b"), (math.degrees(1.0), "deg")),
}
HEADS: Final = ("", "", "t full\n[s]", "t other\n[s]", "full", "other", "percent", "")


def unit(name: str) -> tuple[float, str]:
    """Return the factor to the page's unit of a column, and that unit."""
    return UNITS.get(name, (1.0, "SI"))


def _row(point: Point) -> tuple[str, ...]:
    """Return one point as a line of the table."""
    factor, name = unit(point.variable)
    verdict = "BEYOND" if not point.passed else ("within" if point.judged else "")
    return (
        f"{point.variable} [{name}]",
        point.point,
        f"{point.t_full:.1f}",
        f"{point.t_reduced:.1f}",
        f"{factor * point.change_full:+.4g}",
        f"{factor * point.change_reduced:+.4g}",
        "-" if point.percent is None else f"{point.percent:+.2f}",
        verdict,
    )


def render(report: Comparison) -> str:
    """Return the report as text."""
    room = WIDTH - len("  other ")
    lines = [
        "PERCENT CHANGE OF CHANGE (ZC590, ZC691)",
        f"{INDENT}full  {cut(report.full, room)}",
        f"{INDENT}other {cut(report.reduced, room)}",
        f"{INDENT}changes since the start, over {report.until_s:g} s; 100 (full - other)/full",
    ]
    if report.points:
        lines += ["", *table(HEADS, [_row(point) for point in report.points])]
    if report.unchanged:
        names = ", ".join(report.unchanged)
        lines += wrapped(f"too little change in the full run to compare: {names}")
    judged = [point for point in report.points if point.judged]
    beyond = sum(not point.passed for point in judged)
    verdict = f"{beyond} of {len(judged)} beyond {report.allowed_percent:g} %."
    if not beyond:
        verdict = f"All of {len(judged)} within {report.allowed_percent:g} %."
    return "\n".join([*lines, "", verdict])


def panels(report: Comparison, full: Series, reduced: Series) -> tuple[Panel, ...]:
    """Return the changes of both runs over time, extremes marked."""
    found = []
    for name in dict.fromkeys(point.variable for point in report.points):
        factor, unit_name = unit(name)
        curves = []
        for label, run in (("full", full), ("other", reduced)):
            t, change = changes(run, name, report.until_s)
            curves.append(Curve(label, t, factor * change))
        spots = [point for point in report.points if point.variable == name and point.judged]
        times = [time for point in spots for time in (point.t_full, point.t_reduced)]
        heights = [by for point in spots for by in (point.change_full, point.change_reduced)]
        if spots:
            marks = Curve("compared", np.array(times), factor * np.array(heights), points=True)
            curves.append(marks)
        label = f"change of {name} [{unit_name}]"
        found.append(Panel(name, "time from the start [s]", label, tuple(curves)))
    return tuple(found)

"""Weight and balance of a boat's tanks as a page for a terminal, and as a trim polygon."""

import numpy as np

from trainer.study.fillings import Ranges, Report
from trainer.study.page import INDENT, table
from trainer.study.plots import Curve, Panel
from trainer.study.tanks import Range, Weight


def _weight(name: str, part: Weight, fill: str) -> tuple[str, ...]:
    """Return one weight as a line of the table."""
    centre = (f"{place:+.3f}" for place in (part.x, part.y, part.z))
    return (name, fill, f"{1e-3 * part.weight:.1f}", *centre)


def _balance(report: Report) -> list[str]:
    """Return hull, tanks and their sum."""
    heads = ("", "filled", "[kN]", "x [m]", "y [m]", "z [m]")
    now = Weight(report.now.weight, *report.now.centre)
    rows = [
        _weight("hull, tanks empty", report.hull, ""),
        *(_weight(tank.name, tank.contents, f"{tank.fill:.1%}") for tank in report.tanks),
        _weight("together", now, ""),
    ]
    excess = 1e-3 * (report.now.weight - report.buoyancy_N)
    moment = 1e-3 * (report.now.moments[0] - report.x_b_m * report.buoyancy_N)
    x, y, z = (1e-3 * part for part in report.now.moments)
    below = report.now.centre[2] - report.z_b_m
    return [
        "",
        "WEIGHT AND BALANCE (EC430)",
        *table(heads, rows),
        f"{INDENT}moments about the origin: x {x:+.1f}, y {y:+.1f}, z {z:+.1f} kN m",
        f"{INDENT}W - B {excess:+.1f} kN, bow-down moment {moment:+.1f} kN m",
        f"{INDENT}centre of gravity {below:.4f} m below the centre of buoyancy",
    ]


def _span(limits: Range, scale: float, form: str) -> str:
    """Return a range as text."""
    return f"{scale * limits.least:{form}} to {scale * limits.most:{form}}"


def _limits(ranges: Ranges) -> tuple[str, ...]:
    """Return the limits of one group as a line of the table."""
    limits = ranges.limits
    weight = _span(limits.weight, 1e-3, ".1f")
    return (ranges.free, weight, _span(limits.x_g, 1.0, "+.3f"), _span(limits.z_g, 1.0, "+.3f"))


def render(report: Report) -> str:
    """Return the report as text."""
    heads = ("free to be filled", "weight [kN]", "x_G [m]", "z_G [m]")
    rows = [_limits(ranges) for ranges in report.ranges]
    sided = [
        f"{INDENT}{ranges.free}: y_G {_span(ranges.limits.y_g, 1.0, '+.4f')} m"
        for ranges in report.ranges
        if ranges.limits.y_g != (0.0, 0.0)
    ]
    return "\n".join(
        [
            report.vessel,
            *_balance(report),
            "",
            "LIMITS OVER ALL FILLINGS, each by itself",
            *table(heads, rows),
            *sided,
        ]
    )


def panels(report: Report) -> tuple[Panel, ...]:
    """Return the outlines of excess weight and moment, the boat as it is among them."""
    here = (
        1e-3 * (report.now.moments[0] - report.x_b_m * report.buoyancy_N),
        1e-3 * (report.now.weight - report.buoyancy_N),
    )
    found = []
    for ranges in report.ranges:
        corners = 1e-3 * np.array(ranges.outline)
        outline = Curve(ranges.free, corners[:, 1], corners[:, 0])
        now = Curve("as filled", np.array(here[:1]), np.array(here[1:]), points=True)
        x, y = "bow-down moment [kN m]", "W - B [kN]"
        found.append(Panel(f"{report.vessel}: {ranges.free}", x, y, (outline, now)))
    return tuple(found)

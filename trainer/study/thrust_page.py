"""Thrust over speed as a page for a terminal, and as a plot."""

from typing import Final

import numpy as np

from trainer.files.vessel_file import VesselFile
from trainer.study.page import INDENT, table
from trainer.study.plots import Curve, Panel
from trainer.study.thrust import Report, thrust
from trainer.units import KNOT

HEADS: Final = (
    "u\n[kn]",
    "u_c\n[kn]",
    "row",
    "thrust\n[kN]",
    "T/m\n[m/s2]",
    "as flown\n[m/s2]",
)
POINTS: Final = 201  # of a curve


def _breaks(report: Report) -> list[str]:
    """Return where rows change, and how well they join."""
    if not report.breaks:
        return [f"{INDENT}one row of coefficients for every eta = u_c/u"]
    return [
        f"{INDENT}row {i} holds from eta = u_c/u = {one.eta:g} up; there thrust jumps by "
        f"{one.jump:+.3g} rho/2 L^2 u^2"
        for i, one in enumerate(report.breaks, start=1)
    ]


def render(report: Report) -> str:
    """Return the report as text."""
    rows, last = [], None
    for one in report.points:
        first = "" if one.u_kn == last else f"{one.u_kn:.4g}"
        last = one.u_kn
        accelerations = (one.acceleration_m_s2, one.as_flown_m_s2)
        rows.append(
            (
                first,
                f"{one.u_c_kn:+.4g}",
                str(one.row),
                f"{1e-3 * one.thrust_N:+.4g}",
                *(f"{acceleration:+.5f}" for acceleration in accelerations),
            )
        )
    bollard = [
        f"{INDENT}at rest, full {name}: {1e-3 * force:+.4g} kN"
        for name, force in report.bollard_N.items()
    ]
    return "\n".join(
        [
            report.vessel,
            *_breaks(report),
            *bollard,
            "",
            "THRUST LESS DRAG (ZC300; as flown: with the added mass)",
            *table(HEADS, rows),
        ]
    )


def panels(file: VesselFile, report: Report) -> tuple[Panel, ...]:
    """Return thrust over speed, a curve for each command speed."""
    most = max(one.u_kn for one in report.points)
    speeds = np.linspace(0.0, most, POINTS)
    curves = []
    for command in dict.fromkeys(one.u_c_kn for one in report.points):
        forces = [1e-3 * thrust(file, u * KNOT, command * KNOT) for u in speeds]
        curves.append(Curve(f"u_c {command:+.3g} kn", speeds, np.array(forces)))
    title = f"{report.vessel}: thrust less drag"
    return (Panel(title, "speed [kn]", "thrust [kN]", tuple(curves), levels=(0.0,)),)

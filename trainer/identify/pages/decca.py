"""A track by Decca as a page for a terminal and as a plot."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from trainer.identify.record.decca_study import Sailed
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, cut, figure, table
from trainer.units import KNOT

SHOWN: Final = 20  # rows


@dataclass(frozen=True)
class Report:
    """The answer of ``trainer decca``. A missing number is None."""

    source: str
    rows: int
    fixed: int
    smoothed: bool
    t_s: tuple[float, ...]
    east_m: tuple[float | None, ...]
    north_m: tuple[float | None, ...]
    sway_m_s: tuple[float | None, ...]
    ahead_m_s: tuple[float | None, ...]
    colours: tuple[str, ...]


def report_of(sailed: Sailed, *, smooth: bool) -> Report:
    """Return the report of a track."""
    known = {
        name: tuple(None if np.isnan(x) else float(x) for x in values)
        for name, values in {
            "east_m": sailed.east,
            "north_m": sailed.north,
            "sway_m_s": sailed.sway,
            "ahead_m_s": sailed.ahead,
        }.items()
    }
    return Report(
        source=sailed.source,
        rows=len(sailed.t),
        fixed=sailed.fixed,
        smoothed=smooth,
        t_s=tuple(map(float, sailed.t)),
        colours=sailed.colours,
        **known,
    )


def render(report: Report) -> str:
    """Return the report as text: at most SHOWN rows of the track, evenly taken."""
    every = max(1, -(-report.rows // SHOWN))
    rows = [
        (
            f"{report.t_s[i]:g}",
            figure(report.east_m[i], ".1f"),
            figure(report.north_m[i], ".1f"),
            figure(_knots(report.sway_m_s[i]), ".3f"),
            figure(_knots(report.ahead_m_s[i]), ".2f"),
            report.colours[i] or "no fix",
        )
        for i in range(0, report.rows, every)
    ]
    heads = ("t\n[s]", "east\n[m]", "north\n[m]", "sway\n[kn]", "ahead\n[kn]", "by\n")
    how = "smoothed by Spencer's 15 points" if report.smoothed else "not smoothed"
    return "\n".join(
        [
            "DECCA TRACK (DECCON)",
            f"{INDENT}{cut(report.source, 70)}",
            f"{INDENT}{report.fixed} of {report.rows} rows have a fix; {how}",
            "",
            *table(heads, rows),
        ]
    )


def _knots(speed: float | None) -> float | None:
    return None if speed is None else speed / KNOT


def panels(sailed: Sailed) -> tuple[Panel, ...]:
    """Return track and sway velocity."""
    return (
        Panel(
            "track, from the master station",
            "east [m]",
            "north [m]",
            (Curve("fixes", sailed.east, sailed.north),),
        ),
        Panel(
            "sway velocity",
            "time [s]",
            "to starboard [kn]",
            (Curve("sway", sailed.t, sailed.sway / KNOT),),
            levels=(0.0,),
        ),
    )

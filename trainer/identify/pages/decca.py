"""``trainer ship decca``: the track that Decca lanes give, as text and as a plot.

The position is from the master station [m]; velocities are in knots on the page, in m/s in the
data.
"""

import math
from dataclasses import dataclass
from typing import Final

from trainer.identify.record.decca import ShipTrack
from trainer.report.plots import Curve, Panel
from trainer.report.text import INDENT, cut_text, format_number, table
from trainer.units import KNOT

MAX_ROWS_SHOWN: Final = 20  # rows
NUMBER_FORMS: Final = (
    (1.0, ".1f"),
    (1.0, ".1f"),
    (KNOT, ".3f"),
    (KNOT, ".2f"),
)  # of the page's numbers


@dataclass(frozen=True)
class DeccaReport:
    """The answer of ``trainer ship decca``, as printed and as ``--json`` has it.

    NaN, null in JSON, is where lanes or neighbours lack.
    """

    source: str
    rows: int
    fixed: int
    smoothed: bool
    t_s: tuple[float, ...]
    east_m: tuple[float, ...]
    north_m: tuple[float, ...]
    sway_m_s: tuple[float, ...]
    ahead_m_s: tuple[float, ...]
    colours: tuple[str, ...]


def report_of(sailed: ShipTrack, *, smooth: bool) -> DeccaReport:
    """Return the report of a track."""
    columns = (sailed.t, sailed.east, sailed.north, sailed.sway, sailed.ahead)
    t, east, north, sway, ahead = (tuple(one.tolist()) for one in columns)
    known = sailed.source, len(t), sum(map(bool, sailed.colours)), smooth
    return DeccaReport(*known, t, east, north, sway, ahead, sailed.colours)


def render(report: DeccaReport) -> str:
    """Return the report as text: at most MAX_ROWS_SHOWN rows of the track, evenly spaced."""
    numbers = zip(report.east_m, report.north_m, report.sway_m_s, report.ahead_m_s, strict=True)
    rows = [
        (
            f"{t:g}",
            *(
                format_number(None if math.isnan(x) else x / unit, form)
                for x, (unit, form) in zip(row, NUMBER_FORMS, strict=True)
            ),
            colours or "no fix",
        )
        for t, row, colours in zip(report.t_s, numbers, report.colours, strict=True)
    ]
    heads = ("t\n[s]", "east\n[m]", "north\n[m]", "sway\n[kn]", "ahead\n[kn]", "by\n")
    how = "smoothed by Spencer's 15 points" if report.smoothed else "not smoothed"
    return "\n".join(
        [
            "DECCA TRACK (DECCON)",
            f"{INDENT}{cut_text(report.source, 70)}",
            f"{INDENT}{report.fixed} of {report.rows} rows have a fix; {how}",
            "",
            *table(heads, rows[:: max(1, -(-report.rows // MAX_ROWS_SHOWN))]),
        ]
    )


def panels(sailed: ShipTrack) -> tuple[Panel, ...]:
    """Return track and sway velocity."""
    track = (Curve("fixes", sailed.east, sailed.north),)
    sway = (Curve("sway", sailed.t, sailed.sway / KNOT),)
    return (
        Panel("track, from the master station", "east [m]", "north [m]", track),
        Panel("sway velocity", "time [s]", "to starboard [kn]", sway, levels=(0.0,)),
    )

"""The track of a debrief: the way over the ground from above, a turning circle round."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer.analysis.debrief.charts import Beside
from trainer.analysis.debrief.data import DebriefData
from trainer.analysis.report.svg import (
    WIDTH,
    Axis,
    Ground,
    clock,
    rule,
    step_of,
    svg,
    text,
)
from trainer.core.kernel import Numbers

TALL: Final = 420.0  # [px] of the track
SIDE, HEAD, FOOT = 10.0, 26.0, 30.0  # [px] about it
LEAST: Final = 400.0  # [m] across the shorter way
EVERY: Final = (10.0, 30.0, 60.0, 300.0, 600.0, 1800.0)  # [s] between its marks of time
TRACKED: Final = 1600  # points of it
TICKED: Final = 12  # of them at most
SCALE: Final = 0.2  # of the width, the longest rule


def draw_track(debrief: DebriefData, ground: Ground, beside: tuple[Beside, ...] = ()) -> Markup:
    """Return the track from above as an SVG element, north up, equal scales both ways."""
    column = debrief.trajectory.columns
    good = np.isfinite(column["x"]) & np.isfinite(column["y"])
    north, east, seconds = column["x"][good], column["y"][good], ground.seconds[good]
    if not seconds.size:
        return Markup()
    others = [_way_of(run, float(seconds[-1])) for run in beside]
    across, up = _equal_axes(
        np.concatenate([east, *(way[0] for way in others)]),
        np.concatenate([north, *(way[1] for way in others)]),
    )
    x, y = across.places(east), up.places(north)
    parts = [text("title", SIDE, 16.0, "Track [m], north up")]
    for run, way in zip(beside, others, strict=True):
        parts.append(_path(run.style, across.places(way[0]), up.places(way[1])))
    parts.append(_path("actual", x, y))
    for begin, end in ground.spans:
        inside = (seconds >= begin) & (seconds <= end)
        if inside.any():
            parts.append(_path("broken", x[inside], y[inside]))
    step = next((s for s in EVERY if seconds[-1] / s <= TICKED), EVERY[-1])
    for second in np.arange(0.0, float(seconds[-1]) + 1e-9, step):
        place = int(np.searchsorted(seconds, second))
        parts.append(f'<circle class="axis" cx="{x[place]:.1f}" cy="{y[place]:.1f}" r="2.5"/>')
        parts.append(text("tick", x[place] + 6.0, y[place] - 4.0, clock(float(second))))
    return svg("The track from above", (WIDTH, TALL), [*parts, *_rule_of(across)])


def _way_of(run: Beside, end: float) -> tuple[Numbers, Numbers]:
    """Return the way of another run up to a time [s]: east and north [m]."""
    column = run.trajectory.columns
    good = np.isfinite(column["x"]) & np.isfinite(column["y"])
    good &= run.trajectory.seconds <= end + 1e-6
    return column["y"][good], column["x"][good]


def _equal_axes(east: Numbers, north: Numbers) -> tuple[Axis, Axis]:
    """Return axes of one scale about the whole track: a turning circle is round."""
    wide, high = WIDTH - 2.0 * SIDE, TALL - HEAD - FOOT
    metres = 1.12 * max(float(np.ptp(east)) / wide, float(np.ptp(north)) / high)
    metres = max(metres, LEAST / min(wide, high))
    middle_e = 0.5 * (float(east.min()) + float(east.max()))
    middle_n = 0.5 * (float(north.min()) + float(north.max()))
    half_e, half_n = 0.5 * metres * wide, 0.5 * metres * high
    return (
        Axis(middle_e - half_e, middle_e + half_e, SIDE, WIDTH - SIDE),
        Axis(middle_n - half_n, middle_n + half_n, TALL - FOOT, HEAD),
    )


def _path(style: str, x: Numbers, y: Numbers) -> str:
    """Return a line through places [px], about one point in so many as can be told apart."""
    every = max(x.size // TRACKED, 1)
    rows = [*range(0, x.size, every), x.size - 1]
    told = "L".join(f"{x[i]:.1f} {y[i]:.1f}" for i in rows)
    return f'<path class="line {style}" d="M{told}"/>'


def _rule_of(across: Axis) -> Iterator[str]:
    """Yield a rule of a round length, with that length."""
    pixels = (across.end - across.begin) / (across.high - across.low)  # [px/m]
    length = step_of(SCALE * WIDTH / pixels, 1)
    length = length if length * pixels <= 2.0 * SCALE * WIDTH else 0.5 * length
    bottom = TALL - 10.0
    yield rule("axis", SIDE, bottom, SIDE + length * pixels, bottom)
    for end in (SIDE, SIDE + length * pixels):
        yield rule("axis", end, bottom - 4.0, end, bottom + 4.0)
    yield text("tick", SIDE + length * pixels + 8.0, bottom + 4.0, f"{length:g} m")

"""The track of a debrief: the way over the ground, north up, a circle round."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer.analysis.debrief.charts import ACTUAL, runs_beside
from trainer.analysis.debrief.data import DebriefData
from trainer.analysis.debrief.trajectory import Trajectory
from trainer.analysis.report.svg import (
    LEFT,
    RIGHT,
    TOP,
    WIDTH,
    Axis,
    rule,
    step_of,
    svg,
    text,
    ticks,
)
from trainer.core.kernel import Numbers

HEIGHT: Final = 340.0  # [px]
BOTTOM: Final = 24.0
POINTS: Final = 800  # of a line
LEAST: Final = 100.0  # [m] that is shown at least

Way = tuple[str, Numbers, Numbers]  # style, east, north [m]


def draw_track(debrief: DebriefData) -> Markup:
    """Return the way over the ground as an SVG element, both scales the same."""
    end = int(debrief.trajectory.ticks[-1])
    ways = [_way(run.trajectory, run.style, end) for run in runs_beside(debrief)]
    ways.append(_way(debrief.trajectory, ACTUAL, end))
    across, up = _same_scale(ways)
    parts = [text("title", LEFT, 16.0, "Track, north up [m]"), *_grid(across, up)]
    parts += [_draw(way, across, up) for way in ways]
    _, east, north = ways[-1]
    parts.append(text("tick", across.at(east[0]) + 6.0, up.at(north[0]) + 4.0, "start"))
    parts.append(text("tick", across.at(east[-1]) + 6.0, up.at(north[-1]) + 4.0, "end"))
    return svg("Track over the ground", (WIDTH, HEIGHT), parts)


def _way(trajectory: Trajectory, style: str, end: int) -> Way:
    """Return the way of a run up to a tick, in as many points as are drawn."""
    last = trajectory.row(end) + 1
    rows = np.unique(np.linspace(0, last - 1, min(last, POINTS)).astype(int))
    return style, trajectory.columns["y"][rows], trajectory.columns["x"][rows]


def _same_scale(ways: list[Way]) -> tuple[Axis, Axis]:
    """Return the axes east and north, as many metres to a pixel in both."""
    wide, high = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM
    ends = [
        (float(np.min(each)), float(np.max(each)))
        for each in (
            np.concatenate([way[1] for way in ways]),
            np.concatenate([way[2] for way in ways]),
        )
    ]
    (west, east), (south, north) = ends
    scale = 1.08 * max((east - west) / wide, (north - south) / high, LEAST / high)
    x, y = 0.5 * (west + east), 0.5 * (south + north)
    half, tall = 0.5 * scale * wide, 0.5 * scale * high
    return (
        Axis(x - half, x + half, LEFT, WIDTH - RIGHT),
        Axis(y - tall, y + tall, HEIGHT - BOTTOM, TOP),
    )


def _grid(across: Axis, up: Axis) -> Iterator[str]:
    """Yield the lines of both axes, equally far apart, with their labels."""
    step = step_of(up.high - up.low, 6)
    for value in ticks(up.low, up.high, step):
        yield rule("grid", LEFT, up.at(value), WIDTH - RIGHT, up.at(value))
        yield text("tick end", LEFT - 6.0, up.at(value) + 4.0, f"{value + 0.0:g}")
    for value in ticks(across.low, across.high, step):
        x = across.at(value)
        yield rule("grid", x, TOP, x, HEIGHT - BOTTOM)
    coarse = step_of(across.high - across.low, 10)
    for value in ticks(across.low, across.high, coarse):
        yield text("tick middle", across.at(value), HEIGHT - BOTTOM + 16.0, f"{value + 0.0:g}")


def _draw(way: Way, across: Axis, up: Axis) -> str:
    style, east, north = way
    places = zip(across.places(east), up.places(north), strict=True)
    points = "L".join(f"{x:.1f} {y:.1f}" for x, y in places)
    return f'<path class="line {style}" d="M{points}"/>'

"""Panels as SVG, for pages: drawn without any other library."""

import math
from dataclasses import replace
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer.report.plots import TRACK, Curve, Panel
from trainer.report.svg import Axis, rule, step_of, svg, text, ticks, way

WIDTH, HEIGHT = 460.0, 230.0  # [px]
LEFT, RIGHT, TOP, BOTTOM = 52.0, 12.0, 26.0, 40.0
POINTS: Final = 160  # of a curve
STYLES: Final = 7  # classes of curves in the page's style
SHAPES: Final = (  # about the point
    "m-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0",
    "m-3-3h6v6h-6z",
    "m0-3.6l3.4 6.4h-6.8z",
    "m0-4l4 4l-4 4l-4-4z",
    "m-3-3l6 6m0-6l-6 6",
)
ONES: Final = (1, 2, 5)  # labels of a decade


def draw(panel: Panel) -> Markup:
    """Return a panel as an SVG element."""
    if panel.decades:
        logs = (replace(curve, x=np.log10(curve.x)) for curve in panel.curves)
        panel = replace(panel, curves=tuple(logs))
    curves = []
    for curve in panel.curves:
        good = np.isfinite(curve.x) & np.isfinite(curve.y)
        curves.append((curve.x[good], curve.y[good]))
    xs = np.concatenate([x for x, _ in curves])
    ys = np.concatenate([y for _, y in curves])
    if not xs.size:
        return Markup()
    across, up = _axes(panel, xs, ys)
    parts = [text("title", LEFT, 15.0, panel.y), *_grid(panel, across, up)]
    for label, place in panel.marks:
        if across.low <= place <= across.high:
            parts += [
                rule("mark", across.at(place), TOP, across.at(place), HEIGHT - BOTTOM),
                text("tick", across.at(place) + 3.0, TOP + 9.0, label),
            ]
    for i, (curve, (x, y)) in enumerate(zip(panel.curves, curves, strict=True)):
        if curve.points:
            spots = zip(across.places(x), up.places(y), strict=True)
            parts.append("".join(_dot(i, float(a), float(b)) for a, b in spots))
            continue
        line = way(across.places(curve.x), up.places(curve.y), POINTS)
        parts.append(f'<path class="c{i % STYLES}" d="{line}"/>')
    return svg(f"{panel.y} against {panel.x}", (WIDTH, HEIGHT), parts)


def legend(curves: tuple[Curve, ...]) -> Markup:
    """Return what the curves mean, as an HTML paragraph with samples."""
    key = Markup('<span class="key"><svg viewBox="0 0 36 8" aria-hidden="true">{}</svg>{}</span>')
    samples = Markup().join(
        key.format(Markup(sample), curve.label)  # noqa: S704  made here
        for i, curve in enumerate(curves)
        for sample in (
            _dot(i, 18.0, 4.0) if curve.points else f'<path class="c{i % STYLES}" d="M1 4H35"/>',
        )
    )
    return Markup('<p class="legend">{}</p>').format(samples)


def _axes(panel: Panel, xs: np.ndarray, ys: np.ndarray) -> tuple[Axis, Axis]:
    """Return both axes; those of a track have one scale, and depth is downwards."""
    low, high = float(ys.min()), float(ys.max())
    room = max(0.05 * (high - low), 1e-3 * max(abs(low), abs(high)), 1e-6)
    low, high = low - room, high + room
    begin, end = float(xs.min()), float(xs.max())
    end = max(end, begin + 1e-6)
    if panel.title == TRACK:
        scale = max((end - begin) / (WIDTH - LEFT - RIGHT), (high - low) / (HEIGHT - TOP - BOTTOM))
        begin, end = _about(begin, end, scale * (WIDTH - LEFT - RIGHT))
        low, high = _about(low, high, scale * (HEIGHT - TOP - BOTTOM))
    ends = (HEIGHT - BOTTOM, TOP)
    if panel.downwards:
        ends = (TOP, HEIGHT - BOTTOM)
    return Axis(begin, end, LEFT, WIDTH - RIGHT), Axis(low, high, *ends)


def _about(low: float, high: float, span: float) -> tuple[float, float]:
    """Return the stretch of that span about the middle of another."""
    middle = 0.5 * (low + high)
    return middle - 0.5 * span, middle + 0.5 * span


def _grid(panel: Panel, across: Axis, up: Axis) -> list[str]:
    """Return lines and labels of both axes."""
    parts = []
    for value in ticks(up.low, up.high, step_of(up.high - up.low, 5)):
        y = up.at(value)
        parts.append(rule("grid", LEFT, y, WIDTH - RIGHT, y))
        parts.append(text("tick end", LEFT - 5.0, y + 3.5, f"{value + 0.0:.6g}"))
    if panel.decades:  # 1, 2 and 5 of each
        powers = range(math.floor(across.low), math.ceil(across.high) + 1)
        places = [(math.log10(m) + power, f"{m * 10.0**power:g}") for power in powers for m in ONES]
        places = [one for one in places if across.low <= one[0] <= across.high]
    else:
        values = ticks(across.low, across.high, step_of(across.high - across.low, 7))
        places = [(value, f"{value + 0.0:.6g}") for value in values]
    for value, label in places:
        x = across.at(value)
        parts.append(rule("grid", x, TOP, x, HEIGHT - BOTTOM))
        parts.append(text("tick middle", x, HEIGHT - BOTTOM + 14.0, label))
    parts.append(text("tick middle", 0.5 * (LEFT + WIDTH - RIGHT), HEIGHT - 8.0, panel.x))
    inside = [up.at(value) for value in panel.levels if up.low <= value <= up.high]
    return [*parts, *(rule("mark", LEFT, y, WIDTH - RIGHT, y) for y in inside)]


def _dot(place: int, x: float, y: float) -> str:
    """Return a mark, of one of several shapes."""
    shape = SHAPES[place % len(SHAPES)]
    return f'<path class="dot c{place % STYLES}" d="M{x:.1f} {y:.1f}{shape}"/>'

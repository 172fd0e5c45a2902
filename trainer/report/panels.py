"""The panels of a plot as SVG for pages, drawn without any other library.

``plots`` says what a panel is and draws the same by matplotlib, for ``--plot``.
"""

import math
from dataclasses import replace
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer.report.plots import TRACK_TITLE, Curve, Panel
from trainer.report.svg import Axis, line_path, rule, step_of, svg_element, text, ticks

PANEL_WIDTH_PX, PANEL_HEIGHT_PX = 460.0, 230.0  # [px]
LEFT_MARGIN_PX, TOP_MARGIN_PX = 52.0, 26.0
RIGHT_EDGE_PX, BOTTOM_EDGE_PX = PANEL_WIDTH_PX - 12.0, PANEL_HEIGHT_PX - 40.0
INNER_WIDTH_PX, INNER_HEIGHT_PX = RIGHT_EDGE_PX - LEFT_MARGIN_PX, BOTTOM_EDGE_PX - TOP_MARGIN_PX
CURVE_POINTS: Final = 160  # of a curve
CURVE_STYLES: Final = 7  # classes of curves in the page's style
MARKER_SHAPES: Final = (  # about the point
    "m-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0",
    "m-3-3h6v6h-6z",
    "m0-3.6l3.4 6.4h-6.8z",
    "m0-4l4 4l-4 4l-4-4z",
    "m-3-3l6 6m0-6l-6 6",
)
DECADE_LABELS: Final = (1, 2, 5)  # labels of a decade


def draw_panel(panel: Panel) -> Markup:
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
    parts = [text("title", LEFT_MARGIN_PX, 15.0, panel.y), *_grid(panel, across, up)]
    for label, value in panel.marks:
        if across.low <= value <= across.high:
            x = across.at(value)
            parts.append(rule("mark", x, TOP_MARGIN_PX, x, BOTTOM_EDGE_PX))
            parts.append(text("tick", x + 3.0, TOP_MARGIN_PX + 9.0, label))
    for i, (curve, known) in enumerate(zip(panel.curves, curves, strict=True)):
        if curve.points:
            spots = zip(across.pixels(known[0]), up.pixels(known[1]), strict=True)
            parts.append("".join(_dot(i, float(a), float(b)) for a, b in spots))
            continue
        line = line_path(across.pixels(curve.x), up.pixels(curve.y), CURVE_POINTS)
        parts.append(f'<path class="c{i % CURVE_STYLES}" d="{line}"/>')
    return svg_element(f"{panel.y} against {panel.x}", (PANEL_WIDTH_PX, PANEL_HEIGHT_PX), parts)


def legend(curves: tuple[Curve, ...]) -> Markup:
    """Return the legend of the curves, as an HTML paragraph with samples."""
    key = Markup('<span class="key"><svg viewBox="0 0 36 8" aria-hidden="true">{}</svg>{}</span>')
    samples = Markup().join(
        key.format(Markup(sample), curve.label)  # noqa: S704  made here
        for i, curve in enumerate(curves)
        for sample in (
            _dot(i, 18.0, 4.0)
            if curve.points
            else f'<path class="c{i % CURVE_STYLES}" d="M1 4H35"/>',
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
    if panel.title == TRACK_TITLE:
        scale = max((end - begin) / INNER_WIDTH_PX, (high - low) / INNER_HEIGHT_PX)
        begin, end = _about(begin, end, scale * INNER_WIDTH_PX)
        low, high = _about(low, high, scale * INNER_HEIGHT_PX)
    ends = (TOP_MARGIN_PX, BOTTOM_EDGE_PX)
    upright = Axis(low, high, *(ends if panel.downwards else ends[::-1]))
    return Axis(begin, end, LEFT_MARGIN_PX, RIGHT_EDGE_PX), upright


def _about(low: float, high: float, span: float) -> tuple[float, float]:
    """Return the stretch of length ``span`` about the middle of another stretch."""
    middle = 0.5 * (low + high)
    return middle - 0.5 * span, middle + 0.5 * span


def _grid(panel: Panel, across: Axis, up: Axis) -> list[str]:
    """Return lines and labels of both axes."""
    parts = []
    for value in ticks(up.low, up.high, step_of(up.high - up.low, 5)):
        y = up.at(value)
        parts.append(rule("grid", LEFT_MARGIN_PX, y, RIGHT_EDGE_PX, y))
        parts.append(text("tick end", LEFT_MARGIN_PX - 5.0, y + 3.5, f"{value + 0.0:.6g}"))
    if panel.decades:  # 1, 2 and 5 of each
        powers = range(math.floor(across.low), math.ceil(across.high) + 1)
        labels = [(m, power) for power in powers for m in DECADE_LABELS]
        labelled = [(math.log10(m) + power, f"{m * 10.0**power:g}") for m, power in labels]
        labelled = [one for one in labelled if across.low <= one[0] <= across.high]
    else:
        values = ticks(across.low, across.high, step_of(across.high - across.low, 7))
        labelled = [(value, f"{value + 0.0:.6g}") for value in values]
    for value, label in labelled:
        x = across.at(value)
        parts.append(rule("grid", x, TOP_MARGIN_PX, x, BOTTOM_EDGE_PX))
        parts.append(text("tick middle", x, BOTTOM_EDGE_PX + 14.0, label))
    middle = 0.5 * (LEFT_MARGIN_PX + RIGHT_EDGE_PX)
    parts.append(text("tick middle", middle, PANEL_HEIGHT_PX - 8.0, panel.x))
    inside = [up.at(value) for value in panel.levels if up.low <= value <= up.high]
    return parts + [rule("mark", LEFT_MARGIN_PX, y, RIGHT_EDGE_PX, y) for y in inside]


def _dot(number: int, x: float, y: float) -> str:
    """Return a mark, of one of several shapes."""
    shape = MARKER_SHAPES[number % len(MARKER_SHAPES)]
    return f'<path class="dot c{number % CURVE_STYLES}" d="M{x:.1f} {y:.1f}{shape}"/>'

"""Charts of the guide as SVG: the panels of the programs, drawn without any other library."""

import math
from html import escape
from typing import Final

import numpy as np

from trainer.debrief.axes import Axis, step_of, thinned, ticks
from trainer.study.compare_page import unit
from trainer.study.manoeuvres.flight import Flight
from trainer.study.plots import Curve, Panel

WIDTH, HEIGHT = 460.0, 230.0  # [px]
LEFT, RIGHT, TOP, BOTTOM = 52.0, 12.0, 26.0, 40.0
POINTS: Final = 160  # of a curve
STYLES: Final = 7  # classes of curves in the page's style
TRACK: Final = "track"
WORDS: Final = {
    "t": "time",
    "u": "speed ahead",
    "v": "sway",
    "w": "heave",
    "p": "roll rate",
    "q": "pitch rate",
    "r": "yaw rate",
    "x": "run north",
    "y": "run east",
    "z": "depth, change",
    "phi": "roll",
    "theta": "pitch",
    "psi": "heading",
    "delta_r": "rudder",
    "delta_s": "stern planes",
}


def panels(shows: tuple[str, ...], flights: dict[str, Flight]) -> tuple[Panel, ...]:
    """Return the panels of a manoeuvre, a curve for each flight; depth from its start."""
    found = []
    for name in shows:
        if name != TRACK and not all(flight.has(name) for flight in flights.values()):
            continue
        curves = []
        for label, flight in flights.items():
            factor, _ = unit(name)
            if name == TRACK:
                curves.append(Curve(label, flight.column("y"), flight.column("x")))
                continue
            values = flight.change(name) if name == "z" else flight.column(name)
            curves.append(Curve(label, flight.t, factor * values))
        if name == TRACK:
            found.append(Panel("track", "east [m]", "north [m]", tuple(curves)))
        else:
            title = f"{WORDS[name]} [{unit(name)[1]}]"
            found.append(Panel(title, "time [s]", title, tuple(curves)))
    return tuple(found)


def draw(panel: Panel) -> str:
    """Return a panel as an SVG element."""
    curves = [_finite(curve) for curve in panel.curves]
    xs = np.concatenate([x for x, _ in curves])
    ys = np.concatenate([y for _, y in curves])
    if not xs.size:
        return ""
    across, up = _axes(panel, xs, ys)
    parts = [_text("title", LEFT, 15.0, panel.title), *_grid(panel, across, up)]
    for label, place in panel.marks:
        if across.low <= place <= across.high:
            parts += [
                _rule("mark", across.at(place), TOP, across.at(place), HEIGHT - BOTTOM),
                _text("tick", across.at(place) + 3.0, TOP + 9.0, label),
            ]
    parts += [_curve(curve, i % STYLES, across, up) for i, curve in enumerate(panel.curves)]
    label = escape(f"{panel.title} against {panel.x}")
    size = f'viewBox="0 0 {WIDTH:g} {HEIGHT:g}"'
    return f'<svg {size} role="img" aria-label="{label}">{"".join(parts)}</svg>'


def legend(labels: tuple[str, ...]) -> str:
    """Return what the lines mean, as an HTML paragraph with samples."""
    samples = "".join(
        f'<span class="key"><svg viewBox="0 0 36 8" aria-hidden="true">'
        f'<path class="c{i % STYLES}" d="M1 4H35"/></svg>{escape(label)}</span>'
        for i, label in enumerate(labels)
    )
    return f'<p class="legend">{samples}</p>'


def _finite(curve: Curve) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of a curve that are numbers."""
    good = np.isfinite(curve.x) & np.isfinite(curve.y)
    return curve.x[good], curve.y[good]


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
    if panel.title.startswith("depth"):
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
        parts.append(_rule("grid", LEFT, y, WIDTH - RIGHT, y))
        parts.append(_text("tick end", LEFT - 5.0, y + 3.5, f"{value + 0.0:.6g}"))
    for value in ticks(across.low, across.high, step_of(across.high - across.low, 7)):
        x = across.at(value)
        parts.append(_rule("grid", x, TOP, x, HEIGHT - BOTTOM))
        parts.append(_text("tick middle", x, HEIGHT - BOTTOM + 14.0, f"{value + 0.0:.6g}"))
    parts.append(_text("tick middle", 0.5 * (LEFT + WIDTH - RIGHT), HEIGHT - 8.0, panel.x))
    for value in panel.levels:
        if up.low <= value <= up.high:
            parts.append(_rule("mark", LEFT, up.at(value), WIDTH - RIGHT, up.at(value)))
    return parts


def _curve(curve: Curve, style: int, across: Axis, up: Axis) -> str:
    """Return a curve as a path, broken where its points are no numbers."""
    strokes = []
    breaks = np.flatnonzero(~(np.isfinite(curve.x) & np.isfinite(curve.y)))
    for piece in np.split(np.arange(curve.x.size), breaks):
        kept = piece[np.isfinite(curve.x[piece]) & np.isfinite(curve.y[piece])]
        if kept.size > 1:
            x, y = thinned(curve.x[kept], curve.y[kept], POINTS)
            points = zip(across.places(x), up.places(y), strict=True)
            strokes.append("M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in points))
    return f'<path class="c{style}" d="{"".join(strokes)}"/>'


def _rule(style: str, x: float, y: float, x_end: float, y_end: float) -> str:
    """Return a straight line."""
    return f'<path class="{style}" d="M{x:.1f} {y:.1f}L{x_end:.1f} {y_end:.1f}"/>'


def _text(style: str, x: float, y: float, words: str) -> str:
    """Return some words."""
    return f'<text class="{style}" x="{x:.1f}" y="{y:.1f}">{escape(words)}</text>'


def figure(value: float | None, of: str) -> str:
    """Return a number in the page's unit: degrees for radians."""
    if value is None or not math.isfinite(value):
        return "-"
    return f"{math.degrees(value) if of.startswith('rad') else value:.4g}"


def page_unit(of: str) -> str:
    """Return the page's unit of a unit."""
    return of.replace("rad", "deg")

"""The track from above: north up, one scale both ways. A turning circle is round."""

import math
from collections.abc import Sequence
from typing import Final

from trainer.console.drawing.chart import ACROSS, Sheet
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, fit, line

LEAST: Final = 400.0  # [m] across the shorter side
MARGIN: Final = 1.15
NOSE: Final = 5.0  # [dots] of the stroke ahead of the boat
STEPS: Final = (1.0, 2.0, 5.0)
# A character is about twice as high as wide, and has 2 by 4 dots: dots are square.
Point = tuple[float, float]  # [m] north, east


def plan(model: SessionModel, width: int, height: int) -> Lines:
    """Return the track with the boat as an arrow, and a rule of its scale."""
    track = model.track
    heading = fit(line((" track", "heading"), ("  north up", "heading-dim")), width, "heading")
    if height < 4 or not track:
        return [heading][:height]
    sheet = Sheet(width, height - 2)
    middle, metres = frame(track, sheet)
    points = [place(point, middle, metres, sheet) for point in track]
    sheet.stroke(points)
    sheet.stroke(nose(points[-1], model.picture.number("motion", "heading") or 0.0))
    rows = [line((sheet.text(row), "plain")) for row in range(sheet.height)]
    return [heading, *(fit(row, width) for row in rows), fit(rule(metres, width), width)][:height]


def frame(track: Sequence[Point], sheet: Sheet) -> tuple[Point, float]:
    """Return the middle of the view, and the metres of a dot both ways."""
    north, east = [point[0] for point in track], [point[1] for point in track]
    high, wide = max(north) - min(north), max(east) - min(east)
    across, down = max(sheet.across, 1), max(sheet.down, 1)
    metres = max(wide * MARGIN / across, high * MARGIN / down, LEAST / min(across, down))
    return ((max(north) + min(north)) / 2.0, (max(east) + min(east)) / 2.0), metres


def place(point: Point, middle: Point, metres: float, sheet: Sheet) -> tuple[float, float]:
    """Return where a point is drawn [dots], counted from the upper left."""
    x = sheet.across / 2.0 + (point[1] - middle[1]) / metres
    y = sheet.down / 2.0 - (point[0] - middle[0]) / metres
    return x, y


def nose(at: tuple[float, float], heading: float) -> list[tuple[float, float]]:
    """Return the stroke that shows where the boat heads [deg]."""
    angle = math.radians(heading)
    return [at, (at[0] + NOSE * math.sin(angle), at[1] - NOSE * math.cos(angle))]


def rule(metres: float, width: int) -> Line:
    """Return a rule as long as a round distance, and that distance."""
    longest = metres * ACROSS * width / 3.0
    power = 10.0 ** math.floor(math.log10(max(longest, 1.0)))
    length = max(step * power for step in STEPS if step * power <= max(longest, power))
    columns = max(round(length / metres / ACROSS), 1)
    told = f"{length:g} m" if length < 2000.0 else f"{length / 1000.0:g} km"
    return line((f" ├{'─' * max(columns - 2, 0)}┤ {told}", "dim"))

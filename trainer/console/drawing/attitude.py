"""The boat from its side (pitch) and from astern (heel), drawn in Braille dots.

``layouts`` has it on the instructor's screen. A drawing takes the model, and the columns and rows
that there are; it returns lines and changes nothing.
"""

import math
from collections.abc import Sequence
from typing import Final

from trainer.console.drawing.chart import Sheet
from trainer.console.drawing.gauges import interpolate
from trainer.console.drawing.values import angle_text
from trainer.console.model import SessionModel
from trainer.console.pane import Lines, beside, fit, line

Points = Sequence[tuple[float, float]]


# seen from starboard, bow to the right, in parts of half the length; up is positive
HULL_OUTLINE: Final[Points] = (
    *((math.cos(a * math.pi / 12.0) * 0.45 + 0.5, math.sin(a * math.pi / 12.0) * 0.13)
      for a in range(7)),
    (-0.35, 0.13), (-0.95, 0.02), (-0.95, -0.02), (-0.35, -0.13),
    *((math.cos(a * math.pi / 12.0) * 0.45 + 0.5, math.sin(a * math.pi / 12.0) * 0.13)
      for a in range(-6, 1)),
)  # fmt: skip


SAIL_OUTLINE: Final[Points] = ((0.42, 0.13), (0.40, 0.30), (0.16, 0.30), (0.14, 0.13))


UPPER_RUDDER_OUTLINE: Final[Points] = ((-0.70, 0.07), (-0.86, 0.22), (-0.94, 0.22), (-0.90, 0.03))


LOWER_RUDDER_OUTLINE: Final[Points] = tuple((x, -y) for x, y in UPPER_RUDDER_OUTLINE)


# seen from astern, in parts of the radius
HULL_SECTION: Final[Points] = tuple(
    (math.cos(a * math.pi / 12.0), math.sin(a * math.pi / 12.0)) for a in range(25)
)


FIN_OUTLINE: Final[Points] = ((-0.14, 1.0), (-0.14, 1.75), (0.14, 1.75), (0.14, 1.0))


STERN_VIEW_COLUMNS: Final = 12  # [columns] of the view from astern


MIN_SIDE_COLUMNS: Final = 18  # [columns] of the view from the side


ANGLES_COLUMNS: Final = 32  # [columns] with room for both angles


def hull(model: SessionModel, width: int, height: int) -> Lines:
    """Return both views above a line with the angles in words."""
    if height < 3 or width < MIN_SIDE_COLUMNS:
        return [fit(line(), width)] * height
    pitch, heel = interpolate(model, "pitch"), interpolate(model, "heel")
    pitch_line = line((f" pitch {angle_text('pitch', pitch)}", "dim"))
    heel_text = f"heel {angle_text('heel', heel)} "
    right = line((heel_text if width >= ANGLES_COLUMNS else "", "dim"))
    room = height - 1
    astern = STERN_VIEW_COLUMNS if width >= MIN_SIDE_COLUMNS + STERN_VIEW_COLUMNS else 0
    side = side_view(pitch or 0.0, width - astern, room)
    behind = from_astern(heel or 0.0, astern, room)
    lines = [line((side.text(row), "plain"), (behind.text(row), "plain")) for row in range(room)]
    return [*(fit(each, width) for each in lines), beside(pitch_line, right, width)]


def side_view(pitch: float, width: int, height: int) -> Sheet:
    """Return the boat from starboard, the horizon dotted through its middle."""
    sheet = Sheet(width, height)
    middle, half = (sheet.across / 2.0, sheet.down / 2.0), min(sheet.across / 2.0 - 2.0, 40.0)
    for x in range(0, sheet.across, 6):
        sheet.dot(x, middle[1])
    for shape in (HULL_OUTLINE, SAIL_OUTLINE, UPPER_RUDDER_OUTLINE, LOWER_RUDDER_OUTLINE):
        sheet.stroke(turn(shape, math.radians(pitch), half, middle))
    return sheet


def from_astern(heel: float, width: int, height: int) -> Sheet:
    """Return the boat from astern: to starboard is to the right."""
    sheet = Sheet(width, height)
    radius = min(sheet.across, sheet.down) / 3.6
    middle = sheet.across / 2.0, sheet.down * 0.62
    for x in range(0, sheet.across, 6):
        sheet.dot(x, middle[1])
    for shape in (HULL_SECTION, FIN_OUTLINE):
        sheet.stroke(turn(shape, math.radians(-heel), radius, middle))
    return sheet


def turn(shape: Points, angle: float, size: float, middle: tuple[float, float]) -> Points:
    """Return a shape turned anticlockwise by an angle [rad] and moved to its point."""
    c, s = math.cos(angle), math.sin(angle)
    return [
        (middle[0] + size * (x * c - y * s), middle[1] - size * (x * s + y * c)) for x, y in shape
    ]

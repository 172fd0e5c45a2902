"""Strip charts, drawn in dots, and the track from above.

A character of Braille has two by four dots, so that a terminal draws curves four times finer than
its rows. All drawings take the model, columns and rows, and return lines (``pane``).
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import Final

from trainer.console.charts import Quantity
from trainer.console.drawing.aids import interpolated_way, way_ahead
from trainer.console.drawing.crew_orders import in_feet
from trainer.console.drawing.values import NO_VALUE, course, number
from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, Run, beside, fit, length, line
from trainer.console.readings import CIRCULAR_FIELDS
from trainer.units import FOOT

DOTS_ACROSS: Final = 2  # dots in a character
DOTS_DOWN: Final = 4  # [dots] of a Braille character
BRAILLE_BITS: Final = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
EMPTY_BRAILLE: Final = 0x2800  # the character without dots, in Unicode
SCALE_COLUMNS: Final = 6  # [columns] for the numbers at the side
DASH_SIGN: Final = "╌"
GHOST_SIGN: Final = "··"
GHOST_DOTS: Final = 4  # [dots] from one to the next of the ghost's line
AHEAD_DOTS: Final = 2  # the same, of what is to come
TICK_SPACINGS_S: Final = (10.0, 30.0, 60.0, 120.0, 300.0, 600.0)  # [s] between marks of time
MIN_TICK_COLUMNS: Final = 9  # [columns] between marks at least
MIN_AXIS_ROWS: Final = 4  # [rows] of a chart from which on it has an axis of time
SCALE_STEPS: Final = (1.0, 2.0, 5.0)  # of a scale, times a power of ten
MIN_CHART_COLUMNS: Final = 10  # [columns]
MIN_SIDE_M: Final = 400.0  # [m] across the shorter side
RANGE_MARGIN: Final = 1.15  # [-] of the track, so that none of it lies on the edge
NOSE_DOTS: Final = 5.0  # [dots] of the stroke ahead of the boat
# A character is about twice as high as wide, and has 2 by 4 dots: dots are square.
Point = tuple[float, float]  # [m] north, east


@dataclass
class Sheet:
    """Dots on ``width`` by ``height`` characters; those beyond it are not drawn."""

    width: int
    height: int
    cells: list[list[int]] = field(init=False)

    def __post_init__(self) -> None:
        self.cells = [[0] * self.width for _ in range(self.height)]

    @property
    def across(self) -> int:
        """Return the number of dots in a row."""
        return self.width * DOTS_ACROSS

    @property
    def down(self) -> int:
        """Return the number of dots in a column."""
        return self.height * DOTS_DOWN

    def dot(self, x: float, y: float) -> None:
        """Put a dot at a point counted from the upper left."""
        column, row = round(x), round(y)
        if 0 <= column < self.across and 0 <= row < self.down:
            self.cells[row // DOTS_DOWN][column // DOTS_ACROSS] |= BRAILLE_BITS[row % DOTS_DOWN][
                column % DOTS_ACROSS
            ]

    def stroke(self, points: Iterable[tuple[float, float]]) -> None:
        """Draw from each point to the next."""
        before: tuple[float, float] | None = None
        for x, y in points:
            x0, y0 = before or (x, y)
            steps = max(round(abs(x - x0)), round(abs(y - y0)), 1)
            if steps > DOTS_ACROSS * self.width + DOTS_DOWN * self.height:
                steps = 1
            for step in range(steps + 1):
                self.dot(x0 + (x - x0) * step / steps, y0 + (y - y0) * step / steps)
            before = x, y

    def text(self, row: int) -> str:
        """Return a row as characters, a blank where there is no dot."""
        return "".join(chr(EMPTY_BRAILLE + cell) if cell else " " for cell in self.cells[row])


def strip(quantity: int, model: SessionModel, span: float, width: int, height: int) -> Lines:
    """Return the chart of a quantity over the last ``span`` [s], its title above it."""
    drawn = model.quantities[quantity]
    title = headline(drawn, model, span, width)
    columns, rows = width - SCALE_COLUMNS - 1, height - 1
    if rows < 1 or columns < MIN_CHART_COLUMNS:
        return [title][:height]
    way, size = way_ahead(model, drawn.name), unit_of(drawn, model)[1]
    reach = way[-1][0] if way else 0.0
    past = round(columns * span / (span + reach))  # the columns up to now
    series = model.charts.trace.series(quantity, span, past * DOTS_ACROSS)
    actual = [scaled_value(each.actual, size) if each else None for each in series]
    ordered = [scaled_value(each.ordered, size) if each else None for each in series]
    ghost = [scaled_value(each.ghost, size) if each else None for each in series]
    coming: list[float | None] = [
        value / size for value in interpolated_way(way, (columns - past) * DOTS_ACROSS)
    ]
    if drawn.actual[1] in CIRCULAR_FIELDS:
        heading_error = (
            model.picture.number("orders", f"{drawn.crew}_error") if drawn.crew else None
        )
        actual = unwrap(actual)
        ordered = beside_headings(ordered, actual, heading_error)
        ghost = nearest_headings(ghost, actual)
        coming = nearest_headings(coming, actual[-1:] * len(coming))
    low, high = limits([*actual, *ordered, *ghost, *coming], drawn.least)
    axis = [time_axis(span, past, columns - past)] if rows >= MIN_AXIS_ROWS else []
    plot = Plot(low, high, columns, rows - len(axis))
    ahead = [*[None] * len(actual), *coming]
    return [title, *plot.lines(actual, ordered, drawn, ghost, ahead), *axis]


def nearest_headings(
    headings: Sequence[float | None], beside: Sequence[float | None]
) -> list[float | None]:
    """Return headings [deg] counted on so that each lies nearest to another one."""
    return [
        value if value is None or near is None else near + beside_zero(value - near)
        for value, near in zip(headings, beside, strict=True)
    ]


def time_axis(span: float, columns: int, ahead: int = 0) -> Line:
    """Return marks of time below a chart, with what is ahead after the present."""
    step = next(
        (s for s in TICK_SPACINGS_S if s / span * (columns - 1) >= MIN_TICK_COLUMNS),
        TICK_SPACINGS_S[-1],
    )
    signs = ["─"] * columns
    taken = columns - 1  # from there on there is text, or the end
    for k in range(int(span / step) + 1):
        column = columns - 1 - round(k * step / span * (columns - 1))
        signs[column] = "┴"
        text = "now" if k == 0 else ago_text(k * step)
        start = column - len(text) if k == 0 else column + 1
        if start >= 0 and start + len(text) <= taken:
            signs[start : start + len(text)] = text
            taken = min(start, column)
    return line((f"{'':>{SCALE_COLUMNS}}└{''.join(signs)}{'╌' * ahead}", "dim"))


def ago_text(seconds: float) -> str:
    """Return how long ago, such as -30s or -2min."""
    return f"-{seconds:g}s" if seconds < 60.0 or seconds % 60.0 else f"-{seconds / 60.0:g}min"


def headline(drawn: Quantity, model: SessionModel, span: float, width: int) -> Line:
    """Return the name of the chart, its value and what is ordered."""
    says = format_quantity(drawn)
    unit, size = unit_of(drawn, model)
    actual = says(scaled_value(model.picture.number(*drawn.actual), size))
    ordered = says(scaled_value(drawn.order(model.picture.number), size))
    ordered_text = "" if ordered == NO_VALUE else f" {DASH_SIGN}{DASH_SIGN} {ordered}"
    name = drawn.name if width > 34 else drawn.name[:7]
    ghost = says(scaled_value(model.picture.number("ghost", drawn.name), size))
    ghost_text = "" if ghost == NO_VALUE else f" {GHOST_SIGN} {ghost}"
    inks = ("heading", "heading-value", "heading-ordered", "heading-dim")
    name_line = line(*zip((f" {name} ", actual, ordered_text, ghost_text), inks, strict=True))
    right = f"{unit}  {minutes(span)} "
    if length(name_line) + len(right) >= width:
        right = f" {minutes(span)} "
    return beside(name_line, line((right, "heading-dim")), width, "heading")


def unit_of(drawn: Quantity, model: SessionModel) -> tuple[str, float]:
    """Return the unit of a chart and its size. A crew that is ordered feet has a chart in feet."""
    feet = drawn.name == "depth" and in_feet(model) and not model.instructs
    return ("ft", FOOT) if feet else (drawn.unit, 1.0)


def scaled_value(value: float | None, size: float) -> float | None:
    """Return a value in a unit of that size."""
    return None if value is None else value / size


def minutes(span: float) -> str:
    """Return a span of time in words."""
    return f"{span / 60.0:g} min"


def format_quantity(drawn: Quantity) -> Callable[[float | None], str]:
    """Return how values of a quantity are written."""
    if drawn.actual[1] in CIRCULAR_FIELDS:
        return course
    if drawn.signs == ("", ""):
        return number

    def with_side(value: float | None) -> str:
        if value is None:
            return NO_VALUE
        side = "" if abs(value) < 0.05 else drawn.signs[value < 0.0]
        return f"{side}{abs(value):.1f}"

    return with_side


def unwrap(headings: Sequence[float | None]) -> list[float | None]:
    """Return headings [deg] counted on through north, up to the last as it is."""
    unwrapped: list[float | None] = []
    after: float | None = None
    for value in reversed(headings):
        if value is not None and after is not None:
            after += beside_zero(value - after)
        elif value is not None:
            after = value
        unwrapped.append(None if value is None else after)
    return unwrapped[::-1]


def beside_headings(
    ordered: Sequence[float | None], headings: Sequence[float | None], left: float | None
) -> list[float | None]:
    """Return ordered courses [deg] without jumps, as the boat came to them.

    ``left`` is how far it is to the last of them, the way that was ordered; None: the shorter.
    """
    courses: list[float | None] = []
    begin = len(ordered)
    for value, run in groupby(reversed(ordered)):
        first, begin = begin, begin - len(list(run))
        reached = next((h for h in reversed(headings[begin:first]) if h is not None), None)
        drawn = value
        if value is not None and reached is not None:
            to_go = left if first == len(ordered) and left is not None else None
            drawn = reached + (beside_zero(value - reached) if to_go is None else to_go)
        courses += [drawn] * (first - begin)
    return courses[::-1]


def beside_zero(angle: float) -> float:
    """Return an angle [deg] the short way round."""
    return (angle + 180.0) % 360.0 - 180.0


def limits(values: Sequence[float | None], least: float) -> tuple[float, float]:
    """Return the range shown: round numbers about the values, ``least`` apart at least."""
    known = [value for value in values if value is not None] or [0.0]
    low, high = min(known), max(known)
    wide = max(high - low, least) * 1.1
    middle = (low + high) / 2.0
    step = next(
        size * 10.0**power
        for power in range(-3, 11)
        for size in SCALE_STEPS
        if size * 10.0**power * 4.0 >= wide
    )
    bottom = (middle - wide / 2.0) // step * step
    while bottom + 4.0 * step < high + wide / 40.0:
        step *= 2.0
        bottom = (middle - wide / 2.0) // step * step
    return bottom, bottom + 4.0 * step


class Plot:
    """The area of a chart, from ``low`` to ``high`` on so many columns and rows.

    Depth grows downwards, as everywhere at sea.
    """

    def __init__(self, low: float, high: float, columns: int, rows: int) -> None:
        self._low, self._high = low, high
        self._columns, self._rows = columns, rows

    def lines(
        self,
        actual: Sequence[float | None],
        ordered: Sequence[float | None],
        drawn: Quantity,
        ghost: Sequence[float | None] = (),
        ahead: Sequence[float | None] = (),
    ) -> Lines:
        """Return the rows, numbers at the side.

        The ghost and the way ahead are drawn in dots.
        """
        down = drawn.name == "depth"
        sheet = Sheet(self._columns, self._rows)
        self._trace(sheet, actual, down=down)
        layers = [
            (sheet, "plain"),
            (self._dashes(ordered, down=down), "ordered"),
            (self._dots(ahead, AHEAD_DOTS, down=down), "good"),
            (self._dots(ghost, GHOST_DOTS, down=down), "dim"),
        ]
        return [
            (
                *self._scale(row, drawn, down=down),
                *merge(*((layer.text(row), ink) for layer, ink in layers)),
            )
            for row in range(self._rows)
        ]

    def _level(self, value: float, dots: int, *, down: bool) -> float:
        """Return how far down a value lies."""
        share = (value - self._low) / (self._high - self._low)
        return (share if down else 1.0 - share) * (dots - 1)

    def _trace(self, sheet: Sheet, values: Sequence[float | None], *, down: bool) -> None:
        points: list[tuple[float, float]] = []
        for x, value in enumerate(values):
            if value is None:
                sheet.stroke(points)
                points = []
            else:
                points.append((x, self._level(value, sheet.down, down=down)))
        sheet.stroke(points)

    def _dashes(self, values: Sequence[float | None], *, down: bool) -> Sheet:
        """Return the ordered value in dashes, every second column, as high as the actual one."""
        sheet = Sheet(self._columns, self._rows)
        for x, value in enumerate(values):
            if value is not None and x // DOTS_ACROSS % 2 == 0:
                sheet.dot(x, self._level(value, sheet.down, down=down))
        return sheet

    def _dots(self, values: Sequence[float | None], every: int, *, down: bool) -> Sheet:
        """Return values in dots, one every so many."""
        sheet = Sheet(self._columns, self._rows)
        for x, value in enumerate(values):
            if value is not None and x % every == 0:
                sheet.dot(x, self._level(value, sheet.down, down=down))
        return sheet

    def _scale(self, row: int, drawn: Quantity, *, down: bool) -> Line:
        """Return the number at the side of a row: the ends of the range."""
        if row not in (0, self._rows - 1):
            return line((f"{'':>{SCALE_COLUMNS}}┊", "dim"))
        top = self._low if down else self._high
        value = top if row == 0 else self._low + self._high - top
        text = course(value) if drawn.actual[1] in CIRCULAR_FIELDS else f"{value:g}"
        return line((f"{text:>{SCALE_COLUMNS}}┊", "dim"))


def merge(*layers: Run) -> tuple[Run, ...]:
    """Return a row in inks, of each column the first layer that has something."""
    runs: list[Run] = []
    inks = [ink for _, ink in layers]
    for signs in zip(*(row for row, _ in layers), strict=True):
        text, ink = next(
            (each for each in zip(signs, inks, strict=True) if each[0] != " "), (" ", inks[0])
        )
        if runs and runs[-1][1] == ink:
            runs[-1] = runs[-1][0] + text, ink
        else:
            runs.append((text, ink))
    return tuple(runs)


# The track from above: north up, one scale both ways. A turning circle is round.


def plan(model: SessionModel, width: int, height: int) -> Lines:
    """Return the track with the boat as an arrow, and a rule of its scale."""
    track = model.charts.track
    heading = fit(line((" track", "heading"), ("  north up", "heading-dim")), width, "heading")
    if height < 4 or not track:
        return [heading][:height]
    sheet = Sheet(width, height - 2)
    middle, metres = frame(track, sheet)
    points = [dot_at(point, middle, metres, sheet) for point in track]
    sheet.stroke(points)
    sheet.stroke(nose(points[-1], model.picture.number("motion", "heading") or 0.0))
    rows = [line((sheet.text(row), "plain")) for row in range(sheet.height)]
    return [heading, *(fit(row, width) for row in rows), fit(rule(metres, width), width)][:height]


def frame(track: Sequence[Point], sheet: Sheet) -> tuple[Point, float]:
    """Return the middle of the view, and the metres of a dot both ways."""
    north, east = [point[0] for point in track], [point[1] for point in track]
    high, wide = max(north) - min(north), max(east) - min(east)
    across, down = max(sheet.across, 1), max(sheet.down, 1)
    metres = max(
        wide * RANGE_MARGIN / across, high * RANGE_MARGIN / down, MIN_SIDE_M / min(across, down)
    )
    return ((max(north) + min(north)) / 2.0, (max(east) + min(east)) / 2.0), metres


def dot_at(point: Point, middle: Point, metres: float, sheet: Sheet) -> tuple[float, float]:
    """Return where a point is drawn [dots], counted from the upper left."""
    x = sheet.across / 2.0 + (point[1] - middle[1]) / metres
    y = sheet.down / 2.0 - (point[0] - middle[0]) / metres
    return x, y


def nose(at: tuple[float, float], heading: float) -> list[tuple[float, float]]:
    """Return the stroke that shows where the boat heads [deg]."""
    angle = math.radians(heading)
    return [at, (at[0] + NOSE_DOTS * math.sin(angle), at[1] - NOSE_DOTS * math.cos(angle))]


def rule(metres: float, width: int) -> Line:
    """Return a rule as long as a round distance, and that distance."""
    longest = metres * DOTS_ACROSS * width / 3.0
    power = 10.0 ** math.floor(math.log10(max(longest, 1.0)))
    length = max(step * power for step in SCALE_STEPS if step * power <= max(longest, power))
    columns = max(round(length / metres / DOTS_ACROSS), 1)
    length_text = f"{length:g} m" if length < 2000.0 else f"{length / 1000.0:g} km"
    return line((f" ├{'─' * max(columns - 2, 0)}┤ {length_text}", "dim"))

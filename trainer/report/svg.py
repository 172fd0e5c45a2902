"""SVG: axes, lines and text, and charts against time made of them.

Debriefs, estimates and ``panels`` draw with it. Coordinates are in pixels, downwards from the top.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from html import escape
from typing import Final

import numpy as np
from markupsafe import Markup

from trainer.core.kernel import Numbers

ROUND_STEPS: Final = (1.0, 2.0, 2.5, 5.0, 10.0)  # of an axis, times a power of ten
ANGLE_STEPS_DEG: Final = (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0, 180.0, 360.0)  # [deg]
TIME_STEPS_S: Final = (5.0, 10.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1200.0, 3600.0, 7200.0)  # [s]
CHART_WIDTH_PX, CHART_HEIGHT_PX = 960.0, 210.0  # [px]
LEFT_MARGIN_PX, TOP_MARGIN_PX = 86.0, 26.0
RIGHT_EDGE_PX, BOTTOM_EDGE_PX = CHART_WIDTH_PX - 24.0, CHART_HEIGHT_PX - 24.0
LINE_POINTS: Final = 1600  # of a line
LEGEND_SAMPLE_PX: Final = 24.0  # [px] length of a line's sample
LETTER_WIDTH_PX, TITLE_LETTER_PX = 6.6, 7.6  # [px] about as wide as one


@dataclass(frozen=True)
class Axis:
    """A stretch of numbers laid on a stretch of paper."""

    low: float
    high: float
    begin: float  # [px] where low is
    end: float

    def at(self, value: float) -> float:
        """Return where a number lies [px]."""
        return self.begin + (value - self.low) / (self.high - self.low) * (self.end - self.begin)

    def pixels(self, values: Numbers) -> Numbers:
        """Return where numbers lie [px]."""
        share = (values - self.low) / (self.high - self.low)
        return self.begin + share * (self.end - self.begin)


def step_of(span: float, most: int, steps: tuple[float, ...] = ()) -> float:
    """Return a step that goes into ``span`` at most ``most`` times: of ``steps``, or round."""
    for step in steps:
        if span / step <= most:
            return step
    power = 10.0 ** math.floor(math.log10(span / most))
    return next(power * each for each in ROUND_STEPS if span / (power * each) <= most + 1e-9)


def ticks(low: float, high: float, step: float) -> list[float]:
    """Return the multiples of ``step`` from ``low`` to ``high``."""
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    return [step * i for i in range(first, last + 1)]


def clock(seconds: float) -> str:
    """Return a time as minutes and seconds, from an hour on with hours."""
    tenths = round(seconds * 10.0)
    whole, tenth = divmod(tenths, 10)
    minutes, second = divmod(whole, 60)
    rest = f"{second:02d}" + (f".{tenth}" if tenth else "")
    if minutes < 60:
        return f"{minutes}:{rest}"
    return f"{minutes // 60}:{minutes % 60:02d}:{rest}"


def thin_line(x: Numbers, y: Numbers, most: int) -> tuple[Numbers, Numbers]:
    """Return at most about ``most`` points of a line, with the extremes of every stretch."""
    if x.size <= most:
        return x, y
    shortest, longer = divmod(x.size, most // 2)  # `longer` stretches have a point more
    first_short = longer * (shortest + 1)
    kept_rows = [np.array([0, x.size - 1])]
    for begin, end, width in (
        (0, first_short, shortest + 1),
        (first_short, x.size, shortest),
    ):
        stretches = y[begin:end].reshape(-1, width)
        begins = begin + width * np.arange(len(stretches))
        kept_rows += [begins + stretches.argmin(axis=1), begins + stretches.argmax(axis=1)]
    rows = np.flatnonzero(np.bincount(np.concatenate(kept_rows)))
    return x[rows], y[rows]


def line_path(x: Numbers, y: Numbers, most: int) -> str:
    """Return a line through points [px] as a path, broken where one is none."""
    known = np.isfinite(x) & np.isfinite(y)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], known, [False])).astype(int)))
    pieces = []
    for first, after in edges.reshape(-1, 2):
        points = zip(*thin_line(x[first:after], y[first:after], most), strict=True)
        pieces.append("M" + "L".join(f"{a:.1f} {b:.1f}" for a, b in points))
    return "".join(pieces)


@dataclass(frozen=True)
class CurveLine:
    """A curve; ``style`` is its class in the page's style: colour and dashes."""

    label: str
    values: Numbers
    style: str
    seconds: Numbers | None = None  # its own times [s]; None: those of the page


@dataclass(frozen=True)
class Level:
    """A limit, or another number that a chart has a line for."""

    label: str
    value: float


@dataclass(frozen=True)
class Chart:
    """The contents of one pair of axes."""

    name: str  # where links lead
    title: str
    unit: str
    lines: tuple[CurveLine, ...]
    levels: tuple[Level, ...] = ()
    downwards: bool = False  # larger numbers are lower, as depths are
    least: float = 1.0  # span that is shown at least
    steps: tuple[float, ...] = ()  # round steps, if they are not the usual ones
    number: Callable[[float], str] = "{:g}".format  # how a number is written on the axis
    figures: tuple[tuple[float, str], ...] = ()  # words beside moments [s], the earliest first


@dataclass(frozen=True)
class ChartMoment:
    """A moment that all charts of a page show."""

    name: str  # where links lead
    style: str
    seconds: float


@dataclass(frozen=True)
class ChartGround:
    """The common part of all charts of a page."""

    seconds: Numbers
    spans: tuple[tuple[float, float], ...]  # [s] casualties
    marks: tuple[float, ...]  # [s]
    moments: tuple[ChartMoment, ...] = ()
    holes: tuple[tuple[float, float], ...] = ()  # [s] times between which nothing is known

    @property
    def broken_seconds(self) -> Numbers:
        """Return the times [s], NaN where a line begins anew after a hole."""
        begins_anew = np.isin(self.seconds, [after for _, after in self.holes])
        return np.where(begins_anew, np.nan, self.seconds)

    @property
    def across(self) -> Axis:
        """Return the axis of time."""
        begin, end = float(self.seconds[0]), float(self.seconds[-1])
        return Axis(begin, max(end, begin + 1.0), LEFT_MARGIN_PX, RIGHT_EDGE_PX)


def draw_chart(chart: Chart, ground: ChartGround) -> Markup:
    """Return the chart as an SVG element."""
    up = _upright(chart)
    parts = [text("title", LEFT_MARGIN_PX, 16.0, f"{chart.title} [{chart.unit}]")]
    for value in ticks(up.low, up.high, step_of(up.high - up.low, 6, chart.steps)):
        y = up.at(value)
        parts.append(rule("grid", LEFT_MARGIN_PX, y, RIGHT_EDGE_PX, y))
        parts.append(text("tick end", LEFT_MARGIN_PX - 6.0, y + 4.0, chart.number(value + 0.0)))
    parts += backdrop(ground, TOP_MARGIN_PX, BOTTOM_EDGE_PX, chart.name)
    parts += time_axis(ground, BOTTOM_EDGE_PX)
    for level in chart.levels:
        if up.low <= level.value <= up.high:
            y = up.at(level.value)
            parts.append(rule("limit", LEFT_MARGIN_PX, y, RIGHT_EDGE_PX, y))
            parts.append(text("limit-name end", RIGHT_EDGE_PX - 2.0, y - 3.0, level.label))
    for line in chart.lines:
        x = ground.across.pixels(ground.broken_seconds if line.seconds is None else line.seconds)
        drawn = line_path(x, up.pixels(line.values), LINE_POINTS)
        parts.append(f'<path class="line {line.style}" d="{drawn}"/>')
    parts += _figures(chart, ground)
    end = LEFT_MARGIN_PX + TITLE_LETTER_PX * len(f"{chart.title} [{chart.unit}]") + 20.0
    for line in chart.lines:  # a sample of each with its name, after the title
        parts.append(
            f'<path class="line {line.style}" d="M{end:.1f} 12L{end + LEGEND_SAMPLE_PX:.1f} 12"/>'
        )
        end += LEGEND_SAMPLE_PX + 5.0
        parts.append(text("tick", end, 16.0, line.label))
        end += LETTER_WIDTH_PX * len(line.label) + 12.0
    return svg_element(f"{chart.title} against time", (CHART_WIDTH_PX, CHART_HEIGHT_PX), parts)


def _figures(chart: Chart, ground: ChartGround) -> Iterator[str]:
    """Yield the words beside moments, one above the other where they would touch."""
    taken: list[float] = []  # [px] where each row ends, from the bottom
    for seconds, words in chart.figures:
        x, width = ground.across.at(seconds) + 4.0, LETTER_WIDTH_PX * len(words)
        x = min(x, RIGHT_EDGE_PX - width)
        row = next((i for i, end in enumerate(taken) if end < x), len(taken))
        taken[row : row + 1] = [x + width]
        yield text("figure", x, BOTTOM_EDGE_PX - 6.0 - 13.0 * row, words)


def svg_element(label: str, size: tuple[float, float], parts: list[str]) -> Markup:
    """Return an SVG element of a width and a height [px]. Its parts are SVG already."""
    head = Markup('<svg viewBox="0 0 {:g} {:g}" role="img" aria-label="{}">').format(*size, label)
    return Markup("{}{}</svg>").format(head, Markup("".join(parts)))  # noqa: S704  made here


def backdrop(ground: ChartGround, top: float, bottom: float, name: str = "") -> Iterator[str]:
    """Yield the casualties' shades and the marks' lines, in the chart of a name."""
    for begin, end in ground.spans:
        x, width = ground.across.at(begin), ground.across.at(end) - ground.across.at(begin)
        yield rect("spell", x, top, max(width, 1.0), bottom - top)
    for mark in ground.marks:
        yield rule("mark", ground.across.at(mark), top, ground.across.at(mark), bottom)
    for moment in ground.moments:
        x = ground.across.at(moment.seconds)
        where = f' id="{moment.name}-{name}"' if name else ""
        yield f"<g{where}>{rule(moment.style, x, top, x, bottom)}</g>"


def time_axis(ground: ChartGround, bottom: float) -> Iterator[str]:
    """Yield the axis of time with its labels."""
    return scale_axis(ground.across, bottom, 12, TIME_STEPS_S, clock)


def scale_axis(
    across: Axis,
    bottom: float,
    most: int,
    steps: tuple[float, ...] = (),
    label: Callable[[float], str] = "{:g}".format,
) -> Iterator[str]:
    """Yield an axis with labels at ``most`` round numbers or fewer, as ``step_of`` has them."""
    yield rule("axis", across.begin, bottom, across.end, bottom)
    for value in ticks(across.low, across.high, step_of(across.high - across.low, most, steps)):
        x = across.at(value)
        yield rule("axis", x, bottom, x, bottom + 4.0)
        yield text("tick middle", x, bottom + 16.0, label(value + 0.0))


def rect(style: str, x: float, y: float, width: float, height: float) -> str:
    """Return a rectangle."""
    size = f'width="{width:.1f}" height="{height:.1f}"'
    return f'<rect class="{style}" x="{x:.1f}" y="{y:.1f}" {size}/>'


def rule(style: str, x: float, y: float, x_end: float, y_end: float) -> str:
    """Return a straight line."""
    return f'<line class="{style}" x1="{x:.1f}" y1="{y:.1f}" x2="{x_end:.1f}" y2="{y_end:.1f}"/>'


def text(style: str, x: float, y: float, words: str) -> str:
    """Return some words."""
    return f'<text class="{style}" x="{x:.1f}" y="{y:.1f}">{escape(words)}</text>'


def _upright(chart: Chart) -> Axis:
    """Return the axis upwards: room for all lines, and for limits that are not far off."""
    values = np.concatenate([line.values[np.isfinite(line.values)] for line in chart.lines])
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
    room = 0.4 * max(high - low, chart.least)
    near = [each.value for each in chart.levels if low - room <= each.value <= high + room]
    low, high = min([low, *near]), max([high, *near])
    lacking = 0.5 * max(chart.least - (high - low), 0.0)
    margin = 0.06 * max(high - low, chart.least)
    low, high = low - lacking - margin, high + lacking + margin
    ends = (TOP_MARGIN_PX, BOTTOM_EDGE_PX)
    return Axis(low, high, *(ends if chart.downwards else ends[::-1]))

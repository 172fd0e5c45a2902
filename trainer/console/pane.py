"""Panes of the screen, and the lines in inks that are drawn on them.

``app`` and the dialogs are made of them. Every drawing is a function that returns lines. A pane
draws again only what has changed. An ink is a name for two colours. What an ink says, a word or a
sign says too, so that a screen without colour lacks nothing.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Final, NamedTuple

from rich.segment import Segment
from rich.style import Style
from textual import events
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

Run = tuple[str, str]  # text and the name of its ink
Line = tuple[Run, ...]
Lines = list[Line]
NUMBER_PATTERN: Final = re.compile(r"[-+]?[0-9]+(?:[.,:/][0-9]+)*(?:e[-+]?[0-9]+)?")
HIDDEN_SIGN: Final = "#"  # in place of each sign of a number that has no room
GROUND_COLOUR: Final = "#0c1419"
RAISED_COLOUR: Final = "#16222a"
Draw = Callable[[int, int], Lines]  # takes columns and rows
Click = Callable[[int, int], None]  # takes column and row
Wheel = Callable[[int], None]  # takes lines, downwards
NOTCH_LINES: Final = 3  # [lines] of the wheel


class Ink(NamedTuple):
    """A colour on a colour, as #rrggbb."""

    colour: str
    ground: str
    bold: bool = False


INKS: Final[Mapping[str, Ink]] = {
    "plain": Ink("#d7e0e4", GROUND_COLOUR),
    "dim": Ink("#8ea4af", GROUND_COLOUR),
    "title": Ink("#8fd0ff", GROUND_COLOUR, bold=True),
    "value": Ink("#ffffff", GROUND_COLOUR, bold=True),
    "ordered": Ink("#5cc8f2", GROUND_COLOUR),
    "good": Ink("#7fd992", GROUND_COLOUR),
    "warning": Ink("#ffc95c", GROUND_COLOUR, bold=True),
    "alarm": Ink("#0c1419", "#ff8f85", bold=True),
    "heading": Ink("#8fd0ff", RAISED_COLOUR, bold=True),
    "heading-value": Ink("#ffffff", RAISED_COLOUR, bold=True),
    "heading-ordered": Ink("#6fd0f5", RAISED_COLOUR),
    "heading-dim": Ink("#9fb4be", RAISED_COLOUR),
    "heading-warning": Ink("#ffc95c", RAISED_COLOUR, bold=True),
    "bar": Ink("#d7e0e4", RAISED_COLOUR),
    "key": Ink("#ffd479", RAISED_COLOUR, bold=True),
    "bright": Ink("#ffffff", RAISED_COLOUR, bold=True),
    "running": Ink("#8fe3a0", RAISED_COLOUR, bold=True),
    "new": Ink("#0c1419", "#5cc8f2", bold=True),
    "chosen": Ink("#ffffff", "#1f5377", bold=True),
}


def line(*parts: str | Run) -> Line:
    """Return a line of parts; a part without an ink is plain."""
    return tuple((part, "plain") if isinstance(part, str) else part for part in parts)


def length(drawn: Line) -> int:
    """Return how many columns a line takes."""
    return sum(len(text) for text, _ in drawn)


def cut(drawn: Line, width: int) -> Line:
    """Return the line, at most ``width`` columns of it.

    A number that goes on beyond them becomes ``#``: a part of it would read as another number.
    """
    begin = cut_number(drawn, width)
    runs: list[Run] = []
    used = 0
    for text, ink in drawn:
        if used >= width:
            break
        seen = text[: width - used]
        whole = min(max(begin - used, 0), len(seen))
        runs.append((seen[:whole] + HIDDEN_SIGN * (len(seen) - whole), ink))
        used += len(text)
    return tuple(runs)


def cut_number(drawn: Line, width: int) -> int:
    """Return the first column of a number that a cut would split, else the cut's."""
    text = "".join(part for part, _ in drawn)
    through = (each for each in NUMBER_PATTERN.finditer(text) if each.start() < width < each.end())
    return next((each.start() for each in through), width)


def first_fitting(width: int, *choices: Line) -> Line:
    """Return the first line that fits ``width`` columns whole, else the last one."""
    return next((each for each in choices if length(each) <= width), choices[-1])


def fit(drawn: Line, width: int, ink: str = "plain") -> Line:
    """Return the line in exactly ``width`` columns."""
    short = width - length(drawn)
    return (*drawn, (" " * short, ink)) if short > 0 else cut(drawn, width)


def beside(left: Line, right: Line, width: int, ink: str = "plain") -> Line:
    """Return two lines in one of ``width`` columns; the left one gives way."""
    room = max(width - length(right), 0)
    return cut((*fit(left, room, ink), *right), width)


def plain(lines: Iterable[Line]) -> str:
    """Return lines as text alone."""
    return "\n".join("".join(text for text, _ in drawn).rstrip() for drawn in lines)


INK_STYLES: Final = {
    name: Style(color=ink.colour, bgcolor=ink.ground, bold=ink.bold) for name, ink in INKS.items()
}
BARE_STYLE: Final = Style(color=INKS["plain"].colour, bgcolor=GROUND_COLOUR)


class Pane(Widget):
    """A part of the screen that shows what its function draws."""

    DEFAULT_CSS = "Pane { height: 1; width: 1fr; }"
    ALLOW_SELECT = False
    can_focus = False

    def __init__(
        self,
        draw: Draw,
        name: str,
        *,
        moving: bool = False,
        click: Click | None = None,
        wheel: Wheel | None = None,
    ) -> None:
        """Show what ``draw`` returns. A ``moving`` pane changes between ticks too."""
        super().__init__(id=name)
        self.moving = moving
        self._draw = draw
        self._click, self._wheel = click, wheel
        self.lines: Lines = []
        self._drawn_for = self.size

    def look(self) -> None:
        """Draw, and refresh the lines that have changed."""
        width, height = self.size
        if not (width and height and self.display):
            return
        before, lines = self.lines, self._drawn()
        for row in range(max(len(lines), len(before))):
            if lines[row : row + 1] != before[row : row + 1]:
                self.refresh(Region(0, row, width, 1))

    def on_click(self, event: events.Click) -> None:
        """Hand a click on, from the upper left of what is drawn."""
        point = event.get_content_offset(self)
        if self._click and point:
            event.stop()
            self._click(point.x, point.y)

    def on_mouse_scroll_up(self, event: events.MouseScrollUp) -> None:
        """Hand a turn of the wheel on: towards what is above."""
        self._turn(event, -NOTCH_LINES)

    def on_mouse_scroll_down(self, event: events.MouseScrollDown) -> None:
        """Hand a turn of the wheel on: towards what is below."""
        self._turn(event, NOTCH_LINES)

    def _turn(self, event: events.MouseEvent, lines: int) -> None:
        if self._wheel:
            event.stop()
            self._wheel(lines)

    def on_resize(self) -> None:
        """Draw anew for another size, unless ``render_line`` has done so already."""
        if self._drawn_for != self.size:
            self.look()

    def render_line(self, y: int) -> Strip:
        """Return one line as the screen wants it."""
        if self._drawn_for != self.size:
            self._drawn()
        width = self.size.width
        if y >= len(self.lines):
            return Strip.blank(width, BARE_STYLE)
        return Strip(segments(fit(self.lines[y], width)), width)

    def _drawn(self) -> Lines:
        """Draw for the present size; return the lines."""
        self._drawn_for = self.size
        self.lines = self._draw(*self.size)[: self.size.height]
        return self.lines


def segments(drawn: Line) -> list[Segment]:
    """Return a line in the screen's own terms."""
    return [Segment(text, INK_STYLES[ink]) for text, ink in drawn if text]

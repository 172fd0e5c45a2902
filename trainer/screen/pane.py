"""A drawing on the screen: what has not changed since the last look is not drawn again."""

from collections.abc import Callable
from typing import Final

from rich.segment import Segment
from rich.style import Style
from textual.geometry import Region
from textual.strip import Strip
from textual.widget import Widget

from trainer.screen.ink import GROUND, INKS, Line, Lines, fit

Draw = Callable[[int, int], Lines]  # takes columns and rows

STYLES: Final = {
    name: Style(color=ink.colour, bgcolor=ink.ground, bold=ink.bold) for name, ink in INKS.items()
}
BARE: Final = Style(color=INKS["plain"].colour, bgcolor=GROUND)


class Pane(Widget):
    """A function to lines, shown."""

    DEFAULT_CSS = "Pane { height: 1; width: 1fr; }"
    ALLOW_SELECT = False
    can_focus = False

    def __init__(self, draw: Draw, place: str, *, moving: bool = False) -> None:
        """Show what ``draw`` makes; one that is ``moving`` changes between ticks too."""
        super().__init__(id=place)
        self.moving = moving
        self._draw = draw
        self.lines: Lines = []
        self._drawn_for = self.size

    def look(self) -> None:
        """Draw, and have shown what has changed."""
        width, height = self.size
        if not (width and height and self.display):
            return
        before, lines = self.lines, self._drawn()
        for row in range(max(len(lines), len(before))):
            if lines[row : row + 1] != before[row : row + 1]:
                self.refresh(Region(0, row, width, 1))

    def on_resize(self) -> None:
        """Draw anew for another size, unless that was shown before this was told."""
        if self._drawn_for != self.size:
            self.look()

    def render_line(self, y: int) -> Strip:
        """Return one line as the screen wants it."""
        if self._drawn_for != self.size:
            self._drawn()
        width = self.size.width
        if y >= len(self.lines):
            return Strip.blank(width, BARE)
        return Strip(segments(fit(self.lines[y], width)), width)

    def _drawn(self) -> Lines:
        """Draw for the size that there is; return the lines."""
        self._drawn_for = self.size
        self.lines = self._draw(*self.size)[: self.size.height]
        return self.lines


def segments(drawn: Line) -> list[Segment]:
    """Return a line in the screen's own terms."""
    return [Segment(text, STYLES[ink]) for text, ink in drawn if text]

"""A sheet of dots, four by two in a column, that becomes text."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Final

ACROSS: Final = 2  # dots in a character
DOWN: Final = 4
BITS: Final = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
EMPTY: Final = 0x2800


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
        return self.width * ACROSS

    @property
    def down(self) -> int:
        """Return the number of dots in a column."""
        return self.height * DOWN

    def dot(self, x: float, y: float) -> None:
        """Put a dot at a place counted from the upper left."""
        column, row = round(x), round(y)
        if 0 <= column < self.across and 0 <= row < self.down:
            self.cells[row // DOWN][column // ACROSS] |= BITS[row % DOWN][column % ACROSS]

    def stroke(self, points: Iterable[tuple[float, float]]) -> None:
        """Draw from each point to the next."""
        before: tuple[float, float] | None = None
        for x, y in points:
            x0, y0 = before or (x, y)
            steps = max(round(abs(x - x0)), round(abs(y - y0)), 1)
            if steps > ACROSS * self.width + DOWN * self.height:
                steps = 1
            for step in range(steps + 1):
                self.dot(x0 + (x - x0) * step / steps, y0 + (y - y0) * step / steps)
            before = x, y

    def text(self, row: int) -> str:
        """Return a row as characters, a blank where there is no dot."""
        return "".join(chr(EMPTY + cell) if cell else " " for cell in self.cells[row])

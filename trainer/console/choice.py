"""Lists of casualties and seas. Typing narrows a list and adds to the order."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, fit, line


class Row(NamedTuple):
    """An entry to choose: how it is found, its order, its usual ending, a note."""

    name: str
    words: str
    ending: str
    says: str
    active: bool = False


class Done(NamedTuple):
    """How a dialog ends: with these orders, and perhaps with the console."""

    orders: tuple[str, ...] = ()
    leave: bool = False


NOTHING: Final = Done()
NAMES: Final = 26  # [columns]
HEAD: Final = 2  # [rows] above the list
SEAS: Final = (
    (0, "glassy"),
    (1, "0.05 m: rippled"),
    (2, "0.3 m: smooth"),
    (3, "0.9 m: slight"),
    (4, "1.9 m: moderate"),
    (5, "3.3 m: rough"),
    (6, "5.0 m: very rough"),
    (7, "7.5 m: high"),
    (8, "11.5 m: very high"),
)


@dataclass
class Choice:
    """A list, what has been typed above it, and the row that is chosen."""

    title: str
    rows: Sequence[Row]
    advice: tuple[str, ...]
    clears: bool = False  # Delete clears what is chosen
    prefix: str = ""  # of an order that is in no row
    size: tuple[int, int] = (78, 24)  # columns and rows, at most
    typed: str = ""
    moved: int | None = None  # to this row; else the first that is not active
    _first: int = 0  # row at the top, as drawn last
    _rows: int = 0

    @property
    def shown(self) -> list[Row]:
        """Return the rows that what has been typed leaves."""
        typed = self.typed.lower()
        begin, within = [], []
        for row in self.rows:
            name, part = row.name.lower(), matching_prefix(row, typed)
            if name.startswith(part):
                begin.append(row)
            elif part in name:
                within.append(row)
        return begin + within

    @property
    def place(self) -> int:
        """Return the place of the row that is chosen."""
        shown = self.shown
        if self.moved is None:
            return next((i for i, row in enumerate(shown) if not row.active), 0)
        return min(self.moved, max(len(shown) - 1, 0))

    @property
    def chosen(self) -> Row | None:
        """Return the row that is chosen."""
        shown = self.shown
        return shown[self.place] if shown else None

    @property
    def order(self) -> str:
        """Return the order that Enter gives, "" for none."""
        row = self.chosen
        if row is None:
            return f"{self.prefix} {self.typed.strip()}" if self.prefix and self.typed else ""
        rest = self.typed[len(matching_prefix(row, self.typed)) :].strip()
        return f"{row.words} {rest or row.ending}".strip()

    def press(self, key: str, character: str | None) -> Done | None:
        """Take a key; return how the dialog ends, None while it goes on."""
        if key == "escape":
            return NOTHING
        if key == "enter":
            return Done((self.order,)) if self.order else None
        if key == "delete" and self.clears and self.chosen:
            return Done((f"clear {self.chosen.name}",))
        if key == "ctrl+x" and self.clears:
            return Done(("clear all",))
        self._edit(key, character)
        return None

    def click(self, _column: int, row: int, _width: int) -> Done | None:
        """Choose the row of a click. A row that was chosen already is ordered."""
        place = self._first + row - HEAD
        if not (HEAD <= row < HEAD + self._rows and place < len(self.shown)):
            return None
        if place == self.place and self.order:
            return Done((self.order,))
        self.moved = place
        return None

    def _edit(self, key: str, character: str | None) -> None:
        moves = {"up": -1, "down": 1, "pageup": -10, "pagedown": 10}
        last = max(len(self.shown) - 1, 0)
        if key in moves:
            self.moved = min(max(self.place + moves[key], 0), last)
        elif key == "backspace":
            self.typed, self.moved = self.typed[:-1], None
        elif character and character.isprintable():
            self.typed, self.moved = self.typed + character, None

    def draw(self, width: int, height: int) -> Lines:
        """Return the dialog."""
        lines = [
            line((f" {self.title}", "title")),
            line((" > ", "dim"), (self.typed, "value"), ("_", "dim")),
        ]
        foot = [line((f" {self.chosen.says if self.chosen else ''}", "plain"))]
        foot += [line((f" {text}", "dim")) for text in self.advice]
        foot.append(line((" Enter sends: ", "dim"), (self.order or "nothing", "ordered")))
        room = max(height - len(lines) - len(foot), 1)
        shown = self.shown
        place = self.place
        first = min(max(place - room // 2, 0), max(len(shown) - room, 0))
        self._first, self._rows = first, room
        body = [
            row_line(row, chosen=first + i == place, width=width)
            for i, row in enumerate(shown[first : first + room])
        ]
        body += [line()] * (room - len(body))
        return [fit(each, width) for each in (*lines, *body, *foot)][:height]


def matching_prefix(row: Row, typed: str) -> str:
    """Return as much of the typed text as finds this row: words of a name."""
    return " ".join(typed.split(" ")[: row.name.count(" ") + 1])


def row_line(row: Row, *, chosen: bool, width: int) -> Line:
    """Return a row of the list; the chosen one has an arrow."""
    sign = ">" if chosen else " "
    note = "ACTIVE " if row.active else ""
    text = f" {sign} {row.name:<{NAMES}} {note}{row.says}"
    return fit(line((text, "chosen" if chosen else "warning" if row.active else "plain")), width)


def casualty_choice(model: SessionModel) -> Choice:
    """Return the list of what can break."""
    picture = model.picture
    slots = [name for name in picture.rows("casualties", "casualty_") if name[-1].isdigit()]
    active = {picture.word("casualties", name) for name in slots}
    rows = [
        Row(each.name, f"casualty {each.name}", each.degree, each.says, each.name in active)
        for each in model.casualties
    ]
    rows.sort(key=lambda row: not row.active)
    return Choice(
        "Casualties: type to find one, then perhaps a severity and a ramp",
        rows,
        ("such as: stern-hard-over -0.5 ramp 20", "Delete clears the chosen one, Ctrl-X all"),
        clears=True,
    )


def sea_choice(_sight: SessionModel) -> Choice:
    """Return the list of seas."""
    rows = [Row("calm", "sea calm", "", "the sea goes down")]
    rows += [Row(f"state {n}", f"sea state {n}", "", says) for n, says in SEAS]
    rows += [
        Row(f"from {angle:03}", f"sea from {angle:03}", "", "the sea turns, to come from there")
        for angle in range(0, 360, 45)
    ]
    advice = ("or type what is in no row: wind 30, height 3, from 020",)
    return Choice("The sea: it changes within a minute", rows, advice, prefix="sea")

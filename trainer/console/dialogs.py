"""Dialogs over the console: lists to choose from, and questions before what cannot be undone.

``app`` shows one over the screen, and gives the orders with which it ends. A subject (``Choice``,
``Question``) takes keys and draws lines without the library of windows (Textual), so that it can be
tried without a terminal.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar, Final, NamedTuple, Protocol

from textual import events
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.screen import ModalScreen

from trainer.console.model import SessionModel
from trainer.console.pane import Line, Lines, Pane, fit, line

NAME_COLUMNS: Final = 26  # [columns]
HEAD_ROWS: Final = 2  # [rows] above the list
SEA_STATES: Final = (
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
FRAME_ROWS: Final = 2  # [rows]


class ChoiceRow(NamedTuple):
    """An entry to choose: how it is found, its order, its usual ending, a note."""

    name: str
    words: str
    ending: str
    says: str
    active: bool = False


class DialogOutcome(NamedTuple):
    """How a dialog ends: with these orders, and perhaps with the console."""

    orders: tuple[str, ...] = ()
    leave: bool = False


NO_OUTCOME: Final = DialogOutcome()


@dataclass
class Choice:
    """A list, what has been typed above it, and the row that is chosen."""

    title: str
    rows: Sequence[ChoiceRow]
    advice: tuple[str, ...]
    clears: bool = False  # Delete clears what is chosen
    prefix: str = ""  # of an order that is in no row
    size: tuple[int, int] = (78, 24)  # columns and rows, at most
    typed: str = ""
    moved: int | None = None  # to this row; else the first that is not active
    _first: int = 0  # row at the top, as drawn last
    _rows: int = 0

    @property
    def shown(self) -> list[ChoiceRow]:
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
    def index(self) -> int:
        """Return the index of the row that is chosen."""
        shown = self.shown
        if self.moved is None:
            return next((i for i, row in enumerate(shown) if not row.active), 0)
        return min(self.moved, max(len(shown) - 1, 0))

    @property
    def chosen(self) -> ChoiceRow | None:
        """Return the row that is chosen."""
        shown = self.shown
        return shown[self.index] if shown else None

    @property
    def order(self) -> str:
        """Return the order that Enter gives, "" for none.

        What is typed behind the name of the chosen row takes the place of its usual ending.
        """
        row = self.chosen
        if row is None:
            return f"{self.prefix} {self.typed.strip()}" if self.prefix and self.typed else ""
        rest = self.typed[len(matching_prefix(row, self.typed)) :].strip()
        return f"{row.words} {rest or row.ending}".strip()

    def press(self, key: str, character: str | None) -> DialogOutcome | None:
        """Take a key; return how the dialog ends, None while it goes on."""
        if key == "escape":
            return NO_OUTCOME
        if key == "enter":
            return DialogOutcome((self.order,)) if self.order else None
        if key == "delete" and self.clears and self.chosen:
            return DialogOutcome((f"clear {self.chosen.name}",))
        if key == "ctrl+x" and self.clears:
            return DialogOutcome(("clear all",))
        moves = {"up": -1, "down": 1, "pageup": -10, "pagedown": 10}
        last = max(len(self.shown) - 1, 0)
        if key in moves:
            self.moved = min(max(self.index + moves[key], 0), last)
        elif key == "backspace":
            self._type(self.typed[:-1])
        elif character and character.isprintable():
            self._type(self.typed + character)
        return None

    def _type(self, typed: str) -> None:
        """Take what is typed now; a row that was moved to stays chosen while it is shown."""
        kept = None if self.moved is None else self.chosen
        self.typed = typed
        self.moved = self.shown.index(kept) if kept and kept in self.shown else None

    def click(self, _column: int, row: int, _width: int) -> DialogOutcome | None:
        """Choose the row of a click. A row that was chosen already is ordered."""
        index = self._first + row - HEAD_ROWS
        if not (HEAD_ROWS <= row < HEAD_ROWS + self._rows and index < len(self.shown)):
            return None
        if index == self.index and self.order:
            return DialogOutcome((self.order,))
        self.moved = index
        return None

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
        index = self.index
        first = min(max(index - room // 2, 0), max(len(shown) - room, 0))
        self._first, self._rows = first, room
        body = [
            row_line(row, chosen=first + i == index, width=width)
            for i, row in enumerate(shown[first : first + room])
        ]
        body += [line()] * (room - len(body))
        return [fit(each, width) for each in (*lines, *body, *foot)][:height]


def matching_prefix(row: ChoiceRow, typed: str) -> str:
    """Return as much of the typed text as finds this row: words of a name."""
    return " ".join(typed.split(" ")[: row.name.count(" ") + 1])


def row_line(row: ChoiceRow, *, chosen: bool, width: int) -> Line:
    """Return a row of the list; the chosen one has an arrow."""
    sign = ">" if chosen else " "
    note = "ACTIVE " if row.active else ""
    text = f" {sign} {row.name:<{NAME_COLUMNS}} {note}{row.says}"
    return fit(line((text, "chosen" if chosen else "warning" if row.active else "plain")), width)


def casualty_choice(model: SessionModel) -> Choice:
    """Return the list of what can break."""
    picture = model.picture
    slots = [name for name in picture.rows("casualties", "casualty_") if name[-1].isdigit()]
    active = {picture.word("casualties", name) for name in slots}
    rows = [
        ChoiceRow(
            casualty.name,
            f"casualty {casualty.name}",
            casualty.degree,
            casualty.says,
            casualty.name in active,
        )
        for casualty in model.vessel.casualties
    ]
    rows.sort(key=lambda row: not row.active)
    return Choice(
        "Choose what breaks; a severity and a ramp may follow the name",
        rows,
        (
            "such as: stern-hard-over -0.5 ramp 20",
            "Delete repairs the chosen one, Ctrl-X repairs all",
        ),
        clears=True,
    )


def sea_choice(_sight: SessionModel) -> Choice:
    """Return the list of seas."""
    rows = [ChoiceRow("calm", "sea calm", "", "the sea becomes calm")]
    rows += [ChoiceRow(f"state {n}", f"sea state {n}", "", says) for n, says in SEA_STATES]
    rows += [
        ChoiceRow(
            f"from {angle:03}", f"sea from {angle:03}", "", "the sea turns, to come from there"
        )
        for angle in range(0, 360, 45)
    ]
    advice = ("or type something else: wind 30, height 3, from 020",)
    return Choice("Choose a sea: it changes within a minute", rows, advice, prefix="sea")


class DialogSubject(Protocol):
    """The subject of a dialog."""

    @property
    def size(self) -> tuple[int, int]:
        """Return the columns and rows that it wants at most."""

    def press(self, key: str, character: str | None) -> DialogOutcome | None:
        """Take a key; return how the dialog ends, None while it goes on."""

    def click(self, column: int, row: int, width: int) -> DialogOutcome | None:
        """Take a click on a place of the drawing. Return how the dialog ends, None as above."""

    def draw(self, width: int, height: int) -> Lines:
        """Return it as lines."""


class Dialog(ModalScreen[DialogOutcome]):
    """One subject, until a key ends it."""

    BINDINGS: ClassVar[list[BindingType]] = []

    def __init__(self, subject: DialogSubject, past: Callable[[], bool] = lambda: False) -> None:
        """Show a subject until a key ends it, or it is ``past``."""
        super().__init__()
        self.subject = subject
        self._past = past

    def compose(self) -> ComposeResult:
        """Show the subject."""
        pane = Pane(
            self.subject.draw, "dialog", moving=True, click=self._clicked, wheel=self._turned
        )
        self._fit(pane)
        yield pane

    def _fit(self, pane: Pane) -> None:
        columns, rows = self.subject.size
        pane.styles.width, pane.styles.height = columns, rows + FRAME_ROWS

    def leave_if_past(self) -> None:
        """End, if what it is about is over."""
        if self._past() and self.is_current:
            self.dismiss(NO_OUTCOME)

    def on_key(self, event: events.Key) -> None:
        """Hand the key to the subject."""
        event.stop()
        event.prevent_default()
        self._go_on(self.subject.press(event.key, event.character))

    def _clicked(self, column: int, row: int) -> None:
        width = self.query_one(Pane).size.width
        self._go_on(self.subject.click(column, row, width))

    def _turned(self, lines: int) -> None:
        for _ in range(abs(lines)):
            self.subject.press("down" if lines > 0 else "up", None)
        self._go_on(None)

    def _go_on(self, done: DialogOutcome | None) -> None:
        """Show what has changed, or end; keys pressed after the end change nothing."""
        if done is None:
            pane = self.query_one(Pane)
            self._fit(pane)
            pane.look()
        elif self.is_current:
            self.dismiss(done)


@dataclass
class Question:
    """A question, and the answers by their keys."""

    asks: str
    # key: what it does in words, and how the dialog ends
    answers: dict[str, tuple[str, DialogOutcome]]
    size: tuple[int, int] = (60, 7)

    def press(self, key: str, _character: str | None) -> DialogOutcome | None:
        """Take a key; return how the dialog ends, None while it goes on."""
        if key.lower() in ("escape", "n"):
            return NO_OUTCOME
        return self.answers[key.lower()][1] if key.lower() in self.answers else None

    def click(self, _column: int, row: int, _width: int) -> DialogOutcome | None:
        """Take a click on an answer."""
        index = row - 2
        keys = [*self.answers, "escape"]
        return self.press(keys[index], None) if 0 <= index < len(keys) else None

    def draw(self, width: int, height: int) -> Lines:
        """Return the dialog."""
        lines = [line((f" {self.asks}", "title")), line()]
        for key, (says, _) in self.answers.items():
            lines.append(line((f"   {key.upper():<5}", "value"), says))
        lines.append(line(("   Esc  ", "value"), "stay"))
        return [fit(each, width) for each in lines[:height]]


def leave_question(*, own: bool) -> Question:
    """Return the question whether the instructor ends the run or only leaves it."""
    # Twice: where others are attached the session asks once more, as this question has just done.
    end = ("end the run for everybody", DialogOutcome(("quit", "quit")))
    goes = "leave; the run ends if nobody else is attached" if own else "leave; the session goes on"
    return Question("Leave?", {"q": end, "l": (goes, DialogOutcome(leave=True))})


def blow_question() -> Question:
    """Return the question before all main ballast is blown."""
    blow = ("blow all main ballast from both banks", DialogOutcome(("emergency blow",)))
    return Question("Emergency blow?", {"b": blow})  # another key: E may be held, or typed

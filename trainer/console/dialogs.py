"""Dialogs over the console, and questions before what cannot be undone."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Final, Protocol

from textual import events
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.screen import ModalScreen

from trainer.console.choice import NOTHING, Done
from trainer.console.pane import Lines, Pane, fit, line


class Subject(Protocol):
    """The subject of a dialog, and the columns and rows that it wants at most."""

    size: tuple[int, int]

    def press(self, key: str, character: str | None) -> Done | None:
        """Take a key; return how the dialog ends, None while it goes on."""
        ...

    def click(self, column: int, row: int, width: int) -> Done | None:
        """Take a click on a place of the drawing. Return how the dialog ends, None as above."""
        ...

    def draw(self, width: int, height: int) -> Lines:
        """Return it as lines."""
        ...


FRAME: Final = 2  # [rows]


class Dialog(ModalScreen[Done]):
    """One subject, until a key ends it."""

    BINDINGS: ClassVar[list[BindingType]] = []

    def __init__(self, subject: Subject, past: Callable[[], bool] = lambda: False) -> None:
        """Show a subject until a key ends it, or it is ``past``."""
        super().__init__()
        self._subject = subject
        self._past = past

    def compose(self) -> ComposeResult:
        """Show the subject."""
        pane = Pane(
            self._subject.draw, "dialog", moving=True, click=self._clicked, wheel=self._turned
        )
        columns, rows = self._subject.size
        pane.styles.width, pane.styles.height = columns, rows + FRAME
        yield pane

    def leave_if_past(self) -> None:
        """End, if what it is about is over."""
        if self._past() and self.is_current:
            self.dismiss(NOTHING)

    def on_key(self, event: events.Key) -> None:
        """Hand the key to the subject."""
        event.stop()
        event.prevent_default()
        self._go_on(self._subject.press(event.key, event.character))

    def _clicked(self, column: int, row: int) -> None:
        width = self.query_one(Pane).size.width
        self._go_on(self._subject.click(column, row, width))

    def _turned(self, lines: int) -> None:
        for _ in range(abs(lines)):
            self._subject.press("down" if lines > 0 else "up", None)
        self._go_on(None)

    def _go_on(self, done: Done | None) -> None:
        """Show what has changed, or end; keys pressed after the end change nothing."""
        if done is None:
            self.query_one(Pane).look()
        elif self.is_current:
            self.dismiss(done)


@dataclass
class Question:
    """A question, and the answers by their keys."""

    asks: str
    answers: dict[str, tuple[str, Done]]  # key: what it does in words, and how the dialog ends
    size: tuple[int, int] = (60, 7)

    def press(self, key: str, _character: str | None) -> Done | None:
        """Take a key; return how the dialog ends, None while it goes on."""
        if key.lower() in ("escape", "n"):
            return NOTHING
        return self.answers[key.lower()][1] if key.lower() in self.answers else None

    def click(self, _column: int, row: int, _width: int) -> Done | None:
        """Take a click on an answer."""
        place = row - 2
        keys = [*self.answers, "escape"]
        return self.press(keys[place], None) if 0 <= place < len(keys) else None

    def draw(self, width: int, height: int) -> Lines:
        """Return the dialog."""
        lines = [line((f" {self.asks}", "title")), line()]
        for key, (says, _) in self.answers.items():
            lines.append(line((f"   {key.upper():<5}", "value"), says))
        lines.append(line(("   Esc  ", "value"), "neither"))
        return [fit(each, width) for each in lines[:height]]


def leaving(*, own: bool) -> Question:
    """Return the question whether the instructor ends the run or only leaves it."""
    end = ("end the run: its recording is complete", Done(("quit",)))
    goes = "leave; it ends unless others are attached" if own else "leave; the session goes on"
    return Question("Leave?", {"q": end, "l": (goes, Done(leave=True))})


def emergency() -> Question:
    """Return the question before all main ballast is blown."""
    blow = ("blow all main ballast from both banks", Done(("emergency blow",)))
    return Question("Emergency blow?", {"b": blow})  # another key: E may be held, or typed

"""A dialog over the console: drawn, and ended by a key."""

from typing import ClassVar, Final, Protocol

from textual import events
from textual.app import ComposeResult
from textual.binding import BindingType
from textual.screen import ModalScreen

from trainer.screen.choice import Done
from trainer.screen.ink import Lines
from trainer.screen.pane import Pane


class Subject(Protocol):
    """What a dialog is about, and the columns and rows it wants at most."""

    size: tuple[int, int]

    def press(self, key: str, character: str | None) -> Done | None:
        """Take a key; return how the dialog ends, None while it goes on."""
        ...

    def draw(self, width: int, height: int) -> Lines:
        """Return it as lines."""
        ...


FRAME: Final = 2  # [rows]


class Dialog(ModalScreen[Done]):
    """One subject, until a key ends it."""

    BINDINGS: ClassVar[list[BindingType]] = []

    def __init__(self, subject: Subject) -> None:
        super().__init__()
        self._subject = subject

    def compose(self) -> ComposeResult:
        """Show the subject."""
        pane = Pane(self._subject.draw, "dialog", moving=True)
        columns, rows = self._subject.size
        pane.styles.width, pane.styles.height = columns, rows + FRAME
        yield pane

    def on_key(self, event: events.Key) -> None:
        """Hand the key to the subject."""
        event.stop()
        event.prevent_default()
        done = self._subject.press(event.key, event.character)
        if done is None:
            self.query_one(Pane).look()
        else:
            self.dismiss(done)

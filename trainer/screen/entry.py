"""The line at the bottom where orders are typed: completion, history, and keys when it is empty."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from textual import events
from textual.binding import BindingType
from textual.suggester import Suggester
from textual.widgets import Input

from trainer.screen.client import LONGEST_ORDER
from trainer.screen.completion import completed, offer

Known = Mapping[str, Sequence[str]]


class Ghost(Suggester):
    """The rest of the word that is being typed, shown behind it."""

    def __init__(self, known: Known) -> None:
        super().__init__(use_cache=False, case_sensitive=True)
        self._known = known

    async def get_suggestion(self, value: str) -> str | None:
        """Return the line with its last word whole, None where nothing has been begun."""
        begun = "" if not value or value[-1].isspace() else value.rsplit(maxsplit=1)[-1]
        words = offer(value, self._known).words if begun else ()
        return value[: len(value) - len(begun)] + words[0] if words else None


class Entry(Input):
    """One line of order; when it is empty, ``quick`` keys are not letters but keys."""

    BINDINGS: ClassVar[list[BindingType]] = []

    def __init__(self, known: Known, quick: frozenset[str], prompt: str) -> None:
        super().__init__(
            placeholder=prompt,
            suggester=Ghost(known),
            max_length=LONGEST_ORDER,
            compact=True,
            select_on_focus=False,
            id="entry",
        )
        self._known = known
        self._quick = quick
        self._history: list[str] = []
        self._place = 0

    def begin(self, text: str) -> None:
        """Let an order begin so."""
        self.value = text
        self.cursor_position = len(text)
        self.focus()

    def keep(self, words: str) -> None:
        """Keep a line for those that want it again, and clear it."""
        if words and self._history[-1:] != [words]:
            self._history.append(words)
        self._place = len(self._history)
        self.value = ""

    def on_key(self, event: events.Key) -> None:
        """Complete, look back, clear; leave the quick keys to the console."""
        if not self.value and event.key in self._quick:
            event.prevent_default()
            return
        if event.key in ("tab", "up", "down", "escape"):
            if event.key == "escape" and not self.value:
                return
            event.prevent_default()
            event.stop()
            self._edit(event.key)

    def _edit(self, key: str) -> None:
        if key == "escape":
            self.value = ""
        elif key == "tab":
            self.value = completed(self.value, self._known)
            self.cursor_position = len(self.value)
        else:
            self._look(-1 if key == "up" else 1)

    def _look(self, way: int) -> None:
        """Show the order before or after the one shown."""
        self._place = min(max(self._place + way, 0), len(self._history))
        self.value = "" if self._place == len(self._history) else self._history[self._place]
        self.cursor_position = len(self.value)

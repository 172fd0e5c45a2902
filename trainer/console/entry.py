"""The line at the screen's bottom where orders are typed, with completion and history.

What may follow a word comes from the grammar's own table (``io/orders/table``), so that the
completion cannot differ from what the session understands.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import ClassVar, Final, NamedTuple

from textual import events
from textual.binding import BindingType
from textual.suggester import Suggester
from textual.widgets import Input

from trainer.console.client import MAX_ORDER_LETTERS
from trainer.console.model import SessionModel
from trainer.io.orders.grammar import FORM_READINGS, match_slot, tokenise
from trainer.io.orders.quantities import Number
from trainer.io.orders.table import NAME_SLOTS, Name, Slot, UnitWord, Word

KnownNames = Mapping[str, Sequence[str]]
ENTER_KEYS: Final = ("enter", "ctrl+j")  # the second: typed before the terminal was the console's
TYPING_HINT: Final = "type an order, then Enter; Esc goes back to the controls"
CASUALTY_HINT: Final = NAME_SLOTS["NAME"].says
MOMENT_HINT: Final = NAME_SLOTS["LABEL"].says


class Offer(NamedTuple):
    """Whole words that fit, and what else would, in words."""

    words: tuple[str, ...]
    hints: tuple[str, ...]


def offer(text: str, known: Mapping[str, Sequence[str]]) -> Offer:
    """Return what fits after the whole words of ``text``, the last one perhaps begun.

    ``known`` are names by what they are, as the grammar says it: "the name of a casualty".
    """
    begun = "" if not text or text[-1].isspace() else text.rsplit(maxsplit=1)[-1].lower()
    said = tokenise(text[: len(text) - len(begun)])
    words: dict[str, None] = {}
    hints: dict[str, None] = {}
    for slot in following_slots(said):
        for word in fitting_words(slot, begun, known):
            words[word] = None
        if not isinstance(slot, Word | UnitWord) and not begun:
            hints[slot_text(slot)] = None
    return Offer(tuple(words), tuple(hints))


def following_slots(said: Sequence[str]) -> list[Slot]:
    """Return the slots that may follow the words said."""
    next_slots = []
    for reading in FORM_READINGS:
        slots = reading.slots
        if reading.form.refusal or len(slots) <= len(said):
            continue
        if all(any(True for _ in match_slot(slot, word)) for slot, word in zip(slots, said)):  # noqa: B905
            next_slots.append(slots[len(said)])
    return next_slots


def fitting_words(slot: Slot, begun: str, known: Mapping[str, Sequence[str]]) -> list[str]:
    """Return the words of a slot that begin so; of several spellings the first."""
    if isinstance(slot, Word):
        matches = {word: said for said, word in reversed(slot.spellings) if said.startswith(begun)}
        return [said if not word.startswith(begun) else word for word, said in matches.items()]
    if isinstance(slot, Name):
        return [name for name in known.get(slot.says, ()) if name.startswith(begun)]
    return []


def slot_text(slot: Slot) -> str:
    """Return what a slot wants."""
    if isinstance(slot, Number):
        return f"{slot.says} ({slot.limits})"
    return slot.says if isinstance(slot, Name) else "a token"


def complete_word(text: str, known: Mapping[str, Sequence[str]]) -> str:
    """Return ``text`` with its last word completed as far as there is no doubt."""
    words = offer(text, known).words
    begun = "" if not text or text[-1].isspace() else text.rsplit(maxsplit=1)[-1]
    if not words or (not begun and len(words) > 1):
        return text
    shared = words[0]
    for word in words[1:]:
        while not word.startswith(shared):
            shared = shared[:-1]
    ending = " " if len(words) == 1 else ""
    return text[: len(text) - len(begun)] + shared + ending


def hint(text: str, known: Mapping[str, Sequence[str]]) -> str:
    """Return what may come next, in words, or that nothing more can."""
    if len(text) >= MAX_ORDER_LETTERS:
        return f"the line is full: an order has {MAX_ORDER_LETTERS} letters at most"
    offered = offer(text, known)
    return "   ".join((*offered.words, *(f"<{each}>" for each in offered.hints)))


class Ghost(Suggester):
    """The rest of the word that is being typed, shown behind it."""

    def __init__(self, known: KnownNames) -> None:
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

    def __init__(
        self, known: KnownNames, quick: frozenset[str], prompt: str, send: Callable[[str], None]
    ) -> None:
        super().__init__(
            placeholder=prompt,
            suggester=Ghost(known),
            max_length=MAX_ORDER_LETTERS,
            compact=True,
            select_on_focus=False,
            id="entry",
        )
        self._known = known
        self._quick = quick
        self._prompt = prompt
        self._send = send
        self._history: list[str] = []
        self._index = 0
        self.lost = ""  # why letters before the first are missing

    def begin(self, text: str, lost: str = "") -> None:
        """Begin an order with these words, where letters before them may have been lost."""
        self.value, self.lost = text, lost
        self.cursor_position = len(text)
        self.screen.set_focus(self)  # now, not when the keys that follow have been taken

    def on_focus(self) -> None:
        """Say that what is typed is an order now."""
        self.placeholder = TYPING_HINT if not self._quick else self._prompt

    def on_blur(self) -> None:
        """Say again what keys do."""
        self.placeholder = self._prompt

    def _submit(self) -> None:
        """Send the line before any key that follows, and keep it for those that want it again."""
        words = self.value.strip().removeprefix(":").lstrip()  # of who types it as at the controls
        if words and self._history[-1:] != [words]:
            self._history.append(words)
        self._index = len(self._history)
        self.value = self.lost = ""
        self._send(words)

    def on_key(self, event: events.Key) -> None:
        """Complete, look back, clear; leave the quick keys to the console."""
        if not self.value and event.key in self._quick:
            event.prevent_default()
            return
        if event.key in ENTER_KEYS:  # now, and not when it has come to the console as a key
            event.prevent_default()
            event.stop()
            self._submit()
        if event.key in ("tab", "up", "down", "escape"):
            if event.key == "escape" and not self.value:
                return
            event.prevent_default()
            event.stop()
            if event.key == "escape":
                self.value = self.lost = ""
            elif event.key == "tab":
                self.value = complete_word(self.value, self._known)
                self.cursor_position = len(self.value)
            else:
                self._look(-1 if event.key == "up" else 1)

    def _look(self, way: int) -> None:
        """Show the order before or after the one shown."""
        self._index = min(max(self._index + way, 0), len(self._history))
        self.value = "" if self._index == len(self._history) else self._history[self._index]
        self.cursor_position = len(self.value)


class OrderNames(Mapping[str, Sequence[str]]):
    """The names that an order may hold at this moment."""

    def __init__(self, model: SessionModel) -> None:
        self._sight = model

    def __getitem__(self, says: str) -> Sequence[str]:
        if says == CASUALTY_HINT:
            return [each.name for each in self._sight.vessel.casualties]
        if says == MOMENT_HINT:
            return [kept.text for kept in self._sight.timeline.snapshots]
        raise KeyError(says)

    def __iter__(self) -> Iterator[str]:
        return iter((CASUALTY_HINT, MOMENT_HINT))

    def __len__(self) -> int:
        return 2
